#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws a scene of cables and ultrasound, for `haptogram robot explore` and `robot tell`: where the palm was, what the ultrasound
played, with what was measured at the board's pins, and the forces.

plot_scene.py FOLDER PICTURE, with rows.csv, report.json and title.txt in the folder as the program writes them.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BLUE, RED, GREEN = "#174a7c", "#c0392b", "#2c7a4b"


def ultrasound(panel, rows, pins):
    """Frequency on the left axis, perceived magnitude on the right, each with what the pins made."""
    time, felt = rows["time_s"], rows["frequency_hz"] > 0
    panel.plot(time, np.where(felt, rows["frequency_hz"], np.nan), color=BLUE, label="frequency asked")
    panel.plot([p["time_s"] for p in pins], [p["frequency_hz_at_pins"] for p in pins], "o", mfc="none", color=BLUE, label="at the board's pins")
    panel.set(ylabel="frequency / Hz", ylim=(0, 320), title="ultrasound")
    right = panel.twinx()
    right.plot(time, np.where(felt, rows["magnitude"], np.nan), color=RED, label="magnitude asked")
    at = [(p["time_s"], point["magnitude_at_pins"]) for p in pins for point in p["points"]]
    right.plot([a for a, _ in at], [b for _, b in at], "s", ms=4, mfc="none", color=RED, label="by the board's pins")
    right.plot(time, rows["points"], drawstyle="steps-post", lw=0.8, color="#888888", label="points")
    right.set(ylabel="perceived magnitude, points", ylim=(0, None))
    lines = [axis.get_legend_handles_labels() for axis in (panel, right)]
    panel.legend(lines[0][0] + lines[1][0], lines[0][1] + lines[1][1], fontsize=8, ncol=2, loc="best")


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    rows = np.atleast_1d(np.genfromtxt(folder / "rows.csv", delimiter=",", names=True))
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    figure, (place, sound, force) = plt.subplots(3, 1, figsize=(10, 9), sharex=True, constrained_layout=True)
    time = rows["time_s"]
    for axis, color in (("x", GREEN), ("y", "#888888")):
        place.plot(time, rows[f"{axis}_mm"], color=color, lw=1, label=axis)
    height = place.twinx()
    height.plot(time, rows["z_mm"], color=BLUE, label="height, on the right")
    height.set_ylabel("height above the array / mm")
    place.set(ylabel="x, y / mm", title="the palm")
    lines = [axis.get_legend_handles_labels() for axis in (place, height)]
    place.legend(lines[0][0] + lines[1][0], lines[0][1] + lines[1][1], fontsize=8, loc="best")
    ultrasound(sound, rows, report["pins"])
    for axis, color in (("x", GREEN), ("y", "#888888"), ("z", BLUE)):
        force.plot(time, rows[f"f{axis}_n"], color=color, label=f"the scene, {axis}")
        force.plot(time, -rows[f"user_{axis}_n"], color=color, lw=0.8, ls="--", label=f"the user's, against it, {axis}")
    force.set(ylabel="force / N", xlabel="time / s", title="cables")
    force.legend(fontsize=8, ncol=3, loc="best")
    for panel in (place, sound, force):
        panel.grid(alpha=0.3)
    figure.suptitle((folder / "title.txt").read_text(encoding="utf-8").strip())
    figure.savefig(output, dpi=100, format="png")


if __name__ == "__main__":
    main()
