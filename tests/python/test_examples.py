# SPDX-License-Identifier: Apache-2.0
"""The example does on a virtual board what it says, at whatever rate it reaches, and leaves its outputs off."""
import json
import re
import signal
import subprocess
import sys

import processes
import pytest
from patience import also_in_time

EXAMPLES = processes.ROOT / "python/examples"


def run(folder, name, *args):
    result = processes.run([sys.executable, EXAMPLES / name, *args, "--port", "port"], folder)
    assert result.returncode == 0, result.stderr
    return result.stdout


def assert_silent(folder):
    status = json.loads(processes.ask(folder, "device", "status", "--json"))
    assert (status["outputs"], status["index"], status["refused_records"], status["watchdog_trips"]) == ("off", 0, 0, 0)


def played(folder, board):
    """Indices in the order in which channel 0 played them, without repeats."""
    board.send_signal(signal.SIGINT)
    board.communicate(timeout=300)
    rows = sorted([int(n) for n in line.split(",")] for line in (folder / "pulses.csv").read_text().splitlines()[1:])
    indices = [row[3] for row in rows if row[0] == 0 and row[3] > 0]
    return [a for a, b in zip(indices, [*indices[1:], None], strict=True) if a != b]


@also_in_time
def test_stream_circle(folder, figure, in_time):
    with processes.virtual_board(folder, "--pulses", "pulses.csv") as board:
        said = run(folder, "stream_circle.py", "image.hex", "--seconds", 0.3, "--rate", 100)
        sent, underruns = map(int, re.match(r"(\d+) indices, .* per second, (\d+) underruns", said).groups())
        if in_time:
            figure("underruns of the streamed circle", underruns, 0, "")
        assert_silent(folder)
        indices = played(folder, board)
    assert 8 < len(indices) <= sent
    assert indices == [1 + i % 8 for i in range(len(indices))]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_stream_circle_interrupted(number, folder):
    with processes.virtual_board(folder) as board:
        # A shell that started the tests in the background has them ignore SIGINT, and what they start inherits it.
        host = subprocess.Popen([sys.executable, EXAMPLES / "stream_circle.py", "image.hex", "--port", "port"], cwd=folder, env=processes.ENVIRONMENT,
                                stderr=subprocess.PIPE, text=True, preexec_fn=lambda: [signal.signal(n, signal.SIG_DFL) for n in (signal.SIGINT, signal.SIGHUP)])  # fmt: skip
        board.until(outputs=True)
        host.send_signal(number)
        assert host.communicate(timeout=300)[1] == "stream_circle.py: interrupted; outputs are off\n"
        assert_silent(folder)
