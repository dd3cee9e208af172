# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: Identity, what it is, and Status, what it is doing (rtl/INTERFACE.md)."""
from dataclasses import dataclass

from .errors import device_error
from .interface import IDENTITY_FIELDS, IDENTITY_WORDS, NAME, STATUS_FIELDS, STATUS_UNTIMED_WORDS, STATUS_WORDS, VERSION, BitField, Mode, Role, unpack


def _unpack(fields: dict[str, BitField], words: list[str], data: bytes) -> dict[str, int]:
    if len(data) < 2 * len(words):
        raise device_error("board", "its reply is too short; it speaks another version of the protocol")
    return unpack(fields, data)


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
        values = _unpack(IDENTITY_FIELDS, IDENTITY_WORDS, data)
        name = data[:16].split(b"\0")[0].decode("ascii", "backslashreplace")
        major, minor = values.pop("version_major"), values.pop("version_minor")
        if name != NAME or major != VERSION[0]:
            raise device_error("board", f"it says it is '{name}' {major}.{minor}, expected '{NAME}' {VERSION[0]}.x")
        return cls(name=name, version=(major, minor), **values)


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
    period: int | None  # number of the carrier period at the pins since reset; None on boards that keep no time

    @classmethod
    def parse(cls, data: bytes) -> "Status":
        values = _unpack(STATUS_FIELDS, STATUS_WORDS[:STATUS_UNTIMED_WORDS], data)
        mode = Mode(values.pop("mode")).name.lower()
        period = values.pop("period") | values.pop("period_high") << STATUS_FIELDS["period"].width
        values["period"] = period if len(data) >= 2 * len(STATUS_WORDS) else None
        role = Role(values.pop("role")).name.lower()
        flags = {name: bool(values.pop(name)) for name in ("enabled", "stopped", "modulated", "in_step", "numbered", "waiting")}
        return cls(mode=mode, role=role, **flags, **values)
