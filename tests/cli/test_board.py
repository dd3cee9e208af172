# SPDX-License-Identifier: Apache-2.0
"""Boards: the shipped files against the arrays they drive, files that cannot be used, and images compiled for a board."""
import csv
import functools
import io
import json
import math
import re
import tomllib
import xml.etree.ElementTree

import pytest
from support import BAD_INPUT, ROOT, USAGE, Image, read_json, refuse, run, succeed, text

BOARDS = sorted(p.stem for p in (ROOT / "constraints").glob("*.toml"))
LARGE, SMALL = "colorlight-5a-75e-v6.0", "ulx3s-85f"


def board_file(name):
    own = tomllib.loads((ROOT / f"constraints/{name}.toml").read_text(encoding="utf-8"))
    return board_file(own["like"]) | own if "like" in own else own


@functools.cache
def parameters(name):
    """Of the core that a board file asks for."""
    table = tomllib.loads((ROOT / "tools/interface.toml").read_text(encoding="utf-8"))
    file = dict(board_file(name)["parameters"])
    like = file.pop("configuration", None)
    return (parameters(like) if like else {p["name"]: p["default"] for p in table["parameter"]}) | file


def array_file(name):
    return tomllib.loads((ROOT / f"host/arrays/{name}.toml").read_text(encoding="utf-8"))


def pinout(board, *arguments, **more):
    return json.loads(succeed(["board", "pinout", board, "--json", *arguments], **more).stdout)


# A board small enough to be read here, to be damaged below. The 4th output is spare, and the LED's.
GOOD = """description = "A board"
sources = ["https://example.org/board"]
array = "pair.toml"
outputs = [
  ["J1", "1", "R0", "A1"],
  ["J1", "2", "G0", "A2"],
  ["J1", "3", "B0", "A3"],
  ["J1", "4", "OE", "A4"],
]
[fpga]
family = "ecp5"
device = "25k"
package = "CABGA256"
speed = 6
top = "colorlight"
[parameters]
CHANNELS = 3
RECORDS = 5
SEQUENCE_DEPTH = 8
LIVE_DEPTH = 16
TIMING_BITS = 9
PULSE_BITS = 8
CLOCK_HZ = 48000000
BAUD = 3000000
WATCHDOG_MS = 500
MAX_HIGH_CLOCKS = 10000
MIN_PULSE_CLOCKS = 5
MAX_DUTY_256 = 128
[flash]
load = ["-b", "it"]
write = ["-b", "it", "-f"]
note = "A cable."
[pins]
clk = "P1"
rx = "P2"
tx = "P3"
led = "A4"
high = ["P4"]
"""
# Nothing of its own [board] may be used, and 3 elements listed in an order of their own.
ARRAY = "[array]\nelements_mm = [[10, 0], [-10, 0], [0, 12.5]]\n[board]\nclock_hz = 50000000\nchannels = 16\n"


def line_of(needle):
    """Of the line of GOOD that begins so."""
    return next(i for i, line in enumerate(GOOD.splitlines(), 1) if line.startswith(needle))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "board.toml").write_text(GOOD)
    (tmp_path / "pair.toml").write_text(ARRAY)
    return tmp_path


# The shipped boards


def test_the_list_names_every_board():
    listed = json.loads(succeed(["board", "list", "--json"]).stdout)
    assert [b["board"] for b in listed] == BOARDS and len(BOARDS) >= 5
    for entry in listed:
        file = board_file(entry["board"])
        p = parameters(entry["board"])
        assert entry["channels"] == p["CHANNELS"] and entry["clock_hz"] == p["CLOCK_HZ"]
        assert entry["description"] == file["description"] and entry["array"] == file["array"]
    lines = text(succeed(["board", "list"]).stdout).splitlines()
    assert [line.split()[0] for line in lines] == ["board", *BOARDS]


@pytest.mark.parametrize("board", BOARDS)
def test_a_shipped_board_drives_its_array(board):
    file, shown = board_file(board), pinout(board)
    array = array_file(file["array"])["array"]
    rows, columns, pitch = array["rows"], array["columns"], array["pitch_mm"]
    outputs = shown["outputs"]
    assert len(outputs) == parameters(board)["CHANNELS"] == rows * columns
    for k, output in enumerate(outputs):
        assert [output[key] for key in ("connector", "pin", "net", "ball")] == file["outputs"][k]
        row, column = divmod(k, columns)
        assert (output["channel"], output["row"], output["column"]) == (k, row, column)
        assert output["x_mm"] == pytest.approx((column - (columns - 1) / 2) * pitch)
        assert output["y_mm"] == pytest.approx((row - (rows - 1) / 2) * pitch)
    pins = file["pins"]
    balls = [o["ball"] for o in outputs] + [pins["clk"], *pins["high"]]
    balls += [pins[key] for key in ("rx", "tx", "led", "stop", "driver_enable", "alive", "sync_in", "sync_out", "trigger_in", "trigger_out", "test", "next_rx", "next_tx") if key in pins]
    network = file.get("network", {"rx": [], "tx": []})
    balls += [network[key] for key in ("rx_clk", "rx_ctl", "tx_clk", "tx_ctl") if key in network] + network["rx"] + network["tx"]
    for named in file.get("sdram", {}).values():
        balls += named if isinstance(named, list) else [named]
    assert len(set(balls)) == len(balls)
    assert len({(o["connector"], o["pin"]) for o in outputs}) == len(outputs)


@pytest.mark.parametrize("board", BOARDS)
def test_the_pinout_says_what_the_file_says(board):
    file, shown = board_file(board), pinout(board)
    for key in ("description", "sources", "array", "flash"):
        assert shown[key] == file[key], key
    assert shown["parameters"] == parameters(board)
    assert shown["board"] == board
    assert shown["fpga"] == {"speed": None, **file["fpga"]}
    unsaid = {"rx": None, "tx": None, "led": None, "stop": None, "stop_level": 0, "driver_enable": None, "driver_enable_level": 1, "alive": None, "sync_in": None, "sync_out": None, "trigger_in": None, "trigger_out": None, "test": None, "next_rx": None, "next_tx": None, "active": "high",
              "drive_ma": None, "slew": None}  # fmt: skip
    assert shown["pins"] == unsaid | file["pins"]
    assert shown["network"] == file.get("network")
    assert shown["sdram"] == file.get("sdram")
    assert shown["wiring"] == {"places": {}} | file["wiring"]
    places = {ball: f"{connector} pin {pin}" for connector, pin, _, ball in file["outputs"]} | file["wiring"].get("places", {})
    assert shown["places"] == {key: places[ball] for key, ball in file["pins"].items() if key != "clk" and isinstance(ball, str) and ball in places}


@pytest.mark.parametrize("board", BOARDS)
def test_a_shipped_board_makes_its_carrier(board, tmp_path):
    """With timings that its bits hold, all ones left for silence, and a pulse that its counter holds."""
    p = parameters(board)
    succeed(["compile", "--shape", "circle", "--points", "8", "--board", board, *(["--records"] if p["FOCI"] else []), "-o", "image.hex"], cwd=tmp_path)
    image = Image(tmp_path / "image.hex")
    for record in image.records():
        assert record["cycle_length"] * record["prescaler"] * 40_000 == p["CLOCK_HZ"]
        assert record["pulse_length"] * 2 == record["cycle_length"] and record["pulse_length"] < 2 ** p["PULSE_BITS"]
        assert len(record["timings"]) == p["CHANNELS"] == image.channels
        assert max(record["timings"]) < record["cycle_length"] < 2 ** p["TIMING_BITS"]
        assert record["pulse_length"] * record["prescaler"] < p["MAX_HIGH_CLOCKS"]
    succeed(["inspect", "image.hex"], cwd=tmp_path)
    manifest = read_json(tmp_path / "image.json")
    unsaid = {"LIVE_DEPTH", "WATCHDOG_MS", "MAX_HIGH_CLOCKS", "MAX_DUTY_256", "SCHEDULE", "SYNC", "CHAIN", "NET", "STREAM", "TRIGGER", "SDRAM"}
    if p["WIDTH_BITS"] == 0:
        unsaid |= {"MIN_PULSE_CLOCKS", "WIDTH_BITS", "MODULATION_DEPTH", "SLEW", "FOCI"}
    assert manifest["board"] == {"name": board, **{key.lower(): p[key] for key in p if key not in unsaid}}
    assert manifest["array"]["name"] == board_file(board)["array"]


# The table


def test_the_table_is_aligned_and_says_what_to_connect():
    file = board_file(LARGE)
    header, table = text(succeed(["board", "pinout", LARGE]).stdout).split("\n\n")
    for needle in (LARGE, file["description"], "ecp5 25k CABGA256", "speed grade 6", "ball P6", "50 MHz", "rx ball R7", "tx ball T6", "115200 baud",
                   "ball M4", "ball R6", file["flash"]["note"]):
        assert needle in header, needle
    lines = table.splitlines()
    assert lines[0].split() == ["connector", "pin", "net", "ball", "channel", "row", "column", "x_mm", "y_mm"]
    assert lines[1].split() == ["J1", "1", "R0", "C4", "0", "0", "0", "-45.00", "-45.00"]
    assert lines[-1].split() == ["J1-J16", "12", "D", "P4", "99", "9", "9", "45.00", "45.00"]
    assert len(lines) == 101 and len({len(line) for line in lines}) == 1
    ball = lines[0].index("ball")
    assert all(line[ball - 1] == " " != line[ball] for line in lines)


@pytest.mark.parametrize("board", [LARGE, SMALL])
def test_the_csv_is_the_json(board):
    rows = list(csv.DictReader(io.StringIO(text(succeed(["board", "pinout", board, "--csv"]).stdout))))
    for row, output in zip(rows, pinout(board)["outputs"], strict=True):
        assert list(row) == list(output)
        for key, value in output.items():
            assert row[key] == value if isinstance(value, str) else float(row[key]) == value


@pytest.mark.parametrize("form", [[], ["--csv"], ["--json"]])
def test_the_pinout_in_a_file(form, tmp_path):
    shown = succeed(["board", "pinout", SMALL, *form, "-o", "-"]).stdout
    assert succeed(["board", "pinout", SMALL, *form, "-o", "pins"], cwd=tmp_path).stdout == b""
    assert (tmp_path / "pins").read_bytes() == shown == succeed(["board", "pinout", SMALL, *form]).stdout


def test_the_wiring_as_a_picture(tmp_path):
    succeed(["board", "pinout", LARGE, "-o", "wiring.svg"], cwd=tmp_path)
    picture = (tmp_path / "wiring.svg").read_text(encoding="utf-8")
    assert picture.count("<path") > 100 and picture.rstrip().endswith("</svg>")
    refuse(tmp_path, ["board", "pinout", LARGE, "--csv", "-o", "wiring.svg"], USAGE, outputs=["wiring.svg"])


@pytest.mark.parametrize("board", [LARGE, SMALL, *(pytest.param(board, marks=pytest.mark.deep) for board in ("ice40-hx8k-breakout", "colorlight-5a-75b-v8.0", "colorlight-5a-75e-v7.1-net"))])
def test_grounds_supplies_and_the_serial_line(board, tmp_path):
    """In the table, and in the picture, which has each line of text as a comment beside its letters."""
    file = board_file(board)
    table = text(succeed(["board", "pinout", board]).stdout)
    succeed(["board", "pinout", board, "-o", "wiring.svg"], cwd=tmp_path)
    picture = " ".join(re.findall(r"<!-- (.*?) -->", (tmp_path / "wiring.svg").read_text(encoding="utf-8")))
    wiring, pins = file["wiring"], file["pins"]
    assert f"ground {wiring['ground']}, by a meter" in table and wiring["ground"] in picture
    assert f"power  {wiring['power']};" in table and wiring["power"] in picture
    assert ("serial " in table) == ("rx" in pins)
    for key, place in pinout(board)["places"].items():
        assert f"ball {pins[key]}, {place}" in table, key
        if key in ("driver_enable", "stop", "alive", "rx", "tx"):
            assert place in picture, key
    if wiring["before_configuration"] == "inputs":
        assert "off    4.7 kΩ from each driver's input to ground" in table and "4.7 kΩ" in picture and "switch by hand" in picture
    elif "driver_enable" in pins:
        assert "off    switch the drivers' supply by J1-J16 pin 14" in table and "P-channel switch" in picture
    else:
        assert "off    a hand switches the drivers' supply" in table and "switch by hand" in picture
    for key in ("load_jumpers", "write_jumpers"):
        assert key not in file["flash"] or (file["flash"][key] in table and file["flash"][key] in picture)


def test_a_board_without_wiring_has_no_circuit(folder):
    assert pinout("board.toml", cwd=folder)["wiring"] is None
    assert "ground" not in text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)
    succeed(["board", "pinout", "board.toml", "-o", "wiring.svg"], cwd=folder)
    assert "supplies and grounds" not in (folder / "wiring.svg").read_text(encoding="utf-8")


WIRED = GOOD + """[wiring]
ground = "pin 9"
power = "5 V"
serial = "USB"
before_configuration = "inputs"
places = { P2 = "J9 pin 1" }
"""
BAD_WIRING = {
    "no ground": ('ground = "pin 9"\n', ""),
    "unknown key": ("ground =", "grounds ="),
    "floating": ('"inputs"', '"floating"'),
    "a list of places": ('{ P2 = "J9 pin 1" }', '["J9"]'),
    "the place of an output": ("{ P2 =", "{ A1 ="),
    "a place that is a number": ('"J9 pin 1"', "1"),
}


def test_wiring_in_words_and_as_a_picture(folder):
    (folder / "board.toml").write_text(WIRED)
    assert "rx ball P2, J9 pin 1" in text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)
    succeed(["board", "pinout", "board.toml", "-o", "wiring.svg"], cwd=folder)
    assert "to J9 pin 1" in (folder / "wiring.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("case", BAD_WIRING)
def test_bad_wiring(case, folder):
    there, instead = BAD_WIRING[case]
    assert there in WIRED
    (folder / "board.toml").write_text(WIRED.replace(there, instead, 1))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


def test_the_power_of_an_array(tmp_path):
    """By the formula again: (2 V sin(pi D) / pi)^2 / (2 R) + C V^2 f."""
    told = json.loads(text(succeed(["board", "power", LARGE, "--volts", 18, "--duty", 0.25, "--json"]).stdout))
    one = (2 * 18 / math.pi * math.sin(math.pi / 4)) ** 2 / 2 / 729 + 2.7e-9 * 18**2 * 40e3
    assert told["all_w"] == pytest.approx(100 * one) and told["current_a"] == pytest.approx(100 * one / 18)
    assert told["drivers_a"] == pytest.approx(50 * 4.5e-3)
    refuse(tmp_path, ["board", "power", LARGE, "--duty", "0.7"], USAGE)


def test_a_holder_has_a_place_for_each_transducer(tmp_path):
    """Read as any program that draws reads it: its size in millimetres, and of each circle what is cut."""
    succeed(["board", "holder", "tile-10x10", "-o", "holder.svg"], cwd=tmp_path)
    svg = xml.etree.ElementTree.parse(tmp_path / "holder.svg").getroot()
    assert (svg.get("width"), svg.get("height")) == ("124.000mm", "124.000mm")  # nine pitches, a body, two margins
    circles = [(each.get("class"), *(float(each.get(key)) for key in ("cx", "cy", "r"))) for each in svg.iter("{http://www.w3.org/2000/svg}circle")]
    legs = {(x, y) for kind, x, y, r in circles if kind == "cut" and r == 0.6}
    middles = {(10 * i - 45, 10 * k - 45) for i in range(10) for k in range(10)}
    assert legs == {(x + side, y) for x, y in middles for side in (-2.54, 2.54)}
    assert {(x, y) for kind, x, y, r in circles if kind == "mark"} == middles
    numbers = [each for each in svg.iter("{http://www.w3.org/2000/svg}text")]
    assert [each.text for each in numbers] == [str(n) for n in range(100)]
    assert float(numbers[0].get("y")) > 0  # the first row is the lowest, and SVG counts down
    for wrong in (["--body", "10.1"], ["--legs", "9.5"], ["--hole", "0"], ["--margin", "5"]):
        refuse(tmp_path, ["board", "holder", "tile-10x10", *wrong, "-o", "wrong.svg"], USAGE)
    assert not (tmp_path / "wrong.svg").exists()


def test_a_holder_is_flat(tmp_path):
    (tmp_path / "tilted.toml").write_text("name = 'tilted'\n[array]\nelements_mm = [[0, 0, 0], [20, 0, 5]]\n[transducer]\nname = 'any'\nradius_mm = 4.5\nsource_pa_m = 1\n")
    refuse(tmp_path, ["board", "holder", "tilted.toml"], BAD_INPUT)


def test_an_array_that_is_no_grid_has_no_rows(folder):
    shown = pinout("board.toml", cwd=folder)
    assert all(o["row"] is None and o["column"] is None for o in shown["outputs"])
    assert [(o["x_mm"], o["y_mm"]) for o in shown["outputs"]] == [(10, 0), (-10, 0), (0, 12.5)]
    assert [o["ball"] for o in shown["outputs"]] == ["A1", "A2", "A3"]
    assert b"J1,3,B0,A3,2,,,0.00,12.50\n" in succeed(["board", "pinout", "board.toml", "--csv"], cwd=folder).stdout
    table = text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)
    assert table.splitlines()[-1].split() == ["J1", "3", "B0", "A3", "2", "-", "-", "0.00", "12.50"] and "ball A4, J1 pin 4\n" in table


def test_a_board_file_names_its_array_from_where_it_is(folder):
    (folder / "elsewhere").mkdir()
    assert pinout("../board.toml", cwd=folder / "elsewhere")["array"] == "pair"


LIKE = 'like = "board.toml"\ndescription = "As the other"\n[parameters]\nconfiguration = "tile-100"\nCHANNELS = 3\n'


def test_a_board_is_like_another_but_for_what_it_says(folder):
    (folder / "variants").mkdir()
    (folder / "variants/own.toml").write_text(LIKE.replace("board.toml", "../board.toml"))
    shown, other = pinout("variants/own.toml", cwd=folder), pinout("board.toml", cwd=folder)
    differs = {"board": "own", "description": "As the other", "parameters": parameters("colorlight-5a-75e-v7.1") | {"BAUD": 1000000, "CHANNELS": 3}}
    assert shown == other | differs
    # Like one that is like a third: each table from the nearest that has it.
    (folder / "third.toml").write_text('like = "variants/own.toml"\ndescription = "As both"\n')
    assert pinout("third.toml", cwd=folder) == shown | {"board": "third", "description": "As both"}
    (folder / "own.toml").write_text(LIKE.replace("board.toml", SMALL) + "SYNC = 1\nSCHEDULE = 1\nTRIGGER = 1\n")  # as it has pins for them
    assert pinout("own.toml", "--array", "pair.toml", cwd=folder)["fpga"] == {"speed": None, **board_file(SMALL)["fpga"]}


def test_a_board_in_a_chain(folder):
    chained = GOOD.replace("[pins]\n", '[pins]\nnext_rx = "T1"\nnext_tx = "T2"\n')
    (folder / "board.toml").write_text(chained)
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)
    (folder / "board.toml").write_text(chained.replace("[parameters]\n", "[parameters]\nCHAIN = 1\n"))
    pins = pinout("board.toml", cwd=folder)["pins"]
    assert (pins["next_rx"], pins["next_tx"]) == ("T1", "T2")
    assert "rx ball T1, tx ball T2" in text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)
    (folder / "board.toml").write_text(chained.replace("[parameters]\n", "[parameters]\nCHAIN = 1\n").replace('next_tx = "T2"\n', ""))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)
    (folder / "board.toml").write_text(chained.replace("[parameters]\n", "[parameters]\nCHAIN = 1\n").replace('"T2"', '"T1"'))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


@pytest.mark.parametrize(
    "like",
    ["nobody", "missing.toml",
     "own.toml", "second.toml",
     "four.toml", 3],
)  # fmt: skip
def test_a_board_like_none(like, folder):
    (folder / "second.toml").write_text(LIKE.replace("board.toml", "second.toml"))
    for name, other in [("four", "three"), ("three", "two"), ("two", "one")]:
        (folder / f"{name}.toml").write_text(LIKE.replace("board.toml", f"{other}.toml"))
    (folder / "one.toml").write_text(LIKE)
    (folder / "own.toml").write_text(LIKE.replace('"board.toml"', json.dumps(like)))
    refuse(folder, ["board", "pinout", "own.toml"], BAD_INPUT)


def test_a_message_names_the_file_that_is_wrong(folder):
    (folder / "board.toml").write_text(GOOD.replace('clk = "P1"', "clk = 1"))
    (folder / "own.toml").write_text(LIKE)
    refuse(folder, ["board", "pinout", "own.toml"], BAD_INPUT)


# What cannot be used


def test_an_array_of_another_size(tmp_path):
    refuse(tmp_path, ["board", "pinout", SMALL, "--array", "tile-10x10"], BAD_INPUT)
    refuse(tmp_path, ["board", "pinout", LARGE, "--array", "tile-7x8"], BAD_INPUT)
    assert pinout(SMALL, "--array", "tile-7x8") == pinout(SMALL)


def test_command_lines_that_make_no_sense(folder):
    refuse(folder, ["board"], USAGE)
    refuse(folder, ["board", "pinuot"], USAGE)
    refuse(folder, ["board", "pinout"], USAGE)
    refuse(folder, ["board", "pinout", SMALL, "--csv", "--json"], USAGE)
    refuse(folder, ["board", "pinout", "board.toml", "-o", "./board.toml"], USAGE)
    refuse(folder, ["board", "pinout", "board.toml", "--array", "pair.toml", "-o", "pair.toml"], USAGE)
    refuse(folder, ["compile", "--shape", "point", "--board", "board.toml", "-o", "board.toml"], USAGE)


@pytest.mark.parametrize("name", ["ulx3s", ""])
def test_a_name_that_no_board_has(name, tmp_path):
    refuse(tmp_path, ["board", "pinout", name], BAD_INPUT)
    refuse(tmp_path, ["compile", "--shape", "point", "--board", name, "-o", "image.hex"], BAD_INPUT)


def test_files_that_are_not_there(folder):
    refuse(folder, ["board", "pinout", "nowhere.toml"], BAD_INPUT)
    refuse(folder, ["board", "pinout", "./"], BAD_INPUT)
    refuse(folder, ["board", "pinout", SMALL, "-o", "missing/pins"], BAD_INPUT)
    (folder / "pair.toml").unlink()
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


REQUIRED = ["description", "sources", "array", *(f"fpga.{k}" for k in ("family", "device", "package", "speed", "top")),
            *(f"flash.{k}" for k in ("load", "write", "note")),
            *(f"pins.{k}" for k in ("clk", "rx", "tx", "high"))]  # fmt: skip


@pytest.mark.parametrize("key", REQUIRED)
def test_a_missing_key(key, folder):
    last = key.split(".")[-1]
    (folder / "board.toml").write_text("".join(line for line in GOOD.splitlines(True) if not line.startswith(f"{last} =")))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


@pytest.mark.parametrize("table", ["fpga", "parameters", "flash", "pins"])
def test_a_missing_table(table, folder):
    begin, end = GOOD.index(f"[{table}]"), GOOD.find("\n[", GOOD.index(f"[{table}]"))
    (folder / "board.toml").write_text(GOOD[:begin] + (GOOD[end + 1 :] if end > 0 else ""))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


def test_a_table_that_is_none(folder):
    begin, end = GOOD.index("[flash]"), GOOD.index("[pins]")
    (folder / "board.toml").write_text("flash = 3\n" + GOOD[:begin] + GOOD[end:])
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


# what stands there, what is put instead, and what the message must hold beside the line
BAD = {
    "syntax": ("[fpga]", "[fpga"),
    "unknown key": ("array =", 'colour = "red"\narray ='),
    "unknown table": ("[flash]", "[flashes]"),
    "unknown FPGA key": ("speed = 6", "speeed = 6"),
    "unknown configuration": ("CHANNELS = 3", 'configuration = "tile-99"'),
    "unknown parameter": ("RECORDS", "RECORD"),
    "unknown budget key": ("outputs = [", "budget = { slices = 3 }\noutputs = ["),
    "odd budget": ("outputs = [", "budget = { cells = 'few' }\noutputs = ["),
    "unknown flash key": ("note =", "notes ="),
    "odd stop level": ('led = "A4"', 'stop_level = 2'),
    "neither high nor low": ('led = "A4"', 'active = "up"'),
    "odd strength": ('led = "A4"', 'drive_ma = 5'),
    "odd slew": ('led = "A4"', 'slew = "quick"'),
    "unknown pin": ("rx =", "rxd ="),
    "number for a description": ('description = "A board"', "description = 3"),
    "empty description": ('description = "A board"', 'description = ""'),
    "description of two lines": ('description = "A board"', 'description = "A\\nboard"'),
    "text for a list": ('sources = ["https://example.org/board"]', 'sources = "https://example.org"'),
    "number in a list": ('sources = ["https://example.org/board"]', "sources = [7]"),
    "unknown family": ('family = "ecp5"', 'family = "ecp6"'),
    "text for a speed": ("speed = 6", 'speed = "6"'),
    "text for a parameter": ("RECORDS = 5", 'RECORDS = "5"'),
    "fraction for a parameter": ("RECORDS = 5", "RECORDS = 5.5"),
    "list for a parameter": ("RECORDS = 5", "RECORDS = [5]"),
    "too many channels": ("CHANNELS = 3", "CHANNELS = 1001"),
    "negative records": ("RECORDS = 5", "RECORDS = -5"),
    "no sequence": ("SEQUENCE_DEPTH = 8", "SEQUENCE_DEPTH = 1"),
    "live depth no power of two": ("LIVE_DEPTH = 16", "LIVE_DEPTH = 24"),
    "timing bits": ("TIMING_BITS = 9", "TIMING_BITS = 17"),
    "pulse bits": ("PULSE_BITS = 8", "PULSE_BITS = 9"),
    "more pulse bits than timing bits": ("TIMING_BITS = 9", "TIMING_BITS = 6"),
    "baud that the clock cannot make": ("BAUD = 3000000", "BAUD = 9000000"),
    "baud too slow for the divider": ("BAUD = 3000000", "BAUD = 1200"),
    "guard's bound": ("MAX_HIGH_CLOCKS = 10000", "MAX_HIGH_CLOCKS = 16777216"),
    "text for load": ('load = ["-b", "it"]', 'load = "-b it"'),
    "table for a ball": ('clk = "P1"', "clk = { ball = 1 }"),
    "two words for a ball": ('clk = "P1"', 'clk = "P1 P2"'),
    "text for high": ('high = ["P4"]', 'high = "P4"'),
    "output of three": ('  ["J1", "2", "G0", "A2"],', '  ["J1", "2", "A2"],'),
    "output with a number": ('  ["J1", "2", "G0", "A2"],', '  ["J1", 2, "G0", "A2"],'),
    "output that is none": ('  ["J1", "2", "G0", "A2"],', '  "A2",'),
    "output with a comma": ('  ["J1", "2", "G0", "A2"],', '  ["J1", "2", "G,0", "A2"],'),
    "one ball for two outputs": ('  ["J1", "3", "B0", "A3"],', '  ["J1", "3", "B0", "A1"],'),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_a_bad_board_file(case, folder):
    there, instead = BAD[case]
    assert there in GOOD
    (folder / "board.toml").write_text(GOOD.replace(there, instead, 1))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)
    refuse(folder, ["compile", "--shape", "point", "--board", "board.toml", "-o", "image.hex"], BAD_INPUT)


NETWORK = """[network]
mac = "02:48:47:00:00:01"
ip = "169.254.71.1"
rx_delay = 80
tx_delay = 0
rx_clk = "N1"
rx_ctl = "N2"
rx = ["N3", "N4", "N5", "N6"]
tx_clk = "N7"
tx_ctl = "N8"
tx = ["N9", "N10", "N11", "N12"]
"""
OVER_NETWORK = GOOD.replace("[flash]", "NET = 1\n[flash]").replace('rx = "P2"\ntx = "P3"\n', "") + NETWORK
BAD_NETWORK = {
    "group": ("02:48", "03:48"),
    "short MAC": ("02:48:47:00:00:01", "02:48:47:00:00"),
    "one digit": ("02:48:47:00:00:01", "2:48:47:00:00:01"),
    "number of an address": ("169.254.71.1", "169.254.71.256"),
    "three numbers": ("169.254.71.1", "169.254.71"),
    "delay": ("rx_delay = 80", "rx_delay = 128"),
    "no delay": ("tx_delay = 0\n", ""),
    "three balls": ('"N5", "N6"]', '"N5"]'),
    "unknown": ("rx_ctl", "rx_dv"),
    "used twice": ('"N12"', '"P1"'),
    "serial line, too": ('clk = "P1"\n', 'clk = "P1"\nrx = "P2"\n'),
    "none": (NETWORK, ""),
    "for none": ("NET = 1\n", 'MIN = 1\n'),
    "without NET": ("NET = 1\n", ""),
}


def test_a_board_over_ethernet_has_no_serial_line(folder):
    (folder / "board.toml").write_text(OVER_NETWORK)
    shown = pinout("board.toml", cwd=folder)
    assert shown["network"]["tx"] == ["N9", "N10", "N11", "N12"] and shown["pins"]["rx"] is None
    assert "169.254.71.1, MAC 02:48:47:00:00:01" in text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)


@pytest.mark.parametrize("case", BAD_NETWORK)
def test_a_bad_network(case, folder):
    there, instead = BAD_NETWORK[case]
    assert there in OVER_NETWORK
    (folder / "board.toml").write_text(OVER_NETWORK.replace(there, instead, 1))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


def test_a_network_that_the_core_does_not_have(folder):
    (folder / "board.toml").write_text(GOOD + NETWORK)
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


SDRAM = f"""[sdram]
clk = "M1"
ras_n = "M2"
cas_n = "M3"
we_n = "M4"
bank = ["M5"]
address = [{", ".join(f'"M{k}"' for k in range(6, 17))}]
data = [{", ".join(f'"D{k}"' for k in range(32))}]
flash = ["E1", "E2", "E3"]
"""
WITH_SDRAM = GOOD.replace("CHANNELS = 3", "CHANNELS = 2").replace("[flash]", "SDRAM = 4\n[flash]") + SDRAM
BAD_SDRAM = {
    "two bank balls": ('["M5"]', '["M5", "M20"]'),
    "a ball less": ('"D0", ', ""),
    "a flash without its data": ('"E2", ', ""),
    "a flash on the chip's ball": ('"E2"', '"M6"'),
    "used twice": ('"D1"', '"P1"'),
    "unknown": ("we_n", "cke"),
    "none": (SDRAM, ""),
    "of another size": ("SDRAM = 4", "SDRAM = 6"),
    "without SDRAM": ("SDRAM = 4\n", ""),
    "odd records": ("CHANNELS = 2", "CHANNELS = 3"),
    "too many channels": ("CHANNELS = 2\nRECORDS = 5", "CHANNELS = 100\nRECORDS = 20165"),
}


def test_a_board_with_an_sdram(folder):
    (folder / "board.toml").write_text(WITH_SDRAM)
    (folder / "pair.toml").write_text(ARRAY.replace(", [0, 12.5]", ""))
    shown = pinout("board.toml", cwd=folder)
    assert shown["sdram"]["bank"] == ["M5"] and len(shown["sdram"]["data"]) == 32
    assert "SDRAM  4 MiB" in text(succeed(["board", "pinout", "board.toml"], cwd=folder).stdout)


@pytest.mark.parametrize("case", BAD_SDRAM)
def test_a_bad_sdram(case, folder):
    there, instead = BAD_SDRAM[case]
    assert there in WITH_SDRAM
    (folder / "board.toml").write_text(WITH_SDRAM.replace(there, instead, 1))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


SHARED = {
    "clock on an output": ('clk = "P1"', 'clk = "A2"'),
    "receive and transmit": ('tx = "P3"', 'tx = "P2"'),
    "LED on a channel": ('led = "A4"', 'led = "A1"'),
    "stop on a channel": ('led = "A4"', 'stop = "A1"'),
    "enable is the clock": ('led = "A4"', 'driver_enable = "P1"'),
    "held twice": ('high = ["P4"]', 'high = ["P4", "P4"]'),
    "clock held": ('high = ["P4"]', 'high = ["P1"]'),
}


@pytest.mark.parametrize("case", SHARED)
def test_a_ball_with_two_uses(case, folder):
    there, instead = SHARED[case]
    (folder / "board.toml").write_text(GOOD.replace(there, instead))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


def test_fewer_outputs_than_channels(folder):
    (folder / "board.toml").write_text(GOOD.replace("CHANNELS = 3", "CHANNELS = 5"))
    refuse(folder, ["board", "pinout", "board.toml"], BAD_INPUT)


def test_the_speed_of_an_ice40_may_be_left_out(folder):
    (folder / "board.toml").write_text(GOOD.replace('"ecp5"', '"ice40"').replace("speed = 6\n", ""))
    assert pinout("board.toml", cwd=folder)["fpga"]["speed"] is None


# Images for a board


def compiled(folder, *arguments):
    succeed(["compile", "--shape", "circle", "--diameter", "20", "--center", "0,0,80", "-o", "image.hex", *arguments], cwd=folder)
    return read_json(folder / "image.json"), Image(folder / "image.hex")


@pytest.mark.parametrize("bits, timer", [(16, (3, 400, 200)), (9, (3, 400, 200)), (8, (5, 240, 120)), (7, (10, 120, 60))])
def test_the_timer_is_the_finest_that_the_timing_bits_hold(bits, timer, tmp_path):
    """On the iCE40 board, whatever it is built with."""
    board = (ROOT / "constraints/ice40-hx8k-breakout.toml").read_text(encoding="utf-8")
    board = board.replace("TIMING_BITS = 8\n", f"TIMING_BITS = {bits}\nPULSE_BITS = {min(bits, 8)}\n")
    (tmp_path / "board.toml").write_text(board, encoding="utf-8")
    manifest, image = compiled(tmp_path, "--points", "20", "--board", "board.toml", "--array", "tile-10x10")
    assert tuple(manifest["timer"][key] for key in ("prescaler", "cycle_ticks", "pulse_ticks")) == timer
    shown = json.loads(succeed(["inspect", "image.hex", "--json"], cwd=tmp_path).stdout)
    assert shown["clock_hz"] == 48_000_000 and shown["timing_bits"] == bits and shown["problems"] == []
    timings = [t for record in image.records() for t in record["timings"]]
    assert len(timings) == 2000 and 0.95 * timer[1] < max(timings) < timer[1]


def test_a_parameter_beside_a_configuration_takes_the_place_of_its_value(folder):
    begin, end = GOOD.index("CHANNELS = 3"), GOOD.index("[flash]")
    (folder / "board.toml").write_text(GOOD[:begin] + 'configuration = "ulx3s-85f"\nCHANNELS = 3\n' + GOOD[end:])
    assert pinout("board.toml", cwd=folder)["parameters"] == {**parameters("ulx3s-85f"), "CHANNELS": 3}


def test_a_parameter_that_is_not_there_has_its_default(folder):
    (folder / "board.toml").write_text("".join(line for line in GOOD.splitlines(True) if not line.startswith("BAUD =")))
    assert pinout("board.toml", cwd=folder)["parameters"]["BAUD"] == 1000000


def test_the_largest_image_of_the_ice40_board(tmp_path):
    most = str(parameters("ice40-hx8k-breakout")["RECORDS"])
    assert compiled(tmp_path, "--points", most, "--board", "ice40-hx8k-breakout")[1].count == int(most)
    assert json.loads(succeed(["inspect", "image.hex", "--json"], cwd=tmp_path).stdout)["problems"] == []


def test_the_board_file_takes_the_place_of_the_arrays_board(folder):
    manifest, image = compiled(folder, "--points", "3", "--board", "board.toml")
    assert manifest["array"]["name"] == "pair" and image.channels == 3
    assert manifest["board"] == {"name": "board", "clock_hz": 48e6, "baud": 3_000_000, "channels": 3, "records": 5, "sequence_depth": 8,
                                 "timing_bits": 9, "pulse_bits": 8}  # fmt: skip


def test_another_array_on_the_board(folder):
    (folder / "one.toml").write_text("[array]\nelements_mm = [[0, 0]]\n")
    manifest, image = compiled(folder, "--points", "2", "--board", "board.toml", "--array", "one.toml")
    assert manifest["array"]["name"] == "one" and image.channels == 3
    assert all(record["timings"][1:] == [0xFFFF, 0xFFFF] for record in image.records())
    refuse(folder, ["compile", "--shape", "point", "--board", "board.toml", "--array", "tile-7x8", "-o", "image.hex"], BAD_INPUT, outputs=())  # fmt: skip


def test_an_array_larger_than_its_own_board_on_a_board_that_is_large_enough(folder):
    (folder / "pair.toml").write_text(ARRAY.replace("16", "2"))
    refuse(folder, ["compile", "--shape", "point", "--array", "pair.toml", "-o", "image.hex"], BAD_INPUT)
    assert compiled(folder, "--points", "3", "--board", "board.toml")[1].channels == 3


def test_more_points_than_the_board_has_records(folder):
    circle = ["compile", "--shape", "circle", "--diameter", "20", "--center", "0,0,80", "--board", "board.toml", "-o", "image.hex"]
    refuse(folder, [*circle, "--points", "6"], BAD_INPUT)
    assert compiled(folder, "--points", "5", "--board", "board.toml")[1].count == 5


def test_more_points_than_the_boards_sequence_holds(folder):
    (folder / "board.toml").write_text(GOOD.replace("RECORDS = 5", "RECORDS = 50"))
    circle = ["compile", "--shape", "circle", "--diameter", "20", "--center", "0,0,80", "--board", "board.toml", "-o", "image.hex"]
    refuse(folder, [*circle, "--points", "8"], BAD_INPUT)
    assert compiled(folder, "--points", "7", "--board", "board.toml")[1].count == 7


def test_a_board_whose_timings_are_too_narrow(folder):
    (folder / "board.toml").write_text(GOOD.replace("TIMING_BITS = 9", "TIMING_BITS = 4").replace("PULSE_BITS = 8", "PULSE_BITS = 2"))
    refuse(folder, ["compile", "--shape", "point", "--board", "board.toml", "-o", "image.hex"], BAD_INPUT)  # fmt: skip


def test_the_input_hash_follows_the_board(folder):
    first = compiled(folder, "--points", "3", "--array", "pair.toml")[0]["inputs_sha256"]
    second = compiled(folder, "--points", "3", "--board", "board.toml")[0]["inputs_sha256"]
    (folder / "board.toml").write_text(GOOD.replace("BAUD = 3000000", "BAUD = 1000000"))
    third = compiled(folder, "--points", "3", "--board", "board.toml")[0]["inputs_sha256"]
    assert len({first, second, third}) == 3


def test_without_a_board_nothing_changes(tmp_path):
    result = run(["compile", "--shape", "circle", "--points", "8", "-o", "image.hex"], cwd=tmp_path)
    assert result.returncode == 0
    manifest = read_json(tmp_path / "image.json")
    assert manifest["array"]["name"] == "tile-10x10" and manifest["board"]["name"] == "generic-100" and manifest["board"]["clock_hz"] == 50e6
