#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesises, places and routes boards of constraints/*.toml, with nothing but open tools.

Leaves in OUTPUT/BOARD/: BOARD.bin or .bit with empty memories, what `haptogram bitstream` needs to put an image into it
(placed.asc or placed.config, primary.hex, sequence.hex), core.v (the netlist of haptogram_core that was placed, for tests/netlist), the tools'
logs, and report.json. With --configuration the core alone in that configuration, for a question of size: placed and routed in
OUTPUT/BOARD-CONFIGURATION, without pins or a bitstream. Exit code 0, 1 when a tool fails or the budget in the board's file is exceeded, 2 on wrong usage.
"""
import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import boards
import configurations

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / "build" / "venv" / "bin"
RECORD_HEADER_WORDS = configurations.load()["record"]["header_words"]
AUTOSTART = sum(1 << f["low"] for f in configurations.load()["sequence_header"]["fields"] if f["name"] == "autostart")
BLOCK_WORDS = 256  # of icebram
NETWORK_MHZ = 125  # of a gigabit PHY
HEADING = """<!-- SPDX-License-Identifier: Apache-2.0 -->
# The last builds, by `make bitstreams`

A row is of its board's last build, maybe of older sources; boards without one were never placed.

- channels, records, timing bits: the core's parameters CHANNELS, RECORDS and TIMING_BITS
- cells, block RAMs: used of the FPGA's; flip-flops a channel: the pulse generators'
- lowest MHz: of so many placements (seeds); goal MHz: the clock and a margin; network MHz: lowest, of 125; seconds: the build's

"""


class Failed(Exception):
    """A tool or a budget."""


def tool(name):
    """A program from Debian, or its PyPI build in the project's environment."""
    found = shutil.which(name) or shutil.which(str(VENV / f"yowasp-{name}"))
    if not found:
        raise Failed(f"{name} is not installed; tools/setup board installs it")
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
    board = boards.load(name)
    board["parameters"] = configurations.parameters_of(board)
    return board


def memories(board):
    """Width and depth of the memories that an image fills, by the name of their parameter."""
    p = board["parameters"]
    primary = {} if p["SDRAM"] else {"primary": (16, p["RECORDS"] * (p["CHANNELS"] + RECORD_HEADER_WORDS))}
    return primary | {"sequence": (32, p["SEQUENCE_DEPTH"])}


def fingerprint(folder, board, empty):
    """Random contents, by which the block RAMs of a placed design are found again for an image; or none, for a bitstream without one."""
    for seed, (name, (width, depth)) in enumerate(memories(board).items(), 1):
        words = random.Random(seed)
        contents = [0 if empty else words.getrandbits(width) for _ in range(depth)]
        if name == "sequence":
            contents[0] &= ~AUTOSTART  # a placed design without an image must never start by itself
        lines = [f"{word:0{width // 4}x}\n" for word in contents]
        # icebram takes whole blocks; where a memory ends within one, its rest is zero.
        zero = "0" * (width // 4) + "\n"
        padding = [zero] * (-depth % BLOCK_WORDS)
        (folder / f"{name}_init.hex").write_text("".join(lines))
        (folder / f"{name}.hex").write_text("".join(lines + padding))


def defines(board):
    """What the board's top takes from its file: options of Yosys, and of whatever reads Verilog."""
    pins = board["pins"]
    given = {"HG_LED": "led" in pins, "HG_ALIVE": "alive" in pins, "HG_ACTIVE_LOW": pins.get("active") == "low"}
    result = [f"-D{name}" for name, wanted in given.items() if wanted]
    result += [f"-DHG_STOP={pins.get('stop_level', 0)}"] if "stop" in pins else []
    result += [f"-DHG_DRIVER_ENABLE={pins.get('driver_enable_level', 1)}"] if "driver_enable" in pins else []
    result += [f"-DHG_{key.upper()}" for key in ("sync_in", "sync_out", "trigger_in", "trigger_out", "test") if key in pins]
    result += ["-DHG_CHAIN"] if "next_rx" in pins else []
    result += [f"-DHG_HIGH={len(pins['high'])}"] if pins.get("high") else []
    result += ["-DHG_SDRAM"] if "sdram" in board else []
    if "network" in board:
        net = board["network"]
        ip = "".join(f"{int(part):02x}" for part in net["ip"].split("."))
        result += ["-DHG_NET", f"-DHG_NET_MAC={net['mac'].replace(':', '')}", f"-DHG_NET_IP={ip}"]
        result += [f"-DHG_NET_{key.upper()}={net[key]}" for key in ("rx_delay", "tx_delay")]
    return result


def commands(family, top, dsp=True):
    """The commands of Yosys that make a netlist of the module `top`, up to what may follow the last one's options."""
    if family == "ice40":
        return f"synth_ice40 -top {top}"
    synth, own = f"synth_ecp5{'' if dsp else ' -nodsp'} -top {top}", f"techmap -map {ROOT / 'tools' / 'ecp5_map.v'}"
    return f"proc\n{own} t:$lt t:$le t:$gt t:$ge\n{synth} -run begin:map_gates\n{own} t:$alu\n{synth} -run map_gates:"


def open_carries(netlist):
    """Takes away the nets of carries that nothing reads: for each nextpnr would add a cell to bring it out."""
    design = json.loads(netlist.read_text())
    for module in design["modules"].values():
        read = {bit for port in module["ports"].values() for bit in port["bits"]}
        for cell in module["cells"].values():
            read |= {bit for port, bits in cell["connections"].items() if cell["port_directions"][port] != "output" for bit in bits}
        for cell in module["cells"].values():
            if cell["type"] == "CCU2C" and not read & set(cell["connections"]["COUT"]):
                cell["connections"]["COUT"] = ["x"]
    netlist.write_text(json.dumps(design))


def synthesise(folder, board):
    """Writes TOP.json for nextpnr and core.v, and returns the seconds that took."""
    family, top = board["fpga"]["family"], board["fpga"]["top"]
    sources = [path for folder in ("rtl", "rtl/amplitudes", "rtl/time") for path in sorted((ROOT / folder).glob("*.v"))]
    sources += sorted(ROOT.glob("rtl/net/*.v")) if "network" in board else []
    sources += sorted(ROOT.glob("rtl/sdram/*.v")) if board["parameters"]["SDRAM"] else []
    if top != "haptogram_core":
        with_ecp5 = [top, "ecp5_50mhz", "clock_watch", "ecp5_rgmii", "ecp5_sdram"] if family == "ecp5" else [top]
        sources += [ROOT / "rtl" / "boards" / f"{name}.v" for name in with_ecp5]
    sets = " ".join(f"-set {k} {v}" for k, v in board["parameters"].items())
    files = " ".join(f'-set {n.upper()}_FILE "{n}_init.hex"' for n in memories(board))
    # Without the one multiplier, for which Yosys has no simulation model; boards with amplitudes have too many of them for that.
    synth = commands(family, top, dsp=board["parameters"]["WIDTH_BITS"] != 0)
    # The core stays a module of its own, so that what is tested is what is placed.
    apart = f"delete {top}\nhierarchy -auto-top\nrename -top haptogram_core\n" if top != "haptogram_core" else ""
    (folder / "synth.ys").write_text(f"""read_verilog {' '.join(defines(board))} -I{ROOT}/rtl -I{ROOT}/rtl/net {' '.join(map(str, sources))}
chparam {sets} {files} {top}
hierarchy -top {top}
setattr -mod -set keep_hierarchy 1 *haptogram_core
{synth} -json {top}.json
{apart}chtype -set dp16kd t:DP16KD
splitnets
write_verilog -noattr core.v
""")
    seconds = run(folder, "yosys.log", tool("yosys"), "-q", "synth.ys")
    if family == "ecp5":
        open_carries(folder / f"{top}.json")
    return seconds


def state_cells(folder, board):
    """Flip-flops of all the pulse generators: those whose output is a net of theirs."""
    modules = json.loads((folder / f"{board['fpga']['top']}.json").read_text())["modules"]
    core = next(m for name, m in modules.items() if "haptogram_core" in name)
    nets = {bit for name, net in core["netnames"].items() if ".generators." in name for bit in net["bits"]}
    if not nets:
        raise Failed("the netlist has no instance called generators; when it was renamed in rtl/, rename it here, too")
    return sum(1 for cell in core["cells"].values() if ("DFF" in cell["type"] or cell["type"] == "TRELLIS_FF") and cell["connections"]["Q"][0] in nets)


def network_sites(net):
    """Ports and balls of the PHY."""
    ways = {"i_net_rx": "rx", "o_net_tx": "tx"}
    return [(f"{port}_{what}", net[f"{key}_{what}"]) for port, key in ways.items() for what in ("clk", "ctl")] + [
        (f"{port}[{k}]", ball) for port, key in ways.items() for k, ball in enumerate(net[key])]


def sdram_sites(chip):
    """Ports and balls of the SDRAM, and of the flash that fills it."""
    flash = list(zip(("o_flash_cs_n", "o_flash_data", "i_flash_data"), chip["flash"]))
    lists = {"o_sdram_bank": "bank", "o_sdram_address": "address", "io_sdram_data": "data"}
    return flash + [(f"o_sdram_{key}", chip[key]) for key in ("clk", "ras_n", "cas_n", "we_n")] + [
        (f"{port}[{k}]", ball) for port, key in lists.items() for k, ball in enumerate(chip[key])]


def constraints(board):
    """The pin file of nextpnr: .pcf for the iCE40, .lpf for the ECP5."""
    pins, channels = board["pins"], board["parameters"]["CHANNELS"]
    sites = [("i_clk", pins["clk"])]
    sites += [("i_rx", pins["rx"]), ("o_tx", pins["tx"])] if "network" not in board else network_sites(board["network"])
    sites += [(port, pins[key]) for port, key in [("o_led", "led"), ("i_stop", "stop"), ("o_driver_enable", "driver_enable"),
                                                  ("o_alive", "alive"), ("i_sync", "sync_in"), ("o_sync", "sync_out"),
                                                  ("i_trigger", "trigger_in"), ("o_trigger", "trigger_out"), ("o_test", "test"),
                                                  ("i_next", "next_rx"), ("o_next", "next_tx")] if key in pins]
    sites += sdram_sites(board["sdram"]) if "sdram" in board else []
    # At rest serial lines are high, SYNC and a trigger low, and a stop switch that nobody has fitted is not pressed.
    pulls = {"i_rx": "UP", "i_next": "UP", "i_sync": "DOWN", "i_trigger": "DOWN", "i_stop": "DOWN" if pins.get("stop_level", 0) else "UP"}
    sites += [(f"o_high[{i}]", ball) for i, ball in enumerate(pins.get("high", []))]
    sites += [(f"o_pins[{k}]", row[3]) for k, row in enumerate(board["outputs"][:channels])]
    if board["fpga"]["family"] == "ice40":
        return "pins.pcf", "".join(f"set_io {'-pullup yes ' if pulls.get(port) == 'UP' else ''}{port} {ball}\n" for port, ball in sites)
    outputs = (f" DRIVE={pins['drive_ma']}" if "drive_ma" in pins else "") + (f" SLEWRATE={pins['slew'].upper()}" if "slew" in pins else "")

    def attributes(port):
        fast = " SLEWRATE=FAST" if "o_sdram" in port or "io_sdram" in port else ""
        return f" PULLMODE={pulls[port]}" if port in pulls else outputs if port.startswith("o_pins") else fast

    text = "".join(f'LOCATE COMP "{port}" SITE "{ball}";\nIOBUF PORT "{port}" IO_TYPE=LVCMOS33{attributes(port)};\n' for port, ball in sites)
    text += f'FREQUENCY PORT "i_net_rx_clk" {NETWORK_MHZ} MHz;\n' if "network" in board else ""
    return "pins.lpf", text + 'FREQUENCY PORT "i_clk" 25 MHz;\n'


def place(folder, board, seed, goal_mhz):
    """Places and routes; returns the lowest Fmax in MHz, the file with the placed design and nextpnr's report, in which network_mhz is
    that of the PHY's clock, if there is one."""
    fpga, placed, report = board["fpga"], f"placed_{seed}.{'asc' if board['fpga']['family'] == 'ice40' else 'config'}", f"nextpnr_{seed}.json"
    command = [tool(f"nextpnr-{fpga['family']}"), f"--{fpga['device']}", "--package", fpga["package"], "--json", f"{fpga['top']}.json",
               "--freq", f"{goal_mhz:.1f}", "--seed", seed, "--report", report, "--timing-allow-fail"]
    command += ["--speed", fpga["speed"]] if fpga["family"] == "ecp5" else []
    if fpga["top"] == "haptogram_core":
        command += ["--out-of-context"]  # which leaves no design to make a bitstream of
    else:
        name, text = constraints(board)
        (folder / name).write_text(text)
        command += [f"--{name.split('.')[1]}", name, "--asc" if fpga["family"] == "ice40" else "--textcfg", placed]
    seconds = run(folder, f"nextpnr_{seed}.log", *command)
    outcome = json.loads((folder / report).read_text())
    of_network = [v["achieved"] for name, v in outcome["fmax"].items() if "net_" in name]
    if bool(of_network) != ("network" in board):
        raise Failed(f"nextpnr names the clocks {', '.join(outcome['fmax'])}; the PHY's is expected to be called net_something")
    fmax = min(v["achieved"] for name, v in outcome["fmax"].items() if "net_" not in name)
    outcome["network_mhz"] = min(of_network, default=None)
    beside = f", network {outcome['network_mhz']:.1f} MHz" if of_network else ""
    print(f"{folder.name}: seed {seed} placed and routed in {seconds:.0f} s, {fmax:.1f} MHz{beside}", file=sys.stderr, flush=True)
    return fmax, placed, outcome


def cells(utilisation, family):
    """(logic cells or LUTs used, available, block RAMs used, available)"""
    logic, ram = ("ICESTORM_LC", "ICESTORM_RAM") if family == "ice40" else ("TRELLIS_COMB", "DP16KD")
    return tuple(utilisation[kind][key] for kind in (logic, ram) for key in ("used", "available"))


def build(name, options):
    board, start = load(name), time.monotonic()
    folder = options.output.resolve() / ("empty" if options.empty else "") / name  # apart: no image can be put into it
    alone = options.configuration is not None
    if alone:
        board["fpga"]["top"] = "haptogram_core"
        board.pop("network", None)
        board["parameters"] = configurations.configuration(options.configuration)
        folder = folder.with_name(f"{name}-{options.configuration}")
    folder.mkdir(parents=True, exist_ok=True)
    family, clock_mhz = board["fpga"]["family"], board["parameters"]["CLOCK_HZ"] / 1e6
    budget = board["budget"]
    goal = clock_mhz * (1.0 if alone else budget["clock_margin"])  # of size only, not of a board's margin
    fingerprint(folder, board, options.empty)
    print(f"{folder.name}: synthesised in {synthesise(folder, board):.0f} s", file=sys.stderr, flush=True)
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        outcomes = list(pool.map(lambda seed: place(folder, board, seed, goal), range(1, options.seeds + 1)))
    fmax, placed, best = max(outcomes, key=lambda outcome: outcome[0])
    if not alone:
        os.replace(folder / placed, folder / f"placed.{placed.split('.')[1]}")
    for _, spare, _ in outcomes:
        (folder / spare).unlink(missing_ok=True)
    bits = f"{name}.{'bin' if family == 'ice40' else 'bit'}"
    if options.program and not alone:
        run(folder, "pack.log", options.program.resolve(), "bitstream", "--board", boards.BOARDS / f"{name}.toml", "--placed",
            options.output.resolve(), "--empty", "-o", bits)
    if options.empty and not alone:
        pack = [tool("icepack"), "placed.asc"] if family == "ice40" else [tool("ecppack"), "--compress", "placed.config"]
        run(folder, "pack.log", *pack, bits)
        (options.output / name).mkdir(exist_ok=True)
        shutil.copy(folder / bits, options.output / name)
    used, available, rams, ram_available = cells(best["utilization"], family)
    channels = board["parameters"]["CHANNELS"]
    network = [outcome[2]["network_mhz"] for outcome in outcomes if "network" in board]
    result = {"board": name, "core_alone": alone, "fpga": board["fpga"], "parameters": board["parameters"], "cells": used,
              "cells_available": available, "state_cells_per_channel": state_cells(folder, board) / channels,
              "block_rams": rams, "block_rams_available": ram_available, "clock_mhz": clock_mhz,
              "fmax_mhz": {"lowest": min(outcome[0] for outcome in outcomes), "highest": fmax, "seeds": options.seeds, "goal": goal},
              "network_mhz": min(network, default=None),
              "seconds": time.monotonic() - start}
    (folder / "report.json").write_text(json.dumps(result, indent=2) + "\n")
    problems = []
    if used > budget["cells"] and not alone:
        problems.append(f"{used} cells, the budget is {budget['cells']}")
    if result["fmax_mhz"]["lowest"] < goal:
        problems.append(f"{result['fmax_mhz']['lowest']:.1f} MHz, the budget is {goal:.1f} MHz")
    if network and min(network) < budget["network_mhz"]:
        problems.append(f"network {min(network):.1f} MHz, the budget is {budget['network_mhz']} MHz")
    return result, problems


def table(results):
    lines = ["| board | channels | records | timing bits | cells | flip-flops a channel | block RAMs | lowest MHz (seeds) | goal MHz | network MHz | seconds |",
             "|---|---|---|---|---|---|---|---|---|---|---|"]
    for r in results:
        p, fmax = r["parameters"], r["fmax_mhz"]
        lines.append(
            f"| {r['board']}{', core alone' if r['core_alone'] else ''} | {p['CHANNELS']} | {p['RECORDS']} | {p['TIMING_BITS']} "
            f"| {r['cells']:,} of {r['cells_available']:,} ({100 * r['cells'] / r['cells_available']:.1f} %) | {r['state_cells_per_channel']:.1f} "
            f"| {r['block_rams']} of {r['block_rams_available']} | {fmax['lowest']:.1f} ({fmax['seeds']}) | {fmax['goal']:.1f} "
            f"| {format(r['network_mhz'], '.1f') if r.get('network_mhz') else '–'} | {r['seconds']:.0f} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("boards", metavar="BOARD", nargs="*", help="of constraints/; none: all")
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "boards")
    parser.add_argument("--seeds", type=int, default=1, help="place and route with this many seeds and take the fastest (1)")
    packing = parser.add_mutually_exclusive_group()
    packing.add_argument("--program", type=Path, help="haptogram, to pack the bitstream with, into which it can then put images; without it there is none")
    packing.add_argument("--empty", action="store_true", help="pack it without haptogram: images are uploaded, and cannot be put into it")
    parser.add_argument("--configuration", metavar="NAME", help="of tools/interface.toml: the core alone, in this configuration")
    parser.add_argument("--table", type=Path, metavar="FILE", help="writes the table of all reports in OUTPUT to a Markdown file")
    options = parser.parse_args()
    results, failed = [], False
    for name in options.boards or boards.names():
        try:
            result, problems = build(name, options)
        except (Failed, boards.Unknown, configurations.Wrong) as error:
            print(f"bitstream: {error}", file=sys.stderr)
            failed = True
            continue
        results.append(result)
        failed |= bool(problems)
        for problem in problems:
            print(f"{name}: over budget: {problem}", file=sys.stderr)
    if results:
        print(table(results), end="")
    if options.table:
        reports = [json.loads(path.read_text()) for path in sorted(options.output.glob("*/report.json"))]
        options.table.write_text(HEADING + table(reports))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
