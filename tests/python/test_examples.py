# SPDX-License-Identifier: Apache-2.0
"""The examples do on a virtual board what they say, at whatever rate it reaches, and leave its outputs off."""
import importlib.util
import json
import pathlib
import re
import signal
import subprocess
import sys

import processes
import numpy as np
import pytest
from haptogram import Image
from haptogram.interface import RECORD_HEADER_WORDS
from messages import program_said
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


def test_upload_image(folder):
    with processes.virtual_board(folder):
        said = run(folder, "upload_image.py", "image.hex", "--loops", 2, "--seconds", 5)
        assert re.search(r"uploaded 9 of 9 frames in .* s\nplayed 8 entries: 0 underruns, 0 refused records", said)
        assert "uploaded 0 of 9" in run(folder, "upload_image.py", "image.hex", "--seconds", 0.3)
        assert_silent(folder)


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


def test_follow_point(folder):
    with processes.virtual_board(folder, "--pulses", "pulses.csv") as board:
        updates = int(re.match(r"(\d+) updates, [\d.]+ per second", run(folder, "follow_point.py", "--seconds", 0.3))[1])
        assert_silent(folder)
        indices = played(folder, board)
    assert 2 < len(indices) <= updates
    assert indices == [1 + i % 2 for i in range(len(indices))]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_follow_point_interrupted(number, folder):
    with processes.virtual_board(folder) as board:
        # A shell that started the tests in the background has them ignore SIGINT, and what they start inherits it.
        host = subprocess.Popen([sys.executable, EXAMPLES / "follow_point.py", "--port", "port"], cwd=folder, env=processes.ENVIRONMENT,
                                stderr=subprocess.PIPE, text=True, preexec_fn=lambda: [signal.signal(n, signal.SIG_DFL) for n in (signal.SIGINT, signal.SIGHUP)])  # fmt: skip
        board.until(outputs=True)
        host.send_signal(number)
        assert host.communicate(timeout=300)[1] == "follow_point.py: interrupted; outputs are off\n"
        assert_silent(folder)


def test_follow_point_for_another_array(folder):
    with processes.virtual_board(folder):
        result = processes.run([sys.executable, EXAMPLES / "follow_point.py", "--port", "port", "--rows", 8], folder)
    assert result.returncode == 1
    program_said(result.returncode, result.stderr)


def test_the_focal_law_is_the_compiler_s(tmp_path):
    specification = importlib.util.spec_from_file_location("follow_point", EXAMPLES / "follow_point.py")
    example = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(example)
    processes.haptogram(tmp_path, "compile", "--shape", "point", "--center", "13,-7,120", "-o", "point.hex")
    manifest = json.loads((tmp_path / "point.json").read_text())
    elements = np.array(manifest["array"]["elements_mm"], dtype=float) * 1e-3
    example.SPEED_M_S = manifest["medium"]["speed_m_s"]
    record = Image.load(str(tmp_path / "point.hex")).records[0]
    ours = example.timings(np.array([0.013, -0.007, 0.120]), elements)
    assert (record.cycle_length, record.prescaler, record.pulse_length) == (example.CYCLE, example.PRESCALER, example.PULSE)
    assert RECORD_HEADER_WORDS == 4 and len(ours) == len(record.timings) == 100
    apart = (np.array(ours) - record.timings + 125) % 250 - 125
    assert np.abs(apart).max() <= 1 and pytest.approx(0, abs=0.05) == np.abs(apart).mean()  # the manifest rounds positions
