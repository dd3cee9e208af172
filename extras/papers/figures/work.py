# SPDX-License-Identifier: Apache-2.0
"""What the figures are made of: runs of the programs, measures of curves, and the rows of the tables."""

import functools
import json
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import plot_field

DPI = 110
SOURCE = "the source strength of 4 Pa·m is the array file's, not calibrated on the paper's transducers: the pressure scales with it"
RADIATION = "time-averaged radiation pressure / Pa"


def run(*arguments):
    result = subprocess.run([str(a) for a in arguments], stdout=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(f"figures: {' '.join(map(str, arguments))} ended with exit code {result.returncode}\n{result.stdout}")
    return result.stdout


def row(what, ours, unit="", paper=None, kind="", why=""):
    """A line of the table. `kind` says what the paper's number is: theory, measured, or text."""
    return {"what": what, "unit": unit, "paper": paper, "kind": kind, "ours": float(ours), "why": why}


class Work:
    """What the figures are made of; each piece is made once, when it is first asked for."""

    def __init__(self, program, tool, folder):
        self.program, self.tool, self.folder = program, tool, folder
        self.data = folder / "data"
        self.data.mkdir(parents=True, exist_ok=True)
        point = self.data / "tile-of-points.toml"
        point.write_text(
            'name = "tile-of-points"\n[array]\nrows = 10\ncolumns = 10\npitch_mm = 10.0\n[medium]\ntemperature_c = 20.0\n'
            'density_kg_m3 = 1.204\n[transducer]\nfile = "point"\nsource_pa_m = 4.0\n', encoding="utf-8")  # fmt: skip
        self.points_array = point
        hoshi = self.data / "hoshi-of-points.toml"
        hoshi.write_text(
            'name = "hoshi-of-points"\n[array]\nrows = 18\ncolumns = 18\npitch_mm = 10.0\n[medium]\nspeed_m_s = 340.0\n'
            'density_kg_m3 = 1.2\n[transducer]\nfile = "point"\n[board]\nchannels = 324\n', encoding="utf-8")  # fmt: skip
        self.hoshi_of_points = hoshi

    @functools.cached_property
    def computed(self):
        return json.loads(run(self.tool))

    @functools.cache
    def played(self, name, *arguments):
        """Compiles, plays one pass on the Verilated board, and measures its pins: (manifest, pulses, report, foci)."""
        print(f"figures: playing {name}", file=sys.stderr)
        image, pulses, report = (self.data / f"{name}{end}" for end in (".hex", ".pulses.csv", ".report.json"))
        run(self.program, "compile", *arguments, "-o", image)
        run(self.program, "simulate", image, "--load", "direct", "--passes", 1, "--pulses", pulses, "--report", report)
        manifest = image.with_suffix(".json")
        foci = np.array([r["focus_mm"] for r in json.loads(manifest.read_text(encoding="utf-8"))["records"]])
        return manifest, pulses, json.loads(report.read_text(encoding="utf-8")), foci

    def plane(self, region, *arguments, label=RADIATION):
        path = self.data / "plane.csv"
        run(self.program, "field", "--plane", region, *arguments, "-o", path)
        return plot_field.read_csv(path, region, label, [])

    def highest(self, region, played, *arguments):
        """The largest amplitude at each point of a plane over a pass, kPa: record by record, as the image has them."""
        image, path = played[0].with_suffix(".hex"), self.data / "plane.csv"
        best, about = 0.0, None
        for record in range(1, len(played[3]) + 1):
            run(self.program, "field", image, "--record", record, "--plane", region, "--quantity", "rms", *arguments, "-o", path)
            field, about = plot_field.read_csv(path, region, "largest sound pressure amplitude / kPa", [])
            best = np.maximum(best, field * np.sqrt(2.0) / 1e3)
        return best, about

    def line(self, region, *arguments):
        path = self.data / "line.csv"
        run(self.program, "field", "--line", region, *arguments, "-o", path)
        return np.loadtxt(path, delimiter=",", skiprows=1).T


def of(played):
    return "--pulses", played[1], "--manifest", played[0]


def crossings(x, y, level, peak):
    """Where y falls below `level` on either side of the sample `peak`, interpolated; NaN where it does not."""
    found = []
    for step in (-1, 1):
        i = peak
        while 0 <= i + step < len(y) and y[i] >= level:
            i += step
        if y[i] >= level:
            found.append(float("nan"))
        else:
            found.append(x[i] + (level - y[i]) / (y[i - step] - y[i]) * (x[i - step] - x[i]))
    return found


def width(x, y, fraction=0.5):
    low, high = crossings(x, y, fraction * y.max(), int(np.argmax(y)))
    return high - low


def first(t, y, level):
    """When a rising y first reaches `level`, interpolated."""
    i = int(np.argmax(y >= level))
    return t[i - 1] + (level - y[i - 1]) / (y[i] - y[i - 1]) * (t[i] - t[i - 1])


def panels(count, size):
    figure, axes = plt.subplots(1, count, figsize=size, constrained_layout=True)
    return figure, np.atleast_1d(axes)


def save(work, figure, name):
    figure.savefig(work.folder / f"{name}.png", dpi=DPI)
    plt.close(figure)


def legend(panel, **more):
    panel.legend(fontsize=8, framealpha=0.85, **more)
