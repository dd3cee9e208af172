# SPDX-License-Identifier: Apache-2.0
"""Nobody reads what a command tells while its outputs are on: the command goes on, ends at Ctrl-C, and leaves them off."""
import contextlib
import fcntl
import json
import os
import signal
import subprocess

import pytest
from patience import PATIENCE_S, until
from support import PROGRAM, succeed, text, virtual_board

LIVE = ["live", "--from", "synthetic:press", "--object", "sphere", "--size", "80", "--center", "0,40,160", "--port", "reference:tile-100-wide"]
DESIGN = """format = "haptogram-project-1"
board = "ulx3s-85f"
points = 4
rate_hz = 20
[[shape]]
kind = "circle"
[[trigger]]
on = "key:a"
"""


@contextlib.contextmanager
def unread(*args, folder, **more):
    """A command whose output goes into two pipes of a page each, which nobody reads: each takes one message. @return it, and the ends that could be read"""
    ends = []
    try:
        for _ in range(2):
            ours, theirs = os.pipe()
            fcntl.fcntl(theirs, fcntl.F_SETPIPE_SZ, 4096)
            ends += [ours, theirs]
        process = subprocess.Popen([PROGRAM, *map(str, args)], cwd=folder, stdout=ends[1], stderr=ends[3], **more)
        for end in (ends.pop(3), ends.pop(1)):
            os.close(end)
        yield process, ends
    finally:
        process.kill()
        process.wait()
        for end in ends:
            os.close(end)


def waiting(end):
    """Bytes that wait to be read there."""
    return int.from_bytes(fcntl.ioctl(end, 0x541B, bytes(4)), "little")  # FIONREAD


def test_a_session_whose_scene_nobody_reads_ends_in_time(tmp_path):
    with unread(*LIVE, "--seconds", 1, "--scene", "-", folder=tmp_path) as (process, _):
        assert process.wait(PATIENCE_S) == 0


def test_a_session_whose_scene_nobody_reads_ends_at_ctrl_c(tmp_path):
    with unread(*LIVE, "--seconds", 10000, "--scene", "-", folder=tmp_path) as (process, ends):
        until(lambda: waiting(ends[0]) > 0, "lines")
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE_S) in (0, 1)


@pytest.mark.parametrize("last", ["end", "ctrl-c"])
def test_triggers_whose_warnings_nobody_reads(tmp_path, last):
    (tmp_path / "design.toml").write_text(DESIGN)
    succeed(["compile", "design.toml", "-o", "design.hex"], cwd=tmp_path)
    with virtual_board(tmp_path, "--model", "reference", "--board", "ulx3s-85f"):
        succeed(["upload", "design.hex", "--port", "port"], cwd=tmp_path)
        with unread("play", "--triggers", "design.toml", "--watchdog", 60000, "--port", "port", folder=tmp_path, stdin=subprocess.PIPE) as (process, ends):
            with contextlib.suppress(BrokenPipeError):
                process.stdin.write(b"nothing of that\n" * 1000 + b"a\n")
                process.stdin.flush()
            until(lambda: waiting(ends[1]) > 0, "a pipe without room")
            if last == "end":
                process.stdin.close()
            else:
                process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) in (0, 1)
        told = json.loads(text(succeed(["device", "status", "--json", "--port", "port"], cwd=tmp_path).stdout))
        assert told["outputs"] == "off"
