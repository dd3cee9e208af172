# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: Identity, what it is, and Status, what it is doing (rtl/INTERFACE.md)."""
from dataclasses import dataclass

from .errors import device_error
from .interface import (
    IDENTITY_FIELDS,
    IDENTITY_WORDS,
    NAME,
    PARAMETER_RANGES,
    RECORD_HEADER_WORDS,
    STATUS_FIELDS,
    STATUS_UNSTREAMED_WORDS,
    STATUS_UNTIMED_WORDS,
    STATUS_WORDS,
    VERSION,
    Feature,
    Flash,
    Mode,
    Role,
    unpack,
)

NAME_BYTES = 16


def _require_parameters(values: dict[str, int], where: str) -> None:
    """What the identity says of the core's parameters is checked against their ranges."""
    said = values | {"modulation_depth": 2 * values["modulation_words"]}
    for name in said.keys() & PARAMETER_RANGES.keys():
        low, high, power_of_two, optional = PARAMETER_RANGES[name]
        value = said[name]
        if low <= value <= high and (not power_of_two or value & value - 1 == 0) or optional and value == 0:
            continue
        expected = f"{'a power of two from ' if power_of_two else ''}{low} to {high}{', or 0' if optional else ''}"
        raise device_error(where, f"the board says that its {name} is {value}, expected {expected}; is it a Haptogram?")


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
    def parse(cls, data: bytes, where: str = "board") -> "Identity":
        """Raises HaptogramError when a field is outside of its range. `where` names the port in messages."""
        # Name and version come first in every version of the protocol; what follows them may be shorter in another one.
        values = unpack(IDENTITY_FIELDS, data)
        name = data[:NAME_BYTES].rstrip(b"\0").decode("ascii", "backslashreplace")
        major, minor = values.pop("version_major"), values.pop("version_minor")
        if name != NAME or major != VERSION[0]:
            raise device_error(where, f"the board says it is {name!r} {major}.{minor}, expected '{NAME}' {VERSION[0]}.x")
        if len(data) != 2 * len(IDENTITY_WORDS):
            raise device_error(where, f"the board's identity has {len(data)} bytes, expected {2 * len(IDENTITY_WORDS)}")
        _require_parameters(values, where)
        least = 2 * (values["channels"] + RECORD_HEADER_WORDS) + 6  # a record, its address, number and command
        if values["frame_bytes"] < least:
            raise device_error(where, f"the board says that its frame_bytes is {values['frame_bytes']}, but a record takes {least}")
        return cls(name=name, version=(major, minor), **values)

    @property
    def status_bytes(self) -> int:
        """Length of its status block."""
        if self.features >> Feature.STREAM & 1:
            return 2 * len(STATUS_WORDS)
        return 2 * (STATUS_UNSTREAMED_WORDS if self.features >> Feature.SCHEDULE & 1 else STATUS_UNTIMED_WORDS)


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
    def parse(cls, data: bytes, board: Identity, where: str = "board") -> "Status":
        """Raises HaptogramError when a field has no meaning. `data` has the length that the board's identity promises."""
        values = unpack(STATUS_FIELDS, data)
        if values["live_level"] > board.live_depth:
            raise device_error(where, f"the board says that its live_level is {values['live_level']}, expected 0 to {board.live_depth}")
        mode = Mode(values.pop("mode")).name.lower()
        period = values.pop("period") | values.pop("period_high") << STATUS_FIELDS["period"].width
        values["period"] = period if len(data) >= 2 * STATUS_UNSTREAMED_WORDS else None
        if values["role"] not in list(Role):
            raise device_error(where, f"the board says that its role is {values['role']}, expected 0 to {max(Role)}")
        role = Role(values.pop("role")).name.lower()
        if values["flash"] not in list(Flash):
            raise device_error(where, f"the board says that its flash is {values['flash']}, expected 0 to {max(Flash)}")
        flash = Flash(values.pop("flash")).name.lower()
        flags = {name: bool(values.pop(name)) for name in ("enabled", "stopped", "modulated", "in_step", "numbered", "waiting", "streaming")}
        return cls(mode=mode, role=role, flash=flash, **flags, **values)
