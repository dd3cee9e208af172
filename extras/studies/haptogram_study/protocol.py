# SPDX-License-Identifier: Apache-2.0
"""A protocol says what a study does: factors and orders, stimuli, questions, rests, staircases, and how its answers are analysed. It is a
TOML file; README.md describes its keys. The reader is strict: a message names file and key, what was found and what was expected."""
import contextlib
import hashlib
import itertools
import json
import math
import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from haptogram.errors import HaptogramError, bad_input
from . import tables
from .staircase import Rule
from .tables import Table

FORMAT = "haptogram-protocol-1"
SHIPPED = Path(__file__).parent / "protocols"
CLAIM = re.compile(rb'^\s*format\s*=\s*"haptogram-protocol-', re.MULTILINE)
NAME = re.compile(r"[a-z][a-z0-9_]*")
PLACEHOLDER = re.compile(r"\{([^{}]*)\}")
TERM = re.compile(r"(.+?)(?:\*(\d+(?:\.\d+)?))?([+-]\d+(?:\.\d+)?)?")  # of a number: {edge_mm*0.5+100}
RUNNERS = {"compile": ("-o", "--output", "--manifest", "--json", "--path", "--save-path", "--readmemh"),
           "movement": ("-o", "--output", "--json", "--array", "--board"),
           "live": ("--from", "--port", "--baud", "--settings", "--json")}  # options that the runner adds
ORDERS = ("fixed", "random", "latin-square")
WITHIN = (*ORDERS, "independent")
KINDS = ("choice", "yes-no", "scale", "number", "text")
TESTS = ("binomial", "confusion", "mean", "paired-t", "rm-anova", "anova", "friedman", "wilcoxon", "votes", "thresholds", "psychometric", "magnitudes")
MOST_TRIALS = 10_000
SET = "set"  # by this analyses go by a block's repeated sets, as by a factor
RESERVED = ("participant", "kind", "trial", SET, "level_db", "threshold_db", "start", "state")  # what results are told apart by
Value = str | float | int


@dataclass(frozen=True)
class Level:
    """One value of a factor; `more` holds what else is known of it, for placeholders such as {target.x_mm}."""

    value: Value
    more: dict[str, Value] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return str(self.value)


@dataclass(frozen=True)
class Factor:
    name: str
    levels: tuple[Level, ...]


@dataclass(frozen=True)
class Drawn:
    """A number that each trial draws anew: evenly from `low` to `high`, in steps when `step` is not 0, otherwise to a thousandth."""

    name: str
    low: float
    high: float
    step: float

    def at(self, chance: float) -> float:
        """The value for a number in [0, 1)."""
        if not self.step:
            return round(self.low + chance * (self.high - self.low), 3)
        return self.low + self.step * int(chance * (round((self.high - self.low) / self.step) + 1))


@dataclass(frozen=True)
class Lookup:
    """A number that depends on two factors: a row for each level of one, a column for each level of the other."""

    name: str
    row: str
    column: str
    values: dict[tuple[str, str], float]


@dataclass(frozen=True)
class Fitted:
    """A number that the board decides: the first of `values` with which it takes every stimulus."""

    name: str
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Order:
    blocked: tuple[str, ...]  # factors whose levels come one after the other
    blocks: str  # how those are ordered
    within: str  # how the trials of a set are ordered
    sets: int  # in each block
    repetitions: int  # of each combination, in each set


@dataclass(frozen=True)
class PathPlan:
    """A focus that moves along straight lines at a steady speed; numbers may be placeholders. Millimetres, seconds. With `square_hz` it is on
    and off for half a period each, and stands still for a period, or for as many as it takes to go `step_mm`."""

    waypoints_mm: tuple[tuple[Value, Value, Value], ...]
    speed_mm_s: float
    step_mm: Value
    hold_s: float  # at the last waypoint
    intensity: Value
    square_hz: Value  # 0: always on


@dataclass(frozen=True)
class Stimulus:
    text: str
    compile: tuple[str, ...]  # arguments of `haptogram compile`; none: it is live, or another apparatus presents it
    live: tuple[tuple[str, ...], ...]  # arguments of `haptogram live`, for a tracked hand; of each array, when several stand side by side
    path: PathPlan | None
    movement: tuple[str, ...]  # arguments of `haptogram movement`, whose path is compiled
    array: str


@dataclass(frozen=True)
class Question:
    name: str
    text: str
    kind: str
    when: str  # "trial" or "end"
    each: str  # an end question is asked for each level of this factor; "" once
    keys: dict[str, str]  # of a choice: what is typed, and what it means
    low: float
    high: float
    whole: bool
    correct: str  # of a choice: placeholder of the right answer
    truth: str  # of a number: placeholder of the right one
    limit_s: float  # 0: none


@dataclass(frozen=True)
class Rest:
    after_trial_s: float = 0.0
    every_s: float = 0.0
    for_s: float = 0.0
    between_blocks_s: float = 0.0


@dataclass(frozen=True)
class Analysis:
    name: str
    test: str
    of: str
    by: str
    correction: str
    chance: float
    weight: str  # of a binomial: the question that weights its answers
    where: dict[str, Value]
    paper: str  # what the paper says of it


@dataclass(frozen=True)
class Protocol:
    path: Path
    sha256: str
    name: str
    title: str
    source: str
    participants: int
    instructions: tuple[str, ...]
    choices: tuple[str, ...]  # what the paper leaves open, and what was chosen here
    factors: tuple[Factor, ...]
    drawn: tuple[Drawn, ...]
    lookups: tuple[Lookup, ...]
    fitted: tuple[Fitted, ...]
    order: Order
    stimulus: Stimulus
    questions: tuple[Question, ...]
    rest: Rest
    staircase: Rule | None
    analyses: tuple[Analysis, ...]
    simulated: dict[str, Any]

    def factor(self, name: str) -> Factor:
        return next(f for f in self.factors if f.name == name)

    def question(self, name: str) -> Question:
        return next(q for q in self.questions if q.name == name)

    def fits(self) -> list[dict[str, Value]]:
        """What fitted numbers may be, the preferred first."""
        return [dict(zip((f.name for f in self.fitted), chosen)) for chosen in itertools.product(*(f.values for f in self.fitted))]

    def levels(self, name: str) -> tuple[Value, ...]:
        """The values of a factor, or the numbers of the sets."""
        return _levels(name, {f.name: f for f in self.factors}, self.order)

    @property
    def trials(self) -> int:
        """Of one participant; with a staircase, its runs."""
        return math.prod(len(f.levels) for f in self.factors) * self.order.sets * self.order.repetitions


def _levels(name: str, factors: Mapping[str, Factor], order: Order) -> tuple[Value, ...]:
    return tuple(range(1, order.sets + 1)) if name == SET else tuple(level.value for level in factors[name].levels)


def shipped() -> dict[str, Path]:
    """The protocols of the package, by name."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def _beginning(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(tables.LARGEST_FILE)


def in_folder(folder: Path) -> dict[str, Path]:
    """The files of a folder that say that they are protocols, by name; whether they make sense, read() says."""
    found = {}
    for path in sorted(folder.glob("*.toml")):
        with contextlib.suppress(OSError):
            # A pipe or a device would keep us waiting.
            if path.is_file() and CLAIM.search(_beginning(path)):
                found[path.name] = path
    return found


def find(name: str) -> Path:
    """A file's path, or the name of a shipped protocol."""
    if name in shipped():
        return shipped()[name]
    path = Path(name)
    if not path.exists() and path.suffix != ".toml":
        raise bad_input(name, f"is neither a file nor a shipped protocol; those are {', '.join(shipped())}")
    return path


def _term(place: str) -> tuple[str, float, float]:
    """What stands in a placeholder: a name, and by how much its number is multiplied and made larger."""
    match = TERM.fullmatch(place)
    return (match[1], float(match[2] or 1.0), float(match[3] or 0.0)) if match else (place, 1.0, 0.0)


def names_in(text: str, known: Container[str]) -> list[str]:
    """The names of a text's placeholders."""
    return [place if place in known else _term(place)[0] for place in PLACEHOLDER.findall(text)]


def fill(text: str, values: Mapping[str, object]) -> str:
    """The text with each {placeholder} replaced."""

    def value(match: re.Match[str]) -> str:
        if match[1] in values:
            return str(values[match[1]])
        name, factor, more = _term(match[1])
        return repr(round(float(str(values[name])) * factor + more, 9))

    return PLACEHOLDER.sub(value, text)


def places(protocol: Protocol, levels: Mapping[str, Level], drawn: Mapping[str, float], level_db: float | None = None) -> dict[str, object]:
    """What placeholders stand for in a trial."""
    values: dict[str, object] = {}
    for name, level in levels.items():
        values[name] = level.value
        values |= {f"{name}.{key}": value for key, value in level.more.items()}
    values |= {name: repr(value) for name, value in drawn.items()}
    for look in protocol.lookups:
        if look.row in levels and look.column in levels:
            values[look.name] = repr(look.values[levels[look.row].name, levels[look.column].name])
    if level_db is not None:
        values |= {"level.db": repr(level_db), "level.amplitude": repr(10.0 ** (level_db / 20.0))}
    return values


def read(path: Path) -> Protocol:
    """Raises HaptogramError when it is no protocol, or makes no sense; of its [simulated] models, observers.read_protocol() does."""
    top = tables.load(path)
    return _read(top, path, hashlib.sha256(path.read_bytes()).hexdigest())


def _read(top: Table, path: Path, sha256: str) -> Protocol:
    if (found := top.text("format")) != FORMAT:
        top.fail("format", found, f"{FORMAT!r}")
    name, title, source = top.text("name"), top.text("title"), top.text("source")
    participants = top.whole("participants", low=1)
    texts = {key: tuple(top.list(key, [], of=str, expected="a list of texts")) for key in ("instructions", "choices")}
    factors = tuple(_factor(t) for t in top.tables("factor"))
    drawn = tuple(_drawn(t) for t in top.tables("drawn"))
    lookups = tuple(_lookup(t, factors) for t in top.tables("lookup"))
    fitted = tuple(_fitted(t) for t in top.tables("fitted"))
    _different(top, "factor", [f.name for f in (*factors, *drawn, *lookups, *fitted)])
    staircase_table = top.table("staircase", None)
    known = _placeholders(factors, drawn, lookups, staircase_table is not None)
    order = _order(top.table("order"), factors)
    stimulus = _stimulus(top.table("stimulus"), known | {f.name for f in fitted})
    if fitted and not stimulus.compile:
        top.fail("fitted", fitted[0].name, "none without `compile`: what is live has nothing to fit")
    questions = tuple(_question(t, factors, known) for t in top.tables("question", least=1))
    _different(top, "question", [q.name for q in questions])
    staircase = _staircase(staircase_table, questions) if staircase_table else None
    rest_table = top.table("rest", None)
    rest = _rest(rest_table) if rest_table else Rest()
    analyses = tuple(_analysis(t, factors, order, questions, staircase) for t in top.tables("analysis"))
    simulated_table = top.table("simulated", None)
    simulated = simulated_table.rest() if simulated_table else {}
    top.done()
    protocol = Protocol(path, sha256, name, title, source, participants, texts["instructions"], texts["choices"], factors, drawn, lookups, fitted, order,
                        stimulus, questions, rest, staircase, analyses, simulated)  # fmt: skip
    if protocol.trials > MOST_TRIALS:
        raise bad_input(f"{path}: order", f"makes {protocol.trials} trials a participant, expected at most {MOST_TRIALS}; ask for fewer")
    return protocol


def _identifier(table: Table) -> str:
    name: str = table.text("name")
    if not NAME.fullmatch(name):
        table.fail("name", name, "small letters, digits and _, beginning with a letter")
    if name in RESERVED:
        table.fail("name", name, f"another name than {', '.join(RESERVED)}, which results have of their own")
    return name


def _different(table: Table, key: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            table.fail(key, name, "a name only once")


def _factor(table: Table) -> Factor:
    name = _identifier(table)
    levels = []
    for given in table.list("levels", of=(str, int, float, dict), expected="a list of texts, numbers or tables {name = …}"):
        if isinstance(given, dict):
            more = dict(given)
            value = more.pop("name", None)
            for key, item in more.items():
                if not NAME.fullmatch(key) or isinstance(item, bool) or not isinstance(item, (str, int, float)):
                    table.fail(f"levels.{key}", item, "a text or a number under a name of small letters")
        else:
            more, value = {}, given
        if isinstance(value, bool) or not isinstance(value, (str, int, float)) or value == "" or (isinstance(value, float) and not math.isfinite(value)):
            table.fail("levels", value, "texts, numbers, or tables with a name")
        levels.append(Level(value, more))
    _different(table, "levels", [level.name for level in levels])
    for level in levels:
        if level.more.keys() != levels[0].more.keys():
            table.fail("levels", level.name, f"the same keys at each level: {', '.join(levels[0].more) or 'none'}")
    table.done()
    return Factor(name, tuple(levels))


def _drawn(table: Table) -> Drawn:
    name = _identifier(table)
    low, high, step = table.number("from"), table.number("to"), table.number("step", 0.0, above=0.0)
    if not low < high:
        table.fail("to", high, f"a number > {low:g}")
    if step and abs((high - low) / step - round((high - low) / step)) > 1e-9:
        table.fail("step", step, f"a step that divides {high - low:g}")
    table.done()
    return Drawn(name, low, high, step)


def _lookup(table: Table, factors: tuple[Factor, ...]) -> Lookup:
    names = {f.name: f for f in factors}
    name = _identifier(table)
    row, column = table.text("row", among=list(names)), table.text("column", among=list(names))
    inner, columns_of = table.table("values"), names[column].levels
    values: dict[tuple[str, str], float] = {}
    for level in names[row].levels:
        numbers = inner.list(level.name, of=(int, float), expected=f"{len(columns_of)} numbers, one for each {column}")
        if len(numbers) != len(columns_of) or not all(map(math.isfinite, numbers)):
            inner.fail(level.name, numbers, f"{len(columns_of)} numbers, one for each {column}")
        values |= {(level.name, other.name): float(number) for other, number in zip(columns_of, numbers)}
    inner.done()
    table.done()
    return Lookup(name, row, column, values)


def _fitted(table: Table) -> Fitted:
    name = _identifier(table)
    values = tuple(table.list("values", of=(int, float), expected="a list of numbers, the preferred one first"))
    _different(table, "values", [str(value) for value in values])
    table.done()
    return Fitted(name, values)


def _order(table: Table, factors: tuple[Factor, ...]) -> Order:
    names = [f.name for f in factors]
    blocked = tuple(table.list("blocked", [], of=str, expected="a list of factors"))
    for name in blocked:
        if name not in names or blocked.count(name) > 1:
            table.fail("blocked", name, f"factors, each once, among {', '.join(names) or 'none'}")
    if not blocked and "blocks" in table:
        table.fail("blocks", table.text("blocks"), "no order of blocks without blocked factors")
    blocks = table.text("blocks", among=ORDERS) if blocked else "fixed"
    order = Order(blocked, blocks, table.text("within", among=WITHIN), table.whole("sets", 1, low=1), table.whole("repetitions", 1, low=1))
    table.done()
    return order


def _placeholders(factors: tuple[Factor, ...], drawn: tuple[Drawn, ...], lookups: tuple[Lookup, ...], staircase: bool) -> set[str]:
    known = {d.name for d in drawn} | {k.name for k in lookups} | ({"level.db", "level.amplitude"} if staircase else set())
    for factor in factors:
        known |= {factor.name} | {f"{factor.name}.{key}" for level in factor.levels for key in level.more}
    return known


def _checked(table: Table, key: str, text: str, known: set[str]) -> str:
    for found in names_in(text, known):
        if found not in known:
            table.fail(key, "{" + found + "}", f"a placeholder among {', '.join(sorted(known)) or 'none'}")
    return text


def _coordinate(table: Table, key: str, value: object, known: set[str]) -> Value:
    if isinstance(value, str) and PLACEHOLDER.fullmatch(value):
        return _checked(table, key, value, known)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        table.fail(key, value, "a number or a {placeholder}")
    return float(value)


def _arguments(table: Table, command: str, words: Sequence[object], known: set[str]) -> tuple[str, ...]:
    found = []
    for word in words:
        if not isinstance(word, str):
            table.fail(command, word, f"a list of arguments of 'haptogram {command}'")
        found.append(_checked(table, command, word, known))
        if word.split("=")[0] in RUNNERS[command]:
            table.fail(command, word, f"none of {', '.join(RUNNERS[command])}: the runner adds what it needs of them")
    return tuple(found)


def _sessions(table: Table, known: set[str]) -> tuple[tuple[str, ...], ...]:
    """The arguments of `live`: a list, or a list of such lists, one for each array."""
    given = table.list("live", [], of=(str, list), expected="a list of arguments of 'haptogram live', or such a list for each array")
    several = bool(given) and isinstance(given[0], list)
    return tuple(_arguments(table, "live", words, known) for words in (given if several else [given] if given else []))


def _stimulus(table: Table, known: set[str]) -> Stimulus:
    text = _checked(table, "text", table.text("text"), known)
    words = _arguments(table, "compile", table.list("compile", [], of=str, expected="a list of arguments of 'haptogram compile'"), known)
    live = _sessions(table, known)
    if words and live:
        table.fail("live", live, "either `compile` or `live`")
    path_table = table.table("path", None)
    path = None
    if path_table is not None:
        points = path_table.list("waypoints_mm", of=list, expected="a list of points [x, y, z]")
        for point in points:
            if len(point) != 3:
                path_table.fail("waypoints_mm", point, "points [x, y, z]")
        waypoints = tuple(tuple(_coordinate(path_table, "waypoints_mm", v, known) for v in p) for p in points)
        speed = path_table.number("speed_mm_s", 0.0 if len(points) == 1 else tables.REQUIRED, above=0.0)
        path = PathPlan(waypoints, speed, _coordinate(path_table, "step_mm", path_table.any("step_mm", 0.0), known), path_table.number("hold_s", 0.0, low=0.0, high=600.0),  # type: ignore[arg-type]
                        _coordinate(path_table, "intensity", path_table.any("intensity", 1.0), known),
                        _coordinate(path_table, "square_hz", path_table.any("square_hz", 0.0), known))  # fmt: skip
        if len(points) == 1 and not path.hold_s:
            path_table.fail("hold_s", path.hold_s, "how long the single point is held, s > 0")
        path_table.done()
    movement = _arguments(table, "movement", table.list("movement", [], of=str, expected="a list of arguments of 'haptogram movement'"), known)
    for key, given in (("path", path), ("movement", movement)):
        if given and not words:
            table.fail(key, key, "also `compile`, the arguments that play it")
    if path and movement:
        table.fail("movement", movement, "either `path` or `movement`")
    array = table.text("array", "")
    table.done()
    if array and live:
        table.fail("array", array, "no array beside `live`; give it there, as --array")
    return Stimulus(text, words, live, path, movement, array)


def _question(table: Table, factors: tuple[Factor, ...], known: set[str]) -> Question:
    name, text, kind = _identifier(table), table.text("text"), table.text("kind", among=KINDS)
    when = table.text("when", "trial", among=("trial", "end"))
    each = table.text("each", "", among=[f.name for f in factors]) if when == "end" else ""
    keys: dict[str, str] = {}
    low, high, whole, correct, truth = -math.inf, math.inf, False, "", ""
    if kind == "choice":
        keys_table = table.table("keys")
        for key in keys_table:
            keys[key] = keys_table.text(key)
        if len(keys) < 2 or len(set(keys.values())) != len(keys):
            table.fail("keys", keys, "at least two keys with different meanings")
        correct = _checked(table, "correct", table.text("correct", ""), known)
        for factor in factors:
            for level in factor.levels:
                if correct == "{" + factor.name + "}" and level.name not in keys.values():
                    table.fail("keys", level.name, "a key for each level of the factor that is asked for")
    elif kind == "yes-no":
        keys = {"y": "yes", "n": "no"}
    elif kind == "scale":
        low, high, whole = table.whole("from", low=-1000), table.whole("to", low=-1000), True
        if not low < high:
            table.fail("to", high, f"a whole number > {low}")
    elif kind == "number":
        low, high = table.number("from", -math.inf), table.number("to", math.inf)
        if not low < high:
            table.fail("to", high, f"a number > {low:g}")
        truth = _checked(table, "truth", table.text("truth", ""), known)
    limit = table.number("limit_s", 0.0, above=0.0) if when == "trial" else 0.0
    table.done()
    return Question(name, text, kind, when, each, keys, low, high, whole, correct, truth, limit)


def _staircase(table: Table, questions: tuple[Question, ...]) -> Rule:
    asked = [q.name for q in questions if q.kind == "yes-no" and q.when == "trial"]
    question = table.text("question", among=asked)
    if [q.name for q in questions if q.when == "trial"] != [question]:
        table.fail("question", question, "the only question of a trial")
    if any(q.limit_s for q in questions if q.name == question):
        table.fail("question", question, "a question without limit_s, because a staircase needs every answer")
    lowest, highest = table.number("lowest_db", high=0.0), table.number("highest_db", high=0.0)
    if not lowest < highest:
        table.fail("highest_db", highest, f"a number > {lowest:g}")
    starts_table = table.table("starts_db")
    starts = {name: starts_table.number(name, low=lowest, high=highest) for name in starts_table}
    if not starts:
        table.fail("starts_db", {}, "at least one named level in dB")
    first_reversals = table.whole("first_reversals", low=0)
    rule = Rule(question, starts, lowest, highest, table.number("first_step_db", above=0.0), table.number("step_db", above=0.0), first_reversals,
                table.whole("reversals", low=first_reversals + 1), table.whole("most_answers", 200, low=10), table.whole("most_at_limit", 5, low=1))  # fmt: skip
    table.done()
    return rule


def _rest(table: Table) -> Rest:
    rest = Rest(**{key: table.number(key, 0.0, above=0.0) for key in ("after_trial_s", "every_s", "for_s", "between_blocks_s")})
    if bool(rest.every_s) != bool(rest.for_s):
        table.fail("for_s" if rest.every_s else "every_s", 0, "both every_s and for_s")
    table.done()
    return rest


def columns(factors: tuple[Factor, ...], questions: tuple[Question, ...], staircase: Rule | None) -> dict[str, str]:
    """What analyses can be of: the column and what it holds (`number`, `answer`, `correct`)."""
    found = {"threshold_db": "number"} if staircase else {}
    for q in questions:
        found[q.name] = "number" if q.kind in ("scale", "number") else "answer"
        if q.when == "trial":
            found[f"{q.name}.seconds"] = "number"
        if q.correct:
            found[f"{q.name}.correct"] = "correct"
            if q.when == "trial":
                found[f"{q.name}.seconds_of_correct"] = "number"
        if q.truth:
            found |= {f"{q.name}.error": "number", f"{q.name}.absolute_error": "number"}
        if staircase and q.name == staircase.question:
            found[q.name] = "levels"
    return found


MEANS = ("paired-t", "rm-anova", "anova", "friedman", "wilcoxon")  # of each person's means at the levels of `by`; of right answers that is their share
NEEDS = {"binomial": ("correct",), "confusion": ("answer",), "votes": ("answer",), "psychometric": ("levels",)} | dict.fromkeys(MEANS, ("number", "correct"))


def _analysis(table: Table, factors: tuple[Factor, ...], order: Order, questions: tuple[Question, ...], staircase: Rule | None) -> Analysis:
    names = {f.name: f for f in factors}
    name, test = table.text("name"), table.text("test", among=TESTS)
    held = columns(factors, questions, staircase)
    fitting = [column for column, kind in held.items() if kind in NEEDS.get(test, ("number",))]
    of = table.text("of", among=fitting)
    question = next((q for q in questions if q.name == of.split(".")[0]), None)
    has_sets = order.sets > 1 and not (question and question.when == "end")  # a question at the end is of no set
    needs_factor = test in ("confusion", "magnitudes", "thresholds", "psychometric", *MEANS)
    by = table.text("by", among=[*names, *([SET] if has_sets and test not in ("confusion", "magnitudes") else [])]) if needs_factor else ""
    if test == "paired-t" and (size := len(_levels(by, names, order))) != 2:
        table.fail("by", by, f"a factor with two levels, it has {size}")
    if test in ("rm-anova", "friedman", "anova") and (size := len(_levels(by, names, order))) < 3:
        table.fail("by", by, f"a factor with at least three levels, it has {size}")
    if test == "confusion" and (question is None or question.correct != "{" + by + "}"):
        table.fail("of", of, f"a choice whose correct answer is {{{by}}}")
    correction = table.text("correction", "none", among=("none", "bonferroni", "holm"))
    chance = table.number("chance", 0.5, above=0.0, high=1.0)
    weights = [q.name for q in questions if q.kind == "scale" and q.low >= 0 and q.when == "trial"]
    weight = table.text("weight", "", among=weights) if test == "binomial" else ""
    where_table = table.table("where", None)
    where: dict[str, Value] = {}
    for key, value in (where_table.rest() if where_table else {}).items():
        if key not in [*names, *([SET] if has_sets else [])] or isinstance(value, bool) or value not in _levels(key, names, order):
            table.fail(f"where.{key}", value, "a factor and one of its levels")
        where[key] = value
    analysis = Analysis(name, test, of, by, correction, chance, weight, where, table.text("paper", ""))
    table.done()
    return analysis


def check(path: Path) -> HaptogramError | None:
    """What is wrong with a protocol, or None."""
    try:
        read(path)
    except HaptogramError as error:
        return error
    return None


def canonical(value: object) -> bytes:
    """A value as JSON that is the same wherever it is made; what hashes are taken of."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
