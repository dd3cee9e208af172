# SPDX-License-Identifier: Apache-2.0
"""Boards over UDP: virtual ones, their sessions, their open port, and what a network does to datagrams."""
import contextlib
import json
import math
import os
import random
import signal
import socket
import subprocess
import sys
import time

import pytest
from patience import also_in_time, until
from support import BAD_INPUT, DEVICE, OK, PROGRAM, ROOT, USAGE, assert_one_message, run, succeed, text, virtual_board

BOARD = "colorlight-5a-75e-v7.1-net"
IDENTIFY, DISABLE, STOP = 1, 5, 9


class NetBoard:
    """A virtual board over UDP; its outcome is there once it has ended."""

    def __init__(self, folder, *options, model="reference"):
        command = [str(PROGRAM), "board", "run", "--json", "--model", model, "--board", BOARD, "--net", "--net-port", "0", *map(str, options)]
        self.process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE)
        self.port = json.loads(self.process.stdout.readline())["port"]
        self.address = ("127.0.0.1", int(self.port.rpartition(":")[2]))
        self.outcome = None

    def end(self):
        self.process.send_signal(signal.SIGINT)
        rest, _ = self.process.communicate(timeout=300)
        self.outcome = json.loads(rest)
        assert self.process.returncode == OK

    def asks(self, *questions):
        """What the open port answers first."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker:
            asker.connect((self.address[0], self.address[1] + 1))
            asker.settimeout(300)
            for question in questions:
                asker.send(question)
            return asker.recv(2048)

    def flags(self):
        return self.asks(b"HG\x01\0")[3]

    @property
    def held(self):
        return bool(self.flags() & 1)

    @property
    def enabled(self):
        return bool(self.flags() & 2)

    def until(self, state, value):
        """The seconds until it was so."""
        begun = time.monotonic()
        until(lambda: getattr(self, state) == value, f"{state} = {value}")
        return time.monotonic() - begun


@contextlib.contextmanager
def net_board(folder, *options, **more):
    board = NetBoard(folder, *options, **more)
    try:
        yield board
        board.end()
    finally:
        board.process.kill()
        board.process.wait()


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    path = tmp_path_factory.mktemp("net") / "dome.hex"
    succeed(["compile", "--shape", "hemisphere", "--diameter", "80", "--center", "0,0,150", "--rate", "7", "--board", BOARD, "-o", path])
    return path


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    """A board that nobody drives."""
    with net_board(tmp_path_factory.mktemp("quiet")) as board:
        yield board


@contextlib.contextmanager
def playing(board, watchdog_ms=60000):
    """A program that plays for ever, and has outputs on."""
    command = [str(PROGRAM), "play", "--port", board.port, "--loops", "0", "--watchdog", str(watchdog_ms)]
    player = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        board.until("enabled", True)
        yield player
    finally:
        player.kill()
        player.wait()


@also_in_time
def test_an_image_goes_up_and_plays(tmp_path, image, figure, in_time):
    with net_board(tmp_path) as board:
        assert json.loads(succeed(["device", "info", "--port", board.port, "--json"]).stdout)["channels"] == 100
        succeed(["upload", image, "--port", board.port])
        succeed(["play", "--port", board.port, "--loops", 2])
        assert not board.enabled
    assert board.outcome["frames_refused"] == 0
    if in_time:  # after 10 ms without an answer
        figure("UDP: frames that were sent twice, on a line that loses none", board.outcome["frames_repeated"], 0, "")


def test_a_network_that_loses_doubles_and_delays_changes_nothing(tmp_path, image):
    with net_board(tmp_path, "--loss", 0.05, "--duplicates", 0.05, "--jitter-ms", 2) as board:
        succeed(["upload", image, "--port", board.port], timeout=300)
        again = succeed(["upload", image, "--port", board.port], timeout=300)  # reads digests: all is there already
        assert "0" in text(again.stderr + again.stdout)
        succeed(["play", "--port", board.port, "--loops", 1], timeout=300)
    assert board.outcome["frames_repeated"] > 0
    assert not board.outcome["enabled"]


@also_in_time
def test_the_watchdog_sees_a_host_that_was_killed(tmp_path, image, figure, in_time):
    with net_board(tmp_path) as board:
        succeed(["upload", image, "--port", board.port])
        with playing(board, 500 if in_time else 3000) as player:
            assert board.held
            player.kill()
            off_s = board.until("enabled", False)
            held_s = board.until("held", False)
            assert json.loads(succeed(["device", "status", "--port", board.port, "--json"]).stdout)["watchdog_trips"] == 1
    if in_time:
        figure("UDP: outputs off after the host was killed, its watchdog being 500 ms", off_s, 0.55)
        figure("UDP: a killed host holds the board no longer", off_s + held_s, 1.1)


def answered(*args):
    """The command's result, if the board has answered it: on a busy machine its patience may end before that."""
    result = run(args)
    return None if b"network's cable" in result.stderr else result


def test_one_peer_holds_it_and_anybody_turns_it_off(tmp_path, image):
    with net_board(tmp_path) as board:
        succeed(["upload", image, "--port", board.port])
        with playing(board):
            for command in ("info", "enable"):
                assert_one_message(until(lambda: answered("device", command, "--port", board.port)), DEVICE)
            assert board.enabled
            succeed(["device", "disable", "--port", board.port])
            assert not board.enabled
            about = board.asks(b"HG\x01\0")
            assert int.from_bytes(about[58:60], "little") > 0  # refused


@pytest.mark.parametrize("question, answered", [(b"HG\x01\0", True), (b"HG\x05\0", True), (b"HG\x09\0", True), (b"HG\x04\0", False), (b"HG\x01\1", False),
                                                (b"HG\x01", False), (b"HG\x01\0\0", False), (b"hG\x01\0", False), (b"", False)])  # fmt: skip
def test_the_open_port_takes_three_questions(quiet, question, answered):
    """What is no question has no answer: the first one is that of the question behind it."""
    answer = quiet.asks(question) if answered else quiet.asks(question, b"HG\x09\0")
    assert answer[:3] == b"HG" + bytes([(question[2] if answered else 9) | 0x80]) and len(answer) == 62
    assert answer[4:13] == b"Haptogram"


def test_noise_of_the_peer_is_counted_and_nothing_more(tmp_path):
    with net_board(tmp_path) as board, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.connect(board.address)
        noise = random.Random(3)
        for sent in range(200):
            peer.send(noise.randbytes(noise.randint(0, 1472)))
            if sent % 10 == 9:
                assert board.flags() is not None  # it has taken what came before
        until(lambda: run(["device", "info", "--port", board.port]).returncode == OK, "the end of the peer's turn")  # it is the peer for a second
        status = json.loads(succeed(["device", "status", "--port", board.port, "--json"]).stdout)
        assert status["frames_damaged"] > 100
        assert status["outputs"] == "off"


@pytest.mark.check
def test_it_is_found_by_a_question(quiet):
    quiet.until("held", False)
    found = json.loads(succeed(["device", "list", "--net", "--at", quiet.port, "--json"]).stdout)
    mine = [row for row in found if row["port"] == quiet.port]
    assert len(mine) == 1 and mine[0]["channels"] == 100 and not mine[0]["held"] and not mine[0]["enabled"]
    assert f"{quiet.port} 100 channels" in text(succeed(["device", "list", "--net", "--at", quiet.port]).stdout)


def test_the_verilated_board_is_reached_the_same_way(tmp_path):
    with net_board(tmp_path, "--speed", "max", model="rtl") as board:
        assert json.loads(succeed(["device", "info", "--port", board.port, "--json"]).stdout)["channels"] == 100
        succeed(["device", "enable", "--watchdog", "0", "--port", board.port])
        board.until("enabled", True)
        succeed(["device", "disable", "--port", board.port])
        assert not board.enabled


def test_the_python_client_speaks_to_it(tmp_path):
    script = """
import sys
from haptogram.client import Client
with Client.open(sys.argv[1]) as board:
    assert board.identity.channels == 100
    board.set_watchdog(60000)
    board.enable()
    assert board.status().enabled
    board.shut_off()
    assert not board.status().enabled
"""
    with net_board(tmp_path) as board:
        done = subprocess.run([sys.executable, "-c", script, board.port], env={"PYTHONPATH": str(ROOT / "python")}, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@also_in_time
def test_what_a_network_loses_is_soon_asked_for_again(tmp_path, figure, in_time):
    """In time: after the network's patience, 10 ms, and not after that of a serial line, 300."""
    script = """
import sys, time
from haptogram.client import Client
with Client.open(sys.argv[1]) as board:
    began, before = time.monotonic(), board.retransmissions
    for _ in range(400):
        board.status()
    print(time.monotonic() - began, board.retransmissions - before)
"""
    with net_board(tmp_path, "--loss", "0.05") as board:
        done = subprocess.run([sys.executable, "-c", script, board.port], env={"PYTHONPATH": str(ROOT / "python")}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    seconds, again = map(float, done.stdout.split())
    assert again > 10
    if in_time:
        figure("UDP: what is lost is asked for again after", seconds / again, 0.05)


# In real time it is this machine that decides how many patterns are late. In a board's own time none may be: tests/reference/test_live_patterns.cpp
# has this host's loop, tests/modules/test_net_stream.cpp the pins. Here, alone on the machine, some must have come in time.
LATE = 0.3  # of all


@also_in_time
def test_patterns_are_streamed_to_it_live(tmp_path, figure, in_time):
    script = """
import json, sys
from haptogram import Client, HaptogramError, PatternStream
sent, seen = [0], []
def source(period, count):
    sent[0] += count
    return None if sent[0] > 12_000 else bytes([period % 256, 200] * (100 * count))
with Client.open(sys.argv[1]) as board:
    try:
        PatternStream(board, slots=512)
        refused = ""
    except HaptogramError as error:
        refused = str(error)
    stream = PatternStream(board, first=20, slots=256)
    with board.outputs():
        before = board.status()
        status = stream.play(source, lambda now: seen.append(now.streaming and now.mode == "live"))
print(json.dumps({"refused": refused, "sent": sent[0], "streaming": any(seen), "before": before.stream_late, "late": status.stream_late,
                  "early": status.stream_early, "repeated": status.stream_repeated, "refused_records": status.refused_records}))
"""
    with net_board(tmp_path) as board:
        done = subprocess.run([sys.executable, "-c", script, board.port], env={"PYTHONPATH": str(ROOT / "python")}, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert "expected a power of two" in told["refused"]  # more than there are records
    assert told["streaming"]
    assert told["repeated"] == told["refused_records"] == 0
    if in_time:
        figure("UDP: patterns of the Python client that come too early", told["early"] / told["sent"], 0.08, "of all")
        figure("UDP: patterns of the Python client that come too late", (told["late"] - told["before"]) / told["sent"], LATE, "of all")


@also_in_time
def test_a_file_of_patterns_is_streamed(tmp_path, figure, in_time):
    patterns = bytes([phase for k in range(4000) for c in range(100) for phase in (k % 256, 180)])
    (tmp_path / "patterns.bin").write_bytes(b"patterns 100\n" + patterns)
    with net_board(tmp_path) as board:
        said = json.loads(succeed(["stream", "--live", "--json", "--port", board.port, "patterns.bin"], cwd=tmp_path).stdout)
        assert said["sent"] == 4000 and said["repeated"] == 0 and not said["interrupted"]
        if in_time:
            figure("UDP: patterns of a file that come too late", said["late"] / said["sent"], LATE, "of all")
        assert json.loads(succeed(["device", "status", "--json", "--port", board.port]).stdout)["outputs"] == "off"
        for name, bad in (("cut", b"patterns 100\n" + patterns[:450]), ("other", b"patterns 101\n" + patterns), ("headless", patterns), ("empty", b"")):
            (tmp_path / f"{name}.bin").write_bytes(bad)
            assert_one_message(run(["stream", "--live", "--port", board.port, f"{name}.bin"], cwd=tmp_path), BAD_INPUT)
        assert json.loads(succeed(["device", "status", "--json", "--port", board.port]).stdout)["outputs"] == "off"


@also_in_time
def test_foci_are_streamed_a_record_for_each_period(tmp_path, figure, in_time):
    (tmp_path / "foci.txt").write_text("".join(f"{10 * math.cos(k / 20):.3f} {10 * math.sin(k / 20):.3f} 150 1 4\n" for k in range(1000)))
    (tmp_path / "ring.toml").write_text('format = "haptogram-project-1"\nboard = "' + BOARD + '"\nimage = "foci"\n[[shape]]\nkind = "circle"\ndiameter_mm = 20\ncenter_mm = [0, 0, 150]\n')
    with net_board(tmp_path) as board:
        assert_one_message(run(["stream", "--live", "--foci", "--port", board.port, "foci.txt"], cwd=tmp_path), DEVICE)
        succeed(["compile", "ring.toml", "-o", "ring.hex"], cwd=tmp_path)
        succeed(["upload", "ring.hex", "--port", board.port], cwd=tmp_path)
        said = json.loads(succeed(["stream", "--live", "--foci", "--json", "--port", board.port, "foci.txt"], cwd=tmp_path).stdout)
        assert said["sent"] == 4000
        if in_time:
            figure("UDP: foci that come too late", said["late"] / said["sent"], LATE, "of all")


def test_a_dwell_of_patterns_is_refused():
    assert_one_message(run(["stream", "--live", "--dwell", "3", "--port", "udp:127.0.0.1", os.devnull]), USAGE)


def test_a_board_without_streams_says_so(tmp_path):
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100"):
        assert_one_message(run(["stream", "--live", "--port", "port", os.devnull], cwd=tmp_path), DEVICE)


@pytest.mark.parametrize("name", ["udp:", "udp::4807", "udp:127.0.0.1:0", "udp:127.0.0.1:65535", "udp:127.0.0.1:99999", "udp:127.0.0.1:4x", "udp:127.0.0.1#2"])
def test_a_name_that_is_none_is_told(name):
    assert_one_message(run(["device", "info", "--port", name]), USAGE)


@also_in_time
def test_nobody_there_is_told_soon(tmp_path, figure, in_time):
    with net_board(tmp_path) as board:
        pass
    begun = time.monotonic()
    assert_one_message(run(["device", "info", "--port", board.port]), DEVICE)
    if in_time:
        figure("UDP: nobody there is told after", time.monotonic() - begun, 2)


@pytest.mark.parametrize("options", [["--board", "tile-100", "--net"], ["--board", BOARD],
                                              ["--board", BOARD, "--net", "--pty", "p"], ["--loss", "0.1"],
                                              ["--board", BOARD, "--net", "--net-address", "nowhere"]])  # fmt: skip
def test_options_that_contradict_each_other(tmp_path, options):
    assert_one_message(run(["board", "run", "--model", "reference", *options], cwd=tmp_path), USAGE)


def test_a_port_in_use_is_told(tmp_path):
    with net_board(tmp_path) as board:
        said = run(["board", "run", "--model", "reference", "--board", BOARD, "--net", "--net-port", board.address[1]], cwd=tmp_path)
        assert_one_message(said, DEVICE)
