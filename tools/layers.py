#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the includes of the C++ sources point one way, counts the core, and draws it.

The core's layers include those that stand below them, and never an extra. An extra includes the core, and the extras that the line
"# Needs:" of its CMakeLists.txt names.

`tools/layers.py` writes the table of host/README.md, the list of extras in extras/README.md and README.md, and
docs/layers.blocks.toml, from which tools/draw.py makes docs/layers.svg. With --check it writes nothing.
Either way the exit code is 1 when an include breaks the rule, or the core has grown beyond MOST; the message names the file and the line.

The picture leaves out an arrow where a chain of other arrows already leads to the same layer.
"""
import argparse
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/layers.blocks.toml"
# The rule of the core. A layer may include itself, the layers that stand here, and all that they may include. "at" is its place in
# the picture, as column and row.
LAYERS = {
    "base":      {"on": [], "at": (1, 6), "knows": "errors, files, processes, text"},
    "array":     {"on": ["base"], "at": (1, 5), "knows": "air, transducers, arrays, rigs"},
    "format":    {"on": ["array"], "at": (2, 4), "knows": "paths, records, images, boards"},
    "acoustics": {"on": ["array"], "at": (0, 4), "knows": "waves, fields, force on skin"},
    "link":      {"on": ["format"], "at": (3, 3), "knows": "messages, ports, devices"},
    "shape":     {"on": ["format"], "at": (2, 3), "knows": "shapes and their paths, files"},
    "solve":     {"on": ["format", "acoustics"], "at": (1, 3), "knows": "foci to drives to records"},
    "verbs":     {"on": ["link", "solve", "shape"], "at": (1, 2), "knows": "what a user asks for"},
    "sim":       {"on": ["verbs"], "at": (2, 1), "knows": "boards without hardware"},
    "cli":       {"on": ["sim"], "at": (2, 0), "knows": "the program: parse, call, print"},
    "c":         {"on": ["sim"], "at": (3, 0), "knows": "the interface for other languages"},
}  # fmt: skip
FOLDERS = {name: f"host/haptogram/{name}" for name in LAYERS} | {"sim": "sim", "cli": "host/cli", "c": "host/c"}
# The C interface is linked with what a build has of these, behind #ifdef.
MAY_HAVE = {"c": ("feel", "formats", "hands")}
# Lines of the files that are needed for a purpose: those that the named headers lead to, with their sources. They may not grow beyond MOST.
PURPOSES = {
    "compile a shape": (("verbs/compile.hpp",), 14650),
    "compile and play": (("verbs/compile.hpp", "link/play.hpp", "link/transfer.hpp", "link/port.hpp"), 18980),
}
ROW, GAP = 44, 32  # of the picture, pixels
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


class Extra:
    """A folder of extras/: what it is about is said by its page's title, "NAME: WHAT"."""

    def __init__(self, folder):
        self.name, self.folder = folder.name, folder
        title = (folder / "README.md").read_text(encoding="utf-8").splitlines()[1]
        self.about = title.split(": ", 1)[1] if ": " in title else ""
        listed = folder / "CMakeLists.txt"
        needs = re.search(r"^# Needs: *(.*)$", listed.read_text(encoding="utf-8"), re.MULTILINE) if listed.exists() else None
        self.needs = needs[1].split() if needs else []
        self.commands = sorted(
            word
            for file in (folder / "commands").glob("*.cpp")
            for word in re.findall(r'app\.add_subcommand\(\s*"([\w-]+)"', file.read_text(encoding="utf-8"))
        )


def extras():
    folders = sorted(p for p in (ROOT / "extras").iterdir() if p.is_dir())
    return {p.name: Extra(p) for p in folders}


def sources(folder):
    return sorted(f for ending in ("hpp", "cpp", "in") for f in folder.rglob(f"*.{ending}") if "node_modules" not in f.parts)


def owner_of(included, file, found):
    """The layer or extra that an include leads to; none when it is the file's own folder, or none of ours."""
    if layer := re.match(r"haptogram/(\w+)/", included):
        return next((name for name, extra in found.items() if (extra.folder / "haptogram" / layer[1]).is_dir()), layer[1])
    if (file.parent / included).exists():
        return None
    for name in ("sim", "cli", "c"):
        if (ROOT / FOLDERS[name] / included).exists():
            return name
    return next((name for name, extra in found.items() for place in ("", "commands", "engine") if (extra.folder / place / included).exists()), None)


def read_includes(found):
    """Each layer's includes of other layers, and what is wrong with them and with those of extras."""
    edges, wrong = {name: set() for name in LAYERS}, []
    on = {name: layer["on"] for name, layer in LAYERS.items()}
    may = {name: reachable(on, name) | set(MAY_HAVE.get(name, ())) for name in LAYERS}
    needs = {name: extra.needs for name, extra in found.items()}
    for name, extra in found.items():
        may[name] = set(LAYERS) | reachable(needs, name)
    for folder in sorted(p.name for p in (ROOT / "host/haptogram").iterdir() if p.is_dir() and p.name not in LAYERS):
        wrong.append(f"host/haptogram/{folder}: no such layer in tools/layers.py; add it to LAYERS with what it stands on")
    for name, folder in [(n, ROOT / f) for n, f in FOLDERS.items()] + [(n, e.folder) for n, e in found.items()]:
        files = sources(folder)
        if not files and name in LAYERS:
            wrong.append(f"{folder.relative_to(ROOT)}: layer {name} has no sources")
        for file in files:
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                included = (match := INCLUDE.match(line)) and owner_of(match[1], file, found)
                if not included or included == name:
                    continue
                if included not in may[name]:
                    allowed = ", ".join(sorted(may[name])) or "nothing"
                    wrong.append(f"{file.relative_to(ROOT)}:{number}: {name} may not include {included}; it may include {allowed}")
                elif name in LAYERS and included in LAYERS:
                    edges[name].add(included)
    return edges, wrong


def needed_for(headers):
    """The files that these headers of the core lead to: a header's source counts with it."""
    seen, left = set(), [ROOT / "host/haptogram" / header for header in headers]
    while left:
        file = left.pop()
        if file in seen:
            continue
        seen.add(file)
        for line in file.read_text(encoding="utf-8").splitlines():
            if (match := INCLUDE.match(line)) and match[1].startswith("haptogram/") and (ROOT / "host" / match[1]).exists():
                left.append(ROOT / "host" / match[1])
        stem = file.with_name("system_posix") if file.name == "system.hpp" else file.with_suffix("")
        if file.suffix == ".hpp" and (source := stem.with_suffix(".cpp")).exists():
            left.append(source)
    return seen


def lines_in(files):
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


def too_large():
    """A line for each purpose that needs more lines than it may."""
    for purpose, (headers, most) in PURPOSES.items():
        if (lines := lines_in(needed_for(headers))) > most:
            yield f"to {purpose} takes {lines} lines of the core; at most {most} (PURPOSES in tools/layers.py)"


def reachable(edges, start):
    """All that chains of edges lead to from a layer."""
    seen, todo = set(), list(edges[start])
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo += edges[name]
    return seen


def without_detours(edges):
    """Only the arrows that no chain of others replaces."""
    return {
        name: {to for to in targets if not any(to in reachable(edges, between) for between in targets - {to})} for name, targets in edges.items()
    }


def picture(edges):
    column = {name: layer["at"][0] for name, layer in LAYERS.items()}
    arrows = [(name, to) for name in LAYERS for to in LAYERS if to in without_detours(edges)[name]]
    lines = ["# SPDX-License-Identifier: Apache-2.0", "# Generated from the includes by tools/layers.py; tools/draw.py makes layers.svg from it.",
             'title = "The core: an arrow leads from a layer to what it includes"',
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


def core_table():
    lines = ["| layer | knows | stands on |", "|---|---|---|"]
    for name, layer in LAYERS.items():
        page = ROOT / FOLDERS[name] / "README.md"
        told = f"[{name}]({Path(os.path.relpath(page, ROOT / 'host')).as_posix()})" if page.exists() else name
        lines.append(f"| {told} | {layer['knows']} | {', '.join(layer['on']) or '–'} |")
    return lines


def extras_table(found):
    lines = ["| extra | commands | stands on |", "|---|---|---|"]
    for name, extra in found.items():
        commands = ", ".join(f"`{command}`" for command in extra.commands) or "–"
        lines.append(f"| [{name}]({name}/README.md) | {commands} | {', '.join(extra.needs) or 'the core'} |")
    return lines


def extras_list(found):
    return [f"- [{name}](extras/{name}/README.md): {extra.about}" for name, extra in found.items()]


def between(page, mark, lines):
    """The page with these lines between its marks."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->\n"
    before, rest = page.split(begin)
    return before + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 when what is written is stale")
    options = parser.parse_args()
    found = extras()
    edges, wrong = read_includes(found)
    wrong += too_large()
    for message in wrong:
        print(f"layers: {message}", file=sys.stderr)
    if wrong:
        return 1
    pages = [(PICTURE, picture(edges))]
    for name, mark, lines in (("host/README.md", "layers", core_table()), ("extras/README.md", "extras", extras_table(found)), ("README.md", "extras", extras_list(found))):
        pages.append((ROOT / name, between((ROOT / name).read_text(encoding="utf-8"), mark, lines)))
    for path, text in pages:
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        if options.check:
            print(f"layers: {path.relative_to(ROOT)} is stale; run tools/layers.py and tools/draw.py", file=sys.stderr)
            return 1
        path.write_text(text, encoding="utf-8")
    core = lines_in(f for folder in FOLDERS.values() for f in sources(ROOT / folder))
    print(f"layers: core {core} lines of C++; " + "; ".join(f"{purpose} {lines_in(needed_for(headers))} of {most}" for purpose, (headers, most) in PURPOSES.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
