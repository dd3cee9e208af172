# SPDX-License-Identifier: Apache-2.0
"""What is streamed live beside what is played from memory, and waveforms on either: judged from the pulses at the pins of the simulated core."""
import json
import signal

import numpy as np
import pytest
from messages import program_said
from patience import also_in_time
from support import BAD_INPUT, USAGE, array_for, ask, path_file, run, status, succeed, virtual_board

PERIOD = 1250  # clocks


def at_the_pins(folder, image, command):
    """What a command says, and all pulses: channel, start and end in clocks from the first one's start, index."""
    # The Verilated board waits for a busy machine, mostly: who streams to it may still pause for longer than what it holds.
    with virtual_board(folder, "--image", image, "--pulses", "pulses.csv", "--model", "rtl") as board:
        said = json.loads(ask(folder, *command, "--json").stdout)
        assert status(folder)["modulated"] is ("--path" in command and "--am" in command)  # as after an upload of that path
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=300)
    rows = np.loadtxt(folder / "pulses.csv", delimiter=",", skiprows=1, dtype=np.int64)
    rows[:, 1:3] -= rows[:, 1].min()
    return said, rows[np.lexsort(rows.T)]


def only_in(some, others):
    """The periods and indices of pulses that others do not have, for a message."""
    known = set(map(tuple, others))
    missing = [row for row in map(tuple, some) if row not in known]
    return f"{len(missing)} pulses in periods and indices {sorted({(int(row[1]) // PERIOD, int(row[3])) for row in missing})[:20]}"


def ring(count, radius=20):
    return [(radius * np.cos(2 * np.pi * i / count), radius * np.sin(2 * np.pi * i / count), 120, 1.0) for i in range(count)]


MODULATION = {"periods_a_sample": 16, "samples": [1.0, 0.6, 0.0, 0.3]}


def turns(pulses):
    """The records of channel 0 in their order."""
    own = pulses[pulses[:, 0] == 0]
    own = own[np.argsort(own[:, 1], kind="stable")]
    return own[np.flatnonzero(np.diff(own[:, 3], prepend=0)), 3].tolist()


@also_in_time
@pytest.mark.parametrize(("board", "modulation", "loops"), [("tile-100", None, 2), pytest.param("tile-100", MODULATION, 1, marks=pytest.mark.deep), ("small-16-wide", None, 2)], ids=str)
def test_a_path_makes_the_same_pulses_from_memory_and_live(board, modulation, loops, tmp_path, in_time):
    """To the clock, unless the stream was late, which it may be on a busy machine: dwells of one period and more, silence, a weak focus, two foci at a time, and amplitude modulation."""
    foci = ring(9)
    steps = [([focus], periods) for focus, periods in zip(foci, (20, 13, 1, 1, 30, 14, 13, 14, 25), strict=True)]
    # An entry of another dwell is a frame of its own, 0.15 ms on the line, so the mean dwell must be longer than that.
    steps[4:4] = [([], 15), ([(5, -5, 110, 0.5)], 16), ([foci[0], (-20, 0, 120, 0.7)], 2)]
    path = path_file(tmp_path, steps, modulation)
    options = ["--board", board, "--array", array_for(board, tmp_path) if board != "tile-100" else "tile-10x10"]
    succeed(["compile", "--path", path, *options, "-o", "held.hex"], cwd=tmp_path)
    succeed(["compile", "--shape", "point", *options, "-o", "other.hex"], cwd=tmp_path)
    played, memory = at_the_pins(tmp_path, "held.hex", ["play", "--loops", loops])
    streamed, live = at_the_pins(tmp_path, "other.hex", ["stream", "--path", path, *options, "--loops", loops])
    assert played["underruns"] == 0 and (streamed["underruns"] == 0 or not in_time)
    assert streamed["sent"] == loops * len(entries_of(tmp_path, "held.hex"))
    assert len(memory) > 500 and len(set(memory[:, 3])) > 8
    assert turns(memory) == turns(live)
    assert streamed["underruns"] or np.array_equal(memory, live), f"{len(memory)} and {len(live)} pulses; {only_in(memory, live)} | {only_in(live, memory)}"


def test_a_path_of_more_foci_than_the_board_holds_is_streamed(tmp_path):
    """The records go over the line as they are due; the pins are those of a path that fits, over and over."""
    held = 83_200 // 8
    steps = [([(0.002 * (i % 6000) - 6, 8 * (i // 6000) - 4, 120, 1.0)], 10) for i in range(held + 1600)]
    path = path_file(tmp_path, steps)
    options = ["--board", "tile-100-wide", "--array", "tile-10x10"]
    refused = run(["compile", "--path", path, *options, "-o", "long.hex"], cwd=tmp_path)
    assert refused.returncode == BAD_INPUT
    program_said(refused.returncode, refused.stderr)
    with virtual_board(tmp_path, "--model", "reference", "--board", "tile-100-wide"):
        said = json.loads(ask(tmp_path, "stream", "--path", path, *options, "--json").stdout)
        assert said["sent"] == len(steps)  # whether the line keeps up depends on the machine
        after = status(tmp_path)
        assert after["refused_records"] == 0 and after["far_foci"] == 0


def entries_of(folder, image):
    return json.loads(succeed(["inspect", image, "--json"], cwd=folder).stdout)["sequence"]


@also_in_time
def test_a_stream_is_as_long_as_it_likes(tmp_path, in_time):
    """More entries than the board's sequence memory has; the FIFO takes them one after the other."""
    foci = ring(4)
    order = [(i + i // 9) % 4 for i in range(1100)]
    path_file(tmp_path, [([foci[i]], 4) for i in order])
    result = run(["compile", "--path", "path.json", "-o", "held.hex"], cwd=tmp_path)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
    succeed(["compile", "--shape", "point", "-o", "other.hex"], cwd=tmp_path)
    said, pulses = at_the_pins(tmp_path, "other.hex", ["stream", "--path", "path.json"])
    assert len(order) > 1023 and said["sent"] == len(order) and (said["underruns"] == 0 or not in_time)
    first_seen = list(dict.fromkeys(order))  # records are numbered as they come
    assert turns(pulses) == [1 + first_seen.index(i) for i in order]
    if not said["underruns"]:
        assert round(pulses[pulses[:, 0] == 0][:, 2].max() / PERIOD) == pytest.approx(4 * len(order), abs=1)


def levels(pulses, index, channel=0):
    """The carrier's amplitude in each period from the first pulse on, of full: 0 where there is none."""
    own = pulses[(pulses[:, 0] == channel) & (pulses[:, 3] == index)]
    number = np.rint((own[:, 1] + own[:, 2] - own[:, 1].min() - own[:, 2].min()) / 2 / PERIOD).astype(int)
    found = np.zeros(number.max() + 1)
    found[number] = np.sin(np.pi * (own[:, 2] - own[:, 1]) / PERIOD)
    return found


@also_in_time
def test_on_and_off_between_the_records_of_a_board_that_does_not_modulate(tmp_path, in_time):
    succeed(["compile", "--shape", "point", "-o", "point.hex"], cwd=tmp_path)
    succeed(["compile", "--shape", "point", "--am", "square:500:0.25", "-o", "compiled.hex"], cwd=tmp_path)
    (tmp_path / "lines").write_text("1 300\n1 20\n")
    _, compiled = at_the_pins(tmp_path, "compiled.hex", ["play", "--loops", 4])
    played = ["play", "--am", "square:500:0.25", "--seconds", 0.008]
    for command in (played, [*played, "--index", 1], ["stream", "lines", "--am", "square:500:0.25"]):
        said, gated = at_the_pins(tmp_path, "point.hex", command)
        assert said["underruns"] == 0 or not in_time
        assert said["underruns"] or levels(gated, 1).tolist() == levels(compiled, 1).tolist() and gated[:, 1:3].max() <= 320 * PERIOD
    with virtual_board(tmp_path, "--image", "point.hex"):
        (tmp_path / "hold").write_text("1 0\n")
        for command, code in (
            (["play", "--am", "sine:200"], USAGE),
            (["stream", "lines", "--am", "sine:200"], USAGE),
            (["stream", "hold", "--am", "square:200"], BAD_INPUT),
            (["play", "--am", "tone:200"], USAGE),
            (["play", "--am", "square:200", "--am-law", "loud"], USAGE),
        ):
            result = run([*command, "--port", "port"], cwd=tmp_path)
            assert result.returncode == code
            program_said(result.returncode, result.stderr)
        assert status(tmp_path)["outputs"] == "off"


@pytest.mark.deep
def test_any_waveform_on_a_board_that_modulates(tmp_path):
    options = ["--board", "small-16-wide", "--array", array_for("small-16-wide", tmp_path)]
    succeed(["compile", "--shape", "point", *options, "-o", "point.hex"], cwd=tmp_path)
    succeed(["compile", "--shape", "point", "--records", *options, "-o", "records.hex"], cwd=tmp_path)
    index = entries_of(tmp_path, "point.hex")[0]["index"]
    (tmp_path / "lines").write_text(f"{index} 160\n")
    path_file(tmp_path, [([(0, 0, 100, 1.0)], 160)])
    for command in (["play", "--loops", 1], ["stream", "lines"], ["stream", "--path", "path.json", *options, "--loops", 4]):
        said, pulses = at_the_pins(tmp_path, "point.hex", [*command, "--am", "sine:1000"])
        assert said["underruns"] == 0
        made = levels(pulses, index)[40:120]
        lines = np.abs(np.fft.rfft(made)) / len(made) * 2
        # Samples of two periods take sin(x)/x of a line, here 0.04 dB.
        assert 20 * np.log10(lines[2] / 0.5) == pytest.approx(0, abs=0.1), command
        assert lines[1] < 0.01 * lines[2]
    with virtual_board(tmp_path, "--image", "point.hex"):
        ask(tmp_path, "upload", "records.hex")
        for command in (["play"], ["stream", "lines1"]):
            (tmp_path / "lines1").write_text("1 100\n")
            result = run([*command, "--am", "sine:1000", "--port", "port"], cwd=tmp_path)
            assert result.returncode == BAD_INPUT
            program_said(result.returncode, result.stderr)


def test_a_path_and_indices_exclude_each_other(tmp_path):
    (tmp_path / "lines").write_text("1\n")
    path_file(tmp_path, [([(0, 0, 100, 1.0)], 160)])
    for command in (["lines", "--path", "path.json"], ["--foci", "--path", "path.json"], ["--path", "path.json", "--points", 7],
                            ["lines", "--loops", 2],
                            ["--path", "path.json", "--rate", 100], ["lines", "--array", "hoshi-18x18"]):  # fmt: skip
        result = run(["stream", *command, "--port", "none"], cwd=tmp_path)
        assert result.returncode == USAGE
        program_said(result.returncode, result.stderr)
    result = run(["stream", "--path", "none.json", "--port", "none"], cwd=tmp_path)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
