# SPDX-License-Identifier: Apache-2.0
"""A pattern for each carrier period, live: see "A stream of patterns" in rtl/INTERFACE.md."""
import time
from collections.abc import Callable

from .board import Status
from .client import Board
from .errors import bad_input, device_error
from .interface import (
    PRIMARY_BASE,
    RECORD_FIELDS,
    RECORD_HEADER_WORDS,
    STREAM_BASE,
    STREAM_FIELDS,
    STREAM_WORDS,
    Feature,
    Kind,
    pack,
)

Buffer = bytes | bytearray | memoryview  # or anything else that has bytes, such as a numpy array
CARRIER_HZ = 40_000
LEAST_LEAD = 4  # periods: the board decides what plays 1.4 periods ahead, and a datagram takes a half
LEAST_SLOTS = 16  # so that the lead can grow and shrink
STATUS_S = 0.005  # between two looks at the board's clock and counters
STEP_S = 0.001  # between two datagrams, or several at once
GROWTH = 1.5  # of the lead when patterns came too late, and a third of it is given back when some came too early


class PatternStream:
    """The slots in a board, and what is sent to them. A pattern is {amplitude, phase} of each channel, 16 bits each, as in a record of
    amplitudes. Whatever lies in the records from `first` on is overwritten."""

    def __init__(self, board: Board, first: int = 1, slots: int = 64, hold: int = 40, fade: int = 1024) -> None:
        """`slots`, a power of two, is how many periods ahead the host can be, at most what the board's STREAM says. A board without
        patterns plays the last one on for `hold` periods; then amplitudes fall by `fade` a period, of 65,535."""
        if not board.identity.features >> Feature.STREAM & 1:
            raise device_error("board", "it takes no streams of patterns; that takes a board with the parameter STREAM")
        self._board = board
        record_bytes = 2 * (board.identity.channels + RECORD_HEADER_WORDS)
        if slots < LEAST_SLOTS or slots & (slots - 1) or not 0 < first <= board.identity.records + 1 - slots:
            raise bad_input("slots", f"{slots} from record {first} on, expected a power of two from {LEAST_SLOTS} on, and all of them within the {board.identity.records} records")
        self.slots = slots
        self.pattern_bytes = 2 * board.identity.channels
        header = pack(RECORD_FIELDS, 2 * RECORD_HEADER_WORDS, cycle_length=round(board.identity.clock_hz / CARRIER_HZ), prescaler=1, kind=Kind.AMPLITUDES)
        for slot in range(slots):
            board.write(PRIMARY_BASE + (first - 1 + slot) * record_bytes, header)
        board.write(STREAM_BASE, pack(STREAM_FIELDS, 2 * len(STREAM_WORDS), first=first, slot_bits=slots.bit_length() - 1, hold=hold, fade=fade))
        self._require_taken()

    def _require_taken(self) -> None:
        """One pattern that is too late for its period shows that the board has so many slots."""
        before = self._board.status()
        self.send(0, bytes(self.pattern_bytes))
        if self._board.status().stream_late == before.stream_late:
            raise device_error("board", f"it refuses a stream through {self.slots} slots; its configuration's STREAM says how many it has")

    def send(self, period: int, patterns: Buffer) -> int:
        """Patterns for this carrier period and those after it, of anything that has bytes, such as a numpy array; how many they were."""
        data = memoryview(patterns).cast("B")
        count, rest = divmod(len(data), self.pattern_bytes)
        if rest or not count:
            raise bad_input("patterns", f"{len(data)} bytes, expected a multiple of {self.pattern_bytes}, those of a pattern")
        self._board.send_patterns(period, data, count)
        return count

    def play(self, source: Callable[[int, int], Buffer | None], watch: Callable[[Status], None] = lambda status: None) -> Status:
        """Asks the source for the patterns of each period ahead of the board, as source(period, count), and sends them in time, until it
        returns None; then, when the last one plays, the board's status. The outputs must be on. The lead follows what the board says came too late or too early."""
        status = first = self._board.status()
        if status.period is None:
            raise device_error("board", "it says no period")
        begun = seen = time.monotonic()
        rate, lead, late, early = CARRIER_HZ, self.slots // 2, first.stream_late, first.stream_early
        following = status.period + lead
        while True:
            now = time.monotonic()
            if now - seen > STATUS_S:
                status = self._board.status()
                seen = now = time.monotonic()
                rate = (status.period - first.period) / (seen - begun)  # by the board's clock, which a simulated one has for itself
                watch(status)
                if not status.enabled:
                    raise device_error("board", "it has turned its outputs off; look at its status")
                if status.stream_late != late:
                    lead = min(self.slots - LEAST_LEAD, int(lead * GROWTH) + 1)
                elif status.stream_early != early:
                    lead = max(2 * LEAST_LEAD, int(lead / GROWTH))  # with no more than LEAST_LEAD nothing would be sent
                late, early = status.stream_late, status.stream_early
            period = status.period + int(min(now - seen, STATUS_S) * rate)  # the answer was on its way: a little less than there is
            following = max(following, period + LEAST_LEAD)
            count = period + lead - following
            if count > 0:
                patterns = source(following, count)
                if patterns is None:
                    break
                following += self.send(following, patterns)
            time.sleep(STEP_S)
        while status.period < following and status.enabled:
            time.sleep(STEP_S)
            status = self._board.status()
        return status
