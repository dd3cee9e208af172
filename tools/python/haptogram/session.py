# SPDX-License-Identifier: Apache-2.0
"""Requests in a window, each acknowledged. What is lost is sent again from the first missing one on; the board applies
each exactly once and in order."""
from collections.abc import Sequence
from typing import Protocol

from .errors import device_error
from .frame import Reply, ReplyDecoder, Request, encode_request
from .interface import Command, Status

WINDOW = 8  # frames under way
FIRST_TRIES = 8  # until somebody answers at all
MOST_TRIES = 32  # without any progress: ten seconds, in which a busy machine runs its virtual board again
MOST_STRANGE = 4
MOST_PATIENCE_S = 10.0


class Line(Protocol):
    """A byte stream to a board."""

    def write(self, data: bytes) -> None: ...

    def read(self, patience: float) -> bytes:
        """What has arrived; waits at most `patience` seconds for the first byte. Empty when nothing came."""

    def drain(self) -> None:
        """Drops what has arrived."""

    def close(self) -> None: ...


class Session:
    def __init__(self, line: Line, patience: float = 0.3) -> None:
        self.patience = patience  # seconds to wait for an answer before sending again
        self.retransmissions = 0
        self._line = line
        self._decoder = ReplyDecoder()
        self._next = 0
        self._in_step = False  # the board's next number is ours
        self._ran_out = False  # of patience, since the last answer that came too late

    def begin(self) -> bytes:
        """Starts the numbers anew, far from those of frames that may still be under way. Returns the identity block."""
        self._next = (self._next + 128) % 256
        self._line.drain()
        self._line.write(b"\0")  # ends whatever half frame the line left
        return self._exchange([Request(Command.IDENTIFY)])[0].data

    def exchange(self, requests: Sequence[Request]) -> list[Reply]:
        """Replies in order. Raises HaptogramError when the board refuses a request; those after it are not applied."""
        if not self._in_step:  # an exchange was cut short, even by Ctrl-C: a number used twice would be ignored
            self.begin()
        return self._exchange(requests)

    def _exchange(self, requests: Sequence[Request]) -> list[Reply]:
        replies: list[Reply] = []
        first, sent, farthest = self._next, 0, 0
        tries = strange = 0
        gap = False  # it was sent again because of a gap; more answers that tell of the same one are on their way
        self._in_step = False
        while len(replies) < len(requests):
            while sent < min(len(requests), len(replies) + WINDOW):
                self._line.write(encode_request((first + sent) % 256, requests[sent]))
                self.retransmissions += sent < farthest
                sent += 1
                farthest = max(farthest, sent)
            data = self._line.read(self.patience)
            again = not data
            if again:
                gap, self._ran_out = False, True
            for reply in self._decoder.feed(data):
                if len(replies) == len(requests):
                    break
                request = requests[len(replies)]
                ahead = (reply.sequence - first - len(replies)) % 256
                mine = ahead == 0 and reply.command == request.command
                if mine and reply.status in (Status.OK, Status.REPEATED):
                    replies.append(reply)
                    tries = strange = 0
                    again = gap = False
                elif mine and reply.status != Status.OUT_OF_ORDER:
                    self._next, self._in_step = reply.sequence, True
                    raise device_error(f"command {request.command.name.lower()}", f"the board refused it: {reply.why()}")
                elif mine:
                    # A frame before it is missing. But before the first that is not acknowledged there is none: one such
                    # answer may be left over from an earlier round, several mean that the board knows nothing of us.
                    strange += 1
                    if strange > MOST_STRANGE:
                        raise device_error("board", "it has lost the session, as after a reset; identify it again")
                    again = True
                elif 0 < ahead < sent - len(replies) and not gap:  # the frame that we wait for was lost, or its answer
                    again = gap = True
                elif ahead >= 128 and reply.status == Status.REPEATED and self._ran_out:  # answered twice: it only came late
                    self.patience, self._ran_out = min(2 * self.patience, MOST_PATIENCE_S), False
            if again:
                tries += 1
                command = requests[len(replies)].command
                most = FIRST_TRIES if command == Command.IDENTIFY else MOST_TRIES
                if tries > most:
                    raise device_error("board", f"no answer to {command.name.lower()} after {most} tries; "
                                       "check the cable, the baud rate and that the board runs Haptogram")  # fmt: skip
                sent = len(replies)
                self._line.drain()
                self._line.write(b"\0")
        self._next, self._in_step = (first + len(requests)) % 256, True
        return replies
