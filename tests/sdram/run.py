#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Records in an SDRAM, simulated by Icarus on a chip that notes whatever its data sheet forbids (sdram_bench.v, sdram_chip.v).

For both sizes, records are read beside a writer that never rests: all come whole, none older than what had been written, in at most 3 µs, and the
chip notes nothing. Then each of the chip's times is made longer than what the controller leaves, and its clock is shifted too far: the chip must
notice. HAPTOGRAM_SDRAM_READS is how many records are read, 1,000 unless set. Exit code 1 when anything is not as it should be.
"""
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOST_CLOCKS = 150  # 3 µs at 50 MHz
SUMMARY = re.compile(r"(\d+) reads, (\d+) writes, (\d+) wrong, (\d+) torn, (\d+) old, worst (\d+) clocks, mean ([\d.]+), (\d+) refreshes, (\d+) violations")
# What the chip calls it, and a time that the controller does not keep: a clock more than what its commands are apart at least.
TOO_LONG = {"start": ("T_START", 200200), "tRCD": ("T_RCD", 41), "tRP": ("T_RP", 41), "tRAS": ("T_RAS", 61), "tRC": ("T_RC", 300), "tRRD": ("T_RRD", 300),
            "tRFC": ("T_RFC", 81), "tWR": ("T_WR", 41), "tMRD": ("T_MRD", 200), "refresh is overdue": ("T_REFRESH", 5000)}  # fmt: skip


def simulate(parameters):
    """What the bench says with these parameters."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "bench"
        options = [f"-Psdram_bench.{name}={value}" for name, value in parameters.items()]
        sources = sorted(map(str, [*(ROOT / "rtl/sdram").glob("*.v"), *(ROOT / "tests/sdram").glob("*.v"), ROOT / "rtl/amplitudes/focus_place.v"]))
        subprocess.run(["iverilog", "-g2005", f"-I{ROOT}/rtl", "-s", "sdram_bench", "-o", program, *options, *sources], check=True)
        return subprocess.run(["vvp", "-n", program], capture_output=True, text=True, check=True).stdout


def good(mib):
    """The problems of a run with the chip as it is; empty when there are none."""
    said = simulate({"MIB": mib, "READS": os.environ.get("HAPTOGRAM_SDRAM_READS", "1000")})
    found = SUMMARY.search(said)
    print(f"{mib} MiB: {found[0] if found else 'no summary'}", flush=True)
    if not found:
        return f"{mib} MiB: the bench ends without its summary:\n{said[-600:]}"
    reads, writes, wrong, torn, old, worst, _, _, violations = (float(text) for text in found.groups())
    if wrong or torn or old or violations or worst > MOST_CLOCKS or writes < reads / 2:
        return f"{mib} MiB: expected nothing wrong, torn, old or violated, and at most {MOST_CLOCKS} clocks:\n{said[-600:]}"
    return ""


def noticed(name, parameters):
    """The same of a run in which the chip must note this."""
    said = simulate({"READS": 15, **parameters})
    return "" if f"violation: {name} at" in said else f"{parameters}: expected a violation of '{name}', found:\n{said[-600:]}"


def shifted(phase):
    """The same of a chip whose clock comes at a wrong time: something must be wrong with what is read."""
    said = simulate({"READS": 15, "PHASE_NS": phase})
    found = SUMMARY.search(said)
    return f"a phase of {phase} ns does no harm:\n{said[-600:]}" if found and found[3] == "0" and found[9] == "0" else ""


def main():
    with ThreadPoolExecutor(2) as workers:
        runs = [workers.submit(good, mib) for mib in (4, 8)]
        runs += [workers.submit(noticed, name, {parameter: value}) for name, (parameter, value) in TOO_LONG.items()]
        runs += [workers.submit(shifted, phase) for phase in (0, 13)]
        problems = [problem for run in runs if (problem := run.result())]
    print(f"{len(runs) - len(problems)} of {len(runs)} runs are as they should be")
    sys.exit("\n".join(problems) or 0)


if __name__ == "__main__":
    main()
