# SPDX-License-Identifier: Apache-2.0
"""What a board says of itself: Identity, what it is, and Status, what it is doing (rtl/INTERFACE.md)."""
import struct
from dataclasses import dataclass

from .errors import device_error
from .interface import IDENTITY_WORDS, NAME, STATUS_WORDS, VERSION

MODES = ("idle", "single", "sequence", "live")


def _words(names: list[str], data: bytes) -> dict[str, int]:
    if len(data) < 2 * len(names):
        raise device_error("board", "its reply is too short; it speaks another version of the protocol")
    return dict(zip(names, struct.unpack_from(f"<{len(names)}H", data), strict=True))


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

    @classmethod
    def parse(cls, data: bytes) -> "Identity":
        words = _words(IDENTITY_WORDS, data)
        name = data[:16].split(b"\0")[0].decode("ascii", "backslashreplace")
        major, minor = divmod(words["version"], 256)
        if name != NAME or major != VERSION[0]:
            raise device_error("board", f"it says it is '{name}' {major}.{minor}, expected '{NAME}' {VERSION[0]}.x")
        pulse_bits, timing_bits = divmod(words["bits"], 256)
        return cls(
            name=name, version=(major, minor), channels=words["channels"], records=words["records"],
            sequence_depth=words["sequence_depth"], live_depth=words["live_depth"], timing_bits=timing_bits, pulse_bits=pulse_bits,
            clock_hz=words["clock_hz_low"] | words["clock_hz_high"] << 16, features=words["features"], frame_bytes=words["frame_bytes"],
        )  # fmt: skip


@dataclass(frozen=True)
class Status:
    """What a board says it is doing. Counters begin at 0 again after 65,535."""

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
    def parse(cls, data: bytes) -> "Status":
        words = _words(STATUS_WORDS, data)
        flags = words.pop("flags")
        return cls(enabled=bool(flags & 1), mode=MODES[flags >> 1 & 3], **words)
