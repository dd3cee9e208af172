# SPDX-License-Identifier: Apache-2.0
"""Statistics of studies against closed forms, exhaustive counts, and other programs' results."""
import itertools
import math
import random
from decimal import ROUND_HALF_DOWN, ROUND_HALF_UP, Decimal

import numpy as np
import pandas as pd
import pytest
import statsmodels.api
from haptogram import HaptogramError
from haptogram.study import inference
from haptogram.study.observers import felt
from haptogram.study.staircase import Rule, Staircase
from scipy import stats

TABLE_1 = [[56, 6, 24, 4], [13, 59, 11, 7], [46, 2, 40, 2], [6, 9, 7, 68]]


@pytest.fixture
def dice():
    """Other random numbers in each run; what pytest prints of a failure has their seed."""
    seed = random.randrange(2**32)
    print(f"seed {seed}")
    return random.Random(seed)


RULE = Rule("felt", {"high": 0.0}, -1000.0, 1000.0)


def test_reference_values():
    for people, p in ((10, "0.00195"), (11, "0.00098")):
        assert inference.rounded(inference.wilcoxon(np.arange(1.0, people + 1), np.zeros(people)).p, 5) == p
        assert inference.wilcoxon(np.arange(1.0, people + 1), np.zeros(people)).p == 2.0 / 2**people
    assert inference.rounded(3 * 2.0 / 2**10, 5) == "0.00586"
    assert inference.rounded(stats.t.isf(0.025, 10), 3) == "2.228" and inference.p_of("t", 2.2281388520, 10) == pytest.approx(0.05, abs=1e-9)
    assert inference.p_of("t", 2.2621571628, 9) == pytest.approx(0.05, abs=1e-9)
    assert inference.p_of("F", 3.5545571457, 2, 18) == pytest.approx(0.05, abs=1e-9)
    assert inference.p_of("chi2", 5.9914645471, 2) == pytest.approx(0.05, abs=1e-9)


def test_p_values_are_their_closed_forms(dice):
    for _ in range(50):
        f, df = dice.uniform(0.01, 30.0), dice.randint(2, 60)
        assert inference.p_of("F", f, 2, df) == pytest.approx((1.0 + 2.0 * f / df) ** (-df / 2.0), rel=1e-9)
        assert inference.p_of("t", -f, df) == pytest.approx(inference.p_of("F", f * f, 1, df), rel=1e-9, abs=1e-300)
        assert inference.p_of("chi2", f, 2) == pytest.approx(math.exp(-f / 2.0), rel=1e-12)
    assert inference.rounded(inference.p_of("F", 13.11, 2, 24), 6) == "0.000142"
    assert inference.rounded(inference.p_of("F", 0.43, 2, 24), 3) == "0.655"


def test_shares():
    for k, n, p in ((9, 16, "0.804"), (27, 48, "0.471"), (10, 16, "0.454"), (30, 48, "0.111")):
        found = inference.binomial(k, n, 0.5)
        tails = sum(math.comb(n, i) for i in range(n + 1) if math.comb(n, i) <= math.comb(n, k)) / 2**n
        assert found[0] == pytest.approx(tails, rel=1e-12) and inference.rounded(found[0], 3) == p
    _, low, high = inference.binomial(240, 240, 0.5)
    assert high == 1.0 and low == pytest.approx(0.025 ** (1 / 240), rel=1e-9) and inference.rounded(low, 4) == "0.9847"


def test_confusion_of_table_1():
    found = inference.confusion(TABLE_1)
    total = 360.0
    assert inference.rounded(100 * found.share, 2) == "61.94" and found.rates[2] == pytest.approx(40 / 90)
    expected = sum(sum(row) * sum(r[i] for r in TABLE_1) for i, row in enumerate(TABLE_1)) / total**2
    assert found.kappa == pytest.approx((223 / total - expected) / (1 - expected), rel=1e-12) and inference.rounded(found.kappa, 3) == "0.493"
    bits = sum(c / total * math.log2(c / total / (sum(row) / total * sum(r[j] for r in TABLE_1) / total)) for row in TABLE_1 for j, c in enumerate(row))
    assert found.bits == pytest.approx(bits, rel=1e-12) and inference.rounded(found.bits, 3) == "0.648"
    share = 223 / total
    chi2 = sum((row[i] - 90 * share) ** 2 / (90 * share * (1 - share)) for i, row in enumerate(TABLE_1))
    assert found.homogeneity.statistic == pytest.approx(chi2, rel=1e-12) and inference.rounded(chi2, 2) == "19.27"
    assert found.homogeneity.df == (3.0,) and inference.rounded(found.homogeneity.p, 5) == "0.00024"
    perfect = inference.confusion(np.diag([5, 5]))
    assert (perfect.kappa, perfect.bits, perfect.homogeneity.p) == (1.0, 1.0, 1.0)


def test_repeated_measures_by_sums_of_squares():
    for seed in range(20):
        values = np.random.default_rng(seed).normal(size=(7, 4)) * [1.0, 2.0, 3.0, 1.0] + [0, 0, 1, 0]
        plain, shrunk = inference.rm_anova(values)
        centred = values - values.mean()
        between, people = 7 * (centred.mean(0) ** 2).sum(), 4 * (centred.mean(1) ** 2).sum()
        left = (centred**2).sum() - between - people
        assert plain.statistic == pytest.approx(between / 3 / (left / 18), rel=1e-9) and plain.df == (3.0, 18.0)
        # Greenhouse and Geisser's own formula, from the means of the covariance matrix.
        s, k = np.cov(values, rowvar=False), 4
        top = k**2 * (np.trace(s) / k - s.mean()) ** 2
        bottom = (k - 1) * ((s**2).sum() - 2 * k * (s.mean(0) ** 2).sum() + k**2 * s.mean() ** 2)
        assert shrunk.df[0] == pytest.approx(3 * top / bottom, rel=1e-9)
        assert shrunk.p == pytest.approx(stats.f.sf(plain.statistic, *shrunk.df), rel=1e-9)
        assert 1 / 3 - 1e-9 <= inference.greenhouse_geisser(values) <= 1.0 + 1e-9
    pair = np.random.default_rng(1).normal(size=(9, 2))
    t, (f, _) = inference.paired_t(*pair.T), inference.rm_anova(pair)
    assert f.statistic == pytest.approx(t.statistic**2, rel=1e-9) and f.p == pytest.approx(t.p, rel=1e-9)


def test_wilcoxon_is_exact_with_ties(dice):
    dice = np.random.default_rng(dice.randrange(2**32))
    for _ in range(25):
        a, b = dice.integers(1, 8, size=(2, 9)).astype(float)
        kept = (a - b)[a != b]
        if len(kept) == 0:
            assert inference.wilcoxon(a, b).p == 1.0
            continue
        ranks = stats.rankdata(abs(kept))
        seen = min(ranks[kept > 0].sum(), ranks[kept < 0].sum())
        sums = [np.dot(ranks, signs) for signs in itertools.product((0, 1), repeat=len(kept))]
        expected = min(1.0, 2 * sum(s <= seen + 1e-9 for s in sums) / len(sums))
        found = inference.wilcoxon(a, b)
        assert found.p == pytest.approx(expected, rel=1e-12) and found.statistic == seen
    plain = dice.normal(size=25)
    assert inference.wilcoxon(plain, np.zeros(25)).p == pytest.approx(stats.wilcoxon(plain, method="exact").pvalue, rel=1e-12)


def test_several_tests():
    assert inference.corrected([0.01, 0.02, 0.04], "bonferroni") == pytest.approx([0.03, 0.06, 0.12])
    assert inference.corrected([0.01, 0.02, 0.04], "holm") == pytest.approx([0.03, 0.04, 0.04])
    assert inference.corrected([0.01], "none") == [0.01]
    groups = [np.array([1.0, 2, 3]), np.array([2.0, 3, 4]), np.array([9.0, 10, 11])]
    assert inference.anova(*groups).statistic == pytest.approx(3 * ((2 - 5) ** 2 + (3 - 5) ** 2 + (10 - 5) ** 2) / 2 / 1.0)
    tukey = inference.tukey(groups, ["a", "b", "c"])
    assert tukey["a", "b"] == pytest.approx(stats.studentized_range.sf(1.0 / math.sqrt(1.0 / 3.0), 3, 6), rel=1e-3)
    assert inference.friedman([[1, 2, 3]] * 5).statistic == pytest.approx(10.0)  # n(k − 1), the largest


def test_psychometric_fits():
    levels, trials = np.array([-24.0, -21, -18, -15, -12, -9]), np.full(6, 40.0)
    yes = np.array([1.0, 5, 14, 29, 37, 40])
    for link, family in (("probit", statsmodels.api.families.links.probit()), ("logit", statsmodels.api.families.links.logit())):
        model = statsmodels.api.GLM(np.stack([yes, trials - yes]).T, statsmodels.api.add_constant(levels), family=statsmodels.api.families.Binomial(family)).fit()
        found = inference.psychometric(levels, yes, trials, link=link)
        assert found.threshold == pytest.approx(-model.params[0] / model.params[1], rel=1e-4)
        assert found.spread == pytest.approx(1 / model.params[1], rel=1e-4)
    share = np.array([felt(level, -17.0, 3.0, 0.05, 0.0) for level in levels])
    lapsing = inference.psychometric(levels, 1e6 * share, np.full(6, 1e6), lapse=None)
    assert (lapsing.threshold, lapsing.spread, lapsing.lapse) == pytest.approx((-17.0, 3.0, 0.05), rel=2e-3)


def test_polynomials_and_magnitudes():
    x = np.linspace(0.07, 0.49, 8)
    coefficients, r2 = inference.polynomial(x, -10.39 * x**2 + 23.17 * x - 0.2071, 2)
    assert coefficients == pytest.approx([-10.39, 23.17, -0.2071]) and r2 == pytest.approx(1.0)
    y = x + np.array([1, -1] * 4) * 0.01
    assert inference.polynomial(x, y, 1)[0] == pytest.approx(np.polyfit(x, y, 1)) and inference.polynomial(x, y, 1)[1] == pytest.approx(np.corrcoef(x, y)[0, 1] ** 2)
    frame = pd.DataFrame({"person": [1, 1, 2, 2], "value": [1.0, 4.0, 10.0, 90.0]})
    assert list(inference.normalised(frame, "person", "value")) == pytest.approx([8.0, 32.0, 16.0 / 3.0, 48.0])  # geometric means 2 and 30, mean 16


def test_printed_means_and_percentages(dice):
    impossible = ("3.77", "3.45", "3.51", "4.02", "3.25", "3.63", "2.31")
    assert not any(inference.grim(mean, 9) for mean in impossible) and inference.grim("3.78", 9)
    for _ in range(200):
        people, mean = dice.randint(1, 40), f"{dice.uniform(1, 5):.{dice.choice((1, 2))}f}"
        quantum = Decimal(1).scaleb(-inference.decimals(mean))
        means = {str((Decimal(t) / people).quantize(quantum, how)) for t in range(6 * people) for how in (ROUND_HALF_UP, ROUND_HALF_DOWN)}
        assert inference.grim(mean, people) == (mean in means), (mean, people)
    shares = ["48.6", "17.3", "25.5", "8.6"]
    assert not inference.possible_counts(shares, 9) and not inference.possible_counts(shares, 27)
    assert inference.fewest_people(shares) == 220
    for people in (3, 7, 12):
        counts = [people // 3, people // 2, people - people // 3 - people // 2]
        given = [f"{100 * c / people:.1f}" for c in counts]
        assert inference.possible_counts(given, people) and inference.fewest_people(given) <= people
    with pytest.raises(HaptogramError, match="no number of people"):
        inference.fewest_people(["50.0", "60.0"], 500)


def staircases(sd_db, start_db, runs):
    dice, found = random.Random(20), []
    for _ in range(runs):
        stairs = Staircase(RULE, start_db + dice.uniform(-0.5, 0.5))
        while stairs.state == "running":
            stairs.answer(dice.random() < felt(stairs.level_db, 0.0, sd_db, 0.0, 0.0))
        found.append(stairs.threshold_db)
    return np.array(found)


@pytest.mark.parametrize(("sd_db", "expected"), [(0.5, 0.33), (1.0, 0.51), (2.0, 0.87)])
def test_staircases_find_the_threshold(sd_db, expected):
    for start in (12.0, -28.0):
        found = staircases(sd_db, start, 2000)
        assert abs(found.mean()) <= 0.13 + 4 * expected / math.sqrt(2000)
        assert found.std() == pytest.approx(expected, rel=0.1)


def test_a_staircase_by_hand():
    stairs, levels = Staircase(RULE, 0.0), []
    for yes in (1, 1, 0, 1, 0, 1, 1, 0, 0, 1, 0):
        levels.append(stairs.level_db)
        stairs.answer(bool(yes))
    assert levels == [0, -3, -6, -3, -6, -5, -6, -7, -6, -5, -6]
    assert stairs.reversals_db == [-6, -3, -6, -5, -7, -5, -6] and stairs.state == "running" and stairs.threshold_db is None
    stairs.answer(True)
    assert stairs.state == "found" and stairs.threshold_db == pytest.approx((-5 - 7 - 5 - 6 - 5) / 5)
    bounded = Staircase(Rule("felt", {}, -10.0, 0.0), 0.0)
    for _ in range(5):
        bounded.answer(False)
    assert bounded.state == "out of range" and bounded.level_db == 0.0 and bounded.threshold_db is None


def test_what_cannot_be_computed_is_said():
    for call in (lambda: inference.paired_t([1.0], [2.0]), lambda: inference.confusion([[1, 2], [0, 0]]), lambda: inference.confusion([[1, 2, 3], [1, 2, 3]]),
                 lambda: inference.chi_squared([[0, 1], [0, 2]]), lambda: inference.anova([1.0, math.nan], [1.0, 2.0]),
                 lambda: inference.psychometric([1.0, 2.0], [5.0, 5.0], [5.0, 5.0]), lambda: inference.rm_anova([[1.0], [2.0]])):  # fmt: skip
        with pytest.raises(HaptogramError, match="expected|no threshold"):
            call()
