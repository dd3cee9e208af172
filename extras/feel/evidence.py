#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What people felt of real devices, beside what `haptogram feel` says of them.

Usage: extras/feel/evidence.py [PROGRAM] [--check]; PROGRAM is build/release/host/cli/haptogram without it. Prints the table of
extras/feel/README.md; with --check, compares it with the page, and fails when a verdict contradicts what people felt, but for those that
the page names.
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "extras/feel/README.md"
BEGIN, END = "<!-- evidence -->\n", "<!-- end of evidence -->"

UNIT = (ROOT / "host/arrays/unit-249.toml").read_text(encoding="utf-8")
ULTRAHAPTICS = '[array]\nrows = 16\ncolumns = 20\npitch_mm = 10\n[board]\nname = "generic-320"\nconfiguration = "hoshi-324"\nchannels = 320\n'


def four_units():
    """Four units of 249 in a square, whose arrangement is ours."""
    begin = UNIT.index("elements_mm = [") + len("elements_mm = ")
    elements = json.loads(UNIT[begin : UNIT.index("]\nreach")].rstrip().rstrip(",") + "]")
    all_four = [[x + sx * 96, y + sy * 76] for sx in (-1, 1) for sy in (-1, 1) for x, y in elements]
    return f'[array]\nelements_mm = {all_four}\n[transducer]\nfile = "T4010A1"\n[board]\nname = "generic-996"\nconfiguration = "hoshi-324"\nchannels = 996\n'


def ring():
    """Fingers: ten places on the ellipse of a fingertip, a millisecond each."""
    turns = [2 * math.pi * i / 10 for i in range(10)]
    return "time_ms,x_mm,y_mm,z_mm\n" + "".join(f"{i},{3 * math.cos(t):.3f},{2 * math.sin(t):.3f},200\n" for i, t in enumerate([*turns, turns[0]]))


# Who; the device; what played, as options of compile, and of feel; what people felt; what was measured; what the verdict may be.
ROWS = [
    ("*Haptogram*, shapes", "100 MA40S4S, 20 V", "circle of 70 mm, 200 points, 10 Hz, 130 mm up",
     ["--shape", "circle", "--diameter", 70, "--points", 200, "--rate", 10], [],
     "15 people told 4 shapes apart, 59 %", "2.65 kPa by a transducer as microphone", {"felt", "perhaps"}),
    ("*Haptogram*, point", "100 MA40S4S, 20 V", "a focus 130 mm up, 1.852 kHz",
     ["--shape", "point", "--am", "square:1852"], [], "“clearly”", "2.95 kPa, the same", {"not felt"}),
    ("*Hoshi*", "324 T4010A1, 24 V", "a focus 200 mm up, square wave of 200 Hz",
     ["--array", "hoshi-18x18", "--shape", "point", "--center", "0,0,200", "--am", "square:200"], [],
     "all visitors who were asked knew its movements", "balance: 16 mN", {"felt"}),
    ("*Multimodal*", "256 T4010A1", "the same, half of the time at full command",
     ["--array", "usx-16x16", "--shape", "point", "--center", "0,0,200", "--am", "square:200"], [],
     "felt from 0.059 gf on, a ninth of this", "balance: 0.540 gf", {"felt"}),
    ("*Shapes*", "256 T4010A1", "circle of 60 mm at 7 m/s, 200 mm up",
     ["--array", "usx-16x16", "--shape", "circle", "--diameter", 60, "--points", 100, "--speed", 7, "--center", "0,0,200"], [],
     "“strong”, 16 people", "", {"felt", "perhaps"}),
    ("*Fingers*", "units of 249 T4010A1; here one", "10 places of an ellipse of 6 × 4 mm, 100 Hz, 200 mm away",
     ["ring.csv", "--array", "unit-249"], ["--region", "finger"], "people found a surface's angle", "", {"felt", "perhaps"}),
    ("*Carter et al. 2013* †", "320 MA40S4S", "a focus 200 mm up, square wave of 200 Hz",
     ["--array", "ultrahaptics.toml", "--shape", "point", "--center", "0,0,200", "--am", "square:200"], [],
     "frequencies and points told apart", "", {"felt"}),
    ("*Hasegawa and Shinoda 2018* †", "4 units of 249 T4010A1", "a focus 1 m away, sine of 200 Hz",
     ["--array", "four.toml", "--shape", "point", "--center", "0,0,1000", "--am", "sine:200"], [],
     "expected to be perceivable", "", {"felt", "perhaps"}),
    ("*Morisaki et al. 2022* †", "a focus that makes 27 mN", "circle of 6 mm (ours), 10 Hz",
     ["--array", "unit-249", "--shape", "circle", "--diameter", 6, "--points", 100, "--rate", 10, "--center", "0,0,200"], ["27 mN"],
     "as strong as a push of 0.21 N", "27 mN", {"felt", "perhaps"}),
]  # fmt: skip


def answer(program, folder, options, how):
    def run(*args):
        return subprocess.run([program, *map(str, args)], cwd=folder, check=True, capture_output=True, text=True).stdout

    is_path = str(options[0]).endswith(".csv")
    run("compile", *(["--path"] if is_path else []), *options, "-o", "image.hex")
    if how == ["27 mN"]:
        at_one = json.loads(run("feel", "image.hex", "--places", 1, "--level", 1, "--json"))["places"][0]["mean_mn"]
        how = ["--level", math.sqrt(27 / at_one)]
    return json.loads(run("feel", "image.hex", *how, "--json"))


def span(found):
    """The strongest place."""
    verdicts = [place["verdict"] for place in found["places"]]
    best = max(verdicts, key=lambda v: -math.inf if v["over_db"] is None else v["over_db"])
    if best["over_db"] is None:
        return found["answer"]
    return f"{found['answer']}: {best['over_db']:+.0f} dB, {best['least_db']:+.0f} to {best['most_db']:+.0f}"


def table(program):
    """The lines, and the rows whose verdict contradicts."""
    lines = ["| who | device | what played | people | measured | our models |", "|---|---|---|---|---|---|"]
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "ultrahaptics.toml").write_text(ULTRAHAPTICS)
        (folder / "four.toml").write_text(four_units())
        (folder / "ring.csv").write_text(ring())
        for who, device, played, options, how, people, measured, may_be in ROWS:
            found = answer(program, folder, options, how)
            lines.append(f"| {who} | {device} | {played} | {people} | {measured} | {span(found)} |")
            if found["answer"] not in may_be:
                wrong.append(f"{who}: {found['answer']}, expected {' or '.join(sorted(may_be))}")
    return "\n".join(lines) + "\n", wrong


def main():
    args = [a for a in sys.argv[1:] if a != "--check"]
    program = Path(args[0] if args else ROOT / "build/release/host/cli/haptogram").resolve()
    text, wrong = table(program)
    print(text, end="")
    if "--check" in sys.argv and text not in PAGE.read_text(encoding="utf-8"):
        wrong.append(f"{PAGE.relative_to(ROOT)} has another table between {BEGIN.strip()} and {END}")
    sys.exit("\n".join(wrong) if wrong else 0)


if __name__ == "__main__":
    main()
