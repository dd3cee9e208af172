#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws a cable robot's workspace or a trace of its handle, for `haptogram robot workspace|simulate -o x.png`.

plot_robot.py FOLDER PICTURE: the folder holds table.csv, which the program writes as .csv, too, and the lines of words.txt:
"workspace" and a title, or "trace", INNER,MIDDLE,OUTER and a line TIME:EVENT for each event.
"""

import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402


def workspace(table, title, output):
    axes = [np.unique(table[name]) for name in ("x_mm", "y_mm", "z_mm")]
    useful = table["useful"].reshape([len(axis) for axis in reversed(axes)]).astype(bool).transpose(2, 1, 0)
    step = axes[0][1] - axes[0][0] if len(axes[0]) > 1 else 1.0
    edges = [np.append(axis - step / 2, axis[-1] + step / 2) for axis in axes]
    figure = plt.figure(figsize=(16, 5.5))
    solid = figure.add_axes([0.0, 0.05, 0.31, 0.85], projection="3d")
    if useful.any():
        solid.voxels(*np.meshgrid(*edges, indexing="ij"), useful, facecolors="#4c9f70", edgecolors="#2c5f43", linewidth=0.3)
    limits = [(edge[0], edge[-1]) for edge in edges]
    solid.set(xlabel="x / mm", ylabel="y / mm", zlabel="z / mm", xlim=limits[0], ylim=limits[1], zlim=limits[2], box_aspect=[np.ptp(e) for e in edges])
    for left, across, (u, v), name in ((0.38, 2, (0, 1), "from above"), (0.71, 1, (0, 2), "from the side")):
        panel = figure.add_axes([left, 0.1, 0.26, 0.78])
        depth = useful.sum(axis=across) * step
        image = panel.pcolormesh(edges[u], edges[v], np.where(depth > 0, depth, np.nan).T, cmap="viridis", vmin=0)
        panel.set(xlabel=f"{'xyz'[u]} / mm", ylabel=f"{'xyz'[v]} / mm", title=name, aspect="equal", xlim=limits[u], ylim=limits[v])
        figure.colorbar(image, ax=panel, label=f"useful depth along {'xyz'[across]} / mm", shrink=0.8)
    figure.suptitle(title)
    figure.savefig(output, dpi=100, format="png")


def trace(table, radii, events, output):
    figure, (place, force, tension) = plt.subplots(3, 1, figsize=(11, 9), sharex=True, constrained_layout=True)
    time = table["time_s"]
    for axis, colour in zip("xyz", ("#c44e52", "#55a868", "#4c72b0")):
        place.plot(time, table[f"{axis}_mm"], color=colour, label=axis)
        place.plot(time, table[f"wanted_{axis}_mm"], color=colour, lw=0.8, ls="--")
        force.plot(time, table[f"user_{axis}_n"], color=colour, label=axis)
        force.plot(time, table[f"measured_{axis}_n"], color=colour, lw=0.8, ls="--")
    farthest = max(abs(table[f"{axis}_mm"]).max() for axis in "xyz")
    for number, radius in enumerate(radii, 1):
        for sign in (1, -1):
            if radius <= 1.3 * farthest:
                place.axhline(sign * radius, color="#999999", lw=0.7, ls=":")
        if radius <= 1.3 * farthest:
            place.text(time[-1], radius, f"Z{number}", va="top", ha="right", color="#777777", fontsize=8)
    for number in range(1, 9):
        tension.plot(time, table[f"tension_{number}_n"], lw=0.9, label=str(number))
    for panel in (place, force, tension):
        for at, _ in events:
            panel.axvline(at, color="#d62728", lw=0.9)
        panel.grid(alpha=0.3)
    for number, (at, name) in enumerate(events):  # one below the other, because they come close together
        place.text(at, 0.92 - 0.1 * (number % 8), f" {name}, {at:g} s", transform=place.get_xaxis_transform(), color="#d62728", fontsize=8)
    place.set(ylabel="place / mm", title="handle, and dashed the virtual body")
    force.set(ylabel="force / N", title="user, and dashed what the controller measures")
    tension.set(ylabel="tension / N", xlabel="time / s", title="cables")
    tension.set_ylim(0, 1.25 * tension.get_ylim()[1])
    for panel, columns in ((place, 1), (force, 1), (tension, 8)):
        panel.legend(loc="upper left", fontsize=8, ncol=columns)
    figure.savefig(output, dpi=100, format="png")


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    kind, *words = (folder / "words.txt").read_text(encoding="utf-8").splitlines()
    table = np.genfromtxt(folder / "table.csv", delimiter=",", names=True)
    if kind == "workspace":
        workspace(table, words[0], output)
    else:
        events = [word.split(":", 1) for word in words[1:]]
        trace(np.atleast_1d(table), [float(r) for r in words[0].split(",")], [(float(at), name) for at, name in events], output)


if __name__ == "__main__":
    main()
