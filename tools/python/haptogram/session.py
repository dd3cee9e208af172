# SPDX-License-Identifier: Apache-2.0
"""Requests in a window, each acknowledged. What is lost is sent again from the first missing one on; the board applies
each exactly once and in order. How often and how soon, and when a link counts as lost, is one policy for all hosts of
this project: see "A line that loses bytes" in rtl/INTERFACE.md."""
from collections.abc import Sequence
from typing import Protocol

from .errors import device_error
from .frame import Reply, ReplyDecoder, Request, encode_request
from .interface import (
    LINK_ASKING_BYTES,
    LINK_FIRST_TRIES,
    LINK_MOST_PATIENCE_MS,
    LINK_MOST_STRANGE,
    LINK_PATIENCE_MS,
    LINK_TRIES,
    LINK_WINDOW,
    Command,
    Status,
)

PATIENCE_S = LINK_PATIENCE_MS / 1000
MOST_PATIENCE_S = LINK_MOST_PATIENCE_MS / 1000
ASKING = (Command.IDENTIFY, Command.READ, Command.STATUS, Command.DIGEST)  # their replies carry data


class Line(Protocol):
    """A byte stream to a board."""

    def write(self, data: bytes) -> None: ...

    def read(self, patience: float) -> bytes:
        """What has arrived; waits at most `patience` seconds for the first byte. Empty when nothing came."""

    def drain(self) -> None:
        """Drops what has arrived."""

    def close(self) -> None: ...


class Session:
    def __init__(self, line: Line, patience: float = PATIENCE_S) -> None:
        self.patience = self._least_patience = patience  # seconds to wait for an answer before sending again
        self.retransmissions = 0
        self.most_asking = 1  # requests under way whose replies carry data: the board keeps room for so many
        self._line = line
        self._decoder = ReplyDecoder()
        self._next = 0
        self._in_step = False  # the board expects the number that we send next
        self._late = False  # something was sent again because no answer came, and what became of it is not known yet

    def begin(self) -> bytes:
        """Starts the numbers anew, far from those of frames that may still be under way. Returns the identity block."""
        self._next = (self._next + 128) % 256
        self._line.drain()
        self._line.write(b"\0")  # ends whatever half frame the line left
        return self._exchange([Request(Command.IDENTIFY)])[0].data

    def make_room(self, frame_bytes: int) -> None:
        """Learns from the identity block how long a frame the board always has room for."""
        self.most_asking = max(1, frame_bytes // LINK_ASKING_BYTES)

    def exchange(self, requests: Sequence[Request]) -> list[Reply]:
        """Replies in order. Raises HaptogramError when the board refuses a request; those after it are not applied."""
        if not self._in_step:  # an exchange was cut short, even by Ctrl-C: a number used twice would be ignored
            self.begin()
        return self._exchange(requests)

    def _exchange(self, requests: Sequence[Request]) -> list[Reply]:
        replies: list[Reply] = []
        first, sent, farthest = self._next, 0, 0
        tries = strange = 0
        gap = False  # all was sent again because of a gap, and more answers that tell of the same gap are on their way
        self._in_step = False
        while len(replies) < len(requests):
            asking = sum(request.command in ASKING for request in requests[len(replies) : sent])
            while sent < min(len(requests), len(replies) + LINK_WINDOW):
                asking += requests[sent].command in ASKING
                if asking > self.most_asking:
                    break
                self._line.write(encode_request((first + sent) % 256, requests[sent]))
                self.retransmissions += sent < farthest
                sent += 1
                farthest = max(farthest, sent)
            data = self._line.read(self.patience)
            again = not data
            if again:
                gap, self._late = False, True
                command = requests[len(replies)].command
                tries += 1
                most = LINK_FIRST_TRIES if command == Command.IDENTIFY else LINK_TRIES
                if tries > most:
                    raise device_error("board", f"no answer to {command.name.lower()} after {most} tries; "
                                       "check the cable, the baud rate and that the board runs Haptogram")  # fmt: skip
            for reply in self._decoder.feed(data):
                if len(replies) == len(requests):
                    break
                request = requests[len(replies)]
                ahead = (reply.sequence - first - len(replies)) % 256
                mine = ahead == 0 and reply.command == request.command
                if mine and reply.status in (Status.OK, Status.REPEATED):
                    replies.append(reply)
                    if not self._late:
                        self.patience = max(self.patience * 15 / 16, self._least_patience)
                    tries = strange = 0
                    again = gap = False
                elif mine and reply.status != Status.OUT_OF_ORDER:
                    self._next, self._in_step = reply.sequence, True
                    raise device_error(f"command {request.command.name.lower()}", f"the board refused it: {reply.why()}")
                elif mine:
                    # A frame before it is missing. But before the first that is not acknowledged there is none: one such
                    # answer may be left over from an earlier round, several mean that the board has forgotten us.
                    strange += 1
                    if strange > LINK_MOST_STRANGE:
                        raise device_error("board", "it has lost the session, as after a reset; identify it again")
                    again = True
                elif 0 < ahead < sent - len(replies) and not gap:  # the frame that we wait for was lost, or its answer
                    again = gap = True
                elif ahead >= 128 and reply.status == Status.REPEATED and self._late:  # answered twice: it only came late
                    self.patience, self._late = min(2 * self.patience, MOST_PATIENCE_S), False
            if again:
                sent = len(replies)
                self._line.drain()
                self._line.write(b"\0")
        self._next, self._in_step = (first + len(requests)) % 256, True
        return replies
