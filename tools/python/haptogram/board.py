# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: the identity and status blocks (rtl/INTERFACE.md)."""
from dataclasses import dataclass

from .errors import device_error
from .interface import IDENTITY_FIELDS, IDENTITY_WORDS, NAME, STATUS_FIELDS, STATUS_WORDS, VERSION, BitField, Mode, unpack

MODES = tuple(mode.name.lower() for mode in Mode)


def _unpack(fields: dict[str, BitField], words: list[str], data: bytes) -> dict[str, int]:
    if len(data) < 2 * len(words):
        raise device_error("board", "its reply is too short; it speaks another version of the protocol")
    return unpack(fields, data)


@dataclass(frozen=True)
class Identity:
    """Fixed at synthesis."""

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

    @classmethod
    def parse(cls, data: bytes) -> "Identity":
        fields = _unpack(IDENTITY_FIELDS, IDENTITY_WORDS, data)
        name = data[:16].split(b"\0")[0].decode("ascii", "backslashreplace")
        major, minor = fields.pop("version_major"), fields.pop("version_minor")
        if name != NAME or major != VERSION[0]:
            raise device_error("board", f"it says it is '{name}' {major}.{minor}, expected '{NAME}' {VERSION[0]}.x")
        return cls(name=name, version=(major, minor), **fields)


@dataclass(frozen=True)
class BoardStatus:
    """Counters run modulo 65,536."""

    enabled: bool
    mode: str  # one of MODES: where the next record comes from
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
    def parse(cls, data: bytes) -> "BoardStatus":
        fields = _unpack(STATUS_FIELDS, STATUS_WORDS, data)
        return cls(enabled=bool(fields.pop("enabled")), mode=MODES[fields.pop("mode")], **fields)
