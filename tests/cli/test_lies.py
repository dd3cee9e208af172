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
from patience import also_in_time, until
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


def end_of(host):
    """What it says in the end, and after how many seconds."""
    begun = time.monotonic()
    host.wait(300)
    took = time.monotonic() - begun
    message = text(host.stderr.read())
    host.stdout.close()
    host.stderr.close()
    return message, took


@also_in_time
@pytest.mark.parametrize("watchdog", [0, 1500])
def test_play_that_gets_no_answers_sends_disable_and_says_that_nobody_confirmed_it(watchdog, figure, in_time):
    with LyingBoard() as board:
        host = start(board, *PLAY, "--watchdog", str(watchdog))
        until(lambda: is_on(board))
        fall_silent(board)
        message, took = end_of(host)
        if in_time:
            figure(f"play before a board that falls silent ends after (watchdog {watchdog} ms)", took, 12)
        assert host.returncode == DEVICE
        assert "does not confirm" in message
        assert ("1500 ms" if watchdog else "switch its power off") in message
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
                assert_one_message(result, DEVICE)


@also_in_time
@pytest.mark.parametrize("command", [PLAY, STREAM], ids=" ".join)
@pytest.mark.parametrize("signals", [1, 2])
def test_a_signal_to_a_silent_board_ends_it_in_two_seconds(command, signals, figure, in_time):
    with LyingBoard() as board:
        host = start(board, *command, "--watchdog", "60000", stdin=subprocess.PIPE)
        until(lambda: is_on(board))
        fall_silent(board)
        time.sleep(0.2)
        host.send_signal(signal.SIGINT)
        if signals == 2:
            time.sleep(0.1)
            host.send_signal(signal.SIGINT)
        message, took = end_of(host)
        if in_time:
            figure(f"{command[0]} before a silent board ends after {signals} SIGINT", took, 2.2 if signals == 1 else 0.5)
        assert host.returncode == DEVICE and "does not confirm" in message
        until(lambda: not is_on(board))  # by a break, which may be on its way when the program has ended
        host.stdin.close()


@also_in_time
def test_an_upload_waits_no_longer_than_it_is_told(image, tmp_path, figure, in_time):
    with LyingBoard(Lie(answers=lambda frame, answer: [answer.packed()] if frame.command == IDENTIFY else [])) as board:
        begun = time.monotonic()
        assert_one_message(run(["upload", image, "--wait", "1", "--port", board.port], cwd=tmp_path, timeout=300), DEVICE)
        if in_time:
            figure("upload --wait 1 to a board that answers nothing more ends after", time.monotonic() - begun, 11)


def test_a_name_reaches_the_terminal_in_letters():
    with LyingBoard(Lie(identity={"name": b"\x1b[2J\x07evil"})) as board:
        assert_one_message(run(["device", "info", "--port", board.port]), DEVICE)


def test_a_file_may_stand_behind_the_port(image, tmp_path):
    result = run(["upload", "--port", "/dev/null", image], cwd=tmp_path)
    assert_one_message(result, DEVICE)


class Page:
    """Just enough of a browser's page: messages to the studio's socket, and what it answers."""

    def __init__(self, address):
        host, token = re.match(r"http://([^/]+)/#(.+)", address).groups()
        name, port = host.split(":")
        self.socket = socket.create_connection((name, int(port)), timeout=300)
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
        """After how many seconds it is told."""
        begun = time.monotonic()
        while needle not in self.hear():
            pass
        return time.monotonic() - begun


@also_in_time
@pytest.mark.parametrize("babble", [b"", b"$GPGGA,123519\r\n"])
def test_the_studio_lets_go_of_a_port_that_talks_or_is_silent(babble, figure, in_time):
    with LyingBoard(Lie(answers=lambda frame, answer: [], babble=babble)) as board:
        host = subprocess.Popen([str(PROGRAM), "studio", "--no-browser", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        page = Page(json.loads(host.stdout.readline())["address"])
        for n in (1, 3):
            page.send({"t": "connect", "n": n, "port": board.port, "scene": ""})
            page.wait_for(b'"connecting"')
            until(lambda: IDENTIFY in heard(board))
            page.send({"t": "disconnect", "n": n + 1})
            took = page.wait_for(b'"none"')
            if in_time:
                figure("the studio tells that it let go of a port", took, 0.2)  # the server waits for no board
        page.send({"t": "connect", "n": 5, "port": board.port, "scene": ""})
        page.wait_for(b'"connecting"')
        host.send_signal(signal.SIGTERM)
        took = end_of(host)[1]
        assert host.returncode == 0
        if in_time:
            figure("the studio ends while it asks for a board", took, 2)


def test_a_closed_terminal_leaves_nothing_on():
    with LyingBoard() as board:
        ours, theirs = os.openpty()
        host = subprocess.Popen([str(PROGRAM), *PLAY, "--port", board.port], stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
                                preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))  # fmt: skip
        os.close(theirs)
        until(lambda: is_on(board))
        os.close(ours)
        host.wait(300)
        assert not is_on(board) and heard(board).index(ENABLE) < len(heard(board)) - 1 - heard(board)[::-1].index(DISABLE)
