# SPDX-License-Identifier: Apache-2.0
"""Figures of the paper Multimodal."""

import json
import sys
import time

import matplotlib.pyplot as plt
import numpy as np
from scipy import special

from .work import legend, panels, row, run, save, width


def asked(work, *arguments):
    return json.loads(run(work.program, *arguments, "--json"))


def table(work, name, *arguments):
    """A run of the robot's simulation as a table."""
    path = work.data / f"{name}.csv"
    run(work.program, "robot", *arguments, "-o", path)
    return np.genfromtxt(path, delimiter=",", names=True)


def multimodal_1(work, name):
    """Eq. 1, a focused cap of as much area as the array, beside the sum over the array's elements. The pressure on the cap is what a flat
    array has there, by area and distance: 1/cos² of the angle."""
    side, focal, wavelength = 165.0, 200.0, 8.58
    steps, limit = 4000, np.arctan(side / np.sqrt(np.pi) / focal)
    beta, k = (np.arange(steps) + 0.5) / steps * limit, 2 * np.pi / wavelength

    def cap(across, along):
        return abs((np.exp(1j * k * along * np.cos(beta)) * special.j0(k * across * np.sin(beta)) * np.sin(beta) / np.cos(beta) ** 2).mean())

    path = work.data / "cap.csv"
    aimed = ("--focus", f"0,0,{focal:.0f}", "--array", "usx-16x16", "--line", f"x@y=0,z={focal:.0f}", "--extent", 40, "--step", 0.25)
    run(work.program, "field", *aimed, "--quantity", "rms", "-o", path)
    x, summed = np.loadtxt(path, delimiter=",", skiprows=1).T
    integral = np.array([cap(at, 0.0) for at in x])
    summed, integral = summed / summed.max(), integral / integral.max()
    figure, (axes,) = panels(1, (6, 4))
    axes.plot(x, summed, label="sum over 16 × 16 elements")
    axes.plot(x, integral, "--", label="eq. 1")
    axes.set(xlabel="x / mm", ylabel="pressure over its peak", title="focal plane, 200 mm")
    legend(axes)
    save(work, figure, name)
    why = "the paper prints no number of eq. 1"
    return [
        row("width of the radiation pressure at half maximum, eq. 1", width(x, integral**2), "mm", why=why),
        row("the same, sum over the elements", width(x, summed**2), "mm", why="T4010A1's directivity"),
        row("largest difference of the two pressures, over the peak", 100 * np.abs(summed - integral).max(), "%", why="a round cap has other side lobes than a square array"),
    ]  # fmt: skip


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
    edges = [330, 360, 390, 420, 450]
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
        axis.set(xlabel=f"{u} / mm", ylabel=f"{v} / mm", aspect="equal", xlim=(-195, 195), ylim=(-195, 195), title=f"{title}; red: the zones Z1 to Z3 of task T1")
        figure.colorbar(drawn, ax=axis, label=f"useful depth along {across} / mm", shrink=0.8)
    for turns, label in (("one", "± 15° about one axis at a time"), ("all", "± 15° about all axes at once")):
        axes[2].plot(edges, np.array(found[turns]) / 1e6, "o-", label=label)
    axes[2].axhline(7.518, color="#c0392b", lw=0.9, ls="--", label="paper: 7.518")
    axes[2].set(xlabel="edge of the cubic frame / mm", ylabel="useful volume / 10⁶ mm³", title="30 mm grid")
    axes[2].grid(alpha=0.3)
    legend(axes[2], loc="lower left")
    save(work, figure, name)
    why = "the paper prints neither its frame nor its handle; ours are a cube of 390 mm and 38 × 38 × 60 mm, chosen for the size of this volume without interference of cables"
    zone = 4 / 3 * np.pi * 160.0**3
    return [
        row("useful volume, edge 390 mm, one axis at a time", found["one"][2], "mm³", 7.518e6, "text", why),
        row("useful volume, edge 390 mm, all axes at once", found["all"][2], "mm³", 7.518e6, "text", why),
        row("the ball of zone Z3 over the paper's useful volume", zone / 7.518e6, "", why="the zone of 160 mm is larger than the workspace that it lies in"),
    ]  # fmt: skip


def multimodal_4bc(work, name):
    """The robot's useful cubes that the ultrasound reaches, too, from above and from the side: by the range and the angle that the papers
    print for the array, and by the pressure that ours reaches. The frame's centre is 250 mm above the array, as in our mode W1."""
    path, height = work.data / "workspace-4.csv", 250
    run(work.program, "robot", "workspace", "--turns", "one", "-o", path)
    cubes = np.genfromtxt(path, delimiter=",", names=True)
    x, y, z, useful = (cubes[key] for key in ("x_mm", "y_mm", "z_mm", "useful"))
    z, useful = z + height, useful == 1
    reached = {}
    for level in np.unique(z[z > 0]):
        file = work.data / f"reach-{level:.0f}.csv"
        run(work.program, "analyze", "--array", "usx-16x16", "--plane", f"xy@z={level:.0f}", "--extent", 180, "--step", 30, "-o", file)
        reached.update({(a, b, level): pressure for a, b, pressure in np.loadtxt(file, delimiter=",", skiprows=1)})
    pressure = np.array([reached[place] for place in zip(x, y, z)])
    file = work.data / "reach-axis.csv"
    run(work.program, "analyze", "--array", "usx-16x16", "--plane", "xy@z=200", "--extent", 30, "--step", 30, "-o", file)
    axis_pressure = next(p for a, b, p in np.loadtxt(file, delimiter=",", skiprows=1) if a == b == 0)
    side, slope = 165 / 2, np.tan(np.radians(60 / 2))
    high = (z >= 100) & (z <= 500)
    wide = {
        "beside the array's edge": np.maximum(np.maximum(abs(x), abs(y)) - side, 0) <= slope * z,
        "about the array's centre": np.hypot(x, y) <= slope * z,
    }
    strong = pressure >= axis_pressure / 2
    figure, axes = panels(2, (12, 5))
    for axis, u, v, labels in ((axes[0], x, y, "xy"), (axes[1], x, z, "xz")):
        axis.plot(u[useful], v[useful], "s", ms=13, color="#b9dfb4", label="robot alone")
        both = useful & high & wide["about the array's centre"]
        axis.plot(u[both], v[both], "s", ms=7, color="#2c7fb8", label="robot and ultrasound")
        axis.set(xlabel=f"{labels[0]} / mm", ylabel=f"{labels[1]} / mm", aspect="equal")
        legend(axis, loc="upper right")
    axes[0].set(xlim=(-195, 195), ylim=(-195, 195), title="from above")
    heights = np.array([100, 445])
    for sign in (-1, 1):
        axes[1].plot(sign * slope * heights, heights, color="#2c7fb8", lw=1)
    axes[1].plot([-side, side], [0, 0], color="black", lw=4)
    axes[1].set(xlim=(-195, 195), ylim=(-10, 445), title="from the side; black: the array")
    save(work, figure, name)
    why = "the paper only draws it; heights of 10 to 50 cm and an angle of 60° are printed for the array (in Shapes)"
    count = useful.sum()
    return [
        row("the robot's useful volume", 27e3 * count, "mm³"),
        *(row(f"of it within the ultrasound's, 60° {where}", 100 * (useful & high & inside).sum() / count, "%", why=why) for where, inside in wide.items()),
        row("of it with half of the pressure that the array reaches at 200 mm on its axis, or more", 100 * (useful & strong).sum() / count, "%", why="of our array of the same size, with T4010A1's directivity"),
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
