# SPDX-License-Identifier: Apache-2.0
"""What the tests share: virtual boards, and both programs as processes."""
import contextlib
import os
import re
import subprocess
import sys
from pathlib import Path

from messages import program_said
from patience import PATIENCE_S, Board

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = [str(ROOT / "python"), str(ROOT / "extras/studies")]
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(PACKAGES), "PYTHONDONTWRITEBYTECODE": "1", "PYTHONUNBUFFERED": ""}  # as in a shell
RATE_NOTE = r"haptogram(-py)?: \S+: it answers at \d+ baud, which is remembered\n"  # once, of the first command at a port
OK, RUN_FAILED, USAGE, BAD_INPUT, DEVICE = range(5)


def run(command, folder, **more):
    more = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL, "timeout": PATIENCE_S, **more}
    return subprocess.run([str(word) for word in command], cwd=folder, env=ENVIRONMENT, text=True, check=False, **more)


def haptogram(folder, *args):
    """The C++ program, which must succeed; its standard output."""
    result = run([PROGRAM, *args], folder)
    assert result.returncode == OK, result.stderr
    return result.stdout


def python_command(*args):
    return [sys.executable, "-m", "haptogram.cli", *map(str, args)]


def ask(folder, *args, **more):
    """haptogram-py at the port of `folder`, which must succeed; its standard output. Where nothing is said of a watchdog, it lets a busy machine pause."""
    if args[0] in ("play", "stream") and "--watchdog" not in args:
        args = (*args, "--watchdog", 60000)
    result = run(python_command(*args, "--port", "port"), folder, **more)
    assert result.returncode == OK, result.stderr
    return result.stdout


def assert_refused(result, code):
    """The exit code, nothing on stdout, and one message."""
    assert (result.returncode, result.stdout) == (code, ""), result.stderr
    lines = re.sub(r"\A" + RATE_NOTE, "", result.stderr).splitlines()
    assert len(lines) == 1 and lines[0].startswith("haptogram-py: "), result.stderr
    program_said(code, lines[0])


@contextlib.contextmanager
def virtual_board(folder, *options, port="port"):
    """A running board; its port is `folder`/`port`. HAPTOGRAM_MODEL=rtl makes it a Verilated one where no model is named, as in tests/cli."""
    model = os.environ.get("HAPTOGRAM_MODEL", "reference")
    as_asked = [] if "--model" in options else ["--model", model, "--speed", "max" if model == "rtl" else "real"]
    command = [str(PROGRAM), "board", "run", "--json", "--pty", port, *as_asked, *map(str, options)]
    board = Board(command, folder)
    try:
        yield board
    finally:
        board.end()
        (folder / port).unlink(missing_ok=True)
