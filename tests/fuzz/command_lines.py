# SPDX-License-Identifier: Apache-2.0
"""Runs the program with random command lines: every verb that reads something, on every source, with options of its own that are drawn
at random. It may refuse; it may not crash, run on for ever, or end with another exit code than the documented ones. Meant for a program
that was built with sanitizers (PRESET=dev), whose findings are errors here."""

import argparse
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

VERBS = ("compile", "inspect", "simulate", "solve", "field", "analyze", "report", "feel", "scatter", "magnitude", "render", "movement",
         "robot workspace", "robot ik", "robot fk", "board pinout", "board show")  # fmt: skip
# How the sources are made, by the program itself.
PROJECT = 'format = "haptogram-project-1"\npoints = 6\nrate_hz = 20\n\n[[shape]]\nkind = "circle"\ndiameter_mm = 30\n'
SOURCES = {
    "timings.hex": ["compile", "--shape", "circle", "--points", "5"],
    "one.hex": ["compile", "--shape", "point"],
    "amplitudes.hex": ["compile", "--shape", "circle", "--points", "4", "--board", "tile-100-wide", "--array", "tile-10x10", "--amplitude", "0.5", "--records"],
    "foci.hex": ["compile", "--shape", "circle", "--points", "6", "--board", "tile-100-wide", "--array", "tile-10x10", "--foci"],
    "modulated.hex": ["compile", "--shape", "point", "--board", "tile-100-wide", "--array", "tile-10x10", "--foci", "--am", "sine:200"],
    "wall.hex": ["compile", "--shape", "circle", "--points", "4", "--rig", "2x2"],
}
POOLS = {
    "at": ["0,0,130", "10,0,150", "nan,0,1", "1,2"],
    "focus": ["0,0,130", "10,0,150", "0,0,150,0", "20,5,140,0.5", "0,0,0", "1e9,0,1"],
    "normal": ["0,0,-1", "0,0,0", "1,1,1"],
    "ear": ["0,-400,300", "0,0,130"],
    "plane": ["xy@z=130", "xz@y=0", "uv@x=0,y=0,z=130,rx=30", "xy@z=", "no@z=1"],
    "line": ["z@x=0,y=0", "x@y=0,z=130", "q@"],
    "x": ["-10:10", "5:1", "0:0"], "y": ["-10:10"], "z": ["100:150", ":"],
    "array": ["tile-10x10", "hoshi-18x18", "tile-7x8", "nothing"],
    "board": ["small-16", "tile-100-wide", "ice40-hx8k-breakout", "nothing"],
    "rig": ["2x2", "hoshi-9x36", "cube-300", "nothing"],
    "shape": ["circle", "sphere", "point", "helix", "polygon", "nothing"],
    "am": ["static", "sine:200", "square:100:25", "square:0", "sine"],
    "center": ["0,0,130", "1"], "rotate": ["0,0,45"],
    "output": ["out.csv", "out.png", "out.vti", "out.npy", "out.hex", "out.json", "-", "out.stl", "no/such/folder.csv"],
    "pulses": ["pulses.csv", "foci.csv", "nothing.csv"],
    "manifest": ["timings.json", "foci.json", "wall.json"],
}  # fmt: skip
NUMBERS = ["0", "1", "2", "3", "5", "8", "0.5", "-1", "100", "1e3", "4294967296", "nan"]
SLOW = {"--volume", "--wait"}
CODES = {0, 1, 2, 3, 4}
FOUND = re.compile(r"AddressSanitizer|LeakSanitizer|runtime error:|Assertion|terminate called", re.MULTILINE)


def call(program, folder, words, seconds):
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=0:exitcode=99", "UBSAN_OPTIONS": "print_stacktrace=1"}
    try:
        done = subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, env=environment)
    except subprocess.TimeoutExpired:
        return None, ""
    return done.returncode, done.stderr.decode(errors="replace")


def options_of(program, folder, verb):
    """(name, type) of each option that the verb's help lists; the type is empty for a flag."""
    said = subprocess.run([program, *verb.split(), "--help"], cwd=folder, capture_output=True, text=True).stdout
    found = re.findall(r"^  (?:-\w,)?--([\w-]+)(?: ([A-Z]+[^\s=]*))?", said, re.MULTILINE)
    return [(name, kind) for name, kind in found if name not in ("help", "port", "threads")]


def value(draw, name, kind):
    if choices := re.search(r"\{([^}]*)\}", kind):
        return draw.choice(choices[1].split(",") + ["nothing"])
    return draw.choice(POOLS.get(name, NUMBERS if kind.startswith(("UINT", "FLOAT")) else ["x", "", "1,2,3", "timings.hex"]))


def line(draw, options, verb):
    words = verb.split()
    if draw.random() < 0.85:
        words += [draw.choice([*SOURCES, "project.toml", "path.json", "wall.json", "point.xyz", "foci.json", "nothing.hex", "pulses.csv"])]
    for name, kind in draw.sample(options, min(len(options), draw.choice([0, 0, 0, 1, 1, 1, 2, 3]))):
        if f"--{name}" in SLOW:
            continue
        words.append(f"--{name}" if not kind else f"--{name}={value(draw, name, kind)}")
    if "pulses" in dict(options) and draw.random() < 0.15:
        which = draw.choice(["timings", "foci", "modulated", "amplitudes"])
        words = [*verb.split(), f"--pulses={which}.csv", f"--manifest={which}.json"]
    if verb == "field" and not any(w.startswith("--step") for w in words):
        words.append("--step=8")
    return words


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120, help="that one may take")
    parser.add_argument("--verb", action="append", help="only these")
    given = parser.parse_args()
    program, wrong, codes = given.program.resolve(), [], {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "project.toml").write_text(PROJECT, encoding="utf-8")
        made = [[*words, "-o", file] for file, words in SOURCES.items()] + [["compile", "project.toml", "--save-path", "path.json", "-o", "saved.hex"]]
        made += [["simulate", f"{which}.hex", "--load=direct", "--duration=2", "--pulses", f"{which}.csv"] for which in ("timings", "foci", "modulated", "amplitudes")]
        (folder / "pulses.csv").touch()
        (folder / "point.xyz").write_text("5 0 140\n", encoding="utf-8")
        for words in made:
            code, said = call(program, folder, words, given.seconds)
            if code not in (0, 1) or FOUND.search(said):
                wrong.append(f"haptogram {' '.join(words)}\n  code {code}\n{said[-3000:]}")
        if (folder / "timings.csv").exists():
            (folder / "pulses.csv").write_bytes((folder / "timings.csv").read_bytes())
        verbs = given.verb or VERBS
        options = {verb: options_of(program, folder, verb) for verb in verbs}
        draw, begun = random.Random(given.seed), time.monotonic()
        for _ in range(given.runs):
            words = line(draw, options[verb := draw.choice(verbs)], verb)
            code, said = call(program, folder, words, given.seconds)
            codes[code] = codes.get(code, 0) + 1
            if code not in CODES or FOUND.search(said):
                wrong.append(f"haptogram {' '.join(words)}\n  {'took too long' if code is None else f'code {code}'}\n{said[-3000:]}")
    print(f"{given.runs} command lines, seed {given.seed}, {time.monotonic() - begun:.0f} s; exit codes {dict(sorted(codes.items(), key=str))}")
    print(f"{given.runs - len(wrong)} passed, {len(wrong)} failed")
    sys.exit("\n".join(wrong) or 0)


if __name__ == "__main__":
    main()
