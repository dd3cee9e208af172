# SPDX-License-Identifier: Apache-2.0
"""A simulated hand that touches what is asked for: each trial is one of `haptogram task`, in which cameras see a scripted finger, rings are made
around it as `haptogram live` makes them, and it feels them by the pressure on its skin, thresholds and noise. No answer is drawn from the paper's."""
import json
import subprocess
from dataclasses import dataclass

from ..errors import HaptogramError, ErrorCode, bad_input
from .asking import Answer, Occasion
from .design import digest
from .protocol import Protocol, Question, fill, places

NAME = "simulated:hand"


@dataclass(frozen=True)
class _Task:
    words: tuple[str, ...]  # of the program, with the protocol's placeholders
    answers: dict[str, str]  # of each question, the member of the task's report


TASKS = {
    "fingers_surface": _Task(
        ("surface", "--felt", "{method}", "--angle", "{angle_deg}", "--height", "{height_mm}"),
        {"angle": "answer_deg", "height": "answer_mm"},
    ),
}


class Hand:
    """Answers by the program's tasks, reproducibly: all follows from seed, participant and trial."""

    waits = False
    name = NAME

    def __init__(self, protocol: Protocol, program: str) -> None:
        if protocol.name not in TASKS:
            raise bad_input(str(protocol.path), f"{NAME} has no task for it, only for {', '.join(TASKS)}; take another observer")
        self._protocol, self._program, self._task = protocol, program, TASKS[protocol.name]
        self._key: tuple[object, ...] = ()
        self._found: dict[str, float] = {}

    def tell(self, text: str) -> None:
        pass

    def ready(self, occasion: Occasion, presented: str) -> None:
        pass

    def rest(self, seconds: float) -> None:
        pass

    def ask(self, question: Question, occasion: Occasion) -> tuple[Answer, float]:
        key = (occasion.seed, occasion.participant, *occasion.key)
        if key != self._key:
            self._found, self._key = self._touch(occasion), key
        answer = self._found[self._task.answers[question.name]]
        return min(max(answer, question.low), question.high), self._found["time_s"]

    def _touch(self, occasion: Occasion) -> dict[str, float]:
        values = places(self._protocol, occasion.cell.levels, occasion.cell.drawn, occasion.level_db)
        seed = int.from_bytes(digest(occasion.seed, occasion.participant, "hand", *occasion.key)[:4], "big")
        words = ["task", *(fill(word, values) for word in self._task.words), "--trials", "1", "--seed", str(seed), "--json"]
        done = subprocess.run([self._program, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
        if done.returncode:
            raise HaptogramError(ErrorCode.RUN_FAILED, NAME, f"'haptogram {' '.join(words)}' failed: {done.stderr.strip()}")
        found: dict[str, float] = json.loads(done.stdout)["trials"][0]
        return found
