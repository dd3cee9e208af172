# SPDX-License-Identifier: Apache-2.0
"""Trigger pins of a virtual board: what is set stays, what the board counts, what waits for a trigger, and what is refused."""
import json
import signal
import subprocess
import time

import pytest
from support import BAD_INPUT, DEVICE, PROGRAM, USAGE, ask, assert_one_message, run, status, succeed, virtual_board


@pytest.fixture
def running(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "ulx3s-85f") as board:
        yield board


@pytest.fixture
def board(running, tmp_path):
    """The folder that has its port."""
    return tmp_path


def trigger(folder, *options):
    return json.loads(ask(folder, "device", "trigger", "--json", *options).stdout)


@pytest.mark.check
def test_what_is_set_stays_and_is_counted(board, running):
    first = trigger(board, "--out", "period", "--every", "400", "--pulse", "0.1")
    assert (first["out"], first["every"], first["pulse_ms"], first["in"]) == ("period", 400, 0.1, "high")
    running.goes_on_for(0.1)
    later = trigger(board, "--in", "low", "--settle", "0.02", "--test", "carrier", "--channel", "3")
    assert (later["out"], later["every"], later["in"], later["settle_ms"], later["test"], later["channel"]) == ("period", 400, "low", 0.02, "carrier", 3)
    clocks = later["clock"] - first["clock"]
    assert clocks > 4_000_000
    assert abs((later["out_count"] - first["out_count"]) % 65536 - clocks / (400 * 1250) % 65536) <= 1.5
    assert 0 <= later["clock"] - later["out_clock"] <= 400 * 1250


def test_a_start_waits_for_it_and_stop_ends_the_wait(board):
    succeed(["compile", "--shape", "circle", "--points", "4", "--rate", "500", "--board", "ulx3s-85f", "-o", "c.hex"], cwd=board)
    ask(board, "upload", "c.hex")
    ask(board, "device", "start", "--first", "1", "--length", "4", "--on-trigger")
    assert status(board)["waiting"]
    ask(board, "device", "stop")
    said = status(board)
    assert not said["waiting"] and said["outputs"] == "off"


def test_playing_waits_for_it(board, running):
    """Nothing drives the pin of a virtual board: it is low, which is active or not as it is set."""
    succeed(["compile", "--shape", "circle", "--points", "4", "--rate", "500", "--board", "ulx3s-85f", "-o", "c.hex"], cwd=board)
    ask(board, "upload", "c.hex")
    trigger(board, "--in", "low", "--level", "--out", "start")
    assert json.loads(ask(board, "play", "--loops", "3", "--watchdog", "0", "--on-trigger", "--json").stdout)["underruns"] == 0
    assert trigger(board)["out_count"] == 1
    trigger(board, "--in", "high", "--level")
    waits = subprocess.Popen([PROGRAM, "play", "--loops", "3", "--seconds", "0.01", "--watchdog", "0", "--on-trigger", "--port", "port"], cwd=board, stderr=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL)  # fmt: skip
    running.until(outputs=True)
    running.goes_on_for(0.3)
    assert waits.poll() is None, "its seconds begin with the trigger"
    waits.send_signal(signal.SIGINT)
    waits.communicate(timeout=300)
    assert trigger(board)["out_count"] == 1 and status(board)["outputs"] == "off" and not status(board)["waiting"]
    for more in (["--rate", "20"], ["--index", "1"]):
        assert_one_message(run(["play", "--on-trigger", *more, "--port", "port"], cwd=board), USAGE)


def test_another_command_that_waits_does_not_hold_up_the_end(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100-wide"):
        succeed(["compile", "--shape", "circle", "--points", "4", "--rate", "500", "--board", "tile-100-wide", "--array", "tile-10x10", "-o", "c.hex"], cwd=tmp_path)
        ask(tmp_path, "upload", "c.hex")
        ask(tmp_path, "device", "modulate", "--samples", "4", "--at-period", "4000000000000")
        assert status(tmp_path)["waiting"]
        ask(tmp_path, "play", "--loops", "3", "--watchdog", "0")
        assert status(tmp_path)["outputs"] == "off"


@pytest.mark.parametrize("options", [["--every", "3"], ["--out", "mark", "--every", "3"], ["--gate"],
                                             ["--test", "cycle", "--channel", "2"], ["--out", "never"],
                                             ["--test", "carrier", "--channel", "999"], ["--pulse", "9999"]])  # fmt: skip
def test_what_makes_no_sense_is_refused(board, options):
    assert_one_message(run(["device", "trigger", "--port", "port", *options], cwd=board), USAGE)


def test_a_board_without_pins_says_so(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100"):
        assert_one_message(run(["device", "trigger", "--port", "port"], cwd=tmp_path), DEVICE)
        assert_one_message(run(["device", "start", "--on-trigger", "--port", "port"], cwd=tmp_path), DEVICE)


PROJECT = """format = "haptogram-project-1"
board = "ulx3s-85f"
points = 4
rate_hz = 20
{triggers}
[[shape]]
kind = "circle"
[[keyframe]]
time_s = 0
[[keyframe]]
time_s = 0.2
mark = true
[[keyframe]]
time_s = 0.4
"""
TRIGGERS = """
[[trigger]]
on = "key:a"
to_s = 0.2
[[trigger]]
on = "line:go"
from_s = 0.2
loops = 2
[[trigger]]
on = "region"
center_mm = [0, 0, 150]
size_mm = 60
from_s = 0.2
"""


def design(folder, triggers, name="design.toml"):
    (folder / name).write_text(PROJECT.format(triggers=triggers))
    succeed(["compile", name, "-o", "design.hex"], cwd=folder)
    ask(folder, "upload", "design.hex")


def waits_for_triggers(folder, *more):
    return subprocess.Popen([PROGRAM, "play", "--triggers", "design.toml", "--watchdog", "0", "--port", "port", *more], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE)  # fmt: skip


def hand(x):
    return json.dumps({"scene": 2, "hands": [{"palm_mm": [x, 0, 150], "fingers_mm": []}]})


def test_keys_lines_and_hands_start_their_part(board):
    """The second half of the pass begins with a mark, the first does not. What plays when the input ends is played to its end."""
    design(board, TRIGGERS)
    trigger(board, "--out", "mark")
    told, marks = [], []
    comes_in_once = "\n".join(["nothing of that", "{", *map(hand, (100, 0, 10, 100))]) + "\n"
    for words in ("a\n", "go\n", comes_in_once, hand(0)):  # go: twice; the last line is one without its end
        plays = waits_for_triggers(board)
        _, said = plays.communicate(words.encode(), timeout=300)
        assert plays.returncode == 0, said
        told.append(said)
        marks.append(trigger(board)["out_count"])
    assert marks == [0, 2, 3, 4] and status(board)["outputs"] == "off"
    assert b"found 'nothing of that', expected 'a', 'go' or a scene" in told[2] and b"standard input:1" in told[2] and b"no scene" in told[2]


@pytest.mark.real_time
def test_one_session_waits_for_many_triggers(board):
    """What comes while a part plays begins at once, so each line comes when the one before has played."""
    design(board, TRIGGERS)
    trigger(board, "--out", "mark")
    plays = waits_for_triggers(board)

    def say(line, seconds):
        plays.stdin.write(line.encode() + b"\n")
        plays.stdin.flush()
        time.sleep(seconds)

    time.sleep(1.0)
    say("a", 0.6)
    say("go", 1.2)  # twice
    say("nothing of that", 0)
    say("{", 0)
    for x in (100, 0, 10, 100):  # it comes in once
        say(hand(x), 0.5)
    plays.stdin.write(hand(0).encode())  # a last line without its end
    _, said = plays.communicate(timeout=300)
    assert plays.returncode == 0, said
    assert b"found 'nothing of that', expected 'a', 'go' or a scene" in said and b"standard input:3" in said and b"no scene" in said
    assert trigger(board)["out_count"] == 4 and status(board)["outputs"] == "off"


def test_a_key_alone_starts_what_it_says(board):
    design(board, TRIGGERS)
    trigger(board, "--out", "pass")
    for words, passes in ((b"", 0), (b"a\n", 1), (b"go\n", 3)):
        plays = waits_for_triggers(board)
        _, said = plays.communicate(words, timeout=300)
        assert plays.returncode == 0, said
        assert trigger(board)["out_count"] == passes, words


def test_the_pin_starts_its_part_again_and_again(board):
    """Nothing drives the pin of a virtual board: it is low, which is active or not as it is set."""
    design(board, '[[trigger]]\non = "pin"\nto_s = 0.1\n')
    trigger(board, "--out", "pass", "--in", "high", "--level")
    ask(board, "play", "--triggers", "design.toml", "--seconds", "0.5", "--watchdog", "0")
    assert trigger(board)["out_count"] == 0 and not status(board)["waiting"]
    trigger(board, "--in", "low", "--level")
    ask(board, "play", "--triggers", "design.toml", "--seconds", "3", "--watchdog", "0")
    assert trigger(board)["out_count"] >= 2 and status(board)["outputs"] == "off"


def test_triggers_that_cannot_be_are_refused(board):
    design(board, "")
    assert_one_message(run(["play", "--triggers", "design.toml", "--port", "port"], cwd=board), BAD_INPUT)
    (board / "late.toml").write_text(PROJECT.format(triggers='[[trigger]]\non = "key:a"\nfrom_s = 3\n'))
    assert_one_message(run(["play", "--triggers", "late.toml", "--port", "port"], cwd=board), BAD_INPUT)
    assert_one_message(run(["compile", "late.toml", "-o", "late.hex"], cwd=board), BAD_INPUT)
    for more in (["--loops", "2"], ["--index", "1"], ["--rate", "20"], ["--on-trigger"]):
        assert_one_message(run(["play", "--triggers", "late.toml", "--port", "port", *more], cwd=board), USAGE)


BOARD, OTHER = 'board = "ulx3s-85f"', 'board = "tile-100"\narray = "tile-10x10"'


def test_a_board_without_the_pin_refuses_a_trigger_of_it(tmp_path):
    pin = PROJECT.format(triggers='[[trigger]]\non = "pin"\n').replace("mark = true\n", "")
    (tmp_path / "pin.toml").write_text(pin)
    (tmp_path / "none.toml").write_text(pin.replace(BOARD, OTHER))
    assert_one_message(run(["compile", "none.toml", "-o", "none.hex"], cwd=tmp_path), BAD_INPUT)
    (tmp_path / "plain.toml").write_text(pin.replace(BOARD, OTHER).replace('[[trigger]]\non = "pin"\n', ""))
    succeed(["compile", "plain.toml", "-o", "plain.hex"], cwd=tmp_path)
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100"):
        ask(tmp_path, "upload", "plain.hex")
        assert_one_message(run(["play", "--triggers", "pin.toml", "--port", "port"], cwd=tmp_path), DEVICE)
