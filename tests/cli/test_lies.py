# SPDX-License-Identifier: Apache-2.0
"""What the command line does when a board or its line lies, beyond what tests/torture asks of every command: what it says, and how soon
it ends. The board that lies is the one from there."""
import base64
import fcntl
import json
import os
import re
import signal
import socket
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest
from support import DEVICE, PROGRAM, assert_one_message, run, text

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "torture"))
from lying_board import DISABLE, ENABLE, IDENTIFY, LIES, STOP, Lie, LyingBoard, loses  # noqa: E402

PLAY = ["play", "--index", "1"]
STREAM = ["stream"]


def start(board, *args, **more):
    more.setdefault("stdin", subprocess.DEVNULL)
    return subprocess.Popen([str(PROGRAM), *args, "--port", board.port], stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def heard(board):
    return [frame.command for frame in board.frames]


def fall_silent(board):
    board.lie.answers = lambda frame, answer: []


def is_on(board):
    return board.instrument.enabled


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
        wait_for(lambda: is_on(board))
        fall_silent(board)
        message = end_of(host, 25)
        assert host.returncode == DEVICE
        assert "does not confirm" in message
        assert ("400 ms" if watchdog else "switch its power off") in message
        assert not is_on(board) and DISABLE in heard(board) and STOP in heard(board)


def test_disable_acts_without_a_session_and_fails_when_it_is_not_confirmed():
    for lie, confirmed in ((loses(IDENTIFY), True), (LIES["silent"](), False)):
        with LyingBoard(lie) as board:
            board.instrument.enabled, board.instrument.watchdog_ms = True, 0
            result = run(["device", "disable", "--port", board.port])
            assert not is_on(board)
            if confirmed:
                assert result.returncode == 0 and IDENTIFY not in heard(board)
            else:
                assert_one_message(result, DEVICE, "does not confirm", "power")


@pytest.mark.parametrize("command", [PLAY, STREAM])
@pytest.mark.parametrize("signals", [1, 2])
def test_a_signal_to_a_silent_board_ends_it_in_two_seconds(command, signals):
    with LyingBoard() as board:
        host = start(board, *command, stdin=subprocess.PIPE)
        wait_for(lambda: is_on(board))
        fall_silent(board)
        time.sleep(0.2)
        host.send_signal(signal.SIGINT)
        if signals == 2:
            time.sleep(0.1)
            host.send_signal(signal.SIGINT)
        message = end_of(host, 3.0 if signals == 1 else 1.0)  # 2 s and half a second, and what a busy machine adds
        assert host.returncode == DEVICE and "does not confirm" in message
        assert not is_on(board)
        host.stdin.close()


def test_an_upload_waits_no_longer_than_it_is_told(image, tmp_path):
    with LyingBoard(Lie(answers=lambda frame, answer: [answer.packed()] if frame.command == IDENTIFY else [])) as board:
        begun = time.monotonic()
        assert_one_message(run(["upload", image, "--wait", "1", "--port", board.port], cwd=tmp_path, timeout=60), DEVICE, "did not come back")
        assert time.monotonic() - begun < 15


def test_a_name_reaches_the_terminal_in_letters():
    with LyingBoard(Lie(identity={"name": b"\x1b[2J\x07evil"})) as board:
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
    with LyingBoard(Lie(answers=lambda frame, answer: [], babble=babble)) as board:
        host = subprocess.Popen([str(PROGRAM), "studio", "--no-browser", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        page = Page(json.loads(host.stdout.readline())["address"])
        for n in (1, 3):
            page.send({"t": "connect", "n": n, "port": board.port, "scene": ""})
            page.wait_for(b'"connecting"')
            wait_for(lambda: IDENTIFY in heard(board))
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
        wait_for(lambda: is_on(board))
        os.close(ours)
        host.wait(5)
        assert not is_on(board) and heard(board).index(ENABLE) < len(heard(board)) - 1 - heard(board)[::-1].index(DISABLE)
