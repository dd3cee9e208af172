# SPDX-License-Identifier: Apache-2.0
"""A board's trigger pins and its test output (the trigger block of rtl/INTERFACE.md), and its clock as time of this computer."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from .board import Identity
from .errors import bad_input
from .interface import TRIGGER_FIELDS, TRIGGER_SETTINGS, TRIGGER_WORDS, Event, Test, pack, unpack

LEAST_WIDTH_S = 1e-7  # no question and its answer are shorter by any clock of a host, so no sample counts for ever


@dataclass(frozen=True)
class TriggerSettings:
    event: Event = Event.NONE  # what makes a pulse at the trigger output
    every_periods: int = 1  # of Event.PERIOD
    pulse_s: float = 1e-3
    active_low: bool = False  # the trigger input is active while it is low
    by_level: bool = False  # what waits for the trigger begins while it is active, too; not only when it becomes so
    gates: bool = False  # no pulse reaches the transducers while the trigger input is not active
    settle_s: float = 0.0  # for which a change of the input must last before it counts
    test: Test = Test.OFF
    channel: int = 0  # of Test.CARRIER

    def block(self, identity: Identity) -> bytes:
        if not 0 <= self.channel < identity.channels:
            raise bad_input("channel", f"{self.channel}, expected 0 to {identity.channels - 1}, a channel of this board")
        if not 1 <= self.every_periods <= 65535:
            raise bad_input("every_periods", f"{self.every_periods}, expected 1 to 65535 carrier periods")
        lengths = {}
        for name, field, seconds in (("pulse_s", "out_length", self.pulse_s), ("settle_s", "in_least", self.settle_s)):
            most = (1 << TRIGGER_FIELDS[field].width) - 1
            lengths[field] = round(seconds * identity.clock_hz)
            if not 0 <= lengths[field] <= most:
                raise bad_input(name, f"{seconds} s, expected 0 to {most / identity.clock_hz:g} s: the board counts {most} clocks at most")
        return pack(TRIGGER_FIELDS, 2 * TRIGGER_SETTINGS, event=self.event, out_periods=self.every_periods, in_low=self.active_low,
                    in_level=self.by_level, in_gates=self.gates, test=self.test, test_channel=self.channel, **lengths)  # fmt: skip


@dataclass(frozen=True)
class Trigger:
    """All of one moment; clocks count from the board's power-up, counts modulo 65,536."""

    now: int
    out_count: int
    out: int  # the clock of the last event at the trigger output
    in_count: int
    in_: int  # the clock in which the trigger input became active last

    @classmethod
    def of(cls, told: bytes) -> Self:
        """The words of the trigger block behind its settings."""
        assert len(told) == 2 * (len(TRIGGER_WORDS) - TRIGGER_SETTINGS)
        found = unpack(TRIGGER_FIELDS, bytes(2 * TRIGGER_SETTINGS) + told)
        now, out, in_ = (found[f"{name}_high"] << 32 | found[name] for name in ("now", "out", "in"))
        return cls(now, found["out_count"], out, found["in_count"], in_)


@dataclass(frozen=True)
class ClockSample:
    """A clock of the board that was told between two moments of this computer."""

    asked_s: float
    answered_s: float
    clock: int


@dataclass(frozen=True)
class ClockFit:
    """This computer's time as a line over the board's clock, through the middles of samples that count by how short they were."""

    origin: int
    origin_s: float
    s_per_clock: float
    error_s: float  # what the line can be off, if questions and answers take between nothing and all of their time
    spread_s: float  # how far the middles lie from the line, root mean square by their weights

    def host_s(self, clock: int) -> float:
        return self.origin_s + self.s_per_clock * (clock - self.origin)


def fit_clocks(samples: Sequence[ClockSample]) -> ClockFit:
    """Raises HaptogramError when there are fewer than two different clocks, an answer is before its question, or the board's clock
    goes back while this computer's goes on."""
    if any(sample.answered_s < sample.asked_s for sample in samples):
        raise bad_input("clock samples", "an answer is before its question; expected a clock that never goes back, such as time.monotonic()")
    if len({sample.clock for sample in samples}) < 2:
        raise bad_input("clock samples", f"{len(samples)} with no two different clocks, expected at least two")
    if any(b.asked_s >= a.answered_s and b.clock < a.clock for a, b in zip(samples, samples[1:])):
        raise bad_input("clock samples", "the board's clock goes back: it was switched off meanwhile; begin anew")
    origin = samples[0].clock
    widths = [max(sample.answered_s - sample.asked_s, LEAST_WIDTH_S) for sample in samples]
    weights = [1 / width**2 for width in widths]
    total = sum(weights)

    def mean(values: Sequence[float]) -> float:
        return sum(weight * value for weight, value in zip(weights, values)) / total

    first_s = (samples[0].asked_s + samples[0].answered_s) / 2
    clocks = [float(sample.clock - origin) for sample in samples]
    hosts = [(sample.asked_s + sample.answered_s) / 2 - first_s for sample in samples]
    clock, host = mean(clocks), mean(hosts)
    slope = mean([(x - clock) * (y - host) for x, y in zip(clocks, hosts)]) / mean([(x - clock) ** 2 for x in clocks])
    spread = mean([(y - host - slope * (x - clock)) ** 2 for x, y in zip(clocks, hosts)]) ** 0.5
    return ClockFit(origin, first_s + host - slope * clock, slope, mean(widths) / 2, spread)
