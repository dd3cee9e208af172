# SPDX-License-Identifier: Apache-2.0
"""Array files that cannot be used name the file, the line and the key."""
import pytest
from support import BAD_INPUT, refuse, run, succeed

GRID = "[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n"


def compile_with(array):
    return ["compile", "--shape", "point", "--array", array, "-o", "image.hex"]


def test_the_good_array_compiles(tmp_path):
    (tmp_path / "array.toml").write_text(GRID)
    succeed(compile_with("array.toml"), cwd=tmp_path)


BAD = {
    "syntax": ("[array\nrows = 2\n", ["toml:1", "TOML"]),
    "cut short": (GRID + "duty = ", ["toml:5", "TOML"]),
    "no text": (b"\xff\xfe\x00", ["toml:1", "TOML"]),
    "empty": ("", ["rows", "elements_mm"]),
    "unknown key": (GRID + "colums = 3\n", ["toml:5", r"array\.colums", "known are", "columns"]),
    "unknown table": (GRID + "[bord]\nrecords = 2\n", ["toml:5", "bord", "board"]),
    "a table that is none": ("array = 3\n", ["toml:1", "array", "table"]),
    "text for a number": ('[array]\nrows = "2"\ncolumns = 2\npitch_mm = 10\n', ["toml:2", r"array\.rows", "whole number", r"['\"]2['\"]"]),
    "fraction for a whole number": (GRID + "[board]\nbaud = 1.5\n", ["toml:6", r"board\.baud", "whole number", r"1\.5"]),
    "number for a text": (GRID + "[board]\nname = 7\n", ["toml:6", r"board\.name", "text"]),
    "number for the name": ("name = 3\n" + GRID, ["toml:1", "name", "text"]),
    "NaN": ("[array]\nrows = 2\ncolumns = 2\npitch_mm = nan\n", ["toml:4", r"array\.pitch_mm"]),
    "infinite": ("[array]\nrows = 2\ncolumns = 2\npitch_mm = inf\n", ["toml:4", r"array\.pitch_mm"]),
    "zero rows": ("[array]\nrows = 0\ncolumns = 2\npitch_mm = 10\n", ["toml:2", r"array\.rows", "from 1"]),
    "negative": (GRID + "[board]\nrecords = -4\n", ["toml:6", r"board\.records", "from 1", "-4"]),
    "twice": (GRID + "rows = 2\n", ["toml:5", "rows"]),
    "no pitch": ("[array]\nrows = 2\ncolumns = 2\n", ["pitch_mm"]),
    "elements and rows": ("[array]\nelements_mm = [[0, 0]]\nrows = 2\n", ["toml:2", "elements_mm", "rows"]),
    "no elements": ("[array]\nelements_mm = []\n", ["toml:2", "elements_mm"]),
    "element with four numbers": ("[array]\nelements_mm = [[0, 0],\n [1, 2, 3, 4]]\n", ["toml:3", "elements_mm", "x, y"]),
    "element not finite": ("[array]\nelements_mm = [[0, 0],\n [nan, 0]]\n", ["toml:3", "elements_mm"]),
    "two elements in one place": ("[array]\nelements_mm = [[0, 0],\n [10, 0],\n [0, 0]]\n", ["toml:4", "elements_mm"]),
    "two media": (GRID + "[medium]\nspeed_m_s = 340\ntemperature_c = 20\n", ["speed_m_s", "temperature_c", "not both"]),
    "more elements than channels": (GRID + "[board]\nchannels = 3\n", ["4 elements", "3 channels"]),
    "a clock that cannot make the carrier": (GRID + "carrier_hz = 41234.5\n", ["41234.5", "50000000", "clock"]),
    "a clock too slow": (GRID + "carrier_hz = 200000.0\n[board]\nclock_hz = 1000000\nbaud = 115200\n", ["200000", "1000000", "clock"]),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_array_file(case, tmp_path):
    content, needles = BAD[case]
    (tmp_path / "array.toml").write_bytes(content if isinstance(content, bytes) else content.encode())
    refuse(tmp_path, compile_with("array.toml"), BAD_INPUT, r"array\.toml", *needles)


def test_a_missing_array_file(tmp_path):
    refuse(tmp_path, compile_with("nowhere.toml"), BAD_INPUT, r"nowhere\.toml", "No such file")


def test_a_name_that_no_shipped_array_has(tmp_path):
    refuse(tmp_path, compile_with("tile-9x9"), BAD_INPUT, "tile-9x9", "tile-10x10", "hoshi-18x18", r"\.toml")


def test_a_directory_for_an_array_file(tmp_path):
    (tmp_path / "folder.toml").mkdir()
    refuse(tmp_path, compile_with("folder.toml"), BAD_INPUT, r"folder\.toml", "directory")


def test_an_image_for_an_array_file(small):
    result = run(compile_with("./image.hex")[:-2] + ["-o", "new.hex"], cwd=small.folder)
    assert result.returncode == BAD_INPUT and b"image.hex:1: not valid TOML" in result.stderr
    assert not (small.folder / "new.hex").exists()


def test_a_board_with_few_records(tmp_path):
    (tmp_path / "array.toml").write_text(GRID + "[board]\nrecords = 5\n")
    circle = ["compile", "--shape", "circle", "--center", "0,0,80", "--array", "array.toml", "-o", "image.hex"]
    refuse(tmp_path, [*circle, "--points", "6"], BAD_INPUT, "6 points", "holds 5", "--points")
    succeed([*circle, "--points", "5"], cwd=tmp_path)


def test_a_board_with_a_short_sequence(tmp_path):
    (tmp_path / "array.toml").write_text(GRID + "[board]\nsequence_depth = 4\n")
    circle = ["compile", "--shape", "circle", "--center", "0,0,80", "--array", "array.toml", "-o", "image.hex"]
    refuse(tmp_path, [*circle, "--points", "4"], BAD_INPUT, "4 points", "holds 3")
    succeed([*circle, "--points", "3"], cwd=tmp_path)
