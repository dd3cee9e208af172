# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: Identity, what it is, and Status, what it is doing (rtl/INTERFACE.md)."""
from dataclasses import dataclass

from .interface import IDENTITY_FIELDS, STATUS_FIELDS, STATUS_UNSTREAMED_WORDS, Flash, Mode, Role, unpack

NAME_BYTES = 16


@dataclass(frozen=True)
class Identity:
    """What a board says it is; fixed when its FPGA was synthesised."""

    name: str
    version: tuple[int, int]
    channels: int
    records: int
    sequence_depth: int
    live_depth: int
    timing_bits: int
    pulse_bits: int
    clock_hz: int
    features: int
    frame_bytes: int
    min_pulse_clocks: int
    max_pulse_clocks: int
    max_duty_256: int
    max_cycle_clocks: int
    width_bits: int  # of a channel's own pulse width; 0: the pulses of a record have one length
    foci: int  # most foci of a focus record
    modulation_words: int  # of two samples

    @classmethod
    def parse(cls, data: bytes) -> "Identity":
        """The library has looked at its length and at its fields' ranges."""
        values = unpack(IDENTITY_FIELDS, data)
        version = values.pop("version_major"), values.pop("version_minor")
        return cls(name=data[:NAME_BYTES].rstrip(b"\0").decode("ascii"), version=version, **values)


@dataclass(frozen=True)
class Status:
    """What a board says it is doing. Counters begin at 0 again after 65,535."""

    enabled: bool
    stopped: bool  # by the stop input: outputs stay off
    mode: str  # a name of Mode, in lower case: where the next record comes from
    present_index: int
    underruns: int
    refused_records: int
    frames_good: int
    frames_damaged: int
    frames_repeated: int
    watchdog_trips: int
    guard_trips: int
    live_level: int
    watchdog_ms: int
    frames_refused: int
    modulated: bool  # the modulation runs
    bent_periods: int
    far_foci: int
    role: str  # a name of Role, in lower case
    in_step: bool  # of a slave: its carrier cycles begin with the master's
    numbered: bool  # they have the master's numbers, too
    sync_misses: int
    sync_losses: int
    waiting: bool  # a start, a modulation or pushed indices wait for their time
    late_changes: int  # that came too late for their carrier period
    streaming: bool  # a stream plays; the next four count its patterns that did not play in their period
    stream_late: int
    stream_lost: int
    stream_early: int
    stream_repeated: int
    flash: str  # a name of Flash, in lower case
    period: int | None  # number of the carrier period at the pins since reset; None on boards that keep no time

    @classmethod
    def parse(cls, data: bytes) -> "Status":
        """The library has looked at its length and at its fields' meanings."""
        values = unpack(STATUS_FIELDS, data)
        period = values.pop("period") | values.pop("period_high") << STATUS_FIELDS["period"].width
        values["period"] = period if len(data) >= 2 * STATUS_UNSTREAMED_WORDS else None
        names = {name: kind(values.pop(name)).name.lower() for name, kind in (("mode", Mode), ("role", Role), ("flash", Flash))}
        flags = {name: bool(values.pop(name)) for name in ("enabled", "stopped", "modulated", "in_step", "numbered", "waiting", "streaming")}
        return cls(**names, **flags, **values)
