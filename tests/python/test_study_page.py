# SPDX-License-Identifier: Apache-2.0
"""The runner as a program meets it that shows a page: lines of JSON, their order, what ends a session, and that its results are the terminal's."""
import json
import signal
import subprocess
import time

import processes
import pytest
from messages import program_said
from processes import BAD_INPUT, OK, RUN_FAILED, run
from haptogram_study import protocol
from haptogram_study.design import cells
from test_study_protocols import SMALL
from test_study_runs import records, session, study

KEYS = {"circle": "1", "line": "2"}


class Shown:
    """The runner, with what it shows as it comes."""

    def __init__(self, folder, *more, **names):
        command = session("--observer", "page", *more, **names)
        self.process = subprocess.Popen(command, cwd=folder, env=processes.ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.told = []

    def next(self, *kinds):
        """The next line of one of these kinds; what is told before is kept."""
        while line := self.process.stdout.readline():
            shown = json.loads(line)
            if shown["show"] in kinds:
                return shown
            assert shown["show"] == "tell", shown
            self.told.append(shown["text"])
        raise AssertionError(self.process.communicate()[1])

    def say(self, **message):
        self.process.stdin.write((message.get("line") or json.dumps(message)) + "\n")
        self.process.stdin.flush()

    def answer(self, shown, text=""):
        self.say(do="answer", number=shown["number"], text=text)

    def end(self):
        """Its exit code and what it said; its standard input ends, too."""
        said = self.process.communicate(timeout=300)
        return self.process.returncode, said[1]


@pytest.fixture
def place(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    return tmp_path


@pytest.fixture
def expected(place):
    return [c.factors["shape"] for c in cells(protocol.read(place / "small.toml"), 3, 7)]


def trial(page, key):
    page.answer(page.next("ready"))
    page.answer(page.next("ask"), key)


def test_a_session_by_a_page_is_that_of_the_terminal(place, expected):
    page = Shown(place)
    first = page.next("ready")
    assert page.told == ["A small study", "Trial 1 of 8"]
    assert (first["trial"], first["of"]) == (1, 8) and expected[0] in first["presented"]
    page.answer(first)
    asked = page.next("ask")
    assert asked == {"show": "ask", "number": 2, "trial": 1, "of": 8, "text": "Which?", "kind": "choice", "keys": [["1", "circle"], ["2", "line"]],
                     "whole": False, "limit_s": None, "from": None, "to": None}  # fmt: skip
    page.answer(first, "2")  # of what is over: answers nothing
    page.answer(asked, "3")
    assert page.next("wrong") == {"show": "wrong", "number": 2, "text": "type 1 for circle, 2 for line"}
    page.answer(asked, KEYS[expected[0]])
    trial(page, KEYS[expected[1]])
    page.next("ready")
    page.say(do="stop")
    code, said = page.end()
    assert code == RUN_FAILED and "stopped after 2 more answers" in said and "no stimulus is played" in said
    again = Shown(place)
    for shape in expected[2:]:
        trial(again, KEYS[shape])
    code, said = again.end()
    assert code == OK and "goes on after 2 records" in said and "complete, 6 new answers" in said and "A small study" not in again.told
    typed = "".join(f"\n{KEYS[shape]}\n" for shape in expected)
    whole = place / "out.jsonl"
    by_page = records(whole)
    whole.rename(place / "page.jsonl")
    assert run(session(), place, stdin=None, input=typed).returncode == OK
    for ours, theirs in zip(by_page, records(whole), strict=True):
        assert list(ours) == list(theirs)
        assert ours.pop("observer") == "page" and theirs.pop("observer") == "keyboard"
        for record in (ours, theirs):
            assert record["answers"]["answer"].pop("seconds") >= 0
        assert ours == theirs
    # A session is of one observer.
    whole.unlink()
    (place / "page.jsonl").rename(whole)
    result = run(session(), place)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)


def test_whatever_ends_it_the_session_goes_on(place, expected):
    def closed(page):
        page.process.stdin.close()
        page.process.stdin = None

    ends = [closed, lambda page: page.process.send_signal(signal.SIGTERM), lambda page: page.process.send_signal(signal.SIGINT), lambda page: page.say(do="stop")]
    for done, end in enumerate(ends, 1):
        page = Shown(place)
        trial(page, KEYS[expected[done - 1]])
        page.answer(page.next("ready"))
        page.next("ask")
        end(page)
        code, said = page.end()
        assert code == RUN_FAILED and "stopped after 1 more answers" in said and "Traceback" not in said
        assert len(records(place / "out.jsonl")) == done and (place / "out.jsonl").read_bytes().endswith(b"\n")


@pytest.mark.parametrize("line", ["", "{", "[]", "5", '{"do": "fly"}', '{"do": "stop", "now": true}', '{"do": "answer", "number": "1", "text": ""}',
                                  '{"do": "answer", "number": 1}', '{"do": "answer", "number": 1, "text": 5}', "[" * 50_000])  # fmt: skip
def test_lines_that_make_no_sense_end_it(place, line):
    page = Shown(place)
    page.next("ready")
    page.say(line=line or " ")
    code, said = page.end()
    assert code == BAD_INPUT and "expected an answer or stop" in said and "Traceback" not in said
    assert records(place / "out.jsonl") == []


def test_time_runs_out_and_rests(place):
    (place / "small.toml").write_text(SMALL.replace('correct = "{shape}"', 'correct = "{shape}"\nlimit_s = 0.2').replace("sets = 2", "sets = 1")
                                      + "\n[rest]\nafter_trial_s = 0.3\n")  # fmt: skip
    page = Shown(place)
    for _ in range(4):
        ready = page.next("ready")
        begun = time.monotonic()
        page.answer(ready)
        assert page.next("ask")["limit_s"] == 0.2
        page.next("late")
        assert page.next("rest")["seconds"] == 0.3
    assert page.process.stdout.read() == "" and page.end()[0] == OK and time.monotonic() - begun >= 0.5
    assert all(r["answers"]["answer"]["cancelled"] for r in records(place / "out.jsonl"))


def test_every_kind_of_question(place):
    questions = """
[[question]]
name = "felt"
text = "Felt?"
kind = "yes-no"

[[question]]
name = "sure"
text = "How sure?"
kind = "scale"
from = 1
to = 7

[[question]]
name = "size"
text = "How large?"
kind = "number"
from = 0

[[question]]
name = "words"
text = "In words?"
kind = "text"
when = "end"
each = "shape"
"""
    head = SMALL.split("[[question]]")[0]
    (place / "small.toml").write_text(head.replace("sets = 2", "sets = 1") + questions)
    page = Shown(place)
    for _ in range(4):
        page.answer(page.next("ready"))
        for kind, answer in (("yes-no", "y"), ("scale", "4"), ("number", "12.5")):
            asked = page.next("ask")
            assert asked["kind"] == kind
            assert (asked["from"], asked["to"], asked["whole"]) == {"yes-no": (None, None, False), "scale": (1, 7, True), "number": (0, None, False)}[kind]
            assert bool(asked["keys"]) == (kind == "yes-no")
            page.answer(asked, answer)
    for shape in ("circle", "line"):
        asked = page.next("ask")
        assert page.told[-1] == f"shape: {shape}" and asked["kind"] == "text" and asked["trial"] == 5
        page.answer(asked, "soft – and \n warm")
    assert page.end()[0] == OK
    made = records(place / "out.jsonl")
    assert {name: a["value"] for name, a in made[0]["answers"].items()} == {"felt": True, "sure": 4, "size": 12.5}
    assert made[-1]["answers"]["words"]["value"] == "soft – and \n warm"


def test_protocols_of_a_folder(place):
    (place / "bad.toml").write_text('format = "haptogram-protocol-1"\n')
    (place / "project.toml").write_text('format = "haptogram-project-1"\n')
    (place / "folder.toml").mkdir()
    result = run(study("list", "--json", "--folder", "."), place)
    assert result.returncode == OK
    listed = json.loads(result.stdout)
    assert set(listed) == {*protocol.shipped(), "small.toml", "bad.toml"}
    assert listed["small.toml"] == {"title": "A small study", "source": "this test", "trials": 8, "participants": 2, "playable": True}
    assert "missing" in listed["bad.toml"]["error"] and not listed["fingers_surface"]["playable"]
    result = run(study("list", "--folder", "."), place)
    assert result.returncode == OK and "A small study" in result.stdout and "bad.toml" in result.stderr


def test_a_board_is_off_when_a_session_is_ended(place):
    few = SMALL.replace('compile = ["--rate", "10"]', 'compile = ["--rate", "500", "--points", "4", "--shape", "circle", "--loops", "0"]')
    (place / "small.toml").write_text("\n".join(line for line in few.splitlines() if not line.startswith("path =")))
    with processes.virtual_board(place):
        page = Shown(place, "--port", "port", "--program", processes.PROGRAM)
        page.answer(page.next("ready"))
        page.next("ask")
        page.process.send_signal(signal.SIGTERM)
        code, said = page.end()
        assert code == RUN_FAILED and "stopped after 0 more answers" in said
        assert "outputs          off" in processes.ask(place, "device", "status")
