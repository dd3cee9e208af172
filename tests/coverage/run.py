#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the co-simulation tests once on cores that count, and says which lines of rtl/ they reach and which bits they change.

Exit code 0 when 95 % of the lines are reached and exceptions.toml explains exactly the others, 1 otherwise, 2 on a wrong
table or command line, or when a test fails.
"""
import argparse
import collections
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
REQUIRED = 0.95
# Of each program all that run on the models that count; a long count reaches no further line.
COSIM = "~[tile100]~[whole]~[long]"
PROGRAMS = {
    "test_cosim_coverage": COSIM,
    "test_port_coverage": "~[long]",
}
FOLDERS = ("rtl", "rtl/amplitudes", "rtl/time", "rtl/net")


class Wrong(Exception):
    """A test, the table or the data is not as expected."""


def measure(program, tests, folder):
    """Coverage points with their counts, as dictionaries of Verilator's one-letter keys."""
    data = folder / f"{program.name}.dat"
    data.unlink(missing_ok=True)
    done = subprocess.run([program, tests, "--rng-seed", "1"], env={**os.environ, "HAPTOGRAM_COVERAGE": str(data)}, capture_output=True, text=True)
    if done.returncode != 0 or not data.exists():
        raise Wrong(f"{program.name}: the tests fail, or count nothing\n{done.stdout[-3000:]}{done.stderr[-1000:]}")
    points = []
    for line in data.read_text().splitlines():
        match = re.fullmatch(r"C '(.*)' (\d+)", line)
        if match:
            points.append({**dict(re.findall("\x01([^\x02]+)\x02([^\x01]*)", match[1])), "count": int(match[2])})
    return [p for p in points if folder_of(p) in FOLDERS]


def folder_of(point):
    folder = Path(point["f"]).resolve().parent
    return str(folder.relative_to(ROOT)) if folder.is_relative_to(ROOT) else ""


def file_of(point):
    """Within rtl/."""
    return str(Path(point["f"]).resolve().relative_to(ROOT / "rtl"))


def expand(ranges):
    """60,68-70 → 60, 68, 69, 70."""
    for part in ranges.split(","):
        first, _, last = part.partition("-")
        yield from range(int(first), int(last or first) + 1)


def lines_of(points):
    """For each file, how often each line was reached: where a line has several branches, its least."""
    branches = collections.Counter()
    for p in points:
        if not p["page"].startswith("v_toggle"):
            for line in expand(p.get("S", p["l"])):  # a missing else has no lines of its own
                branches[file_of(p), line, p["l"], p["n"], p["o"]] += p["count"]
    least = collections.defaultdict(dict)
    for (file, line, *_), count in branches.items():
        least[file][line] = min(count, least[file].get(line, count))
    return least


def bits_of(points):
    """For each file, every bit and whether it went there and back."""
    bits = collections.defaultdict(dict)
    for p in points:
        if p["page"].startswith("v_toggle"):
            name = f"{p['h'].removeprefix('TOP.')}.{p['o']}"
            bits[file_of(p)][name] = bits[file_of(p)].get(name, False) or p["count"] >= 2
    return bits


def exceptions():
    rows = tomllib.loads((HERE / "exceptions.toml").read_text()).get("exception", [])
    for row in rows:
        if set(row) != {"file", "line", "reason"} or not row["reason"].strip():
            raise Wrong(f"exceptions.toml: each has a file, a line and a reason, not {row}")
    return {(row["file"], row["line"].strip()): row["reason"] for row in rows}


def share(part, whole):
    return f"{part} of {whole}, {part / whole:.1%}" if whole else "none"


def run(options):
    options.build.mkdir(parents=True, exist_ok=True)
    points = [p for program, tests in PROGRAMS.items() for p in measure(options.programs / program, tests, options.build)]
    lines, bits, excused, used = lines_of(points), bits_of(points), exceptions(), set()
    table, problems = [], []
    for file in sorted(set(lines) | set(bits)):
        source = (ROOT / "rtl" / file).read_text().splitlines()
        missed = sorted(number for number, count in lines[file].items() if count == 0)
        for number in missed:
            text = source[number - 1].strip()
            used.add((file, text))
            if (file, text) not in excused:
                problems.append(f"rtl/{file}:{number} is not reached, and exceptions.toml does not say why: {text}")
        table.append({"file": file, "lines": len(lines[file]), "reached": len(lines[file]) - len(missed), "missed": missed,
                      "bits": len(bits[file]), "toggled": sum(bits[file].values()), "still": sorted(b for b, moved in bits[file].items() if not moved)})
    problems += [f"exceptions.toml lists a line of rtl/{file} that is reached or not there: {text}" for file, text in excused if (file, text) not in used]
    total = {"file": "all", **{key: sum(row[key] for row in table) for key in ("lines", "reached", "bits", "toggled")}}
    if total["reached"] < REQUIRED * total["lines"]:
        problems.append(f"{share(total['reached'], total['lines'])} of the lines are reached, {REQUIRED:.0%} are asked for")

    markdown = ["| file | lines reached | bits toggled |", "|---|---|---|"]
    for row in [*table, total]:
        cells = [row["file"], share(row["reached"], row["lines"]), share(row["toggled"], row["bits"])]
        markdown.append(f"| {' | '.join(cells)} |")
        print(f"{cells[0]:<22} {cells[1]:<22} {cells[2]}")
    for problem in problems:
        print(f"    {problem}")
    (options.build / "coverage.md").write_text("\n".join(markdown) + "\n")
    (options.build / "coverage.json").write_text(json.dumps({"total": total, "files": table}, indent=1) + "\n")
    return 1 if problems else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    build = ROOT / "build" / "deep" / "tests" / "coverage"
    parser.add_argument("--programs", metavar="DIR", type=Path, default=build, help="where the tests on cores that count are")
    parser.add_argument("--build", metavar="DIR", type=Path, default=build, help="where the data and the reports go")
    options = parser.parse_args()
    try:
        return run(options)
    except (Wrong, OSError, KeyError, tomllib.TOMLDecodeError) as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
