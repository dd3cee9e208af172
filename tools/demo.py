#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The whole path on real shapes: compile, upload over the simulated UART, play one pass on the Verilated FPGA, measure the
pins, compute the field, and show it. One folder a shape with image, manifest, pulses, report, fields and a picture."""

import argparse
import collections
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SHAPES = {"heart": HERE / "demo/heart.ply", "vase": HERE / "demo/vase.obj"}
# Small enough, and fast enough, that a hand should feel the outline. The vase's whole surface is too large for one focus: its table says so.
TOUR = ("--size", 40, "--points", 100, "--rate", 100)


def run(arguments):
    result = subprocess.run([str(a) for a in arguments], stdout=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(f"demo: {' '.join(map(str, arguments))} ended with exit code {result.returncode}\n{result.stdout}")
    return result.stdout


def busiest_height(foci):
    """The height, to 2 mm, at which most of the shape lies."""
    counts = collections.Counter(round(z / 2.0) * 2 for _, _, z in foci)
    return min(counts, key=lambda z: (-counts[z], z))


def render(program, name, source, folder):
    import plot_field

    folder.mkdir(parents=True, exist_ok=True)
    image, manifest = folder / f"{name}.hex", folder / f"{name}.json"
    pulses, report = folder / "pulses.csv", folder / "report.json"
    print(f"demo: {name}: compiling {source.name}", file=sys.stderr)
    run([program, "compile", source, *TOUR, "-o", image])
    print(f"demo: {name}: uploading, playing and measuring", file=sys.stderr)
    run([program, "simulate", image, "--passes", 1, "--load", "uart", "--pulses", pulses, "--report", report])
    foci = [r["focus_mm"] for r in json.loads(manifest.read_text(encoding="utf-8"))["records"]]
    planes = [f"xy@z={busiest_height(foci)}", "xz@y=0"]
    fields = []
    for plane in planes:
        print(f"demo: {name}: field in {plane}", file=sys.stderr)
        field = folder / f"field_{plane[:2]}.csv"
        run([program, "field", "--pulses", pulses, "--manifest", manifest, "--plane", plane, "--extent", 90, "--step", 1, "-o", field])
        fields.append(plot_field.read_csv(field, plane, "time-averaged radiation pressure / Pa", foci))
    plot_field.draw(fields, f"{name}: 100 points at 100 Hz, radiation pressure from the pulses at the pins", folder / f"{name}.png")
    felt = json.loads(run([program, "feel", image, "--json"]))
    return json.loads(report.read_text(encoding="utf-8")) | {"felt": felt}


def evenness(program, name, source, folder):
    """How alike the points of a shape feel with equal dwells and with chosen ones, in words."""
    report = json.loads(run([program, "compile", *source, *TOUR, "--even", "--json", "-o", folder / f"{name}_even.hex"]))
    return (
        f"{name}: dwells for an even feeling lower the spread from {report['spread_before']:.3f} to {report['spread']:.3f}; "
        f"the weakest point has {report['weakest_of_before']:.2f} of its pressure before"
    )


ROWS = [
    ("points", lambda r: f"{r['points']}"),
    ("image size", lambda r: f"{r['image_bytes']} bytes"),
    ("timer", lambda r: "prescaler {prescaler}, cycle {cycle_ticks}, pulse {pulse_ticks} ticks".format(**r["timer"])),
    ("clocks simulated", lambda r: f"{r['clocks']}"),
    ("simulated at", lambda r: f"{r['mclk_per_s']:.2f} Mclk/s"),
    ("pulses equal to the image", lambda r: f"{r['pulses_equal_to_image']} of {r['pulses']} measured"),
    ("focus error", lambda r: f"{r['worst_focus_error_mm']:.4f} mm at most"),
    ("pressure kept", lambda r: f"{100 * r['least_pressure_kept']:.4f} % at least"),
    ("contract violations", lambda r: f"{r['contract_violations']}"),
    ("by models a hand feels it", lambda r: r["felt"]["answer"]),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    reports = {name: render(arguments.program, name, source, arguments.output / name) for name, source in SHAPES.items()}
    print(f"{'':28}" + "".join(f"{name:44}" for name in reports))
    for title, value in ROWS:
        print((f"{title:28}" + "".join(f"{value(report):44}" for report in reports.values())).rstrip())
    print(evenness(arguments.program, "heart", [SHAPES["heart"]], arguments.output / "heart"))
    print(evenness(arguments.program, "hemisphere", ["--shape", "hemisphere"], arguments.output))
    for name in reports:
        print(f"{arguments.output / name}/: image, manifest, pulses, report, fields and {name}.png")


if __name__ == "__main__":
    main()
