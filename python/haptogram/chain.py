# SPDX-License-Identifier: Apache-2.0
"""One tile of a chain, whose boards pass one serial line on: see "A chain of tiles" in rtl/INTERFACE.md."""
from __future__ import annotations

from typing import TYPE_CHECKING

from .errors import ErrorCode, HaptogramError
from .frame import Splitter
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
        self.path = f"{line.path}#{number}"
        self._line = line
        self._number = number
        self._header = header(2 * number + 1)
        self._starts = True  # the next byte that is not 0 is the first of a frame
        self._splitter = Splitter()
        self._make_chain()

    def _make_chain(self) -> None:
        self._line.write(b"\0" + (header(CHAIN_ALL) + b"\0") * self._number)

    def _with_headers(self, data: bytes) -> bytes:
        first, *others = data.split(b"\0")
        whole = [self._header + first if first and self._starts else first, *(self._header + other if other else other for other in others)]
        self._starts = not others[-1] if others else self._starts and not first
        return b"\0".join(whole)

    def write(self, data: bytes) -> None:
        self._line.write(self._with_headers(data))

    def urge(self, data: bytes) -> None:
        self._starts = True  # what was not yet out is dropped, and `data` begins with a zero
        self._line.urge(self._with_headers(data))

    def send_break(self, bits: int) -> None:
        """Each tile passes on a break that is half a bit shorter. It ends the chain, which is made anew."""
        self._line.send_break(bits + self._number)
        self._make_chain()

    def read(self, patience: float) -> bytes:
        """Whole frames of this tile, if such have arrived. Those of others, and damaged ones, are left out."""
        frames = self._splitter.feed(self._line.read(patience))
        return b"".join(frame[2:] + b"\0" for frame in frames if frame[:2] == self._header)

    def drain(self) -> None:
        self._splitter.clear()
        self._line.drain()

    def close(self) -> None:
        self._line.close()
