#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the includes of the C++ sources point one way, and draws the house from them.

`tools/layers.py` writes the table of host/README.md, and docs/layers.blocks.toml, from which tools/draw.py makes docs/layers.svg.
With --check it writes nothing.
Either way the exit code is 1 when a layer includes what LAYERS does not allow, and the message names the file and the line.

The picture leaves out an arrow where a chain of other arrows already leads to the same layer.
"""
import argparse
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/layers.blocks.toml"
PAGE = ROOT / "host/README.md"
BEGIN, END = "<!-- layers -->\n", "<!-- end of layers -->\n"
# The rule. A layer may include itself, the layers that stand here, and all that they may include. "at" is its place in the picture, as
# column and row.
LAYERS = {
    "base":       {"on": [], "at": (2, 7), "knows": "errors, files, processes, text"},
    "array":      {"on": ["base"], "at": (2, 6), "knows": "air, transducers, arrays, rigs"},
    "format":     {"on": ["array"], "at": (3, 5), "knows": "paths, records, images, boards"},
    "link":       {"on": ["format"], "at": (4, 4), "knows": "messages, ports, devices"},
    "acoustics":  {"on": ["array"], "at": (0, 5), "knows": "waves, fields, transients"},
    "shape":      {"on": ["format"], "at": (3, 4), "knows": "shapes and their paths, files"},
    "solve":      {"on": ["format", "acoustics"], "at": (2, 4), "knows": "foci to drives to records"},
    "calibration": {"on": ["verbs"], "at": (5, 2), "knows": "what a real array is like"},
    "hand":       {"on": ["perception"], "at": (1, 2), "knows": "hands, skin, rendering"},
    "scattering": {"on": ["hand"], "at": (2, 1), "knows": "rigid bodies in a sound field"},
    "perception": {"on": ["verbs"], "at": (0, 2), "knows": "how strong a focus feels"},
    "verbs":      {"on": ["link", "solve", "shape"], "at": (2, 3), "knows": "what a user asks for"},
    "live":       {"on": ["hand"], "at": (0, 1), "knows": "depth to rings, as it comes"},
    "robot":      {"on": ["hand"], "at": (3, 1), "knows": "a handle on eight cables"},
    "sim":        {"on": ["verbs"], "at": (4, 1), "knows": "boards without hardware"},
    "studio":     {"on": ["hand"], "at": (1, 1), "knows": "the page in the browser"},
    "serve":      {"on": ["verbs"], "at": (5, 1), "knows": "the service for other programs"},
    "c":          {"on": ["sim", "hand"], "at": (4, 0), "knows": "the interface for other languages"},
    "cli":        {"on": ["calibration", "scattering", "live", "robot", "sim", "studio", "serve"], "at": (2, 0), "knows": "the program: parse, call, print"},
}  # fmt: skip
FOLDERS = {name: f"host/haptogram/{name}" for name in LAYERS} | {"sim": "sim", "studio": "host/studio", "cli": "host/cli", "c": "host/c", "serve": "host/serve"}
ROW, GAP = 44, 32  # of the picture, pixels
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


def layer_of(included, file):
    """The other layer that an include leads to; none when it is the file's own, or none of ours."""
    if found := re.match(r"haptogram/(\w+)/", included):
        return found[1]
    if (file.parent / included).exists():
        return None
    return next((name for name in ("sim", "studio", "serve", "c", "cli") if (ROOT / FOLDERS[name] / included).exists()), None)


def read_includes():
    """Each layer's includes of other layers, and what is wrong with them."""
    edges, wrong = {name: set() for name in LAYERS}, []
    on = {name: layer["on"] for name, layer in LAYERS.items()}
    may = {name: reachable(on, name) for name in LAYERS}
    for folder in sorted(p.name for p in (ROOT / "host/haptogram").iterdir() if p.is_dir() and p.name not in LAYERS):
        wrong.append(f"host/haptogram/{folder}: no such layer in tools/layers.py; add it to LAYERS with what it stands on")
    for name, folder in FOLDERS.items():
        files = sorted(f for ending in ("hpp", "cpp", "in") for f in (ROOT / folder).rglob(f"*.{ending}"))
        if not files:
            wrong.append(f"{folder}: layer {name} has no sources")
        for file in files:
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                included = (found := INCLUDE.match(line)) and layer_of(found[1], file)
                if not included or included == name:
                    continue
                edges[name].add(included)
                if included not in may[name]:
                    allowed = ", ".join(sorted(may[name])) or "nothing"
                    wrong.append(f"{file.relative_to(ROOT)}:{number}: layer {name} may not include {included}; it may include {allowed}")
    return edges, wrong


def reachable(edges, start):
    found, waiting = set(), list(edges[start])
    while waiting:
        if (name := waiting.pop()) not in found:
            found.add(name)
            waiting += edges[name]
    return found


def without_detours(edges):
    """Only the arrows that no chain of others replaces."""
    return {
        name: {to for to in targets if not any(to in reachable(edges, between) for between in targets - {to})} for name, targets in edges.items()
    }


def picture(edges):
    column = {name: layer["at"][0] for name, layer in LAYERS.items()}
    arrows = [(name, to) for name in LAYERS for to in LAYERS if to in without_detours(edges)[name]]
    lines = ["# SPDX-License-Identifier: Apache-2.0", "# Generated from the includes by tools/layers.py; tools/draw.py makes layers.svg from it.",
             'title = "The layers of the C++ side: an arrow leads from a layer to what it includes"',
             "columns = 220", f"rows = {ROW}", f"gap = [40, {GAP}]", ""]  # fmt: skip
    for name, layer in LAYERS.items():
        lines += ["[[box]]", f'name = "{name}"', f"at = [{layer['at'][0]}, {layer['at'][1]}]", f'text = ["{name}", "{layer["knows"]}"]']
    for name, to in arrows:
        # Arrows share a side evenly, in the order of where they lead or come from.
        out = sorted((column[other], other) for start, other in arrows if start == name)
        into = sorted((column[start], start) for start, other in arrows if other == to)
        places = [(side.index((column[end], end)) + 1) / (len(side) + 1) for side, end in ((out, to), (into, name))]
        # A long arrow turns right below the box that it leaves, where no other box is.
        length = (LAYERS[to]["at"][1] - LAYERS[name]["at"][1]) * (ROW + GAP) - ROW
        lines += ["[[arrow]]", f'from = "{name}"', f'to = "{to}"', 'sides = "bottom top"',
                  f"out = {places[0]:.3g}", f"in = {places[1]:.3g}", f"turn = {GAP / 2 / length:.3g}"]  # fmt: skip
    return "\n".join(lines) + "\n"


def table(page):
    """The page with the rule as its table."""
    lines = ["| layer | knows | stands on |", "|---|---|---|"]
    for name, layer in LAYERS.items():
        folder = Path(os.path.relpath(ROOT / FOLDERS[name], PAGE.parent)).as_posix()
        lines.append(f"| [{name}]({folder}/README.md) | {layer['knows']} | {', '.join(layer['on']) or '–'} |")
    before, rest = page.split(BEGIN)
    return before + BEGIN + "\n".join(lines) + "\n" + END + rest.split(END)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when the table or the picture's source is stale")
    options = parser.parse_args()
    edges, wrong = read_includes()
    for message in wrong:
        print(f"layers: {message}", file=sys.stderr)
    if wrong:
        return 1
    for path, text in ((PICTURE, picture(edges)), (PAGE, table(PAGE.read_text(encoding="utf-8")))):
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        if options.check:
            print(f"layers: {path.relative_to(ROOT)} is stale; run tools/layers.py and tools/draw.py", file=sys.stderr)
            return 1
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
