# SPDX-License-Identifier: Apache-2.0
"""What another simulator than Verilator can say: the core elaborates with each parameter at both ends of its range and not just
outside of them, and no output is unknown after a reset of one clock."""

import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# What other parameters must be, so that a value in its range is refused by nothing else.
BESIDE = {
    "CHANNELS": {"RECORDS": 2},
    "RECORDS": {"CHANNELS": 2},
    "SEQUENCE_DEPTH": {"RECORDS": 2, "CHANNELS": 2},
    "CLOCK_HZ": {"BAUD": 100000, "MAX_HIGH_CLOCKS": 100000},
    "BAUD": {"CLOCK_HZ": 1000000000},
    "TIMING_BITS": {"PULSE_BITS": 4},
    "WIDTH_BITS": {"CHANNELS": 2, "TIMING_BITS": 16, "PULSE_BITS": 6, "MAX_HIGH_CLOCKS": 1000000},
    "MIN_PULSE_CLOCKS": {"MAX_HIGH_CLOCKS": 16777215},
    "MAX_HIGH_CLOCKS": {"MIN_PULSE_CLOCKS": 1},
    "STREAM": {"SCHEDULE": 1, "RECORDS": 1024, "CHANNELS": 2},
    "TRIGGER": {"SCHEDULE": 1},
}
SOURCES = [str(path) for folder in ("rtl", "rtl/amplitudes", "rtl/time", "rtl/sdram") for path in sorted((ROOT / folder).glob("*.v"))]
WIDE = {"WIDTH_BITS": 10, "TIMING_BITS": 11, "PULSE_BITS": 8}


def elaborates(parameters):
    """Whether it does, and what was said."""
    options = [f"-Phaptogram_core.{name}={value}" for name, value in parameters.items()]
    command = ["iverilog", "-g2005", "-Irtl", "-s", "haptogram_core", "-t", "null", *options, *SOURCES]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.returncode == 0, done.stderr


def cases():
    """(parameter, values of all that are not the default, whether they elaborate)"""
    for row in tomllib.loads((ROOT / "tools/interface.toml").read_text(encoding="utf-8"))["parameter"]:
        name = row["name"]
        beside = dict(BESIDE.get(name, {}))
        if "needs" in row:
            beside |= WIDE
        low, high = row["low"], row["high"]
        if name == "BAUD":
            low = beside["CLOCK_HZ"] // 20000
        for value, good in ((low, True), (high, True), (low - 1, False), (high + 1, False)):
            yield name, {**beside, name: value}, good
        if row.get("power_of_two"):
            yield name, {**beside, name: low + 1}, False
        if row.get("optional"):
            yield name, {**beside, name: 0}, True
        if "needs" in row:
            yield name, {name: high}, False
    yield "STREAM", {"STREAM": 16, "SCHEDULE": 1}, False
    yield "PULSE_BITS", {"TIMING_BITS": 4, "PULSE_BITS": 5}, False
    yield "BAUD", {"CLOCK_HZ": 1000000, "BAUD": 125001}, False
    yield "MIN_PULSE_CLOCKS", {"MIN_PULSE_CLOCKS": 1001}, False


def unknown_after_reset(wide, many):
    """What short_reset.v says against the core; empty when nothing."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "short_reset"
        options = [f"-Pshort_reset.WIDE={wide}", f"-Pshort_reset.MANY={many}"]
        sources = ["tests/modules/short_reset.v", *SOURCES]
        subprocess.run(["iverilog", "-g2005", "-Irtl", "-s", "short_reset", "-o", program, *options, *sources], cwd=ROOT, check=True)
        said = subprocess.run(["vvp", "-n", program], capture_output=True, text=True, check=True).stdout
    return "" if said.strip() == "known" else said


def main():
    wrong = []
    all_cases = list(cases())
    with ThreadPoolExecutor(2) as workers:
        for (name, parameters, good), (done, said) in zip(all_cases, workers.map(lambda case: elaborates(case[1]), all_cases)):
            if done != good or (not good and f"{name.lower()}_out_of_range" not in said):
                wrong.append(f"{parameters}: {'elaborates' if done else 'does not elaborate'}\n{said[-600:]}")
        resets = [(0, 0), (1, 0), (0, 1), (1, 1)]
        wrong += [f"{settings}: {said}" for settings, said in zip(resets, workers.map(lambda s: unknown_after_reset(*s), resets)) if said]
    print(f"{len(all_cases) + len(resets) - len(wrong)} passed, {len(wrong)} failed")
    sys.exit("\n".join(wrong) or 0)


if __name__ == "__main__":
    main()
