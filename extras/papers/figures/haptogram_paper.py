# SPDX-License-Identifier: Apache-2.0
"""Figures of the paper Haptogram."""

import json

import matplotlib.pyplot as plt
import numpy as np
import plot_field

from .work import RADIATION, SOURCE, crossings, first, legend, of, panels, row, save, width


def haptogram_6(work, name):
    """Pins of the Verilated board while it plays a point."""
    played = work.played("point-130", "--shape", "point", "--center", "0,0,130", "--rate", 1000)
    manifest = json.loads(played[0].read_text(encoding="utf-8"))
    pulses = np.loadtxt(played[1], delimiter=",", skiprows=1)
    clock_us = 1e6 / manifest["board"]["clock_hz"]
    channels = range(44, 50)
    elements = np.array(manifest["array"]["elements_mm"])
    start = pulses[pulses[:, 0] == 44][1, 1]
    figure, (panel,) = panels(1, (8.5, 4.2))
    delays, wanted = [], []
    flight_us = np.hypot(130.0, np.hypot(elements[:, 0], elements[:, 1])) / manifest["medium"]["speed_m_s"] * 1e3
    for place, channel in enumerate(channels):
        rises, falls = ((pulses[pulses[:, 0] == channel][:, i] - start) * clock_us for i in (1, 2))
        times, levels = [-50.0], [0.0]
        for rise, fall in zip(rises, falls):
            if fall > -10.0 and rise < 90.0:
                times += [rise, rise, fall, fall]
                levels += [0.0, 1.0, 1.0, 0.0]
        panel.plot(times + [150.0], np.array(levels + [0.0]) * 0.7 + 5 - place, lw=1.2, color="#174a7c")
        delays.append(rises[rises >= -12.5][0])
        wanted.append(flight_us[44] - flight_us[channel])
    off = (np.array(delays) - np.array(wanted) + 12.5) % 25.0 - 12.5
    panel.set(xlabel="time / µs", xlim=(-10, 90), yticks=[5 - i + 0.35 for i in range(6)],
              yticklabels=[f"x = {elements[c, 0]:.0f} mm" for c in channels], ylabel="element of the row y = −5 mm",
              title="Pins of the Verilated board, focus at (0, 0, 130) mm")  # fmt: skip
    panel.grid(axis="x", alpha=0.3)
    save(work, figure, name)
    one = pulses[pulses[:, 0] == 44]
    return [
        row("carrier", 1e3 / np.diff(one[:, 1] * clock_us).mean(), "kHz", 40.0, "text"),
        row("pulse width", (one[:, 2] - one[:, 1]).mean() * clock_us, "µs"),
        row("shift of the outermost element shown against the innermost, within a period", (delays[-1] - delays[0]) % 25.0, "µs",
            why="the paper's figure shows a shift between successive transducers; its text gives no number"),
        row("largest distance of a pulse from the focal law, recomputed in double precision", np.abs(off - off.mean()).max(), "µs",
            why="timings are rounded to ticks of 0.1 µs"),
        row("pulses equal to the image, of all", played[2]["pulses_equal_to_image"] / played[2]["pulses"]),
    ]  # fmt: skip


def haptogram_11(work, name):
    found = work.computed["formation"]
    at = found["at_150_mm"]
    envelope, wave = np.array(at["envelope_pa"]), np.array(at["pressure_pa"])
    t = np.arange(len(envelope)) * at["step_us"]
    # The paper's receiver, if it is a resonant transducer, too: the same low-pass of the envelope once more.
    keep = np.exp(-at["step_us"] / found["time_constant_us"])
    heard = np.zeros_like(envelope)
    for i in range(1, len(envelope)):
        heard[i] = heard[i - 1] * keep + envelope[i] * (1.0 - keep)
    by = {int(f["elevation_mm"]): f for f in found["foci"]}
    begin, full = by[150]["second_order"]["first_arrival_us"], envelope.max()
    through_receiver = first(t, heard, 0.9 * full) - begin
    half = at["step_us"] * 20
    inner = (t > half) & (t < t[-1] - half)
    figure, (panel,) = panels(1, (8.5, 4.6))
    panel.plot(t[inner] - begin, wave[inner] / full, lw=0.4, color="#9ab8d6", label="pressure at the focus")
    panel.plot(t[inner] - begin, envelope[inner] / full, color="#174a7c", label="its envelope")
    panel.plot(t[inner] - begin, heard[inner] / full, color="#c0392b", label="through a receiver of the same bandwidth")
    panel.axhline(0.9, color="#666666", lw=0.8, ls=":")
    panel.axvline(640.0, color="#c0392b", lw=0.8, ls="--", label="paper, measured: 640 µs to 90 %")
    panel.set(xlabel="time after the first arrival at the focus / µs", ylabel="over the steady amplitude", xlim=(-150, 1500), ylim=(-1.1, 1.1),
              title="A focus at 15 cm forms: resonators of 2 kHz, all started in one period")  # fmt: skip
    panel.grid(alpha=0.3)
    legend(panel, loc="lower right")
    save(work, figure, name)
    ten, fifteen = by[100], by[150]
    return [
        row("flight-time spread ΔT, focus 10 cm above the centre (eq. 4)", ten["second_order"]["flight_spread_us"], "µs", 643.0, "theory",
            "the paper's 643 µs does not follow from its eq. 4 and a tile of 10 × 10 elements, 10 mm apart; ours at 20 °C"),
        row("β, the same focus (eq. 11)", ten["beta"], "", 26, "theory", "follows from ΔT"),
        row("to 90 % of the pressure at 15 cm, in the air", fifteen["second_order"]["formation_90_us"], "µs", 640.0, "measured",
            "from the first arrival; the paper's number has its receiver's ring-up in it, too, if that is as resonant as its later probe, an MA40S4R: next row"),
        row("the same as a receiver of the same 2 kHz bandwidth hears it", through_receiver, "µs", 640.0, "measured",
            "an assumption, not a fit: the paper names neither the receiver of Fig. 11 nor any bandwidth; here it has the transmitter's"),
        row("  of it flight-time spread", fifteen["second_order"]["flight_spread_us"], "µs"),
        row("  of it ring-up of one transmitter to 90 %", fifteen["second_order"]["ring_up_90_us"], "µs"),
        row("to 90 % at 10 cm, in the air", ten["second_order"]["formation_90_us"], "µs"),
        row("to 90 % at 15 cm with the Butterworth–Van Dyke circuit instead", fifteen["butterworth_van_dyke"]["formation_90_us"], "µs"),
        row("flight to 15 cm, before the first arrival", begin, "µs",
            why="not counted above; the paper does not say where its time begins"),
    ]  # fmt: skip


def switching(work, name):
    found = work.computed["alternation"]
    dwell = np.array([f["dwell_us"] for f in found])
    figure, (panel,) = panels(1, (8.5, 4.2))
    panel.semilogx(dwell, [100 * f["peak"] for f in found], "o-", label="largest pressure amplitude")
    panel.semilogx(dwell, [100 * f["power"] for f in found], "s-", label="mean square (half the time: 50 %)")
    panel.axhline(50, color="#666666", lw=0.8, ls=":")
    ticks = [25, 50, 100, 200, 400, 1000, 2000]
    panel.set(xlabel="dwell at each point / µs", ylabel="of the point played alone / %", ylim=(0, 105),
              title="Alternating between two points 50 mm apart at 13 cm")  # fmt: skip
    panel.set_xticks(ticks, [str(x) for x in ticks])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    legend(panel, loc="upper left")
    save(work, figure, name)
    rows = []
    for f in found:
        if round(f["dwell_us"]) in (25, 100, 650, 1000):
            near = "26 whole periods, the nearest to 640 µs, at which the paper's probe showed 90 %; ours is in the air" if round(f["dwell_us"]) == 650 else ""
            paper = (90.0, "measured") if near else (None, "")
            rows.append(row(f"largest amplitude at a dwell of {f['dwell_us']:.0f} µs", 100 * f["peak"], "%", *paper, near))
            rows.append(row(f"mean square at a dwell of {f['dwell_us']:.0f} µs", 100 * f["power"], "%"))
    return rows


def haptogram_13(work, name):
    played = work.played("point-130", "--shape", "point", "--center", "0,0,130", "--rate", 1000)
    pins = work.plane("xy@z=130", *of(played), "--extent", 25, "--step", 0.5)
    ideal = work.plane("xy@z=130", "--focus", "0,0,130", "--extent", 25, "--step", 0.5)
    widths = {}
    figure, axes = panels(2, (11.5, 4.7))
    plot_field.plane(figure, axes[0], *pins)
    axes[0].set_title("from the pins' pulses, z = 130 mm")
    for label, source, style in (
        ("piston, a = 4.5 mm", ("--focus", "0,0,130"), "-"),
        ("point source", ("--focus", "0,0,130", "--array", work.points_array), "--"),
        ("piston, from the pins", of(played), ":"),
    ):
        x, y = work.line("x@y=0,z=130", *source, "--extent", 25, "--step", 0.1)
        widths[label] = width(x, y)
        axes[1].plot(x, y / y.max(), style, label=f"{label}: {widths[label]:.2f} mm")
    axes[1].set(xlabel="x / mm", ylabel="radiation pressure over its peak", title="cut through the focus, full width at half maximum")
    axes[1].grid(alpha=0.3)
    legend(axes[1], loc="upper right")
    save(work, figure, name)
    (x, rms) = work.line("x@y=0,z=130", *of(played), "--extent", 25, "--step", 0.1, "--quantity", "rms")
    amplitude = rms.max() * np.sqrt(2.0)
    return [
        row("width of the radiation pressure at half maximum, piston", widths["piston, a = 4.5 mm"], "mm", 10.0, "measured", "the paper says about 10 mm, and not at what level"),
        row("the same, point sources", widths["point source"], "mm", 10.0, "measured"),
        row("the same, from the pins", widths["piston, from the pins"], "mm", 10.0, "measured"),
        row("sound pressure at the focus, amplitude", amplitude / 1e3, "kPa", 2.95, "measured", SOURCE),
        row("source strength at which this model would give the paper's", 4.0 * 2950.0 / amplitude, "Pa·m", why="for information; nothing here uses it"),
        row("radiation pressure there", pins[0].max(), "Pa", why="the paper's kPa can hardly be this; its text says acoustic pressure"),
        row("largest difference between pins and exact phases, over the peak", np.abs(pins[0] - ideal[0]).max() / ideal[0].max()),
    ]


def haptogram_15(work, name):
    found = work.computed["elevations"]
    z = np.array(found["z_mm"])
    far = z >= found["far_field_mm"]
    curves = {
        "piston, a = 4.5 mm (eq. 9)": np.array(found["piston_pa"]),
        "the same, as a receiver of that directivity hears it": np.array(found["heard_pa"]),
        "T4010A1's measured directivity": np.array(found["t4010a1_pattern_pa"]),
        "point source (eq. 8), rising on towards the array": np.array(found["point_pa"]),
    }
    figure, (panel,) = panels(1, (8.5, 4.6))
    for label, curve in curves.items():
        (drawn,) = panel.plot(z[far] / 10, curve[far] / 1e3, label=label)
        panel.plot(z[~far] / 10, curve[~far] / 1e3, ls=":", color=drawn.get_color())
    panel.plot([14], [2.9], "x", ms=9, mew=2, color="black", label="paper's peak, measured: 2.9 kPa at 14 cm")
    panel.axvspan(0, found["far_field_mm"] / 10, color="#dddddd", alpha=0.6, lw=0, label="nearer than eq. 9 holds (eq. 10)")
    panel.set(xlabel="elevation of the focus / cm", ylabel="sound pressure amplitude at the focus / kPa", xlim=(0, 20), ylim=(0, 8.5),
              title="Pressure of a focus above the centre, one tile")  # fmt: skip
    panel.grid(alpha=0.3)
    legend(panel, loc="upper right")
    save(work, figure, name)

    def peak(curve):
        return z[far][np.argmax(curve[far])] / 10

    piston, heard, pattern, _ = curves.values()
    at_14 = int(np.argmin(abs(z - 140)))
    why = (
        "the model has no loss that grows towards the array: its directivity alone sets the peak. The paper explains "
        "14 cm by limited directivity below it; no directivity tried here takes so much away"
    )
    return [
        row("elevation of the largest pressure, piston", peak(piston), "cm", 14.0, "measured", why),
        row("the same, heard by a receiver of the same directivity", peak(heard), "cm", 14.0, "measured", "the probe was such a transducer; this explains a part"),
        row("the same, with a measured directivity (T4010A1's)", peak(pattern), "cm", 14.0, "measured"),
        row("pressure at 14 cm, piston", piston[at_14] / 1e3, "kPa", 2.9, "measured", SOURCE),
        row("pressure at its peak, piston", piston[far].max() / 1e3, "kPa", 2.9, "measured", SOURCE),
    ]


def pass_rows(played, points, rate):
    report = played[2]
    manifest = json.loads(played[0].read_text(encoding="utf-8"))
    cycle_s = report["timer"]["prescaler"] * report["timer"]["cycle_ticks"] / manifest["board"]["clock_hz"]
    lasted = sum(r["cycles"] for r in report["records"]) * cycle_s
    pressures = np.array([r["pressure_pa"] for r in report["records"]]) / 1e3
    return pressures, [
        row("focal points", len(played[3]), "", points, "text"),
        row("rendering rate, of the pass played on the board", 1.0 / lasted, "Hz", rate, "text"),
        row("pulses equal to the image, of all", report["pulses_equal_to_image"] / report["pulses"]),
        row("largest distance of a peak from its point", report["worst_focus_error_mm"], "mm"),
    ]


def cloud(panel, foci, title):
    panel.plot(foci[:, 0], foci[:, 1], ".", ms=3, color="#174a7c")
    panel.set(xlabel="x / mm", ylabel="y / mm", xlim=(-75, 75), ylim=(-75, 75), aspect="equal", title=title)
    panel.grid(alpha=0.3)


def haptogram_16(work, name):
    played = work.played("line-120", "--shape", "line", "--length", 100, "--center", "0,0,120", "--rotate", "0,0,90", "--points", 200, "--rate", 10)
    foci = played[3]
    field = work.plane("xy@z=120", *of(played), "--extent", 75, "--step", 1)
    y, along = work.line("y@x=0,z=120", *of(played), "--extent", 75, "--step", 0.25)
    x, across = work.line("x@y=0,z=120", *of(played), "--extent", 75, "--step", 0.25)
    figure, axes = panels(3, (14.5, 4.4))
    cloud(axes[0], foci, "200 focal points at z = 120 mm")
    plot_field.plane(figure, axes[1], *field)
    axes[1].set_title("mean over one pass, from the pins' pulses")
    axes[2].plot(y, along, label="along y, x = 0")
    axes[2].plot(x, across, label="along x, y = 0")
    axes[2].set(xlabel="y or x / mm", ylabel=RADIATION, title="cuts")
    axes[2].grid(alpha=0.3)
    legend(axes[2])
    save(work, figure, name)
    pressures, rows = pass_rows(played, 200, 10)
    middle = int(np.argmin(abs(y)))
    low, high = crossings(y, along, 0.5 * along[middle], middle)
    return [
        row("length of the line of focal points", np.ptp(foci[:, 1]), "mm", 100.0, "text", "Fig. 17, measured: spread along 100 mm"),
        row("length of the field at half its middle's radiation pressure", high - low, "mm", 100.0, "measured"),
        row("width of the field at half maximum", width(x, across), "mm"),
        row("highest radiation pressure more than 20 mm beyond the ends, over the middle's", along[abs(y) > 70].max() / along[middle],
            why="a grating lobe: the elements are more than a wavelength apart; beyond what the paper scanned"),
        row("sound pressure at each point while it plays, mean", pressures.mean(), "kPa", 2.9, "measured", "the paper's is the largest it measured; " + SOURCE),
        row("the same, largest", pressures.max(), "kPa", 2.9, "measured", SOURCE),
        *rows,
    ]  # fmt: skip


def ring_of(field):
    """Mean over the angle of the radial profile: (radii, profile)."""
    values, about = field
    x, y = np.meshgrid(about["x_mm"], about["y_mm"])
    radius = np.hypot(x, y)
    bins = np.arange(0, 72, 1.0)
    profile = np.array([values[(radius >= r - 0.75) & (radius < r + 0.75)].mean() for r in bins])
    return bins, profile


def haptogram_18(work, name):
    found = {}
    for diameter in (100, 70):
        arguments = ("--shape", "circle", "--diameter", diameter, "--center", "0,0,120", "--points", 200, "--rate", 10)
        played = work.played(f"circle-{diameter}-120", *arguments)
        found[diameter] = played, work.plane("xy@z=120", *of(played), "--extent", 75, "--step", 1)
    figure, axes = panels(3, (14.5, 4.4))
    cloud(axes[0], found[100][0][3], "200 focal points at z = 120 mm, 100 mm wide")
    rows, rings = [], {}
    for axis, (diameter, (played, field)) in zip(axes[1:], found.items()):
        plot_field.plane(figure, axis, *field)
        axis.set_title(f"{diameter} mm circle, mean over one pass, from the pins")
        radii, profile = ring_of(field)
        fine = np.linspace(0, 71, 7101)
        rings[diameter] = 2 * fine[np.argmax(np.interp(fine, radii, profile))]
    save(work, figure, name)
    pressures, rows = pass_rows(found[100][0], 200, 10)
    return [
        row("diameter of the ring of radiation pressure, 100 mm asked", rings[100], "mm", 70.0, "measured",
            "the text does not give the size of Fig. 18's circle; Fig. 19 shows about 70 mm, people were shown shapes of 100 mm"),
        row("the same, 70 mm asked", rings[70], "mm", 70.0, "measured", "radii are binned to 1 mm"),
        row("sound pressure at each point while it plays, 100 mm, mean", pressures.mean(), "kPa", 2.9, "measured", "the paper's is the largest it measured; " + SOURCE),
        row("radiation pressure of the ring over that of its centre, 100 mm", ring_of(found[100][1])[1].max() / max(ring_of(found[100][1])[1][0], 1e-9)),
        *rows,
    ]  # fmt: skip


def haptogram_20(work, name):
    # The bounding box of the upper half of a sphere about (0, 0, 140) mm has its centre 25 mm higher.
    played = work.played("hemisphere-140", "--shape", "hemisphere", "--diameter", 100, "--center", "0,0,165", "--points", 200, "--rate", 7)
    foci = played[3]
    side = work.plane("xz@y=0", *of(played), "--x", "-75:75", "--z", "90:230", "--step", 1)
    slice_ = work.plane("xy@z=160", *of(played), "--extent", 75, "--step", 1)
    highest = work.highest("xz@y=0", played, "--x", "-75:75", "--z", "90:230", "--step", 2)
    figure = plt.figure(figsize=(11.5, 9.4), constrained_layout=True)
    solid = figure.add_subplot(2, 2, 1, projection="3d")
    solid.scatter(foci[:, 0], foci[:, 1], foci[:, 2], c=foci[:, 2], cmap="viridis", s=9)
    solid.set(xlabel="x / mm", ylabel="y / mm", zlabel="z / mm", title="200 focal points")
    solid.set_box_aspect((2, 2, 1), zoom=0.85)
    solid.locator_params(nbins=5)
    titles = "y = 0, mean over one pass, from the pins", "z = 160 mm, mean over one pass, from the pins", "y = 0, largest over the pass, record by record"
    for place, (field, title) in enumerate(zip((side, slice_, highest), titles), start=2):
        panel = figure.add_subplot(2, 2, place)
        plot_field.plane(figure, panel, *field)
        panel.set_title(title)
        across = place == 3
        angle = np.linspace(0, np.pi * (2 if across else 1), 200)
        radius = np.sqrt(50.0**2 - 20.0**2) if across else 50.0
        panel.plot(radius * np.cos(angle), (0 if across else 140) + radius * np.sin(angle), ":", color="#5fe3ff", lw=1, label="the surface asked for")
        if field is highest:
            panel.contour(field[1]["x_mm"], field[1]["z_mm"], field[0], levels=[2.0], colors="white", linewidths=1.2)
            panel.plot([], [], color="white", label="2 kPa, the threshold of Fig. 21")
        legend(panel, loc="upper right", facecolor="#777777", labelcolor="white")
    save(work, figure, name)
    pressures, rows = pass_rows(played, 200, 7)
    radii = np.linalg.norm(foci - [0, 0, 140], axis=1)
    axis = side[0][:, int(np.argmin(abs(np.asarray(side[1]["x_mm"]))))]
    centre, top = (axis[int(np.argmin(abs(np.asarray(side[1]["z_mm"]) - z)))] for z in (140, 190))
    return [
        row("mean radiation pressure at the sphere's centre over that at its top", centre / top,
            why="in the mean over a pass it is no shell: foci are deep, and every wave to the top passes below. The paper shows what is above 2 kPa"),
        row("radius of the points about (0, 0, 140) mm, mean", radii.mean(), "mm", 50.0, "text"),
        row("sound pressure at each point while it plays, mean", pressures.mean(), "kPa", 2.65, "measured", SOURCE),
        row("its standard deviation", pressures.std(), "kPa", 0.2, "measured", "in the model the points differ by distance and directivity alone"),
        row("points above 2 kPa, the threshold of Fig. 21", 100 * (pressures > 2.0).mean(), "%", why="the paper shows its hemisphere by what is above; which share of its points that is it does not say"),
        row("its standard deviation over its mean", 100 * pressures.std() / pressures.mean(), "%", 100 * 0.2 / 2.65, "measured"),
        *rows,
    ]  # fmt: skip
