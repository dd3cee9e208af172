# SPDX-License-Identifier: Apache-2.0
"""A participant's session: asks what the protocol says, and hands on a record for each answer."""
import datetime
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from haptogram.errors import bad_input
from haptogram.markers import no_mark
from . import design
from .asking import Answer, Observer, Occasion, Stopped
from .design import Cell
from .protocol import Protocol, Question, fill, places
from .staircase import Staircase
from .stimulus import Presenter

FORMAT = "haptogram-trial-1"
Record = dict[str, Any]


def judged(question: Question, value: Answer, seconds: float, values: dict[str, object]) -> dict[str, Any]:
    """An answer as the results have it: whether it was right, or how far off, when the protocol knows that."""
    found: dict[str, Any] = {"value": value, "seconds": round(seconds, 6)}
    if value is None:
        found["cancelled"] = True
        if question.correct:
            found["correct"] = False
    elif question.correct:
        found["correct"] = value == fill(question.correct, values)
    elif question.truth:
        found["error"] = float(value) - float(fill(question.truth, values))
    return found


class Session:
    """`before` are the records of an earlier part of the same session; they are checked, not asked again. `emit` takes new ones."""

    def __init__(self, protocol: Protocol, participant: int, seed: int, observer: Observer, presenter: Presenter, emit: Callable[[Record], None], *,
                 before: Iterable[tuple[str, Record]] = (), versions: dict[str, str] | None = None, mark: Callable[..., None] = no_mark) -> None:  # fmt: skip
        self.protocol, self.observer, self.presenter, self.emit, self.mark = protocol, observer, presenter, emit, mark
        self.participant, self.seed = participant, seed
        self.cells = design.cells(protocol, participant, seed)
        self._before: Iterator[tuple[str, Record]] = iter(before)
        self._head = {"format": FORMAT, "protocol": protocol.name, "protocol_sha256": protocol.sha256, "participant": participant, "seed": seed,
                      "observer": observer.name, "versions": versions or {}} | ({"made_for": presenter.made_for} if presenter.made_for else {})  # fmt: skip
        self._worked_s = 0.0
        self.asked = 0  # in this part

    def run(self) -> None:
        """To the end, or until Stopped is raised."""
        in_trials = [q for q in self.protocol.questions if q.when == "trial"]
        block: tuple[object, ...] | None = None
        for cell in self.cells:
            now = tuple(cell.levels[name].value for name in self.protocol.order.blocked)
            if block is not None and now != block and self.asked:
                self._pause(self.protocol.rest.between_blocks_s)
            block = now
            if self.protocol.staircase:
                self._staircase(cell, in_trials[0])
            elif in_trials:
                self._trial(cell, in_trials)
        for question in (q for q in self.protocol.questions if q.when == "end"):
            levels = self.protocol.factor(question.each).levels if question.each else (None,)
            for level in levels:
                self._end_question(question, {question.each: level} if level else {})
        for where, _ in self._before:
            raise bad_input(where, "the session had ended before this line; the file was changed; name another file")

    def _record(self, kind: str, number: int, step: int, expected: dict[str, Any]) -> Record | None:
        """What the earlier part has of this, if it came so far."""
        where, found = next(self._before, ("", None))
        if found is None:
            return None
        identity = {"kind": kind, "trial": number, "step": step} | expected
        for key, value in identity.items():
            if found.get(key) != value:
                raise bad_input(where, f"{key} is {str(found.get(key))[:80]!r}, expected {str(value)[:80]!r} of trial {number}; the file was changed, or is "
                                "of another session; name another file")  # fmt: skip
        return found

    def _trial(self, cell: Cell, questions: list[Question], stairs: Staircase | None = None, step: int = 1) -> Record:
        level = stairs.level_db if stairs else None
        expected: dict[str, Any] = {"set": cell.set, "factors": cell.factors, "drawn": cell.drawn}
        if stairs:
            expected |= {"start": cell.start, "level_db": level}
        values = places(self.protocol, cell.levels, cell.drawn, level) | self.presenter.fitted
        found = self._record("trial", cell.number, step, expected)
        if found:
            return self._require_answers(found, questions)
        begun = time.monotonic()
        self.observer.tell(f"Trial {cell.number} of {len(self.cells)}" + (f", level {step}" if stairs else ""))
        stimulus = self.presenter.prepare(values)
        occasion = Occasion(self.participant, self.seed, cell, level, ("trial", cell.number, step))
        self.observer.ready(occasion, fill(self.protocol.stimulus.text, values))
        answers, answered_s = {}, {}
        self.presenter.start()
        try:
            for question in questions:
                answers[question.name] = judged(question, *self.observer.ask(question, occasion), values)
                answered_s[question.name] = time.monotonic()
        finally:
            self.presenter.stop()
            self._mark({"trial": cell.number, "step": step}, stimulus, answered_s)
        self.asked += 1
        began = {"began": self.presenter.began()} if stimulus["played"] else {}
        record = self._write("trial", cell.number, step, expected | {"stimulus": stimulus} | began | {"answers": answers})
        self._rest(time.monotonic() - begun)
        return record

    def _mark(self, trial: dict[str, int], stimulus: dict[str, object], answered_s: dict[str, float]) -> None:
        """In the order of their times, which a board tells after its stimulus only."""
        found = self.presenter
        error = {} if found.began_error_s is None else {"error_s": found.began_error_s}
        self.mark("start", found.began_s, **trial, by=found.began_by, **error, played=stimulus["played"], sha256=stimulus["sha256"])
        for name, at_s in answered_s.items():
            self.mark("answer", at_s, **trial, question=name)
        self.mark("stop", found.ended_s, **trial)

    def _require_answers(self, found: Record, questions: list[Question]) -> Record:
        answers = found.get("answers")
        if not isinstance(answers, dict) or answers.keys() != {q.name for q in questions} or not all(isinstance(a, dict) for a in answers.values()):
            raise bad_input(f"trial {found['trial']}", f"answers {', '.join(q.name for q in questions)} expected in the file; it was changed; name another file")
        return found

    def _staircase(self, cell: Cell, question: Question) -> None:
        rule = self.protocol.staircase
        assert rule is not None
        stairs, step = Staircase(rule, rule.starts_db[cell.start]), 0
        while stairs.state == "running":
            step += 1
            record = self._trial(cell, [question], stairs, step)
            value = record["answers"][question.name].get("value")
            if not isinstance(value, bool):
                raise bad_input(f"trial {cell.number}", f"found the answer {value!r}, expected true or false; a staircase needs every answer")
            stairs.answer(value)
        result = {"set": cell.set, "factors": cell.factors, "start": cell.start, "state": stairs.state, "threshold_db": stairs.threshold_db,
                  "reversals_db": stairs.reversals_db}  # fmt: skip
        if not self._record("threshold", cell.number, step, result):
            self._write("threshold", cell.number, step, result)

    def _end_question(self, question: Question, levels: dict[str, Any]) -> None:
        factors = {name: level.value for name, level in levels.items()}
        number = len(self.cells) + 1
        expected = {"question": question.name, "factors": factors}
        found = self._record("question", number, 1, expected)
        if found:
            self._require_answers(found, [question])
            return
        if factors:
            self.observer.tell(" ".join(f"{name}: {value}" for name, value in factors.items()))
        cell = Cell(number, 0, levels)
        occasion = Occasion(self.participant, self.seed, cell, None, ("question", *factors.values()))
        answer = judged(question, *self.observer.ask(question, occasion), places(self.protocol, levels, {}))
        self.asked += 1
        self._write("question", number, 1, expected | {"answers": {question.name: answer}})

    def _write(self, kind: str, number: int, step: int, more: dict[str, Any]) -> Record:
        at = datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")
        record = self._head | {"kind": kind, "trial": number, "of": len(self.cells), "step": step} | more | {"at": at}
        self.emit(record)
        return record

    def _rest(self, worked_s: float) -> None:
        rest = self.protocol.rest
        self._worked_s += worked_s
        if rest.every_s and self._worked_s >= rest.every_s:
            self._worked_s = 0.0
            self._pause(rest.for_s)
        else:
            self._pause(rest.after_trial_s)

    def _pause(self, seconds: float) -> None:
        if seconds:
            self.observer.rest(seconds)


__all__ = ["Record", "Session", "Stopped"]
