# SPDX-License-Identifier: Apache-2.0
"""Protocols: those of the papers, what the reader refuses, and the orders of trials."""
import collections
import hashlib
import itertools
import re
import tomllib
from dataclasses import replace

import pytest
from haptogram import HaptogramError
from haptogram_study import design, observers, protocol, stimulus
from haptogram_study.asking import parse
from haptogram_study.design import cells
from messages import refusal

SMALL = """
format = "haptogram-protocol-1"
name = "small"
title = "A small study"
source = "this test"
participants = 2

[[factor]]
name = "shape"
levels = ["circle", "line"]

[[factor]]
name = "place"
levels = [{ name = "left", x_mm = -20 }, { name = "right", x_mm = 20 }]

[order]
within = "random"
sets = 2

[stimulus]
text = "{shape} at {place.x_mm} mm"
compile = ["--rate", "10"]
path = { waypoints_mm = [[0, 0, 130], ["{place.x_mm}", 0, 130]], speed_mm_s = 100 }

[[question]]
name = "answer"
text = "Which?"
kind = "choice"
keys = { 1 = "circle", 2 = "line" }
correct = "{shape}"

[[analysis]]
name = "rate"
test = "binomial"
of = "answer.correct"

[simulated.answer]
model = "confusion"
factor = "shape"
answers = ["circle", "line"]
rows = { circle = [9, 1], line = [1, 9] }
"""

# What is replaced by what, and what the message must name: the key, what was found or what was expected.
MISTAKES = [
    ('format = "haptogram-protocol-1"', 'format = "2"'),
    ('title = "A small study"\n', ""),
    ("participants = 2", "participants = 0"),
    ("participants = 2", "participants = true"),
    ("participants = 2", "participants = 2\ncolour = 1"),
    ('name = "shape"', 'name = "Shape!"'),
    ('name = "place"', 'name = "shape"'),
    ('levels = ["circle", "line"]', 'levels = ["circle", "circle"]'),
    ('levels = ["circle", "line"]', "levels = []"),
    ('levels = ["circle", "line"]', "levels = 5"),
    ('levels = ["circle", "line"]', 'levels = ["circle", "star"]'),
    ("x_mm = 20", "y_mm = 20"),
    ('within = "random"', 'within = "shuffled"'),
    ('within = "random"', 'within = "random"\nblocks = "fixed"'),
    ('within = "random"', 'within = "random"\nblocked = ["colour"]\nblocks = "fixed"'),
    ("sets = 2", "sets = 5000"),
    ("sets = 2", "sets = 2.5"),
    ("{shape} at", "{colour} at"),
    ('"--rate", "10"', '"-o", "x"'),
    ("speed_mm_s = 100", "speed_mm_s = 0"),
    ("speed_mm_s = 100", "speed_mm_s = nan"),
    ("[0, 0, 130], [", "[0, 130], ["),
    ('kind = "choice"', 'kind = "guess"'),
    ('keys = { 1 = "circle", 2 = "line" }', 'keys = { 1 = "circle" }'),
    ('correct = "{shape}"', 'correct = "{form}"'),
    ('test = "binomial"', 'test = "bayes"'),
    ('of = "answer.correct"', 'of = "answer.error"'),
    ('test = "binomial"\nof = "answer.correct"', 'test = "rm-anova"\nof = "answer.seconds"\nby = "shape"'),
    ('name = "shape"', 'name = "set"'),
    ('name = "answer"', 'name = "trial"'),
    ('of = "answer.correct"', 'of = "answer.correct"\nby = "shape"'),
    ('of = "answer.correct"', 'of = "answer.correct"\nwhere = { set = 3 }'),
    ('test = "binomial"\nof = "answer.correct"', 'test = "rm-anova"\nof = "answer.seconds"\nby = "set"'),
    ('test = "binomial"\nof = "answer.correct"', 'test = "confusion"\nof = "answer"\nby = "set"'),
    ('sets = 2', 'sets = 1\n[[analysis]]\nname = "x"\ntest = "paired-t"\nof = "answer.seconds"\nby = "set"'),
    ('[[analysis]]\nname = "rate"\ntest = "binomial"\nof = "answer.correct"',
     '[[question]]\nname = "last"\ntext = "?"\nkind = "scale"\nfrom = 1\nto = 7\nwhen = "end"\n[[analysis]]\nname = "rate"\ntest = "paired-t"\nof = "last"\nby = "set"'),
    ('model = "confusion"', 'model = "oracle"'),
    ("line = [1, 9]", "line = [1]"),
    ("line = [1, 9]", "line = [-1, 9]"),
    ("[simulated.answer]", "[simulated.reply]"),
    ("[order]", "[order"),
    ("[order]", '[[fitted]]\nname = "points"\nvalues = []\n[order]'),
    ("[order]", '[[fitted]]\nname = "points"\nvalues = [200, 200]\n[order]'),
    ("[order]", '[[fitted]]\nname = "shape"\nvalues = [200]\n[order]'),
    ("speed_mm_s = 100", 'speed_mm_s = 100, step_mm = "{points}"'),
    ('compile = ["--rate", "10"]', 'compile = ["--rate", "10"]\nmovement = ["circle"]'),
    ('compile = ["--rate", "10"]', 'movement = ["circle", "--board", "x"]'),
]


def written(tmp_path, text, name="small.toml"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refused(path):
    with refusal(HaptogramError) as caught:
        observers.read_protocol(path)
    assert caught.value.code == 3


@pytest.mark.parametrize(("old", "new"), MISTAKES, ids=range(len(MISTAKES)))
def test_mistakes_are_named(tmp_path, old, new):
    assert SMALL.count(old) >= 1
    refused(written(tmp_path, SMALL.replace(old, new)))


def test_hostile_files(tmp_path):
    refused(tmp_path / "absent.toml")
    refused(tmp_path)
    refused(written(tmp_path, b"\xff\xfe\x00"))
    refused(written(tmp_path, b""))
    refused(written(tmp_path, b"#" * 2_000_000))
    refused(written(tmp_path, "a = " + "[" * 100_000))
    refused(written(tmp_path, "factor = 3\n" + SMALL.split("[[factor]]")[0]))
    good = protocol.read(written(tmp_path, SMALL))
    keys = [key for key in tomllib.loads(SMALL) if key not in ("analysis", "simulated", "factor")]
    for key in keys:  # each table or value in turn of another type
        broken = re.sub(rf"(?m)^\[?\[?{key}\]?\]?( = .*)?$", f"[{key}.x.y]" if f"\n{key} = " in SMALL else f"[other_{key}]", SMALL, count=1)
        assert broken != SMALL
        refused(written(tmp_path, broken))
    assert good.trials == 8


def test_the_papers_protocols():
    found = {name: protocol.read(path) for name, path in protocol.shipped().items()}
    assert {p.source.split(",")[0] for p in found.values()} == {"Haptogram", "Hoshi", "Shapes", "Fingers", "Multimodal"}
    trials = {"haptogram_shapes": (15, 24), "hoshi_direction": (6, 40), "hoshi_positioning": (8, 16), "hoshi_movements": (8, 20), "fingers_surface": (11, 40), "fingers_lift_visible": (10, 75),
              "fingers_lift_hidden": (10, 50), "multimodal_magnitude": (16, 96), "multimodal_placing": (9, 3), "shapes_comparison": (16, 6)}  # fmt: skip
    for name, p in found.items():
        assert p.name == name and p.analyses and p.simulated and p.choices
        assert (p.participants, p.trials) == trials.get(name, (p.participants, p.trials))
        made = cells(p, p.participants, 5)
        assert [c.number for c in made] == list(range(1, p.trials + 1))
        for cell in made[:: max(len(made) // 8, 1)]:
            level = p.staircase.starts_db[cell.start] if p.staircase else None
            described = stimulus.describe(p.stimulus, protocol.places(p, cell.levels, cell.drawn, level) | p.fits()[0], name)
            assert "{" not in str(described["text"]) and "{" not in str(described.get("compile"))


def test_commands_are_those_of_eq_11():
    p = protocol.read(protocol.shipped()["multimodal_magnitude"])
    table = tomllib.loads((protocol.SHIPPED.parent / "printed.toml").read_text())["table"]["multimodal_1"]
    assert len(p.lookups[0].values) == 48
    for (hz, gf), command in p.lookups[0].values.items():
        a, b, c, d = table[hz]
        assert command == pytest.approx(a * float(gf) ** 3 + b * float(gf) ** 2 + c * float(gf) + d, abs=5.1e-5) and 0.3 < command < 1.0


def test_orders(tmp_path):
    surface = protocol.read(protocol.shipped()["fingers_surface"])
    first = [cells(surface, person, 1)[0].factors["method"] for person in range(1, 12)]
    assert collections.Counter(first) == {"dynamic": 6, "static": 5}
    for person in (1, 2):
        methods = [c.factors["method"] for c in cells(surface, person, 1)]
        assert methods[:20] == [methods[0]] * 20 and methods[20:] == [methods[20]] * 20 and methods[0] != methods[20]
    drawn = [c.drawn for c in cells(surface, 1, 1)]
    assert all(-45 <= d["angle_deg"] <= 45 and d["angle_deg"] % 0.5 == 0 and -10 <= d["height_mm"] <= 10 for d in drawn)
    assert len({d["angle_deg"] for d in drawn}) > 20
    shapes = protocol.read(protocol.shipped()["haptogram_shapes"])
    for person, number in itertools.product(range(1, 6), (1, 2)):
        names = [c.factors["shape"] for c in cells(shapes, person, 9) if c.set == number]
        assert collections.Counter(names) == dict.fromkeys(("circle", "triangle", "line", "plus"), 3)
    orders = {tuple(c.factors["shape"] for c in cells(shapes, person, seed)) for person in range(1, 6) for seed in range(5)}
    assert len(orders) == 25
    lift = protocol.read(protocol.shipped()["fingers_lift_visible"])
    sets = [[c.factors["feedback"] for c in cells(lift, 1, 1) if c.set == number] for number in range(1, 26)]
    assert all(sorted(s) == ["dynamic", "none", "static"] for s in sets) and len(set(map(tuple, sets))) == 6
    fixed = protocol.read(written(tmp_path, SMALL.replace('"random"', '"fixed"')))
    assert [tuple(c.factors.values()) for c in cells(fixed, 1, 1)] == list(itertools.product(("circle", "line"), ("left", "right"))) * 2


def test_draws_are_even_and_the_same_everywhere():
    assert design.digest(1, "a") == hashlib.sha256(b"1/a").digest()
    assert design.shuffled("abcdef", 7, 3) == sorted("abcdef", key=lambda c: hashlib.sha256(b"7/3/%d" % "abcdef".index(c)).digest()) == list("cfedab")
    places = collections.Counter(design.shuffled("abc", seed).index("a") for seed in range(3000))
    assert all(abs(count - 1000) < 130 for count in places.values())  # five standard deviations
    draws = [design.chance(seed, "x") for seed in range(2000)]
    assert abs(sum(draws) / 2000 - 0.5) < 0.033 and 0.0 <= min(draws) and max(draws) < 1.0


@pytest.mark.parametrize("size", range(2, 9))
def test_latin_squares_are_balanced(size):
    rows = design.latin_square(size)
    assert len(rows) == (size if size % 2 == 0 else 2 * size)
    assert all(sorted(row) == list(range(size)) for row in rows)
    for place in range(size):
        assert set(collections.Counter(row[place] for row in rows).values()) == {len(rows) // size}
    behind = collections.Counter(pair for row in rows for pair in itertools.pairwise(row))
    assert len(behind) == size * (size - 1) and len(set(behind.values())) == 1


def test_paths(tmp_path):
    p = protocol.read(written(tmp_path, SMALL.replace("speed_mm_s = 100", "speed_mm_s = 100, step_mm = 5, hold_s = 1")))
    rows = stimulus.path_rows(p.stimulus.path, {"place.x_mm": -20}, "x")
    assert rows == [(0, 0, 0, 130, 1), (50, -5, 0, 130, 1), (100, -10, 0, 130, 1), (150, -15, 0, 130, 1), (200, -20, 0, 130, 1), (700, -20, 0, 130, 1)]
    p = protocol.read(written(tmp_path, SMALL.replace("speed_mm_s = 100", "speed_mm_s = 100, square_hz = 10, intensity = 0.5")))
    rows = stimulus.path_rows(p.stimulus.path, {"place.x_mm": 20}, "x")
    assert rows == [(0, 0, 0, 130, 0.5), (50, 0, 0, 130, 0), (100, 10, 0, 130, 0.5), (150, 10, 0, 130, 0)]
    # It stays for two periods of 10 mm each.
    p = protocol.read(written(tmp_path, SMALL.replace("speed_mm_s = 100", "speed_mm_s = 100, square_hz = 10, step_mm = 20").replace("x_mm = 20", "x_mm = 40")))
    assert [row[1] for row in stimulus.path_rows(p.stimulus.path, {"place.x_mm": 40}, "x")] == [0, 0, 0, 0, 20, 20, 20, 20]
    for step in (-1, "far"):
        with refusal(HaptogramError):
            stimulus.path_rows(replace(p.stimulus.path, step_mm=step), {"place.x_mm": 40}, "x")
    for value in ("far", "nan"):
        with refusal(HaptogramError):
            stimulus.path_rows(p.stimulus.path, {"place.x_mm": value}, "x")


def test_answers_as_typed():
    def question(kind, **more):
        fields = {"keys": {"1": "circle"}, "low": 1, "high": 7, "whole": kind == "scale"} | more
        return protocol.Question("q", "?", kind, "trial", "", fields["keys"], fields["low"], fields["high"], fields["whole"], "", "", 0.0)

    assert parse(question("choice"), " 1 ") == "circle" and parse(question("scale"), "7") == 7 and parse(question("number"), "2.5") == 2.5
    assert parse(question("yes-no", keys={"y": "yes", "n": "no"}), "n") is False and parse(question("text"), "soft ") == "soft"
    for kind, typed in (("choice", "circle"), ("scale", "8"), ("scale", "2.5"), ("number", "nan"), ("number", "inf"), ("number", ""), ("text", " ")):
        with pytest.raises(ValueError, match="type"):
            parse(question(kind), typed)
