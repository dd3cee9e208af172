# SPDX-License-Identifier: Apache-2.0
"""Every shipped protocol from its first trial to its analysis, on virtual boards of each kind; and what is said, before the first trial, of a
protocol that a board cannot play."""
import contextlib
import json
import os

import processes
import pytest
from messages import loose_numbers, program_said
from patience import Board
from processes import BAD_INPUT, DEVICE, OK, PROGRAM, run, virtual_board
from haptogram_study import analysis, observers, protocol, results
from haptogram_study.session import Session
from haptogram_study.stimulus import Presenter
from test_study_runs import records, study

SHIPPED = {name: protocol.read(path) for name, path in protocol.shipped().items()}
WITHOUT_A_BOARD = [name for name, p in SHIPPED.items() if not p.stimulus.compile and not p.stimulus.live]
HX8K, WIDE, NET, SLOW = "ice40-hx8k-breakout", "colorlight-5a-75e-v7.1-wide", "colorlight-5a-75e-v7.1-net", "colorlight-5a-75e-v7.1"
HOSHI, FOCI = "hoshi-324", "tile-100-wide"  # configurations of the core that are no board's: with Hoshi's channels, and with foci on a fast line
LISTED = json.loads(processes.haptogram(".", "board", "list", "--json")) if PROGRAM.is_file() else []
BOARDS = [one["board"] for one in LISTED]
ARRAYS = {one["board"]: one["array"] for one in LISTED} | {HOSHI: "hoshi-18x18", FOCI: "tile-10x10"}
HOSHIS = ("hoshi_direction", "hoshi_movements", "hoshi_positioning")  # of 324 elements, for which no shipped board has the pins
LIVE = [name for name, p in SHIPPED.items() if p.stimulus.live]
COMPILED = [name for name, p in SHIPPED.items() if p.stimulus.compile]

# What a board cannot play although its array has been named: its exit code, and what of it stands in the message.
TOO_MUCH = {(HX8K, name): (BAD_INPUT, "more records than the board's 64") for name in ("hoshi_movements", "hoshi_positioning")}
SLOW_LINE = (DEVICE, "too slow to follow a hand")  # records of amplitudes or timings over 115200 baud
TOO_MUCH |= {(board, name): SLOW_LINE for board in ("colorlight-5a-75e-v6.0", SLOW) for name in LIVE}
FITTED = {(HX8K, "haptogram_shapes"): {"points": 64}, (HX8K, "hoshi_direction"): {"step_mm": 1}}

# All on a board of records, and of the other kinds what they play in another way: foci over a serial line, amplitudes over Ethernet, records over
# a slow line.
IN_TEST = [(HX8K, name) for name in COMPILED] + [(FOCI, name) for name in LIVE] + [(NET, "hoshi_positioning"), (SLOW, "fingers_surface")]
ALL = [(board, name) for board in BOARDS for name in (*COMPILED, *LIVE)] + [(HOSHI, name) for name in HOSHIS] + [(FOCI, name) for name in LIVE]
# Whether a board without foci follows a hand depends on how fast it takes records, which on a busy machine is slow.
MARKS = {name: pytest.mark.real_time for name in LIVE}
MATRIX = [pytest.param(*one, marks=[] if one in IN_TEST else MARKS.get(one[1], pytest.mark.deep)) for one in ALL]


@contextlib.contextmanager
def boards_of(place, name, count):
    """Ports of so many virtual boards."""
    with contextlib.ExitStack() as stack:
        if not name.endswith(("-net", "-sdram")):
            for n in range(count):
                stack.enter_context(virtual_board(place, "--model", "reference", "--board", name, port=f"port{n}"))
            yield [f"port{n}" for n in range(count)]
        else:
            ports = []
            for _ in range(count):
                board = Board([PROGRAM, "board", "run", "--json", "--model", "reference", "--board", name, "--net", "--net-port", "0"], place)
                stack.callback(board.end)
                ports.append(board.says["port"])
            yield ports


def others(p, like, people):
    """More simulated people, whose stimuli were made for the same board."""
    found = []
    for participant in range(2, people + 1):
        Session(p, participant, 7, observers.simulated(p, "simulated:protocol"), Presenter(p), found.append).run()
    for record in found:
        record.pop("made_for", None)
    return [record | ({"made_for": like["made_for"]} if "made_for" in like else {}) for record in found]


def assert_analysed(place, p, people=3):
    """The results of the first participant, who was played to, with others'."""
    played = results.read(place / "1.jsonl")
    found = analysis.study(p, played + [("2.jsonl", record) for record in others(p, played[0][1], people)]).as_json()
    assert [one["name"] for one in found["analyses"]] == [one.name for one in p.analyses] and found["observers"] == {"simulated:protocol": people}


def asked(name, ports, *more):
    p = SHIPPED[name]
    shown = [word for port in ports for word in ("--port", port)] + [word for _ in p.stimulus.live for word in ("--from", "synthetic:press")][: 2 * len(ports)]
    return study("run", name, "--participant", 1, "--seed", 7, "-o", "1.jsonl", "--observer", "simulated:protocol", *shown, *more)


@pytest.mark.parametrize(("board", "name"), MATRIX)
def test_a_protocol_from_its_first_trial_to_its_analysis(tmp_path, board, name):
    p = SHIPPED[name]
    array = ["--array", ARRAYS[board]] if name in HOSHIS or board not in BOARDS else []
    with boards_of(tmp_path, board, max(1, len(p.stimulus.live))) as ports:
        for _ in range(10):
            said = run(asked(name, ports, "--board", board, *array), tmp_path)
            if "its watchdog heard nothing" not in said.stderr:  # this machine had no time for so long; the session goes on where it was
                break
        for port in ports:
            assert json.loads(processes.haptogram(tmp_path, "device", "status", "--port", port, "--json"))["outputs"] == "off"
    if (board, name) in TOO_MUCH:
        code, needle = TOO_MUCH[board, name]
        assert said.returncode == code and needle in said.stderr and f"{name}: cannot be played on {board}" in said.stderr, said.stderr
        assert (tmp_path / "1.jsonl").read_bytes() == b"", "it was said before the first trial"
        if code == DEVICE:
            loose_numbers()  # how long records take
        program_said(code, said.stderr)
        return
    assert said.returncode == OK, said.stderr
    trials = [record for record in records(tmp_path / "1.jsonl") if record["kind"] == "trial"]
    silent = {"none"} if name == "fingers_lift_visible" else set()
    assert all(r["stimulus"]["played"] == (r["factors"].get("feedback") not in silent) for r in trials)
    assert max(r["trial"] for r in trials) == p.trials and all(len(r["stimulus"].get("image_sha256", 64 * "x")) == 64 for r in trials)
    of = {"board": board} | ({"array": ARRAYS[board]} if array or name in LIVE else {})
    fitted = FITTED.get((board, name), p.fits()[0])
    assert all(r["made_for"] == of | ({"fitted": fitted} if fitted else {}) for r in records(tmp_path / "1.jsonl"))
    assert_analysed(tmp_path, p)


@pytest.mark.parametrize("name", WITHOUT_A_BOARD)
def test_a_protocol_of_another_apparatus(tmp_path, name):
    assert run(asked(name, []), tmp_path).returncode == OK
    assert_analysed(tmp_path, SHIPPED[name])


def test_what_a_board_cannot_play_is_said_before_the_first_trial(tmp_path):
    """Without --array or --board, too; and results of one board are not gone on with for another."""
    with virtual_board(tmp_path, "--model", "reference", "--board", HX8K):
        for name, more in (("hoshi_direction", ["--board", HX8K]), ("haptogram_shapes", []), ("haptogram_shapes", ["--board", WIDE])):
            said = run(asked(name, ["port"], *more), tmp_path)
            assert said.returncode == BAD_INPUT and f"{name}: cannot be played" in said.stderr, said.stderr
            assert (tmp_path / "1.jsonl").read_bytes() == b""
            program_said(BAD_INPUT, said.stderr)
    for words in (["--images", "made", "--board", HX8K], ["--images", "made", "--board", WIDE], ["--board", HX8K], ["--array", "tile-10x10"]):
        said = run(asked("haptogram_shapes", [], *words), tmp_path)
        assert said.returncode == (OK if words == ["--images", "made", "--board", HX8K] else BAD_INPUT), said.stderr
        if said.returncode:
            program_said(BAD_INPUT, said.stderr)


def test_which_protocols_a_board_plays(tmp_path):
    said = run(study("check", "--board", HX8K), tmp_path)
    lines = {line.split(":")[0]: line for line in said.stdout.splitlines()}
    assert said.returncode == BAD_INPUT and lines.keys() == SHIPPED.keys() - set(HOSHIS), said.stderr
    assert lines["haptogram_shapes"].endswith(f"fit {HX8K}, with points = 64") and all(f"{name}: cannot be played on {HX8K}" in said.stderr for name in HOSHIS)


def test_a_program_that_is_none(tmp_path):
    (tmp_path / "program").write_bytes(b"\x7fELF")
    (tmp_path / "program").chmod(0o755)
    said = run(asked("haptogram_shapes", [], "--images", "made", "--program", tmp_path / "program"), tmp_path)
    assert said.returncode == BAD_INPUT and said.stderr.startswith(f"haptogram-study: haptogram_shapes: cannot be played: {tmp_path / 'program'}: cannot be started"), said.stderr
    program_said(BAD_INPUT, said.stderr)


def test_stimuli_of_different_boards_do_not_mix(tmp_path):
    p = SHIPPED["haptogram_shapes"]
    for number, board in ((2, HX8K), (3, WIDE)):
        found = others(p, {"made_for": {"board": board, "fitted": {"points": 64}}}, 3)
        (tmp_path / f"{number}.jsonl").write_text("".join(json.dumps(r | {"observer": "keyboard"}) + "\n" for r in found if r["participant"] == number))
    said = run(study("analyse", "haptogram_shapes", "2.jsonl", "3.jsonl"), tmp_path)
    assert said.returncode == BAD_INPUT and f"people (board {HX8K}, points 64)" in said.stderr, said.stderr
    program_said(BAD_INPUT, said.stderr)
    said = run(study("analyse", "haptogram_shapes", "2.jsonl", "3.jsonl", "--mixed"), tmp_path)
    assert said.returncode == OK and said.stdout.startswith(f"MIXED: answers of 1 person (board {HX8K}, points 64), 1 person (board {WIDE}"), said.stdout
