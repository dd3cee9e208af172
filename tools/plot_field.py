# SPDX-License-Identifier: Apache-2.0
"""Draws fields that `haptogram field` wrote, with the asked points over them."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

NEAR_MM = 3.0  # points this near to the plane are drawn as lying in it


def read(path):
    """Axis names, the two axes in mm, and the field in Pa as rows along the second axis."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    u, v = np.unique(table[:, 0]), np.unique(table[:, 1])
    return names[0][0], names[1][0], u, v, table[:, 2].reshape(len(v), len(u))


def draw(fields, foci_mm, title, output):
    """fields: (plane such as "xy@z=130", CSV file) pairs, a panel each; foci_mm: the asked points."""
    foci = np.asarray(foci_mm)
    figure, panels = plt.subplots(1, len(fields), figsize=(7.0 * len(fields), 6.2), constrained_layout=True)
    for panel, (plane, path) in zip(np.atleast_1d(panels), fields):
        u_name, v_name, u, v, field = read(path)
        # Next to the elements the pressure is that of one element, not of the focus: leave it out of the scale.
        top = field[v > 30.0].max() if v_name == "z" else field.max()
        image = panel.pcolormesh(u, v, field, cmap="magma", vmin=0.0, vmax=top, shading="nearest", rasterized=True)
        axes = {"x": 0, "y": 1, "z": 2}
        across = abs(foci[:, axes[plane[3]]] - float(plane[5:])) <= NEAR_MM
        for chosen, alpha, label in ((~across, 0.25, "asked points elsewhere"), (across, 0.95, "asked points in this plane")):
            if chosen.any():
                points = foci[chosen]
                panel.plot(points[:, axes[u_name]], points[:, axes[v_name]], "o", ms=3.2, mfc="none", mec="#5fe3ff", mew=0.8, alpha=alpha, label=label)
        panel.set(xlabel=f"{u_name} / mm", ylabel=f"{v_name} / mm", title=f"{plane} mm", aspect="equal")
        panel.legend(loc="upper right", fontsize=8, framealpha=0.7)
        figure.colorbar(image, ax=panel, label="time-averaged radiation pressure / Pa", shrink=0.85)
    figure.suptitle(title)
    figure.savefig(output, dpi=110)
    plt.close(figure)
