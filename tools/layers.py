#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the includes of the C++ sources point one way, and draws the house from them.

`tools/layers.py` writes docs/layers.blocks.toml, from which tools/draw.py makes docs/layers.svg. With --check it writes nothing.
Either way the exit code is 1 when a layer includes what LAYERS does not allow, and the message names the file and the line.

The picture leaves out an arrow where a chain of other arrows already leads to the same layer.
"""
import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/layers.blocks.toml"
BASICS = ["base", "model"]
PHYSICS = [*BASICS, "boards", "acoustics"]
IMAGE = [*PHYSICS, "shape", "hand", "render", "solve", "image"]
INSTRUMENT = [*IMAGE, "analysis", "instrument"]

# The rule. A layer may include itself and the layers that stand here. "at" is its place in the picture, as column and row.
LAYERS = {
    "base":       {"may": [], "at": (1, 9), "knows": "errors, files, processes, progress"},
    "model":      {"may": ["base"], "at": (1, 8), "knows": "air, transducers, arrays, rigs"},
    "robot":      {"may": ["base"], "at": (4, 8), "knows": "a handle on eight cables"},
    "boards":     {"may": BASICS, "at": (2, 7), "knows": "board files, the core's parameters"},
    "acoustics":  {"may": BASICS, "at": (0, 7), "knows": "waves, fields, transients"},
    "shape":      {"may": BASICS, "at": (1, 7), "knows": "files, built-in shapes, points"},
    "hand":       {"may": BASICS, "at": (3, 7), "knows": "hands, skin, solids"},
    "scattering": {"may": [*BASICS, "acoustics", "shape", "hand"], "at": (0, 6), "knows": "rigid bodies in a sound field"},
    "sense":      {"may": [*BASICS, "hand"], "at": (4, 6), "knows": "depth cameras to points"},
    "scene":      {"may": [*BASICS, "hand"], "at": (5, 6), "knows": "fingers hold an object"},
    "render":     {"may": [*BASICS, "shape", "hand"], "at": (1, 6), "knows": "paths: foci in time"},
    "perception": {"may": [*BASICS, "acoustics", "render"], "at": (3, 6), "knows": "how strong a focus feels"},
    "fusion":     {"may": [*BASICS, "acoustics", "hand", "render", "perception", "robot"], "at": (4, 5), "knows": "a scene to cables and ultrasound"},
    "solve":      {"may": [*PHYSICS, "render"], "at": (1, 5), "knows": "foci to drives to records"},
    "image":      {"may": [*PHYSICS, "render", "solve"], "at": (1, 4), "knows": "memories, Intel HEX, bundles"},
    "analysis":   {"may": IMAGE, "at": (0, 3), "knows": "pulses to drives, checks of foci"},
    "instrument": {"may": [*IMAGE, "scattering", "perception", "analysis"], "at": (0, 2), "knows": "the verbs as functions"},
    "link":       {"may": IMAGE, "at": (2, 3), "knows": "frames, ports, devices"},
    "live":       {"may": [*INSTRUMENT, "perception", "sense", "scene", "link"], "at": (3, 1), "knows": "depth to rings, as it comes"},
    "sim":        {"may": [*IMAGE, "analysis", "link"], "at": (2, 2), "knows": "boards without hardware"},
    "studio":     {"may": [*INSTRUMENT, "link"], "at": (1, 1), "knows": "the page in the browser, its server"},
    "cli":        {"may": [*INSTRUMENT, "perception", "robot", "fusion", "sense", "scene", "link", "live", "sim", "studio"], "at": (1, 0), "knows": "the program: parse, call, print"},
}  # fmt: skip
FOLDERS = {name: f"host/haptogram/{name}" for name in LAYERS} | {"sim": "sim", "studio": "host/studio", "cli": "host/cli"}
ROW, GAP = 44, 32  # of the picture, pixels
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


def layer_of(included, file):
    """The other layer that an include leads to; none when it is the file's own, or none of ours."""
    if found := re.match(r"haptogram/(\w+)/", included):
        return found[1]
    if (file.parent / included).exists():
        return None
    return next((name for name in ("sim", "studio", "cli") if (ROOT / FOLDERS[name] / included).exists()), None)


def read_includes():
    """Each layer's includes of other layers, and what is wrong with them."""
    edges, wrong = {name: set() for name in LAYERS}, []
    for folder in sorted(p.name for p in (ROOT / "host/haptogram").iterdir() if p.is_dir() and p.name not in LAYERS):
        wrong.append(f"host/haptogram/{folder}: no such layer in tools/layers.py; add it to LAYERS with what it may include")
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
                if included not in LAYERS[name]["may"]:
                    allowed = ", ".join(LAYERS[name]["may"]) or "nothing"
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when the picture's source is stale")
    options = parser.parse_args()
    edges, wrong = read_includes()
    for message in wrong:
        print(f"layers: {message}", file=sys.stderr)
    if wrong:
        return 1
    text = picture(edges)
    if not PICTURE.exists() or PICTURE.read_text(encoding="utf-8") != text:
        if options.check:
            print("layers: docs/layers.blocks.toml is stale; run tools/layers.py and tools/draw.py", file=sys.stderr)
            return 1
        PICTURE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
