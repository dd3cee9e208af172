#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws several foci and how even they are: `haptogram solve -o x.png` calls it with a folder that holds solved.json, and
field.npy and about.json of the first set of foci, and the picture's name."""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
import plot_field  # noqa: E402  beside this file

COLOURS = {"exact": "#3b6fb6", "quantised": "#e08a3c"}
LABELS = {"exact": "exact phases", "quantised": "phases in ticks"}


def foci(panel, step):
    """Each focus' pressure, beside one another for exact phases and for those that the board can play."""
    count = len(step["foci"])
    at = np.arange(1, count + 1)
    for offset, which in ((-0.2, "exact"), (0.2, "quantised")):
        quality = step["quality"][which]
        label = f"{LABELS[which]}: spread {100 * quality['spread']:.2g} %, efficiency {quality['efficiency']:.3f}"
        panel.bar(at + offset, quality["pressure_pa"], width=0.4, color=COLOURS[which], label=label)
    panel.set(xlabel="focus", ylabel="pressure amplitude / Pa", title="set 1: pressure at each focus")
    panel.set_xticks(at if count <= 20 else at[:: int(np.ceil(count / 16))])
    panel.set_ylim(0, 1.25 * max(max(step["quality"][w]["pressure_pa"]) for w in COLOURS))
    panel.legend(loc="upper right", fontsize=8)


def over_sets(panel, steps):
    at = np.arange(1, len(steps) + 1)
    for which, colour in COLOURS.items():
        panel.plot(at, [100 * s["quality"][which]["spread"] for s in steps], color=colour, label=f"spread, {LABELS[which]}")
    panel.set(xlabel="set of foci", ylabel="spread / %", title="all sets")
    panel.set_ylim(bottom=0)
    right = panel.twinx()
    right.plot(at, [s["quality"]["quantised"]["efficiency"] for s in steps], color="#777777", ls="--", label="efficiency (right)")
    right.set_ylim(0, 1.1)
    right.set_ylabel("efficiency")
    lines = panel.get_lines() + right.get_lines()
    panel.legend(lines, [line.get_label() for line in lines], loc="center right", fontsize=8)
    panel.grid(alpha=0.3)


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    solved = json.loads((folder / "solved.json").read_text(encoding="utf-8"))
    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    steps = solved["steps"]
    count = 2 if len(steps) == 1 else 3
    figure, panels = plt.subplots(1, count, figsize=(6.6 * count, 5.8), constrained_layout=True)
    plot_field.plane(figure, panels[0], np.load(folder / "field.npy"), about)
    foci(panels[1], steps[0])
    if len(steps) > 1:
        over_sets(panels[2], steps)
    figure.suptitle(f"{solved['array']}, {len(steps[0]['foci'])} foci by {solved['solver']}")
    figure.savefig(output, dpi=110, format="png")
    plt.close(figure)


if __name__ == "__main__":
    main()
