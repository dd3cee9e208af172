#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws pictures: `tools/draw.py` writes each NAME.svg from the NAME.blocks.toml or NAME.waves.toml beside it; --check only says what is stale.

A block picture is boxes on a grid, groups around boxes, and arrows between boxes with right angles:

    title   = "…"
    columns = 140          # of the grid, in pixels, with gap = 60 between them; likewise rows
    [[box]]     name, at = [column, row], text = ["first line in bold", "further lines"], wide = 1.0 columns, plain = true for no frame
    [[group]]   text, boxes = ["…"]
    [[arrow]]   from, to, text; out and in are the places on the boxes' sides (0.5 is the middle); sides = "right left" when the
                two sides that face each other are not meant; two_way = true

A picture of waves is a row for each signal over a common time:

    title   = "…"
    end     = 1000         # of the time, which begins at 0; width = 900 pixels
    [[row]]     text, high = [[from, to], …] of a signal that is low or high, or values = [[from, to, "text"], …] of one with a name for each time
    [[mark]]    at, text: a line through all rows
    [[span]]    from, to, row (counted from 0), text: an arrow with two heads above a row

Graphviz would move boxes about with each change, and WaveDrom's times are whole steps.
"""
import argparse
import subprocess
import sys
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
STYLE = """text { font: 12px sans-serif; fill: #1b1b1b; text-anchor: middle } .bold { font-weight: bold } .title { font-size: 15px }
.note { font-size: 11px; fill: #3a3a3a } .halo { stroke: #ffffff; stroke-width: 4px; paint-order: stroke }
rect.box { fill: #eaf1fb; stroke: #2f5d9b; stroke-width: 1.2 } rect.group { fill: #f7f7f4; stroke: #8a8a80; stroke-dasharray: 5 4 }
.group { text-anchor: start; fill: #5b5b52 } path { fill: none; stroke: #333333; stroke-width: 1.2; marker-end: url(#tip) }"""
WAVE_STYLE = """
.start { text-anchor: start } path.wave { stroke: #2f5d9b; stroke-width: 1.6; marker-end: none }
path.mark { stroke: #b04a2f; stroke-dasharray: 4 3; marker-end: none }"""
OPPOSITE = {"right": "left", "left": "right", "top": "bottom", "bottom": "top"}
LINE = 15  # of text


class Wrong(Exception):
    """A source is not as expected."""


class Picture:
    def __init__(self, table):
        self.table = table
        self.size = table.get("columns", 140), table.get("rows", 48)
        self.gap = table.get("gap", [60, 40])
        self.margin = table.get("margin", [24, 56])
        self.boxes = {}
        for box in table["box"]:
            column, row = box["at"]
            x, y = (self.margin[i] + at * (self.size[i] + self.gap[i]) for i, at in enumerate((column, row)))
            self.boxes[box["name"]] = (x, y, self.size[0] * box.get("wide", 1), self.size[1])

    def box(self, name):
        if name not in self.boxes:
            raise Wrong(f"no box {name}; there are {', '.join(self.boxes)}")
        return self.boxes[name]

    def sides(self, arrow):
        if "sides" in arrow:
            return arrow["sides"].split()
        (x0, y0, w0, _), (x1, y1, *_) = self.box(arrow["from"]), self.box(arrow["to"])
        if x1 >= x0 + w0:
            side = "right"
        elif x1 < x0:
            side = "left"
        else:
            side = "bottom" if y1 > y0 else "top"
        return side, OPPOSITE[side]

    def place(self, name, side, fraction):
        x, y, w, h = self.box(name)
        return {"right": (x + w, y + h * fraction), "left": (x, y + h * fraction), "top": (x + w * fraction, y), "bottom": (x + w * fraction, y + h)}[side]

    def arrow(self, arrow):
        leaves, enters = self.sides(arrow)
        (x0, y0), (x1, y1) = self.place(arrow["from"], leaves, arrow.get("out", 0.5)), self.place(arrow["to"], enters, arrow.get("in", 0.5))
        flat = {"right", "left"}
        turn = arrow.get("turn", 0.5)
        if leaves in flat and enters in flat:
            x = x0 + (x1 - x0) * turn
            points = [(x0, y0), (x, y0), (x, y1), (x1, y1)] if y0 != y1 else [(x0, y0), (x1, y1)]
        elif leaves in flat:
            points = [(x0, y0), (x1, y0), (x1, y1)]
        elif enters in flat:
            points = [(x0, y0), (x0, y1), (x1, y1)]
        else:
            y = y0 + (y1 - y0) * turn
            points = [(x0, y0), (x0, y), (x1, y), (x1, y1)] if x0 != x1 else [(x0, y0), (x1, y1)]
        start = ' marker-start="url(#tip)"' if arrow.get("two_way") else ""
        lines = ["<path%s d='M %s'/>" % (start, " L ".join(f"{x:g} {y:g}" for x, y in points))]
        # The text stands on the longest piece.
        a, b = max(zip(points, points[1:]), key=lambda piece: abs(piece[0][0] - piece[1][0]) + abs(piece[0][1] - piece[1][1]))
        x, y = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        texts = arrow.get("text", [])
        for i, text in enumerate([texts] if isinstance(texts, str) else texts):
            up = -5 - LINE * (len(texts) - 1 - i if not isinstance(texts, str) else 0) if a[1] == b[1] else 4 + LINE * (i - (len(texts) - 1) / 2 if not isinstance(texts, str) else 0)
            lines.append(f'<text class="note halo" x="{x:g}" y="{y + up:g}">{escape(text)}</text>')
        return lines

    def svg(self, source):
        right = max(x + w for x, _, w, _ in self.boxes.values()) + 24
        bottom = max(y + h for _, y, _, h in self.boxes.values()) + 24
        body = []
        for group in self.table.get("group", []):
            inside = [self.box(name) for name in group["boxes"]]
            x, y = min(b[0] for b in inside) - 12, min(b[1] for b in inside) - 22
            w, h = max(b[0] + b[2] for b in inside) + 12 - x, max(b[1] + b[3] for b in inside) + 10 - y
            body.append(f'<rect class="group" x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}" rx="8"/>')
            body.append(f'<text class="group" x="{x + 8:g}" y="{y + 14:g}">{escape(group["text"])}</text>')
            right, bottom = max(right, x + w + 12), max(bottom, y + h + 12)
        for arrow in self.table.get("arrow", []):
            body += self.arrow(arrow)
        for box in self.table["box"]:
            x, y, w, h = self.boxes[box["name"]]
            if not box.get("plain"):
                body.append(f'<rect class="box" x="{x:g}" y="{y:g}" width="{w:g}" height="{h:g}" rx="5"/>')
            lines = box.get("text", [box["name"]])
            for i, text in enumerate(lines):
                kind = ' class="bold"' if i == 0 else ' class="note"'
                body.append(f'<text{kind} x="{x + w / 2:g}" y="{y + h / 2 + 4 + LINE * (i - (len(lines) - 1) / 2):g}">{escape(text)}</text>')
        return svg(self.table["title"], source, right, bottom, body)


class Waves:
    LEFT, TOP, HIGH, PITCH = 190, 78, 26, 56  # pixels: before the waves, above them, of a pulse, from row to row

    def __init__(self, table):
        self.table = table
        self.scale = table.get("width", 900) / table["end"]

    def x(self, time):
        if not 0 <= time <= self.table["end"]:
            raise Wrong(f"time {time} is not within 0…{self.table['end']}")
        return self.LEFT + time * self.scale

    def row(self, number, row):
        top = self.TOP + number * self.PITCH
        low = top + self.HIGH
        lines = [f'<text class="start" x="16" y="{top + 17:g}">{escape(row["text"])}</text>']
        for begin, end, text in row.get("values", []):
            x0, x1 = self.x(begin), self.x(end)
            lines.append(f'<rect class="box" x="{x0:g}" y="{top:g}" width="{x1 - x0:g}" height="{self.HIGH}" rx="4"/>')
            lines.append(f'<text class="note" x="{(x0 + x1) / 2:g}" y="{top + 17:g}">{escape(text)}</text>')
        if "high" in row:
            times = [time for pulse in row["high"] for time in pulse]
            level, edges = low, ""
            for time in times:
                level = top if level == low else low
                if time == 0:  # high from the beginning
                    edges += f" M {self.x(0):g} {top:g}"
                elif time < self.table["end"]:
                    edges += f" H {self.x(time):g} V {level:g}"
            lines.append(f'<path class="wave" d="M {self.x(0):g} {low:g}{edges} H {self.x(self.table["end"]):g}"/>')
        return lines

    def svg(self, source):
        rows = self.table["row"]
        right, bottom = self.x(self.table["end"]) + 24, self.TOP + len(rows) * self.PITCH
        body = []
        for mark in self.table.get("mark", []):
            x = self.x(mark["at"])
            body.append(f'<path class="mark" d="M {x:g} {self.TOP - 22:g} V {bottom - 14:g}"/>')
            body.append(f'<text class="note" x="{x:g}" y="{self.TOP - 28:g}">{escape(mark["text"])}</text>')
        for number, row in enumerate(rows):
            body += self.row(number, row)
        for span in self.table.get("span", []):
            y = self.TOP + span["row"] * self.PITCH - 8
            x0, x1 = self.x(span["from"]), self.x(span["to"])
            body.append(f'<path marker-start="url(#tip)" d="M {x0:g} {y:g} H {x1:g}"/>')
            body.append(f'<text class="note halo" x="{(x0 + x1) / 2:g}" y="{y - 4:g}">{escape(span["text"])}</text>')
        return svg(self.table["title"], source, right, bottom, body, STYLE + WAVE_STYLE)


def svg(title, source, right, bottom, body, style=STYLE):
    return "\n".join([
        f"<!-- Generated from {source} by tools/draw.py; edit the source, not this file. SPDX-License-Identifier: Apache-2.0 -->",
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {right:g} {bottom:g}" width="{right:g}" height="{bottom:g}" role="img">',
        f"<title>{escape(title)}</title>", f"<style>{style}</style>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto-start-reverse">'
        '<polygon points="0 0.5 8 4 0 7.5" fill="#333333"/></marker></defs>',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        f'<text class="bold title" x="{right / 2:g}" y="22">{escape(title)}</text>', *body, "</svg>", ""])  # fmt: skip


KINDS = {".blocks.toml": Picture, ".waves.toml": Waves}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog="\n".join(__doc__.splitlines()[2:]),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("sources", metavar="FILE", nargs="*", type=Path, help="none: all of the repository")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when a picture is stale")
    options = parser.parse_args()
    sources = options.sources
    if not sources:
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", *(f"*{kind}" for kind in KINDS)], capture_output=True, text=True, check=True)
        sources = [ROOT / name for name in listed.stdout.splitlines()]
    stale = []
    for source in sources:
        kind = next((kind for kind in KINDS if source.name.endswith(kind)), None)
        if kind is None:
            sys.exit(f"{source}: the name must end in {' or '.join(KINDS)}")
        target = source.with_name(source.name.removesuffix(kind) + ".svg")
        try:
            text = KINDS[kind](tomllib.loads(source.read_text(encoding="utf-8"))).svg(source.name)
        except (Wrong, KeyError, ValueError, tomllib.TOMLDecodeError) as error:
            sys.exit(f"{source}: {error!r}" if isinstance(error, KeyError) else f"{source}: {error}")
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            stale.append(target.name)
            if not options.check:
                target.write_text(text, encoding="utf-8")
    if options.check and stale:
        sys.exit(f"stale, run tools/draw.py: {', '.join(stale)}")


if __name__ == "__main__":
    main()
