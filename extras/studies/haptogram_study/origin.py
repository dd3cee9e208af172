# SPDX-License-Identifier: Apache-2.0
"""Where results are from: people or simulated observers, whole sessions or parts, stimuli that were played or not. Only what is alike can be
pooled without a word; what else is pooled must be asked for, and every output says it."""
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from haptogram.errors import HaptogramError, bad_input
from .protocol import Protocol
from .session import Record

PEOPLE = ("keyboard", "page")
MOST_NAMED = 6
BROKEN = (KeyError, TypeError, ValueError, StopIteration, OverflowError)  # what reading a record that was changed can raise


def _listed(names: Iterable[str]) -> str:
    different = list(dict.fromkeys(names))
    more = len(different) - MOST_NAMED
    return ", ".join(different[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def of_protocol(protocol: Protocol, where: str, record: Record) -> None:
    """Raises HaptogramError when a record is of another protocol."""
    if record.get("protocol") != protocol.name or record.get("protocol_sha256") != protocol.sha256:
        raise bad_input(where, f"is of protocol {str(record.get('protocol'))[:40]!r}, {str(record.get('protocol_sha256'))[:12]}; expected {protocol.name!r}, "
                        f"{protocol.sha256[:12]}; analyse it with the file that it was made with")  # fmt: skip


def incomplete(where: str, error: Exception) -> HaptogramError:
    return bad_input(where, f"is no complete record ({type(error).__name__}: {error}); the file was changed")


@dataclass
class Part:
    """What the results have of a participant's session."""

    participant: int
    observer: str
    made_for: str  # what its stimuli were made for, in words; "" where the protocol alone says it
    files: list[str] = field(default_factory=list)
    done: set[int] = field(default_factory=set)  # trials, or with a staircase its runs
    asked: set[tuple[str, str]] = field(default_factory=set)  # questions at the end, with the level that each is about
    presented: int = 0  # answers to a stimulus
    silent: int = 0  # of them, those whose stimulus was not played

    @property
    def by_people(self) -> bool:
        return self.observer in PEOPLE

    @property
    def kind(self) -> str:
        return ("people" if self.by_people else self.observer) + (f" ({self.made_for})" if self.made_for else "")

    def __str__(self) -> str:
        return f"{_listed(self.files)}: participant {self.participant}"


def _read(part: Part, protocol: Protocol, where: str, record: Record) -> None:
    kind, trial = record["kind"], record["trial"]
    file = where.rpartition(":")[0] or where
    if file not in part.files:
        part.files.append(file)
    if kind == "question":
        each = protocol.question(record["question"]).each
        part.asked.add((record["question"], str(record["factors"][each]) if each else ""))
        return
    if kind not in ("trial", "threshold"):
        raise ValueError(f"{str(kind)[:40]!r} is no kind of record")
    if not isinstance(trial, int) or not 1 <= trial <= protocol.trials:
        raise ValueError(f"trial {str(trial)[:40]} is not one of {protocol.trials}")
    if kind == ("threshold" if protocol.staircase else "trial"):
        part.done.add(trial)
    if kind == "trial":
        played = record["stimulus"]["played"]
        if not isinstance(played, bool):
            raise ValueError(f"played is {str(played)[:40]!r}")
        part.presented += 1
        part.silent += not played


@dataclass(frozen=True)
class Origin:
    """The sessions that results are of."""

    protocol: Protocol
    parts: tuple[Part, ...]

    @property
    def observers(self) -> dict[str, int]:
        """How many participants each had."""
        return dict(Counter(part.observer for part in self.parts))

    @property
    def simulated(self) -> bool:
        """Whether any answer is not of a person."""
        return not all(part.by_people for part in self.parts)

    @property
    def mixed(self) -> bool:
        return len({part.kind for part in self.parts}) > 1

    @property
    def _trials(self) -> int:
        return self.protocol.trials if any(q.when == "trial" for q in self.protocol.questions) else 0

    @property
    def _questions(self) -> int:
        return sum(len(self.protocol.factor(q.each).levels) if q.each else 1 for q in self.protocol.questions if q.when == "end")

    @property
    def unfinished(self) -> list[Part]:
        return [part for part in self.parts if len(part.done) < self._trials or len(part.asked) < self._questions]

    def has(self, part: Part) -> str:
        """How much of its session, in words."""
        counts = [f"{len(part.done)} of {self._trials} {'thresholds' if self.protocol.staircase else 'trials'}"] if self._trials else []
        counts += [f"{len(part.asked)} of {self._questions} answers at the end"] if self._questions else []
        return f"{part} has {' and '.join(counts)}"

    def refuse(self, *, mixed: bool = False, unfinished: bool = False) -> None:
        """Raises HaptogramError when results do not go together, but for those that were asked for."""
        if self.mixed and not mixed:
            kinds: dict[str, list[str]] = {}
            for part in self.parts:
                kinds.setdefault(part.kind, []).extend(part.files)
            whose = "; ".join(f"{_listed(files)} of {kind}" for kind, files in kinds.items())
            raise bad_input("results", f"found answers that do not go together ({whose}), expected those of people, or of one simulated observer, to stimuli made for one board; analyse them apart, "
                            "or ask by --mixed for a mixture, which is labelled as one")  # fmt: skip
        for number, sessions in Counter(part.participant for part in self.parts).items():
            if sessions > 1:
                files = _listed(file for part in self.parts if part.participant == number for file in part.files)
                raise bad_input(files, f"found {sessions} sessions of participant {number}, with other seeds or observers; expected one; leave out the others, or give each "
                                "person a number of their own")  # fmt: skip
        if self.unfinished and not unfinished:
            named = "; ".join(map(self.has, self.unfinished[:MOST_NAMED])) + ("; and others" if len(self.unfinished) > MOST_NAMED else "")
            raise bad_input("results", f"found sessions that are not finished ({named}); let 'run' go on with them, leave them out, or ask for them by --unfinished, which "
                            "labels them")  # fmt: skip

    @property
    def labels(self) -> list[str]:
        """What must be said before any number."""
        counts = Counter(part.kind for part in sorted(self.parts, key=lambda part: not part.by_people))
        whose = [f"{count} {name.replace('people', 'person', count == 1)}" if name.startswith("people") else f"{count} × {name}" for name, count in counts.items()]
        said = "answers of " + ", ".join(whose)
        found = [f"MIXED: {said}; no result of a study" if self.mixed else f"SIMULATED: {said}; no person was asked, this is no result" if self.simulated else said]
        if self.unfinished:
            found.append(f"UNFINISHED: {'; '.join(map(self.has, self.unfinished))}")
        presented, silent = self._played()
        if silent and self.protocol.stimulus.compile:
            whose_silent = "; ".join(str(part) for part in self.parts if part.by_people and part.silent)
            found.append(f"NOT PLAYED: nothing was played in {silent} of {presented} trials of people ({whose_silent}); answers without a stimulus are no result")
        elif silent:
            found.append("NOT PLAYED: nothing was played by this program; another apparatus presents this protocol's stimuli, and the results do not show that it did")
        return found

    def _played(self) -> tuple[int, int]:
        return sum(p.presented for p in self.parts if p.by_people), sum(p.silent for p in self.parts if p.by_people)

    def as_json(self) -> dict[str, Any]:
        presented, silent = self._played()
        unfinished = [{"files": p.files, "participant": p.participant, "trials": len(p.done), "of_trials": self._trials, "answers_at_end": len(p.asked),
                       "of_answers_at_end": self._questions} for p in self.unfinished]  # fmt: skip
        return {"simulated": self.simulated, "mixed": self.mixed, "labels": self.labels, "observers": self.observers, "unfinished": unfinished,
                "not_played": {"trials": silent, "of": presented}}  # fmt: skip


def of(protocol: Protocol, records: Sequence[tuple[str, Record]]) -> Origin:
    """Raises HaptogramError when a record is of another protocol, or does not say where it is from."""
    parts: dict[tuple[object, ...], Part] = {}
    for where, record in records:
        of_protocol(protocol, where, record)
        try:
            participant, observer, seed = int(record["participant"]), record["observer"], record["seed"]
            if not isinstance(observer, str) or not (observer in PEOPLE or observer.startswith("simulated:")):
                raise ValueError(f"observer is {str(observer)[:40]!r}, expected {', '.join(PEOPLE)} or simulated:…")
            told = dict(record.get("made_for", {}))
            fitted = dict(told.pop("fitted", {}))
            made_for = ", ".join(f"{name} {value}" for name, value in (told | fitted).items())
            _read(parts.setdefault((participant, observer, str(seed), made_for), Part(participant, observer, made_for)), protocol, where, record)
        except BROKEN as error:
            raise incomplete(where, error) from error
    return Origin(protocol, tuple(parts.values()))
