# SPDX-License-Identifier: Apache-2.0
"""From results to the statistics that their protocol asks for; and how often simulated people would show an effect."""
import itertools
import math
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from haptogram.errors import HaptogramError, bad_input
from . import inference, origin
from .observers import simulated
from .protocol import SET, Analysis, Protocol, Question
from .session import Record, Session
from .stimulus import Presenter


@dataclass
class Finding:
    """What an analysis found: lines to read, p-values by name, numbers by name."""

    name: str
    test: str
    paper: str
    lines: list[str] = field(default_factory=list)
    p: dict[str, float] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        return {"name": self.name, "test": self.test, "paper": self.paper, "p": self.p, "numbers": self.numbers}


def _finite(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError(f"{str(value)[:40]!r} is no number")
    return float(value)


def _answered(question: Question, answer: dict[str, Any]) -> dict[str, Any]:
    """The columns of an answer. Raises ValueError when it is none to this question."""
    value, name = answer["value"], question.name
    if value is not None:
        if question.kind in ("scale", "number"):
            value = _finite(value)
        elif not (isinstance(value, bool) if question.kind == "yes-no" else isinstance(value, str) and (question.kind == "text" or value in question.keys.values())):
            raise ValueError(f"{str(value)[:40]!r} is no answer to {name}")
    found = {name: value, f"{name}.seconds": _finite(answer["seconds"])}
    if "correct" in answer:
        if not isinstance(answer["correct"], bool):
            raise ValueError(f"{name}.correct is {str(answer['correct'])[:40]!r}")
        found |= {f"{name}.correct": answer["correct"], f"{name}.seconds_of_correct": found[f"{name}.seconds"] if answer["correct"] else None}
    if "error" in answer:
        found[f"{name}.error"] = _finite(answer["error"])
        found[f"{name}.absolute_error"] = abs(found[f"{name}.error"])
    return found


def frame(protocol: Protocol, records: Iterable[tuple[str, Record]]) -> pd.DataFrame:
    """A row a record. Columns: participant, kind, set, factors and drawn numbers, and of each question its answer, `.seconds`, `.correct`,
    `.seconds_of_correct`, `.error`, `.absolute_error`. Records of another protocol, and two of the same trial, are errors."""
    rows: list[dict[str, Any]] = []
    seen: dict[tuple[object, ...], str] = {}
    for where, record in records:
        origin.of_protocol(protocol, where, record)
        try:
            factors, answers = dict(record["factors"]), dict(record.get("answers", {}))
            row: dict[str, Any] = {"participant": int(record["participant"]), "kind": str(record["kind"]), "trial": int(record["trial"]), **factors}
            if row["kind"] != "question":
                row[SET] = int(record[SET])
                if row[SET] not in protocol.levels(SET):
                    raise ValueError(f"set {row[SET]} is not one of {protocol.order.sets}")
            row |= {name: float(value) for name, value in dict(record.get("drawn", {})).items()}
            if "level_db" in record:
                row["level_db"] = float(record["level_db"])
            if row["kind"] == "threshold":
                found = record["threshold_db"]
                row |= {"threshold_db": found if found is None else _finite(found), "start": record["start"], "state": record["state"]}
            for name, value in factors.items():
                if value not in protocol.levels(name):
                    raise ValueError(f"{str(value)[:40]!r} is no level of {name}")
            for name, answer in answers.items():
                row |= _answered(protocol.question(name), answer)
            step = int(record["step"])
        except origin.BROKEN as error:
            raise origin.incomplete(where, error) from error
        identity = (row["participant"], row["kind"], row["trial"], step, record.get("question"), str(factors))
        if identity in seen:
            raise bad_input(where, f"is a second record of participant {row['participant']}, trial {row['trial']}; the first is {seen[identity]}; leave one out")
        seen[identity] = where
        rows.append(row)
    if not rows:
        raise bad_input("results", "found no records; run the protocol first")
    return pd.DataFrame(rows)


def _selected(protocol: Protocol, analysis: Analysis, data: pd.DataFrame) -> pd.DataFrame:
    kind = "threshold" if analysis.of == "threshold_db" else "question" if protocol.question(analysis.of.split(".")[0]).when == "end" else "trial"
    chosen = data[data["kind"] == kind]
    for name, value in analysis.where.items():
        chosen = chosen[chosen[name] == value]
    if analysis.of not in chosen or chosen.empty:
        raise bad_input(analysis.name, f"the results have no {analysis.of}; are they of a finished session?")
    return chosen.dropna(subset=[analysis.of])


def _wide(protocol: Protocol, analysis: Analysis, data: pd.DataFrame) -> pd.DataFrame:
    """The mean of each person (rows) at each level (columns)."""
    table = data.assign(**{analysis.of: data[analysis.of].astype(float)}).pivot_table(analysis.of, "participant", analysis.by)
    table = table.reindex(columns=protocol.levels(analysis.by))
    if table.isna().to_numpy().any():
        lacking = [str(person) for person in table.index[table.isna().any(axis=1)]]
        raise bad_input(analysis.name, f"participant(s) {', '.join(lacking)} lack a level of {analysis.by}; leave them out, or let them finish")
    if len(table) < 2:
        raise bad_input(analysis.name, f"found {len(table)} participant, expected at least two")
    return table.rename(columns=lambda level: _named(analysis, level))


def _named(analysis: Analysis, level: object) -> str:
    """A level as the findings call it."""
    return f"{SET} {level}" if analysis.by == SET else str(level)


def _means(found: Finding, table: pd.DataFrame) -> None:
    for level in table:
        values = table[level]
        found.lines.append(f"{level}: mean {values.mean():.4g}, SD {values.std():.4g} of {len(values)} people")
    found.numbers["mean"] = {level: float(table[level].mean()) for level in table}


def _one(protocol: Protocol, analysis: Analysis, everything: pd.DataFrame) -> Finding:
    data, found = _selected(protocol, analysis, everything), Finding(analysis.name, analysis.test, analysis.paper)

    def told(name: str, test: inference.Test) -> None:
        found.lines.append(f"{name}: {test}" if name else str(test))
        found.p[name] = test.p
        found.numbers.setdefault("statistic", {})[name] = {"name": test.name, "value": test.statistic, "df": list(test.df)}
        if not math.isfinite(test.statistic) or not math.isfinite(test.p):
            raise bad_input(analysis.name, f"{name or analysis.test} has no p-value; do all values agree? found {data[analysis.of].nunique()} different ones")

    def sized(name: str, *effects: inference.Effect) -> None:
        found.lines.append((f"{name}: " if name else "") + "; ".join(map(str, effects)))
        sizes = found.numbers.setdefault("effect", {}).setdefault(name, {})
        for effect in effects:
            sizes[effect.name] = {"value": effect.value} | ({"low": effect.low, "high": effect.high, "level": effect.level} if effect.level else {})

    if analysis.test == "binomial":
        right, trials = int(data[analysis.of].sum()), len(data)
        p, low, high = inference.binomial(right, trials, analysis.chance)
        person = data.groupby("participant")[analysis.of].mean().astype(float)
        found.lines.append(f"{right} of {trials}: {right / trials:.2%}, 95 % interval {low:.2%} to {high:.2%}; against {analysis.chance:.0%}: p = {p:.3g}")
        found.lines.append(f"over {len(person)} people: mean {person.mean():.2%}, SD {person.std():.2%}; the interval takes trials as independent")
        found.p[""], found.numbers = p, {"successes": right, "trials": trials, "low": low, "high": high}
        sized("", inference.cohen_h(right, trials, analysis.chance))
        if analysis.weight:
            weights = data[analysis.weight].astype(float)
            weighted = float((weights * data[analysis.of].astype(float)).sum() / weights.sum())
            found.lines.append(f"weighted by {analysis.weight}: {weighted:.2%}")
            found.numbers["weighted"] = weighted
    elif analysis.test == "confusion":
        shown = protocol.levels(analysis.by)
        counts = pd.crosstab(data[analysis.by], data[analysis.of]).reindex(index=shown, columns=[str(s) for s in shown], fill_value=0)
        matrix = inference.confusion(counts.to_numpy())
        found.lines += [f"{name}: {' '.join(f'{c:4d}' for c in row)}" for name, row in zip(shown, counts.to_numpy())]
        found.lines.append(f"right {matrix.share:.2%}, kappa {matrix.kappa:.3f}, information {matrix.bits:.3f} bit of {math.log2(len(shown)):.3g}")
        told("same rate for all", matrix.homogeneity)
        found.numbers |= {"counts": counts.to_numpy().tolist(), "kappa": matrix.kappa, "bits": matrix.bits}
    elif analysis.test == "mean":
        values = data[analysis.of].astype(float)
        found.lines.append(f"mean {values.mean():.4g}, SD {values.std():.4g}, standard error {values.sem():.3g} of {len(values)}")
        found.numbers = {"mean": float(values.mean()), "sd": float(values.std()), "n": len(values)}
    elif analysis.test == "paired-t":
        table = _wide(protocol, analysis, data)
        _means(found, table)
        told("", inference.paired_t(*table.to_numpy().T))
        sized(" − ".join(table), *inference.paired_effects(*table.to_numpy().T))
    elif analysis.test == "rm-anova":
        table = _wide(protocol, analysis, data)
        _means(found, table)
        plain, shrunk = inference.rm_anova(table.to_numpy())
        told("", plain)
        told("Greenhouse-Geisser", shrunk)
        sized("", inference.eta_squared(plain, "partial eta squared"))
    elif analysis.test == "anova":
        table = _wide(protocol, analysis, data)
        _means(found, table)
        overall = inference.anova(*table.to_numpy().T)
        told("", overall)
        sized("", inference.eta_squared(overall))
        for (a, b), (p, difference) in inference.tukey(list(table.to_numpy().T), list(table)).items():
            found.lines.append(f"Tukey, {a} and {b}: p = {p:.3g}")
            found.p[f"{a}, {b}"] = p
            sized(f"{a} − {b}", difference)
    elif analysis.test == "friedman":
        table = _wide(protocol, analysis, data)
        ranked = inference.friedman(table.to_numpy())
        told("", ranked)
        sized("", inference.kendall_w(ranked, len(table)))
    elif analysis.test == "wilcoxon":
        table = _wide(protocol, analysis, data)
        pairs = list(itertools.combinations(table, 2))
        tests = [inference.wilcoxon(table[a], table[b]) for a, b in pairs]
        for (a, b), test, p in zip(pairs, tests, inference.corrected([t.p for t in tests], analysis.correction)):
            told(f"{a}, {b}", inference.Test(test.name, test.statistic, test.df, p))
            if effect := inference.rank_biserial(table[a], table[b]):
                sized(f"{a} − {b}", effect)
            else:
                found.lines.append(f"{a} − {b}: no pair differs, so there is no rank-biserial correlation")
    elif analysis.test == "votes":
        counts = data[analysis.of].value_counts().reindex(list(protocol.question(analysis.of).keys.values()), fill_value=0)
        found.lines += [f"{name}: {count} of {counts.sum()}, {count / counts.sum():.1%}" for name, count in counts.items()]
        told("all alike", _goodness(counts.to_numpy()))
        found.numbers["counts"] = {str(k): int(v) for k, v in counts.items()}
    elif analysis.test == "thresholds":
        lost = everything[(everything["kind"] == "threshold") & everything["threshold_db"].isna()]
        if len(lost):
            found.lines.append(f"{len(lost)} runs ended without a threshold: {', '.join(sorted(set(lost['state'])))}")
        table = data.assign(threshold_db=data["threshold_db"].astype(float)).groupby(analysis.by)["threshold_db"].agg(["mean", "std", "count"])
        table = table.rename(index=lambda level: _named(analysis, level))
        found.lines += [f"{level}: {row['mean']:.2f} dB, SD {row['std']:.2f} of {int(row['count'])} runs" for level, row in table.iterrows()]
        found.numbers = {"mean_db": {str(k): float(v) for k, v in table["mean"].items()}, "lost": len(lost)}
    elif analysis.test == "psychometric":
        for level, part in data.groupby(analysis.by):
            counts = part.assign(yes=part[analysis.of].astype(float)).groupby("level_db")["yes"].agg(["sum", "count"])
            fit = inference.psychometric(counts.index.to_numpy(), counts["sum"].to_numpy(), counts["count"].to_numpy(dtype=float))
            found.lines.append(f"{_named(analysis, level)}: threshold {fit.threshold:.2f} dB, spread {fit.spread:.2f} dB, of {int(counts['count'].sum())} answers (probit)")
            found.numbers[_named(analysis, level)] = {"threshold_db": fit.threshold, "spread_db": fit.spread}
    else:
        _magnitudes(protocol, analysis, data, found)
    return found


def _goodness(counts: Any) -> inference.Test:
    """Pearson's test that all answers are equally frequent."""
    found = stats.chisquare(counts)
    return inference.Test("chi2", float(found.statistic), (len(counts) - 1.0,), float(found.pvalue))


def _magnitudes(protocol: Protocol, analysis: Analysis, data: pd.DataFrame, found: Finding) -> None:
    """A parabola of the mean magnitude over the other factor, at each level of `by` (Multimodal eq. 10)."""
    others = [f for f in protocol.factors if f.name != analysis.by]
    if len(others) != 1:
        raise bad_input(analysis.name, f"found {len(others)} other factors, expected one, over which the magnitude is fitted")
    over = others[0].name
    for level, part in data.assign(**{analysis.of: data[analysis.of].astype(float)}).groupby(analysis.by):
        part = part.assign(scaled=inference.normalised(part, "participant", analysis.of))
        means = part.groupby(over)["scaled"].mean()
        coefficients, r2 = inference.polynomial(means.index.to_numpy(dtype=float), means.to_numpy(), 2)
        found.lines.append(f"{level}: {coefficients[0]:.4g}·x² {coefficients[1]:+.4g}·x {coefficients[2]:+.4g}, R² = {r2:.3f}")
        found.numbers[str(level)] = {"coefficients": [float(c) for c in coefficients], "r2": float(r2)}


def analyse(protocol: Protocol, data: pd.DataFrame) -> list[Finding]:
    """All analyses of the protocol. What the numbers do not allow, such as a test of values without any scatter, is an error."""
    found = []
    for analysis in protocol.analyses:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # said by the check below
            one = _one(protocol, analysis, data)
        for name, p in one.p.items():
            if not math.isfinite(p):
                raise bad_input(analysis.name, f"{name or analysis.test} has no p-value; do all values agree? found {data[analysis.of].nunique()} different ones")
        found.append(one)
    return found


@dataclass
class Study:
    """What the results of a study say, and where they are from; no number is handed on without that."""

    origin: origin.Origin
    found: list[Finding]

    def as_json(self) -> dict[str, Any]:
        protocol = self.origin.protocol
        return {"protocol": protocol.name, "protocol_sha256": protocol.sha256} | self.origin.as_json() | {"analyses": [f.as_json() for f in self.found]}

    def report(self) -> str:
        parts = list(self.origin.labels)
        for f in self.found:
            parts += [f"{f.name} ({f.test})", *(f"  {line}" for line in f.lines)] + ([f"  the paper: {f.paper}"] if f.paper else [])
        return "\n".join(parts)


def study(protocol: Protocol, records: Iterable[tuple[str, Record]], *, mixed: bool = False, unfinished: bool = False) -> Study:
    """All analyses of results. People with simulated observers, or different simulated ones, are refused without `mixed`, sessions that are not
    finished without `unfinished`."""
    given = list(records)
    where = origin.of(protocol, given)
    where.refuse(mixed=mixed, unfinished=unfinished)
    return Study(where, analyse(protocol, frame(protocol, given)))


def power(protocol: Protocol, observer: str, participants: int, runs: int, seed: int, alpha: float) -> dict[str, tuple[float, float, float]]:
    """The share of simulated studies in which each p-value is below alpha, with its exact 95 % interval. A study that an analysis cannot
    evaluate is an error: it would make the share wrong."""
    hits: dict[str, int] = {}
    for study in range(runs):
        records: list[tuple[str, Record]] = []
        for participant in range(1, participants + 1):
            Session(protocol, participant, seed * 1_000_003 + study, simulated(protocol, observer), Presenter(protocol),
                    lambda record: records.append((f"simulated study {study + 1}", record))).run()  # fmt: skip
        try:
            found = analyse(protocol, frame(protocol, records))
        except HaptogramError as error:
            error.add_note(f"in simulated study {study + 1} of {runs}")
            raise
        for one in found:
            for name, p in one.p.items():
                key = one.name + (f": {name}" if name else "")
                hits[key] = hits.get(key, 0) + (p < alpha)
    if not hits:
        raise bad_input(str(protocol.path), "has no analysis with a p-value, so there is no power; add a test")
    return {name: (count / runs, *inference.binomial(count, runs, 0.5)[1:]) for name, count in hits.items()}
