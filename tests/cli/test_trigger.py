# SPDX-License-Identifier: Apache-2.0
"""Trigger pins of a virtual board: what is set stays, what the board counts, what waits for a trigger, and what is refused."""
import json
import signal
import subprocess
import time

import pytest
from support import DEVICE, PROGRAM, USAGE, ask, assert_one_message, run, status, succeed, virtual_board


@pytest.fixture
def board(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "ulx3s-85f"):
        yield tmp_path


def trigger(folder, *options):
    return json.loads(ask(folder, "device", "trigger", "--json", *options).stdout)


def test_what_is_set_stays_and_is_counted(board):
    first = trigger(board, "--out", "period", "--every", "400", "--pulse", "0.1")
    assert (first["out"], first["every"], first["pulse_ms"], first["in"]) == ("period", 400, 0.1, "high")
    time.sleep(0.2)
    later = trigger(board, "--in", "low", "--settle", "0.02", "--test", "carrier", "--channel", "3")
    assert (later["out"], later["every"], later["in"], later["settle_ms"], later["test"], later["channel"]) == ("period", 400, "low", 0.02, "carrier", 3)
    clocks = later["clock"] - first["clock"]
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


def test_playing_waits_for_it(board):
    """Nothing drives the pin of a virtual board: it is low, which is active or not as it is set."""
    succeed(["compile", "--shape", "circle", "--points", "4", "--rate", "500", "--board", "ulx3s-85f", "-o", "c.hex"], cwd=board)
    ask(board, "upload", "c.hex")
    trigger(board, "--in", "low", "--level", "--out", "start")
    assert json.loads(ask(board, "play", "--loops", "3", "--watchdog", "0", "--on-trigger", "--json").stdout)["underruns"] == 0
    assert trigger(board)["out_count"] == 1
    trigger(board, "--in", "high", "--level")
    waits = subprocess.Popen([PROGRAM, "play", "--loops", "3", "--seconds", "0.01", "--watchdog", "0", "--on-trigger", "--port", "port"], cwd=board, stderr=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL)  # fmt: skip
    time.sleep(1.0)
    assert waits.poll() is None, "its seconds begin with the trigger"
    waits.send_signal(signal.SIGINT)
    waits.communicate(timeout=20)
    assert trigger(board)["out_count"] == 1 and status(board)["outputs"] == "off" and not status(board)["waiting"]
    for more in (["--rate", "20"], ["--index", "1"]):
        assert_one_message(run(["play", "--on-trigger", *more, "--port", "port"], cwd=board), USAGE, "on-trigger")


def test_another_command_that_waits_does_not_hold_up_the_end(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100-wide"):
        succeed(["compile", "--shape", "circle", "--points", "4", "--rate", "500", "--board", "tile-100-wide", "--array", "tile-10x10", "-o", "c.hex"], cwd=tmp_path)
        ask(tmp_path, "upload", "c.hex")
        ask(tmp_path, "device", "modulate", "--samples", "4", "--at-period", "4000000000000")
        assert status(tmp_path)["waiting"]
        ask(tmp_path, "play", "--loops", "3", "--watchdog", "0")
        assert status(tmp_path)["outputs"] == "off"


@pytest.mark.parametrize("options, needle", [(["--every", "3"], "--every"), (["--out", "mark", "--every", "3"], "event is mark"), (["--gate"], "--in"),
                                             (["--test", "cycle", "--channel", "2"], "--channel"), (["--out", "never"], "--out"),
                                             (["--test", "carrier", "--channel", "999"], "channel"), (["--pulse", "9999"], "clocks at most")])  # fmt: skip
def test_what_makes_no_sense_is_refused(board, options, needle):
    assert_one_message(run(["device", "trigger", "--port", "port", *options], cwd=board), USAGE, needle)


def test_a_board_without_pins_says_so(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100"):
        assert_one_message(run(["device", "trigger", "--port", "port"], cwd=tmp_path), DEVICE, "TRIGGER")
        assert_one_message(run(["device", "start", "--on-trigger", "--port", "port"], cwd=tmp_path), DEVICE, "TRIGGER|SCHEDULE")
