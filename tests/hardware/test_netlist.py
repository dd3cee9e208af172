# SPDX-License-Identifier: Apache-2.0
"""The driver tile's netlist: rules that hold, faults that they notice, and boards that it cannot be made for."""
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")
SEED = int(os.environ.get("HAPTOGRAM_SEED", 0)) or int.from_bytes(os.urandom(4), "big")
sys.path.insert(0, str(ROOT / "extras/hardware"))
import netlist  # noqa: E402

GRID = ROOT / "host/arrays/tile-10x10.toml"
TILES = [
    ("colorlight-5a-75e-v7.1", netlist.ARRAY),
    ("colorlight-5a-75e-v7.1", GRID),
    ("colorlight-5a-75e-v6.0", netlist.ARRAY),
    ("colorlight-5a-75b-v8.0", ROOT / "host/arrays/tile-7x8.toml"),
]


def made(board, array):
    return netlist.build(board, array), netlist.pinout(PROGRAM, board, array)


@pytest.mark.parametrize("board, array", TILES, ids=lambda v: Path(v).stem)
def test_every_channel_reaches_its_element_and_no_rule_is_broken(board, array):
    net, expected = made(board, array)
    assert len(expected["outputs"]) == len(netlist.places(array))
    assert netlist.faults(net, expected) == []


@pytest.mark.parametrize("board, array", [TILES[0], pytest.param(*TILES[3], marks=pytest.mark.deep)], ids=lambda v: Path(v).stem)
def test_every_broken_netlist_is_noticed(board, array):
    print(f"seed {SEED}")
    noticed, missed = netlist.mutants(*made(board, array), seed=SEED)
    assert (noticed, missed) == (450, [])


def test_the_wires_of_another_array_file_are_noticed():
    net, _ = made(*TILES[0])
    assert len(netlist.faults(net, netlist.pinout(PROGRAM, TILES[1][0], GRID))) >= 90


def test_the_arrays_file_is_what_the_generator_writes_and_has_the_grids_places():
    text = netlist.ARRAY.read_text(encoding="utf-8")
    for board in ("colorlight-5a-75e-v7.1", "colorlight-5a-75e-v6.0"):
        assert netlist.array_file(board) == text, "stale: extras/hardware/netlist.py --array-file >host/arrays/driver-tile.toml"
    assert sorted(netlist.places(netlist.ARRAY)) == sorted(netlist.places(GRID))


def test_the_bill_counts_every_part_once():
    net, _ = made(*TILES[0])
    rows = netlist.bill(net).splitlines()[1:]
    assert sum(int(r.split(",")[0]) for r in rows) == len(net["parts"])
    count = {r.split(",")[1]: int(r.split(",")[0]) for r in rows}
    assert (count["driver"], count["element"], count["pull-down"], count["switch"]) == (50, 100, 101, 1)


def test_the_circuits_numbers_are_those_of_board_power():
    element, driver = netlist.CIRCUIT["element"], netlist.CIRCUIT["drivers"][netlist.PARTS["driver"]["value"]]
    options = {
        "--resistance-ohm": element["resistance_ohm"],
        "--capacitance-nf": element["capacitance_f"] * 1e9,
        "--series-ohm": driver["ohm"] + netlist.number(netlist.PARTS["series"]["value"]),
        "--volts": float(netlist.PARTS["terminal"]["value"].split()[0]),
    }
    command = [str(PROGRAM), "board", "power", netlist.BOARD, "--json"]
    told = [str(word) for option in options.items() for word in option]
    silent, spoken = (json.loads(subprocess.run(command + more, check=True, stdout=subprocess.PIPE).stdout) for more in ([], told))
    assert silent == pytest.approx(spoken)


@pytest.mark.parametrize(
    "board, array, words",
    [
        ("ice40-hx8k-breakout", GRID, ["ice40-hx8k-breakout", "HUB75", "take a Colorlight"]),
        ("colorlight-5a-75b-v8.0", GRID, ["100 elements", "56 outputs", "smaller array"]),
        ("colorlight-5a-75e-v9", GRID, ["no board colorlight-5a-75e-v9", "colorlight-5a-75e-v7.1"]),
    ],
)
def test_a_board_that_does_not_suit_is_refused(board, array, words):
    command = [sys.executable, ROOT / "extras/hardware/netlist.py", "--board", board, "--array", array, "--program", PROGRAM]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 3 and not result.stdout
    assert all(word in result.stderr for word in words), result.stderr
