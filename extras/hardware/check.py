# SPDX-License-Identifier: Apache-2.0
"""make hardware: builds all of the driver tile into a folder, checks it, and prints each finding beside its bound.

Exit code 1 when a bound is missed, or a planted fault is not noticed."""
import argparse
import json
import random
import subprocess
import sys
from pathlib import Path

try:
    import copper
    import netlist
    import picture
    import spice
    import table
    from table import Row
except ModuleNotFoundError as missing:
    sys.exit(f"hardware: missing the Python module {missing.name}: tools/setup hardware installs it")

KICAD_PYTHON = "/usr/bin/python3"  # of Debian, which has pcbnew


def netlist_rows(net, expected):
    noticed, missed = netlist.mutants(net, expected)
    broken = noticed + len(missed)
    return [Row("broken rules of the netlist", len(netlist.faults(net, expected)), 0, 0, f"{broken} broken netlists, {noticed} noticed", int(not missed))]


def board_rows(folder):
    """Built by KiCad's Python, which says what it found."""
    command = [KICAD_PYTHON, str(Path(__file__).parent / "board.py"), str(folder), netlist.BOARD, str(netlist.ARRAY), "--planted"]
    told = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.split()
    found, noticed, made = map(int, told[-3:])
    return [Row("violations of KiCad's rules", found, 0, 0, f"{made} broken boards, {noticed} noticed", int(noticed == made))]


def joined(net):
    """What hangs together, whatever it is called."""
    return {frozenset(map(tuple, nodes)) for nodes in net["nets"].values()}


def copper_rows(folder, net, expected):
    gerbers, pads = folder / "gerber", folder / "pads.csv"
    read = copper.Copper(gerbers)
    lines, found = copper.faults(read, pads, net, expected)
    print("\n".join(lines[:10]), file=sys.stderr, end="\n" if lines else "")
    noticed, made = copper.planted(gerbers, folder / "damaged", read, pads, net, expected, random.Random(1))
    other = joined(found) != joined(net)
    return [Row("faults in the Gerbers' copper", len(lines) + other, 0, 0, f"{made} damaged files, {noticed} noticed", int(noticed == made))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    o = parser.parse_args()
    o.output.mkdir(parents=True, exist_ok=True)
    net, expected = netlist.build(netlist.BOARD, netlist.ARRAY), netlist.pinout(o.program, netlist.BOARD, netlist.ARRAY)
    (o.output / "netlist.json").write_text(json.dumps(net, indent=1), encoding="utf-8")
    (o.output / "bill.csv").write_text(netlist.bill(net), encoding="utf-8")
    rows = netlist_rows(net, expected) + spice.rows(o.program)
    rows += board_rows(o.output)
    picture.draw(o.output / "gerber", o.output / "driver-tile.png")
    rows += copper_rows(o.output, net, expected)
    text = table.text(rows) + "\n" + spice.variants() + "\n" + spice.tones()
    (o.output / "checks.md").write_text(text, encoding="utf-8")
    print(text, end="")
    bad = [r for r in rows if r.verdict != "ok"]
    print(f"hardware: {len(net['parts'])} parts, {len(net['nets'])} nets; {len(rows) - len(bad)} of {len(rows)} checks hold; files in {o.output}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
