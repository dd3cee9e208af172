#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws how a hand feels an object: `haptogram render -o x.png` calls it with a folder that holds touch.json, and the
picture's name. Each frame has the palm's view of the skin, coloured by the radiation pressure; the first one also stands
in space, with the object and the array."""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import EllipseCollection  # noqa: E402

COLOURS = {"contour": "#39d353", "feature": "#ff4d4d", "solid": "#4da6ff", "grain": "#39d353", "blob": "#ffb000", "pointer": "#ff4dff", "press": "#ffb000"}


def in_palm(points, frame):
    """Coordinates across and along the hand, mm, from the middle of the palm."""
    along = np.asarray(frame["direction"])
    across = np.cross(frame["normal"], along)
    away = np.asarray(points).reshape(-1, 3) - frame["palm_mm"]
    return away @ across, away @ along


def grid_mm(points):
    """The usual distance from a place of the skin to the nearest other one, mm."""
    points = np.asarray(points).reshape(-1, 3)
    some = points[:: max(1, len(points) // 200)]
    squares = ((some[:, None] - points[None]) ** 2).sum(-1)
    return float(np.sqrt(np.median(np.where(squares > 0.0, squares, np.inf).min(1))))


def palm_view(figure, panel, frame, most):
    # Discs as large as the skin's grid is wide, so that they close whatever the picture's scale.
    size = 1.5 * grid_mm(frame["points_mm"])
    places = np.column_stack(in_palm(frame["points_mm"], frame))
    skin = EllipseCollection(size, size, 0.0, units="xy", offsets=places, offset_transform=panel.transData, array=frame["radiation_pa"], cmap="magma", clim=(0.0, most),
                             linewidths=0, antialiased=False, rasterized=True)  # fmt: skip
    panel.add_collection(skin)
    panel.autoscale_view()
    seen = set()
    for line in frame["lines"]:
        kind = line["kind"]
        mark = "o" if len(line["points_mm"]) == 1 else ""
        panel.plot(*in_palm(line["points_mm"], frame), color=COLOURS[kind], lw=1.0, marker=mark, ms=4, label=None if kind in seen else kind)
        seen.add(kind)
    panel.set(aspect="equal", xlabel="across the hand / mm", ylabel="along the hand / mm")
    panel.set_title(f"frame {frame['frame']}, {frame['time_s']:.2f} s: {frame['length_mm']:.0f} mm at {frame['draw_hz']:.1f} Hz, cos² {frame['tilt']:.2f}", fontsize=9)
    panel.set_facecolor("#e8e8e8")
    if seen:
        panel.legend(loc="lower right", fontsize=7, framealpha=0.7)
    return skin


def in_space(panel, touch, frame, most):
    points = np.asarray(frame["points_mm"])[::3]
    panel.scatter(*points.T, c=np.asarray(frame["radiation_pa"])[::3], s=1.5, cmap="magma", vmin=0.0, vmax=most, linewidths=0, alpha=0.35, rasterized=True)
    for line in frame["lines"]:
        panel.plot(*np.asarray(line["points_mm"]).T, color=COLOURS[line["kind"]], lw=1.2)
    for edge in touch["edges_mm"]:
        panel.plot(*np.asarray(edge).T, color="#3b6fb6", lw=1.0)
    for part in touch["slices"]:
        count = part["across"]
        middles = (np.arange(count) + 0.5) / count
        low, high = np.asarray(part["low_mm"]), np.asarray(part["high_mm"])
        x, y = low[0] + (high[0] - low[0]) * middles, low[1] + (high[1] - low[1]) * middles
        distances = np.asarray(part["distances_mm"]).reshape(count, count)
        if distances.min() < 0.0 < distances.max():
            panel.contour(x, y, distances, levels=[0.0], zdir="z", offset=part["z_mm"], colors="#3b6fb6", linewidths=0.5, alpha=0.6)
    panel.scatter(*np.asarray(touch["elements_mm"]).T, s=3, color="#777777", linewidths=0)
    # All axes at one scale.
    spread = np.concatenate([points, np.asarray(touch["elements_mm"])])
    middle, half = (spread.min(0) + spread.max(0)) / 2, (spread.max(0) - spread.min(0)).max() / 2
    panel.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), zlim=(middle[2] - half, middle[2] + half))
    panel.set_box_aspect((1, 1, 1))
    panel.view_init(elev=-12, azim=-60)  # from below, where the palm is
    panel.set(xlabel="x / mm", ylabel="y / mm", zlabel="z / mm")
    panel.locator_params(nbins=4)
    panel.tick_params(labelsize=8)


def main():
    touch = json.loads((pathlib.Path(sys.argv[1]) / "touch.json").read_text(encoding="utf-8"))
    frames = touch["frames"]
    most = max(max(frame["radiation_pa"]) for frame in frames) or 1.0
    columns = 2 if len(frames) == 1 else 3
    rows = 1 if len(frames) == 1 else 1 + -(-len(frames) // columns)
    figure = plt.figure(figsize=(6.4 * columns, 6.0 * rows), constrained_layout=True)
    in_space(figure.add_subplot(rows, columns, 1, projection="3d"), touch, frames[0], most)
    panels = [figure.add_subplot(rows, columns, (2 if len(frames) == 1 else columns + 1) + i) for i in range(len(frames))]
    for panel, frame in zip(panels, frames):
        skin = palm_view(figure, panel, frame, most)
    figure.colorbar(skin, ax=panels, label="radiation pressure on the skin, mean over time / Pa", shrink=0.8)
    figure.suptitle(f"{touch['object']}, algorithm {touch['algorithm']}, {touch['array']}")
    figure.savefig(sys.argv[2], dpi=100, format="png")
    plt.close(figure)


if __name__ == "__main__":
    main()
