#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws how a cube was placed, for `haptogram robot place -o x.png`: its height, what the ultrasound told of it, with what
was measured at the board's pins, and the forces.

plot_placed.py FOLDER PICTURE, with rows.csv and report.json in the folder as the program writes them.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BLUE, RED, GREEN = "#174a7c", "#c0392b", "#2c7a4b"


def told(panel, rows, report):
    """What the mapping changes with the height, and the same at the pins where the board played a frame."""
    time, felt, pins = rows["time_s"], rows["frequency_hz"] > 0, report["pins"]
    at = [pin["time_s"] for pin in pins]
    if report["mapping"] == "G1":
        panel.plot(time[felt], rows["line_mm"][felt], ".", ms=3, color=BLUE, label="where the plane cuts the palm")
        panel.axhline(0, color="#666666", lw=0.8, ls=":")
        panel.set(ylabel="along the palm / mm", title="ultrasound: the plane on the palm, from its centre towards the fingers")
        for pin in pins:
            panel.annotate(f"{pin['frequency_hz_at_pins']:.0f} Hz", (pin["time_s"], 0.03), xycoords=("data", "axes fraction"), fontsize=8, color=RED, ha="center")
        return
    name, unit = ("frequency_hz", "Hz") if report["mapping"] == "G2" else ("magnitude", "")
    panel.plot(time, np.where(felt, rows[name], np.nan), color=BLUE, label="asked")
    measured = [pin["frequency_hz_at_pins"] if unit else pin["points"][0]["magnitude_at_pins"] for pin in pins if pin["points"]]
    panel.plot(at, measured, "o", ms=6, mfc="none", color=RED, label="by the pulses at the board's pins")
    panel.set(ylabel="frequency / Hz" if unit else "perceived magnitude", title="ultrasound: a focus on the palm")


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    rows = np.atleast_1d(np.genfromtxt(folder / "rows.csv", delimiter=",", names=True))
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    figure, (height, cue, force) = plt.subplots(3, 1, figsize=(10, 9), sharex=True, constrained_layout=True)
    time = rows["time_s"]
    height.plot(time, rows["height_mm"], color=BLUE, label="the cube")
    height.plot(time, rows["wanted_mm"], color=BLUE, lw=0.8, ls="--", label="where the hand wants it")
    height.axhline(report["target_mm"], color=RED, lw=0.8, ls=":", label="the height to find")
    found = f"placed after {report['time_s']:.2f} s, {report['error_mm']:+.2f} mm off" if report["placed"] else "not placed"
    height.set(ylabel="height above the array / mm", title=f"mapping {report['mapping']}, {report['array']} and {report['robot']}: {found}")
    told(cue, rows, report)
    force.plot(time, rows["user_n"], color=BLUE, label="the user holds")
    force.plot(time, rows["measured_n"], color=GREEN, lw=0.8, ls="--", label="what the controller takes it for")
    force.plot(time, -rows["scene_n"], color=RED, lw=0.8, ls=":", label="the cube's weight, rendered by the cables")
    force.set(ylabel="vertical force / N", xlabel="time / s", title="cables")
    for panel in (height, cue, force):
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8, loc="best")
    figure.savefig(output, dpi=100, format="png")


if __name__ == "__main__":
    main()
