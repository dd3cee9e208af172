# SPDX-License-Identifier: Apache-2.0
"""Figures of the paper Fingers: radiation pressure on a finger that dips into a virtual surface, by boundary elements."""

import json
import xml.etree.ElementTree

import matplotlib.pyplot as plt
import numpy as np
from plot_scatter import paint

from .work import DPI, row, run

RADIUS, LENGTH = 8.0, 50.0  # mm; the paper's mesh is 5 cm of a real finger, of which it prints no more
EDGE = 1.16  # mm: 4300 triangles, where the paper has 4322
AXIS = np.array([0.0, -1.0, 1.0]) / np.sqrt(2)  # from the tip to the hand
PAD = np.array([0.0, -1.0, -1.0]) / np.sqrt(2)
SURFACE = 150.0  # height of the virtual surface, which is at the middle of the rig
DEPTHS = (1.0, 2.0, 4.0, 6.0)  # mm
OURS = "finger, arrangement of the units and depths are ours: the paper does not print them"


def tip(depth):
    """Centre of the round tip."""
    return np.array([0.0, 0.0, SURFACE + RADIUS - depth])


def outside(points, depth):
    """Distance from the finger's skin, negative inside."""
    along = np.clip((points - tip(depth)) @ AXIS, 0.0, LENGTH - 2 * RADIUS)
    return np.linalg.norm(points - tip(depth) - along[:, None] * AXIS, axis=1) - RADIUS


def section(depth, count=2000):
    """The line in which the surface cuts the finger, and its centre."""
    angles = 2 * np.pi * np.arange(count) / count
    ways = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    centre = np.array([0.0, 0.0, SURFACE])
    for _ in range(3):
        near, far = np.zeros(count), np.full(count, 40.0)
        for _ in range(50):
            middle = (near + far) / 2
            inside = outside(centre + middle[:, None] * ways, depth) < 0
            near, far = np.where(inside, middle, near), np.where(inside, far, middle)
        line = centre + near[:, None] * ways
        steps = np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1)
        centre = ((line + np.roll(line, -1, axis=0)) / 2 * steps[:, None]).sum(axis=0) / steps.sum()
    return line, centre


def ring(depth):
    """Ten points on the section, at equal ways."""
    line, _ = section(depth)
    steps = np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    closed = np.vstack([line, line[:1]])
    return np.column_stack([np.interp(np.arange(10) * way[-1] / 10, way, closed[:, i]) for i in range(3)])


def words_of(point):
    return ",".join(f"{x:.6f}" for x in point)


def scattered(work, depth, foci, name):
    """Runs the program: its report, and the finger's corners (mm), triangles and radiation pressure (Pa)."""
    path = work.data / f"{name}.vtp"
    centre = tip(depth) + (LENGTH / 2 - RADIUS) * AXIS
    body = ("finger", "--radius", RADIUS, "--length", LENGTH, "--edge", EDGE, "--rotate", "45,0,0", "--center", words_of(centre))
    aims = [part for focus in foci for part in ("--focus", words_of(focus))]
    report = json.loads(run(work.program, "scatter", *body, *aims, "--rig", "cube-300", "--foci-inside", "--json", "-o", path))
    piece = xml.etree.ElementTree.parse(path).getroot().find("PolyData/Piece")
    corners = np.fromstring(piece.find("Points/DataArray").text, sep=" ").reshape(-1, 3)
    triangles = np.fromstring(piece.find("Polys/DataArray[@Name='connectivity']").text, sep=" ", dtype=int).reshape(-1, 3)
    radiation = np.fromstring(piece.find("CellData/DataArray[@Name='radiation_pressure_pa']").text, sep=" ")
    return report, corners, triangles, radiation


class Touch:
    """One finger at one depth, with one way of aiming."""

    def __init__(self, work, depth, way):
        self.depth, self.centre = depth, section(depth)[1]
        self.foci = ring(depth) if way == "dynamic" else self.centre[None]
        self.report, self.corners, self.triangles, self.radiation = scattered(work, depth, self.foci, f"finger-{way}-{depth:g}")
        sides = self.corners[self.triangles]
        self.middles = sides.mean(axis=1)
        across = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
        self.areas = np.linalg.norm(across, axis=1) / 2
        self.normals = across / (2 * self.areas[:, None])

    def strong(self):
        """Where the pressure is over half of its highest."""
        return self.radiation > self.radiation.max() / 2

    def spread(self):
        """Diameter of a disc as large as the strong skin, mm."""
        return 2 * np.sqrt(self.areas[self.strong()].sum() / np.pi)

    def off_surface(self):
        """Mean distance of the strong skin from the virtual surface, mm."""
        share = self.areas * self.radiation * self.strong()
        return (share * abs(self.middles[:, 2] - SURFACE)).sum() / share.sum()

    def back_over_pad(self):
        back = self.normals @ PAD < -0.5
        return self.radiation[back].max() / self.radiation.max()

    def paint(self, panel, view, title, foci):
        """The outer 30 mm of the finger, tip up."""
        drawn = paint(panel, self.corners, self.triangles, self.radiation / self.radiation.max(), view, -AXIS, (0, 1), foci)
        top = (self.corners @ -AXIS).max()
        panel.set(title=title, xticks=[], yticks=[], ylim=(top - 30, top + 1))
        return drawn


def fingers_7(work, name):
    touch = Touch(work, 2.0, "dynamic")
    figure, axes = plt.subplots(1, 2, figsize=(7.4, 6.2), constrained_layout=True)
    touch.paint(axes[0], -PAD, "pad", touch.foci)
    drawn = touch.paint(axes[1], PAD, "back", ())
    figure.colorbar(drawn, ax=axes, label="mean radiation pressure over its highest", shrink=0.8)
    figure.suptitle(f"finger of 16 mm, {touch.depth:g} mm deep, ten foci in turn by four units", fontsize=10)
    figure.savefig(work.folder / f"{name}.png", dpi=DPI)
    plt.close(figure)
    shallow = Touch(work, 1.0, "static")
    report = touch.report
    return [
        row("triangles", report["triangles"], "", 4322, "text", "of a capsule; the paper's is a finger's mesh, which it does not describe further"),
        row("triangles a wavelength", report["elements_per_wavelength"]),
        row("highest pressure on the back over that on the pad", touch.back_over_pad(), "", None, "", "the paper: no significant pressure on the back, because of interference; ours is at the tip's rim, which the unit at the back reaches"),
        row("width of the strong skin (over half), one focus, 1 mm deep", shallow.spread(), "mm", 5.0, "text", OURS),
        row("highest mean radiation pressure", report["highest_radiation_pa"], "Pa", None, "", "transducers as Hoshi measured them at 10 Vrms"),
        row("mean force", float(np.linalg.norm(report["force_mn"])), "mN"),
    ]  # fmt: skip


def fingers_8(work, name):
    rows = []
    figure, axes = plt.subplots(2, len(DEPTHS), figsize=(11.5, 8.4), constrained_layout=True)
    for column, depth in enumerate(DEPTHS):
        for line, way in zip(axes, ("dynamic", "static")):
            touch = Touch(work, depth, way)
            drawn = touch.paint(line[column], -PAD, f"{way}, {depth:g} mm deep", touch.foci)
            rows.append((f"{way}, {depth:g} mm deep", touch))
    figure.colorbar(drawn, ax=axes, label="mean radiation pressure over the picture's highest", shrink=0.7)
    figure.savefig(work.folder / f"{name}.png", dpi=DPI)
    plt.close(figure)
    return [
        *(row(f"diameter of the strong skin, {label}", touch.spread(), "mm", None, "", OURS if i == 0 else "") for i, (label, touch) in enumerate(rows)),
        *(row(f"strong skin off the virtual surface, {label}", touch.off_surface(), "mm", None, "", "the paper: deep down, a static focus presses beside the surface" if i == 7 else "") for i, (label, touch) in enumerate(rows)),
        *(row(f"highest mean radiation pressure, {label}", touch.report["highest_radiation_pa"], "Pa") for label, touch in rows),
    ]  # fmt: skip
