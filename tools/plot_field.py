#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws a field: `haptogram field -o x.png` calls it with a folder that holds field.npy and about.json, and the picture's
name. Scripts call draw() with several such fields."""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

AXES = {"x": 0, "y": 1, "z": 2, "u": 0, "v": 1}
NEAR_MM = 3.0  # points this near to the plane are drawn as lying in it
NEAR_FIELD_MM = 30.0  # below it the pressure is that of one element, not of the focus


def marks_of(panel, about, u_name, v_name):
    """The asked points, those in the plane stronger than those elsewhere."""
    marks = np.asarray(about["marks_mm"]).reshape(-1, 3)
    # An oblique plane lies at 0 in its own coordinates, in which its marks are.
    fixed_name, fixed = ("z", 0.0) if about["axes"] == "uv" else about["region"].split("@")[1].split("=")
    across = abs(marks[:, AXES[fixed_name]] - float(fixed)) <= NEAR_MM
    for chosen, alpha, label in ((~across, 0.25, "asked points elsewhere"), (across, 0.95, "asked points in this plane")):
        if chosen.any():
            points = marks[chosen]
            panel.plot(points[:, AXES[u_name]], points[:, AXES[v_name]], "o", ms=3.2, mfc="none", mec="#5fe3ff", mew=0.8, alpha=alpha, label=label)
    if len(marks):
        panel.legend(loc="upper right", fontsize=8, framealpha=0.7)


def plane(figure, panel, field, about):
    u_name, v_name = about["axes"]
    u, v = np.asarray(about[f"{u_name}_mm"]), np.asarray(about[f"{v_name}_mm"])
    scaled = field[v > NEAR_FIELD_MM] if v_name == "z" and (v > NEAR_FIELD_MM).any() else field
    lowest = np.nanmin(field) if "dB" in about["label"] else 0.0
    image = panel.pcolormesh(u, v, field, cmap="magma", vmin=lowest, vmax=np.nanmax(scaled), shading="nearest", rasterized=True)
    marks_of(panel, about, u_name, v_name)
    panel.set(xlabel=f"{u_name} / mm", ylabel=f"{v_name} / mm", title=f"{about['region']} mm", aspect="equal")
    figure.colorbar(image, ax=panel, label=about["label"], shrink=0.85)


def line(panel, field, about):
    (name,) = about["axes"]
    panel.plot(about[f"{name}_mm"], field)
    for mark in about["marks_mm"] if len(about["marks_mm"]) <= 4 else ():
        panel.axvline(mark[AXES[name]], color="#999999", lw=0.8, ls=":")
    panel.set(xlabel=f"{name} / mm", ylabel=about["label"], title=f"{about['region']} mm")
    panel.grid(alpha=0.3)


def read_csv(path, region, label, marks_mm):
    """A plane that `haptogram field` wrote as CSV, as draw() wants it."""
    u_name, v_name = region[:2]
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    u, v = np.unique(table[:, 0]), np.unique(table[:, 1])
    about = {"axes": region[:2], "region": region, "label": label, "marks_mm": marks_mm, f"{u_name}_mm": u, f"{v_name}_mm": v}
    return table[:, 2].reshape(len(v), len(u)), about


def draw(fields, title, output):
    """fields: (array, about) pairs, a panel each."""
    figure, panels = plt.subplots(1, len(fields), figsize=(7.0 * len(fields), 6.2), constrained_layout=True)
    for panel, (field, about) in zip(np.atleast_1d(panels), fields):
        if len(about["axes"]) == 2:
            plane(figure, panel, field, about)
        else:
            line(panel, field, about)
    figure.suptitle(title)
    figure.savefig(output, dpi=110, format="png")
    plt.close(figure)


def main():
    folder, output = pathlib.Path(sys.argv[1]), sys.argv[2]
    about = json.loads((folder / "about.json").read_text(encoding="utf-8"))
    draw([(np.load(folder / "field.npy"), about)], about["title"], output)


if __name__ == "__main__":
    main()
