#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The papers' figures, computed now: a picture each, and a page with each picture beside a table of the paper's numbers and
ours. Haptogram is the paper of the system; Hoshi is "Noncontact Tactile Display Based on Radiation Pressure of Airborne
Ultrasound"; Multimodal is the paper of the cable robot beside the ultrasound (docs/references.md). The fields of played shapes
come from the pulses that the Verilated board makes. Nothing is tuned to agree, but for one bandwidth in Hoshi's Fig. 12c, which
is named where it is used."""

import argparse
import functools
import html
import json
import pathlib
import subprocess
import sys
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import plot_field  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).parent / "python"))
from haptogram.study import figures as study_figures, printed  # noqa: E402

DPI = 110
SOURCE = "the source strength of 4 Pa·m is the array file's, not calibrated on the paper's transducers: the pressure scales with it"
RADIATION = "time-averaged radiation pressure / Pa"


def run(*arguments):
    result = subprocess.run([str(a) for a in arguments], stdout=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(f"figures: {' '.join(map(str, arguments))} ended with exit code {result.returncode}\n{result.stdout}")
    return result.stdout


def row(what, ours, unit="", paper=None, kind="", why=""):
    """A line of the table. `kind` says what the paper's number is: theory, measured, or text."""
    return {"what": what, "unit": unit, "paper": paper, "kind": kind, "ours": float(ours), "why": why}


class Work:
    """What the figures are made of; each piece is made once, when it is first asked for."""

    def __init__(self, program, tool, folder):
        self.program, self.tool, self.folder = program, tool, folder
        self.data = folder / "data"
        self.data.mkdir(parents=True, exist_ok=True)
        point = self.data / "tile-of-points.toml"
        point.write_text(
            'name = "tile-of-points"\n[array]\nrows = 10\ncolumns = 10\npitch_mm = 10.0\n[medium]\ntemperature_c = 20.0\n'
            'density_kg_m3 = 1.204\n[transducer]\nfile = "point"\nsource_pa_m = 4.0\n', encoding="utf-8")  # fmt: skip
        self.points_array = point
        hoshi = self.data / "hoshi-of-points.toml"
        hoshi.write_text(
            'name = "hoshi-of-points"\n[array]\nrows = 18\ncolumns = 18\npitch_mm = 10.0\n[medium]\nspeed_m_s = 340.0\n'
            'density_kg_m3 = 1.2\n[transducer]\nfile = "point"\n[board]\nchannels = 324\n', encoding="utf-8")  # fmt: skip
        self.hoshi_of_points = hoshi

    @functools.cached_property
    def computed(self):
        return json.loads(run(self.tool))

    @functools.cache
    def played(self, name, *arguments):
        """Compiles, plays one pass on the Verilated board, and measures its pins: (manifest, pulses, report, foci)."""
        print(f"figures: playing {name}", file=sys.stderr)
        image, pulses, report = (self.data / f"{name}{end}" for end in (".hex", ".pulses.csv", ".report.json"))
        run(self.program, "compile", *arguments, "-o", image)
        run(self.program, "simulate", image, "--load", "direct", "--passes", 1, "--pulses", pulses, "--report", report)
        manifest = image.with_suffix(".json")
        foci = np.array([r["focus_mm"] for r in json.loads(manifest.read_text(encoding="utf-8"))["records"]])
        return manifest, pulses, json.loads(report.read_text(encoding="utf-8")), foci

    def plane(self, region, *arguments, label=RADIATION):
        path = self.data / "plane.csv"
        run(self.program, "field", "--plane", region, *arguments, "-o", path)
        return plot_field.read_csv(path, region, label, [])

    def highest(self, region, played, *arguments):
        """The largest amplitude at each point of a plane over a pass, kPa: record by record, as the image has them."""
        image, path = played[0].with_suffix(".hex"), self.data / "plane.csv"
        best, about = 0.0, None
        for record in range(1, len(played[3]) + 1):
            run(self.program, "field", image, "--record", record, "--plane", region, "--quantity", "rms", *arguments, "-o", path)
            field, about = plot_field.read_csv(path, region, "largest sound pressure amplitude / kPa", [])
            best = np.maximum(best, field * np.sqrt(2.0) / 1e3)
        return best, about

    def line(self, region, *arguments):
        path = self.data / "line.csv"
        run(self.program, "field", "--line", region, *arguments, "-o", path)
        return np.loadtxt(path, delimiter=",", skiprows=1).T


def of(played):
    return "--pulses", played[1], "--manifest", played[0]


def crossings(x, y, level, peak):
    """Where y falls below `level` on either side of the sample `peak`, interpolated; NaN where it does not."""
    found = []
    for step in (-1, 1):
        i = peak
        while 0 <= i + step < len(y) and y[i] >= level:
            i += step
        if y[i] >= level:
            found.append(float("nan"))
        else:
            found.append(x[i] + (level - y[i]) / (y[i - step] - y[i]) * (x[i - step] - x[i]))
    return found


def width(x, y, fraction=0.5):
    low, high = crossings(x, y, fraction * y.max(), int(np.argmax(y)))
    return high - low


def first(t, y, level):
    """When a rising y first reaches `level`, interpolated."""
    i = int(np.argmax(y >= level))
    return t[i - 1] + (level - y[i - 1]) / (y[i] - y[i - 1]) * (t[i] - t[i - 1])


def panels(count, size):
    figure, axes = plt.subplots(1, count, figsize=size, constrained_layout=True)
    return figure, np.atleast_1d(axes)


def save(work, figure, name):
    figure.savefig(work.folder / f"{name}.png", dpi=DPI)
    plt.close(figure)


def legend(panel, **more):
    panel.legend(fontsize=8, framealpha=0.85, **more)


# ---------------------------------------------------------------- Haptogram


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


# ---------------------------------------------------------------- Hoshi


def hoshi_3(work, name):
    found = work.computed["energy_loss"]
    figure, (panel,) = panels(1, (8.5, 4.2))
    panel.plot(found["khz"], 100 * np.array(found["hoshi"]), label="as the paper: 1 dB/m at 40 kHz, rising as f²")
    panel.plot(found["khz"], 100 * np.array(found["iso_9613_1"]), "--", label="ISO 9613-1: 20 °C, 50 % humidity")
    panel.set(xlabel="frequency / kHz", ylabel="energy lost on 200 mm / %", title="Loss of energy in 200 mm of air", xlim=(0, 200), ylim=(0, 75))
    panel.grid(alpha=0.3)
    legend(panel, loc="upper left")
    save(work, figure, name)
    return [
        row("absorption at 40 kHz", found["absorption_40_khz_np_m"], "Np/m", 0.115, "text"),
        row("energy lost on 200 mm at 40 kHz", 100 * found["lost_40_khz"], "%", 4.0, "theory", "the paper rounds, or cuts off"),
        row("the same at 160 kHz", 100 * found["lost_160_khz"], "%", 50.0, "theory", "a round number in the paper"),
        row("radiation pressure kept on 400 mm at 40 kHz: more than", 100 * found["kept_at_400_mm"], "%", 90.0, "theory", "a bound in the paper: more than 90 %"),
        row("by ISO 9613-1: absorption at 40 kHz", found["iso_absorption_40_khz_np_m"], "Np/m", 0.115, "text", "20 °C, 50 % relative humidity; the paper's value has another source"),
        row("by ISO 9613-1: energy lost at 40 kHz", 100 * found["iso_lost_40_khz"], "%", 4.0, "theory"),
        row("by ISO 9613-1: energy lost at 160 kHz", 100 * found["iso_lost_160_khz"], "%", 50.0, "theory", "molecular relaxation flattens the rise; f² overstates it"),
    ]  # fmt: skip


def hoshi_row(work, name):
    """The closed forms of section 2.2, drawn as what the force is made of."""
    found = work.computed["hoshi_focus"]
    figure, (panel,) = panels(1, (8.5, 4.2))
    labels = ["theory: eq. 4 and 5", "exact spherical waves", "with the T4010A1's directivity", "and phases in 16 steps", "paper, measured"]
    values = [found["force_mn"], found["force_spherical_mn"], found["force_pattern_mn"], found["force_16_steps_mn"], 16.0]
    bars = panel.barh(labels[::-1], values[::-1], color=["#c0392b"] + ["#174a7c"] * 4)
    panel.bar_label(bars, fmt="%.1f mN", padding=4, fontsize=9)
    panel.set(xlabel="force through the focal square / mN", xlim=(0, 185), title="18 × 18 elements of 36 Pa rms at 200 mm, focus at 200 mm")
    panel.axvline(143, color="#666666", lw=0.8, ls=":")
    save(work, figure, name)
    taken, missing = 1 - found["force_16_steps_mn"] / found["force_spherical_mn"], 1 - 16.0 / found["force_16_steps_mn"]
    why = (
        "the paper's own list: decay and directivity per transducer, angles of incidence, unequal delays, 16 phase steps, mutual "
        f"impedance, non-linear air. Directivity and steps, computed here, take {taken:.0%} away; {missing:.0%} are missing"
    )
    return [
        row("focal diameter w_f", found["w_f_mm"], "mm", 19.0, "theory", "the paper rounds"),
        row("focal depth w_d", found["w_d_mm"], "mm", 42.0, "theory"),
        row("first side lobe over the peak (eq. 4)", found["side_lobe"], "", 0.05, "theory", "the paper says about 0.05"),
        row("force (eq. 5 on eq. 4)", found["force_mn"], "mN", 143.0, "theory"),
        row("force, spherical waves without the Fresnel approximation", found["force_spherical_mn"], "mN", 143.0, "theory", "each element's 36 Pa is at 200 mm on its axis"),
        row("the same with the T4010A1's directivity", found["force_pattern_mn"], "mN", 143.0, "theory"),
        row("and with phases in 16 steps", found["force_16_steps_mn"], "mN", 16.0, "measured", why),
        row("level of one transducer, 24 Pa rms", found["one_level_db"], "dB", 121.5, "text", "24 Pa rms is 121.58 dB"),
        row("radiation pressure of 100 in phase at 300 mm", found["hundred_radiation_pa"], "Pa", 83.0, "theory"),
    ]  # fmt: skip


def hoshi_6(work, name):
    found = work.computed["hoshi_focus"]
    x, cut = np.array(found["eq4_x_mm"]), np.array(found["eq4_radiation"])
    coarse = slice(None, None, 10)
    u, exact = work.line("x@y=0,z=200", "--focus", "0,0,200", "--array", work.hoshi_of_points, "--extent", 45, "--step", 0.1)
    exact = exact / exact.max()
    figure, axes = panels(2, (11.5, 4.9))
    drawn = axes[0].pcolormesh(x[coarse], x[coarse], np.outer(cut[coarse], cut[coarse]), cmap="magma", vmin=0, vmax=1, shading="nearest", rasterized=True)
    axes[0].set(xlabel="x / mm", ylabel="y / mm", aspect="equal", title="eq. 4, focal plane at 200 mm")
    figure.colorbar(drawn, ax=axes[0], label="radiation pressure over its peak", shrink=0.85)
    axes[1].plot(x, cut, label="eq. 4 (Fresnel)")
    axes[1].plot(u, exact, "--", label="exact spherical waves")
    axes[1].axhline(0.05, color="#666666", lw=0.8, ls=":", label="paper: side lobes about 0.05")
    axes[1].set(xlabel="x / mm", ylabel="radiation pressure over its peak", title="along x through the focus")
    axes[1].grid(alpha=0.3)
    legend(axes[1])
    save(work, figure, name)
    near = (abs(u) > found["w_f_mm"] / 2) & (abs(u) < 1.2 * found["w_f_mm"])
    zeros = x[1:-1][(cut[1:-1] < cut[:-2]) & (cut[1:-1] < cut[2:])]
    return [
        row("side lobe, eq. 4", found["side_lobe"], "", 0.05, "theory", "the paper says about 0.05"),
        row("side lobe, exact spherical waves", exact[near].max(), "", 0.05, "theory", "eq. 4 takes distances to second order, and equal amplitudes"),
        row("diameter between the zeros, eq. 4", zeros[zeros > 0].min() - zeros[zeros < 0].max(), "mm", 19.0, "theory"),
    ]


def hoshi_11(work, name):
    source = ("--focus", "0,0,200", "--array", "hoshi-18x18")
    x, across = work.line("x@y=0,z=200", *source, "--extent", 50, "--step", 0.1)
    z, along = work.line("z@x=0,y=0", *source, "--z", "60:400", "--step", 0.5)
    across, along = across / across.max(), along / along[int(np.argmin(abs(z - 200)))]
    figure, axes = panels(2, (11.5, 4.4))
    axes[0].plot(x, across)
    axes[0].set(xlabel="x / mm", ylabel="radiation pressure over that at the focus", title="(b) along x, y = 0, z = 200 mm")
    axes[1].plot(z, along)
    axes[1].axhline(0.2, color="#c0392b", lw=0.8, ls="--", label="the paper's threshold, 0.2")
    axes[1].set(xlabel="z / mm", ylabel="radiation pressure over that at the focus", title="(c) along z, x = y = 0")
    legend(axes[1])
    for axis in axes:
        axis.grid(alpha=0.3)
    save(work, figure, name)
    minima = x[1:-1][(across[1:-1] < across[:-2]) & (across[1:-1] <= across[2:])]
    low, high = crossings(z, along, 0.2, int(np.argmax(along)))
    lobes = across[(abs(x) > 9.5) & (abs(x) < 28)]
    closed = work.computed["hoshi_focus"]["w_d_mm"]
    return [
        row("diameter, between the minima along x", minima[minima > 0].min() - minima[minima < 0].max(), "mm", 20.0, "measured"),
        row("width at half maximum along x", width(x, across), "mm"),
        row("first side lobe along x", lobes.max(), "", 0.05, "theory", "the paper's measured lobes are not symmetric; its text gives no number for them"),
        row("depth at a threshold of 0.2", high - low, "mm", 100.0, "measured", "about 100 mm in the paper, which compares it with w_d, another measure"),
        row("the same over w_d", (high - low) / closed, "", 2.4, "measured"),
        row("where along z it is largest", z[int(np.argmax(along))], "mm", why="a focused field's maximum lies nearer to the array than its focal point"),
    ]  # fmt: skip


def hoshi_12(work, name):
    found = work.computed["modulation"]
    step = found["step_us"] / 1e3
    envelope, wave = np.array(found["envelope_pa"]), np.array(found["pressure_pa"])
    half = 10
    t = np.arange(len(envelope)) * step - found["second_order"]["first_arrival_us"] / 1e3
    inner = slice(half, len(t) - half)
    t, envelope, wave = t[inner], envelope[inner], wave[inner]
    full = envelope.max()
    radiation = (envelope / full) ** 2
    figure, axes = panels(2, (11.5, 4.4))
    for axis, limits in zip(axes, ((-0.5, 9.2), (0, 1))):
        axis.plot(t, wave / full, lw=0.4, color="#9ab8d6", label="ultrasound")
        axis.plot(t, envelope / full, color="#174a7c", lw=1, label="its envelope")
        axis.plot(t, radiation, color="#c0392b", label="radiation pressure")
        axis.set(xlabel="time after the first arrival / ms", ylabel="over its maximum", xlim=limits, ylim=(-1.1, 1.1))
        axis.grid(alpha=0.3)
    axes[0].set_title("(a) 100 Hz modulation, at the focus, 200 mm")
    axes[1].set_title("(b) the first millisecond")
    legend(axes[1], loc="lower right")
    save(work, figure, name)
    rise = first(t, envelope / full, 0.9)
    stop = 5.0
    after = t > stop
    fall = first(t[after], -(envelope / full)[after], -0.1) - stop
    radiation_rise = first(t, radiation, 0.9)
    radiation_fall = first(t[after], -radiation[after], -0.1) - stop
    reached = float(np.interp(0.5, t, envelope / full))
    why = "ours is the pressure itself; in the paper's it went through a sensor, whose filters were compensated"
    return [
        row("rise of the ultrasound to 90 %", rise, "ms", 0.5, "measured", "the paper does not say to which level"),
        row("amplitude 0.5 ms after the first arrival", 100 * reached, "%"),
        row("fall of the ultrasound to 10 %", fall, "ms", 0.5, "measured"),
        row("rise of the radiation pressure to 90 %", radiation_rise, "ms", 1.0, "measured", "the paper says nearly 1 ms; " + why),
        row("fall of the radiation pressure to 10 %", radiation_fall, "ms", 1.0, "measured", "the square falls faster than the amplitude; " + why),
    ]  # fmt: skip


def hoshi_7(work, name):
    """Section 3.1 and eq. 7: pulses on 16 segments."""
    found = work.computed["quantised"]
    figure, axes = panels(2, (11.5, 4.6))
    for place, element in enumerate(found["row"]):
        level = len(found["row"]) - 1 - place
        segment = np.arange(33)
        high = (segment - element["start"]) % 16 < element["length"]
        axes[0].step(segment, 0.7 * high + level, where="post", color="#174a7c", lw=1.3)
        for cycle in (0, 1):
            axes[0].plot([element["exact_start"] + 16 * cycle], [level - 0.08], "^", color="#c0392b", ms=4, label="exact start" if place + cycle == 0 else None)
    axes[0].set(xlabel="time / segments of 1.5625 µs", ylabel="element of the row y = 5 mm", xlim=(0, 32), xticks=range(0, 33, 4),
                yticks=[len(found["row"]) - 1 - i + 0.35 for i in range(len(found["row"]))],
                yticklabels=[f"x = {e['x_mm']:.0f} mm" for e in found["row"]], ylim=(-1.3, 9), title="focus at (0, 0, 200) mm: phases in 16 steps")  # fmt: skip
    axes[0].grid(axis="x", alpha=0.3)
    legend(axes[0], loc="lower right")
    duty = np.linspace(0, 1, 401)
    axes[1].plot(duty, np.sin(np.pi * duty), color="#174a7c", label="pressure, eq. 7: |sin(πD/T)|")
    axes[1].plot(duty, np.sin(np.pi * duty) ** 2, "--", color="#c0392b", label="radiation pressure: its square")
    steps = np.arange(9) / 16
    axes[1].plot(steps, found["carrier"], "o", color="#174a7c", label="pulses of 0 to 8 segments: their 40 kHz")
    axes[1].plot(steps, np.array(found["carrier"]) ** 2, "s", color="#c0392b", ms=5)
    axes[1].set(xlabel="pulse width over the period, D/T", ylabel="over its maximum", title="amplitudes of the carrier", xlim=(0, 1), ylim=(0, 1.05))
    axes[1].grid(alpha=0.3)
    legend(axes[1], loc="lower center")
    save(work, figure, name)
    table = np.sin(np.pi * np.arange(9) / 16)
    return [
        row("clocks of 25.6 MHz in a segment", 25.6e6 / 40e3 / 16, "", why="a segment of 1.5625 µs, exactly"),
        row("amplitudes of pulses of 0 to 8 segments: how many different", len(set(np.round(found["drive"], 9))), "", 8, "text",
            "three bits name eight; silence, or another one of the nine, must be left out, and the paper does not say which"),
        row("largest difference of the pulses' carrier from sin(πn/16)", np.abs(np.array(found["carrier"]) - table).max()),
        row("pressure that 16 phases keep, mean over the 18 × 18 positions", 100 * found["kept_mean"], "%", why="by theory sin(x)/x with x = π/16, 99.36 %"),
        row("the same, least of all positions", 100 * found["kept_least"], "%"),
    ]  # fmt: skip


def hoshi_12c(work, name):
    found = work.computed["response"]
    figure, (panel,) = panels(1, (8.5, 4.4))
    panel.semilogx(found["hz"], found["printed_db"], "o-", ms=4, label="bandwidth 2 kHz, as the paper prints")
    panel.semilogx(found["hz"], found["fitted_db"], "s-", ms=4, label=f"bandwidth {found['fitted_hz']:.0f} Hz, fitted to the paper's −5.8 dB")
    panel.plot([10, 1000], [0, -5.8], "x", color="#c0392b", ms=9, mew=2, label="paper, measured: its two numbers")
    panel.set(xlabel="frequency of the modulation / Hz", ylabel="radiation pressure over that at 10 Hz / dB", ylim=(-7, 0.5),
              title="(c) fundamental of the radiation pressure, carrier switched on and off", xticks=[10, 20, 50, 100, 200, 500, 1000])  # fmt: skip
    panel.set_xticklabels(["10", "20", "50", "100", "200", "500", "1000"])
    panel.minorticks_off()
    panel.grid(alpha=0.3)
    legend(panel, loc="lower left")
    save(work, figure, name)
    fitted = "this one bandwidth is fitted to the paper's −5.8 dB, and to nothing else"
    rows = [row(f"at {f} Hz, bandwidth 2 kHz", db, "dB", *((-5.8, "measured", "the printed bandwidth does not give the measured response") if f == 1000 else ()))
            for f, db in zip((200, 500, 1000), found["printed_at"])]  # fmt: skip
    return [
        *rows,
        row("bandwidth that gives −5.8 dB at 1 kHz", found["fitted_hz"], "Hz", 2000.0, "text", fitted),
        row("its time constant", found["fitted_tau_us"], "µs"),
        row("with it, the envelope rises to 90 % in", found["fitted_envelope_90_ms"], "ms", 0.5, "measured", "follows from the fit; the paper does not say to which level"),
        row("with it, the radiation pressure rises to 95 % in", found["fitted_radiation_95_ms"], "ms", 1.0, "measured", "follows from the fit; the paper says nearly 1 ms"),
    ]


def hoshi_eq9(work, name):
    found = {key: np.array(value) for key, value in work.computed["pattern"].items()}
    x, far = found["x_mm"], found["copy_x_mm"]
    figure, axes = panels(2, (12.5, 4.7))
    axes[0].plot(x, found["fresnel"], label="eq. 9 (Fresnel)")
    axes[0].plot(x, found["equal"], "--", label="equal amplitudes, exact distances")
    axes[0].plot(x, found["transform"], label="spherical waves: eq. 9's drives")
    axes[0].plot(x, found["superposition"], lw=1.2, label="superposition, phases alone")
    axes[0].plot(x, found["weighted_gs"], ":", lw=2, color="#222222", label="weighted Gerchberg–Saxton, phases alone")
    for at in (-20, 20):
        axes[0].axvline(at, color="#666666", lw=0.8, ls=":")
    axes[0].set(xlabel="x / mm", ylabel="pressure over that of a single focus", title="two spots asked for at ±20 mm", ylim=(0, 1.05))
    axes[1].plot(far, found["copy_fresnel"], label="eq. 4 (Fresnel)")
    axes[1].plot(far, found["copy_equal"], "--", label="equal amplitudes, exact distances")
    axes[1].plot(far, found["copy_exact"], label="spherical waves")
    axes[1].axvline(float(found["repeats_mm"]), color="#666666", lw=0.8, ls=":", label="λr/d, where eq. 4 repeats")
    axes[1].set(xlabel="x / mm", ylabel="pressure over that of the focus", title="a single focus at x = 0, and its first copy", ylim=(0, 1.05))
    for axis in axes:
        axis.grid(alpha=0.3)
        legend(axis, **({"loc": "upper right"} if axis is axes[0] else {"loc": "upper left", "bbox_to_anchor": (0.06, 1.0)}))
    save(work, figure, name)

    def top(key, at, from_mm, to_mm):
        inside = (at >= from_mm) & (at <= to_mm)
        return at[inside][int(np.argmax(found[key][inside]))], found[key][inside].max()

    spots = {key: top(key, x, 5, 40) for key in ("fresnel", "equal", "transform", "superposition", "gs", "weighted_gs")}
    copies = {key: top(key, far, 150, 260) for key in ("copy_fresnel", "copy_equal", "copy_exact")}
    same = "eq. 9 asks for ±20 mm"
    return [
        row("spot's place by eq. 9 in the Fresnel approximation", spots["fresnel"][0], "mm", 20.0, "theory", same + "; the other spot's side lobe pushes it outwards"),
        row("its pressure over a single focus", spots["fresnel"][1]),
        row("spot's place with exact distances, equal amplitudes", spots["equal"][0], "mm", 20.0, "theory", "the Fresnel approximation is poor at 200 mm from an array of 180 mm"),
        row("spot's place by spherical waves", spots["transform"][0], "mm", 20.0, "theory", "the same, and nearer elements count more"),
        row("its pressure over a single focus", spots["transform"][1]),
        row("spot's place by superposition of exact foci", spots["superposition"][0], "mm", 20.0, "theory", "the other spot's side lobe pushes it outwards"),
        row("its pressure", spots["superposition"][1], why="phases alone: every element at full strength"),
        row("the same by Gerchberg–Saxton", spots["gs"][1]),
        row("the same by weighted Gerchberg–Saxton", spots["weighted_gs"][1]),
        row("first copy of a single focus by eq. 4", copies["copy_fresnel"][0], "mm", 170.0, "theory"),
        row("its pressure over the focus'", copies["copy_fresnel"][1], "", 1.0, "theory"),
        row("first copy with exact distances, equal amplitudes", copies["copy_equal"][0], "mm", 170.0, "theory", "it is farther off, and no copy of the same height"),
        row("its pressure over the focus'", copies["copy_equal"][1], "", 1.0, "theory"),
        row("first copy by spherical waves", copies["copy_exact"][0], "mm", 170.0, "theory"),
        row("its pressure over the focus'", copies["copy_exact"][1], "", 1.0, "theory"),
    ]


# ---------------------------------------------------------------- studies


def study_confusion(work, name):
    figure, paper, made = study_figures.confusion()
    save(work, figure, name)
    simulated = "no person answered: one draw of people with the paper's rates"
    return [
        row("right answers over all", 100 * paper.share, "%", 59.44, "text", "223 of 360 by the paper's own Table 1"),
        row("Cohen's κ of Table 1", paper.kappa),
        row("information in Table 1, of 2 bit", paper.bits, "bit"),
        row("right answers of the simulated study", 100 * made.share, "%", why=simulated),
        row("its κ", made.kappa, why=simulated),
    ]


def study_staircase(work, name):
    figure, found = study_figures.staircase()
    save(work, figure, name)
    return [row(f"threshold, begun {start}", level, "dB", -18.0, "theory", "the simulated person's; one run has an SD of about 0.5 dB") for start, level in found.items()]


# ---------------------------------------------------------------- Multimodal


def asked(work, *arguments):
    return json.loads(run(work.program, *arguments, "--json"))


def table(work, name, *arguments):
    """A run of the robot's simulation as a table."""
    path = work.data / f"{name}.csv"
    run(work.program, "robot", *arguments, "-o", path)
    return np.genfromtxt(path, delimiter=",", names=True)


def multimodal_magnitude(work, name):
    """Eq. 10 and 11 with Tables I and II, over the outputs that the device has, and the thresholds of Table III."""
    figure, axes = panels(3, (15, 4.6))
    rows, read = [], {80: (10.149, 0.6185), 100: (8.928, 0.5804), 140: (8.070, 0.5587), 180: (7.592, 0.5478), 240: (4.363, 0.5280), 300: (2.458, 0.4926)}
    for hz, (magnitude, output) in read.items():
        known = asked(work, "magnitude", "--frequency", hz)
        least, full = known["least_felt_gf"], known["full_output_gf"]
        (low, high) = known["magnitudes"]
        # The last wanted magnitude lies a little below the largest, which is rounded on the command line.
        points = [asked(work, "magnitude", f"{wanted:.9f}", "--frequency", hz) for wanted in np.linspace(low + 1e-6, high - 1e-6, 13)]
        outputs, wanted, commands = ([p[key] for p in points] for key in ("output_gf", "magnitude", "command"))
        axes[0].plot(outputs, commands, ".-", ms=4, label=f"{hz} Hz")
        axes[1].plot(outputs, wanted, ".-", ms=4)
        rows.append(row(f"output of the full command at {hz} Hz", full, "gf", output, "theory", "from the coefficients of Table I, of which the paper prints no such value; solved apart from this program"))
        rows.append(row(f"perceived magnitude of it at {hz} Hz", high, "", magnitude, "theory", "from the coefficients of Tables I and II"))
        rows.append(row(f"least that a palm feels at {hz} Hz and a grip of 1 N", least, "gf"))
    axes[0].set(xlabel="output / gf", ylabel="command", ylim=(0, 1.02), title="eq. 11: the command of an output")
    axes[1].set(xlabel="output / gf", ylabel="perceived magnitude", ylim=(0, None), title="eq. 10: how an output feels")
    legend(axes[0])
    for region, colour in (("palm", "#174a7c"), ("finger", "#c0392b")):
        grips = np.unique(np.concatenate([np.geomspace(1, 10, 13), [3.0, 6.0]]))
        ends = np.array([asked(work, "magnitude", "--region", region, "--grip", f"{grip:.6f}")["threshold_interval_gf"] for grip in np.minimum(grips, 10)])
        axes[2].fill_between(grips, *ends.T, alpha=0.35, color=colour, lw=0, label=region)
    axes[2].set(xscale="log", xlabel="force of the handle on the hand / N", ylabel="least felt / gf", title="Table III: thresholds")
    axes[2].set_xticks([1, 3, 6, 10], ["1", "3", "6", "10"])
    axes[2].minorticks_off()
    legend(axes[2], loc="upper left")
    for axis in axes:
        axis.grid(alpha=0.3)
    save(work, figure, name)
    return rows


def multimodal_waveforms(work, name):
    """What the waveform and the duty of the modulation do to the radiation pressure (eq. 8, 9 and 13)."""
    phase = np.arange(4096) / 4096
    ramp = 1 - abs(2 * phase - 1)
    waves = {"square": (phase < 0.5) * 1.0, "abs-sine": np.sin(np.pi * phase), "sine": 0.5 + 0.5 * np.sin(2 * np.pi * phase), "triangle": ramp, "sawtooth": phase}
    figure, axes = panels(3, (15, 4.6))
    for place, (shape, wave) in enumerate(waves.items()):
        twice = np.concatenate([wave, wave]) ** 2
        axes[0].plot(np.arange(len(twice)) / len(wave), 0.8 * twice + 4 - place, lw=1.2)
    axes[0].set(xlabel="periods of the modulation", yticks=[4.4 - i for i in range(5)], yticklabels=list(waves), title="radiation pressure, m², of each waveform")
    rows = []
    for offset, weighing, how in ((-0.2, "fundamental", "what is felt: the fundamental"), (0.2, "mean", "what a balance weighs: the mean")):
        factors = [asked(work, "magnitude", 2, "--frequency", 180, "--waveform", shape, "--weighing", weighing)["waveform_factor"] for shape in waves]
        axes[1].bar(np.arange(5) + offset, factors, 0.4, label=how)
        for (shape, wave), ours in zip(waves.items(), factors):
            spectrum = np.fft.rfft(wave**2) / len(wave)
            square = np.fft.rfft(waves["square"]) / len(wave)
            sampled = 2 * abs(spectrum[1]) / (2 * abs(square[1])) if weighing == "fundamental" else spectrum[0].real / square[0].real
            rows.append(row(f"{shape} over the square wave, by its {weighing}", ours, "", sampled, "sampled", "the paper's coefficients of eq. 8 are not printed; beside ours is a sum over samples, without the program"))
        duties = np.linspace(0.08, 0.92, 29)
        half = [asked(work, "magnitude", 1.2, "--frequency", 180, "--duty", f"{duty:.6f}", "--weighing", weighing)["duty_factor"] for duty in duties]
        axes[2].plot(duties, 1 / np.array(half), "-", label=how)
    axes[1].set(ylabel="over the square wave of 50 % duty", ylim=(0, 1.25), title="eq. 8: factors of the waveforms")
    axes[1].set_xticks(range(5), list(waves))
    axes[2].set(xlabel="duty of the square wave", ylabel="over 50 % duty", title="eq. 9 and 13: factors of the duty")
    for axis in axes[1:]:
        axis.grid(alpha=0.3)
        legend(axis, loc="upper left")
    save(work, figure, name)
    return rows


def multimodal_workspace(work, name):
    """The useful workspace for two readings of ± 15°, over the edge of the frame, which the paper does not print."""
    edges = [320, 340, 360, 380, 400]
    found = {turns: [asked(work, "robot", "workspace", "--turns", turns, "--edge", edge)["volume_mm3"] for edge in edges] for turns in ("one", "all")}
    path = work.data / "workspace.csv"
    run(work.program, "robot", "workspace", "--turns", "one", "-o", path)
    cubes = np.genfromtxt(path, delimiter=",", names=True)
    figure, axes = panels(3, (15, 4.6))
    for axis, (u, v, across), title in ((axes[0], "xyz", "from above"), (axes[1], "xzy", "from the side")):
        sides = [np.unique(cubes[f"{letter}_mm"]) for letter in (u, v)]
        depth = np.zeros((len(sides[1]), len(sides[0])))
        for i, x in enumerate(sides[0]):
            for j, y in enumerate(sides[1]):
                depth[j, i] = 30 * cubes["useful"][(cubes[f"{u}_mm"] == x) & (cubes[f"{v}_mm"] == y)].sum()
        drawn = axis.pcolormesh(*sides, np.where(depth > 0, depth, np.nan), shading="nearest", cmap="viridis", vmin=0)
        for radius, style in ((40, ":"), (120, "--"), (160, "-")):
            axis.add_patch(plt.Circle((0, 0), radius, fill=False, ls=style, color="#c0392b", lw=1))
        axis.set(xlabel=f"{u} / mm", ylabel=f"{v} / mm", aspect="equal", xlim=(-180, 180), ylim=(-180, 180), title=f"{title}; red: the zones Z1 to Z3 of task T1")
        figure.colorbar(drawn, ax=axis, label=f"useful depth along {across} / mm", shrink=0.8)
    for turns, label in (("one", "± 15° about one axis at a time"), ("all", "± 15° about all axes at once")):
        axes[2].plot(edges, np.array(found[turns]) / 1e6, "o-", label=label)
    axes[2].axhline(7.518, color="#c0392b", lw=0.9, ls="--", label="paper: 7.518")
    axes[2].set(xlabel="edge of the cubic frame / mm", ylabel="useful volume / 10⁶ mm³", title="30 mm grid")
    axes[2].grid(alpha=0.3)
    legend(axes[2], loc="lower left")
    save(work, figure, name)
    why = "the paper prints neither its frame nor its handle; ours are a cube of 360 mm and 40 × 40 × 100 mm, chosen for the size of this volume"
    zone = 4 / 3 * np.pi * 160.0**3
    return [
        row("useful volume, edge 360 mm, one axis at a time", found["one"][2], "mm³", 7.518e6, "text", why),
        row("useful volume, edge 360 mm, all axes at once", found["all"][2], "mm³", 7.518e6, "text", why),
        row("edge at which one axis at a time has the paper's volume", float(np.interp(-7.518e6, -np.array(found["one"][1:4]), edges[1:4])), "mm", why="linear between the edges of the grid"),
        row("the ball of zone Z3 over the paper's useful volume", zone / 7.518e6, "", why="the zone of 160 mm is larger than the workspace that it lies in"),
    ]  # fmt: skip


ZONES = ((40, "Z1"), (120, "Z2"), (160, "Z3"))


def zone_lines(axis, most):
    for radius, zone in ZONES:
        if radius < 1.2 * most:
            axis.axhline(radius, color="#999999", lw=0.8, ls=":")
            axis.text(0.995, radius, zone, transform=axis.get_yaxis_transform(), va="top", ha="right", fontsize=8, color="#777777")


def multimodal_admittance(work, name):
    """The handle under four forces of 3 s, on the simulated robot, beside the differential equation of eq. 17."""
    figure, axes = panels(2, (12, 4.8))
    rows, settled = [], {4: 26.667, 5: 132.5, 8: 140.0, 10: 145.0}
    for colour, (force, closed) in zip(("#55a868", "#4c72b0", "#c44e52", "#8172b2"), settled.items()):
        trace = table(work, f"push-{force}", "simulate", "--push", f"0:3:0,0,{force}", "--duration", 12)
        axes[0].plot(trace["time_s"], trace["z_mm"], color=colour, label=f"{force} N")
        axes[1].plot(trace["time_s"], trace["measured_z_n"], color=colour, lw=0.8)
        at = trace["z_mm"][np.argmin(abs(trace["time_s"] - 2.97))]
        held = trace["measured_z_n"][(trace["time_s"] > 1) & (trace["time_s"] < 2.9)]
        why = "force over the stiffness of 150 N/m" if force == 4 else "120 mm and force over the stiffness of 400 N/m"
        rows.append(row(f"handle at the end of {force} N", at, "mm", closed, "closed form", why + "; stiffnesses are ours, the paper prints none"))
        rows.append(row(f"force that the controller measured then, {force} N", held.mean(), "N", force, "closed form", "the force of the simulated user"))
        rows.append(row(f"handle 9 s after {force} N", trace["z_mm"][-1], "mm"))
    zone_lines(axes[0], 150)
    axes[0].set(xlabel="time / s", ylabel="height of the handle / mm", ylim=(-15, 200), title="a push upwards from 0 to 3 s, through the zones")
    axes[1].set(xlabel="time / s", ylabel="force by the tensions / N", title="what the controller takes the user's force for")
    for axis in axes:
        axis.grid(alpha=0.3)
    legend(axes[0], loc="upper right", ncols=4)
    save(work, figure, name)
    return rows


def multimodal_8(work, name):
    """The story of Fig. 8, told by three pushes of a script."""
    trace = table(work, "story", "simulate", "--push", "1:3:0,0,3", "--push", "5:8:0,0,8", "--push", "12:12.6:0,0,-1", "--duration", 24)
    time, z = trace["time_s"], trace["z_mm"]
    figure, axes = plt.subplots(2, 1, figsize=(9.5, 6.4), sharex=True, constrained_layout=True)
    axes[0].plot(time, trace["user_z_n"], color="#174a7c", label="the user")
    axes[0].plot(time, trace["measured_z_n"], color="#2c7a4b", lw=0.8, label="what the controller measures")
    axes[0].set(ylabel="w_z / N", title="Fig. 8, by a script: force of the user and height of the handle")
    legend(axes[0])
    axes[1].plot(time, z, color="#174a7c")
    zone_lines(axes[1], z.max())
    for at, above, text in ((2.0, 42, "too weak:\nheld in Z1"), (4.1, 5, "back"), (4.4, 75, "breaks\nthrough"), (8.1, 148, "held by Z3"), (9.0, 112, "guided back, coasts in Z2"), (13.0, 62, "pushed to Z1,\nwhich snaps"), (18.0, 8, "rests at the origin")):
        axes[1].text(at, above, text, fontsize=8, color="#c0392b", ha="center" if at < 8 else "left", va="bottom")
    axes[1].set(xlabel="time / s", ylabel="x_r,z / mm", ylim=(-12, 172))
    for axis in axes:
        axis.grid(alpha=0.3)
    save(work, figure, name)

    def at(seconds):
        return float(np.interp(seconds, time, z))

    return [
        row("held in Z1 by 3 N", at(3.0), "mm", 20.0, "closed form", "3 N over 150 N/m; the paper's forces and stiffnesses are not printed"),
        row("back at the origin before the second push", at(5.0), "mm", 0.0, "text"),
        row("largest height in the run: out of Z1, through Z2 and into Z3", z.max(), "mm", why="the zones end at 40, 120 and 160 mm in the paper, too"),
        row("height at which it rests in Z2 after 8 N", at(12.0), "mm", why="between 40 and 120 mm"),
        row("at the origin in the end", at(24.0), "mm", 0.0, "text", "the noise of the tension sensors moves it by some tenths of a millimetre"),
    ]  # fmt: skip


def multimodal_t4(work, name):
    """Task T4 with the scripted user: what the mappings ask for, and what the simulated board's pins show."""
    figure, axes = plt.subplots(2, 3, figsize=(15, 7), sharex="col", constrained_layout=True)
    rows = []
    for column, mapping in enumerate(("G1", "G2", "G3")):
        path = work.data / f"place-{mapping}.csv"
        print(f"figures: placing by {mapping}", file=sys.stderr)
        report = json.loads(run(work.program, "robot", "place", "--mapping", mapping, "--json", "-o", path))
        trace, pins = np.genfromtxt(path, delimiter=",", names=True), report["pins"]
        time, felt, at = trace["time_s"], trace["frequency_hz"] > 0, [pin["time_s"] for pin in pins]
        top, below = axes[:, column]
        top.plot(time, trace["height_mm"], color="#174a7c", label="the cube")
        top.axhline(report["target_mm"], color="#c0392b", lw=0.9, ls=":", label="the height to find")
        top.set(ylabel="height / mm", title=f"{mapping}: {report['time_s']:.1f} s, {report['error_mm']:+.2f} mm off")
        if mapping == "G1":
            below.plot(time[felt], trace["line_mm"][felt], ".", ms=3, color="#174a7c", label="where the plane cuts the palm")
            below.set(ylabel="along the palm / mm")
        else:
            key = "frequency_hz" if mapping == "G2" else "magnitude"
            below.plot(time[felt], trace[key][felt], color="#174a7c", label="asked")
            measured = [pin["frequency_hz_at_pins"] if mapping == "G2" else pin["points"][0]["magnitude_at_pins"] for pin in pins]
            below.plot(at, measured, "o", mfc="none", color="#c0392b", label="by the pulses at the pins")
            below.set(ylabel="frequency / Hz" if mapping == "G2" else "perceived magnitude")
        below.set(xlabel="time / s")
        for axis in (top, below):
            axis.grid(alpha=0.3)
            legend(axis)
        off = max(abs(pin["frequency_hz_at_pins"] / pin["frequency_hz"] - 1) for pin in pins)
        ticks = max(abs(point["ticks_off"]) for pin in pins for point in pin["points"])
        rows += [
            row(f"{mapping}: offset of the placed cube", report["error_mm"], "mm", why="of a scripted user, who is no model of people; the paper's Table IV is not in its text"),
            row(f"{mapping}: time", report["time_s"], "s"),
            row(f"{mapping}: weight that the user held at rest", report["weight_felt_n"], "N", 1.0, "text", "the paper's weight is rendered; this is the force of the simulated hand"),
            row(f"{mapping}: largest error of the modulation's frequency at the pins", 100 * off, "%", why="a burst begins with a whole carrier period"),
            row(f"{mapping}: largest error of a pulse's length at the pins, in ticks", ticks, "", why="a pulse has whole ticks, so half of one is what rounding may do"),
        ]
    save(work, figure, name)
    return rows


FIGURES = {
    "haptogram-6": (haptogram_6, "Haptogram, Fig. 6: pulses of sample transducers"),
    "haptogram-11": (haptogram_11, "Haptogram, Fig. 11: how long a focal point takes to form"),
    "haptogram-switching": (switching, "Haptogram III-G: what fast switching costs"),
    "haptogram-13": (haptogram_13, "Haptogram, Fig. 13 (and 14, measured): a single point at 13 cm"),
    "haptogram-15": (haptogram_15, "Haptogram, Fig. 15: pressure against elevation"),
    "haptogram-16": (haptogram_16, "Haptogram, Fig. 16 (and 17, measured): a line at 12 cm"),
    "haptogram-18": (haptogram_18, "Haptogram, Fig. 18 (and 19, measured): a circle at 12 cm"),
    "haptogram-20": (haptogram_20, "Haptogram, Fig. 20 (and 21, measured): a hemisphere about 14 cm"),
    "hoshi-3": (hoshi_3, "Hoshi, Fig. 3: loss of energy in air"),
    "hoshi-force": (hoshi_row, "Hoshi 2.2 and 3.2: size and force of the focus"),
    "hoshi-6": (hoshi_6, "Hoshi, Fig. 6: distribution in the focal plane"),
    "hoshi-7": (hoshi_7, "Hoshi 3.1 and eq. 7: the quantised drive"),
    "hoshi-11": (hoshi_11, "Hoshi, Fig. 11b–c: cuts through the focus"),
    "hoshi-12": (hoshi_12, "Hoshi, Fig. 12a–b: modulation at 100 Hz"),
    "hoshi-12c": (hoshi_12c, "Hoshi, Fig. 12c: frequency characteristics, with one bandwidth fitted"),
    "hoshi-eq9": (hoshi_eq9, "Hoshi, eq. 9: two spots by a Fourier transform, and what repeats"),
    "multimodal-magnitude": (multimodal_magnitude, "Multimodal, eq. 10 and 11, Tables I–III: command, output, perceived magnitude, thresholds"),
    "multimodal-waveforms": (multimodal_waveforms, "Multimodal, eq. 8, 9 and 13: waveforms and duties"),
    "multimodal-workspace": (multimodal_workspace, "Multimodal, Fig. 4: useful workspace of the cable robot"),
    "multimodal-admittance": (multimodal_admittance, "Multimodal, eq. 17: the handle under a force, zone by zone"),
    "multimodal-8": (multimodal_8, "Multimodal, Fig. 8: the story of task T1"),
    "multimodal-t4": (multimodal_t4, "Multimodal, task T4: a cube is placed by touch, mappings G1 to G3"),
    "study-confusion": (study_confusion, "Haptogram, Table 1: which shape was taken for which"),
    "study-staircase": (study_staircase, "Multimodal, task T3: a staircase on a simulated person"),
}


def number(value):
    return "" if value is None else f"{value:.4g}" if abs(value) < 9999.5 else f"{value:.0f}"


def difference(line):
    if line["paper"] is None:
        return ""
    apart = line["ours"] - line["paper"]
    if abs(apart) < 5e-4 * abs(line["paper"]):
        return "none"
    percent = f" ({100 * apart / line['paper']:+.3g} %)" if line["unit"] != "%" and line["paper"] != 0 else ""
    unit = "points" if line["unit"] == "%" else line["unit"]
    return f"{apart:+.3g}{' ' + unit if unit else ''}{percent}"


STYLE = """body{font:16px/1.5 system-ui,sans-serif;margin:0 auto;max-width:72rem;padding:1rem;color:#222;background:#fff}
img{max-width:100%;height:auto;display:block}h2{margin:2.5rem 0 .5rem;font-size:1.25rem}
.wide{overflow-x:auto}table{border-collapse:collapse;width:100%;font-size:.9rem}
th,td{text-align:left;vertical-align:top;padding:.3rem .6rem;border-bottom:1px solid #ccc}td.n{white-space:nowrap}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#161616}th,td{border-color:#444}a{color:#8bf}}"""


def page(figures):
    e = html.escape
    parts = [
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Haptogram: the papers' figures, computed</title><style>{STYLE}</style></head><body>",
        "<h1>The papers' figures, computed</h1><p>Every number under “ours” was computed in the run that wrote this page (<code>make figures</code>). "
        "Where the paper's number is a measurement, ours is the theory's for the same set-up, and the last column says what is known of the "
        "difference. Nothing is tuned to agree, but for one bandwidth in Hoshi's Fig. 12c, which is named there. “Haptogram” is the paper of this system, “Hoshi” is T. Hoshi et al., <em>Noncontact Tactile "
        "Display Based on Radiation Pressure of Airborne Ultrasound</em>, and “Multimodal” is the paper of a cable robot beside ultrasound, doi:10.1109/JSEN.2022.3144888. "
        "Where Multimodal prints no number, a row has one that follows from what it prints by other means than our program, and says by which. "
        "The fields of the point, the line, the circles and the hemisphere come from the pulses measured "
        'at the pins of the Verilated FPGA, each of one pass; they are steady ones, each point\'s with its full pressure: '
        'what ring-up and switching cost has figures of its own. The same numbers: <a href="figures.json">figures.json</a>.</p><ul>',
        *(f'<li><a href="#{f["id"]}">{e(f["title"])}</a></li>' for f in figures),
        '<li><a href="#printed">All numbers that the papers print about their studies and formulas</a></li>',
        "</ul>",
    ]
    for f in figures:
        parts.append(f'<h2 id="{f["id"]}">{e(f["title"])}</h2><img src="{f["picture"]}" alt="{e(f["title"])}">')
        parts.append('<div class="wide"><table><thead><tr><th>what</th><th>paper</th><th>ours</th><th>difference</th><th>why</th></tr></thead><tbody>')
        for line in f["rows"]:
            unit = f" {line['unit']}" if line["unit"] else ""
            paper = f"{number(line['paper'])}{unit}, {line['kind']}" if line["paper"] is not None else "–"
            parts.append(
                f'<tr><td>{e(line["what"])}</td><td class="n">{e(paper)}</td><td class="n">{e(number(line["ours"]) + unit)}</td>'
                f'<td class="n">{e(difference(line))}</td><td>{e(line["why"])}</td></tr>'
            )
        parts.append("</tbody></table></div>")
    parts.append('<h2 id="printed">What the papers print, and what follows from it</h2><div class="wide"><table><thead><tr><th>paper</th>'
                 "<th>where</th><th>what</th><th>printed</th><th>ours</th><th>verdict</th><th>note</th></tr></thead><tbody>")  # fmt: skip
    for line in printed.recompute():
        cells = (line.paper, line.where, line.what, *printed.with_units(line), line.verdict, line.note)
        parts.append("<tr>" + "".join(f"<td>{e(cell)}</td>" for cell in cells) + "</tr>")
    parts.append("</tbody></table></div>")
    return "\n".join(parts) + "\n</body></html>\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=pathlib.Path, required=True, help="haptogram")
    parser.add_argument("--tool", type=pathlib.Path, required=True, help="haptogram_figures")
    parser.add_argument("--output", type=pathlib.Path, required=True, help="folder of pictures and page")
    parser.add_argument("--only", nargs="+", choices=FIGURES, default=list(FIGURES), metavar="NAME", help="of " + ", ".join(FIGURES))
    arguments = parser.parse_args()
    work = Work(arguments.program.resolve(), arguments.tool.resolve(), arguments.output)
    begun, figures = time.perf_counter(), []
    for name in (n for n in FIGURES if n in arguments.only):
        draw, title = FIGURES[name]
        rows = draw(work, name)
        for line in rows:
            if not np.isfinite(line["ours"]):
                sys.exit(f"figures: {name}: {line['what']} is {line['ours']}")
        figures.append({"id": name, "title": title, "picture": f"{name}.png", "rows": rows})
    (arguments.output / "figures.json").write_text(json.dumps({"figures": figures}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    (arguments.output / "index.html").write_text(page(figures), encoding="utf-8")
    print(f"{arguments.output}/index.html: {len(figures)} figures in {time.perf_counter() - begun:.0f} s")


if __name__ == "__main__":
    main()
