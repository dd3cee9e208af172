# SPDX-License-Identifier: Apache-2.0
"""Simulated people, to test runners, analyses and power. What they answer is never a measurement. A model answers one question; its numbers
stand in the protocol under [simulated.QUESTION], or in a file. A number may be a table with a number for each level of the factor `by`."""
import math
import random
from collections.abc import Callable
from pathlib import Path
from statistics import NormalDist
from typing import Any

from haptogram.errors import HaptogramError, ErrorCode, bad_input
from . import protocol as protocols
from . import tables
from .asking import Answer, Occasion
from .design import digest
from .protocol import Protocol, Question, fill, places
from .tables import Table

Model = Callable[[Occasion, random.Random], tuple[Answer, float]]  # the answer, and the seconds that it takes
MODELS = {"psychometric": "yes-no", "confusion": "choice", "preference": "choice", "template": "choice", "matching": "number", "magnitude": "number",
          "lognormal": "number", "rating": "scale", "words": "text"}  # fmt: skip


def felt(level_db: float, threshold_db: float, sd_db: float, lapse: float, guess: float) -> float:
    """The probability of a yes: a cumulative normal distribution between `guess` and 1 − `lapse`."""
    return guess + (1.0 - guess - lapse) * NormalDist(threshold_db, sd_db).cdf(level_db)


def _places(drawing: list[list[list[float]]], step: float = 2.0) -> list[tuple[float, float]]:
    """Points along a drawing's lines, `step` mm apart."""
    found = []
    for line in drawing:
        for (x0, y0), (x1, y1) in zip(line, line[1:]):
            pieces = max(1, round(math.hypot(x1 - x0, y1 - y0) / step))
            found += [(x0 + (x1 - x0) * (i + 0.5) / pieces, y0 + (y1 - y0) * (i + 0.5) / pieces) for i in range(pieces)]
    return found


def likeness(drawings: list[list[list[list[float]]]], blur_mm: float) -> list[list[float]]:
    """How alike drawings are that skin blurs: the correlation of what is left of each after a Gaussian of standard deviation `blur_mm`. Two points
    d apart overlap by exp(−d²/4·blur²). A drawing is a list of lines, a line a list of places in mm."""
    sampled = [_places(drawing) for drawing in drawings]

    def overlap(a: list[tuple[float, float]], b: list[tuple[float, float]]) -> float:
        return sum(math.exp(-((xa - xb) ** 2 + (ya - yb) ** 2) / (4.0 * blur_mm**2)) for xa, ya in a for xb, yb in b)

    own = [overlap(a, a) for a in sampled]
    return [[overlap(a, b) / math.sqrt(own[i] * own[j]) for j, b in enumerate(sampled)] for i, a in enumerate(sampled)]


def _root(matrix: list[list[float]]) -> list[list[float]]:
    """The lower triangle L with L·Lᵀ = matrix (Cholesky). Raises ValueError when two drawings are the same after the blur."""
    root: list[list[float]] = []
    for i, row in enumerate(matrix):
        line: list[float] = []
        for j in range(i + 1):
            rest = row[j] - sum(line[k] * (root[j][k] if j < i else line[k]) for k in range(j))
            if j == i and rest <= 1e-9:
                raise ValueError
            line.append(math.sqrt(rest) if j == i else rest / root[j][j])
        root.append(line)
    return root


class _ByLevel:
    """A number, or one for each level of a factor."""

    def __init__(self, table: Table, key: str, by: str, protocol: Protocol, default: Any = tables.REQUIRED, low: float = -math.inf) -> None:
        self._by, self._one = by, 0.0
        self._values: dict[str, float] = {}
        value = table.any(key, default, "a number, or a table of numbers")
        if isinstance(value, dict):
            if not by:
                table.fail(key, value, "a number, or also `by`, the factor whose levels are meant")
            inner = Table(value, f"{table.where}: {key}")
            self._values = {level.name: inner.number(level.name, low=low) for level in protocol.factor(by).levels}
            inner.done()
        else:
            self._one = Table({key: value}, table.where).number(key, low=low)

    def __call__(self, occasion: Occasion) -> float:
        return self._values[occasion.cell.levels[self._by].name] if self._values else self._one


def _seconds_of(mean: float, sd: float, dice: random.Random) -> float:
    """Log-normal with this mean and standard deviation."""
    spread = math.log1p((sd / mean) ** 2)
    return dice.lognormvariate(math.log(mean) - spread / 2.0, math.sqrt(spread)) if sd else mean


def _person(occasion: Occasion, question: str, sd: float) -> float:
    """How a person differs from the mean, the same in all trials."""
    return random.Random(digest(occasion.seed, occasion.participant, "person", question)).gauss(0.0, sd) if sd else 0.0


def _truth(protocol: Protocol, question: Question, occasion: Occasion) -> float:
    return float(fill(question.truth, places(protocol, occasion.cell.levels, occasion.cell.drawn, occasion.level_db)))


def _model(protocol: Protocol, question: Question, table: Table) -> Model:
    kind = table.text("model", among=[m for m, answers in MODELS.items() if answers == question.kind])
    by = table.text("by", "", among=[f.name for f in protocol.factors])

    def number(key: str, default: Any = tables.REQUIRED, low: float = -math.inf) -> _ByLevel:
        return _ByLevel(table, key, by, protocol, default, low)

    if kind == "psychometric":
        if protocol.staircase is None:
            table.fail("model", kind, "a protocol with a staircase, which has levels")
        threshold, sd = number("threshold_db"), number("sd_db", low=0.01)
        lapse, guess = table.number("lapse", 0.02, low=0.0, high=0.5), table.number("guess", 0.0, low=0.0, high=0.5)

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            assert occasion.level_db is not None
            return dice.random() < felt(occasion.level_db, threshold(occasion), sd(occasion), lapse, guess)

    elif kind == "confusion":
        factor = protocol.factor(table.text("factor", among=[f.name for f in protocol.factors]))
        answers: list[str] = table.list("answers", of=str, expected="the answers, in the order of the columns")
        if sorted(answers) != sorted(question.keys.values()):
            table.fail("answers", answers, f"each of {', '.join(question.keys.values())} once")
        rows_table = table.table("rows")
        rows = {level.name: rows_table.list(level.name, of=(int, float), expected="a row of weights") for level in factor.levels}
        for name, row in rows.items():
            if len(row) != len(answers) or min(row) < 0 or not 0 < sum(row) < math.inf:
                rows_table.fail(name, row, f"{len(answers)} weights, none negative, not all zero")
        rows_table.done()

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            return dice.choices(answers, rows[occasion.cell.levels[factor.name].name])[0]

    elif kind == "template":
        factor = protocol.factor(table.text("factor", among=[f.name for f in protocol.factors]))
        names = [level.name for level in factor.levels]
        if sorted(names) != sorted(question.keys.values()):
            table.fail("factor", factor.name, f"one whose levels are the answers, {', '.join(question.keys.values())}")
        inner, blur, snr = table.table("drawings"), table.number("blur_mm", 8.5, above=0.0), table.number("snr", low=0.0)
        expected = "lines of at least two places [x, y], mm"
        drawings = [inner.list(name, of=list, expected=expected) for name in names]
        inner.done()
        for name, drawing in zip(names, drawings):
            for line in drawing:
                if len(line) < 2 or not all(isinstance(p, list) and len(p) == 2 and all(isinstance(x, (int, float)) and math.isfinite(x) for x in p) for p in line):
                    inner.fail(name, line, expected)
        alike = likeness(drawings, blur)
        try:
            noise = _root(alike)
        except ValueError:
            inner.fail(names[0], drawings[0], f"drawings that differ after a blur of {blur:g} mm")

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            # Each drawing is compared with what is felt, which has white noise; the noise of two comparisons is alike as the drawings are.
            true = names.index(occasion.cell.levels[factor.name].name)
            white = [dice.gauss(0.0, 1.0) for _ in names]
            scores = [snr * alike[true][k] + sum(a * b for a, b in zip(noise[k], white)) for k in range(len(names))]
            return names[scores.index(max(scores))]

    elif kind == "preference":
        weights_table = table.table("weights")
        weights = {meaning: _ByLevel(weights_table, meaning, by, protocol, low=0.0) for meaning in question.keys.values()}
        weights_table.done()

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            return dice.choices(list(weights), [w(occasion) for w in weights.values()])[0]

    elif kind == "matching":
        if not question.truth:
            table.fail("model", kind, "a question with a `truth`")
        sd, bias, centre, step = number("sd", low=0.0), number("bias", 0.0, low=0.0), table.number("centre", 0.0), table.number("step", 0.0, above=0.0)

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            truth = _truth(protocol, question, occasion)
            value: float = truth + bias(occasion) * (centre - truth) + dice.gauss(0.0, sd(occasion))
            value = min(max(value, question.low), question.high)  # as the keys that change the value stop at its ends
            return round(value / step) * step if step else value

    elif kind == "magnitude":
        frequency, output = (table.text(key, among=[f.name for f in protocol.factors]) for key in ("frequency", "output"))
        inner, log_sd, person = table.table("polynomials"), table.number("log_sd", low=0.0), table.number("person_log_sd", 0.0, low=0.0)
        polynomials = {level.name: inner.list(level.name, of=(int, float), least=3, expected="G, J and V of eq. 10") for level in protocol.factor(frequency).levels}
        inner.done()

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            g, j, v = polynomials[occasion.cell.levels[frequency].name]
            force = float(occasion.cell.levels[output].value)
            mean: float = g * force**2 + j * force + v
            if mean <= 0.0:
                raise bad_input(f"{protocol.path}: simulated.{question.name}", f"the magnitude of {force:g} gf is {mean:g}; expected > 0; choose outputs that are felt")
            return mean * math.exp(dice.gauss(0.0, log_sd) + _person(occasion, question.name, person))

    elif kind == "lognormal":
        mean, sd, person = number("mean", low=1e-9), number("sd", low=0.0), table.number("person_log_sd", 0.0, low=0.0)

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            return _seconds_of(mean(occasion), sd(occasion), dice) * math.exp(_person(occasion, question.name, person))

    elif kind == "rating":
        mean, sd, person = number("mean"), number("sd", low=0.0), table.number("person_sd", 0.0, low=0.0)

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            wanted = mean(occasion) + _person(occasion, question.name, person) + dice.gauss(0.0, sd(occasion))
            return round(min(max(wanted, question.low), question.high))  # a scale ends there

    else:

        def answer(occasion: Occasion, dice: random.Random) -> Answer:
            return "simulated"

    seconds = table.list("seconds", [1.0, 0.0], of=(int, float), least=2, expected="mean and standard deviation, s")
    if len(seconds) != 2 or seconds[0] <= 0 or seconds[1] < 0:
        table.fail("seconds", seconds, "a mean > 0 and a standard deviation >= 0")
    table.done()

    mean_s, sd_s = seconds
    return lambda occasion, dice: (answer(occasion, dice), _seconds_of(mean_s, sd_s, dice))


def read_models(protocol: Protocol, given: dict[str, Any], where: str) -> dict[str, Model]:
    """A model a question. Raises HaptogramError when one is missing or makes no sense."""
    top = Table(given, where)
    models = {q.name: _model(protocol, q, top.table(q.name)) for q in protocol.questions}
    top.done()
    return models


def read_protocol(path: Path) -> Protocol:
    """A protocol whose models of simulated people make sense, too."""
    protocol = protocols.read(path)
    if protocol.simulated:
        read_models(protocol, protocol.simulated, f"{path}: simulated")
    return protocol


def _guess(question: Question) -> Model:
    def answer(_: Occasion, dice: random.Random) -> Answer:
        if question.kind == "yes-no":
            return dice.random() < 0.5
        if question.kind == "choice":
            return dice.choice(list(question.keys.values()))
        if question.kind == "text":
            return "simulated"
        if math.isinf(question.low) or math.isinf(question.high):
            raise bad_input(f"simulated:chance: {question.name}", "has no limits between which to guess; expected `from` and `to`; add them")
        return dice.randint(int(question.low), int(question.high)) if question.whole else dice.uniform(question.low, question.high)

    return lambda occasion, dice: (answer(occasion, dice), 1.0)


class Silent:
    """One who answers at once, reproducibly, and needs to be told nothing: all follows from seed, participant and trial."""

    waits = False

    def tell(self, text: str) -> None:
        pass

    def ready(self, occasion: Occasion, presented: str) -> None:
        pass

    def rest(self, seconds: float) -> None:
        pass


class Simulated(Silent):
    """Answers by models."""

    def __init__(self, name: str, models: dict[str, Model]) -> None:
        self.name, self._models = name, models

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        dice = random.Random(digest(occasion.seed, occasion.participant, "answer", question.name, *occasion.key))
        value, seconds = self._models[question.name](occasion, dice)
        return (None, question.limit_s) if question.limit_s and seconds > question.limit_s else (value, seconds)


def simulated(protocol: Protocol, name: str) -> Simulated:
    """`simulated:protocol`, with the protocol's own models, `simulated:chance`, which guesses, or `simulated:FILE.toml`."""
    kind, _, which = name.partition(":")
    if kind != "simulated" or not which:
        raise HaptogramError(ErrorCode.USAGE, "--observer", f"found {name!r}, expected keyboard, page, simulated:protocol, simulated:chance or simulated:FILE.toml")
    if which == "chance":
        return Simulated(name, {q.name: _guess(q) for q in protocol.questions})
    if which == "protocol":
        if not protocol.simulated:
            raise bad_input(str(protocol.path), "has no [simulated] models; use simulated:chance or a file")
        return Simulated(name, read_models(protocol, protocol.simulated, f"{protocol.path}: simulated"))
    return Simulated(name, read_models(protocol, tables.load(Path(which)).rest(), which))
