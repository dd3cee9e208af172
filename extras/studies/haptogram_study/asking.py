# SPDX-License-Identifier: Apache-2.0
"""Who answers: a person at the keyboard, or at a page that another program shows. Simulated people are in observers.py."""
import json
import math
import os
import select
import sys
import termios
import time
from dataclasses import dataclass, field
from typing import Protocol as Interface

from haptogram.errors import bad_input
from .design import Cell
from .protocol import Question

Answer = str | float | bool | None


@dataclass(frozen=True)
class Occasion:
    """When a question is asked: of which trial, at which level of a staircase. `key` names it among all, for random numbers."""

    participant: int
    seed: int
    cell: Cell
    level_db: float | None
    key: tuple[object, ...] = field(default_factory=tuple)


class Stopped(Exception):
    """The person wants to stop, or there is no more input; what was answered is kept."""


class Observer(Interface):
    name: str
    waits: bool  # for a person: who is told what to do

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        """The answer, None when the time ran out, and the seconds that it took."""

    def tell(self, text: str) -> None: ...

    def ready(self, occasion: Occasion, presented: str) -> None:
        """Waits until a trial may begin. `presented` says what its stimulus is; it is not for the eyes of who answers."""

    def rest(self, seconds: float) -> None: ...


def parse(question: Question, text: str) -> Answer:
    """What a typed line means. Raises ValueError saying what was expected."""
    text = text.strip()
    if question.kind in ("choice", "yes-no"):
        if text not in question.keys:
            raise ValueError("type " + ", ".join(f"{key} for {meaning}" for key, meaning in question.keys.items()))
        return text == "y" if question.kind == "yes-no" else question.keys[text]
    if question.kind == "text":
        if not text:
            raise ValueError("type some words")
        return text
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (question.low <= value <= question.high and math.isfinite(value)) or (question.whole and value != int(value)):
        limits = "" if math.isinf(question.low) else f" from {question.low:g}"
        limits += "" if math.isinf(question.high) else f" to {question.high:g}"
        raise ValueError(f"type a {'whole ' if question.whole else ''}number{limits}")
    return int(value) if question.whole else value


class Lines:
    """Lines of a file descriptor, as they come. Raises Stopped at its end."""

    def __init__(self, source: int) -> None:
        self._source, self._left = source, b""

    def forget(self) -> None:
        """What was typed at a terminal and not read yet."""
        if os.isatty(self._source):
            termios.tcflush(self._source, termios.TCIFLUSH)
            self._left = b""

    def next(self, seconds: float | None) -> str | None:
        """The next line; None when none came in time."""
        end = None if seconds is None else time.monotonic() + seconds
        while b"\n" not in self._left:
            wait = None if end is None else max(end - time.monotonic(), 0.0)
            if not select.select([self._source], [], [], wait)[0]:
                return None
            block = os.read(self._source, 4096)
            if not block or len(self._left) > 100_000:
                raise Stopped
            self._left += block
        line, self._left = self._left.split(b"\n", 1)
        return line.decode("utf-8", "replace")


class Keyboard:
    """Lines of a file descriptor, usually the terminal. What was typed before a question was asked does not answer it."""

    name, waits = "keyboard", True

    def __init__(self, source: int = 0) -> None:
        self._lines = Lines(source)

    def tell(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    def ready(self, occasion: Occasion, presented: str) -> None:
        print("Return begins the next trial, q stops. ", end="", file=sys.stderr, flush=True)
        self._lines.forget()
        if (self._lines.next(None) or "").strip() == "q":
            raise Stopped

    def rest(self, seconds: float) -> None:
        self.tell(f"Rest for {seconds:g} s.")
        time.sleep(seconds)

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        keys = " / ".join(f"{key} {meaning}" for key, meaning in question.keys.items())
        print(f"{question.text} [{keys or question.kind}] ", end="", file=sys.stderr, flush=True)
        self._lines.forget()
        begun = time.monotonic()
        while True:
            left = question.limit_s - (time.monotonic() - begun) if question.limit_s else None
            line = self._lines.next(left)
            seconds = time.monotonic() - begun
            if line is None:
                print("time is up", file=sys.stderr, flush=True)
                return None, seconds
            try:
                return parse(question, line), seconds
            except ValueError as error:
                print(f"{error}: ", end="", file=sys.stderr, flush=True)


class Page:
    """A page that another program shows: what it is to show goes to standard output, and what a person did there comes from standard input, a
    line of JSON each. What waits for the person has a number, so that a late answer cannot answer the next question.

    Standard output:
    {"show": "tell", "text"}: title, instructions, which trial
    {"show": "ready", "number", "trial", "of", "presented"}: waits for the start of the trial; `presented` tells the experimenter the stimulus
    {"show": "ask", "number", "trial", "of", "text", "kind", "keys", "from", "to", "whole", "limit_s"}: waits for an answer; `keys` are pairs of
        key and meaning, or null
    {"show": "wrong", "number", "text"}: the answer was not valid, and the runner still waits
    {"show": "late"}: the time ran out
    {"show": "rest", "seconds"}: a pause

    Standard input:
    {"do": "answer", "number", "text"}: what a person would type; another number than that of the waiting question is ignored
    {"do": "stop"}, or end of input: stops; the session can continue later
    Any other line ends the runner with code 3."""

    name, waits = "page", True

    def __init__(self, trials: int, source: int = 0) -> None:
        self._trials, self._lines, self._number = trials, Lines(source), 0

    def tell(self, text: str) -> None:
        self._show("tell", text=text)

    def ready(self, occasion: Occasion, presented: str) -> None:
        self._show_numbered("ready", occasion, presented=presented)
        self._answer(None)

    def rest(self, seconds: float) -> None:
        self._number += 1  # nothing is waited for, and nothing that comes now answers anything
        self._show("rest", seconds=seconds)
        self._answer(time.monotonic() + seconds)

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        limits = {"from": question.low, "to": question.high}
        self._show_numbered("ask", occasion, text=question.text, kind=question.kind, keys=list(question.keys.items()), whole=question.whole,
                            limit_s=question.limit_s or None, **{key: limit if math.isfinite(limit) else None for key, limit in limits.items()})  # fmt: skip
        begun = time.monotonic()
        while True:
            text = self._answer(begun + question.limit_s if question.limit_s else None)
            seconds = time.monotonic() - begun
            if text is None:
                self._show("late")
                return None, seconds
            try:
                return parse(question, text), seconds
            except ValueError as error:
                self._show("wrong", number=self._number, text=str(error))

    def _show_numbered(self, what: str, occasion: Occasion, **more: object) -> None:
        self._number += 1
        self._show(what, number=self._number, trial=occasion.cell.number, of=self._trials, **more)

    def _show(self, what: str, **more: object) -> None:
        try:
            print(json.dumps({"show": what} | more, allow_nan=False), flush=True)
        except BrokenPipeError as error:
            raise Stopped from error

    def _answer(self, end: float | None) -> str | None:
        """The text that answers what was shown last; None when none came until then."""
        while True:
            line = self._lines.next(None if end is None else end - time.monotonic())
            if line is None:
                return None
            try:
                message = json.loads(line)
            except (ValueError, RecursionError):
                message = None
            match message:
                case {"do": "stop", **rest} if not rest:
                    raise Stopped
                case {"do": "answer", "number": int(number), "text": str(text), **rest} if not rest:
                    if number == self._number:
                        return text
                case _:
                    raise bad_input("page", f"found {line[:80]!r}, expected an answer or stop")
