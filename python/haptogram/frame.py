# SPDX-License-Identifier: Apache-2.0
"""Frames as they go on the line (rtl/INTERFACE.md): COBS with a zero byte after it, a CRC-16/IBM-3740 inside."""
import binascii
import struct
from dataclasses import dataclass

from cobs import cobs

from .interface import Command, Status

REPLY = 0x80  # set in the command of a reply
HEADER = struct.Struct("<BBBBH")  # of a reply: sequence number, command, status, expected number, live level
LONGEST = 4096  # bytes of a frame on the line; a reply with the longest record has some 2,030


@dataclass(frozen=True)
class Request:
    """A command, its payload (arguments, then data), and how many bytes of data its reply carries; None: whoever asks judges them."""

    command: Command
    payload: bytes = b""
    answer: int | None = 0


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


class Splitter:
    """Takes a byte stream apart at its zeros. What is longer than any frame is left out, so a line without zeros fills no memory."""

    def __init__(self) -> None:
        self._rest = bytearray()
        self._too_long = False

    def feed(self, data: bytes) -> list[bytes]:
        """The frames that are whole now; an empty one where a longer one was."""
        frames = []
        *ends, rest = data.split(b"\0")
        for end in ends:
            self._extend(end)
            frames.append(bytes(self._rest))
            self.clear()
        self._extend(rest)
        return frames

    def clear(self) -> None:
        self._rest.clear()
        self._too_long = False

    def _extend(self, data: bytes) -> None:
        self._too_long |= len(self._rest) + len(data) > LONGEST
        if self._too_long:
            self._rest.clear()
        else:
            self._rest += data


class ReplyDecoder:
    """Takes a byte stream apart into replies; whatever is damaged is counted and dropped, as the board does."""

    def __init__(self) -> None:
        self.damaged = 0
        self._splitter = Splitter()

    def feed(self, data: bytes) -> list[Reply]:
        replies = [decode_reply(frame) for frame in self._splitter.feed(data) if frame]
        self.damaged += replies.count(None)
        return [reply for reply in replies if reply]
