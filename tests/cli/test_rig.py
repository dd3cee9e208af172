# SPDX-License-Identifier: Apache-2.0
"""Rigs: the files that `compile --rig` writes, and what the commands refuse."""
import json

import pytest
from support import BAD_INPUT, USAGE, assert_one_message, run, succeed, text

PAIR = """format = "haptogram-rig-1"
name = "pair"
[[unit]]
array = "tile-10x10"
origin_mm = [-50, 0, 0]
board = "tile-100-wide"
{first}
[[unit]]
array = "tile-10x10"
origin_mm = [50, 0, 0]
board = "tile-100-wide"
{second}
"""


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A rig of two tiles whose file names the ports, and a small shape on it."""
    folder = tmp_path_factory.mktemp("pair")
    (folder / "pair.toml").write_text(PAIR.format(first='port = "port-1"', second='port = "port-2"'))
    told = succeed(["compile", "--shape", "circle", "--points", 4, "--rate", 500, "--center", "0,0,180", "--rig", "pair.toml", "-o", "wall.hex", "--json"], cwd=folder)
    report = json.loads(told.stdout)
    assert report["rig"] == "pair" and report["images"] == ["wall.tile-1.hex", "wall.tile-2.hex"] and report["manifest"] == "wall.json"
    return folder


def test_the_files_of_a_rig(pair):
    manifest = json.loads((pair / "wall.json").read_text())
    assert manifest["format"] == "haptogram-rig-manifest-1" and manifest["rig"]["name"] == "pair"
    assert [(t["image"], t["elements"], t["port"]) for t in manifest["tiles"]] == [("wall.tile-1.hex", 100, "port-1"), ("wall.tile-2.hex", 100, "port-2")]
    # A tile's image is one that programs for one board read.
    about = text(succeed(["inspect", "wall.tile-2.hex"], cwd=pair).stdout)
    assert "100" in about
    # At a focus, the pressures of the two add up.
    record = json.loads((pair / "wall.tile-1.json").read_text())["records"][0]
    x, y, z = record["foci"][0]["position_mm"] if "foci" in record else record["focus_mm"]
    field = ["field", "--line", f"z@x={x},y={y}", "--z", f"{z}:{z + 1}", "--step", 1, "--quantity", "rms"]
    both, one = (float(text(succeed([*field, name], cwd=pair).stdout).splitlines()[-1].split(",")[-1]) for name in ("wall.json", "wall.tile-1.hex"))
    assert 1.5 * one < both < 2.5 * one


@pytest.mark.parametrize(
    "args, code, needles",
    [
        (["compile", "--shape", "circle", "--rig", "3x3"], BAD_INPUT, ["3x3", "2x2", "hoshi-9x36"]),
        (["compile", "--shape", "circle", "--rig", "2x2", "-o", "-"], USAGE, ["--output", "one for each tile"]),
        (["compile", "--shape", "circle", "--rig", "2x2", "--array", "hoshi"], USAGE, ["--array", "--rig"]),
        (["compile", "--shape", "circle", "--rig", "cube-300"], BAD_INPUT, ["cube-300", "neither SYNC nor SCHEDULE"]),
        (["upload", "--rig", "wall.tile-1.json"], BAD_INPUT, ["wall.tile-1.json", "no rig manifest"]),
        (["upload", "--rig", "wall.json", "--port", "a"], USAGE, ["--port", "1 given", "2 tiles"]),
        (["play", "--rig", "wall.json", "--port", "a", "--port", "a"], USAGE, ["--port", "two tiles"]),
        (["play", "--rig", "wall.json", "--rate", 3], USAGE, ["--rate", "as it was compiled"]),
        (["play"], USAGE, ["--port", "missing"]),
        (["play", "--port", "a", "--port", "b"], USAGE, ["--port", "given 2 times"]),
        (["upload", "--port", "a"], USAGE, ["nothing to upload"]),
        (["simulate"], USAGE, ["nothing to simulate"]),
        (["board", "run", "--tiles", 2, "--model", "reference"], USAGE, ["--model", "no SYNC"]),
        (["board", "run", "--tiles", 2, "--fault", "silent:3@1"], USAGE, ["--fault", "a tile from 1 to 2"]),
        (["board", "run", "--tiles", 2, "--channels", 16], USAGE, ["--channels", "there are 100"]),
    ],
)
def test_what_cannot_be_done(pair, args, code, needles):
    assert_one_message(run(args, cwd=pair), code, *needles)
