# SPDX-License-Identifier: Apache-2.0
"""Array files that cannot be used name the file, the line and the key."""
import pytest
from messages import program_said
from support import BAD_INPUT, refuse, run, succeed

GRID = "[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n"


def compile_with(array):
    return ["compile", "--shape", "point", "--array", array, "-o", "image.hex"]


def test_the_good_array_compiles(tmp_path):
    (tmp_path / "array.toml").write_text(GRID)
    succeed(compile_with("array.toml"), cwd=tmp_path)


BAD = {
    "syntax": "[array\nrows = 2\n",
    "cut short": GRID + "duty = ",
    "no text": b"\xff\xfe\x00",
    "empty": "",
    "unknown key": GRID + "colums = 3\n",
    "unknown table": GRID + "[bord]\nrecords = 2\n",
    "a table that is none": "array = 3\n",
    "text for a number": '[array]\nrows = "2"\ncolumns = 2\npitch_mm = 10\n',
    "fraction for a whole number": GRID + "[board]\nbaud = 1.5\n",
    "number for a text": GRID + "[board]\nname = 7\n",
    "number for the name": "name = 3\n" + GRID,
    "NaN": "[array]\nrows = 2\ncolumns = 2\npitch_mm = nan\n",
    "infinite": "[array]\nrows = 2\ncolumns = 2\npitch_mm = inf\n",
    "zero rows": "[array]\nrows = 0\ncolumns = 2\npitch_mm = 10\n",
    "negative": GRID + "[board]\nrecords = -4\n",
    "twice": GRID + "rows = 2\n",
    "no pitch": "[array]\nrows = 2\ncolumns = 2\n",
    "elements and rows": "[array]\nelements_mm = [[0, 0]]\nrows = 2\n",
    "no elements": "[array]\nelements_mm = []\n",
    "element with four numbers": "[array]\nelements_mm = [[0, 0],\n [1, 2, 3, 4]]\n",
    "element not finite": "[array]\nelements_mm = [[0, 0],\n [nan, 0]]\n",
    "two elements in one place": "[array]\nelements_mm = [[0, 0],\n [10, 0],\n [0, 0]]\n",
    "two media": GRID + "[medium]\nspeed_m_s = 340\ntemperature_c = 20\n",
    "more elements than channels": GRID + "[board]\nchannels = 3\n",
    "a clock that cannot make the carrier": GRID + "carrier_hz = 41234.5\n",
    "a clock too slow": GRID + "carrier_hz = 200000.0\n[board]\nclock_hz = 1000000\nbaud = 115200\n",
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_array_file(case, tmp_path):
    content = BAD[case]
    (tmp_path / "array.toml").write_bytes(content if isinstance(content, bytes) else content.encode())
    refuse(tmp_path, compile_with("array.toml"), BAD_INPUT)


def test_a_missing_array_file(tmp_path):
    refuse(tmp_path, compile_with("nowhere.toml"), BAD_INPUT)


def test_a_name_that_no_shipped_array_has(tmp_path):
    refuse(tmp_path, compile_with("tile-9x9"), BAD_INPUT)


def test_a_directory_for_an_array_file(tmp_path):
    (tmp_path / "folder.toml").mkdir()
    refuse(tmp_path, compile_with("folder.toml"), BAD_INPUT)


def test_an_image_for_an_array_file(small):
    result = run(compile_with("./image.hex")[:-2] + ["-o", "new.hex"], cwd=small.folder)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
    assert not (small.folder / "new.hex").exists()


def test_a_board_with_few_records(tmp_path):
    (tmp_path / "array.toml").write_text(GRID + "[board]\nrecords = 5\n")
    circle = ["compile", "--shape", "circle", "--center", "0,0,80", "--array", "array.toml", "-o", "image.hex"]
    refuse(tmp_path, [*circle, "--points", "6"], BAD_INPUT)
    succeed([*circle, "--points", "5"], cwd=tmp_path)


def test_a_board_with_a_short_sequence(tmp_path):
    (tmp_path / "array.toml").write_text(GRID + "[board]\nsequence_depth = 4\n")
    circle = ["compile", "--shape", "circle", "--center", "0,0,80", "--array", "array.toml", "-o", "image.hex"]
    refuse(tmp_path, [*circle, "--points", "4"], BAD_INPUT)
    succeed([*circle, "--points", "3"], cwd=tmp_path)
