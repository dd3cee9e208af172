# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: Identity, what it is, and Status, what it is doing (rtl/INTERFACE.md)."""
from dataclasses import dataclass

from .errors import device_error
from .interface import IDENTITY_FIELDS, IDENTITY_WORDS, NAME, STATUS_FIELDS, STATUS_WORDS, VERSION, BitField, Mode, unpack


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

    @classmethod
    def parse(cls, data: bytes) -> "Status":
        values = _unpack(STATUS_FIELDS, STATUS_WORDS, data)
        mode = Mode(values.pop("mode")).name.lower()
        return cls(enabled=bool(values.pop("enabled")), stopped=bool(values.pop("stopped")), mode=mode, **values)
