# SPDX-License-Identifier: Apache-2.0
"""Figures of the paper Shapes: what speed, spacing and dwell leave of a drawn line."""

import json

import numpy as np

from .work import legend, panels, row, run, save

CIRCLE = ("--shape", "circle", "--diameter", 40, "--center", "0,0,130")
LENGTH_MM = np.pi * 40


def drawn(work, name, *arguments):
    """A circle as an image, and what it is expected to feel like: (compile's report, feel's report)."""
    image = work.data / f"{name}.hex"
    made = json.loads(run(work.program, "compile", *CIRCLE, *arguments, "-o", image, "--json"))
    return made, json.loads(run(work.program, "feel", image, "--places", 4, "--json"))


def over_threshold(felt):
    return np.mean([place["verdict"]["over_db"] for place in felt["places"]])


def shapes_strength(work, name):
    """A circle of 40 mm, 130 mm above the tile, drawn at speeds, with spacings and with dwells."""
    figure, axes = panels(3, (15, 4.6))
    speeds = (2, 3, 4, 5, 6, 7, 8, 9, 10, 12)
    runs = [drawn(work, f"speed-{v}", "--points", 150, "--speed", v) for v in speeds]
    axes[0].plot(speeds, [felt["mean_pa"] for _, felt in runs], "o-", label="mean radiation pressure / Pa")
    axes[0].plot(speeds, [over_threshold(felt) for _, felt in runs], "s-", label="vibration over the least felt / dB")
    gains = [felt["wave_gain"] for _, felt in runs]
    axes[0].plot(speeds, [10 * gain for gain in gains], "^--", label="10 × deflection by waves in the skin")
    axes[0].set(xlabel="speed / (m/s)", title="150 points, at a speed")
    counts = (8, 12, 18, 30, 60, 120, 240, 359)
    spaced = [drawn(work, f"points-{n}", "--points", n, "--speed", 7) for n in counts]
    spacing = LENGTH_MM / np.array(counts)
    axes[1].semilogx(spacing, [100 * made["pressure_left_mean"] for made, _ in spaced], "o-", label="pressure left by the bandwidth / %")
    axes[1].semilogx(spacing, [felt["noise"]["relative_db"] for _, felt in spaced], "s-", label="audible noise / dB(A)")
    axes[1].set(xlabel="spacing / mm", title="7 m/s, with more points")
    dwells = (1, 2, 3, 5, 8, 13, 20, 40)
    held = [drawn(work, f"dwell-{n}", "--points", 40, "--rate", 1000 / n) for n in dwells]
    axes[2].semilogx(dwells, [100 * made["pressure_left_mean"] for made, _ in held], "o-", label="pressure left by the bandwidth / %")
    axes[2].semilogx(dwells, [felt["noise"]["relative_db"] for _, felt in held], "s-", label="audible noise / dB(A)")
    axes[2].set(xlabel="dwell / carrier periods", title="40 points, 3.1 mm apart, each held")
    for panel in axes:
        panel.grid(alpha=0.3)
        legend(panel)
    save(work, figure, name)
    best = speeds[int(np.argmax(gains))]
    return [
        row("speed at which the skin's waves lift it most", best, "m/s", 7.0, "text", "the membrane's waves travel at 6 m/s by our choice; the paper has a rule of thumb"),
        row("mean pressure at 12 m/s over that at 2 m/s", runs[-1][1]["mean_pa"] / runs[0][1]["mean_pa"], why="the time-averaged pressure does not depend on the speed, but for the bandwidth"),
        row("pressure left at a spacing of 0.35 mm and 7 m/s", 100 * spaced[-1][0]["pressure_left_mean"], "%"),
        row("pressure left at a spacing of 15.7 mm and 7 m/s", 100 * spaced[0][0]["pressure_left_mean"], "%", why="each point is held for 2.2 ms"),
        row("pressure left with 3.1 mm and 1 period each", 100 * held[0][0]["pressure_left_mean"], "%"),
        row("pressure left with 3.1 mm and 40 periods each", 100 * held[-1][0]["pressure_left_mean"], "%"),
        row("noise at a spacing of 15.7 mm over that at 0.35 mm", spaced[0][1]["noise"]["relative_db"] - spaced[-1][1]["noise"]["relative_db"], "dB", why="phases step farther from point to point"),
    ]


OBJECTS = ("cube", "sphere", "cone", "cylinder")
JOINTS = ("mcpPosition", "pipPosition", "dipPosition", "tipPosition")


def still_hand(path, frames):
    """A recording of a hand that does not move: five fingers, 5 mm deep in the upper face of a cube of 80 mm at 160 mm."""
    fingers = [{"id": k, "handId": 1, "type": k, "width": 16.0, **{name: [20.0 * (k - 2), 195.0, -10.0 - 25.0 * i] for i, name in enumerate(JOINTS)}} for k in range(5)]
    palm = {"id": 1, "type": "right", "palmPosition": [0.0, 195.0, 60.0], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}
    moments = [{"id": n, "timestamp": 1_000_000 + round(1e6 * n / 110), "hands": [palm], "pointables": fingers} for n in range(frames)]
    path.write_text(json.dumps({"frames": moments}), encoding="utf-8")


def rendered(work, thing, algorithm, *arguments):
    """What `render` says of each frame in which something is drawn."""
    path = work.data / f"{algorithm}.json"
    said = run(work.program, "render", thing, "--size", 80, "--algorithm", algorithm, *arguments, "-o", path, "--report", "--json")
    return [frame for frame in json.loads(said)["frames"] if frame["lines"]]


def mean_on_skin(work, algorithm):
    """Radiation pressure on the fingers' skin, averaged over time, of what was rendered last by an algorithm for the still hand, Pa."""
    places = [word for x in (-40, -20, 0, 20, 40) for y in (12, 20) for word in ("--at", f"{x},{y},187")]
    said = run(work.program, "feel", work.data / f"{algorithm}.json", "--array", "tile-10x10", "--board", "tile-100-wide", "--hand", work.data / "still.json", *places, "--json")
    return sum(place["mean_pa"] for place in json.loads(said)["places"]) / (len(places) / 2)


def shapes_algorithms(work, name):
    """Lengths and estimated strengths of A, E, F and G on a hand that presses, and why G and F differ from the paper's judgement."""
    figure, axes = panels(2, (12, 4.6))
    kinds = {"A": ("A",), "E": ("E",), "F": ("F",), "G": ("G",), "G, larger circles": ("G", "--blob-palm", 60, "--blob-finger", 30)}
    frames = {(thing, kind): rendered(work, thing, words[0], "--hand", "synthetic:press", *words[1:])[14] for thing in OBJECTS for kind, words in kinds.items()}
    width = 0.8 / len(kinds)
    for axis, key, label in ((axes[0], "length_mm", "length of all lines / mm"), (axes[1], "strength_pa", "pressure on the lines, as estimated / Pa")):
        for i, kind in enumerate(kinds):
            axis.bar(np.arange(len(OBJECTS)) + (i - 2) * width, [frames[thing, kind][key] for thing in OBJECTS], width, label=kind)
        axis.set(title=label)
        axis.set_xticks(range(len(OBJECTS)), OBJECTS)
        axis.grid(alpha=0.3)
        legend(axis)
    save(work, figure, name)

    def over(kind, other, key="strength_pa"):
        return np.mean([frames[thing, kind][key] / frames[thing, other][key] for thing in OBJECTS])

    still_hand(work.data / "still.json", 22)
    still = []
    for thing in OBJECTS[:1] + OBJECTS[3:]:
        for algorithm in "EF":
            rendered(work, thing, algorithm, "--hand", work.data / "still.json", "--center", "0,0,160")
        still.append(mean_on_skin(work, "F") / mean_on_skin(work, "E"))
    return [
        row("strength of G over that of A, circles up to 25 mm", over("G", "A"), why="ours end where the palm does, and so one short circle has all of the power; the paper's lines of G are longer than others"),
        row("the same with circles up to 60 mm", over("G, larger circles", "A"), why="as long as the contour; the paper prints no measure"),
        row("lines of F over those of E", over("F", "E", "lines"), why="skin aslant in the lattice cuts more cubes than it has squares"),
        row("strength of F over that of E, as estimated", over("F", "E"), why="P·w/L is of lines farther apart than the focus is wide"),
        row("pressure on the skin over time, F over E, cube and cylinder", np.mean(still), why="lines 6 mm apart under a focus of 16 mm: both fill the same skin evenly"),
    ]
