# SPDX-License-Identifier: Apache-2.0
"""Frames as they go on the line (rtl/INTERFACE.md): COBS with a zero byte after it, a CRC-16/IBM-3740 inside."""
import binascii
import struct
from dataclasses import dataclass

from cobs import cobs

from .interface import Command, Status

REPLY = 0x80  # set in the command of a reply
HEADER = struct.Struct("<BBBBH")  # of a reply: sequence number, command, status, expected number, live level
LONGEST = 1 << 16  # a line that never sends a zero must not fill the memory


@dataclass(frozen=True)
class Request:
    """A command and its payload: arguments, then data."""

    command: Command
    payload: bytes = b""


@dataclass(frozen=True)
class Reply:
    sequence: int
    command: int
    status: int
    expected: int  # the next sequence number that the board would apply
    live_level: int  # entries in the live FIFO
    data: bytes

    def why(self) -> str:
        """Its status in words."""
        return Status(self.status).name.lower() if self.status in list(Status) else f"unknown status {self.status:#04x}"


def crc16(data: bytes) -> int:
    """Over data followed by its CRC, high byte first, it is 0."""
    return binascii.crc_hqx(data, 0xFFFF)


def encode_request(sequence: int, request: Request) -> bytes:
    frame = bytes([sequence, request.command]) + request.payload
    return bytes(cobs.encode(frame + crc16(frame).to_bytes(2, "big"))) + b"\0"


def decode_reply(code: bytes) -> Reply | None:
    """None when it is damaged."""
    try:
        frame = bytes(cobs.decode(code))
    except cobs.DecodeError:
        return None
    if len(frame) < HEADER.size + 2 or crc16(frame) != 0 or not frame[1] & REPLY:
        return None
    sequence, command, status, expected, level = HEADER.unpack_from(frame)
    return Reply(sequence, command & ~REPLY, status, expected, level, frame[HEADER.size : -2])


class ReplyDecoder:
    """Takes a byte stream apart into replies; whatever is damaged is counted and dropped, as the board does."""

    def __init__(self) -> None:
        self.damaged = 0
        self._rest = b""

    def feed(self, data: bytes) -> list[Reply]:
        *frames, rest = (self._rest + data).split(b"\0")
        self._rest = rest[:LONGEST]
        replies = [decode_reply(frame) for frame in frames if frame]
        self.damaged += replies.count(None)
        return [reply for reply in replies if reply]
