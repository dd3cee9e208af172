#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws radiation pressure on the skin of a body: `haptogram scatter -o x.png` calls it with a folder that holds surface.json, and the
picture's name."""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402


def unit(v):
    return v / np.linalg.norm(v)


def view_axes(view, up):
    """Right and up on the picture of somebody who looks along `view`."""
    up = unit(up - view * (up @ view))
    return np.cross(view, up), up


def paint(panel, vertices, triangles, values, view, up, limits, foci=(), cmap="inferno"):
    """The surface as seen along `view`, nearest triangles last; foci as asterisks."""
    right, up = view_axes(unit(np.asarray(view, float)), np.asarray(up, float))
    view = unit(np.asarray(view, float))
    corners = vertices[triangles]
    towards = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ view < 0
    corners, values = corners[towards], values[towards]
    order = np.argsort(-(corners.mean(axis=1) @ view))
    flat = np.stack([corners @ right, corners @ up], axis=-1)[order]
    surface = PolyCollection(flat, array=values[order], cmap=cmap, clim=limits, edgecolors="face", linewidths=0.3, rasterized=True)
    panel.add_collection(surface)
    for focus in np.atleast_2d(foci) if len(foci) else []:
        panel.plot(focus @ right, focus @ up, "*", color="#35d0ba", mec="black", mew=0.4, ms=8)
    panel.set(aspect="equal", facecolor="#dddddd")
    panel.autoscale_view()
    return surface


def main():
    folder, picture = pathlib.Path(sys.argv[1]), sys.argv[2]
    surface = json.loads((folder / "surface.json").read_text(encoding="utf-8"))
    vertices, triangles = np.array(surface["vertices_mm"]), np.array(surface["triangles"])
    values, force = np.array(surface["radiation_pa"]), np.array(surface["force_mn"])
    foci = np.array(surface["foci_mm"])
    centred = vertices - vertices.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1]
    length = axes[:, 2] * (1 if axes[np.argmax(abs(axes[:, 2])), 2] > 0 else -1)
    push = force if np.linalg.norm(force) > 0 else np.array([0.0, 0.0, 1.0])
    if abs(unit(push) @ length) > 0.95:  # pushed along its length: seen from there, the next axis is upright
        length = axes[:, 1]
    figure, panels = plt.subplots(1, 2, figsize=(8.5, 5.6), constrained_layout=True)
    limits = (min(0.0, values.min()), values.max())
    for panel, view, name, shown in ((panels[0], push, "from the side that is pushed", foci), (panels[1], -push, "from the other side", ())):
        drawn = paint(panel, vertices, triangles, values, view, length, limits, shown)
        panel.set(xlabel="mm", ylabel="mm", title=name)
    figure.colorbar(drawn, ax=panels, label="mean radiation pressure / Pa", shrink=0.85)
    figure.suptitle(f"{surface['title']}\nforce {np.linalg.norm(force):.2f} mN", fontsize=10)
    figure.savefig(picture, dpi=110, format="png")


if __name__ == "__main__":
    main()
