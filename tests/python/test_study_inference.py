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
from haptogram_study import inference
from haptogram_study.observers import felt
from haptogram_study.staircase import Rule, Staircase
from messages import refusal
from scipy import optimize, special, stats

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
    p, apart = tukey["a", "b"]
    assert p == pytest.approx(stats.studentized_range.sf(1.0 / math.sqrt(1.0 / 3.0), 3, 6), rel=1e-6)
    half = stats.studentized_range.isf(0.05, 3, 6) / math.sqrt(3.0)  # the mean square within groups is 1, three of each
    assert (apart.value, apart.low, apart.high, apart.level) == pytest.approx((-1.0, -1.0 - half, -1.0 + half, 0.95), rel=1e-5)
    # The table of Tukey's range: 4.339 for three groups and 6 degrees of freedom.
    assert half * math.sqrt(3.0) == pytest.approx(4.339, abs=6e-4) and list(tukey) == [("a", "b"), ("a", "c"), ("b", "c")]
    assert inference.friedman([[1, 2, 3]] * 5).statistic == pytest.approx(10.0)  # n(k − 1), the largest


QUANTILES = (np.arange(100_000) + 0.5) / 100_000


def chance_of_t(t, df, noncentrality):
    """P(T ≤ t) of the noncentral t by its definition, (Z + δ)/√(χ²/df), as a mean over χ²."""
    return special.ndtr(t * np.sqrt(stats.chi2.ppf(QUANTILES, df) / df) - noncentrality).mean()


def chance_of_f(f, above, below, noncentrality):
    """P(F ≤ f) of the noncentral F as the mixture of beta distributions, whose weights are Poisson's (Johnson, Kotz and Balakrishnan, 30.3)."""
    j = np.arange(int(noncentrality + 20 * math.sqrt(noncentrality) + 60))
    return (stats.poisson.pmf(j, noncentrality / 2) * special.betainc(above / 2 + j, below / 2, above * f / (above * f + below))).sum()


def test_differences_of_pairs():
    # By hand: differences 1, 2, 3, 4, 5 have mean 3 and variance 2.5; t = 3/√0.5; t of 0.975 at 4 degrees of freedom is 2.776445.
    difference, d_z = inference.paired_effects([2.0, 4, 6, 8, 10], [1.0, 2, 3, 4, 5])
    assert (difference.value, difference.low, difference.high) == pytest.approx((3.0, 3 - 2.776445 * math.sqrt(0.5), 3 + 2.776445 * math.sqrt(0.5)), rel=1e-6)
    assert d_z.value == pytest.approx(3 / math.sqrt(2.5), rel=1e-12) and (difference.level, d_z.level) == (0.95, 0.95)
    for size, effect in ((2, 0.3), (5, 1.0), (11, -0.7), (15, 0.0), (40, 2.5), (8, -30.0), (9, 900.0)):
        pairs = np.random.default_rng(size).normal(size=size)
        pairs = (pairs - pairs.mean()) / pairs.std(ddof=1) + effect
        (difference, d_z), t = inference.paired_effects(pairs, np.zeros(size)), effect * math.sqrt(size)
        assert d_z.value == pytest.approx(effect, abs=1e-9)
        for end, chance in ((d_z.low, 0.975), (d_z.high, 0.025)):
            assert chance_of_t(t, size - 1, end * math.sqrt(size)) == pytest.approx(chance, abs=2e-4)
        other = inference.paired_effects(np.zeros(size), pairs)[1]
        assert (other.low, other.high) == pytest.approx((-d_z.high, -d_z.low), abs=1e-9)
        # The interval of the difference leaves out 0 where Student's test finds it, and so does that of d_z.
        found = inference.paired_t(pairs, np.zeros(size)).p < 0.05
        assert found == (difference.low * difference.high > 0) == (d_z.low * d_z.high > 0)


def test_the_interval_of_a_difference_contains_it_as_often_as_it_says():
    dice, hits = np.random.default_rng(4), np.zeros(2)
    for _ in range(1000):
        effects = inference.paired_effects(dice.normal(0.8, 1.0, size=9), np.zeros(9))
        hits += [e.low <= 0.8 <= e.high for e in effects]
    assert hits == pytest.approx([950, 950], abs=4 * math.sqrt(1000 * 0.95 * 0.05))


def test_eta_squared():
    # By hand: the sum of squares between 1, 2, 3 | 2, 3, 4 | 9, 10, 11 is 114, within it is 6.
    groups = [np.array([1.0, 2, 3]), np.array([2.0, 3, 4]), np.array([9.0, 10, 11])]
    plain = inference.eta_squared(inference.anova(*groups))
    assert plain.value == pytest.approx(114 / 120, rel=1e-12) and plain.level == 0.9 and "90 % interval" in str(plain)
    values = np.random.default_rng(2).normal(size=(8, 3)) + [0, 1, 0]
    centred = values - values.mean()
    between, people = 8 * (centred.mean(0) ** 2).sum(), 3 * (centred.mean(1) ** 2).sum()
    test = inference.rm_anova(values)[0]
    assert inference.eta_squared(test, "partial eta squared").value == pytest.approx(between / ((centred**2).sum() - people), rel=1e-9)
    # The ends are where λ makes F, or a larger one, as rare as 5 %.
    for f, above, below in ((13.11, 2, 24), (0.43, 2, 24), (3.0, 2, 16), (3.7, 2, 24), (0.02, 3, 30), (8.0, 1, 9), (50.0, 3, 50), (900.0, 2, 16), (20000.0, 2, 16)):
        p = inference.p_of("F", f, above, below)
        eta = inference.eta_squared(inference.Test("F", f, (float(above), float(below)), p))
        assert 0.0 <= eta.low <= eta.value and eta.low <= eta.high < 1.0 and (eta.low > 0.0) == (p < 0.05)

        def end(chance, f=f, above=above, below=below):
            if chance_of_f(f, above, below, 0.0) <= chance:
                return 0.0
            top = 10 * f * above + 50
            noncentrality = optimize.brentq(lambda nc: chance_of_f(f, above, below, nc) - chance, 0.0, top)
            return noncentrality / (noncentrality + above + below + 1)

        assert (eta.low, eta.high) == pytest.approx((end(0.95), end(0.05)), abs=2e-4)


def test_ranks_that_agree():
    same = inference.kendall_w(inference.friedman([[1, 2, 3]] * 5), 5)
    assert same.value == pytest.approx(1.0) and str(same) == "Kendall's W = 1"
    values = np.array([[1, 2, 3, 4], [2, 1, 4, 3], [1, 3, 2, 4], [4, 1, 2, 3]])
    sums = values.sum(0)
    squares = ((sums - sums.mean()) ** 2).sum()
    assert inference.kendall_w(inference.friedman(values), 4).value == pytest.approx(12 * squares / (16 * (64 - 4)), rel=1e-12)
    # W is also (mean rank correlation of pairs of people times (n − 1) + 1)/n.
    rank = np.mean([stats.spearmanr(a, b)[0] for a, b in itertools.combinations(values, 2)])
    assert inference.kendall_w(inference.friedman(values), 4).value == pytest.approx((3 * rank + 1) / 4, rel=1e-12)
    # Kerby's own example of favourable and unfavourable ranks: of 1 … 5 those against are 1 and 2, so r = 12/15 − 3/15.
    assert inference.rank_biserial([0.0, 0, 3, 4, 5], [1.0, 2, 0, 0, 0]).value == pytest.approx(9 / 15)
    assert inference.rank_biserial([1.0, 2, 3], [0.0, 2, 0]).value == 1.0 and inference.rank_biserial([0.0, 2], [1.0, 2]).value == -1.0
    assert inference.rank_biserial([1.0, 2], [1.0, 2]) is None
    a, b = np.random.default_rng(5).integers(1, 8, size=(2, 12))
    w = inference.wilcoxon(a, b).statistic
    kept = int((a != b).sum())
    assert abs(inference.rank_biserial(a, b).value) == pytest.approx(1 - 4 * w / (kept * (kept + 1)), rel=1e-12)


def test_shares_against_chance():
    h = inference.cohen_h(30, 40, 0.5)
    assert h.value == pytest.approx(2 * math.asin(math.sqrt(0.75)) - math.pi / 2, rel=1e-12) and h.value == pytest.approx(math.pi / 6)
    _, low, high = inference.binomial(30, 40, 0.5)
    assert (h.low, h.high) == pytest.approx([2 * math.asin(math.sqrt(s)) - math.pi / 2 for s in (low, high)], rel=1e-12)
    assert inference.cohen_h(40, 40, 0.5).value == pytest.approx(math.pi / 2)


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
    with refusal(HaptogramError):
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
        with refusal(HaptogramError):
            call()
