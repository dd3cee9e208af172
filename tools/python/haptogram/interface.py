"""Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file."""
# SPDX-License-Identifier: Apache-2.0
import enum

NAME = 'Haptogram'
VERSION = (1, 1)
PRIMARY_BASE = 0x00000000
SEQUENCE_BASE = 0x10000000
IDENTITY_BASE = 0x20000000
STATUS_BASE = 0x30000000
DESCRIPTION_BASE = 0x40000000
RECORD_HEADER_WORDS = 4
SILENT_TIMING = 0xffff
AUTOSTART_BIT = 1 << 15  # of the sequence header
IDENTITY_WORDS = ["name_0", "name_1", "name_2", "name_3", "name_4", "name_5", "name_6", "name_7", "version", "channels", "records", "sequence_depth", "live_depth", "bits", "clock_hz_low", "clock_hz_high", "features", "frame_bytes"]
STATUS_WORDS = ["flags", "present_index", "underruns", "refused_records", "frames_good", "frames_damaged", "frames_repeated", "watchdog_trips", "guard_trips", "live_level", "watchdog_ms", "frames_refused"]
DESCRIPTION_WORDS = ["magic", "format", "channels", "records", "sequence_words", "bits", "clock_hz_low", "clock_hz_high"]


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
