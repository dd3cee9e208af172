# SPDX-License-Identifier: Apache-2.0
"""The board from both sides, drawn from its Gerbers."""
import matplotlib

matplotlib.use("Agg")
import copper  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

SIDES = [("front: wires and elements", ["F_Cu", "F_SilkS"], False), ("back: drivers, supply", ["B_Cu"], True)]
COLOURS = {"F_Cu": "#b5651d", "B_Cu": "#b5651d", "F_SilkS": "#222222"}


def draw(gerbers, path):
    figure, axes = plt.subplots(1, 2, figsize=(9, 6.6), dpi=110)
    for side, (title, layers, turned) in zip(axes, SIDES):
        for layer in layers:
            pieces = copper.pieces_of(gerbers / f"driver-tile-{layer}.gbr")
            outlines = [list(p.exterior.coords) for p in pieces if not p.is_empty]
            side.add_collection(PolyCollection(outlines, facecolors=COLOURS[layer], edgecolors="none"))
        edge = copper.pieces_of(gerbers / "driver-tile-Edge_Cuts.gbr")
        for p in edge:
            side.plot(*p.exterior.xy, color="black", linewidth=0.5)
        side.set_aspect("equal")
        side.axis("off")
        if turned:
            side.invert_xaxis()
        side.set_title(title, fontsize=9)
    figure.tight_layout()
    beside = path.with_name(path.stem + ".part.png")
    figure.savefig(beside)
    plt.close(figure)
    beside.replace(path)
