# SPDX-License-Identifier: Apache-2.0
"""The procedure that finds the level which a person just feels (Multimodal, task T3)."""
from dataclasses import dataclass


@dataclass(frozen=True)
class Rule:
    """How a staircase steps. Levels and steps are in dB of the pressure's amplitude."""

    question: str
    starts_db: dict[str, float]
    lowest_db: float
    highest_db: float
    first_step_db: float = 3.0  # until `first_reversals` have happened
    step_db: float = 1.0  # afterwards
    first_reversals: int = 3  # these do not count for the result
    reversals: int = 8  # at which it ends
    most_answers: int = 200
    most_at_limit: int = 5  # answers in a row that ask for a level out of reach, at which it gives up


class Staircase:
    """Down by a step after each yes, up after each no. A reversal is a level at which the direction changes."""

    def __init__(self, rule: Rule, start_db: float) -> None:
        self.rule, self.level_db = rule, start_db
        self.reversals_db: list[float] = []
        self.answers = self._at_limit = 0
        self._last: bool | None = None

    @property
    def state(self) -> str:
        """`running`, `found`, `out of range` when the level would have to leave its limits, or `too long`."""
        if len(self.reversals_db) >= self.rule.reversals:
            return "found"
        if self._at_limit >= self.rule.most_at_limit:
            return "out of range"
        return "too long" if self.answers >= self.rule.most_answers else "running"

    def answer(self, felt: bool) -> None:
        if self.state != "running":
            raise ValueError(f"the staircase has ended: {self.state}")
        self.answers += 1
        if self._last is not None and self._last != felt:
            self.reversals_db.append(self.level_db)
        self._last = felt
        step = self.rule.first_step_db if len(self.reversals_db) < self.rule.first_reversals else self.rule.step_db
        wanted = self.level_db + (-step if felt else step)
        # At a limit the level stays; answers that ask for more are counted, and end the run.
        within = self.rule.lowest_db <= wanted <= self.rule.highest_db
        self._at_limit = 0 if within else self._at_limit + 1
        if within:
            self.level_db = wanted

    @property
    def threshold_db(self) -> float | None:
        """The mean of the reversals that count; None unless it was found."""
        if self.state != "found":
            return None
        counted = self.reversals_db[self.rule.first_reversals :]
        return sum(counted) / len(counted)
