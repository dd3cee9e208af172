# SPDX-License-Identifier: Apache-2.0
"""Foci from which a board itself computes phases and amplitudes, and its modulation (rtl/INTERFACE.md)."""
import math
import struct
from collections.abc import Sequence
from typing import NamedTuple

from .board import Identity
from .errors import bad_input
from .interface import PARAMETERS_FIELDS

UNITS_A_MM = 128
FOCUS_BYTES = 8


def _rounded(value: float) -> int:
    """Halves away from zero, as the compiler rounds them."""
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


class Focus(NamedTuple):
    """A focal point in the array's frame."""

    x_mm: float
    y_mm: float
    z_mm: float
    amplitude: float = 1.0  # 0 to 1

    @classmethod
    def at(cls, place_m: Sequence[float], amplitude: float = 1.0) -> "Focus":
        """At x, y and z in metres. Raises HaptogramError for a place that is farther away than a board can say."""
        x, y, z = map(float, place_m)
        if max(abs(x), abs(y), abs(z)) > 1.024:
            meant = f"({x / 1000:g}, {y / 1000:g}, {z / 1000:g})"
            raise bad_input("place_m", f"({x:g}, {y:g}, {z:g}) m is too far away; lengths are metres: did you mean {meant}?")
        return cls(1000 * x, 1000 * y, 1000 * z, amplitude)

    def pack(self) -> bytes:
        """Raises HaptogramError for a number that the board cannot hold."""
        if not 0 <= self.amplitude <= 1:
            raise bad_input("focus", f"an amplitude of {self.amplitude}, expected 0 to 1")
        units = []
        for axis, length in zip("xyz", self[:3], strict=True):
            units.append(_rounded(length * UNITS_A_MM) if -1024 <= length <= 1024 else 1 << 17)
            if units[-1] == 1 << 17:
                raise bad_input("focus", f"{axis} is {length} mm, expected -1024 to less than 1024")
        high = sum((unit >> 16 & 3) << 2 * axis for axis, unit in enumerate(units))
        return struct.pack("<4H", *(unit & 0xFFFF for unit in units), _rounded(255 * self.amplitude) << 8 | high)

    @classmethod
    def unpack(cls, data: bytes) -> "Focus":
        *low, last = struct.unpack("<4H", data)
        units = [(word | (last >> 2 * axis & 3) << 16 ^ 0x20000) - 0x20000 for axis, word in enumerate(low)]
        return cls(*(unit / UNITS_A_MM for unit in units), (last >> 8) / 255)


class Modulation(NamedTuple):
    """Samples by which the board multiplies all amplitudes, over and over; 255 leaves them as they are."""

    divider: int  # carrier periods a sample
    samples: bytes

    @property
    def words(self) -> bytes:
        return self.samples + b"\xff" * (len(self.samples) % 2)


class FocusRecords(NamedTuple):
    """Records of one to eight foci, behind the other records in primary memory, and what the board computes them with."""

    board_records: int  # the board's RECORDS; the first of these has the next index
    parameters: bytes  # the parameters block
    geometry: bytes  # x, y, z, phase and weight of each channel
    data: bytes  # the foci

    def _parameter(self, name: str) -> int:
        return PARAMETERS_FIELDS[name].get(self.parameters)

    @property
    def base(self) -> int:
        """Where they begin, in bytes."""
        return 8 * self._parameter("foci_base")

    @property
    def count(self) -> int:
        return self._parameter("foci_count")

    @property
    def each(self) -> int:
        """Foci of a record."""
        return self._parameter("foci_last") + 1

    @property
    def records(self) -> list[list[Focus]]:
        foci = [Focus.unpack(self.data[at : at + FOCUS_BYTES]) for at in range(0, len(self.data), FOCUS_BYTES)]
        return [foci[at : at + self.each] for at in range(0, len(foci), self.each)]

    def has(self, index: int) -> bool:
        return self.board_records < index <= self.board_records + self.count

    def fits(self, board: Identity) -> Sequence[tuple[bool, str]]:
        """What must hold for a board, and what is wrong if it does not."""
        cycle, room = self._parameter("foci_cycle"), 2 * board.records * (board.channels + 4)
        least, most = 2 * (board.channels + 44), 2 * min((1 << board.width_bits) - 1, board.max_pulse_clocks)
        return (
            (board.version >= (2, 5) or not any(self.geometry[6::8]),
             "the image's channels have weights, and the board is of a protocol older than 2.5, which knows none"),
            (board.foci > 0, "the image has focus records, the board computes no foci"),
            (self.each <= board.foci, f"the image has {self.each} foci a record, the board takes {board.foci}"),
            (self.board_records == board.records,
             f"the image's focus records begin behind index {self.board_records}, those of the board behind {board.records}"),
            (least <= cycle <= most, f"the foci have a cycle of {cycle} clocks, the board plays {least} to {most} with amplitudes"),
            (self.base + len(self.data) <= room, f"the image fills {self.base + len(self.data)} bytes of primary memory, the board has {room}"),
        )  # fmt: skip
