# SPDX-License-Identifier: Apache-2.0
"""What the program does when a board or its line lies: it ends, says why, and leaves no outputs on."""
import base64
import fcntl
import json
import os
import re
import signal
import socket
import subprocess
import termios
import time

import lying_board
import pytest
from lying_board import DISABLE, ENABLE, IDENTIFY, READ, STATUS, STOP, LyingBoard
from support import DEVICE, PROGRAM, assert_one_message, run, text

PLAY = ["play", "--index", "1"]
STREAM = ["stream"]


def start(board, *args, **more):
    more.setdefault("stdin", subprocess.DEVNULL)
    return subprocess.Popen([str(PROGRAM), *args, "--port", board.port], stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def wait_for(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.005)


def end_of(host, seconds):
    begun = time.monotonic()
    host.wait(30)
    took = time.monotonic() - begun
    message = text(host.stderr.read())
    host.stdout.close()
    host.stderr.close()
    assert took < seconds, f"it took {took:.1f} s: {message}"
    return message


@pytest.mark.parametrize("watchdog", [0, 400])
def test_play_that_gets_no_answers_sends_disable_and_says_that_nobody_confirmed_it(watchdog):
    with LyingBoard() as board:
        host = start(board, *PLAY, "--watchdog", str(watchdog))
        wait_for(lambda: board.enabled)
        board.answers = lambda command, count: False
        message = end_of(host, 25)
        assert host.returncode == DEVICE
        assert "does not confirm" in message
        assert ("400 ms" if watchdog else "switch its power off") in message
        assert not board.enabled and DISABLE in board.heard and STOP in board.heard


def test_disable_acts_without_a_session_and_fails_when_it_is_not_confirmed():
    with LyingBoard(answers=lambda command, count: command != IDENTIFY) as board:
        board.enabled = True
        assert run(["device", "disable", "--port", board.port]).returncode == 0
        assert not board.enabled and IDENTIFY not in board.heard
    with LyingBoard(answers=lambda command, count: False) as board:
        board.enabled = True
        assert_one_message(run(["device", "disable", "--port", board.port]), DEVICE, "does not confirm", "power")
        assert not board.enabled


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_a_signal_before_the_outputs_are_on_leaves_them_off(number):
    with LyingBoard(late=0.4) as board:
        host = start(board, *PLAY)
        wait_for(lambda: IDENTIFY in board.heard)
        host.send_signal(number)
        end_of(host, 2.5)
        assert ENABLE not in board.heard and not board.enabled
        assert host.returncode > 0


@pytest.mark.parametrize("command", [PLAY, STREAM])
@pytest.mark.parametrize("signals", [1, 2])
def test_a_signal_to_a_silent_board_ends_it_in_two_seconds(command, signals):
    with LyingBoard() as board:
        host = start(board, *command, stdin=subprocess.PIPE)
        wait_for(lambda: board.enabled)
        board.answers = lambda command, count: False
        time.sleep(0.2)
        host.send_signal(signal.SIGINT)
        if signals == 2:
            time.sleep(0.1)
            host.send_signal(signal.SIGINT)
        message = end_of(host, 2.0 if signals == 1 else 0.6)
        assert host.returncode == DEVICE and "does not confirm" in message
        assert not board.enabled
        host.stdin.close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
def test_a_signal_while_it_plays_ends_it_in_good_order(number):
    with LyingBoard() as board:
        host = start(board, *PLAY)
        wait_for(lambda: board.enabled)
        host.send_signal(number)
        assert end_of(host, 2) == ""
        assert host.returncode == 0 and not board.enabled


@pytest.mark.parametrize("command", [["device", "info"], ["device", "disable"], PLAY, ["upload", "image.hex"], ["download", "-o", "x.hex"]])
def test_a_port_that_talks_is_no_board(command, image, tmp_path):
    (tmp_path / "image.hex").write_bytes((tmp_path / image).read_bytes())
    with LyingBoard(answers=lambda command, count: False, babble=b"$GPGGA,123519,4807.038,N\r\n") as board:
        result = run([*command, "--port", board.port], cwd=tmp_path, timeout=20)
        assert_one_message(result, DEVICE)
    with LyingBoard(answers=lambda command, count: False, babble=b"$GPGGA,123519,4807.038,N\r\n") as board:
        host = start(board, *PLAY)
        wait_for(lambda: IDENTIFY in board.heard)
        host.send_signal(signal.SIGINT)
        end_of(host, 2)


def test_an_answer_that_is_always_lost_ends_an_upload_without_a_flood(image, tmp_path):
    with LyingBoard(answers=lambda command, count: command != lying_board.DIGEST or count % 16 != 1) as board:
        result = run(["upload", image, "--wait", "1", "--port", board.port], cwd=tmp_path, timeout=40)
        assert result.returncode == DEVICE
        assert len(board.heard) < 2000


def test_an_upload_waits_no_longer_than_it_is_told(image, tmp_path):
    with LyingBoard(answers=lambda command, count: command == IDENTIFY) as board:
        begun = time.monotonic()
        assert_one_message(run(["upload", image, "--wait", "1", "--port", board.port], cwd=tmp_path, timeout=60), DEVICE, "did not come back")
        assert time.monotonic() - begun < 15


@pytest.mark.parametrize("depth", [0, 1, 2, 3, 65535])
def test_an_identity_out_of_range_names_its_field(depth):
    for key, field in (("live_depth", "LIVE_DEPTH"), ("channels", "CHANNELS"), ("sequence_depth", "SEQUENCE_DEPTH")):
        if key == "sequence_depth" and depth in (2, 3) or key == "channels" and depth in (2, 3):
            continue
        with LyingBoard(**{key: depth}) as board:
            for command in (PLAY, STREAM, ["device", "info"]):
                assert_one_message(run([*command, "--port", board.port]), DEVICE, field, "expected")


@pytest.mark.parametrize("cut", [lambda data: data[:1], lambda data: data + bytes(700)], ids=["short", "long"])
@pytest.mark.parametrize(("command", "of"), [(PLAY, STATUS), (["play"], READ), (["play"], STATUS), (STREAM, STATUS), (["download", "-o", "x.hex"], READ),
                                             (["upload", "image.hex"], lying_board.DIGEST)])  # fmt: skip
def test_an_answer_of_another_length_is_an_error(command, of, cut, image, tmp_path):
    (tmp_path / "image.hex").write_bytes((tmp_path / image).read_bytes())
    with LyingBoard(lie=lambda asked, data: cut(data) if asked == of else data) as board:
        assert_one_message(run([*command, "--port", board.port], cwd=tmp_path, timeout=20), DEVICE, "bytes of data, expected")
        assert not board.enabled


def test_a_name_reaches_the_terminal_in_letters():
    with LyingBoard(name=b"\x1b[2J\x07evil") as board:
        assert_one_message(run(["device", "info", "--port", board.port]), DEVICE, "evil")


def test_a_file_may_stand_behind_the_port(image, tmp_path):
    result = run(["upload", "--port", "/dev/null", image], cwd=tmp_path)
    assert_one_message(result, DEVICE, "/dev/null")


class Page:
    """Just enough of a browser's page: messages to the studio's socket, and what it answers."""

    def __init__(self, address):
        host, token = re.match(r"http://([^/]+)/#(.+)", address).groups()
        name, port = host.split(":")
        self.socket = socket.create_connection((name, int(port)), timeout=10)
        self.socket.sendall((f"GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {base64.b64encode(bytes(16)).decode()}\r\n"
                             f"Sec-WebSocket-Protocol: haptogram.1, token.{token}\r\n\r\n").encode())  # fmt: skip
        said = b""
        while b"\r\n\r\n" not in said:
            said += self.socket.recv(1)
        assert b" 101 " in said.splitlines()[0], said

    def send(self, message):
        data = json.dumps(message).encode()
        self.socket.sendall(bytes([0x81, 0x80 | len(data)]) + bytes(4) + data)

    def hear(self):
        head = self.exactly(2)
        length = head[1] if head[1] < 126 else int.from_bytes(self.exactly(2 if head[1] == 126 else 8), "big")
        return self.exactly(length)

    def exactly(self, count):
        data = b""
        while len(data) < count:
            data += self.socket.recv(count - len(data))
        return data

    def wait_for(self, needle):
        begun = time.monotonic()
        while needle not in self.hear():
            assert time.monotonic() - begun < 10, f"{needle} was not told"
        return time.monotonic() - begun


@pytest.mark.parametrize("babble", [b"", b"$GPGGA,123519\r\n"])
def test_the_studio_lets_go_of_a_port_that_talks_or_is_silent(babble):
    with LyingBoard(answers=lambda command, count: False, babble=babble) as board:
        host = subprocess.Popen([str(PROGRAM), "studio", "--no-browser", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        page = Page(json.loads(host.stdout.readline())["address"])
        for n in (1, 3):
            page.send({"t": "connect", "n": n, "port": board.port, "scene": ""})
            page.wait_for(b'"connecting"')
            wait_for(lambda: IDENTIFY in board.heard)
            page.send({"t": "disconnect", "n": n + 1})
            assert page.wait_for(b'"none"') < 0.5  # the server waits for no board
        page.send({"t": "connect", "n": 5, "port": board.port, "scene": ""})
        page.wait_for(b'"connecting"')
        host.send_signal(signal.SIGTERM)
        end_of(host, 4)
        assert host.returncode == 0


def test_a_closed_terminal_leaves_nothing_on():
    with LyingBoard() as board:
        ours, theirs = os.openpty()
        host = subprocess.Popen([str(PROGRAM), *PLAY, "--port", board.port], stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
                                preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))  # fmt: skip
        os.close(theirs)
        wait_for(lambda: board.enabled)
        os.close(ours)
        host.wait(5)
        assert not board.enabled and DISABLE in board.heard
