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
    return np.mean([place["lines"][0]["over_db"] for place in felt["places"]])


def shapes_strength(work, name):
    """A circle of 40 mm, 130 mm above the tile, drawn at speeds, with spacings and with dwells."""
    figure, axes = panels(3, (15, 4.6))
    speeds = (2, 3, 4, 5, 6, 7, 8, 9, 10, 12)
    runs = [drawn(work, f"speed-{v}", "--points", 150, "--speed", v) for v in speeds]
    axes[0].plot(speeds, [felt["mean_pa"] for _, felt in runs], "o-", label="mean radiation pressure / Pa")
    axes[0].plot(speeds, [over_threshold(felt) for _, felt in runs], "s-", label="strongest line over the least felt / dB")
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
