# SPDX-License-Identifier: Apache-2.0
"""Plans that are refused say what is wrong; none of these starts a cluster."""
import pathlib

import pytest
from haptogram_sweep import plan
from haptogram_sweep.errors import BAD_INPUT, SweepError
from messages import refusal

GOOD = """format = "haptogram-sweep-1"
quantities = ["pressure_pa"]
[vary]
side = [2, 3]
pitch_mm = {from = 9, to = 10, steps = 3}
focus_mm = [[0, 0, 130]]
"""


def read(folder, text):
    (folder / "plan.toml").write_text(text, encoding="utf-8")
    return plan.read(folder / "plan.toml")


def test_every_combination_once(tmp_path):
    found = read(tmp_path, GOOD)
    assert [(c["side"], c["pitch_mm"]) for c in found.configurations] == [(s, p) for s in (2, 3) for p in (9.0, 9.5, 10.0)]
    assert found.varied == ["side", "pitch_mm"]
    assert len({found.key_of(c) for c in found.configurations}) == 6


def test_keys_follow_contents(tmp_path):
    """A row is the same only while all is the same that it follows from: a shape that a project names, too."""
    (tmp_path / "p.toml").write_text('format = "haptogram-project-1"\n[[shape]]\nfile = "cloud.xyz"\n')
    (tmp_path / "cloud.xyz").write_text("0 0 130\n")
    text = 'format = "haptogram-sweep-1"\nquantities = ["pressure_pa"]\n[vary]\nproject = ["p.toml"]\n'
    first = read(tmp_path, text)
    assert set(first.files["p.toml"]) == {"p.toml", "cloud.xyz"}
    keys = {first.key_of(first.configurations[0])}
    (tmp_path / "cloud.xyz").write_text("0 0 131\n")
    for changed in (text, text.replace('"pressure_pa"', '"pressure_pa", "force_mn"')):
        again = read(tmp_path, changed)
        keys.add(again.key_of(again.configurations[0]))
    assert len(keys) == 3


WRONG = {
    "no format": GOOD.replace("sweep-1", "sweep-9"),
    "no TOML": "[",
    "an unknown key": "colour = 1\n" + GOOD,
    "an unknown thing to vary": GOOD + "colour = [1]\n",
    "nothing played": GOOD.replace("focus_mm = [[0, 0, 130]]", ""),
    "two things played": GOOD + 'path = ["a.json"]\n',
    "a pitch without a side": GOOD.replace("side = [2, 3]", ""),
    "an array and a side": GOOD + 'array = ["tile-10x10"]\n',
    "a side of a half": GOOD.replace("[2, 3]", "[2.5]"),
    "a negative pitch": GOOD.replace("{from = 9, to = 10, steps = 3}", "[-1]"),
    "a range of foci": GOOD.replace("[[0, 0, 130]]", "{from = 1, to = 2, steps = 2}"),
    "a value twice": GOOD.replace("[2, 3]", "[2, 2]"),
    "an empty list": GOOD.replace("[2, 3]", "[]"),
    "an unknown quantity": GOOD.replace("pressure_pa", "warmth"),
    "a quantity of paths": GOOD.replace("pressure_pa", "highest_db"),
    "no least pressure": GOOD.replace("pressure_pa", "workspace_cm3"),
    "a table for nothing": GOOD + "[workspace]\nleast_pa = 1\n",
    "a range backwards": GOOD.replace("pressure_pa", "workspace_cm3") + "[workspace]\nleast_pa = 1\nx_mm = [5, 1]\n",
    "a plot of nothing": GOOD + '[plot]\nx = "colour"\n',
    "a file that is not there": GOOD.replace("focus_mm = [[0, 0, 130]]", 'path = ["none.json"]'),
    "a file elsewhere": GOOD.replace("focus_mm = [[0, 0, 130]]", 'path = ["../none.json"]'),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_makes_no_sense(case, tmp_path):
    text = WRONG[case]
    with refusal(SweepError) as caught:
        read(tmp_path, text)
    assert caught.value.code == BAD_INPUT


def test_the_example_is_good():
    example = pathlib.Path(plan.__file__).parents[1] / "examples/pitch-and-count.toml"
    assert len(plan.read(example).configurations) == 55
