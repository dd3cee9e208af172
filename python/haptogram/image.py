# SPDX-License-Identifier: Apache-2.0
"""An image: what a board's memories are loaded with, and what board it was compiled for (rtl/INTERFACE.md)."""
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from . import hexfile
from .board import Identity
from .errors import bad_input
from .foci import FocusRecords, Modulation
from .interface import (
    DESCRIPTION_BASE,
    DESCRIPTION_FIELDS,
    DESCRIPTION_FORMAT,
    DESCRIPTION_LONG_FORMAT,
    DESCRIPTION_MAGIC,
    DESCRIPTION_WORDS,
    GEOMETRY_BASE,
    LONGEST_CYCLE_S,
    MODULATION_BASE,
    PARAMETERS_BASE,
    PARAMETERS_WORDS,
    PRIMARY_BASE,
    RECORD_FIELDS,
    RECORD_HEADER_WORDS,
    SEQUENCE_BASE,
    SEQUENCE_ENTRY_FIELDS,
    SEQUENCE_HEADER_FIELDS,
    Feature,
    Kind,
    pack,
    unpack,
)

HIGHEST_INDEX = (1 << SEQUENCE_ENTRY_FIELDS["index"].width) - 1  # of an entry
HEADER_BYTES = 2 * RECORD_HEADER_WORDS
SHORT_DESCRIPTION_WORDS = DESCRIPTION_FIELDS["board_records"].offset // 16  # of the format that knows records and a sequence alone


class Piece(NamedTuple):
    """What one frame carries of an image."""

    address: int
    data: bytes


class Record(NamedTuple):
    """One focal point as the FPGA stores it."""

    cycle_length: int  # ticks
    prescaler: int  # clocks per tick
    pulse_length: int  # ticks
    timings: Sequence[int]  # one a channel; SILENT_TIMING never fires; of Kind.AMPLITUDES: {amplitude, phase}
    kind: int = Kind.TIMINGS

    def pack(self) -> bytes:
        header = pack(RECORD_FIELDS, HEADER_BYTES, cycle_length=self.cycle_length, prescaler=self.prescaler, pulse_length=self.pulse_length,
                      kind=self.kind)  # fmt: skip
        return header + struct.pack(f"<{len(self.timings)}H", *self.timings)

    @classmethod
    def unpack(cls, data: bytes) -> "Record":
        header = unpack(RECORD_FIELDS, data)
        return cls(**header, timings=list(struct.unpack_from(f"<{len(data) // 2 - RECORD_HEADER_WORDS}H", data, HEADER_BYTES)))


@dataclass(frozen=True, repr=False)
class Image:
    channels: int
    clock_hz: int
    timing_bits: int
    pulse_bits: int
    primary: bytes  # records, one after the other
    sequence: bytes  # the header, then the entries
    foci: FocusRecords | None = None  # for boards that compute foci
    modulation: Modulation | None = None  # for boards that modulate
    min_pulse_clocks: int = 1  # of a pulse with an amplitude; the board's MIN_PULSE_CLOCKS

    def __repr__(self) -> str:
        foci = f", {self.foci.count} of foci" if self.foci else ""
        return f"<Image: {len(self.records)} records{foci}, {len(self.entries)} entries, {self.channels} channels at {self.clock_hz / 1e6:g} MHz>"

    @property
    def record_bytes(self) -> int:
        return 2 * (self.channels + RECORD_HEADER_WORDS)

    @property
    def records(self) -> list[Record]:
        """The paper's record i is records[i - 1]."""
        return [Record.unpack(piece.data) for piece in _cut(PRIMARY_BASE, self.primary, self.record_bytes)]

    @property
    def entries(self) -> list[tuple[int, int]]:
        """Index and dwell of each step of the sequence."""
        return [(index & HIGHEST_INDEX, dwell) for index, dwell in struct.iter_unpack("<HH", self.sequence)][1:]

    @property
    def has_marks(self) -> bool:
        """Whether an entry's beginning is to be told at a trigger output."""
        return any(index > HIGHEST_INDEX for index, _ in list(struct.iter_unpack("<HH", self.sequence))[1:])

    @property
    def has_amplitudes(self) -> bool:
        """Whether its channels have amplitudes of their own."""
        return self.foci is not None or any(record.kind == Kind.AMPLITUDES for record in self.records)

    def pieces(self) -> list[Piece]:
        """A record a frame, and all else in pieces no longer."""
        size = self.record_bytes // 4 * 4
        primary = self.primary.ljust(self.foci.base, b"\0") if self.foci else self.primary
        found = _cut(PRIMARY_BASE, primary, self.record_bytes) + _cut(SEQUENCE_BASE, self.sequence, size)
        if self.foci:
            found += _cut(PRIMARY_BASE + self.foci.base, self.foci.data, size) + _cut(PARAMETERS_BASE, self.foci.parameters, size)
        if self.modulation:
            found += _cut(MODULATION_BASE, self.modulation.words, size)
        return found

    def unread_pieces(self) -> list[Piece]:
        """What can be written and not be read back: the geometry of foci."""
        return _cut(GEOMETRY_BASE, self.foci.geometry, self.record_bytes // 4 * 4) if self.foci else []

    def require_fits(self, board: Identity, where: str) -> None:
        """Raises HaptogramError saying why it does not fit the board."""
        for fits, what in (
            (self.channels == board.channels, f"the image is for {self.channels} channels, the board has {board.channels}"),
            (self.clock_hz == board.clock_hz, f"the image is for a {self.clock_hz} Hz clock, the board has {board.clock_hz} Hz"),
            (self.timing_bits <= board.timing_bits, f"the image needs {self.timing_bits} timing bits, the board has {board.timing_bits}"),
            (self.pulse_bits <= board.pulse_bits, f"the image needs {self.pulse_bits} pulse bits, the board has {board.pulse_bits}"),
            (len(self.records) <= board.records, f"the image has {len(self.records)} records, the board holds {board.records}"),
            (len(self.entries) < board.sequence_depth,
             f"the image has {len(self.entries)} sequence entries, the board holds {board.sequence_depth - 1}"),
            (board.features >> Feature.TRIGGER & 1 or not self.has_marks, "the image marks entries for a trigger output, the board has none"),
            (board.width_bits > 0 or all(record.kind == Kind.TIMINGS for record in self.records),
             "the image has records of amplitudes, the board has no amplitudes"),
            (board.width_bits == 0 or all(record.cycle_length * record.prescaler >= 8 for record in self.records),
             "the image has a record with a cycle of fewer than 8 clocks, which a board with amplitudes refuses"),
            (not self.has_amplitudes or self.min_pulse_clocks == board.min_pulse_clocks,
             f"the image is for shortest pulses of {self.min_pulse_clocks} clocks, the board's have {board.min_pulse_clocks}"),
            *(self.foci.fits(board) if self.foci else ()),
            (not self.modulation or len(self.modulation.samples) <= 2 * board.modulation_words,
             f"the image has {len(self.modulation.samples) if self.modulation else 0} samples of modulation, the board holds "
             f"{2 * board.modulation_words}"),
        ):  # fmt: skip
            if not fits:
                raise bad_input(where, f"{what}; compile it for this board, or use the board it was made for")

    def require_playable(self, where: str) -> None:
        """Raises HaptogramError saying what would keep it from being played as it is."""
        for index, record in enumerate(self.records, 1):
            if record.kind == Kind.AMPLITUDES and (record.prescaler, record.pulse_length) == (1, 0):
                continue
            if record.kind != Kind.TIMINGS:
                raise bad_input(where, f"record {index}: kind {record.kind}, prescaler {record.prescaler}, pulse length {record.pulse_length}; "
                                "expected kind 0, or kind 1 with 1 and 0; the board will refuse it")  # fmt: skip
            if record.prescaler == 0:
                raise bad_input(where, f"record {index}: prescaler 0; the board will refuse it")
            if record.pulse_length >= record.cycle_length:
                raise bad_input(where, f"record {index}: a pulse of {record.pulse_length} ticks is not shorter than its cycle of "
                                f"{record.cycle_length}; the board will refuse it")  # fmt: skip
            cycle_s = record.cycle_length * record.prescaler / max(self.clock_hz, 1)
            if cycle_s > LONGEST_CYCLE_S:
                raise bad_input(where, f"record {index}: a cycle lasts {cycle_s:.3g} s, and until it ends the board changes to nothing "
                                f"else, not even to silence; at most {LONGEST_CYCLE_S:g} s")  # fmt: skip
        if not self.entries:
            raise bad_input(where, "the sequence is empty; nothing would be played")
        for number, (index, dwell) in enumerate(self.entries, 1):
            if index > len(self.records) and not (self.foci and self.foci.has(index)):
                raise bad_input(where, f"sequence entry {number}: index {index} of {len(self.records)} records"
                                f"{f' and {self.foci.count} of foci behind {self.foci.board_records}' if self.foci else ''}; the board will "
                                "refuse it")  # fmt: skip
            if dwell == 0:
                raise bad_input(where, f"sequence entry {number}: dwell 0 lasts only until the next record is loaded")

    @classmethod
    def load(cls, path: str) -> "Image":
        """Reads an Intel HEX file and checks all that can be checked without knowing the board. `-` is standard input."""
        return cls.from_bytes(hexfile.read_file(path), path)

    @classmethod
    def from_bytes(cls, content: bytes, where: str = "image") -> "Image":
        """The same of an Intel HEX file's content, such as `hex` of what was compiled; `where` is for messages."""
        image = _from_regions(hexfile.parse(content, where), where)
        image.require_playable(where)
        return image

    def save(self, path: str) -> None:
        """As Intel HEX. `-` is standard output."""
        is_long = self.has_amplitudes or self.modulation is not None
        description = pack(
            DESCRIPTION_FIELDS, 2 * len(DESCRIPTION_WORDS), magic=DESCRIPTION_MAGIC,
            format=DESCRIPTION_LONG_FORMAT if is_long else DESCRIPTION_FORMAT, channels=self.channels,
            records=len(self.records), sequence_words=len(self.sequence) // 4, timing_bits=self.timing_bits, pulse_bits=self.pulse_bits,
            clock_hz=self.clock_hz, board_records=self.foci.board_records if self.foci else 0,
            modulation_samples=len(self.modulation.samples) if self.modulation else 0,
            modulation_divider=self.modulation.divider if self.modulation else 0, min_pulse_clocks=self.min_pulse_clocks)  # fmt: skip
        regions = {PRIMARY_BASE: self.primary, SEQUENCE_BASE: self.sequence,
                   DESCRIPTION_BASE: description if is_long else description[: 2 * SHORT_DESCRIPTION_WORDS]}  # fmt: skip
        if self.foci:
            regions[PRIMARY_BASE] = self.primary.ljust(self.foci.base, b"\0") + self.foci.data
            regions |= {PARAMETERS_BASE: self.foci.parameters, GEOMETRY_BASE: self.foci.geometry}
        if self.modulation:
            regions[MODULATION_BASE] = self.modulation.words
        hexfile.write_file(path, hexfile.format(regions))


def _cut(base: int, data: bytes, size: int) -> list[Piece]:
    return [Piece(base + at, data[at : at + size]) for at in range(0, len(data), size)]


def _from_regions(regions: dict[int, bytes], where: str) -> Image:
    def region(base: int, size: int, name: str) -> bytes:
        found = regions.pop(base, b"")
        if len(found) != size:
            raise bad_input(where, f"{name} holds {len(found)} bytes from {base:08X} on, expected {size}; the image is cut short or "
                            "garbled, or was not made by haptogram")  # fmt: skip
        return found

    is_long = DESCRIPTION_FIELDS["format"].get(regions.get(DESCRIPTION_BASE, b"").ljust(4, b"\0")) == DESCRIPTION_LONG_FORMAT
    described = region(DESCRIPTION_BASE, 2 * (len(DESCRIPTION_WORDS) if is_long else SHORT_DESCRIPTION_WORDS),
                       "the description, which says format 2," if is_long else "the description")  # fmt: skip
    says = unpack(DESCRIPTION_FIELDS, described.ljust(2 * len(DESCRIPTION_WORDS), b"\0"))
    if says["magic"] != DESCRIPTION_MAGIC or says["format"] not in (DESCRIPTION_FORMAT, DESCRIPTION_LONG_FORMAT):
        raise bad_input(where, f"the description says magic {says['magic']:04X}, format {says['format']}; expected {DESCRIPTION_MAGIC:04X}, "
                        f"format {DESCRIPTION_FORMAT} or {DESCRIPTION_LONG_FORMAT}; compile it with this version")  # fmt: skip
    channels, records, words = says["channels"], says["records"], says["sequence_words"]
    has_foci = is_long and PARAMETERS_BASE in regions
    if 0 in (channels, words) or (records == 0 and not has_foci):
        raise bad_input(where, f"the description says {channels} channels, {records} records and {words} sequence words; none may be zero")
    shortest = says["min_pulse_clocks"] if is_long else 1
    if shortest == 0:
        raise bad_input(where, "the description says a shortest pulse of 0 clocks; expected 1 or more; the image is garbled")
    size, foci, modulation = 2 * (channels + RECORD_HEADER_WORDS) * records, None, None
    if has_foci:
        foci = FocusRecords(says["board_records"], region(PARAMETERS_BASE, 2 * len(PARAMETERS_WORDS), "the parameters block"),
                            region(GEOMETRY_BASE, 8 * channels, "the geometry"), b"")  # fmt: skip
        if foci.base < size or foci.count == 0:
            raise bad_input(where, f"its parameters say {foci.count} focus records from byte {foci.base} on, behind {records} records that "
                            f"fill {size} bytes; the image is garbled")  # fmt: skip
        primary = region(PRIMARY_BASE, foci.base + 8 * foci.each * foci.count, "primary memory")
        foci = foci._replace(data=primary[foci.base :])
        if any(primary[size : foci.base]):
            raise bad_input(where, f"primary memory is not empty between its {records} records and the foci from byte {foci.base} on; the image is garbled")
    else:
        primary = region(PRIMARY_BASE, size, "primary memory")
    if is_long and says["modulation_samples"]:
        samples = region(MODULATION_BASE, (says["modulation_samples"] + 1) // 2 * 2, "the modulation")
        modulation = Modulation(says["modulation_divider"], samples[: says["modulation_samples"]])
        if modulation.divider == 0:
            raise bad_input(where, "the description says samples of modulation for 0 carrier periods each; the image is garbled")
    sequence = region(SEQUENCE_BASE, 4 * words, "sequence memory")
    for address, data in regions.items():
        raise bad_input(where, f"{len(data)} bytes at {address:08X} belong to no region; the image is garbled")
    length = SEQUENCE_HEADER_FIELDS["length"].get(sequence)
    if length != words - 1:
        raise bad_input(where, f"the sequence header says {length} entries, the description {words - 1}; the image is garbled")
    return Image(channels, says["clock_hz"], says["timing_bits"], says["pulse_bits"], primary[:size], sequence, foci, modulation, shortest)
