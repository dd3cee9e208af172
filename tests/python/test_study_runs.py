# SPDX-License-Identifier: Apache-2.0
"""The runner as an experimenter meets it: sessions that are killed and go on, files of results, analyses, power."""
import contextlib
import datetime
import io
import itertools
import json
import math
import os
import random
import signal
import subprocess
import sys
import time
import types
from dataclasses import replace
from pathlib import Path

import processes
import matplotlib
import numpy as np
import pytest
import scipy.ndimage
from messages import program_said, refusal
from patience import also_in_time, until
from processes import BAD_INPUT, DEVICE, OK, RUN_FAILED, USAGE, haptogram, run, virtual_board
from haptogram import HaptogramError
from haptogram_study import analysis, cli, figures, observers, protocol, results, touching
from haptogram_study.asking import Occasion
from haptogram_study.design import cells
from haptogram_study.session import Session
from haptogram_study.stimulus import Presenter
from test_study_protocols import SMALL

STAIRS = SMALL.split("[[question]]")[0].replace('"{shape} at', '"{shape} at {level.db} dB,') + """
[[question]]
name = "felt"
text = "Felt?"
kind = "yes-no"

[staircase]
question = "felt"
first_step_db = 3
step_db = 1
first_reversals = 3
reversals = 8
starts_db = { high = 0, low = -40 }
lowest_db = -60
highest_db = 0

[[analysis]]
name = "thresholds"
test = "thresholds"
of = "threshold_db"
by = "shape"

[[analysis]]
name = "functions"
test = "psychometric"
of = "felt"
by = "shape"

[simulated.felt]
model = "psychometric"
by = "shape"
threshold_db = { circle = -20, line = -15 }
sd_db = 0.5
lapse = 0
"""


def study(*args):
    return [sys.executable, "-m", "haptogram_study", *map(str, args)]


def session(*more, name="small.toml", participant=3):
    return study("run", name, "--participant", participant, "--seed", 7, "-o", "out.jsonl", *more)


def records(path):
    """Without when they were made."""
    found = [json.loads(line) for line in path.read_text().splitlines()]
    return [{key: value for key, value in record.items() if key != "at"} for record in found]


def assert_says(result, code, *needles):
    """Of an error its place, of what went well what `needles` name."""
    assert result.returncode == code, result.stderr
    assert "Traceback" not in result.stderr
    for needle in needles:
        assert needle in result.stderr, result.stderr
    if code != OK:
        program_said(code, result.stderr)


@pytest.fixture
def place(tmp_path):
    (tmp_path / "small.toml").write_text(SMALL)
    (tmp_path / "stairs.toml").write_text(STAIRS)
    return tmp_path


def simulate(p, participants=None, observer="simulated:protocol", seed=1):
    found = []
    for participant in range(1, (participants or p.participants) + 1):
        Session(p, participant, seed, observers.simulated(p, observer), Presenter(p), lambda record: found.append(("here", record))).run()
    return found


def test_a_session_that_was_killed_goes_on(place):
    expected = [c.factors["shape"] for c in cells(protocol.read(place / "small.toml"), 3, 7)]
    keys = {"circle": "1", "line": "2"}
    host = subprocess.Popen(session(), cwd=place, env=processes.ENVIRONMENT, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
    host.stdin.write("".join(f"\n{keys[shape]}\n" for shape in expected[:3]).encode())
    host.stdin.flush()
    until(lambda: (place / "out.jsonl").exists() and (place / "out.jsonl").read_bytes().count(b"\n") >= 3 or host.poll() is not None, "three records")
    assert host.poll() is None
    host.kill()
    host.communicate()
    before = (place / "out.jsonl").read_bytes()
    # A kill within a write leaves half a line.
    (place / "out.jsonl").write_bytes(before + b'{"format": "haptogram-tri')
    typed = "".join(f"\nwrong\n{keys[shape]}\n" for shape in expected[3:])
    result = run(session(), place, stdin=None, input=typed)
    assert_says(result, OK, "out.jsonl.unfinished-1", "goes on after 3 records", "complete, 5 new answers", "type 1 for circle, 2 for line", "no stimulus is played")
    assert (place / "out.jsonl").read_bytes().startswith(before) and (place / "out.jsonl.unfinished-1").read_bytes() == b'{"format": "haptogram-tri'
    made = records(place / "out.jsonl")
    assert [r["trial"] for r in made] == list(range(1, 9)) and [r["factors"]["shape"] for r in made] == expected
    assert all(r["answers"]["answer"]["correct"] and r["seed"] == 7 and r["versions"]["python"] and len(r["stimulus"]["sha256"]) == 64 for r in made)
    assert not any(r["stimulus"]["played"] for r in made) and len({r["stimulus"]["sha256"] for r in made}) == 4
    whole = (place / "out.jsonl").read_bytes()
    assert_says(run(session(), place), OK, "complete, 0 new answers")
    assert (place / "out.jsonl").read_bytes() == whole


@pytest.mark.parametrize("name", ["small.toml", "stairs.toml"])
def test_wherever_it_is_cut_it_ends_the_same(place, name):
    p = protocol.read(place / name)
    whole = [record for _, record in simulate(p, 1)]
    for cut in {0, 1, len(whole) // 3, len(whole) // 2, len(whole) - 1, len(whole)}:
        kept = json.loads(json.dumps(whole[:cut]))
        more = []
        Session(p, 1, 1, observers.simulated(p, "simulated:protocol"), Presenter(p), more.append, before=[("file:1", r) for r in kept]).run()
        assert [r | {"at": 0} for r in kept + more] == [r | {"at": 0} for r in whole], cut


def test_stopping(place):
    result = run(session(), place, stdin=None, input="\n1\nq\n")
    assert_says(result, RUN_FAILED)
    host = subprocess.Popen(session(), cwd=place, env=processes.ENVIRONMENT, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while "Trial 2" not in host.stderr.readline():
        assert host.poll() is None
    host.send_signal(signal.SIGINT)
    assert "stopped after 0 more answers" in host.communicate(timeout=300)[1] and host.returncode == RUN_FAILED
    assert len(records(place / "out.jsonl")) == 1


def test_time_runs_out(place):
    (place / "small.toml").write_text(SMALL.replace('correct = "{shape}"', 'correct = "{shape}"\nlimit_s = 0.2').replace("sets = 2", "sets = 1"))
    host = subprocess.Popen(session(), cwd=place, env=processes.ENVIRONMENT, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = ""
    for _ in range(4):
        host.stdin.write("\n")
        host.stdin.flush()
        while "time is up" not in (line := host.stderr.readline()):
            assert host.poll() is None, said
            said += line
    assert host.wait(timeout=300) == OK
    host.communicate()
    assert all(r["answers"]["answer"]["value"] is None and r["answers"]["answer"]["cancelled"] for r in records(place / "out.jsonl"))


def test_files_of_other_sessions_are_left_alone(place):
    assert run(session("--observer", "simulated:protocol"), place).returncode == OK
    whole = (place / "out.jsonl").read_bytes()
    assert_says(run(session("--observer", "simulated:protocol", participant=4), place), BAD_INPUT)
    assert_says(run(session("--observer", "simulated:chance"), place), BAD_INPUT)
    (place / "small.toml").write_text(SMALL + "# changed\n")
    assert_says(run(session("--observer", "simulated:protocol"), place), BAD_INPUT)
    assert (place / "out.jsonl").read_bytes() == whole


def test_hostile_results(place):
    p = protocol.read(place / "small.toml")
    good = [json.dumps(record) for _, record in simulate(p, 1)]
    path = place / "out.jsonl"

    def refused(text):
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        before = path.read_bytes()
        with refusal(HaptogramError), results.ResultsFile(path) as file:
            Session(p, 1, 1, observers.simulated(p, "simulated:protocol"), Presenter(p), file.append, before=file.before).run()
        assert path.read_bytes() == before

    refused("hello\n")
    refused(b"\xff\xfe\n")
    refused("[" * 100_000 + "\n")
    refused('{"format": NaN}\n')
    refused("3\n")
    refused(good[0].replace("haptogram-trial-1", "haptogram-trial-2") + "\n")
    refused("x" * 1_100_000 + "\n")
    refused(good[1] + "\n")
    refused("\n".join([good[0], good[0], ""]))
    refused("\n".join([*good, good[-1], ""]))
    refused(good[0].replace('"answers"', '"answered"') + "\n")
    refused(good[0].replace('"factors": {"shape": "', '"factors": {"shape": "un') + "\n")
    broken = [good[0].replace(old, new) for old, new in (('"value"', '"worth"'), ('"value": "', '"value": "un'), ('"correct": ', '"correct": 1, "x": '), ('"seconds": ', '"seconds": "x", "x": '),
              ('"circle"', '"star"'), ('"line"', '"star"'), ('"answer":', '"reply":'))]  # fmt: skip
    for bad in (json.dumps({"format": "haptogram-trial-1", "protocol": p.name, "protocol_sha256": p.sha256}), *(b for b in broken if b != good[0] and json.loads(b))):
        with refusal(HaptogramError):
            analysis.frame(p, results.parse(bad.encode() + b"\n", "x"))
    with refusal(HaptogramError):
        analysis.frame(p, results.parse("\n".join([good[0], good[0], ""]).encode(), "x"))
    with refusal(HaptogramError):
        path.write_text(good[0])
        results.read(path)
    with refusal(HaptogramError), results.ResultsFile(type(path)("/dev/full")):
        pass
    with refusal(HaptogramError), results.ResultsFile(place):
        pass
    path.unlink()
    with results.ResultsFile(path), refusal(HaptogramError), results.ResultsFile(path):
        pass


def test_analyses_find_what_was_simulated(place):
    people = 12
    assert run(session("--observer", "simulated:protocol"), place).returncode == OK
    said = run(study("analyse", "small.toml", "out.jsonl", "--json"), place)
    assert said.returncode == OK, said.stderr
    right = sum(r["answers"]["answer"]["correct"] for r in records(place / "out.jsonl"))
    assert json.loads(said.stdout)["analyses"][0]["numbers"]["successes"] == right
    p = protocol.read(place / "stairs.toml")
    found, functions = (one.numbers for one in analysis.analyse(p, analysis.frame(p, simulate(p, people))))
    for shape, threshold in (("circle", -20.0), ("line", -15.0)):
        assert functions[shape]["threshold_db"] == pytest.approx(threshold, abs=0.3) and functions[shape]["spread_db"] == pytest.approx(0.5, abs=0.25)
    assert found["lost"] == 0 and found["mean_db"] == pytest.approx({"circle": -20, "line": -15}, abs=0.3)
    votes = protocol.read(protocol.shipped()["shapes_comparison"])
    given = simulate(votes, 5)
    answers = [record["answers"] for _, record in given if record["kind"] == "trial"]
    for_h = sum(a["similar_confidence"]["value"] * a["similar"]["correct"] for a in answers) / sum(a["similar_confidence"]["value"] for a in answers)
    assert analysis.analyse(votes, analysis.frame(votes, given))[0].numbers["weighted"] == pytest.approx(for_h, rel=1e-12)
    direction = protocol.read(protocol.shipped()["hoshi_direction"])
    assert analysis.analyse(direction, analysis.frame(direction, simulate(direction)))[0].numbers["successes"] == 240
    placing = protocol.read(protocol.shipped()["multimodal_placing"])
    tests = analysis.analyse(placing, analysis.frame(placing, simulate(placing)))
    assert [t.numbers["statistic"][""]["df"] for t in tests[:3]] == [[2.0, 24.0], [2.0, 16.0], [2.0, 24.0]]
    magnitude = protocol.read(protocol.shipped()["multimodal_magnitude"])
    fits = analysis.analyse(magnitude, analysis.frame(magnitude, simulate(magnitude)))[0].numbers
    for hz, (g, j, v) in magnitude.simulated["magnitude"]["polynomials"].items():
        made = fits[hz]["coefficients"]
        for gf in (0.13, 0.31, 0.43):  # up to the factor that normalises free scales
            assert made[0] * gf**2 + made[1] * gf + made[2] == pytest.approx(g * gf**2 + j * gf + v, rel=0.5)
        assert fits[hz]["r2"] > 0.8


def as_people(given, played=True, observer="keyboard"):
    """Records as they would be if people had answered."""
    return [record | {"observer": observer} | ({"stimulus": record["stimulus"] | {"played": played}} if "stimulus" in record else {}) for record in given]


def session_of(p, participant, observer="simulated:protocol"):
    found = []
    Session(p, participant, 7, observers.simulated(p, observer), Presenter(p), found.append).run()
    return found


def write(path, given):
    path.write_text("".join(json.dumps(record) + "\n" for record in given))


def here(place, *args):
    """The exit code, standard output and standard error of haptogram-study, of which a process of its own would load the statistics each time."""
    out, said = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        patch.chdir(place)
        patch.setattr(sys, "argv", ["haptogram-study", *map(str, args)])
        code = int(cli.main())
    return code, out.getvalue(), said.getvalue()


def analysed(place, *args, code=OK, name="small.toml"):
    """The text and the JSON of an analysis, or what was said when it was refused."""
    text, made = (here(place, "analyse", name, *args, *more) for more in ((), ("--json",)))
    assert (text[0], made[0]) == (code, code), text[2]
    return text[2] if code else (text[1].splitlines(), json.loads(made[1]))


def test_a_simulated_study_says_so_first(place):
    p = protocol.read(place / "small.toml")
    for number in (1, 2):
        write(place / f"s{number}.jsonl", session_of(p, number))
        write(place / f"p{number}.jsonl", as_people(session_of(p, number), observer=("keyboard", "page")[number - 1]))
    lines, made = analysed(place, "s1.jsonl", "s2.jsonl")
    assert lines[0].startswith("SIMULATED: answers of 2 × simulated:protocol") and "no result" in lines[0] and "rate (binomial)" in lines[1]
    assert made["simulated"] is True and made["mixed"] is False and made["observers"] == {"simulated:protocol": 2} and made["labels"] == lines[:1]
    assert made["protocol_sha256"] == p.sha256 and [one["name"] for one in made["analyses"]] == ["rate"]
    # Keyboard and page are both people.
    lines, made = analysed(place, "p1.jsonl", "p2.jsonl")
    assert lines[:2] == ["answers of 2 people", "rate (binomial)"] and made["simulated"] is False and made["observers"] == {"keyboard": 1, "page": 1}
    said = here(place, "power", "small.toml", "--runs", 2, "--observer", "simulated:chance")[1]
    assert said.startswith("SIMULATED: 2 studies with 2 × simulated:chance")
    assert json.loads(here(place, "power", "small.toml", "--runs", 2, "--json")[1])["simulated"] is True


def test_people_and_simulated_observers_do_not_mix(place):
    p = protocol.read(place / "small.toml")
    write(place / "real.jsonl", as_people(session_of(p, 1)))
    write(place / "made.jsonl", session_of(p, 2))
    write(place / "guess.jsonl", session_of(p, 3, "simulated:chance"))
    said = analysed(place, "real.jsonl", "made.jsonl", code=BAD_INPUT)
    assert said.count("\n") == 1
    for needle in ("real.jsonl of people", "made.jsonl of simulated:protocol", "analyse them apart", "--mixed"):
        assert needle in said, said
    # Two kinds of simulated observers are a mixture, too.
    assert "guess.jsonl of simulated:chance" in analysed(place, "made.jsonl", "guess.jsonl", code=BAD_INPUT)
    lines, made = analysed(place, "--mixed", "real.jsonl", "made.jsonl", "guess.jsonl")
    assert lines[0] == "MIXED: answers of 1 person, 1 × simulated:protocol, 1 × simulated:chance; no result of a study"
    assert made["mixed"] is True and made["simulated"] is True and made["labels"] == lines[:1] and made["analyses"][0]["numbers"]["trials"] == 24
    # What was asked for and does not happen is not said.
    lines, made = analysed(place, "--mixed", "--unfinished", "real.jsonl")
    assert lines[0] == "answers of 1 person" and made["mixed"] is False and made["unfinished"] == []
    # A number is a person's, even in a mixture.
    write(place / "again.jsonl", session_of(p, 1))
    assert "2 sessions of participant 1" in analysed(place, "--mixed", "real.jsonl", "again.jsonl", code=BAD_INPUT)
    half = session_of(p, 1)
    write(place / "spliced.jsonl", half[:4] + [record | {"seed": 8} for record in half[4:]])
    assert "2 sessions of participant 1" in analysed(place, "spliced.jsonl", code=BAD_INPUT)


def test_unfinished_sessions_are_left_out(place):
    p = protocol.read(place / "small.toml")
    write(place / "whole.jsonl", as_people(session_of(p, 1)))
    write(place / "part.jsonl", as_people(session_of(p, 2))[:5])
    said = analysed(place, "whole.jsonl", "part.jsonl", code=BAD_INPUT)
    assert said.count("\n") == 1 and "whole" not in said
    for needle in ("part.jsonl: participant 2 has 5 of 8 trials", "'run'", "leave them out", "--unfinished"):
        assert needle in said, said
    lines, made = analysed(place, "--unfinished", "whole.jsonl", "part.jsonl")
    assert lines[:3] == ["answers of 2 people", "UNFINISHED: part.jsonl: participant 2 has 5 of 8 trials", "rate (binomial)"]
    assert made["labels"] == lines[:2] and made["analyses"][0]["numbers"]["trials"] == 13
    assert made["unfinished"] == [{"files": ["part.jsonl"], "participant": 2, "trials": 5, "of_trials": 8, "answers_at_end": 0, "of_answers_at_end": 0}]
    # Both labels, where both are true.
    write(place / "made.jsonl", session_of(p, 2)[:5])
    lines, _ = analysed(place, "--unfinished", "--mixed", "whole.jsonl", "made.jsonl")
    assert lines[0].startswith("MIXED") and lines[1].startswith("UNFINISHED")


@pytest.mark.parametrize("name", ["stairs.toml", "multimodal_placing"])
def test_thresholds_and_questions_at_the_end_finish_a_session(place, name):
    p = protocol.read(protocol.find(name) if name in protocol.shipped() else place / name)
    if p.staircase:
        (place / name).write_text((place / name).read_text().replace("sets = 2", "sets = 1"))
        p = protocol.read(place / name)
    whole = session_of(p, 1)
    analysis.origin.of(p, [("a:1", record) for record in whole]).refuse()
    with refusal(HaptogramError):
        analysis.study(p, [("a:1", record) for record in whole[:-1]])


def test_stimuli_that_were_not_played_are_said(place):
    p = protocol.read(place / "small.toml")
    write(place / "silent.jsonl", as_people(session_of(p, 1), played=False))
    write(place / "played.jsonl", as_people(session_of(p, 2)))
    lines, made = analysed(place, "silent.jsonl")
    assert lines[1] == "NOT PLAYED: nothing was played in 8 of 8 trials of people (silent.jsonl: participant 1); answers without a stimulus are no result"
    assert made["not_played"] == {"trials": 8, "of": 8} and made["labels"] == lines[:2]
    lines, made = analysed(place, "silent.jsonl", "played.jsonl")
    assert "nothing was played in 8 of 16 trials" in lines[1] and made["not_played"] == {"trials": 8, "of": 16}
    lines, made = analysed(place, "played.jsonl")
    assert lines[1] == "rate (binomial)" and made["not_played"] == {"trials": 0, "of": 8}
    surface = protocol.read(protocol.shipped()["fingers_surface"])
    given = [("a:1", record) for number in (1, 2) for record in as_people(session_of(surface, number), played=False)]
    assert "another apparatus" in analysis.study(surface, given).report().splitlines()[1]


def test_records_that_do_not_say_where_they_are_from(place):
    p = protocol.read(place / "small.toml")
    for change in ({"observer": None}, {"observer": "robot"}, {"observer": 3}, {"trial": 9}, {"trial": "x"}, {"kind": "guess"}, {"stimulus": {}}, {"stimulus": {"played": 1}},
                   {"participant": 1e400}, {"kind": "question", "question": "other"}):  # fmt: skip
        given = session_of(p, 1)
        given[2] |= change
        with refusal(HaptogramError):
            analysis.study(p, [(f"here:{number}", record) for number, record in enumerate(given, 1)])
    with refusal(HaptogramError):
        analysis.study(p, [])


def test_how_large_effects_are(place):
    """Each test of a mean or of ranks says how large its effect is, as a line and as numbers."""
    expected = {"multimodal_placing": {"anova": {"eta squared"}, "rm-anova": {"partial eta squared"}}, "fingers_surface": {"paired-t": {"difference", "Cohen's d_z"}},
                "fingers_lift_visible": {"friedman": {"Kendall's W"}, "wilcoxon": {"rank-biserial correlation"}, "rm-anova": {"partial eta squared"}},
                "haptogram_shapes": {"binomial": {"Cohen's h"}}}  # fmt: skip
    for name, tests in expected.items():
        p = protocol.read(protocol.shipped()[name])
        made = analysis.study(p, simulate(p))
        text, seen = made.report(), set()
        json.dumps(made.as_json(), allow_nan=False)
        for one in made.found:
            seen.add(one.test)
            found = {effect: numbers for effects in one.numbers.get("effect", {}).values() for effect, numbers in effects.items()}
            assert tests.get(one.test, set()) <= set(found), (name, one.name)
            for effect, numbers in found.items():
                assert f"{effect} = {numbers['value']:.3g}" in text
                if "level" in numbers:
                    assert numbers["low"] <= numbers["value"] <= numbers["high"] or effect.endswith("eta squared")
                    assert f"{100 * numbers['level']:.0f} % interval {numbers['low']:.3g} to {numbers['high']:.3g}" in text
            if one.test == "anova":
                for pair, effects in one.numbers["effect"].items():
                    if pair:
                        a, b = pair.split(" − ")
                        assert effects["difference"]["value"] == pytest.approx(one.numbers["mean"][a] - one.numbers["mean"][b])
                        assert (one.p[f"{a}, {b}"] < 0.05) == (effects["difference"]["low"] * effects["difference"]["high"] > 0)
        assert set(tests) <= seen


@pytest.mark.parametrize("base", [0.0, 0.7])  # from 0.7 on, the differences scatter by rounding
def test_differences_without_scatter_have_no_effect_size(place, base):
    p = protocol.read(protocol.shipped()["fingers_surface"])
    given = simulate(p, 3)
    for _, record in given:
        if record["kind"] == "trial":
            record["answers"]["angle"]["error"] = base * record["participant"] + (0.1 if record["factors"]["method"] == "static" else 0.3)
    with refusal(HaptogramError):
        analysis.study(p, given)


def test_sets_are_a_factor(place):
    """Who learns: each person's share of right answers and mean time in the first set and in the second, by another route."""
    p = protocol.read(protocol.shipped()["haptogram_shapes"])
    given, dice = simulate(p), random.Random(2)
    for _, record in given:
        answer = record["answers"]["answer"]
        if record["set"] == 2 and dice.random() < 0.4:
            answer |= {"value": record["factors"]["shape"], "correct": True, "seconds": 0.5 * answer["seconds"]}
    found = {one.name: one for one in analysis.study(p, given).found}
    for name, key in (("right answers from session to session", "correct"), ("recognition time from session to session", "seconds")):
        counts = [(r["participant"], r["set"], r["answers"]["answer"][key]) for _, r in given if key == "correct" or r["answers"]["answer"]["correct"]]
        people = [[np.mean([value for who, number, value in counts if (who, number) == (person, one)]) for one in (1, 2)] for person in range(1, 16)]
        changes = np.array([first - second for first, second in people])
        t = changes.mean() / (changes.std(ddof=1) / math.sqrt(15))
        numbers = found[name].numbers
        assert numbers["statistic"][""] == {"name": "t", "value": pytest.approx(t), "df": [14.0]} and found[name].p[""] < 0.05
        assert numbers["mean"] == pytest.approx({"set 1": np.mean(people, 0)[0], "set 2": np.mean(people, 0)[1]})
        assert numbers["effect"]["set 1 − set 2"]["difference"]["value"] == pytest.approx(changes.mean())
        assert found[name].paper.endswith("no test")
    times = [r["answers"]["answer"]["seconds"] for _, r in given if r["answers"]["answer"]["correct"]]
    assert found["recognition time, of correct answers"].numbers == pytest.approx({"mean": np.mean(times), "sd": np.std(times, ddof=1), "n": len(times)})
    assert len(times) < len(given) and "time of all answers" in found
    # Two and more sets, thresholds, and one set alone.
    text = SMALL.replace("sets = 2", "sets = 3").replace("[simulated.answer]", "".join(
        f'[[analysis]]\nname = "{test}"\ntest = "{test}"\nof = "answer.correct"\nby = "set"\n' for test in ("rm-anova", "anova", "friedman", "wilcoxon")) + """
[[analysis]]
name = "second"
test = "binomial"
of = "answer.correct"
where = { set = 2 }

[simulated.answer]""")  # fmt: skip
    (place / "small.toml").write_text(text)
    small = protocol.read(place / "small.toml")
    given = simulate(small, 8, "simulated:chance")
    made = {one.name: one for one in analysis.study(small, given).found}
    assert made["second"].numbers["trials"] == 8 * 4
    assert made["second"].numbers["successes"] == sum(r["answers"]["answer"]["correct"] for _, r in given if r["set"] == 2)
    assert set(made["wilcoxon"].p) == {"set 1, set 2", "set 1, set 3", "set 2, set 3"} and list(made["rm-anova"].numbers["mean"]) == ["set 1", "set 2", "set 3"]
    (place / "stairs.toml").write_text(STAIRS.replace('kind = "yes-no"', 'kind = "yes-no"\nlimit_s = 2'))
    with refusal(HaptogramError):
        protocol.read(place / "stairs.toml")
    (place / "stairs.toml").write_text(STAIRS.replace('by = "shape"', 'by = "set"', 2))
    stairs = protocol.read(place / "stairs.toml")
    thresholds, functions = analysis.study(stairs, simulate(stairs, 6)).found
    assert list(thresholds.numbers["mean_db"]) == ["set 1", "set 2"] and list(functions.numbers) == ["set 1", "set 2"]
    broken = simulate(small, 1)
    broken[3][1]["set"] = 4
    with refusal(HaptogramError):
        analysis.study(small, broken)


def test_power(place):
    p = protocol.read(place / "small.toml")
    strong = analysis.power(p, "simulated:protocol", 6, 20, 1, 0.05)
    # 90 % right in 48 trials against one half: practically always found.
    assert strong["rate"][0] == 1.0
    guessing = analysis.power(p, "simulated:chance", 6, 60, 1, 0.05)["rate"]
    assert guessing[0] <= 0.05 + 4 * (0.05 * 0.95 / 60) ** 0.5 and guessing[1] <= guessing[0] <= guessing[2]
    with refusal(HaptogramError):
        analysis.power(protocol.read(place / "stairs.toml"), "simulated:protocol", 2, 1, 1, 0.05)


def test_observers_of_a_file(place):
    (place / "people.toml").write_text('[answer]\nmodel = "preference"\nweights = { circle = 1, line = 0 }\nseconds = [2, 0]\n')
    assert_says(run(session("--observer", "simulated:people.toml"), place), OK, "complete")
    assert {r["answers"]["answer"]["value"] for r in records(place / "out.jsonl")} == {"circle"}
    (place / "people.toml").write_text('[answer]\nmodel = "preference"\nweights = { circle = 1 }\n')
    assert_says(run(session("--observer", "simulated:people.toml"), place), BAD_INPUT)
    assert_says(run(session("--observer", "oracle"), place), USAGE)


def test_a_hand_that_touches_answers_what_the_task_found(place):
    p = protocol.read(protocol.find("fingers_surface"))
    hand, trial = touching.Hand(p, str(processes.PROGRAM)), cells(p, 1, 7)[0]
    angle, height = p.questions
    value, seconds = hand.ask(angle, Occasion(1, 7, trial, None, ("trial", 1, 1)))
    assert isinstance(value, float) and value % 0.5 == 0 and seconds > 0
    assert abs(value - trial.drawn["angle_deg"]) < 60 and abs(hand.ask(height, Occasion(1, 7, trial, None, ("trial", 1, 1)))[0]) < 30
    again = touching.Hand(p, str(processes.PROGRAM))
    assert again.ask(angle, Occasion(1, 7, trial, None, ("trial", 1, 1)))[0] == value
    # An answer beyond the scale is refused, not moved to its end.
    with refusal(HaptogramError):
        again.ask(replace(angle, low=value + 0.5), Occasion(1, 7, trial, None, ("trial", 1, 1)))
    assert_says(run(session("--observer", "simulated:hand"), place), BAD_INPUT)


@pytest.mark.deep
def test_a_hand_that_lifts_answers_what_the_task_found(place):
    """A short session: times of cubes that were lifted, and ratings of what was lifted and felt."""
    text = protocol.find("fingers_lift_visible").read_text().replace("sets = 25", "sets = 1").replace("from = 30\nto = 50", "from = 40\nto = 50")
    (place / "fingers_lift_visible.toml").write_text(text)
    command = study("run", "fingers_lift_visible.toml", "--participant", "1", "--seed", "3", "-o", "h.jsonl", "--observer", "simulated:hand")
    assert_says(run(command, place), OK, "complete, 9 new answers")
    trials = {r["factors"]["feedback"]: r for r in records(place / "h.jsonl") if r["kind"] == "trial"}
    ratings = {(r["question"], r["factors"]["feedback"]): r["answers"][r["question"]]["value"] for r in records(place / "h.jsonl") if r["kind"] == "question"}
    assert set(trials) == {"dynamic", "static", "none"}
    for feedback, trial in trials.items():
        time_s = trial["answers"]["time_s"]["value"]
        assert ratings["as_desired", feedback] == (1 if time_s is None else 7) and (time_s is None or 1.5 <= time_s < 12)
    assert ratings["present", "none"] == 1 < ratings["present", "dynamic"] and sum(t["answers"]["time_s"]["value"] is not None for t in trials.values()) >= 2
    # One that goes on carries out again what the ratings are of.
    kept = (place / "h.jsonl").read_text().splitlines(keepends=True)
    (place / "h.jsonl").write_text("".join(kept[:-2]))
    assert_says(run(command, place), OK, "complete, 2 new answers")
    assert [r["answers"] for r in records(place / "h.jsonl")] == [json.loads(line)["answers"] for line in kept]


@pytest.mark.deep
def test_a_hand_that_compares_two_arrays_judges_what_each_plays(place):
    """*Shapes* 2: two renderings, each with noise of its own; swapped sides swap the answer, and one rendering against itself is a guess."""
    command = study("run", "shapes_comparison", "--participant", "1", "--seed", "3", "-o", "c.jsonl", "--observer", "simulated:hand")
    assert_says(run(command, place), OK, "complete, 7 new answers")
    answers = [r["answers"] for r in records(place / "c.jsonl") if r["kind"] == "trial"]
    assert len(answers) == 6 and {one["stronger"]["value"] for one in answers} <= {"left", "right"} and all(1 <= one["surface_confidence"]["value"] <= 5 for one in answers)

    def votes(path, question):
        """How often the left side, in 60 trials of a cube with H at the left."""
        p = protocol.read(path)
        hand = touching.Hand(p, str(processes.PROGRAM))
        trial = next(c for c in cells(p, 1, 7) if c.levels["shape"].name == "cube" and c.levels["side_of_h"].name == "left")
        asked = next(q for q in p.questions if q.name == question)
        return sum(hand.ask(asked, Occasion(person, 7, trial, None, ("trial", 1, 1)))[0] == "left" for person in range(60))

    text = protocol.find("shapes_comparison").read_text()

    def variant(name, left, right):
        path = place / name
        path.write_text(text.replace('left = "H", right = "A"', f'left = "{left}", right = "{right}"'))
        return path

    same, weaker, stronger = variant("same.toml", "A", "A"), variant("weaker.toml", "E", "A"), variant("stronger.toml", "A", "E")
    assert 18 <= votes(same, "stronger") <= 42
    assert votes(weaker, "stronger") < 15 < 45 < votes(stronger, "stronger")
    other = variant("other.toml", "A", "H")
    other.write_text(other.read_text().replace("similar", "alike"))
    assert_says(run(study("run", "other.toml", "--participant", "1", "-o", "o.jsonl", "--observer", "simulated:hand"), place), BAD_INPUT)


def test_placeholders_with_numbers():
    values = {"edge_mm": "40.5", "freq-2": "7"}
    assert protocol.fill("{edge_mm*0.5+100},{edge_mm-1},{edge_mm},{freq-2}", values) == "120.25,39.5,40.5,7"
    assert protocol.names_in("{edge_mm*0.5+100} {freq-2}", values) == ["edge_mm", "freq-2"]


def test_stimuli_for_a_tracked_hand_are_played(place):
    """`haptogram live` plays from the trial's beginning to its answers; then outputs are off. Without feedback nothing plays."""
    (place / "lift.toml").write_text(protocol.find("fingers_lift_visible").read_text().replace("sets = 25", "sets = 1"))
    command = study("run", "lift.toml", "--participant", "1", "-o", "l.jsonl", "--observer", "simulated:chance", "--port", "port")
    with virtual_board(place, "--model", "reference", "--board", "tile-100-wide"):
        assert_says(run(command, place), BAD_INPUT)
        assert_says(run([*command, "--from", "synthetic:press"], place), OK, "complete")
        found = {r["factors"]["feedback"]: r["stimulus"] for r in records(place / "l.jsonl") if r["kind"] == "trial"}
        assert {name: one["played"] for name, one in found.items()} == {"dynamic": True, "static": True, "none": False}
        assert json.loads(haptogram(place, "device", "status", "--port", "port", "--json"))["outputs"] == "off"
        (place / "l.jsonl").unlink()
        assert_says(run([*command, "--from", "nobody:1"], place), DEVICE)


def command_of(process):
    """Of a folder of /proc; nothing of what has ended."""
    try:
        return (process / "cmdline").read_bytes()
    except OSError:
        return b""


def is_session_of(process, place):
    """Whether a folder of /proc is of a `haptogram live` in this place."""
    command = command_of(process)
    try:
        return b"leap-pipe:hands" in command and b"\0live\0" in command and (process / "cwd").samefile(place)
    except OSError:
        return False


@also_in_time
@pytest.mark.parametrize("how", ["killed", "Ctrl-C"])
def test_no_live_session_outlives_its_runner(place, how, in_time):
    """A killed runner tells nobody anything, and Ctrl-C of a terminal goes to all of its programs: in both cases one signal reaches the session."""
    os.mkfifo(place / "hands")
    text = protocol.find("fingers_lift_visible").read_text()
    (place / "lift.toml").write_text(text.replace('algorithm = "none"', 'algorithm = "still"'))  # each trial has a session
    command = study("run", "lift.toml", "--participant", "1", "-o", "l.jsonl", "--port", "port", "--from", "leap-pipe:hands")
    with virtual_board(place, "--board", "tile-100-wide") as board:
        host = subprocess.Popen(command, cwd=place, env=processes.ENVIRONMENT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True, start_new_session=True)  # fmt: skip
        host.stdin.write("\n")  # begin
        host.stdin.flush()
        with open(place / "hands", "w", encoding="utf-8"):  # as soon as the session waits for hands
            child = next(path for path in Path("/proc").glob("[0-9]*") if is_session_of(path, place))
            board.until(outputs=True)
            board.goes_on_for(0.5)
            if how == "killed":
                host.kill()
            else:
                os.killpg(host.pid, signal.SIGINT)
            said = host.communicate(timeout=300)[1]
            until(lambda: not command_of(child), "the session's end")
            board.until(outputs=False)
        now = json.loads(haptogram(place, "device", "status", "--port", "port", "--json"))
        assert now["outputs"] == "off" and (now["watchdog_trips"] == 0 or not in_time)
    if how == "Ctrl-C":
        assert host.returncode == RUN_FAILED and "confirm" not in said, said


def test_two_arrays_side_by_side_play_at_once(place):
    """*Shapes*' comparison: each array has a board, a session of its own and what sees the hand from it."""
    command = study("run", "shapes_comparison", "--participant", "1", "-o", "s.jsonl", "--observer", "simulated:chance", "--port", "port", "--from", "synthetic:press")
    kinds = ("--model", "reference", "--board", "tile-100-wide")
    with virtual_board(place, *kinds), virtual_board(place, *kinds, port="right"):
        assert_says(run(command, place), BAD_INPUT)
        assert_says(run([*command, "--port", "right"], place), BAD_INPUT)
        assert_says(run([*command, "--port", "right", "--from", "nobody:1"], place), DEVICE)
        for port in ("port", "right"):  # also of the other array when one fails
            assert json.loads(haptogram(place, "device", "status", "--port", port, "--json"))["outputs"] == "off"
        assert_says(run([*command, "--port", "right", "--from", "synthetic:press"], place), OK, "complete")
    assert all(r["stimulus"]["played"] for r in records(place / "s.jsonl") if r["kind"] == "trial")


def test_commands_of_the_terminal(place):
    assert_says(run(study("check", "small.toml", "absent.toml", "haptogram_shapes"), place), BAD_INPUT)
    listed = json.loads(run(study("list", "--json"), place).stdout)
    assert set(listed) == set(protocol.shipped())
    assert_says(run(study("run", "small.toml", "-o", "x"), place), USAGE)
    assert_says(run(study("check", "nothing"), place), BAD_INPUT)
    assert_says(run(study("power", "small.toml", "--alpha", "2"), place), USAGE)


def test_the_runner_needs_no_statistics(place):
    blocked = "import sys; sys.modules.update(dict.fromkeys(('numpy', 'scipy', 'pandas', 'statsmodels', 'matplotlib'))); "
    command = [sys.executable, "-c", blocked + "from haptogram_study.cli import main; sys.exit(main())"]
    assert_says(run([*command, *session("--observer", "simulated:protocol")[3:]], place), OK, "complete, 8 new answers")
    assert_says(run([*command, "analyse", "small.toml", "out.jsonl"], place), USAGE)


def test_stimuli_on_a_board(place):
    few = SMALL.replace('compile = ["--rate", "10"]', 'compile = ["--rate", "500", "--points", "4", "--shape", "circle"]').replace("sets = 2", "sets = 1")
    (place / "small.toml").write_text("\n".join(line for line in few.splitlines() if not line.startswith("path =")))
    with virtual_board(place):
        result = run(session("--observer", "simulated:protocol", "--port", "port", "--program", processes.PROGRAM, "--images", "made"), place)
        assert_says(result, OK, "complete, 4 new answers")
        assert "outputs          off" in processes.ask(place, "device", "status")
    made = records(place / "out.jsonl")
    assert all(r["stimulus"]["played"] and r["versions"]["haptogram"] for r in made)
    assert {(r["stimulus"]["image"]) for r in made} == {path.name for path in (place / "made").glob("*.hex")}
    # A stimulus that is another one now is not taken from the folder.
    (place / "out.jsonl").unlink()
    for image in (place / "made").glob("*.hex"):
        image.write_text("of yesterday", encoding="utf-8")
    assert_says(run(session("--observer", "simulated:protocol", "--program", processes.PROGRAM, "--images", "made"), place), OK, "another image than it did before")
    assert [r["stimulus"]["image_sha256"] for r in records(place / "out.jsonl")] == [r["stimulus"]["image_sha256"] for r in made]
    (place / "out.jsonl").unlink()
    assert_says(run(session("--observer", "simulated:protocol", "--port", "nowhere", "--program", processes.PROGRAM), place), 4)
    assert_says(run(session("--observer", "simulated:protocol", "--images", "x", "--program", "absent-program"), place), BAD_INPUT)
    described = ["--participant", 1, "-o", "other.jsonl", "--observer", "simulated:protocol", "--images", "x", "--program", processes.PROGRAM]
    assert_says(run(study("run", "fingers_surface", *described), place), BAD_INPUT)


def markers_of(place, monkeypatch, *options, in_time=False):
    """What a recorder gets of a session that marks: (time, marker), and the session's end. In time: times are in their order, too."""
    alone = f"[lab]\nSessionID = haptogram-{os.getpid()}\n"  # other tests at the same time are not found
    (place / "lsl.cfg").write_text(f"{alone}[multicast]\nResolveScope = machine\n[log]\nlevel = -2\n", encoding="utf-8")
    monkeypatch.setenv("LSLAPICFG", str(place / "lsl.cfg"))
    monkeypatch.setitem(processes.ENVIRONMENT, "LSLAPICFG", str(place / "lsl.cfg"))
    import pylsl

    command = [str(word) for word in session("--observer", "simulated:protocol", "--lsl", *options)]
    process = subprocess.Popen(command, cwd=place, env=processes.ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    begun_s = pylsl.local_clock()
    found = pylsl.resolve_byprop("name", "haptogram", 1, 300.0)
    assert found and found[0].type() == "Markers"
    inlet, got = pylsl.StreamInlet(found[0]), []
    inlet.open_stream(300.0)
    while (sample := inlet.pull_sample(0.5))[0] or process.poll() is None:
        if sample[0]:
            got.append((sample[1], json.loads(sample[0][0])))
    said = process.communicate()[1]
    assert process.returncode == OK and "waits until somebody records" in said, said
    times = [time_s for time_s, _ in got]
    # The board's clock is known to a millisecond or so.
    if in_time:
        assert all(later > earlier - 0.02 for earlier, later in zip(times, times[1:])) and begun_s < times[0] and times[-1] < pylsl.local_clock()
    assert [(marker["kind"], marker["trial"]) for _, marker in got] == [(kind, n) for n in range(1, 5) for kind in ("start", "answer", "stop")]
    return got


@also_in_time
def test_markers_have_the_time_of_the_board_that_tells_it(place, monkeypatch, in_time):
    few_on_a_board_with_pins(place)
    shown = ("--port", "port", "--program", processes.PROGRAM)
    for event, by in (("start", "board"), ("pass", "host")):
        (place / "out.jsonl").unlink(missing_ok=True)
        with virtual_board(place, "--board", "ulx3s-85f", "--model", "reference"):
            before = json.loads(processes.haptogram(place, "device", "trigger", "--out", event, "--port", "port", "--json"))
            markers = markers_of(place, monkeypatch, *shown, in_time=in_time)
            after = json.loads(processes.haptogram(place, "device", "trigger", "--port", "port", "--json"))
        starts = [(at_s, marker) for at_s, marker in markers if marker["kind"] == "start"]
        began = [record["began"] for record in records(place / "out.jsonl")]
        assert [b["by"] for b in began] == 4 * [by]
        assert all(("error_s" in b, "clock" in b, "error_s" in marker) == 3 * (by == "board",) for b, (_, marker) in zip(began, starts, strict=True))
        assert all(marker["by"] == by and marker["played"] for _, marker in starts)
        if by == "board":
            assert after["out_count"] - before["out_count"] == len(starts), "the board had one start for each"


def few_on_a_board_with_pins(place):
    few = SMALL.replace('compile = ["--rate", "10"]', 'compile = ["--rate", "500", "--points", "4", "--shape", "circle", "--board", "ulx3s-85f"]').replace("sets = 2", "sets = 1")
    (place / "small.toml").write_text("\n".join(line for line in few.splitlines() if not line.startswith("path =")))


@also_in_time
def test_stimuli_wait_for_the_trigger_input_and_have_the_boards_time(place, figure, in_time):
    """Nothing drives the pin of a virtual board: it is low, which is active or not as it is set."""
    few_on_a_board_with_pins(place)
    command = session("--observer", "simulated:protocol", "--port", "port", "--program", processes.PROGRAM, "--on-trigger")
    with virtual_board(place, "--board", "ulx3s-85f", "--model", "reference") as board:
        haptogram(place, "device", "trigger", "--in", "high", "--out", "start", "--port", "port")
        waits = subprocess.Popen(command, cwd=place, env=processes.ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        board.until(outputs=True)
        board.goes_on_for(0.3)
        assert waits.poll() is None
        waits.send_signal(signal.SIGTERM)
        assert "stopped after 0 more answers" in waits.communicate(timeout=300)[1]
        assert "outputs          off" in processes.ask(place, "device", "status") and not (place / "out.jsonl").read_text()
        haptogram(place, "device", "trigger", "--in", "low", "--level", "--port", "port")
        begun_s = time.time()
        assert_says(run(command, place), OK, "complete, 4 new answers")
        after = json.loads(haptogram(place, "device", "trigger", "--port", "port", "--json"))
    began = [record["began"] for record in records(place / "out.jsonl")]
    times = [datetime.datetime.fromisoformat(b["at"]).timestamp() for b in began]
    assert begun_s < times[0] and times == sorted(times) and times[-1] < time.time()
    assert after["out_count"] == 4 and began[-1]["clock"] == after["out_clock"] and all(b["error_s"] > 0 for b in began)
    clocks = [b["clock"] for b in began]
    told_s = [(c - clocks[0]) / 50e6 for c in clocks]
    # A virtual board's clock is this computer's to some milliseconds.
    off = [(round(at - times[0] - s, 5), b["error_s"]) for at, s, b in zip(times, told_s, began, strict=True)]
    if in_time:
        figure("a stimulus' beginning by the board's clock, beyond its own error", max(abs(away) - error - began[0]["error_s"] for away, error in off), 4e-3)
        figure("a stimulus' beginning: its error as told", max(b["error_s"] for b in began), 0.04)
    (place / "out.jsonl").unlink()
    assert_says(run(session("--observer", "simulated:protocol", "--on-trigger"), place), BAD_INPUT)
    with virtual_board(place):
        assert_says(run(command, place), DEVICE)


def test_a_session_that_plays_nothing_marks_it(place, monkeypatch):
    (place / "small.toml").write_text(SMALL.replace("sets = 2", "sets = 1"))
    assert not any(marker["played"] for _, marker in markers_of(place, monkeypatch) if marker["kind"] == "start")


def test_every_path_of_two_factors_has_its_own_hash(place):
    p = protocol.read(place / "small.toml")
    found = {}
    for shape, where in itertools.product(*(f.levels for f in p.factors)):
        found[shape.name, where.name] = Presenter(p).prepare(protocol.places(p, {"shape": shape, "place": where}, {}))["sha256"]
    assert len(set(found.values())) == 4
    again = Presenter(p).prepare(protocol.places(p, {"shape": p.factors[0].levels[0], "place": p.factors[1].levels[0]}, {}))
    assert again == {"sha256": found["circle", "left"], "played": False}


def test_pictures(place):
    matplotlib.use("Agg")
    figure, paper, made = figures.confusion()
    shown = {text.get_text() for text in figure.axes[0].texts}
    assert {"62.2%\n56", "51.1%\n46", "75.6%\n68"} <= shown and len(figure.axes[0].texts) == 16
    assert paper.share == pytest.approx(223 / 360) and made.share == pytest.approx(paper.share, abs=5 * (0.62 * 0.38 / 360) ** 0.5)
    figure.savefig(place / "confusion.png")
    figure, found = figures.staircase(-20.0, 0.3)
    assert set(found) == {"high", "low"} and all(level == pytest.approx(-20.0, abs=1.0) for level in found.values())
    counted = [line for line in figure.axes[0].lines if line.get_label() == "reversals that count"][0]
    assert found["high"] == pytest.approx(sum(counted.get_ydata()) / 5)
    figure.savefig(place / "staircase.png")
    assert all((place / name).stat().st_size > 10_000 for name in ("confusion.png", "staircase.png"))


# Haptogram's four shapes of 10 cm, as lines in mm.
ROUND = [[50 * math.cos(math.pi * i / 18), 50 * math.sin(math.pi * i / 18)] for i in range(37)]
DRAWINGS = {
    "circle": [ROUND],
    "triangle": [[[-50, -28.87], [50, -28.87], [0, 57.74], [-50, -28.87]]],
    "line": [[[-50, 0], [50, 0]]],
    "plus": [[[-50, 0], [50, 0]], [[0, -50], [0, 50]]],
}


def blurred(drawing, blur):
    """What is left of a drawing on a raster of 1 mm, unit energy, by scipy's filter."""
    raster = np.zeros((201, 201))
    for line in drawing:
        for (x0, y0), (x1, y1) in zip(line, line[1:]):
            pieces = max(1, round(np.hypot(x1 - x0, y1 - y0) / 0.25))
            for t in (np.arange(pieces) + 0.5) / pieces:
                raster[round(y0 + t * (y1 - y0)) + 100, round(x0 + t * (x1 - x0)) + 100] += np.hypot(x1 - x0, y1 - y0) / pieces
    left = scipy.ndimage.gaussian_filter(raster, blur, truncate=6)
    return left / np.sqrt((left**2).sum())


def test_an_observer_who_compares_with_templates():
    alike = np.array(observers.likeness(list(DRAWINGS.values()), 8.5))
    patterns = [blurred(drawing, 8.5).ravel() for drawing in DRAWINGS.values()]
    assert alike == pytest.approx(np.array(patterns) @ np.array(patterns).T, abs=0.02)
    p = protocol.read(protocol.shipped()["haptogram_shapes"])
    table = {"answer": {"model": "template", "factor": "shape", "snr": 2.5, "drawings": DRAWINGS}}
    model = observers.read_models(p, table, "here")["answer"]
    dice, order, count = random.Random(1), list(DRAWINGS), 4000
    rates = np.zeros((4, 4))
    for i, name in enumerate(order):
        (level,) = [one for one in p.factor("shape").levels if one.name == name]
        occasion = types.SimpleNamespace(cell=types.SimpleNamespace(levels={"shape": level}))
        for _ in range(count):
            rates[i, order.index(model(occasion, dice)[0])] += 1 / count
    # The same by noise on the whole pattern, not on the scores.
    rng = np.random.default_rng(1)
    expected = np.zeros((4, 4))
    factor = np.linalg.qr(np.array(patterns).T)[0]  # noise across all templates makes no difference
    inside = np.array(patterns) @ factor
    for i in range(4):
        noisy = 2.5 * inside[i] + rng.normal(size=(100_000, 4))
        expected[i] = np.bincount((noisy @ inside.T).argmax(axis=1), minlength=4) / 100_000
    assert rates == pytest.approx(expected, abs=0.05)
    assert rates.diagonal().min() > 0.5 and rates[2, 3] > rates[2, 0]  # a line is taken for a plus, and not for a circle
    same = dict(table["answer"], drawings=dict(DRAWINGS, plus=DRAWINGS["line"]))
    with refusal(HaptogramError):
        observers.read_models(p, {"answer": same}, "here")
    with refusal(HaptogramError):
        observers.read_models(p, {"answer": dict(table["answer"], drawings=dict(DRAWINGS, circle=[[[0, 0]]]))}, "here")
    with refusal(HaptogramError):
        observers.read_models(p, {"answer": {k: v for k, v in table["answer"].items() if k != "snr"}}, "here")
