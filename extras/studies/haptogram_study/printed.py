# SPDX-License-Identifier: Apache-2.0
"""The numbers that the papers print, each beside what follows from the papers' own data and formulas. printed.toml lists them."""
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from . import inference, tables
from .tables import Table

DATA = Path(__file__).parent / "printed.toml"
FORMAT = "haptogram-printed-1"
AGREES, DIFFERS, POSSIBLE, IMPOSSIBLE, NOT_PRINTED, NO_DATA = "agrees", "differs", "possible", "impossible", "not printed", "no data"
BAD = (DIFFERS, IMPOSSIBLE)


@dataclass(frozen=True)
class Line:
    """A printed number, ours, and the verdict: agrees, differs, possible, impossible, not printed, no data."""

    paper: str
    where: str
    what: str
    printed: str
    ours: str
    unit: str
    verdict: str
    note: str

    def as_json(self) -> dict[str, str]:
        return asdict(self)


Number = float | Fraction
Many = list[tuple[str, str, Number, int]]  # what, printed, number, digits
FORMULAS: dict[str, Callable[..., Number]] = {}  # a number from arguments
POSSIBLE_IF: dict[str, Callable[..., tuple[bool, str]]] = {}  # (printed, arguments): whether it can be, and what limits it
MANY: dict[str, Callable[..., Many]] = {}  # several: (what, printed, number, digits)


def formula(function: Callable[..., Number]) -> Callable[..., Number]:
    FORMULAS[function.__name__] = function
    return function


def condition(function: Callable[..., tuple[bool, str]]) -> Callable[..., tuple[bool, str]]:
    POSSIBLE_IF[function.__name__] = function
    return function


def several(function: Callable[..., Many]) -> Callable[..., Many]:
    MANY[function.__name__] = function
    return function


# ---------------------------------------------------------------- arithmetic


@formula
def value(value: float) -> Number:
    """Another number of the same paper for the same thing."""
    return Fraction(str(value))


@formula
def product(factors: list[float]) -> Number:
    return math.prod(Fraction(str(f)) for f in factors)


@formula
def total(terms: list[float]) -> Number:
    return Fraction(math.fsum(terms)).limit_denominator(10**9)


@formula
def quotient(over: list[float], under: list[float]) -> Number:
    return Fraction(product(over)) / Fraction(product(under))


@formula
def floor_ratio(over: float, under: list[float]) -> Number:
    return math.floor(over / math.prod(under))


# ---------------------------------------------------------------- formulas of the papers


def _distances_mm(rows: int, pitch_mm: float, height_mm: float) -> list[float]:
    places = [(i - (rows - 1) / 2) * pitch_mm for i in range(rows)]
    return [math.dist((x, y, 0.0), (0.0, 0.0, height_mm)) for x in places for y in places]


@formula
def flight_spread_us(rows: int, pitch_mm: float, height_mm: float, speed_m_s: float) -> Number:
    """Haptogram eq. 4, of a square array and a focus on its axis."""
    distances = _distances_mm(rows, pitch_mm, height_mm)
    return 1e3 * (max(distances) - min(distances)) / speed_m_s


@formula
def pulses_to_form(rows: int, pitch_mm: float, height_mm: float, speed_m_s: float, carrier_hz: float) -> Number:
    """Haptogram eq. 11."""
    return math.ceil(carrier_hz * 1e-6 * float(flight_spread_us(rows, pitch_mm, height_mm, speed_m_s)))


@formula
def reflected_percent(skin: float, air: float) -> Number:
    """Hoshi eq. 2: R² of two acoustic impedances, N·s/m³."""
    return 100.0 * ((skin - air) / (skin + air)) ** 2


@formula
def lost_percent(nepers_m: float, path_m: float, frequency_ratio: float) -> Number:
    """Hoshi eq. 3: energy falls as exp(−2βz), and β grows with the square of the frequency."""
    return 100.0 * -math.expm1(-2.0 * nepers_m * frequency_ratio**2 * path_m)


@formula
def focal_diameter_mm(range_mm: float, elements: int, pitch_mm: float, wavelength_mm: float) -> Number:
    """Hoshi 2.2: 4πr/(kNd)."""
    return 2.0 * wavelength_mm * range_mm / (elements * pitch_mm)


@formula
def focal_depth_mm(range_mm: float, elements: int, pitch_mm: float, wavelength_mm: float) -> Number:
    """Hoshi 2.2: 2r·w_f/(Nd)."""
    return 2.0 * range_mm * float(focal_diameter_mm(range_mm, elements, pitch_mm, wavelength_mm)) / (elements * pitch_mm)


@formula
def level_db(pressure_pa: float) -> Number:
    return 20.0 * math.log10(pressure_pa / 20e-6)


@formula
def decibels_ratio(decibels: float) -> Number:
    return math.pow(10.0, decibels / 20.0)


@formula
def cube_edge_mm(volume_mm3: float) -> Number:
    return float(np.cbrt(volume_mm3))


@formula
def sphere_volume(radius_mm: float) -> Number:
    """In 10⁶ mm³."""
    return 4.0 / 3.0 * math.pi * radius_mm**3 / 1e6


@formula
def middle_error(width: float) -> Number:
    """The mean distance of an even draw from the middle of its range."""
    return width / 4.0


@formula
def guess_error(width: float) -> Number:
    """The mean distance of two even draws from the same range."""
    return width / 3.0


# ---------------------------------------------------------------- statistics


@formula
def p(name: str, statistic: float, df: list[float]) -> Number:
    return inference.p_of(name, statistic, *df)


@formula
def statistic_of_p(name: str, p: float, df: list[float]) -> Number:
    return float({"F": stats.f, "chi2": stats.chi2}[name].isf(p, *df))


@formula
def critical(name: str, df: list[float]) -> Number:
    """Above which p < 0.05, two-sided for t."""
    return float(stats.t.isf(0.025, *df)) if name == "t" else statistic_of_p(name, 0.05, df)


@formula
def binomial_p(successes: int, trials: int) -> Number:
    return inference.binomial(successes, trials, 0.5)[0]


@formula
def binomial_low_percent(successes: int, trials: int) -> Number:
    return 100.0 * inference.binomial(successes, trials, 0.5)[1]


@formula
def log2_of_guessing(trials: int, chance: float) -> Number:
    return trials * math.log2(chance)


@formula
def standard_error(sd: float, trials: int) -> Number:
    return sd / math.sqrt(trials)


@formula
def odds_ratio(weighted: float, plain: float) -> Number:
    """Mean weight of the votes on one side over that on the other, from the weighted and the plain percentage."""
    return (weighted / (100.0 - weighted)) / (plain / (100.0 - plain))


@formula
def smallest_wilcoxon(people: int) -> Number:
    """The two-sided p when all differences have the same sign."""
    return inference.wilcoxon(np.arange(1.0, people + 1.0), np.zeros(people)).p


@formula
def fewest(percentages: list[str]) -> Number:
    return inference.fewest_people(percentages)


@condition
def grim(printed: str, people: int) -> tuple[bool, str]:
    nearest = round(Fraction(printed) * people)
    possible = inference.grim(printed, people)
    return possible, f"{nearest}/{people} = {nearest / people:.{inference.decimals(printed) + 1}f}"


@condition
def percentage_of(printed: str, people: int) -> tuple[bool, str]:
    count = round(Fraction(printed) * people / 100)
    fits = any(inference.rounds_to(Fraction(100 * c, people), printed) for c in (count - 1, count, count + 1))
    return fits, f"{count}/{people} = {100 * count / people:.2f}"


@condition
def percentages(printed: str, people: int) -> tuple[bool, str]:
    parts = printed.split()
    return inference.possible_counts(parts, people), f"steps of {100 / people:.2f}"


@condition
def sd_possible(printed: str, mean: float, low: float, high: float, people: int) -> tuple[bool, str]:
    """The largest standard deviation that answers between two ends can have: all of them at the ends."""
    largest = math.sqrt((high - mean) * (mean - low) * people / (people - 1))
    return float(printed) <= largest, f"at most {largest:.2f}"


@condition
def wilcoxon_below(printed: str, people: int, tests: int) -> tuple[bool, str]:
    least = float(smallest_wilcoxon(people)) * tests
    return least < float(printed), f"at least {least:.5f}"


def counts_of(table: dict[str, Any]) -> Any:
    """Whole numbers from printed percentages."""
    counts = np.array([[round(float(cell) * table["trials"] / 100) for cell in row] for row in table["percent"]])
    assert (counts.sum(1) == table["trials"]).all()
    return counts


@several
def confusion_cells(table: dict[str, Any]) -> Many:
    found: Many = []
    for name, row, counts in zip(table["rows"], table["percent"], counts_of(table)):
        for answer, cell, count in zip(table["rows"], row, counts):
            found.append((f"{name} taken for {answer}: {count} of {table['trials']}", cell, Fraction(int(100 * count), table["trials"]), 2))
    return found


@formula
def confusion_share(table: dict[str, Any]) -> Number:
    return 100.0 * inference.confusion(counts_of(table)).share


@formula
def confusion_kappa(table: dict[str, Any]) -> Number:
    return inference.confusion(counts_of(table)).kappa


@formula
def confusion_bits(table: dict[str, Any]) -> Number:
    return inference.confusion(counts_of(table)).bits


@formula
def confusion_chi2(table: dict[str, Any]) -> Number:
    return inference.confusion(counts_of(table)).homogeneity.statistic


@formula
def confusion_p(table: dict[str, Any]) -> Number:
    return inference.confusion(counts_of(table)).homogeneity.p


@several
def magnitude_model(commands: dict[str, list[float]], magnitudes: dict[str, list[float]]) -> Many:
    """Multimodal eq. 10 and 11: where the command is 1, what that feels like, where the magnitude is largest, and where it is 0."""
    found: Many = []
    for hz, (a, b, c, d) in commands.items():
        g, j, v = magnitudes[hz]
        roots = [float(r.real) for r in np.roots([a, b, c, d - 1.0]) if abs(r.imag) < 1e-9]
        full = min(r for r in roots if r > 0.0)
        found += [(f"{hz} Hz: output at the full command, gf", "", full, 4), (f"{hz} Hz: magnitude there", "", g * full**2 + j * full + v, 3),
                  (f"{hz} Hz: output of the largest magnitude, gf", "", -j / (2.0 * g), 3),
                  (f"{hz} Hz: output without sensation, gf", "", float(min(np.roots([g, j, v]).real, key=abs)), 4)]  # fmt: skip
    return found


@several
def threshold_fit(table: dict[str, Any]) -> Many:
    found: Many = []
    for region in ("finger", "palm"):
        middles = np.mean(table[region], axis=1)
        (slope, level), _ = inference.polynomial(np.log(table["force"]), middles, 1)
        found += [(f"{region}: a", "", float(level), 5), (f"{region}: b", "", float(slope), 5)]
    return found


# ---------------------------------------------------------------- the list


def _shown(number: Number, digits: int) -> str:
    return inference.rounded(float(number), digits)


def recompute(path: Path = DATA) -> list[Line]:
    """A line for each printed number. Raises HaptogramError when the file makes no sense."""
    top = tables.load(path)
    if (found := top.text("format")) != FORMAT:
        top.fail("format", found, f"{FORMAT!r}")
    held = top.table("table", None)
    data = held.rest() if held else {}
    lines = [line for entry in top.tables("number", least=1) for line in _lines(entry, data)]
    top.done()
    return lines


def _lines(entry: Table, data: dict[str, Any]) -> list[Line]:
    paper, where, what = entry.text("paper"), entry.text("where"), entry.text("what")
    printed, unit, note = entry.text("printed", ""), entry.text("unit", ""), entry.text("note", "")
    name = entry.text("by", among=[*FORMULAS, *POSSIBLE_IF, *MANY, "no_data"])
    with_table = entry.table("with", None)
    given = with_table.rest() if with_table else {}
    about, digits = entry.number("about", 0.0, above=0.0), entry.whole("digits", None, low=0, high=12)
    entry.done()
    if printed and name not in ("percentages", "no_data"):
        try:
            Fraction(printed)
        except ValueError:
            entry.fail("printed", printed, "the digits of a number")
    for key, item in given.items():
        if isinstance(item, str) and key in ("table", "commands", "magnitudes"):
            if item not in data:
                entry.fail(f"with.{key}", item, f"a table among {', '.join(data)}")
            given[key] = data[item]

    def line(what: str, printed: str, ours: str, verdict: str) -> Line:
        return Line(paper, where, what, printed, ours, unit, verdict, note)

    try:
        if name == "no_data":
            return [line(what, printed, "–", NO_DATA)]
        if name in POSSIBLE_IF:
            possible, limit = POSSIBLE_IF[name](printed, **given)
            return [line(what, printed.replace(" ", ", "), limit, POSSIBLE if possible else IMPOSSIBLE)]
        if name in MANY:
            return [line(more, text, _shown(number, places), _verdict(number, text, about)) for more, text, number, places in MANY[name](**given)]
        number = FORMULAS[name](**given)
    except (TypeError, ValueError, KeyError, ZeroDivisionError) as error:
        entry.fail("with", given, f"the arguments of {name} ({error})")
    verdict = _verdict(number, printed, about)
    places = digits if digits is not None else inference.decimals(printed)
    while verdict == DIFFERS and _shown(number, places) == printed and places < 12:
        places += 1
    return [line(what, printed, _shown(number, places), verdict)]


def _verdict(number: Number, printed: str, about: float) -> str:
    if not printed:
        return NOT_PRINTED
    if about:
        return AGREES if abs(float(number) - float(printed)) <= about * abs(float(printed)) else DIFFERS
    return AGREES if inference.rounds_to(number, printed) else DIFFERS


def with_units(line: Line) -> tuple[str, str]:
    """What is printed and what is ours, as a table shows them."""
    unit = f" {line.unit}" if line.unit else ""
    return tuple(number + unit if number and number != "–" else number or "–" for number in (line.printed, line.ours))  # type: ignore[return-value]


def text(lines: list[Line], differing: bool = False) -> str:
    """For the terminal."""
    found = []
    for paper in dict.fromkeys(line.paper for line in lines):
        found.append(paper)
        for line in (line for line in lines if line.paper == paper and (not differing or line.verdict in BAD)):
            printed, ours = with_units(line)
            found.append(f"  {line.verdict:12} {line.where:18} {line.what}: printed {printed}, ours {ours}" + (f" ({line.note})" if line.note else ""))
    bad = [line for line in lines if line.verdict in BAD]
    return "\n".join([*found, f"{len(lines)} numbers, {len(bad)} of them do not agree or cannot be"])
