# SPDX-License-Identifier: Apache-2.0
"""The rate of a board: found, remembered, fixed; and a virtual board that hears no other one."""
import json
import os
import random
import re
import subprocess
import sys
import termios
import time

import pytest
from patience import bytes_read, until
from support import DEVICE, ROOT, run, succeed, text, virtual_board

sys.path.insert(0, str(ROOT / "tools"))
import boards  # noqa: E402

BOARDS = [name for name in boards.names() if "network" not in boards.load(name)]  # those over Ethernet have no line
WRONG = 9600


@pytest.fixture
def state(tmp_path):
    """A place of its own for the rates that are remembered."""
    return {"XDG_STATE_HOME": str(tmp_path / "state")}


def by_python(*args):
    return [sys.executable, "-m", "haptogram.cli", "device", *args, "--port", "port"]


def ask_python(folder, state, *args):
    environment = {**os.environ, **state, "PYTHONPATH": str(ROOT / "python"), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(by_python(*args), cwd=folder, env=environment, capture_output=True, timeout=300, check=False)


def remembered(folder):
    return (folder / "state/haptogram/ports").read_text().splitlines()


# One board of each rate; the others are the same way again.
FIRST = {boards.load(name)["parameters"].get("BAUD"): name for name in reversed(BOARDS)}.values()


@pytest.mark.parametrize("board", [name if name in FIRST else pytest.param(name, marks=pytest.mark.deep) for name in BOARDS])
def test_the_rate_of_each_shipped_board_is_found(board, tmp_path, state):
    with virtual_board(tmp_path, "--model", "reference", "--board", board) as running:
        baud = running.says["baud"]
        first = succeed(["device", "info", "--json", "--port", "port"], cwd=tmp_path, env=state)
        assert text(first.stderr) == f"haptogram: port: it answers at {baud} baud, which is remembered\n"
        assert json.loads(first.stdout)["channels"] == running.says["channels"]
        assert remembered(tmp_path) == [f"{baud} {tmp_path / 'port'}"]
        assert succeed(["device", "info", "--port", "port"], cwd=tmp_path, env=state).stderr == b""
        assert ask_python(tmp_path, state, "info").stderr == b""  # both programs remember in one place
        (tmp_path / "state/haptogram/ports").unlink()
        said = ask_python(tmp_path, state, "info", "--json")
        assert text(said.stderr) == f"haptogram-py: port: it answers at {baud} baud, which is remembered\n"
        assert json.loads(said.stdout)["channels"] == running.says["channels"]
        assert remembered(tmp_path) == [f"{baud} {tmp_path / 'port'}"]


@pytest.mark.real_time
def test_a_rate_that_is_remembered_takes_no_time(tmp_path, state, figure):
    with virtual_board(tmp_path, "--model", "reference"):
        succeed(["device", "info", "--port", "port"], cwd=tmp_path, env=state)
        begun = time.monotonic()
        succeed(["device", "info", "--port", "port"], cwd=tmp_path, env=state)
        figure("device info at a rate that is remembered", time.monotonic() - begun, 0.2)
        begun = time.monotonic()
        assert ask_python(tmp_path, state, "info").returncode == 0
        figure("the same of haptogram-py", time.monotonic() - begun, 1)


def by_both(folder, state, *args):
    return run(["device", *args, "--port", "port"], cwd=folder, env=state), ask_python(folder, state, *map(str, args))


def right_rate(wrong, right):
    return f"no answer to identify at {wrong} baud, but at {right}: give that rate, or none, and it is found\n"


@pytest.mark.parametrize("remembers", [True, False])
def test_a_wrong_rate_is_named(remembers, tmp_path, state):
    (tmp_path / "file").write_text("in the way")
    state = state if remembers else {"XDG_STATE_HOME": str(tmp_path / "file")}
    with virtual_board(tmp_path, "--model", "reference"):
        for said in by_both(tmp_path, state, "info", "--baud", WRONG):  # the second may find the rate remembered
            assert said.returncode == DEVICE and right_rate(WRONG, 1000000) in text(said.stderr)
        assert right_rate(WRONG, 1000000) in text(run(["device", "self-test", "--port", "port", "--baud", WRONG], cwd=tmp_path, env=state).stderr)


def test_a_wrong_rate_is_named_whatever_it_is(tmp_path, state):
    """HAPTOGRAM_CASES boards and rates drawn by chance."""
    rng, said = random.Random(int(os.environ.get("HAPTOGRAM_SEED", "1"))), []
    for _ in range(int(os.environ.get("HAPTOGRAM_CASES", "1"))):
        board = rng.choice(BOARDS)
        with virtual_board(tmp_path, "--model", "reference", "--board", board) as running:
            right = running.says["baud"]
            wrong = rng.choice([rate for rate in (9600, 57600, 115200, 460800, 921600, 1000000, 2000000, 3000000) if rate != right])
            for told in by_both(tmp_path, state, "info", "--baud", wrong):
                if told.returncode != DEVICE or right_rate(wrong, right) not in text(told.stderr):
                    said.append((board, right, wrong, text(told.stderr)))
        (tmp_path / "port").unlink()
    assert not said


def test_a_board_of_a_rate_that_is_not_known_is_named_by_none(tmp_path, state):
    shipped = (ROOT / "constraints/ice40-hx8k-breakout.toml").read_text()
    (tmp_path / "own.toml").write_text(re.sub(r"^BAUD = \d+", "BAUD = 500000", shipped, flags=re.M))
    with virtual_board(tmp_path, "--model", "reference", "--board", "./own.toml") as running:
        assert running.says["baud"] == 500000
        for told in by_both(tmp_path, state, "info", "--baud", WRONG):
            assert told.returncode == DEVICE
            assert f"nor is there one at another rate than {WRONG} baud: 3000000, 1000000, 115200 were tried" in text(told.stderr)


def test_a_rate_that_is_remembered_and_wrong_is_replaced(tmp_path, state):
    (tmp_path / "state/haptogram").mkdir(parents=True)
    note = tmp_path / "state/haptogram/ports"
    note.write_text(f"3000000 /dev/elsewhere\n115200 {tmp_path / 'port'}\nrubbish\n")
    with virtual_board(tmp_path, "--model", "reference"):
        succeed(["device", "info", "--port", "port"], cwd=tmp_path, env=state)
    assert remembered(tmp_path) == ["3000000 /dev/elsewhere", "rubbish", f"1000000 {tmp_path / 'port'}"]


@pytest.mark.parametrize("blocked", ["no folder", "no home"])
def test_nothing_can_be_remembered(blocked, tmp_path):
    (tmp_path / "file").write_text("in the way")
    state = {"XDG_STATE_HOME": str(tmp_path / "file")} if blocked == "no folder" else {"XDG_STATE_HOME": "", "HOME": ""}
    with virtual_board(tmp_path, "--model", "reference"):
        for _ in range(2):
            assert b"1000000" in succeed(["device", "info", "--port", "port"], cwd=tmp_path, env=state).stderr
            said = ask_python(tmp_path, state, "info")
            assert said.returncode == 0 and b"1000000" in said.stderr


def test_a_board_of_an_unknown_rate_is_turned_off(tmp_path, state):
    with virtual_board(tmp_path, "--model", "reference", "--board", "colorlight-5a-75e-v7.1"):
        for turn_off in (lambda: run(["device", "disable", "--port", "port"], cwd=tmp_path, env=state), lambda: ask_python(tmp_path, state, "disable")):
            succeed(["device", "enable", "--watchdog", 0, "--port", "port"], cwd=tmp_path, env=state)
            (tmp_path / "state/haptogram/ports").unlink()
            assert turn_off().returncode == 0
            assert json.loads(succeed(["device", "status", "--json", "--port", "port"], cwd=tmp_path, env=state).stdout)["outputs"] == "off"


def test_several_boards_behind_ports_of_their_own(tmp_path, state):
    with virtual_board(tmp_path, "--model", "reference", "--tiles", "2"):
        for tile in (1, 2):
            assert json.loads(succeed(["device", "info", "--json", "--port", f"port-{tile}"], cwd=tmp_path, env=state).stdout)["channels"] == 100
    assert [line.split()[0] for line in remembered(tmp_path)] == ["1000000", "1000000"]


def test_bytes_at_another_rate_are_lost(tmp_path, state):
    with virtual_board(tmp_path, "--model", "reference") as board:
        before = json.loads(succeed(["device", "status", "--json", "--port", "port"], cwd=tmp_path, env=state).stdout)
        port = os.open(tmp_path / "port", os.O_RDWR | os.O_NOCTTY)
        settings = termios.tcgetattr(port)
        settings[4] = settings[5] = termios.B115200
        termios.tcsetattr(port, termios.TCSANOW, settings)
        heard = bytes_read(board)
        os.write(port, b"no frame at all\0" * 10)
        until(lambda: bytes_read(board) >= heard + 160, "the board having read them")
        os.close(port)
        after = json.loads(succeed(["device", "status", "--json", "--port", "port"], cwd=tmp_path, env=state).stdout)
        assert after["frames_damaged"] == before["frames_damaged"]
