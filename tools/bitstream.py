#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesises, places and routes boards of constraints/*.toml, with nothing but open tools.

Leaves in OUTPUT/BOARD/: BOARD.bin or .bit with empty memories, what `haptogram bitstream` needs to put an image into it
(placed.asc or placed.config, primary.hex, sequence.hex), core.v (the netlist of haptogram_core that was placed, for tests/netlist), the tools'
logs, and report.json. Exit code 0, 1 when a tool fails or a budget of constraints/budgets.toml is exceeded, 2 on wrong usage.
"""
import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BOARDS = ROOT / "constraints"
VENV = ROOT / "build" / "venv" / "bin"
RECORD_HEADER_WORDS = tomllib.loads((ROOT / "tools" / "interface.toml").read_text())["record"]["header_words"]
BLOCK_WORDS = 256  # of icebram


class Failed(Exception):
    """A tool or a budget."""


def tool(name):
    """A program from Debian, or its PyPI build in the project's environment."""
    found = shutil.which(name) or shutil.which(str(VENV / f"yowasp-{name}"))
    if not found:
        raise Failed(f"{name} is not installed; tools/setup installs it")
    return found


def run(folder, log, *command, stdin=None, stdout=None):
    """Runs a tool in `folder`; its output goes to `log`. Returns the seconds it took."""
    start = time.monotonic()
    with open(folder / log, "w") as out:
        source = open(folder / stdin, "rb") if stdin else subprocess.DEVNULL
        target = open(folder / stdout, "wb") if stdout else out
        code = subprocess.run([str(c) for c in command], cwd=folder, stdin=source, stdout=target, stderr=out).returncode
    if code != 0:
        tail = "\n  ".join((folder / log).read_text(errors="replace").splitlines()[-8:])
        raise Failed(f"{Path(command[0]).name} failed ({code}), see {folder / log}:\n  {tail}")
    return time.monotonic() - start


def load(name):
    path = BOARDS / f"{name}.toml"
    if not path.exists():
        known = ", ".join(board_names())
        raise Failed(f"no board {name}; there are {known}")
    return tomllib.loads(path.read_text())


def board_names():
    return sorted(p.stem for p in BOARDS.glob("*.toml") if p.stem != "budgets")


def memories(board):
    """Width and depth of the memories that an image fills, by the name of their parameter."""
    p = board["parameters"]
    return {"primary": (16, p["RECORDS"] * (p["CHANNELS"] + RECORD_HEADER_WORDS)), "sequence": (32, p["SEQUENCE_DEPTH"])}


def fingerprint(folder, board):
    """Random contents, by which the block RAMs of a placed design are found again; and empty ones for the bitstream."""
    for seed, (name, (width, depth)) in enumerate(memories(board).items(), 1):
        words = random.Random(seed)
        lines = [f"{words.getrandbits(width):0{width // 4}x}\n" for _ in range(depth)]
        # icebram takes whole blocks; where a memory ends within one, its rest is zero.
        zero = "0" * (width // 4) + "\n"
        padding = [zero] * (-depth % BLOCK_WORDS)
        (folder / f"{name}_init.hex").write_text("".join(lines))
        (folder / f"{name}.hex").write_text("".join(lines + padding))


def synthesise(folder, board):
    family, top = board["fpga"]["family"], board["fpga"]["top"]
    sources = sorted(ROOT.glob("rtl/*.v")) + [ROOT / "rtl" / "boards" / f"{top}.v"]
    if family == "ecp5":
        sources.append(ROOT / "rtl" / "boards" / "ecp5_50mhz.v")
    pins = board["pins"]
    defines = (["-DHG_LED"] if "led" in pins else []) + ([f"-DHG_HIGH={len(pins['high'])}"] if pins.get("high") else [])
    parameters = dict(board["parameters"])
    if family == "ecp5" and pins.get("led_active_low"):
        parameters["LED_ACTIVE_LOW"] = 1
    sets = " ".join(f"-set {k} {v}" for k, v in parameters.items())
    files = " ".join(f'-set {n.upper()}_FILE "{n}_init.hex"' for n in memories(board))
    # Without the one multiplier, for which Yosys has no simulation model.
    synth = "synth_ice40" if family == "ice40" else "synth_ecp5 -nodsp"
    # The core stays a module of its own, so that what is tested is what is placed.
    (folder / "synth.ys").write_text(f"""read_verilog {' '.join(defines)} -I{ROOT}/rtl {' '.join(map(str, sources))}
chparam {sets} {files} {top}
hierarchy -top {top}
setattr -mod -set keep_hierarchy 1 *haptogram_core
{synth} -top {top} -json {top}.json
tee -q -o stat.txt stat
delete {top}
hierarchy -auto-top
rename -top haptogram_core
chtype -set dp16kd t:DP16KD
splitnets
write_verilog -noattr core.v
""")
    return run(folder, "yosys.log", tool("yosys"), "-q", "synth.ys")


def constraints(board):
    """The pin file of nextpnr: .pcf for the iCE40, .lpf for the ECP5."""
    pins, channels = board["pins"], board["parameters"]["CHANNELS"]
    sites = [("i_clk", pins["clk"]), ("i_rx", pins["rx"]), ("o_tx", pins["tx"])]
    sites += [("o_led", pins["led"])] if "led" in pins else []
    sites += [(f"o_high[{i}]", ball) for i, ball in enumerate(pins.get("high", []))]
    sites += [(f"o_pins[{k}]", row[3]) for k, row in enumerate(board["outputs"][:channels])]
    if board["fpga"]["family"] == "ice40":
        return "pins.pcf", "".join(f"set_io {'-pullup yes ' if port == 'i_rx' else ''}{port} {ball}\n" for port, ball in sites)
    text = "".join(f'LOCATE COMP "{port}" SITE "{ball}";\nIOBUF PORT "{port}" IO_TYPE=LVCMOS33'
                   f'{" PULLMODE=UP" if port == "i_rx" else ""};\n' for port, ball in sites)
    return "pins.lpf", text + 'FREQUENCY PORT "i_clk" 25 MHz;\n'


def place(folder, board, name, seed, goal_mhz, placed, report):
    fpga = board["fpga"]
    command = [tool(f"nextpnr-{fpga['family']}"), f"--{fpga['device']}", "--package", fpga["package"], "--json", f"{fpga['top']}.json",
               f"--{name.split('.')[1]}", name, "--freq", f"{goal_mhz:.1f}", "--seed", seed, "--report", report, "--timing-allow-fail"]
    if fpga["family"] == "ice40":
        command += ["--asc", placed]
    else:
        command += ["--textcfg", placed, "--speed", fpga["speed"]]
    return run(folder, f"nextpnr_{seed}.log", *command)


def cells(utilisation, family):
    """(logic cells or LUTs used, available, block RAMs used, available)"""
    logic, ram = ("ICESTORM_LC", "ICESTORM_RAM") if family == "ice40" else ("TRELLIS_COMB", "DP16KD")
    return tuple(utilisation[kind][key] for kind in (logic, ram) for key in ("used", "available"))


def build(name, output, seeds, program):
    board, start = load(name), time.monotonic()
    folder = output / name
    folder.mkdir(parents=True, exist_ok=True)
    family, clock_mhz = board["fpga"]["family"], board["parameters"]["CLOCK_HZ"] / 1e6
    budget = tomllib.loads((BOARDS / "budgets.toml").read_text())[family]
    goal = budget["clock_margin"] * clock_mhz
    say = lambda text: print(f"{name}: {text}", file=sys.stderr, flush=True)
    fingerprint(folder, board)
    pins, text = constraints(board)
    (folder / pins).write_text(text)
    say(f"synthesised in {synthesise(folder, board):.0f} s")
    reports = []
    for seed in range(1, seeds + 1):
        placed = f"placed_{seed}.{'asc' if family == 'ice40' else 'config'}"
        seconds = place(folder, board, pins, seed, goal, placed, f"nextpnr_{seed}.json")
        report = json.loads((folder / f"nextpnr_{seed}.json").read_text())
        fmax = min(v["achieved"] for v in report["fmax"].values())
        reports.append((fmax, placed, report))
        say(f"seed {seed} of {seeds} placed and routed in {seconds:.0f} s, {fmax:.1f} MHz")
    best = max(reports, key=lambda r: r[0])
    os.replace(folder / best[1], folder / f"placed.{best[1].split('.')[1]}")
    for _, spare, _ in reports:
        (folder / spare).unlink(missing_ok=True)
    if program:
        run(folder, "pack.log", program, "bitstream", "--board", BOARDS / f"{name}.toml", "--placed", output, "--empty",
            "-o", f"{name}.{'bin' if family == 'ice40' else 'bit'}")
    used, available, rams, ram_available = cells(best[2]["utilization"], family)
    result = {"board": name, "fpga": board["fpga"], "parameters": board["parameters"], "cells": used, "cells_available": available,
              "block_rams": rams, "block_rams_available": ram_available, "clock_mhz": clock_mhz,
              "fmax_mhz": {"lowest": min(r[0] for r in reports), "highest": best[0], "seeds": seeds, "goal": goal},
              "seconds": time.monotonic() - start}
    (folder / "report.json").write_text(json.dumps(result, indent=2) + "\n")
    problems = []
    if used > budget["cells"]:
        problems.append(f"{used} cells, the budget is {budget['cells']}")
    if result["fmax_mhz"]["lowest"] < goal:
        problems.append(f"{result['fmax_mhz']['lowest']:.1f} MHz, the budget is {goal:.1f} MHz")
    return result, problems


def table(results):
    head = "| board | channels | timing bits | cells | block RAMs | lowest MHz (seeds) | goal MHz | seconds |\n|---|---|---|---|---|---|---|---|\n"
    return head + "".join(
        f"| {r['board']} | {r['parameters']['CHANNELS']} | {r['parameters']['TIMING_BITS']} | {r['cells']:,} of {r['cells_available']:,} "
        f"({100 * r['cells'] / r['cells_available']:.1f} %) | {r['block_rams']} of {r['block_rams_available']} "
        f"| {r['fmax_mhz']['lowest']:.1f} ({r['fmax_mhz']['seeds']}) | {r['fmax_mhz']['goal']:.1f} | {r['seconds']:.0f} |\n" for r in results)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("boards", metavar="BOARD", nargs="*", help="of constraints/; none: all")
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "boards")
    parser.add_argument("--seeds", type=int, default=1, help="place and route with this many seeds and take the fastest (1)")
    parser.add_argument("--program", type=Path, help="haptogram, to pack the bitstream with; without it there is none")
    options = parser.parse_args()
    results, failed = [], False
    try:
        for name in options.boards or board_names():
            result, problems = build(name, options.output.resolve(), options.seeds, options.program and options.program.resolve())
            results.append(result)
            failed |= bool(problems)
            for problem in problems:
                print(f"{name}: over budget: {problem}", file=sys.stderr)
    except Failed as error:
        print(f"bitstream: {error}", file=sys.stderr)
        failed = True
    if results:
        print(table(results), end="")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
