# SPDX-License-Identifier: Apache-2.0
"""The papers' printed numbers: what is told of them, the verdicts that follow, and a bad list is refused."""
import collections
import json
import re
import sys

import pytest
from messages import program_said, refusal
from processes import OK, RUN_FAILED, run
from haptogram import HaptogramError
from haptogram_study import printed


@pytest.fixture(scope="module")
def lines():
    return printed.recompute()


def one(lines, paper, part):
    found = [line for line in lines if line.paper == paper and part in line.what]
    assert len(found) == 1, [line.what for line in found]
    return found[0]


def test_what_is_printed_of_them(tmp_path, lines):
    command = [sys.executable, "-m", "haptogram_study", "printed"]
    assert len(json.loads(run([*command, "--json"], tmp_path).stdout)) == len(lines)
    bad = [line for line in lines if line.verdict in printed.BAD]
    for more, wanted in (([], lines), (["--differing"], bad)):
        *told, sum_of_all = run([*command, *more], tmp_path).stdout.splitlines()
        assert [row.split()[0] for row in told if row.startswith("  ")] == [line.verdict.split()[0] for line in wanted]
        assert sum_of_all == f"{len(lines)} numbers, {len(bad)} of them do not agree or cannot be"


@pytest.mark.parametrize(("paper", "what", "shown", "ours", "verdict"), [
    ("Multimodal", "time: p of F(2, 24) = 0.43", "0.265", "0.655", "differs"),
    ("Multimodal", "accuracy: p of F(2, 24) = 13.11", "0.0001", "0.0001", "agrees"),
    ("Multimodal", "F(2, 24) of p = 0.265", "0.43", "1.40", "differs"),
    ("Multimodal", "fewest people", "", "220", "not printed"),
    ("Multimodal", "degrees of freedom", "24", "16", "differs"),
    ("Multimodal", "difficult: SD", "1.83", "at most 1.99", "possible"),
    ("Haptogram", "right answers over all, from Table 1", "59.44", "61.94", "differs"),
    ("Haptogram", "can it be a share of 360", "59.44", "214/360 = 59.44", "possible"),
    ("Haptogram", "Cohen", "", "0.493", "not printed"),
    ("Haptogram", "information", "", "0.648", "not printed"),
    ("Haptogram", "χ²(3)", "", "19.27", "not printed"),
    ("Haptogram", "its p", "", "0.00024", "not printed"),
    ("Haptogram", "ΔT", "643", "53", "differs"),
    ("Haptogram", "β", "26", "3", "differs"),
    ("Hoshi", "interval from", "", "98.47", "not printed"),
    ("Hoshi", "guessing", "", "-240", "not printed"),
    ("Hoshi", "standard deviation", "16.3", "16.3", "agrees"),
    ("Hoshi", "standard error", "", "0.65", "not printed"),
    ("Hoshi", "diameter of the focus", "19", "19", "agrees"),
    ("Shapes", "question 1, 27 of 48", "", "0.471", "not printed"),
    ("Shapes", "30 of 48", "", "0.111", "not printed"),
    ("Shapes", "9 of 16", "", "0.804", "not printed"),
    ("Shapes", "10 of 16", "", "0.454", "not printed"),
    ("Shapes", "over that of voters for A, question 1", "", "1.22", "not printed"),
    ("Shapes", "the same, question 2", "", "1.22", "not printed"),
    ("Shapes", "the same, question 3", "", "1.40", "not printed"),
    ("Shapes", "edge of a cube", "", "21.5", "not printed"),
    ("Fingers", "angle when the answer is always 0", "", "22.5", "not printed"),
    ("Fingers", "angle when guessing", "", "30.0", "not printed"),
    ("Fingers", "height when the answer is always the middle", "", "5.0", "not printed"),
    ("Fingers", "height when guessing", "", "6.67", "not printed"),
    ("Fingers", "Wilcoxon p of 10 people", "", "0.00195", "not printed"),
    ("Fingers", "Wilcoxon p of 11 people", "", "0.00098", "not printed"),
    ("Fingers", "times 3", "0.05", "at least 0.00586", "possible"),
    ("Fingers", "F(2, 18) above", "", "3.555", "not printed"),
    ("Fingers", "χ²(2)", "", "5.991", "not printed"),
    ("Fingers", "|t| above which p < 0.05, 11", "", "2.228", "not printed"),
    ("Fingers", "|t| above which p < 0.05, 10", "", "2.262", "not printed"),
])  # fmt: skip
def test_numbers_that_follow(lines, paper, what, shown, ours, verdict):
    line = one(lines, paper, what)
    assert (line.printed, line.ours, line.verdict) == (shown, ours, verdict)


def test_ratings_and_shares_of_nine_people(lines):
    assert collections.Counter(line.verdict for line in lines if "nine ratings" in line.what and "SD" not in line.what) == {"impossible": 7}
    assert all(line.verdict == "impossible" for line in lines if "48.6" in line.printed)


def test_tables(lines):
    cells = [line for line in lines if " taken for " in line.what]
    counts = [int(re.search(r"(\d+) of 90", line.what)[1]) for line in cells]
    assert [counts[i : i + 4] for i in range(0, 16, 4)] == [[56, 6, 24, 4], [13, 59, 11, 7], [46, 2, 40, 2], [6, 9, 7, 68]]
    assert all(abs(float(line.printed) - float(line.ours)) <= 0.0101 for line in cells)
    derived = {(80, 0): "0.6185", (80, 1): "10.149", (80, 2): "1.115", (80, 3): "0.0090", (100, 0): "0.5804", (100, 1): "8.928", (140, 2): "0.707", (140, 3): "-0.0058",
               (180, 0): "0.5478", (180, 1): "7.592", (240, 1): "4.363", (240, 3): "-0.0145", (300, 0): "0.4926", (300, 1): "2.458", (300, 2): "0.831", (300, 3): "-0.0535"}  # fmt: skip
    for (hz, which), value in derived.items():
        assert [line.ours for line in lines if line.what.startswith(f"{hz} Hz: ")][which] == value
    assert [one(lines, "Multimodal", part).ours for part in ("finger: a", "finger: b", "palm: a", "palm: b")] == ["0.07721", "0.01353", "0.06257", "0.01409"]


@pytest.mark.parametrize("text", [
    "",
    'format = "haptogram-printed-1"\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nprinted = "1"\nby = "magic"\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nprinted = "one"\nby = "value"\nwith = { value = 1 }\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nprinted = "1"\nby = "value"\nwith = { worth = 1 }\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nprinted = "1"\nby = "quotient"\nwith = { over = [1], under = [0] }\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nby = "confusion_kappa"\nwith = { table = "none" }\n',
    'paper = "P"\nwhere = "1"\nwhat = "w"\nprinted = "1"\nby = "value"\nwith = { value = 1 }\nnota = "x"\n',
])  # fmt: skip
def test_a_bad_list_is_refused(tmp_path, text):
    path = tmp_path / "bad.toml"
    path.write_text(('format = "haptogram-printed-1"\n[[number]]\n' if text.startswith("paper") else "") + text)
    with refusal(HaptogramError):
        printed.recompute(path)
