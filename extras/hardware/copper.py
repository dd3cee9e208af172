# SPDX-License-Identifier: Apache-2.0
"""Connections as a factory gets them: from the shapes of the Gerber files and the holes of the drill file alone.

pads.csv tells where which pin is, and of no nets. What hangs together is a netlist again, which the rules of netlist.py judge."""
import collections
import csv
import warnings
from pathlib import Path

import netlist
import shapely
from gerbonara import ExcellonFile, GerberFile
from gerbonara import graphic_primitives as primitives
from shapely import affinity, ops, strtree

LAYERS = ["F_Cu", "In1_Cu", "In2_Cu", "B_Cu"]
LEAST = 0.15  # mm between two nets, and of copper around a hole: what cheap factories make
PLATING = 0.02


def shape(p):
    if isinstance(p, primitives.Circle):
        return shapely.Point(p.x, p.y).buffer(p.r, 16)
    if isinstance(p, primitives.Line | primitives.Arc):
        return shapely.LineString([(p.x1, p.y1), (p.x2, p.y2)]).buffer(p.width / 2, 8)
    if isinstance(p, primitives.Rectangle):
        box = shapely.box(p.x - p.w / 2, p.y - p.h / 2, p.x + p.w / 2, p.y + p.h / 2)
        return affinity.rotate(box, p.rotation, use_radians=True)
    return shapely.Polygon(p.outline).buffer(0)


def pieces_of(path):
    """The copper of a layer, in pieces that hang together."""
    drawn = {True: [], False: []}
    for thing in GerberFile.open(path).objects:
        for p in thing.to_primitives("mm"):
            drawn[p.polarity_dark].append(shape(p))
    copper = ops.unary_union(drawn[True])
    if drawn[False]:
        copper = copper.difference(ops.unary_union(drawn[False]))
    return list(getattr(copper, "geoms", [copper]))


class Copper:
    """All layers, joined by the holes."""

    def __init__(self, folder, layers=None):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of gerbonara, on KiCad's comments
            self.layers = layers or {n: pieces_of(folder / f"driver-tile-{n}.gbr") for n in LAYERS}
            holes = list(ExcellonFile.open(folder / "driver-tile.drl").objects)
        self.trees = {n: strtree.STRtree(pieces) for n, pieces in self.layers.items()}
        self.parent = {}
        for hole in holes:
            wall = shapely.Point(hole.x, hole.y).buffer(hole.aperture.diameter / 2 + PLATING)
            hit = [(n, int(i)) for n in LAYERS for i in self.trees[n].query(wall, predicate="intersects")]
            for other in hit[1:]:
                if self.root(other) != self.root(hit[0]):
                    self.parent[self.root(other)] = self.root(hit[0])

    def root(self, piece):
        while piece in self.parent:
            piece = self.parent[piece]
        return piece

    def under(self, x, y, layer):
        found = self.trees[layer].query(shapely.Point(x, y), predicate="intersects")
        return self.root((layer, int(found[0]))) if len(found) else None

    def least(self):
        """Distance in mm of those two pieces of different nets that are nearest on a layer, up to 0.4."""
        least = 0.4
        for layer, pieces in self.layers.items():
            a, b = self.trees[layer].query(pieces, predicate="dwithin", distance=0.4)
            for i, j in zip(a, b):
                if i < j and self.root((layer, int(i))) != self.root((layer, int(j))):
                    least = min(least, pieces[i].distance(pieces[j]))
        return least


def netlist_of(copper, pads, parts):
    """Pins that the copper joins; elements are where the middles of their pads are, from the array's centre."""
    nets, legs, lines = collections.defaultdict(list), collections.defaultdict(list), []
    with open(pads, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            x, y = float(row["x_mm"]), float(row["y_mm"])
            piece = copper.under(x, y, "F_Cu" if row["side"] == "front" else "B_Cu")
            if piece is None:
                lines.append(f"{row['ref']}.{row['pin']}: no copper at {x}, {y}")
            else:
                nets[piece].append([row["ref"], row["pin"]])
            if parts[row["ref"]]["kind"] == "element":
                legs[row["ref"]].append((x, y))
    middles = {ref: [sum(v) / 2 for v in zip(*ends)] for ref, ends in legs.items()}
    centre = [sum(v) / len(middles) for v in zip(*middles.values())]
    parts = {r: p | {"at": [round(m - c, 3) + 0.0 for m, c in zip(middles[r], centre)]} if r in middles else dict(p) for r, p in parts.items()}
    joined = {f"copper {n}": nodes for n, nodes in enumerate(nets.values()) if len(nodes) > 1}
    return {"parts": parts, "nets": joined}, lines


def faults(copper, pads, net, expected):
    """Lines of what is wrong: rules of the netlist that the copper breaks, and copper that is too near."""
    found, lines = netlist_of(copper, pads, net["parts"])
    lines += netlist.faults(found, expected)
    least = copper.least()
    return lines + [f"{least:.3f} mm between two nets: expected {LEAST}"] * (least < LEAST), found


def _lose_a_line(text, rng):
    """One drawn line, as if the file was damaged: the move to its start is left."""
    drawn = [i for i, line in enumerate(text) if line.endswith("D01*")]
    text.pop(rng.choice(drawn))


def _widen_a_tool(text, rng):
    """Tracks of 0.18 mm drawn with one of 0.9 mm."""
    at = next(i for i, line in enumerate(text) if line.startswith("%ADD") and "C,0.18" in line)
    text[at] = text[at].replace("C,0.18", "C,0.9")


def _lose_a_hole(text, rng):
    text.pop(rng.choice([i for i, line in enumerate(text) if line.startswith("X")]))


def _shift(text, rng):
    """A layer that is 0.7 mm beside the others."""
    for i, line in enumerate(text):
        if line.startswith("X") and "Y" in line:
            x, rest = line[1:].split("Y", 1)
            text[i] = f"X{int(x) + 700000}Y{rest}"


PLANTED = [("B_Cu.gbr", _lose_a_line), ("F_Cu.gbr", _lose_a_line), ("F_Cu.gbr", _widen_a_tool), ("B_Cu.gbr", _shift), ("drl", _lose_a_hole), ("drl", _lose_a_hole)]


def planted(folder, scratch, copper, pads, net, expected, rng):
    """How many damaged files are noticed. Layers that are not damaged are not read again."""
    noticed = 0
    for name, damage in PLANTED:
        scratch.mkdir(parents=True, exist_ok=True)
        for source in folder.iterdir():
            (scratch / source.name).write_bytes(source.read_bytes())
        file = next(f for f in scratch.iterdir() if f.name.endswith(name))
        text = file.read_text(encoding="utf-8").splitlines()
        damage(text, rng)
        file.write_text("\n".join(text) + "\n", encoding="utf-8")
        layers = dict(copper.layers)
        if name != "drl":
            layer = name.removesuffix(".gbr")
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                layers[layer] = pieces_of(file)
        lines, _ = faults(Copper(scratch, layers), pads, net, expected)
        noticed += bool(lines)
    return noticed, len(PLANTED)
