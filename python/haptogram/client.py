# SPDX-License-Identifier: Apache-2.0
"""A board behind a port, and its commands."""
import contextlib
import os
import struct
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING, Self

from .board import Identity, Status
from .errors import HaptogramError, Interrupted, bad_input, device_error
from .foci import FOCUS_BYTES, Focus
from .image import HIGHEST_INDEX, Image, Piece
from .interface import (
    PARAMETERS_BASE,
    PARAMETERS_FIELDS,
    PARAMETERS_WORDS,
    PRIMARY_BASE,
    RECORD_HEADER_WORDS,
    RING_BASE,
    RING_FIELDS,
    RING_WORDS,
    SEQUENCE_BASE,
    SEQUENCE_HEADER_FIELDS,
    TRIGGER_BASE,
    TRIGGER_FIELDS,
    TRIGGER_SETTINGS,
    TRIGGER_WORDS,
    Command,
    Event,
    Feature,
    Role,
    pack,
    unpack,
)
from .link import Link, Reply, Request, never
from .trigger import ClockSample, Trigger, TriggerSettings

if TYPE_CHECKING:
    from .computing import Compiled

GATE_AT_END = (1 << 48) - 1  # a period that means the end of what plays
GATE_AT_TRIGGER = GATE_AT_END - 1


class Board:
    """Speaks to a board behind a port, whose session it begins: Board.open("/dev/ttyUSB0"). As a context manager it closes its line
    at the end; what turns the outputs off is outputs(). Methods raise HaptogramError when the board refuses or does not answer."""

    identity: Identity

    def __init__(self, link: Link) -> None:
        self._link = link
        self.identify()

    @classmethod
    def open(cls, port: str, baud: int | None = None, stopped: Callable[[], bool] = never,
             found: Callable[[int], None] = lambda baud: None) -> Self:  # fmt: skip
        """`port` is a serial port, with "#2" behind it the second tile of a chain there, or "udp:ADDRESS[:PORT]". Without `baud`, its rate
        is found and remembered, and `found` is told one that had to be looked for. Once `stopped` says true, everything but turning
        the outputs off raises Interrupted."""
        link = Link(port, baud, stopped)
        try:
            board = cls(link)
        except BaseException:
            link.close()
            raise
        if rate := link.state().found_baud:
            found(rate)
        return board

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._link.close()

    @property
    def retransmissions(self) -> int:
        return int(self._link.state().retransmissions)

    def identify(self) -> Identity:
        """Starts the session anew."""
        self.identity = Identity.parse(self._link.begin())
        return self.identity

    def status(self) -> Status:
        return Status.parse(self._ask(Command.STATUS).data)

    def enable(self) -> None:
        """Raises HaptogramError when the board does not confirm, and then tries to turn the outputs off again."""
        try:
            self._ask(Command.ENABLE)
        except BaseException as error:
            self._shut_off_after(error)
            raise

    def disable(self) -> None:
        """As shut_off()."""
        self.shut_off()

    def stop(self) -> None:
        """Silence after the present cycle; outputs stay as they are."""
        self._ask(Command.STOP)

    def shut_off(self) -> None:
        """Outputs off and silence, whatever came before, also when the board has answered nothing for a while. Raises HaptogramError when the
        board does not confirm."""
        self._link.shut_off()

    def until_next(self) -> float:
        """Seconds until the board must be asked something again inside of outputs(), which keeps its watchdog quiet."""
        return self._link.rest()

    def rest(self, pause: Callable[[float], object] = time.sleep) -> None:
        """Sleeps until then, or as `pause` does, which is told the seconds and may end early."""
        pause(self.until_next())

    def keep_alive(self) -> None:
        """Starts the watchdog's time anew and does nothing else."""
        self._ask(Command.KEEP_ALIVE)

    def reset(self) -> None:
        """As after power-up, but memories and session stay."""
        self._ask(Command.RESET)

    def select(self, index: int, dwell: int = 0) -> None:
        self._ask(Command.SELECT, index, dwell)

    def _gated(self, command: Command, *words: int, period: int | None, at_end: bool = False, on_trigger: bool = False) -> Reply:
        """A command that waits for a carrier period, the end of what plays, the trigger, or nothing."""
        if (period is not None) + at_end + on_trigger > 1:
            raise bad_input("period", "expected one of a period, the end of what plays, and the trigger")
        if period is not None and not 0 < period < GATE_AT_TRIGGER:
            raise bad_input("period", f"{period}, expected 1 to {GATE_AT_TRIGGER - 1}")
        gate = GATE_AT_END if at_end else GATE_AT_TRIGGER if on_trigger else period or 0
        return self._link.exchange([Request(command, _pack(command, words))], gate)[0]

    def push(self, indices: Sequence[int], dwell: int, period: int | None = None) -> int:
        """Appends indices to the live FIFO, all or none; returns how many entries it holds now. They are not played before the
        carrier period of this number; status() tells the present one."""
        return self._gated(Command.PUSH, dwell, *indices, period=period).live_level

    def push_foci(self, foci: Sequence[Focus], dwell: int) -> int:
        """Appends foci to the live FIFO, each a record of its own, all or none; returns how many entries it holds now. make_ring()
        must have laid the ring for them."""
        each = self.parameters()["foci_last"] + 1
        filled = [one for focus in foci for one in (focus, *[focus._replace(amplitude=0.0)] * (each - 1))]
        data = b"".join(focus.pack() for focus in filled)
        return self._ask(Command.PUSH_FOCI, dwell, *struct.unpack(f"<{len(data) // 2}H", data)).live_level

    def make_ring(self) -> None:
        """Lays the ring for push_foci() behind everything else at the end of primary memory. An image of foci must have been
        uploaded, which says where the channels are and how many foci a record has; it stays."""
        if not self.identity.features >> Feature.LIVE_FOCI & 1:
            raise device_error("board", "it takes no foci while it plays; that takes a board with the parameter FOCI")
        says = self.parameters()
        base, stored, each = says["foci_base"], says["foci_count"], says["foci_last"] + 1
        if not says["gain"] or not stored:
            raise device_error("board", "it holds no image of foci, which says where its channels are; upload one first")
        fours = self.identity.records * (self.identity.channels + RECORD_HEADER_WORDS) // 4
        room = min((fours - base) // each, 65535 - self.identity.records)
        count = self.identity.live_depth + 1
        before = room - count
        ring = pack(RING_FIELDS, 2 * len(RING_WORDS), base=base + before * each, first=self.identity.records + 1 + before, count=count) if before > 0 else b""
        is_there = stored == room and self.read(RING_BASE, 2 * len(RING_WORDS)) == ring
        if before <= 0 or (stored > before and not is_there):
            raise device_error("board", f"its memory has room for {room} focus records behind the image's other records, and the image has {stored}; "
                               f"{count} more are needed for the ring of those that wait; upload a smaller image")  # fmt: skip
        self.write(PARAMETERS_BASE + 2 * PARAMETERS_WORDS.index("foci_count"), struct.pack("<H", room))
        self.write(RING_BASE, ring)

    def start(self, first: int = 1, length: int = 0, loops: int = 0, period: int | None = None, at_end: bool = False,
              on_trigger: bool = False) -> None:  # fmt: skip
        """With length 0 as the sequence's header says. It begins at once, not before the carrier period of this number, at the
        end of what plays, or when the trigger input says so (set_trigger); whatever turns outputs off ends that wait."""
        self._gated(Command.START, first, length, loops, period=period, at_end=at_end, on_trigger=on_trigger)

    def modulate(self, divider: int, length: int = 0, loop: bool = True, first: int = 0, period: int | None = None, at_end: bool = False) -> None:
        """Multiplies all amplitudes by samples of the modulation memory from the first on, which is even, each for `divider` carrier
        periods; 0 ends that. It begins as start() does."""
        if first % 2 or not 0 <= first <= 65534:
            raise bad_input("first", f"sample {first}, expected an even number up to 65534")
        self._gated(Command.MODULATE, divider, length, first | int(loop), period=period, at_end=at_end)

    def set_trigger(self, settings: TriggerSettings) -> None:
        """The trigger pins and the test output; they stay so over a reset."""
        self._require_triggers()
        self.write(TRIGGER_BASE, settings.block(self.identity))

    def trigger(self) -> Trigger:
        """How often the trigger pins did something, when last, and the board's clock, all of one moment."""
        self._require_triggers()
        return Trigger.of(self.read(TRIGGER_BASE + 2 * TRIGGER_SETTINGS, 2 * (len(TRIGGER_WORDS) - TRIGGER_SETTINGS)))

    def trigger_event(self) -> Event:
        """What makes a pulse at the trigger output; none on a board without one."""
        if not self.identity.features >> Feature.TRIGGER & 1:
            return Event.NONE
        block = self.read(TRIGGER_BASE, 2 * TRIGGER_SETTINGS)
        return Event(unpack(TRIGGER_FIELDS, block.ljust(2 * len(TRIGGER_WORDS), b"\0"))["event"])

    def clock_sample(self) -> ClockSample:
        """The board's clock between two of time.monotonic(), for fit_clocks()."""
        asked_s = time.monotonic()
        now = self.trigger().now
        return ClockSample(asked_s, time.monotonic(), now)

    def _require_triggers(self) -> None:
        if not self.identity.features >> Feature.TRIGGER & 1:
            raise device_error("board", "it has no trigger pins; that takes a board with the parameter TRIGGER")

    def set_role(self, role: Role) -> None:
        """Resets the board, and then keeps its carrier cycles in step with other boards."""
        self._ask(Command.SYNC, int(role))

    def set_watchdog(self, milliseconds: int) -> None:
        self._ask(Command.WATCHDOG, milliseconds)

    def send_patterns(self, period: int, words: memoryview, patterns: int) -> None:
        """Patterns, which have no answer; see PatternStream."""
        self._link.stream(period, words, patterns)

    def write(self, address: int, data: bytes) -> None:
        """At most one record."""
        most = 2 * (self.identity.channels + RECORD_HEADER_WORDS)
        if len(data) > most:
            raise bad_input("write", f"{len(data)} bytes, expected at most {most}, as a record of this board has")
        self._link.exchange([_write(Piece(address, data))])

    def read(self, address: int, size: int) -> bytes:
        """At most one record."""
        return self._link.exchange([_read(address, size)])[0].data

    def digest(self, address: int, size: int) -> int:
        """CRC-32 of memory, as zlib.crc32 has it; at most one record."""
        return _digest_of(self._link.exchange([_digest(address, size)])[0])

    @contextlib.contextmanager
    def outputs(self, watchdog_ms: int = 500, unless: Callable[[], bool] = never) -> Iterator[None]:
        """The outputs are on inside the block and off after it, whatever ended it. If this program dies, the board's watchdog
        turns them off. When `unless` says true before they are on, raises Interrupted."""
        self.set_watchdog(watchdog_ms)
        if unless():
            raise Interrupted(self._link.path)
        self._link.keep_alive(watchdog_ms)
        try:
            self._ask(Command.ENABLE)
            yield
        except BaseException as error:
            self._shut_off_after(error)
            raise
        self.shut_off()

    def _shut_off_after(self, error: BaseException) -> None:
        """Notes at an error if the outputs may still be on; of whatever else ended the program, that becomes the error."""
        if not isinstance(error, HaptogramError) or isinstance(error, Interrupted):
            self._link.interrupt()
        try:
            self.shut_off()
        except HaptogramError as failure:
            if not isinstance(error, HaptogramError) or isinstance(error, Interrupted):
                raise failure from error
            error.add_note(failure.message)

    def different(self, pieces: Sequence[Piece]) -> list[Piece]:
        """The pieces that the board does not hold, told by their digests."""
        replies = self._link.exchange([_digest(piece.address, len(piece.data)) for piece in pieces])
        return [piece for piece, reply in zip(pieces, replies, strict=True) if _digest_of(reply) != zlib.crc32(piece.data)]

    def upload(self, image: "Image | Compiled", where: str = "image") -> int:
        """Writes what differs and asks for its digests again; returns how many frames that took. The geometry of foci has no
        digest and is written each time. The board then modulates as the image says. `where` is the image's name in messages."""
        image = image if isinstance(image, Image) else image.image
        image.require_fits(self.identity, where)
        unread, stale = image.unread_pieces(), self.different(image.pieces())
        self._link.exchange([_write(piece) for piece in unread + stale])
        for piece in self.different(stale):
            raise device_error(where, f"the board's memory still differs from address {piece.address:#010x} on; send it again")
        if image.modulation:
            self.modulate(image.modulation.divider, len(image.modulation.samples))
        elif self.identity.modulation_words:
            self.modulate(0)
        return len(unread) + len(stale)

    def parameters(self) -> dict[str, int]:
        """The fields of the parameters block, of boards with amplitudes."""
        return unpack(PARAMETERS_FIELDS, self.read(PARAMETERS_BASE, 2 * len(PARAMETERS_WORDS)))

    def highest_index(self) -> int:
        """Of a record that the board holds; of foci, as its parameters say."""
        return self.identity.records + (self.parameters()["foci_count"] if self.identity.foci else 0)

    def write_foci(self, index: int, foci: Sequence[Focus]) -> None:
        """Writes the foci of one focus record, which may be playing; it is seen whole or not at all. Fewer foci than its
        records have are filled up with foci of amplitude 0. An image of foci must have been uploaded before."""
        if not self.identity.foci:
            raise bad_input("foci", "this board computes no foci")
        says = self.parameters()
        first, each = self.identity.records + 1, says["foci_last"] + 1
        if not first <= index < first + says["foci_count"]:
            raise bad_input("foci", f"index {index}, expected {first} to {first + says['foci_count'] - 1}; upload an image of foci first")
        if not 0 < len(foci) <= each:
            raise bad_input("foci", f"{len(foci)} foci, expected 1 to {each}")
        filled = [*foci, *[foci[0]._replace(amplitude=0.0)] * (each - len(foci))]
        address = PRIMARY_BASE + 8 * says["foci_base"] + FOCUS_BYTES * each * (index - first)
        self.write(address, b"".join(focus.pack() for focus in filled))

    def compare(self, image: Image, where: str = "image") -> None:
        """Reads the image's places back. Raises HaptogramError naming the first difference."""
        pieces = image.pieces()
        replies = self._link.exchange([_read(piece.address, len(piece.data)) for piece in pieces])
        for piece, reply in zip(pieces, replies, strict=True):
            if reply.data != piece.data:
                at = piece.address + len(os.path.commonprefix([piece.data, reply.data]))
                raise device_error(where, f"the board's memory differs at address {at:#010x}; does another program write to this board?")

    def sequence_length(self) -> int:
        """Entries of the sequence in the board's memory. Raises HaptogramError when there is none."""
        length = SEQUENCE_HEADER_FIELDS["length"].get(self.read(SEQUENCE_BASE, 4))
        if not 0 < length < self.identity.sequence_depth:
            raise device_error("board", "there is no sequence in its memory; upload an image first")
        return length

    def download(self) -> Image:
        """The sequence in the board's memory, and the records up to the highest that it plays. An image that plays them all
        comes back as it was, without the autostart bit, which only a bitstream may hold."""
        identity = self.identity
        words = self.sequence_length() + 1
        size = 2 * (identity.channels + RECORD_HEADER_WORDS)
        sequence = bytearray(self._read_long(SEQUENCE_BASE, 4 * words, size // 4 * 4))
        sequence[:4] = pack(SEQUENCE_HEADER_FIELDS, 4, **{**unpack(SEQUENCE_HEADER_FIELDS, sequence), "autostart": 0})
        records = max(index & HIGHEST_INDEX for index, _ in struct.iter_unpack("<HH", sequence[4:]))
        if identity.records < records <= self.highest_index():
            raise device_error("board", f"its sequence plays the focus record of index {records}, and the geometry of foci cannot be read back; "
                               "keep the image that was uploaded")  # fmt: skip
        if not 0 < records <= identity.records:
            raise device_error("board", f"its sequence plays record {records} of {identity.records}; upload an image first")
        primary = self._read_long(PRIMARY_BASE, records * size, size)
        image = Image(identity.channels, identity.clock_hz, identity.timing_bits, identity.pulse_bits, primary, bytes(sequence))
        return replace(image, min_pulse_clocks=identity.min_pulse_clocks) if image.has_amplitudes else image

    def _read_long(self, base: int, total: int, size: int) -> bytes:
        requests = [_read(base + at, min(size, total - at)) for at in range(0, total, size)]
        return b"".join(reply.data for reply in self._link.exchange(requests))

    def _ask(self, command: Command, *words: int) -> Reply:
        return self._link.exchange([Request(command, _pack(command, words))])[0]


Client = Board  # its name in earlier versions; the next one has only Board


def _pack(command: Command, words: Sequence[int]) -> bytes:
    for word in words:
        if not 0 <= word <= 0xFFFF:
            raise bad_input(f"command {command.name.lower()}", f"{word} does not fit into 16 bits")
    return struct.pack(f"<{len(words)}H", *words)


def _about(command: Command, address: int, size: int) -> Request:
    return Request(command, _pack(command, (address & 0xFFFF, address >> 16, size)))


def _read(address: int, size: int) -> Request:
    return _about(Command.READ, address, size)


def _digest(address: int, size: int) -> Request:
    return _about(Command.DIGEST, address, size)


def _digest_of(reply: Reply) -> int:
    return int.from_bytes(reply.data, "little")


def _write(piece: Piece) -> Request:
    return Request(Command.WRITE, struct.pack("<I", piece.address) + piece.data)
