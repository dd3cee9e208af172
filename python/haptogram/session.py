# SPDX-License-Identifier: Apache-2.0
"""Requests in a window, each acknowledged. What is lost is sent again from the first missing one on; the board applies
each exactly once and in order. How often and how soon, and when a link counts as lost, is one policy for all hosts of
this project: see "A line that loses bytes" in rtl/INTERFACE.md."""
import math
import random
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Protocol

from .errors import HaptogramError, Interrupted, Refused, device_error
from .frame import Reply, ReplyDecoder, Request, encode_request
from .interface import (
    LINK_ASKING_BYTES,
    LINK_FIRST_TRIES,
    LINK_KEEP_ALIVE_MS,
    LINK_KEEP_ALIVE_SHARE,
    LINK_LOST_MS,
    LINK_MOST_PATIENCE_MS,
    LINK_MOST_STRANGE,
    LINK_PATIENCE_MS,
    LINK_TRIES,
    LINK_WINDOW,
    Command,
    Status,
)
from .port import SLICE_S, never

PATIENCE_S = LINK_PATIENCE_MS / 1000
MOST_PATIENCE_S = LINK_MOST_PATIENCE_MS / 1000
APPLIED = (Status.OK, Status.REPEATED)
URGENT_TRIES = 5  # of a command that is carried out whatever its number: with a silent board 1.5 s
TRIES_BEFORE_BREAK = 2
BREAK_BITS = 50  # the board takes 25 for a break
HIGHEST_LEVEL = 65535


def keep_alive_pause(watchdog_ms: int) -> float:
    """Seconds within which a host must say something while outputs are on."""
    within_watchdog = watchdog_ms // LINK_KEEP_ALIVE_SHARE + 1
    return 0.001 * (min(LINK_KEEP_ALIVE_MS, within_watchdog) if watchdog_ms else LINK_KEEP_ALIVE_MS)


class Line(Protocol):
    """A byte stream to a board."""

    path: str  # what messages call it

    def write(self, data: bytes) -> None: ...

    def urge(self, data: bytes) -> None:
        """Sends this ahead of what has not left yet, which is dropped."""

    def send_break(self, bits: int) -> None: ...

    def read(self, patience: float) -> bytes:
        """What has arrived; waits at most `patience` seconds for the first byte. Empty when nothing came that matters."""

    def drain(self) -> None:
        """Drops what has arrived."""

    def close(self) -> None: ...


@dataclass
class _Pending:
    request: Request
    reply: Reply | None = None


class _Theirs(Exception):
    """The number is that of a session which somebody else has begun, so the board takes an IDENTIFY for a late copy."""


def _begins(reply: Reply) -> bool:
    """Whether an answer to IDENTIFY says that the session is its own."""
    if reply.status == Status.REPEATED:
        return reply.expected == (reply.sequence + 1) % 256
    return reply.status != Status.SESSION_ENDED


class Session:
    """Once `stopped` says true, every exchange raises Interrupted and nothing more is sent; urge() does not ask it."""

    def __init__(self, line: Line, stopped: Callable[[], bool] = never, clock: Callable[[], float] = time.monotonic) -> None:
        self.patience = self._least_patience = getattr(line, "patience", PATIENCE_S)  # seconds to wait for an answer before sending again
        self._window: int = getattr(line, "window", LINK_WINDOW)
        self._window_bytes: float = getattr(line, "window_bytes", math.inf)  # of frames without an answer
        self._rounds = round(PATIENCE_S / self.patience)  # that make a try
        self.retransmissions = 0
        self.keep_alive: float | None = None  # seconds within which something new must be said, while outputs are on
        self._most_asking = 1  # requests under way whose replies carry data: the board keeps room for so many
        self._highest_level = HIGHEST_LEVEL  # of the live FIFO
        self._line = line
        self._stopped = stopped
        self._clock = clock
        self._decoder = ReplyDecoder()
        self._heard = 0  # bytes since the last progress
        self._queue: deque[_Pending] = deque()
        self._number = 0  # that of the IDENTIFY which began the session
        self._next = random.randrange(256)  # number of the queue's first; so late answers to a program that was killed match nothing
        self._sent = self._farthest = 0  # of the queue, in this round and in any
        self._tries = self._strange = 0  # since the last progress
        self._since = self._said = self._moved = clock()  # of the last progress or round; of the last new frame; of the last progress
        self._last_gap: float | None = None  # since the last progress
        self._in_doubt = True  # only a new session makes the numbers certain
        self._late = False  # something was sent again because no answer came, and what became of it is not known yet

    def begin(self) -> bytes:
        """Starts the numbers anew, far from those of frames that may still be under way. Returns the identity block."""
        self._forget()
        self._next = self._number = (self._next + 128) % 256
        self._line.drain()
        self._line.write(b"\0")  # ends whatever half frame the line left
        for _ in range(LINK_MOST_STRANGE):
            try:
                return self._exchange([Request(Command.IDENTIFY, answer=None)])[0].data
            except _Theirs:
                self._next = self._number = (self._number + 85) % 256
        raise device_error(self._line.path, "the board begins no session; is another program at it?")

    def make_room(self, frame_bytes: int, live_depth: int) -> None:
        """Learns from the identity block how long a frame the board always has room for, and how many live entries."""
        self._most_asking = max(1, frame_bytes // LINK_ASKING_BYTES)
        self._highest_level = live_depth

    def exchange(self, requests: Sequence[Request]) -> list[Reply]:
        """Replies in order. Raises HaptogramError when the board refuses a request; those after it are not applied."""
        if self._in_doubt:  # an exchange was cut short, even by Ctrl-C: a number used twice would be ignored
            self.begin()
        return self._exchange(requests)

    def tell(self, requests: Sequence[Request]) -> None:
        """Requests that have no answer and are not sent again: STREAM."""
        if self._in_doubt:
            self.begin()
        if self._stopped():
            raise Interrupted(self._line.path)
        for request in requests:
            self._line.write(encode_request(self._number, request))
        self._said = self._clock()
        self._line.read(0.0)  # sends what gathers; nothing is waited for, so nothing comes

    def rest(self) -> float:
        """Seconds until something new must be said, while outputs are on."""
        return max(0.0, self._said + (self.keep_alive or 0.0) - self._clock())

    def urge(self, *commands: Command) -> None:
        """DISABLE or STOP, which a board carries out as soon as they arrive, whatever came before and whatever their number.
        So this asks for no session, and an answer of any status confirms. If none comes, a break turns the outputs off.
        Nothing is sent behind them until then: a copy that is sent again acts again."""
        first, in_step = self._next + self._farthest, not self._in_doubt
        self._forget()
        left = {(first + place) % 256: command for place, command in enumerate(commands)}
        for tries in range(URGENT_TRIES * self._rounds):
            if tries == TRIES_BEFORE_BREAK * self._rounds:
                self._line.send_break(BREAK_BITS)
            self._line.urge(b"\0" + b"".join(encode_request(number, Request(command)) for number, command in left.items()))
            end = self._clock() + self.patience
            while left and self._clock() < end:
                for reply in self._decoder.feed(self._line.read(end - self._clock())):
                    if left.get(reply.sequence) == reply.command:
                        del left[reply.sequence]
                        in_step &= reply.status in APPLIED
            if not left:
                self._next, self._in_doubt = (first + len(commands)) % 256, not in_step
                return
        names = " and ".join(command.name.lower() for command in commands)
        raise device_error(self._line.path, f"the board did not confirm {names}, and a break of the line was sent")

    def _exchange(self, requests: Sequence[Request]) -> list[Reply]:
        mine = [_Pending(request) for request in requests]
        self._queue.extend(mine)
        self._in_doubt = True
        self._progress()
        done = 0
        while done < len(mine):
            if self._stopped():
                raise Interrupted(self._line.path)
            self._transmit()
            self._receive()
            while done < len(mine) and mine[done].reply:
                done += 1
        self._in_doubt = False
        return [one.reply for one in mine if one.reply]

    def _transmit(self) -> None:
        asking = under_way = 0
        for place, one in enumerate(islice(self._queue, self._window)):
            if one.reply:
                continue
            asking += one.request.answer != 0
            under_way += len(one.request.payload) + 8  # number, command, CRC, delimiter and stuffing
            if asking > self._most_asking or (under_way > self._window_bytes and place > 0):
                break
            if place >= self._sent:
                self._send(place, one.request)

    def _send(self, place: int, request: Request) -> None:
        self._line.write(encode_request((self._next + place) % 256, request))
        self._sent = place + 1
        if self._sent <= self._farthest:
            self.retransmissions += 1
        else:
            self._farthest, self._said = self._sent, self._clock()

    def _receive(self) -> None:
        until = self._since + self.patience
        if self.keep_alive:
            until = min(until, self._said + self.keep_alive)
        data = self._line.read(min(until - self._clock(), SLICE_S))
        self._heard += len(data)
        for reply in self._decoder.feed(data):
            self._take(reply)
        if not self._queue:
            return
        stuck = self._clock() - self._moved
        if stuck >= max(LINK_LOST_MS / 1000, 2 * self.patience):
            raise device_error(self._line.path, f"no answer to {self._queue[0].request.command.name.lower()} in {stuck:.0f} s; "
                               "check the cable, the baud rate and that the board runs Haptogram")  # fmt: skip
        if self._clock() - self._since >= self.patience:
            self._late = True
            self._send_again()
        elif self.keep_alive and self.rest() == 0:
            self._say_something()

    def _say_something(self) -> None:
        """A board that hears nothing new turns its outputs off. What it has not answered may be lost, so the first of that
        goes out again, too."""
        if self._sent and not self._queue[0].reply:
            self._line.write(b"\0" + encode_request(self._next, self._queue[0].request))
            self.retransmissions += 1
        if self._farthest < self._window:
            self._queue.insert(self._farthest, _Pending(Request(Command.KEEP_ALIVE)))
        self._said = self._clock()

    def _take(self, reply: Reply) -> None:
        place = (reply.sequence - self._next) % 256
        if place >= self._farthest:
            if place >= 128 and reply.status == Status.REPEATED and self._late and not self._tries:  # answered twice: it only came late
                self.patience, self._late = min(2 * self.patience, MOST_PATIENCE_S), False
            return
        one = self._queue[place]
        if one.reply or reply.command != one.request.command:
            return
        if one.request.command == Command.IDENTIFY and not _begins(reply):
            self._forget()
            raise _Theirs
        # What waits was flushed, and what came before it may have been: none of it is known, and none goes out again.
        if reply.status == Status.SESSION_ENDED:
            self._forget()
            raise device_error(self._line.path, "the board has ended the session, as after anybody's DISABLE or a lost link, and its outputs are off")
        if reply.status == Status.OUT_OF_ORDER:
            self._count_strange(place)
            self._mend_gap()
            return
        # A bit of a frame's end that is damaged can add a zero to it and leave its CRC right.
        if reply.status == Status.BAD_LENGTH and self._strange < LINK_MOST_STRANGE:
            self._strange += 1
            self._mend_gap()
            return
        if reply.status in APPLIED:
            self._check(one.request, reply)
        one.reply = reply
        # The board applies frames in order, so those before it were applied, too, and only their answers were lost.
        for before in islice(self._queue, place):
            if before.request.answer == 0 and not before.reply:
                before.reply = Reply(reply.sequence, before.request.command, Status.OK, reply.expected, reply.live_level, b"")
        self._finish()
        if place and self._queue and not self._queue[0].reply and self._sent:
            self._mend_gap()

    def _check(self, request: Request, reply: Reply) -> None:
        name = request.command.name.lower()
        if request.answer is not None and len(reply.data) != request.answer:
            raise device_error(self._line.path, f"the board's answer to {name} has {len(reply.data)} bytes of data, expected {request.answer}")
        if reply.live_level > self._highest_level:
            raise device_error(self._line.path, f"the board says that its live_level is {reply.live_level}, expected 0 to {self._highest_level}")

    def _finish(self) -> None:
        """Takes what is answered off the queue."""
        while self._queue and (reply := self._queue[0].reply):
            one = self._queue.popleft()
            if reply.status not in APPLIED:
                self._forget()  # it was not applied, so its number is still to be used, and those behind it were not either
                self._in_doubt = False
                raise Refused(f"{self._line.path}, command {one.request.command.name.lower()}", f"the board refused it: {reply.why()}")
            self._next = (self._next + 1) % 256
            self._sent, self._farthest = max(self._sent - 1, 0), self._farthest - 1
            if not self._late:
                self.patience = max(self.patience * 15 / 16, self._least_patience)
            self._progress()

    def _progress(self) -> None:
        self._since = self._clock()
        self._moved = self._since
        self._tries = self._strange = self._heard = 0
        self._last_gap = None

    def _count_strange(self, place: int) -> None:
        """A frame before this one is missing. But before the first that is not acknowledged there is none: one such answer may
        be left over from an earlier round, several mean that the board has forgotten us."""
        self._strange += place == 0
        if self._strange > LINK_MOST_STRANGE:
            raise device_error(self._line.path, "the board has lost the session, as after a reset; identify it again")

    def _mend_gap(self) -> None:
        """An answer tells that a frame or another answer was lost. That may be a lie, so it has an effect once per patience."""
        pause = min(self.patience, self.keep_alive or self.patience)
        if self._last_gap is None or self._clock() - self._last_gap >= pause:
            self._last_gap = self._clock()
            self._send_again()

    def _send_again(self) -> None:
        name = self._queue[0].request.command.name.lower()
        self._tries += 1
        most = self._rounds * (LINK_FIRST_TRIES if self._queue[0].request.command == Command.IDENTIFY else LINK_TRIES)
        if self._tries > most:
            heard = f", but {self._heard} bytes of something else" if self._heard else ""
            raise device_error(self._line.path, f"no answer to {name} after {most} tries{heard}; "
                               "check the cable, the baud rate and that the board runs Haptogram")  # fmt: skip
        self._since = self._clock()
        self._sent = 0
        self._line.write(b"\0")

    def _forget(self) -> None:
        self._queue.clear()
        self._sent = self._farthest = 0
        self._in_doubt = True


def off_note(watchdog_ms: int | None) -> str:
    """What becomes of outputs of which it is not known whether they are off; None: the watchdog's time is not known."""
    if watchdog_ms is None:
        return "the watchdog turns the outputs off, unless it was set to 0: then switch the board's power off"
    if watchdog_ms == 0:
        return "the outputs may still be on, and there is no watchdog: switch the board's power off"
    return f"the watchdog turns the outputs off, {watchdog_ms} ms after the last that it heard"


def shut_off(session: Session, watchdog_ms: int | None = None) -> None:
    """Outputs off and silence, whatever came before: the one way for everything that ever turned them on. Raises
    HaptogramError when the board does not confirm."""
    try:
        session.urge(Command.DISABLE, Command.STOP)
    except HaptogramError as error:
        raise device_error(error.where, f"{error.message}; {off_note(watchdog_ms)}") from error
