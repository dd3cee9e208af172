# SPDX-License-Identifier: Apache-2.0
"""One tile of a chain, whose boards pass one serial line on: see "A chain of tiles" in rtl/INTERFACE.md."""
from __future__ import annotations

from typing import TYPE_CHECKING

from .errors import ErrorCode, HaptogramError
from .interface import CHAIN_ALL, CHAIN_MOST_TILES

if TYPE_CHECKING:
    from .session import Line


def header(first: int) -> bytes:
    """What stands before a frame. `first` is 2 n + 1 for the n-th tile, or CHAIN_ALL."""
    return bytes([first, ~first & 0xFE | 1])


def split(port: str) -> tuple[str, int]:
    """The port and the number of the tile behind its last '#'; 0 when there is none, so that the board is alone."""
    path, mark, number = port.rpartition("#")
    if not mark or not path or not number.isascii() or not number.isdigit():
        return port, 0
    if not 1 <= int(number) <= CHAIN_MOST_TILES or split(path)[1]:
        raise HaptogramError(ErrorCode.USAGE, port, f"behind the port, one # and the number of a tile are expected, from 1 to {CHAIN_MOST_TILES}")
    return path, int(number)


class ChainedLine:
    """The line to one tile. Making it tells this tile and all before it that they are a chain, if they do not know yet."""

    def __init__(self, line: Line, number: int) -> None:
        self._line = line
        self._header = header(2 * number + 1)
        self._starts = True  # the next byte that is not 0 is the first of a frame
        self._frame = b""
        line.write(b"\0" + (header(CHAIN_ALL) + b"\0") * number)

    def write(self, data: bytes) -> None:
        out = bytearray()
        for byte in data:
            if byte and self._starts:
                out += self._header
            self._starts = byte == 0
            out.append(byte)
        self._line.write(bytes(out))

    def read(self, patience: float) -> bytes:
        """Whole frames of this tile. Those of others, and damaged ones, are left out."""
        while data := self._line.read(patience):
            *frames, self._frame = (self._frame + data).split(b"\0")
            mine = b"".join(frame[2:] + b"\0" for frame in frames if frame[:2] == self._header)
            if mine:
                return mine
        return b""

    def drain(self) -> None:
        self._frame = b""
        self._line.drain()

    def close(self) -> None:
        self._line.close()
