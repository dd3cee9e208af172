#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what was measured of each element of an array, for `haptogram calibrate fit … --picture x.png`.

plot_calibration.py FOLDER PICTURE, with elements.json in the folder as the program writes it. The array is seen from the hand.
An element's size is its gain, its colour its phase; reversed ones have a minus, dead ones a cross, and those on another channel its number.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    elements = json.loads((folder / "elements.json").read_text(encoding="utf-8"))
    alive = [e for e in elements if not e["dead"]]
    distances = [((a["x_mm"] - b["x_mm"]) ** 2 + (a["y_mm"] - b["y_mm"]) ** 2) ** 0.5 for i, a in enumerate(elements) for b in elements[:i]]
    radius = 0.36 * min(distances, default=10)
    most = max((abs(e["phase_deg"]) for e in alive), default=1.0)
    colour = plt.cm.ScalarMappable(plt.Normalize(-most, most), "coolwarm")

    figure, axes = plt.subplots(figsize=(8, 7), constrained_layout=True)
    for e in elements:
        place = (e["x_mm"], e["y_mm"])
        if e["dead"]:
            axes.plot(*place, "kx", markersize=9, markeredgewidth=2)
        else:
            axes.add_patch(plt.Circle(place, radius * e["gain"], facecolor=colour.to_rgba(e["phase_deg"]), edgecolor="0.4"))
        if e["reversed"]:
            axes.plot([place[0] - 0.5 * radius, place[0] + 0.5 * radius], [place[1]] * 2, "k", linewidth=2)
        if e["channel"] != e["element"]:
            axes.annotate(str(e["channel"]), place, ha="center", va="bottom", fontsize=8, weight="bold")
    dead, reversed_, moved = (sum(1 for e in elements if test(e)) for test in (lambda e: e["dead"], lambda e: e["reversed"], lambda e: e["channel"] != e["element"]))
    axes.set(title=f"{len(elements)} elements: {dead} dead (cross), {reversed_} reversed (minus), {moved} on another channel (its number)", xlabel="x / mm", ylabel="y / mm")
    axes.title.set_fontsize(10)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.grid(alpha=0.2)
    figure.colorbar(colour, ax=axes, label="phase / degrees; the size is the gain")
    figure.savefig(output, dpi=100, format=pathlib.Path(output).suffix[1:] if pathlib.Path(output).suffix in (".png", ".svg") else "png")


if __name__ == "__main__":
    main()
