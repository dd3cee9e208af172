# SPDX-License-Identifier: Apache-2.0
"""The window against a board that is played here: what is lost, late, refused or forgotten."""
import random

import pytest
from haptogram import HaptogramError, session
from haptogram.frame import Request
from haptogram.interface import Command, Status
from test_frame import reply, unstuff

WRITES = [Request(Command.WRITE, bytes([n, 0, 0, 0, n, 0])) for n in range(20)]


class Board:
    """A line with a board behind it that applies frames in order. `fate` says of each frame that reaches it what becomes of
    the frame and its answer: "" nothing, "lost", "unanswered", "late" (the answer comes after the next time-out)."""

    def __init__(self, fate=lambda number, request: ""):
        self.fate = fate
        self.expected = None
        self.applied = []
        self.seen = 0
        self.waits = 0
        self.answers, self.late = b"", b""

    def write(self, data):
        for code in data.split(b"\0")[:-1]:
            if code:
                self.take(unstuff(code))

    def take(self, frame):
        sequence, command, payload = frame[0], Command(frame[1]), frame[2:-2]
        self.seen += 1
        fate = self.fate(self.seen, command)
        if fate == "lost":
            return
        if command == Command.IDENTIFY:
            self.expected = sequence
        ahead = None if self.expected is None else (sequence - self.expected) % 256
        if fate == "refused" and ahead == 0:
            status = Status.BAD_ADDRESS
        elif ahead == 0:
            status, self.expected = Status.OK, (sequence + 1) % 256
            self.applied.append((command, payload))
        else:
            status = Status.OUT_OF_ORDER if ahead is None or ahead < 128 else Status.REPEATED
        answer = reply(sequence, command, status, self.expected or 0, data=b"data")
        if fate == "late":
            self.late += answer
        elif fate != "unanswered":
            self.answers += answer

    def read(self, patience):
        self.waits += not self.answers
        if not self.answers:
            self.answers, self.late = self.late, b""
            return b""
        data, self.answers = self.answers[:5], self.answers[5:]  # as from a slow line
        return data

    def drain(self):
        pass  # the worst case: answers are on their way

    def close(self):
        pass

    def written(self):
        return [payload for command, payload in self.applied if command == Command.WRITE]


def begun(**options):
    board = Board(**options)
    client = session.Session(board)
    client.begin()
    return board, client


def test_all_in_order_and_once():
    board, client = begun()
    assert len(client.exchange(WRITES * 20)) == 400  # the numbers come round
    assert board.written() == [r.payload for r in WRITES * 20]
    assert (client.retransmissions, board.waits) == (0, 0)


@pytest.mark.parametrize("fate", ["lost", "unanswered"])
@pytest.mark.parametrize("number", [2, 5, 9, 10, 21])
def test_one_frame_or_its_answer_is_lost(fate, number):
    board, client = begun(fate=lambda n, _: fate if n == number else "")
    client.exchange(WRITES)
    assert board.written() == [r.payload for r in WRITES]
    assert 0 < client.retransmissions <= session.LINK_WINDOW
    assert board.waits == (number == 21)  # only at the end nothing follows that tells of the gap
    assert client.patience == 0.3


def test_a_board_that_answers_late_is_given_more_time():
    board, client = begun(fate=lambda n, _: "late" if n in (2, 4) else "")
    for n in range(4):
        client.exchange(WRITES[n : n + 1])
    assert board.written() == [r.payload for r in WRITES[:4]]
    doubled_twice = client.patience
    assert 1.0 < doubled_twice <= 1.2  # an answer in time between them took a sixteenth back
    for n in range(4, 20):
        client.exchange(WRITES[n : n + 1])
    assert client.patience == pytest.approx(max(0.3, doubled_twice * (15 / 16) ** 16))
    client.exchange(WRITES * 5)
    assert client.patience == 0.3
    assert board.written() == [r.payload for r in WRITES + WRITES * 5]


def test_no_more_requests_for_data_are_under_way_than_the_board_has_room_for():
    board, client = begun()
    client.make_room(214)
    under_way = []
    write, read = board.write, board.read
    board.write = lambda data: (under_way.append(len(data) > 1), write(data))
    board.read = lambda patience: (most.append(sum(under_way)), under_way.clear(), read(patience))[-1]
    most = []
    assert len(client.exchange([Request(Command.STATUS)] * 40)) == 40
    assert max(most) == min(session.LINK_WINDOW, 214 // session.LINK_ASKING_BYTES)
    client.make_room(40)
    most.clear()
    client.exchange([Request(Command.STATUS)] * 40)
    assert max(most) == 3
    most.clear()
    client.exchange(WRITES)
    assert max(most) == session.LINK_WINDOW


@pytest.mark.parametrize("seed", range(20))
def test_all_in_order_and_once_on_a_line_that_loses_one_frame_in_four(seed):
    generator = random.Random(seed)
    board, client = begun(fate=lambda n, _: generator.choice(["lost", "unanswered", "late"]) if n > 1 and generator.random() < 0.25 else "")
    client.exchange(WRITES * 10)
    assert board.written() == [r.payload for r in WRITES * 10]
    assert client.retransmissions > 0


def test_what_is_refused_is_told_and_those_after_it_are_not_applied():
    board, client = begun(fate=lambda n, _: "refused" if n == 4 else "")
    with pytest.raises(HaptogramError, match="command write: the board refused it: bad_address") as error:
        client.exchange(WRITES[:6])
    assert error.value.code == 4
    assert board.written() == [r.payload for r in WRITES[:2]]
    client.exchange(WRITES[10:])
    assert board.written() == [r.payload for r in WRITES[:2] + WRITES[10:]]


def test_no_answer():
    board, client = begun(fate=lambda n, _: "lost" if n > 1 else "")
    with pytest.raises(HaptogramError, match="no answer to write after 32 tries; check the cable"):
        client.exchange(WRITES)
    assert board.waits == session.LINK_TRIES + 1


def test_after_a_reset_the_session_is_lost_and_then_begun_anew():
    board, client = begun()
    board.expected = None
    with pytest.raises(HaptogramError, match="lost the session"):
        client.exchange(WRITES)
    client.exchange(WRITES[:3])
    assert board.written() == [r.payload for r in WRITES[:3]]


def test_after_an_exchange_cut_short_no_request_is_taken_for_an_old_one():
    """Its frame is applied, its answer never seen; the next request with the same number would be ignored as repeated."""
    board, client = begun(fate=lambda n, _: "unanswered" if 2 <= n <= 2 + session.LINK_TRIES else "")
    with pytest.raises(HaptogramError, match="no answer"):
        client.exchange([Request(Command.STATUS)])
    client.exchange([Request(Command.DISABLE)])
    assert Command.DISABLE in [command for command, _ in board.applied]
