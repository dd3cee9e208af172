# SPDX-License-Identifier: Apache-2.0
"""Who gets what in which order. All of it follows from the seed and the participant's number by SHA-256, so that a session that was cut
short goes on as it would have, on any machine and with any version of Python."""
import hashlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from .protocol import Level, Protocol, places

T = TypeVar("T")


def digest(*what: object) -> bytes:
    return hashlib.sha256("/".join(map(str, what)).encode()).digest()


def chance(*what: object) -> float:
    """A number in [0, 1), always the same for the same arguments."""
    return int.from_bytes(digest(*what)[:8], "big") / 2.0**64


def shuffled(items: Sequence[T], *what: object) -> list[T]:
    """The items in a random order, always the same for the same arguments."""
    return [item for _, item in sorted(enumerate(items), key=lambda pair: digest(*what, pair[0]))]


def latin_square(size: int) -> list[list[int]]:
    """Orders of 0 … size−1 in which each item stands equally often at each place and, over all rows, equally often directly behind each
    other item: size rows when size is even, otherwise twice as many (Williams 1949)."""
    first = [0]
    for step in range(1, size):
        first.append((first[-1] + (step if step % 2 else -step)) % size)
    rows = [[(item + shift) % size for item in first] for shift in range(size)]
    return rows + [row[::-1] for row in rows] if size % 2 and size > 1 else rows


@dataclass(frozen=True)
class Cell:
    """A trial, or with a staircase a run of it. `set` counts from 1 within its blocks."""

    number: int
    set: int
    levels: dict[str, Level]
    drawn: dict[str, float] = field(default_factory=dict)
    start: str = ""  # where a staircase begins

    @property
    def factors(self) -> dict[str, object]:
        return {name: level.value for name, level in self.levels.items()}


def _ordered(items: Sequence[T], how: str, row: int, *what: object) -> list[T]:
    if how == "fixed":
        return list(items)
    if how == "latin-square":
        rows = latin_square(len(items))
        return [items[i] for i in rows[row % len(rows)]]
    if how == "independent":
        return [items[int(chance(*what, place) * len(items))] for place in range(len(items))]
    return shuffled(items, *what)


def stimuli(protocol: Protocol, participant: int, seed: int) -> list[dict[str, object]]:
    """What placeholders stand for in all that a session can present: of a staircase, where it begins and its limits."""
    rule = protocol.staircase
    return [places(protocol, cell.levels, cell.drawn, level) for cell in cells(protocol, participant, seed)
            for level in ((rule.starts_db[cell.start], rule.lowest_db, rule.highest_db) if rule else (None,))]  # fmt: skip


def cells(protocol: Protocol, participant: int, seed: int) -> list[Cell]:
    """All trials of a participant, in order. Participants count from 1."""
    order, row, key = protocol.order, participant - 1, (seed, participant)
    blocked = [f for f in protocol.factors if f.name in order.blocked]
    mixed = [f for f in protocol.factors if f.name not in order.blocked]
    blocks = list(itertools.product(*(f.levels for f in blocked)))
    combinations = list(itertools.product(*(f.levels for f in mixed)))
    found: list[Cell] = []
    for block in _ordered(blocks, order.blocks, row, *key, "blocks"):
        named = {f.name: level for f, level in zip(blocked, block, strict=True)}
        within = [level.name for level in block]
        for number in range(1, order.sets + 1):
            trials = _ordered(combinations * order.repetitions, order.within, row + number - 1, *key, "set", *within, number)
            for trial in trials:
                levels = named | {f.name: level for f, level in zip(mixed, trial, strict=True)}
                place = len(found) + 1
                drawn = {d.name: d.at(chance(*key, "drawn", d.name, place)) for d in protocol.drawn}
                start = ""
                if protocol.staircase:
                    names = sorted(protocol.staircase.starts_db)
                    start = names[int(chance(*key, "start", place) * len(names))]
                found.append(Cell(place, number, {f.name: levels[f.name] for f in protocol.factors}, drawn, start))
    return found
