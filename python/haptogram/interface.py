"""Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file."""
# SPDX-License-Identifier: Apache-2.0
import enum
from typing import NamedTuple

NAME = 'Haptogram'
VERSION = (2, 5)
PRIMARY_BASE = 0x00000000
SEQUENCE_BASE = 0x10000000
IDENTITY_BASE = 0x20000000
STATUS_BASE = 0x30000000
PARAMETERS_BASE = 0x50000000
GEOMETRY_BASE = 0x60000000
MODULATION_BASE = 0x70000000
RING_BASE = 0x80000000
STREAM_BASE = 0x90000000
TRIGGER_BASE = 0xa0000000
DESCRIPTION_BASE = 0x40000000
RECORD_HEADER_WORDS = 4
SILENT_TIMING = 0xffff
DESCRIPTION_MAGIC = 0x4748
DESCRIPTION_FORMAT = 1
DESCRIPTION_LONG_FORMAT = 2
LONGEST_CYCLE_S = 1.0
LINK_KEEP_ALIVE_MS = 100
LINK_KEEP_ALIVE_SHARE = 5
KNOWN_RATES = (3000000, 1000000, 115200)

IDENTITY_WORDS = ["name_0", "name_1", "name_2", "name_3", "name_4", "name_5", "name_6", "name_7", "version", "channels", "records", "sequence_depth", "live_depth", "bits", "clock_hz_low", "clock_hz_high", "features", "frame_bytes", "min_pulse_clocks", "max_pulse_clocks", "max_duty_256", "max_cycle_low", "max_cycle_high", "width_bits", "foci", "modulation_words"]
STATUS_WORDS = ["flags", "present_index", "underruns", "refused_records", "frames_good", "frames_damaged", "frames_repeated", "watchdog_trips", "guard_trips", "live_level", "watchdog_ms", "frames_refused", "bent_periods", "far_foci", "sync", "sync_misses", "sync_losses", "late_changes", "period_low", "period_middle", "period_high", "stream_late", "stream_lost", "stream_early", "stream_repeated"]
PARAMETERS_WORDS = ["foci_base", "foci_count", "foci_form", "foci_cycle", "wave_number_low", "wave_number_high", "gain", "slew_mode", "phase_rate", "amplitude_rate", "arrival_periods"]
RING_WORDS = ["base", "first", "count"]
STREAM_WORDS = ["first", "slot_form", "hold", "fade"]
TRIGGER_WORDS = ["out_form", "out_periods", "out_length_low", "out_length_high", "in_form", "in_least", "test_form", "test_channel", "now_low", "now_middle", "now_high", "out_count", "out_low", "out_middle", "out_high", "in_count", "in_low", "in_middle", "in_high"]
DESCRIPTION_WORDS = ["magic", "format", "channels", "records", "sequence_words", "bits", "clock_hz_low", "clock_hz_high", "board_records", "modulation_samples", "modulation_divider", "min_pulse_clocks"]

STATUS_UNTIMED_WORDS = 17  # of boards without schedule
STATUS_UNSTREAMED_WORDS = 21  # of boards without stream
TRIGGER_SETTINGS = 8  # words of the trigger block which a host may write


class BitField(NamedTuple):
    """Some bits of little-endian memory: `width` bits from bit `offset` on, counted from the beginning of its block."""

    offset: int
    width: int

    def get(self, data: bytes) -> int:
        end = self.offset + self.width
        return int.from_bytes(data[: (end + 7) // 8], "little") >> self.offset & (1 << self.width) - 1


def pack(fields: dict[str, BitField], size: int, **values: int) -> bytes:
    """A block of `size` bytes with these fields; all other bits are zero."""
    block = 0
    for name, value in values.items():
        field = fields[name]
        if not 0 <= value < 1 << field.width:
            raise ValueError(f"{name} is {value}, but its field has {field.width} bits, at most {(1 << field.width) - 1}")
        block |= value << field.offset
    return block.to_bytes(size, "little")


def unpack(fields: dict[str, BitField], data: bytes) -> dict[str, int]:
    """The value of every field."""
    return {name: field.get(data) for name, field in fields.items()}


RECORD_FIELDS = {
    "cycle_length": BitField(0, 24),
    "pulse_length": BitField(24, 8),
    "prescaler": BitField(32, 24),
    "kind": BitField(56, 8),
}
SEQUENCE_HEADER_FIELDS = {
    "length": BitField(0, 15),
    "autostart": BitField(15, 1),
    "loops": BitField(16, 16),
}
SEQUENCE_ENTRY_FIELDS = {
    "index": BitField(0, 15),
    "mark": BitField(15, 1),
    "dwell": BitField(16, 16),
}
IDENTITY_FIELDS = {
    "version_minor": BitField(128, 8),
    "version_major": BitField(136, 8),
    "channels": BitField(144, 16),
    "records": BitField(160, 16),
    "sequence_depth": BitField(176, 16),
    "live_depth": BitField(192, 16),
    "timing_bits": BitField(208, 8),
    "pulse_bits": BitField(216, 8),
    "clock_hz": BitField(224, 32),
    "features": BitField(256, 16),
    "frame_bytes": BitField(272, 16),
    "min_pulse_clocks": BitField(288, 16),
    "max_pulse_clocks": BitField(304, 16),
    "max_duty_256": BitField(320, 16),
    "max_cycle_clocks": BitField(336, 32),
    "width_bits": BitField(368, 16),
    "foci": BitField(384, 16),
    "modulation_words": BitField(400, 16),
}
STATUS_FIELDS = {
    "enabled": BitField(0, 1),
    "mode": BitField(1, 2),
    "stopped": BitField(3, 1),
    "modulated": BitField(4, 1),
    "waiting": BitField(5, 1),
    "streaming": BitField(6, 1),
    "flash": BitField(7, 2),
    "present_index": BitField(16, 16),
    "underruns": BitField(32, 16),
    "refused_records": BitField(48, 16),
    "frames_good": BitField(64, 16),
    "frames_damaged": BitField(80, 16),
    "frames_repeated": BitField(96, 16),
    "watchdog_trips": BitField(112, 16),
    "guard_trips": BitField(128, 16),
    "live_level": BitField(144, 16),
    "watchdog_ms": BitField(160, 16),
    "frames_refused": BitField(176, 16),
    "bent_periods": BitField(192, 16),
    "far_foci": BitField(208, 16),
    "role": BitField(224, 2),
    "in_step": BitField(226, 1),
    "numbered": BitField(227, 1),
    "sync_misses": BitField(240, 16),
    "sync_losses": BitField(256, 16),
    "late_changes": BitField(272, 16),
    "period": BitField(288, 32),
    "period_high": BitField(320, 16),
    "stream_late": BitField(336, 16),
    "stream_lost": BitField(352, 16),
    "stream_early": BitField(368, 16),
    "stream_repeated": BitField(384, 16),
}
PARAMETERS_FIELDS = {
    "foci_base": BitField(0, 16),
    "foci_count": BitField(16, 16),
    "foci_last": BitField(32, 3),
    "foci_whole": BitField(35, 1),
    "foci_cycle": BitField(48, 16),
    "wave_number": BitField(64, 18),
    "gain": BitField(96, 16),
    "slew": BitField(112, 2),
    "phase_rate": BitField(128, 16),
    "amplitude_rate": BitField(144, 16),
    "arrival": BitField(160, 12),
}
RING_FIELDS = {
    "base": BitField(0, 16),
    "first": BitField(16, 16),
    "count": BitField(32, 16),
}
STREAM_FIELDS = {
    "first": BitField(0, 16),
    "slot_bits": BitField(16, 4),
    "hold": BitField(32, 16),
    "fade": BitField(48, 16),
}
TRIGGER_FIELDS = {
    "event": BitField(0, 3),
    "out_periods": BitField(16, 16),
    "out_length": BitField(32, 24),
    "in_low": BitField(64, 1),
    "in_level": BitField(65, 1),
    "in_gates": BitField(66, 1),
    "in_least": BitField(80, 16),
    "test": BitField(96, 2),
    "test_channel": BitField(112, 16),
    "now": BitField(128, 32),
    "now_high": BitField(160, 16),
    "out_count": BitField(176, 16),
    "out": BitField(192, 32),
    "out_high": BitField(224, 16),
    "in_count": BitField(240, 16),
    "in": BitField(256, 32),
    "in_high": BitField(288, 16),
}
DESCRIPTION_FIELDS = {
    "magic": BitField(0, 16),
    "format": BitField(16, 16),
    "channels": BitField(32, 16),
    "records": BitField(48, 16),
    "sequence_words": BitField(64, 16),
    "timing_bits": BitField(80, 8),
    "pulse_bits": BitField(88, 8),
    "clock_hz": BitField(96, 32),
    "board_records": BitField(128, 16),
    "modulation_samples": BitField(144, 16),
    "modulation_divider": BitField(160, 16),
    "min_pulse_clocks": BitField(176, 16),
}


class Kind(enum.IntEnum):
    TIMINGS = 0
    AMPLITUDES = 1


class Feature(enum.IntEnum):
    SEQUENCE = 0
    LIVE = 1
    WATCHDOG = 2
    GUARD = 3
    AMPLITUDE = 4
    MODULATION = 5
    SLEW = 6
    FOCI = 7
    SCHEDULE = 8
    LIVE_FOCI = 9
    STREAM = 10
    TRIGGER = 11
    SYNC = 12
    CHAIN = 13
    NET = 14


class Mode(enum.IntEnum):
    IDLE = 0
    SINGLE = 1
    SEQUENCE = 2
    LIVE = 3


class Role(enum.IntEnum):
    ALONE = 0
    MASTER = 1
    SLAVE = 2


class Flash(enum.IntEnum):
    NONE = 0
    WHOLE = 1
    BROKEN = 2


class Event(enum.IntEnum):
    NONE = 0
    START = 1
    MARK = 2
    PASS = 3
    PERIOD = 4
    SAMPLES = 5


class Test(enum.IntEnum):
    OFF = 0
    CARRIER = 1
    CYCLE = 2
    INDEX = 3


class Command(enum.IntEnum):
    IDENTIFY = 0x01
    WRITE = 0x02
    READ = 0x03
    ENABLE = 0x04
    DISABLE = 0x05
    SELECT = 0x06
    PUSH = 0x07
    START = 0x08
    STOP = 0x09
    WATCHDOG = 0x0a
    STATUS = 0x0b
    DIGEST = 0x0c
    KEEP_ALIVE = 0x0d
    RESET = 0x0e
    MODULATE = 0x0f
    GATE = 0x10
    PUSH_FOCI = 0x11
    STREAM = 0x12
    SYNC = 0x18


class Status(enum.IntEnum):
    OK = 0x00
    REPEATED = 0x01
    UNKNOWN_COMMAND = 0x02
    BAD_LENGTH = 0x03
    OUT_OF_ORDER = 0x04
    BAD_ADDRESS = 0x05
    BAD_ALIGNMENT = 0x06
    BAD_INDEX = 0x07
    BAD_RANGE = 0x08
    FIFO_FULL = 0x09
    STOPPED = 0x0a
    GATE_BUSY = 0x0b
    SESSION_ENDED = 0x0c
    OUT_OF_STEP = 0x10
