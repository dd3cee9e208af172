# SPDX-License-Identifier: Apache-2.0
"""Who answers: a person at the keyboard. Simulated people are in observers.py."""
import math
import os
import select
import sys
import termios
import time
from dataclasses import dataclass, field
from typing import Protocol as Interface

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
    waits: bool  # whether rests and stimuli take their time

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        """The answer, None when the time ran out, and the seconds that it took."""

    def tell(self, text: str) -> None: ...

    def ready(self) -> None:
        """Waits until a trial may begin."""


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


class Keyboard:
    """Lines of a file descriptor, usually the terminal. What was typed before a question was asked does not answer it."""

    name, waits = "keyboard", True

    def __init__(self, source: int = 0) -> None:
        self._source, self._left = source, b""

    def tell(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    def ready(self) -> None:
        print("Return begins the next trial, q stops. ", end="", file=sys.stderr, flush=True)
        self._forget()
        if (self._line(None) or "").strip() == "q":
            raise Stopped

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        keys = " / ".join(f"{key} {meaning}" for key, meaning in question.keys.items())
        print(f"{question.text} [{keys or question.kind}] ", end="", file=sys.stderr, flush=True)
        self._forget()
        begun = time.monotonic()
        while True:
            left = question.limit_s - (time.monotonic() - begun) if question.limit_s else None
            line = self._line(left)
            seconds = time.monotonic() - begun
            if line is None:
                print("time is up", file=sys.stderr, flush=True)
                return None, seconds
            try:
                return parse(question, line), seconds
            except ValueError as error:
                print(f"{error}: ", end="", file=sys.stderr, flush=True)

    def _forget(self) -> None:
        if os.isatty(self._source):
            termios.tcflush(self._source, termios.TCIFLUSH)
            self._left = b""

    def _line(self, seconds: float | None) -> str | None:
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
