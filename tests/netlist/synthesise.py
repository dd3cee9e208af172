#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesises haptogram_core with the parameters of a row of sim/models.cmake and writes the netlist as Verilog."""
import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
NAMES = "CHANNELS RECORDS SEQUENCE_DEPTH LIVE_DEPTH TIMING_BITS PULSE_BITS CLOCK_HZ BAUD WATCHDOG_MS MAX_HIGH_CLOCKS".split()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--family", choices=["ice40", "ecp5"], required=True)
    parser.add_argument("--model", required=True, help="row of sim/models.cmake")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    row = re.search(rf'"{options.model}:([^"]*)"', (ROOT / "sim" / "models.cmake").read_text())
    if not row:
        parser.error(f"sim/models.cmake has no {options.model}")
    sets = " ".join(f"-set {name} {value}" for name, value in zip(NAMES, row[1].split(":")))
    options.output.parent.mkdir(parents=True, exist_ok=True)
    script = f"""read_verilog -I{ROOT}/rtl {' '.join(str(p) for p in sorted(ROOT.glob('rtl/*.v')))}
chparam {sets} haptogram_core
synth_{options.family} {'-nodsp' if options.family == 'ecp5' else ''} -top haptogram_core
chtype -set dp16kd t:DP16KD
splitnets
write_verilog -noattr {options.output}
"""
    return subprocess.run(["yosys", "-q", "-l", f"{options.output}.log", "-p", script]).returncode


if __name__ == "__main__":
    sys.exit(main())
