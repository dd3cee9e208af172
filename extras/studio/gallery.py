#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws each design of extras/studio/gallery as picture.svg, from the focal points of its compiled image.

Usage: extras/studio/gallery.py [PROGRAM], which is build/release/host/cli/haptogram without it.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, MARGIN = 80, 52, 7


def points_of(program, project):
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / "image.hex"
        subprocess.run([program, "compile", project, "-o", image], check=True, capture_output=True)
        manifest = json.loads(image.with_suffix(".json").read_text(encoding="utf-8"))
    return sorted({tuple(record["focus_mm"]) for record in manifest["records"]})


def picture(points):
    """Points seen from the front and above, as large as they fit."""
    seen = [(x + 0.4 * y, -z - 0.5 * y) for x, y, z in points]
    left, top = (min(values) for values in zip(*seen, strict=True))
    wide, high = (max(values) - min(values) for values in zip(*seen, strict=True))
    scale = min((WIDTH - 2 * MARGIN) / max(wide, 1), (HEIGHT - 2 * MARGIN) / max(high, 1), 1.2)
    x0, y0 = (WIDTH - scale * wide) / 2 - scale * left, (HEIGHT - scale * high) / 2 - scale * top
    radius = 4 if len(points) < 4 else 2 if len(points) < 50 else 1.2
    dots = "".join(f'<circle cx="{x0 + scale * x:.1f}" cy="{y0 + scale * y:.1f}" r="{radius}"/>' for x, y in seen)
    return f'<!-- SPDX-License-Identifier: Apache-2.0, drawn by extras/studio/gallery.py -->\n<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" fill="#ad1760">{dots}</svg>\n'


def main():
    program = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/host/cli/haptogram").resolve()
    for project in sorted((ROOT / "extras/studio/gallery").glob("*/project.toml")):
        project.with_name("picture.svg").write_text(picture(points_of(program, project)), encoding="utf-8")


if __name__ == "__main__":
    main()
