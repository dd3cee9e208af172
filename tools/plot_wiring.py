#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws which pin of which connector drives which element, for `haptogram board pinout BOARD -o x.svg`.

plot_wiring.py FOLDER PICTURE, with pinout.json in the folder as the program writes it. The array is seen from where it is wired:
from behind, with x to the left. Each element has the colour of its connector, and the number of its pin.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    pinout = json.loads((folder / "pinout.json").read_text(encoding="utf-8"))
    rows = pinout["outputs"]
    connectors = list(dict.fromkeys(row["connector"] for row in rows))
    colours = {name: plt.cm.tab20(i % 20) for i, name in enumerate(connectors)}

    figure, (array, table) = plt.subplots(1, 2, figsize=(17, 10), width_ratios=[10, 7], constrained_layout=True)
    distances = [((a["x_mm"] - b["x_mm"]) ** 2 + (a["y_mm"] - b["y_mm"]) ** 2) ** 0.5 for i, a in enumerate(rows) for b in rows[:i]]
    radius = 0.47 * min(distances, default=10)
    for row in rows:
        place = (-row["x_mm"], row["y_mm"])
        array.add_patch(plt.Circle(place, radius, color=colours[row["connector"]], alpha=0.55))
        array.annotate(f"{row['connector']}\n{row['pin']}", place, ha="center", va="center", fontsize=7)
    array.set(title=f"{pinout['array']} from behind, where it is wired: connector and pin of each element", xlabel="x / mm: from behind, so to the left", ylabel="y / mm")
    array.set_aspect("equal")
    array.autoscale_view()
    array.set_xticks(array.get_xticks(), [f"{0.0 - tick:g}" for tick in array.get_xticks()])
    array.grid(alpha=0.2)

    # A column a connector: pin, net and channel.
    table.axis("off")
    table.set_title(f"{pinout['board']}: pin, net, channel")
    across = 4
    down = (len(connectors) + across - 1) // across
    most = max(sum(row["connector"] == name for row in rows) for name in connectors)
    for i, name in enumerate(connectors):
        left, top = i % across / across, 1 - i // across / down
        table.text(left, top, name, transform=table.transAxes, va="top", fontsize=10, weight="bold", color=[0.7 * c for c in colours[name][:3]])
        own = [row for row in rows if row["connector"] == name]
        step = 1 / down / (most + 2)
        for line, row in enumerate(own, 1):
            table.text(left, top - line * step, f"{row['pin']:>3}  {row['net']:<5} {row['channel']:>3}", transform=table.transAxes, va="top", fontsize=min(9, 500 * step), family="monospace")
    figure.savefig(output, format="svg")


if __name__ == "__main__":
    main()
