# SPDX-License-Identifier: Apache-2.0
"""The statistics that studies of touch use, by scipy and statsmodels; and whether printed numbers can be true. Only what those libraries
lack is computed here: the Greenhouse–Geisser factor, the rank-biserial correlation, information in a confusion matrix, lapses in psychometric fits, GRIM."""
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_HALF_UP, Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special, stats
from statsmodels.stats.anova import AnovaRM
from statsmodels.stats.inter_rater import cohens_kappa
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.oneway import confint_noncentrality
from statsmodels.stats.proportion import proportion_effectsize
from statsmodels.stats.weightstats import DescrStatsW

from haptogram.errors import bad_input

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Test:
    """A test's statistic with its degrees of freedom (none, one or two) and its p-value."""

    name: str
    statistic: float
    df: tuple[float, ...]
    p: float

    def __str__(self) -> str:
        df = f"({', '.join(f'{d:g}' if d == round(d) else f'{d:.2f}' for d in self.df)})" if self.df else ""
        return f"{self.name}{df} = {self.statistic:.4g}, p = {self.p:.3g}"


@dataclass(frozen=True)
class Effect:
    """How large an effect is, with its interval at a level of confidence; level 0 has no interval."""

    name: str
    value: float
    low: float = math.nan
    high: float = math.nan
    level: float = 0.0

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.3g}" + (f", {self.level:.0%} interval {self.low:.3g} to {self.high:.3g}".replace("%", " %") if self.level else "")


def _finite(values: ArrayLike, what: str, dimensions: int, least: int) -> Floats:
    array = np.asarray(values, dtype=float)
    if array.ndim != dimensions or array.shape[0] < least or not np.isfinite(array).all():
        raise bad_input(what, f"found an array of shape {array.shape}{'' if np.isfinite(array).all() else ' with values that are no numbers'}, expected "
                        f"{dimensions} dimension(s), at least {least} rows, finite numbers")  # fmt: skip
    return array


# ---------------------------------------------------------------- shares


def binomial(successes: int, trials: int, chance: float) -> tuple[float, float, float]:
    """Two-sided exact p, and the exact 95 % interval of the share (Clopper and Pearson 1934)."""
    found = stats.binomtest(successes, trials, chance)
    interval = found.proportion_ci(0.95, "exact")
    return float(found.pvalue), float(interval.low), float(interval.high)


def cohen_h(successes: int, trials: int, chance: float) -> Effect:
    """A share against chance, as a difference of angles (Cohen 1988); its interval is that of the share."""
    _, low, high = binomial(successes, trials, chance)
    value, low, high = (float(proportion_effectsize(share, chance)) for share in (successes / trials, low, high))
    return Effect("Cohen's h", value, low, high, 0.95)


def chi_squared(table: ArrayLike) -> Test:
    """Pearson's test that the rows of a table of counts have the same shares; no continuity correction."""
    counts = _finite(table, "chi_squared", 2, 2)
    if (counts.sum(0) == 0).any() or (counts.sum(1) == 0).any():
        raise bad_input("chi_squared", "found a row or column of zeros, expected counts in each; leave it out")
    found = stats.chi2_contingency(counts, correction=False)
    return Test("chi2", float(found[0]), (float(found[2]),), float(found[1]))


@dataclass(frozen=True)
class Confusion:
    """What a confusion matrix of counts says; a row for what was shown, a column for what was answered."""

    share: float  # right answers over all
    rates: tuple[float, ...]  # for each row
    kappa: float  # Cohen's
    bits: float  # information about what was shown, of at most log2(rows)
    homogeneity: Test  # of the rows' rates


def confusion(counts: ArrayLike) -> Confusion:
    """Of a square matrix of counts."""
    matrix = _finite(counts, "confusion", 2, 2)
    if matrix.shape[0] != matrix.shape[1] or (matrix < 0).any() or (matrix.sum(1) == 0).any():
        raise bad_input("confusion", f"found a matrix of shape {matrix.shape}, expected a square one of counts, none negative, no empty row")
    shown, right = matrix.sum(1), np.diag(matrix)
    together = matrix / matrix.sum()
    bits = stats.entropy(together.sum(0), base=2) + stats.entropy(together.sum(1), base=2) - stats.entropy(together.ravel(), base=2)
    even = right.sum() in (0.0, matrix.sum())
    homogeneity = Test("chi2", 0.0, (len(matrix) - 1.0,), 1.0) if even else chi_squared(np.stack([right, shown - right]).T)
    kappa = float(cohens_kappa(matrix, return_results=False))
    return Confusion(float(right.sum() / matrix.sum()), tuple(map(float, right / shown)), kappa, float(bits), homogeneity)


# ---------------------------------------------------------------- means


def paired_t(first: ArrayLike, second: ArrayLike) -> Test:
    """Student's test of the differences of pairs, two-sided. Without scatter, but for that of rounding, there is no t: it is not a number."""
    a, b = _finite(first, "paired_t", 1, 2), _finite(second, "paired_t", 1, 2)
    if np.ptp(a - b) <= 1e-12 * max(abs(a).max(), abs(b).max()):
        return Test("t", math.nan, (len(a) - 1.0,), math.nan)
    found = stats.ttest_rel(a, b)
    return Test("t", float(found.statistic), (len(a) - 1.0,), float(found.pvalue))


LARGE_T, LARGE_NONCENTRALITY = 1000.0, 9999.0  # beyond these the library's distributions are not exact, and the limit below is


def paired_effects(first: ArrayLike, second: ArrayLike) -> tuple[Effect, Effect]:
    """The mean difference of pairs, and Cohen's d_z, which is it over the differences' standard deviation. The interval of d_z is that of the
    noncentral t distribution."""
    differences = _finite(first, "paired_effects", 1, 2) - _finite(second, "paired_effects", 1, 2)
    size, df = len(differences), len(differences) - 1.0
    mean, sd = float(differences.mean()), float(differences.std(ddof=1))
    low, high = DescrStatsW(differences).tconfint_mean(0.05)
    d_z = mean / sd if sd else math.nan
    t = abs(d_z) * math.sqrt(size)
    if t < LARGE_T:
        ends = special.nctdtrinc(df, [0.975, 0.025], t)
    else:
        ends = t * np.sqrt(stats.chi2.ppf([0.025, 0.975], df) / df)
    a, b = sorted(math.copysign(1.0, mean) * float(end) / math.sqrt(size) for end in ends)
    return Effect("difference", mean, float(low), float(high), 0.95), Effect("Cohen's d_z", d_z, a, b, 0.95)


def eta_squared(test: Test, name: str = "eta squared") -> Effect:
    """The share of variance that an F test explains; of repeated measures it is the partial one. The interval is at 90 %, by the noncentral F
    distribution and its λ/(λ + df₁ + df₂ + 1): F tests one side, so that it contains 0 where p > 0.05 (Steiger 2004)."""
    f, (above, below) = test.statistic, test.df
    low, high = map(float, confint_noncentrality(f, test.df, alpha=0.1))
    if not high < LARGE_NONCENTRALITY:  # also when it found none
        low, high = (float(above * f * s / below) for s in stats.chi2.ppf([0.05, 0.95], below))
    low, high = 0.0 if test.p >= 0.05 else low, 0.0 if test.p >= 0.95 else high
    return Effect(name, f * above / (f * above + below), *(nc / (nc + above + below + 1.0) for nc in (low, high)), 0.9)


def anova(*groups: ArrayLike) -> Test:
    """One-way analysis of variance of independent groups."""
    arrays = [_finite(g, "anova", 1, 2) for g in groups]
    found = stats.f_oneway(*arrays)
    return Test("F", float(found.statistic), (len(arrays) - 1.0, float(sum(map(len, arrays)) - len(arrays))), float(found.pvalue))


def greenhouse_geisser(values: ArrayLike) -> float:
    """By how much the degrees of freedom shrink because conditions do not vary alike (Greenhouse and Geisser 1959): 1/(k−1) to 1.
    `values` has a row for each person, a column for each of k conditions."""
    array = _finite(values, "greenhouse_geisser", 2, 2)
    size = array.shape[1]
    contrasts = np.linalg.qr(np.column_stack([np.ones(size), np.eye(size)[:, 1:]]))[0][:, 1:]
    covariance = contrasts.T @ np.cov(array, rowvar=False) @ contrasts
    return float(np.trace(covariance) ** 2 / ((size - 1) * np.sum(covariance**2)))


def rm_anova(values: ArrayLike) -> tuple[Test, Test]:
    """One-way analysis of variance by repeated measures, a row for each person; and the same with Greenhouse and Geisser's correction."""
    array = _finite(values, "rm_anova", 2, 2)
    people, conditions = array.shape
    if conditions < 2:
        raise bad_input("rm_anova", f"found {conditions} condition, expected at least two")
    frame = pd.DataFrame(array).rename_axis("person").reset_index().melt("person", var_name="condition")
    row = AnovaRM(frame, "value", "person", within=["condition"]).fit().anova_table.iloc[0]
    df = (float(row["Num DF"]), float(row["Den DF"]))
    factor = greenhouse_geisser(array)
    shrunk = (df[0] * factor, df[1] * factor)
    f = float(row["F Value"])
    return Test("F", f, df, float(row["Pr > F"])), Test("F", f, shrunk, float(stats.f.sf(f, *shrunk)))


def tukey(groups: Sequence[ArrayLike], names: Sequence[str]) -> dict[tuple[str, str], tuple[float, Effect]]:
    """Of each pair of independent groups p and the difference of means, first minus second, with its interval (Tukey's honestly significant
    difference). The intervals hold at once: 95 % is the confidence in all of them."""
    found = stats.tukey_hsd(*(_finite(g, "tukey", 1, 2) for g in groups))
    interval = found.confidence_interval(0.95)
    return {(names[i], names[k]): (float(found.pvalue[i, k]),
                                   Effect("difference", float(found.statistic[i, k]), float(interval.low[i, k]), float(interval.high[i, k]), 0.95))
            for i, k in itertools.combinations(range(len(names)), 2)}  # fmt: skip


def friedman(values: ArrayLike) -> Test:
    """Whether conditions rank alike, a row for each person; the chi-squared approximation, corrected for ties."""
    array = _finite(values, "friedman", 2, 2)
    found = stats.friedmanchisquare(*array.T)
    return Test("chi2", float(found.statistic), (array.shape[1] - 1.0,), float(found.pvalue))


def kendall_w(test: Test, people: int) -> Effect:
    """How much people agree in their ranks, 0 to 1, from Friedman's test."""
    return Effect("Kendall's W", test.statistic / (people * test.df[0]))


def rank_biserial(first: ArrayLike, second: ArrayLike) -> Effect | None:
    """The ranks of the pairs in which the first is larger, less those in which the second is, over all ranks (Kerby 2014): −1 to 1. Equal pairs do
    not count; None when there are no others."""
    differences = _finite(first, "rank_biserial", 1, 1) - _finite(second, "rank_biserial", 1, 1)
    differences = differences[differences != 0.0]
    if not len(differences):
        return None
    ranks = stats.rankdata(abs(differences))
    return Effect("rank-biserial correlation", float((ranks * np.sign(differences)).sum() / ranks.sum()))


def wilcoxon(first: ArrayLike, second: ArrayLike) -> Test:
    """The signed-rank test of pairs, two-sided; equal pairs do not count. Exact for up to 25 different pairs, also when differences tie: all
    2ⁿ signs of the ranks are looked at then. Above that the normal approximation."""
    differences = _finite(first, "wilcoxon", 1, 1) - _finite(second, "wilcoxon", 1, 1)
    differences = differences[differences != 0.0]
    if not len(differences):
        return Test("W", 0.0, (), 1.0)
    ranks = stats.rankdata(abs(differences))
    tied = len(np.unique(ranks)) < len(ranks)
    if len(differences) > 25 or not tied:
        found = stats.wilcoxon(differences, method="approx" if len(differences) > 25 else "exact")
        return Test("W", float(found.statistic), (), float(found.pvalue))
    # Twice the ranks are whole numbers; ways[s] is the number of sign patterns whose positive ranks sum to s.
    doubled = np.rint(2 * ranks).astype(int)
    ways = np.zeros(int(doubled.sum()) + 1)
    ways[0] = 1.0
    for rank in doubled:
        ways[rank:] = ways[rank:] + ways[:-rank]
    plus = int(doubled[differences > 0].sum())
    least = min(plus, int(doubled.sum()) - plus)
    return Test("W", least / 2.0, (), float(min(1.0, 2.0 * ways[: least + 1].sum() / 2.0 ** len(differences))))


def corrected(p: Sequence[float], how: str) -> list[float]:
    """p-values of several tests: `none`, `bonferroni` or `holm`."""
    return list(p) if how == "none" or not p else list(map(float, multipletests(p, method=how)[1]))


# ---------------------------------------------------------------- fits


@dataclass(frozen=True)
class Psychometric:
    """P(yes) = guess + (1 − guess − lapse)·F((level − threshold)/spread) with F the normal (probit) or logistic (logit) distribution."""

    threshold: float
    spread: float
    lapse: float
    log_likelihood: float


def psychometric(levels: ArrayLike, yes: ArrayLike, trials: ArrayLike, *, link: str = "probit", guess: float = 0.0, lapse: float | None = 0.0) -> Psychometric:
    """The most likely parameters; with lapse=None the lapse is fitted, too, between 0 and 0.2."""
    x, k, n = (_finite(v, "psychometric", 1, 2) for v in (levels, yes, trials))
    if not (len(x) == len(k) == len(n)) or (k > n).any() or (k < 0).any() or len(np.unique(x)) < 2:
        raise bad_input("psychometric", "expected as many levels (at least two different ones) as counts, and no more yes than trials")
    distribution = {"probit": stats.norm, "logit": stats.logistic}[link]
    weight = k / n
    if weight.max() == weight.min():
        raise bad_input("psychometric", f"all levels have {weight[0]:.0%} yes; no threshold can be found; ask at lower and at higher levels")

    def minus_log(parameters: Floats) -> float:
        lapsing = lapse if lapse is not None else parameters[2]
        share = guess + (1.0 - guess - lapsing) * distribution.cdf((x - parameters[0]) / np.exp(parameters[1]))
        share = np.clip(share, 1e-12, 1.0 - 1e-12)
        return -float(np.sum(k * np.log(share) + (n - k) * np.log1p(-share)))

    span = float(np.ptp(x))
    bounds = [(x.min() - span, x.max() + span), (math.log(span) - 7.0, math.log(span) + 3.0)] + ([(0.0, 0.2)] if lapse is None else [])
    starts = [np.array([t, math.log(span / s)] + ([0.02] if lapse is None else [])) for t in np.quantile(x, [0.25, 0.5, 0.75]) for s in (3.0, 10.0)]
    best = min((optimize.minimize(minus_log, start, method="L-BFGS-B", bounds=bounds) for start in starts), key=lambda found: float(found.fun))
    best = optimize.minimize(minus_log, best.x, method="Nelder-Mead", bounds=bounds, options={"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000})
    return Psychometric(float(best.x[0]), float(math.exp(best.x[1])), float(lapse if lapse is not None else best.x[2]), -float(best.fun))


def polynomial(x: ArrayLike, y: ArrayLike, degree: int) -> tuple[Floats, float]:
    """Coefficients of the least squares, highest power first, and R²."""
    a, b = _finite(x, "polynomial", 1, degree + 1), _finite(y, "polynomial", 1, degree + 1)
    fitted = np.polynomial.Polynomial.fit(a, b, degree)  # type: ignore[no-untyped-call]
    left = float(np.sum((b - fitted(a)) ** 2))
    return fitted.convert().coef[::-1], 1.0 - left / float(np.sum((b - b.mean()) ** 2))


def normalised(magnitudes: pd.DataFrame, person: str, value: str) -> pd.Series:
    """Free magnitude estimates on one scale: each person's factor is the mean over people of their geometric means, over their own
    (Multimodal, task T2)."""
    if not (magnitudes[value] > 0).all():
        raise bad_input(value, "found a magnitude that is not positive; a geometric mean needs positive ones; leave it out")
    own = magnitudes.groupby(person)[value].agg(lambda v: float(stats.gmean(v)))
    return magnitudes[value] * magnitudes[person].map(own.mean() / own)


# ---------------------------------------------------------------- printed numbers


def p_of(name: str, statistic: float, *df: float) -> float:
    """The p-value of a printed F, t (two-sided) or chi2."""
    if name == "F":
        return float(stats.f.sf(statistic, *df))
    if name == "t":
        return float(2.0 * stats.t.sf(abs(statistic), *df))
    return float(stats.chi2.sf(statistic, *df))


def decimals(printed: str) -> int:
    """Digits behind the point of a number as it was printed."""
    return len(printed.partition(".")[2])


def rounds_to(value: Fraction | float, printed: str) -> bool:
    """Whether a value rounds to what was printed, at its digits; half way may have been rounded either way."""
    half = Fraction(1, 2 * 10 ** decimals(printed))
    slack = Fraction(0) if isinstance(value, Fraction) else Fraction(abs(value)).limit_denominator(10**12) / 10**12
    return abs(Fraction(value) - Fraction(printed)) <= half + slack


def rounded(value: float, digits: int) -> str:
    return str(Decimal(repr(value)).quantize(Decimal(1).scaleb(-digits), ROUND_HALF_UP))


def grim(mean: str, people: int) -> bool:
    """Whether a mean, as printed, can be one of whole numbers of so many people (Brown and Heathers 2017)."""
    nearest = round(Fraction(mean) * people)
    return any(rounds_to(Fraction(total, people), mean) for total in (nearest - 1, nearest, nearest + 1))


def possible_counts(percentages: Sequence[str], people: int) -> bool:
    """Whether percentages, as printed, can be those of so many people, each counted once."""
    ranges = []
    for text in percentages:
        nearest = round(Fraction(text) * people / 100)
        fitting = [c for c in range(max(nearest - 1, 0), nearest + 2) if rounds_to(Fraction(100 * c, people), text)]
        if not fitting:
            return False
        ranges.append((min(fitting), max(fitting)))
    return sum(low for low, _ in ranges) <= people <= sum(high for _, high in ranges)


def fewest_people(percentages: Sequence[str], most: int = 100_000) -> int:
    """The smallest number of people that could have given such percentages."""
    for people in range(1, most + 1):
        if possible_counts(percentages, people):
            return people
    raise bad_input("percentages", f"found {', '.join(percentages)}, which no number of people up to {most} can give")
