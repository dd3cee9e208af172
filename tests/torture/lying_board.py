# SPDX-License-Identifier: Apache-2.0
"""A board on a pseudo-terminal that lies, as a Lie says. It is written from rtl/INTERFACE.md and shares no code with the hosts that
it is put before: framing, CRC and replies are its own. Without a lie it is a tile of 100 channels that plays records; a wide one also
takes foci and a modulation, and counts carrier periods."""
import binascii
import contextlib
import os
import random
import select
import struct
import threading
import time
import tty
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

IDENTIFY, WRITE, READ, ENABLE, DISABLE, SELECT, PUSH, START, STOP = range(1, 10)
WATCHDOG, STATUS, DIGEST, KEEP_ALIVE, RESET, MODULATE, GATE, PUSH_FOCI = range(10, 18)
NAMES = ("", "identify", "write", "read", "enable", "disable", "select", "push", "start", "stop", "watchdog", "status", "digest",
         "keep_alive", "reset", "modulate", "gate", "push_foci")  # fmt: skip
OK, REPEATED, UNKNOWN_COMMAND, BAD_LENGTH, OUT_OF_ORDER, BAD_ADDRESS, BAD_ALIGNMENT, BAD_INDEX, BAD_RANGE, FIFO_FULL = range(10)
REFUSALS = (*range(2, 4), *range(5, 12), 16, 0x7F)  # all that tell of no missing frame, and one that no board has
CYCLE_S = 25e-6
CHANNELS, RECORDS, DEPTH, LIVE = 100, 400, 1024, 256
RECORD_BYTES = 2 * (CHANNELS + 4)
PRIMARY, SEQUENCE, PARAMETERS, GEOMETRY, MODULATION, RING = 0x00000000, 0x10000000, 0x50000000, 0x60000000, 0x70000000, 0x80000000
WIDE = {"timing_bits": 11, "features": 0b1111111111, "frame_bytes": 484, "width_bits": 10, "foci": 8, "modulation_words": 2048}
ARGUMENTS = {WRITE: 2, READ: 3, SELECT: 2, PUSH: 1, START: 3, WATCHDOG: 1, DIGEST: 3, MODULATE: 3, GATE: 3, PUSH_FOCI: 1}
CARRY_DATA = (WRITE, PUSH, PUSH_FOCI)
NMEA = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"


class Frame(NamedTuple):
    at: float  # seconds, monotonic
    number: int
    command: int
    payload: bytes

    @property
    def name(self) -> str:
        return NAMES[self.command] if self.command < len(NAMES) else f"{self.command:#04x}"


def stuff(data: bytes) -> bytes:
    """COBS."""
    out = bytearray()
    for run in (data + b"\0").split(b"\0")[:-1]:
        while len(run) >= 254:
            out += b"\xff" + run[:254]
            run = run[254:]
        out += bytes([len(run) + 1]) + run
    return bytes(out)


def unstuff(code: bytes) -> bytes | None:
    """None when it is no COBS."""
    out = bytearray()
    while code:
        if len(code) < code[0]:
            return None
        out += code[1 : code[0]] + (b"\0" if code[0] < 255 and len(code) > code[0] else b"")
        code = code[code[0] :]
    return bytes(out)


def sealed(body: bytes) -> bytes:
    """A frame with its CRC, as it goes on the line."""
    return stuff(body + struct.pack(">H", binascii.crc_hqx(body, 0xFFFF))) + b"\0"


class Answer(NamedTuple):
    number: int
    command: int
    status: int
    expected: int
    level: int
    data: bytes

    def packed(self) -> bytes:
        return sealed(struct.pack("<BBBBH", self.number, self.command | 0x80, self.status, self.expected, self.level) + self.data)


@dataclass
class Lie:
    """What is done otherwise than a board does. Each is asked at its own occasion."""

    identity: dict[str, int | bytes] = field(default_factory=dict)  # fields that are told instead
    status: dict[str, int] = field(default_factory=dict)
    deaf: Callable[[Frame], bool] = lambda frame: False  # the frame does not arrive
    answers: Callable[[Frame, Answer], list[bytes]] = lambda frame, answer: [answer.packed()]
    babble: bytes = b""  # over and over, as much as the line takes
    delay_s: Callable[[], float] = lambda: 0.0  # of an answer
    backwards: bool = False  # answers that are ready together go out the last one first
    hang_up: Callable[[Frame], bool] = lambda frame: False
    refuses: int | None = None  # every command but identify, with this status
    forgets: bool = False  # what is written is confirmed and not kept
    sequence: bytes = b""  # what sequence memory begins with, whatever was written


@dataclass
class Play:
    """What plays, and until when; None: for ever."""

    mode: int = 0
    index: int = 0
    until: float | None = 0.0


class Instrument:
    """What the frames that are applied do."""

    def __init__(self, lie: Lie, wide: bool) -> None:
        self.lie, self.wide, self.begun = lie, wide, time.monotonic()
        self.memory = {PRIMARY: bytearray(RECORDS * RECORD_BYTES), SEQUENCE: bytearray(4 * DEPTH)}
        if wide:
            self.memory |= {PARAMETERS: bytearray(22), GEOMETRY: bytearray(8 * CHANNELS), MODULATION: bytearray(4096), RING: bytearray(6)}
        self.enabled = False
        self.watchdog_ms, self.heard, self.trips = 500, time.monotonic(), 0
        self.play = Play()
        self.live: list[tuple[int, float]] = []  # index, when it ends
        self.good = self.repeated = self.refused = 0

    def identity(self) -> bytes:
        fields: dict[str, int | bytes] = {
            "name": b"Haptogram", "minor": 2, "major": 2, "channels": CHANNELS, "records": RECORDS, "sequence_depth": DEPTH, "live_depth": LIVE,
            "timing_bits": 16, "pulse_bits": 8, "clock_hz": 50_000_000, "features": 0b1111, "frame_bytes": RECORD_BYTES + 6, "min_pulse": 5,
            "max_pulse": 999, "max_duty": 128, "max_cycle": 50_000_000, "width_bits": 0, "foci": 0, "modulation_words": 0} | (WIDE if self.wide else {}) | self.lie.identity  # fmt: skip
        return struct.pack("<16sBBHHHHBBIHHHHHIHHH", *fields.values())

    def tick(self, now: float) -> None:
        """The watchdog, and what ends by itself."""
        if self.enabled and self.watchdog_ms and now - self.heard > self.watchdog_ms / 1000:
            self.enabled, self.trips = False, self.trips + 1
        while self.live and self.live[0][1] <= now:
            self.live.pop(0)
        if self.play.until is not None and self.play.until <= now:
            self.play = Play()

    def status(self) -> bytes:
        live = [entry for entry in self.live if entry[1] > time.monotonic()]
        index = live[0][0] if live else self.play.index
        fields = {"flags": self.enabled | (3 if live else self.play.mode) << 1, "index": index, "underruns": 0, "refused_records": 0,
                  "good": self.good, "damaged": 0, "repeated": self.repeated, "watchdog_trips": self.trips, "guard_trips": 0,
                  "level": max(0, len(live) - 1), "watchdog_ms": self.watchdog_ms, "refused": self.refused, "bent": 0, "far": 0, "sync": 0,
                  "misses": 0, "losses": 0} | self.lie.status  # fmt: skip
        block = struct.pack("<17H", *(value & 0xFFFF for value in fields.values()))
        return block + struct.pack("<HQ", 0, int((time.monotonic() - self.begun) / CYCLE_S))[:8] if self.wide else block

    def _place(self, address: int, size: int) -> tuple[bytearray, int] | None:
        base = address & 0xF0000000
        at = address - base
        memory = self.memory.get(base)
        return (memory, at) if memory is not None and 0 < size <= RECORD_BYTES and at + size <= len(memory) else None

    def off(self, command: int) -> None:
        """DISABLE or STOP, which act as soon as they arrive."""
        if command == DISABLE:
            self.enabled = False
        else:
            self.live, self.play = [], Play()

    def apply(self, command: int, payload: bytes, again: bool, now: float) -> tuple[int, bytes]:
        """Status and data. What comes again does nothing, but what it asks for is told."""
        count = ARGUMENTS.get(command, 0)
        if command not in range(1, (PUSH_FOCI if self.wide else RESET) + 1):
            return UNKNOWN_COMMAND, b""
        if len(payload) < 2 * count or (len(payload) > 2 * count) != (command in CARRY_DATA):
            return BAD_LENGTH, b""
        words = struct.unpack_from(f"<{count}H", payload)
        data = payload[2 * count :]
        if command == STATUS:
            return OK, self.status()
        if command in (READ, DIGEST):
            place = self._place(words[0] | words[1] << 16, words[2])
            if place is None:
                return BAD_ADDRESS, b""
            if place[0] is self.memory[SEQUENCE]:
                place[0][: len(self.lie.sequence)] = self.lie.sequence
            found = bytes(place[0][place[1] : place[1] + words[2]])
            return OK, found if command == READ else struct.pack("<I", zlib.crc32(found))
        return (OK if again else self._change(command, words, data, now)), b""

    def _change(self, command: int, words: tuple[int, ...], data: bytes, now: float) -> int:
        if command == WRITE:
            place = self._place(words[0] | words[1] << 16, len(data))
            if place is None:
                return BAD_ADDRESS
            if not self.lie.forgets:
                place[0][place[1] : place[1] + len(data)] = data
        elif command == ENABLE:
            self.enabled = True
        elif command == WATCHDOG:
            self.watchdog_ms = words[0]
        elif command == SELECT:
            if words[0] > RECORDS and not self.wide:
                return BAD_INDEX
            self.live, self.play = [], Play(1 if words[0] else 0, words[0], now + words[1] * CYCLE_S if words[1] else None)
        elif command == PUSH:
            return self._push([index for index, in struct.iter_unpack("<H", data)], words[0], now)
        elif command == PUSH_FOCI:
            each = 8 * ((self.memory[PARAMETERS][4] & 7) + 1)
            return BAD_LENGTH if len(data) % each else self._push([RECORDS + 1] * (len(data) // each), words[0], now)
        elif command == START:
            return self._start(*words, now)
        elif command == RESET:
            self.enabled, self.play, self.live, self.watchdog_ms = False, Play(), [], 500
        return OK

    def _push(self, indices: list[int], dwell: int, now: float) -> int:
        if max(indices) > RECORDS + (struct.unpack_from("<H", self.memory[PARAMETERS], 2)[0] if self.wide else 0):
            return BAD_INDEX
        if len(self.live) + len(indices) > LIVE:
            return FIFO_FULL
        self.play = Play()
        for index in indices:
            if index:
                self.live.append((index, max(now, self.live[-1][1] if self.live else now) + max(dwell, 1) * CYCLE_S))
        return OK

    def _start(self, first: int, length: int, loops: int, now: float) -> int:
        header, looped = struct.unpack_from("<HH", self.memory[SEQUENCE])
        if not length:
            length, loops = header & 0x7FFF, looped
        if not (0 < first and 0 < length and first + length <= DEPTH):
            return BAD_RANGE
        entries = [struct.unpack_from("<HH", self.memory[SEQUENCE], 4 * (first + n)) for n in range(length)]
        cycles = sum(max(dwell, 1) for _, dwell in entries) * loops
        self.live, self.play = [], Play(2, entries[0][0], now + cycles * CYCLE_S if loops else None)
        return OK


class LyingBoard:
    """A context manager; `port` is its name. `frames` is what arrived, with the time; `on_frame` is told of each."""

    def __init__(self, lie: Lie | None = None, wide: bool = False, on_frame: Callable[[Frame], None] = lambda frame: None) -> None:
        self.lie = lie or Lie()
        self.frames: list[Frame] = []
        self.damaged = 0
        self.instrument = Instrument(self.lie, wide)
        self._on_frame = on_frame
        self._expected: int | None = None
        self._rest = b""
        self._due: list[tuple[float, bytes]] = []
        self._ended = threading.Event()

    def __enter__(self) -> "LyingBoard":
        self._ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self._ours, False)
        self.port = os.ttyname(theirs)
        self._theirs = theirs  # held open, so that the line is there before and after a program's use of it
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        os.close(self._theirs)

    def _run(self) -> None:
        while not self._ended.is_set():
            now = time.monotonic()
            self.instrument.tick(now)
            wait = min([0.01, *(max(0.0, due - now) for due, _ in self._due[:1])])
            if select.select([self._ours], [], [], 0.002 if self.lie.babble else wait)[0] and not self._hear(os.read(self._ours, 4096)):
                return
            self._say()
        os.close(self._ours)

    def _say(self) -> None:
        now = time.monotonic()
        ready = [data for due, data in self._due if due <= now]
        self._due = [entry for entry in self._due if entry[0] > now]
        for data in reversed(ready) if self.lie.backwards else ready:
            self._write(data)
        if self.lie.babble:
            self._write(self.lie.babble)

    def _write(self, data: bytes) -> None:
        """What a program does not take is lost, as behind a real port."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._ours, data)

    def _hear(self, data: bytes) -> bool:
        """False: hung up."""
        *codes, self._rest = (self._rest + data).split(b"\0")
        for code in codes:
            body = unstuff(code) if code else None
            if body is None or len(body) < 4 or binascii.crc_hqx(body, 0xFFFF) != 0:
                self.damaged += bool(code)
                continue
            frame = Frame(time.monotonic(), body[0], body[1], body[2:-2])
            self.frames.append(frame)
            self._on_frame(frame)
            if self.lie.hang_up(frame):
                os.close(self._ours)  # the name stays taken, so that who opens it again finds nothing, and not another case's board
                return False
            if not self.lie.deaf(frame):
                self._take(frame)
        return True

    def _take(self, frame: Frame) -> None:
        board, now = self.instrument, time.monotonic()
        board.good += 1
        if frame.command in (DISABLE, STOP):
            board.off(frame.command)  # whatever its number
        if frame.command == IDENTIFY:
            self._expected = frame.number
        ahead = None if self._expected is None else (frame.number - self._expected) % 256
        data = b""
        if self.lie.refuses is not None and frame.command != IDENTIFY:
            status = self.lie.refuses
        elif ahead is None or 0 < ahead < 128:
            status = OUT_OF_ORDER
        else:
            status, data = (OK, board.identity()) if frame.command == IDENTIFY else board.apply(frame.command, frame.payload, ahead != 0, now)
            if ahead and status == OK:
                status, board.repeated = REPEATED, board.repeated + 1
            if not ahead and status == OK:
                self._expected = (frame.number + 1) % 256
                if frame.command != IDENTIFY:
                    board.heard = now
        board.refused += status not in (OK, REPEATED)
        answer = Answer(frame.number, frame.command, status, self._expected or 0, max(0, len(board.live) - 1), data)
        due = max([now + self.lie.delay_s(), *(at for at, _ in self._due[-1:])])  # a line keeps the order
        self._due += [(due, part) for part in self.lie.answers(frame, answer)]


def loses(*commands: int) -> Lie:
    return Lie(answers=lambda frame, answer: [] if frame.command in commands else [answer.packed()])


def of_length(command: int, length: int) -> Lie:
    """Answers to this command carry so many bytes of data, with a right CRC."""
    return Lie(answers=lambda frame, answer: [answer._replace(data=(answer.data + bytes(length))[:length] if frame.command == command else answer.data).packed()])


def silent_from(command: int) -> Lie:
    """Answers nothing from the first frame of this command on."""
    seen = []

    def answers(frame: Frame, answer: Answer) -> list[bytes]:
        seen.extend([frame] if frame.command == command else [])
        return [] if seen else [answer.packed()]

    return Lie(answers=answers)


def lossy(one_in: int, most_delay_s: float, seed: int = 1) -> Lie:
    """Frames and answers are lost, and answers are late."""
    generator = random.Random(seed)

    def lost() -> bool:
        return generator.randrange(one_in) == 0

    return Lie(deaf=lambda frame: lost(), answers=lambda frame, answer: [] if lost() else [answer.packed()], delay_s=lambda: generator.uniform(0, most_delay_s))


IDENTITIES: dict[str, dict[str, int | bytes]] = {
    "channels-0": {"channels": 0}, "channels-1001": {"channels": 1001}, "records-0": {"records": 0}, "live-depth-0": {"live_depth": 0},
    "live-depth-1": {"live_depth": 1}, "live-depth-2": {"live_depth": 2}, "live-depth-3": {"live_depth": 3}, "live-depth-100": {"live_depth": 100},
    "sequence-depth-0": {"sequence_depth": 0}, "sequence-depth-1": {"sequence_depth": 1}, "clock-0": {"clock_hz": 0},
    "timing-bits-0": {"timing_bits": 0}, "timing-bits-200": {"timing_bits": 200}, "pulse-bits-0": {"pulse_bits": 0}, "frame-bytes-0": {"frame_bytes": 0},
    "width-bits-99": {"width_bits": 99}, "foci-9": {"foci": 9}, "modulation-3": {"modulation_words": 3},
    "name-escapes": {"name": b"\x1b[2J\x1b]0;owned\x07"}, "name-other": {"name": b"Metagram"}, "name-empty": {"name": b""}, "major-9": {"major": 9},
}  # fmt: skip

LIES: dict[str, Callable[[], Lie]] = {
    "honest": Lie,
    "silent": lambda: Lie(answers=lambda frame, answer: []),
    **{f"silent-from-{NAMES[command]}": lambda command=command: silent_from(command) for command in (WATCHDOG, ENABLE, START)},
    "late-identity": lambda: Lie(delay_s=lambda: 0.7),
    **{f"loses-{NAMES[command]}": lambda command=command: loses(command) for command in (IDENTIFY, READ, DIGEST, WRITE, STATUS, ENABLE, DISABLE, STOP, START)},
    "loses-disable-and-stop": lambda: loses(DISABLE, STOP),
    "babbles": lambda: Lie(answers=lambda frame, answer: [], babble=NMEA * 20),
    "babbles-beside": lambda: Lie(answers=lambda frame, answer: [b"\0" + answer.packed()], babble=NMEA * 3 + b"\0"),
    "babbles-zeros": lambda: Lie(answers=lambda frame, answer: [], babble=bytes(2000)),
    "babbles-answers": lambda: Lie(answers=lambda frame, answer: [], babble=Answer(0, STATUS, REPEATED, 0, 0, b"").packed() * 50),
    "forgets": lambda: Lie(forgets=True),
    "backwards": lambda: Lie(backwards=True, delay_s=lambda: 0.002),
    "twice": lambda: Lie(answers=lambda frame, answer: [answer.packed()] * 2),
    **{f"{NAMES[command]}-of-{length}": lambda command=command, length=length: of_length(command, length)
       for command, lengths in ((READ, (0, 1, 7, 400)), (DIGEST, (0, 3, 8)), (STATUS, (0, 33, 42, 300)), (IDENTIFY, (0, 17, 18, 51, 54, 600)), (WRITE, (9,)))
       for length in lengths},
    **{f"identity-{name}": lambda fields=fields: Lie(identity=fields) for name, fields in IDENTITIES.items()},
    "status-role-3": lambda: Lie(status={"sync": 3}),
    "status-level-65535": lambda: Lie(status={"level": 65535}),
    "status-stands-still": lambda: Lie(status={"flags": 5, "index": 1, "good": 7, "level": 0}),
    "level-65535": lambda: Lie(answers=lambda frame, answer: [answer._replace(level=65535).packed()]),
    "sequence-length-32767": lambda: Lie(sequence=b"\xff\x7f"),
    "sequence-length-0": lambda: Lie(sequence=bytes(4)),
    "sequence-of-record-65535": lambda: Lie(sequence=struct.pack("<HHHH", 1, 0, 65535, 1)),
    "sequence-of-silence": lambda: Lie(sequence=struct.pack("<HHHH", 1, 0, 0, 1)),
    "hangs-up-at-identify": lambda: Lie(hang_up=lambda frame: frame.command == IDENTIFY),
    "hangs-up-at-write": lambda: Lie(hang_up=lambda frame: frame.command == WRITE),
    "hangs-up-at-start": lambda: Lie(hang_up=lambda frame: frame.command == START),
    "late": lambda: lossy(100, 0.2),
    **{f"late-{seed}": lambda seed=seed: lossy(100, 0.2, seed) for seed in range(2, 6)},
    **{f"refuses-{status:#04x}": lambda status=status: Lie(refuses=status) for status in (*REFUSALS, OUT_OF_ORDER)},
}  # fmt: skip
