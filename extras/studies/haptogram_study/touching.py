# SPDX-License-Identifier: Apache-2.0
"""A simulated hand that touches what is asked for: each trial is one of `haptogram task`, in which cameras see scripted fingers, rings are made
around them as `haptogram live` makes them, and they feel by the pressure on their skin, thresholds and noise. Or a hand that
`haptogram render` takes through the object of each of two arrays. No answer is drawn from the paper's."""
import json
import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from haptogram.errors import HaptogramError, ErrorCode, bad_input
from . import design, program as programs
from .asking import Answer, Occasion
from .design import digest
from .observers import Silent
from .protocol import Protocol, Question, fill, places

NAME = "simulated:hand"
Found = dict[str, Any]  # a trial of a task's report


def _share(found: list[Found], good: Callable[[Found], float]) -> int:
    """A rating from 1 to 7: how much of what was tried was good."""
    return 1 + round(6 * sum(map(good, found)) / len(found))


@dataclass(frozen=True)
class _Task:
    words: tuple[str, ...]  # of the program, with the protocol's placeholders
    answers: dict[str, Callable[[Found], Answer]]  # of each question of a trial, from the task's report; None: the time ran out
    ratings: dict[str, Callable[[list[Found]], int]]  # of each question at the end, from those of all trials with the same level


def _lift(*more: str) -> _Task:
    """The cube, its time if it was lifted, and two ratings: of how many it lifted, and for how much of its trials it felt something."""
    return _Task(
        ("lift", "--felt", "{feedback}", "--edge", "{edge_mm}", *more),
        {"time_s": lambda found: found["time_s"] if found["done"] else None},
        {"as_desired": lambda all: _share(all, lambda one: one["done"]), "present": lambda all: _share(all, lambda one: one["felt_shots"] / max(1, one["touched_shots"]))},
    )


@dataclass(frozen=True)
class _Comparison:
    """A scripted hand explores what each of two arrays plays, and answers which is more. Each side is judged with noise of its own."""

    hands: tuple[str, ...]  # of `haptogram render`
    array: str  # where the protocol names none
    noise_db: float  # with which a side is judged
    more: dict[str, Callable[[list[Found]], float]]  # of each question: how much of it there is on a side, by the frames that touch, as a pressure
    step_db: float  # of the difference that is felt, for which it is surer by one

    def judge(self, question: str, sides: list[list[Found]], noise: random.Random) -> float:
        """By how many decibels the right side is felt to be more than the left."""
        left, right = (20.0 * math.log10(self.more[question](frames)) + noise.gauss(0.0, self.noise_db) for frames in sides)
        return right - left


def _mean(frames: list[Found], value: Callable[[Found], float]) -> float:
    return max(1e-6, sum(map(value, frames)) / max(1, len(frames)))


TASKS: dict[str, _Task | _Comparison] = {
    # The model's, not the paper's: noise of a judged strength as that of the threshold in the tasks; of lines, how much is strong enough to be felt.
    "shapes_comparison": _Comparison(
        ("synthetic:slide:200", "synthetic:slide:245"),  # through the middle and below the top, so that edges, corners and the apex are met
        "usx-16x16",  # as large as the paper's
        2.0,
        {
            "stronger": lambda frames: _mean(frames, lambda one: one["strength_pa"] * one["tilt"]),
            "surface": lambda frames: _mean(frames, lambda one: one["length_mm"] * (1.0 - one["weak"])),
            "similar": lambda frames: _mean(frames, lambda one: (1.0 - one["weak"]) * (1.0 - one["out_of_reach"])),
        },
        2.0,
    ),
    "fingers_surface": _Task(
        ("surface", "--felt", "{method}", "--angle", "{angle_deg}", "--height", "{height_mm}"),
        {"angle": lambda found: found["answer_deg"], "height": lambda found: found["answer_mm"]},
        {},
    ),
    "fingers_lift_visible": _lift("--x", "{x_mm}", "--y", "{y_mm}", "--turn", "{angle_deg}"),
    "fingers_lift_hidden": _lift("--hidden"),  # a scripted hand searches along one line alone, so the task draws a place on it
}


class Hand(Silent):
    """Answers by the program's tasks."""

    name = NAME

    def __init__(self, protocol: Protocol, program: str) -> None:
        if protocol.name not in TASKS:
            raise bad_input(str(protocol.path), f"{NAME} has no task for it, only for {', '.join(TASKS)}; take another observer")
        self._protocol, self._program, self._task = protocol, program, TASKS[protocol.name]
        self._known: dict[tuple[object, ...], Found] = {}
        self._felt: dict[tuple[str, ...], list[Found]] = {}

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        if isinstance(self._task, _Comparison):
            return self._compare(self._task, question, occasion), 1.0
        if question.when == "end":
            return self._task.ratings[question.name](self._all_like(occasion)), 1.0
        found = self._touch(occasion)
        answer = self._task.answers[question.name](found)
        if isinstance(answer, float) and not question.low <= answer <= question.high:
            raise HaptogramError(ErrorCode.RUN_FAILED, f"trial {occasion.cell.number}", f"{question.name}: the hand answers {answer:g}, expected "
                                 f"{question.low:g} to {question.high:g}; give the protocol's question a wider scale")  # fmt: skip
        return answer, found["time_s"]

    def _compare(self, task: _Comparison, question: Question, occasion: Occasion) -> Answer:
        if question.kind == "text":
            return "simulated"
        asked = question.name.removesuffix("_confidence")
        if asked not in task.more:
            raise bad_input(str(self._protocol.path), f"{NAME} cannot answer '{question.name}', only {', '.join(task.more)}, and how sure of each")
        sides = [self._feel(task, words, occasion) for words in self._protocol.stimulus.live]
        noise = random.Random(digest(occasion.seed, occasion.participant, "hand", asked, *occasion.key))
        more = task.judge(asked, sides, noise)
        if question.name == asked:
            return "right" if more > 0 else "left"
        return int(min(question.high, question.low + abs(more) // task.step_db))

    def _feel(self, task: _Comparison, words: tuple[str, ...], occasion: Occasion) -> list[Found]:
        """What the hand touches of one array's object, frame by frame."""
        values = places(self._protocol, occasion.cell.levels, occasion.cell.drawn, occasion.level_db)
        filled = [fill(word, values) for word in words]
        if "--object" not in filled:
            raise bad_input(str(self._protocol.path), f"{NAME} explores the `--object` of each array's `live`; found none in {filled}")
        at = filled.index("--object")
        array = [] if "--array" in filled else ["--array", task.array]
        command = ["render", filled[at + 1], *filled[:at], *filled[at + 2 :], *array, "--report", "--json"]
        key = tuple(command)
        if key not in self._felt:
            frames = [one for hand in task.hands for one in self._run([*command, "--hand", hand])["frames"] if one["lines"]]
            if not frames:
                raise HaptogramError(ErrorCode.RUN_FAILED, NAME, f"'haptogram {' '.join(command)}' touches nothing")
            self._felt[key] = frames
        return self._felt[key]

    def _run(self, words: list[str]) -> Found:
        found: Found = json.loads(programs.ask(self._program, words, NAME, ErrorCode.RUN_FAILED))
        return found

    def _all_like(self, end: Occasion) -> list[Found]:
        """The trials of the session with the levels of a question at its end; those of an earlier part are carried out again."""
        wanted = {name: level.value for name, level in end.cell.levels.items()}
        cells = [cell for cell in design.cells(self._protocol, end.participant, end.seed) if all(cell.levels[name].value == value for name, value in wanted.items())]
        return [self._touch(Occasion(end.participant, end.seed, cell, None, ("trial", cell.number, 1))) for cell in cells]

    def _touch(self, occasion: Occasion) -> Found:
        key = (occasion.seed, occasion.participant, *occasion.key)
        if key not in self._known:
            assert isinstance(self._task, _Task)
            values = places(self._protocol, occasion.cell.levels, occasion.cell.drawn, occasion.level_db)
            seed = int.from_bytes(digest(occasion.seed, occasion.participant, "hand", *occasion.key)[:4], "big")
            words = ["task", *(fill(word, values) for word in self._task.words), "--trials", "1", "--seed", str(seed), "--json"]
            self._known[key] = self._run(words)["trials"][0]
        return self._known[key]
