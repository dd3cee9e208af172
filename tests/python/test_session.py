# SPDX-License-Identifier: Apache-2.0
"""The window against a board that is played here: what is lost, late, refused or forgotten."""
import random
from collections import deque

import pytest
from haptogram import HaptogramError, session
from haptogram.errors import Interrupted
from haptogram.frame import Request
from haptogram.interface import Command, Status
from messages import refusal
from test_frame import reply, unstuff

ASKING = (Command.IDENTIFY, Command.READ, Command.STATUS, Command.DIGEST)  # their replies carry data
STATUS = Request(Command.STATUS, answer=4)
WRITES = [Request(Command.WRITE, bytes([n, 0, 0, 0, n, 0])) for n in range(20)]


class Board:
    """A line with a board behind it that applies frames in order. `fate` says of each frame that reaches it what becomes of
    the frame and its answer: "" nothing, "lost", "unanswered", "late" (the answer comes when the frame has come again). Its
    clock goes on only when the client waits for nothing."""

    path = "port"

    def __init__(self, fate=lambda number, request: "", session=None):
        self.session, self.ended = session, False  # the number of the IDENTIFY that began it
        self.now = 0.0
        self.breaks = 0
        self.answer, self.level = 4, 0  # bytes of the data asked for; live entries
        self.fate = fate
        self.expected = None
        self.applied = []
        self.seen = 0
        self.answers, self.late = b"", {}

    def write(self, data):
        for code in data.split(b"\0")[:-1]:
            if code:
                self.take(unstuff(code))

    def take(self, frame):
        sequence, command, payload = frame[0], Command(frame[1]), frame[2:-2]
        self.seen += 1
        self.answers += self.late.pop(sequence, b"")
        fate = self.fate(self.seen, command)
        if fate == "lost":
            return
        copy = command == Command.IDENTIFY and sequence == self.session and self.expected is not None
        if command == Command.IDENTIFY and not copy:
            self.session = self.expected = sequence
        ahead = None if self.expected is None else (sequence - self.expected) % 256
        if fate == "refused" and ahead == 0:
            status = Status.BAD_ADDRESS
        elif ahead == 0:
            status, self.expected = Status.OK, (sequence + 1) % 256
            self.applied.append((command, payload))
        else:
            status = Status.OUT_OF_ORDER if ahead is None or ahead < 128 else Status.REPEATED
        if copy and ahead != 0:
            status = Status.SESSION_ENDED if self.ended else Status.REPEATED
        answer = reply(sequence, command, status, self.expected or 0, data=bytes(self.answer) if command in ASKING else b"", level=self.level)
        if fate == "late":
            self.late.setdefault(sequence, answer)
        elif fate != "unanswered":
            self.answers += answer

    def read(self, patience):
        if not self.answers:
            self.now += max(patience, 1e-6)
        data, self.answers = self.answers[:5], self.answers[5:]  # as from a slow line
        return data

    urge = write

    def send_break(self, bits):
        self.breaks += bits >= 25

    def drain(self):
        pass  # the worst case: answers are on their way

    def close(self):
        pass

    def written(self):
        return [payload for command, payload in self.applied if command == Command.WRITE]


def begun(**options):
    board = Board(**options)
    client = session.Session(board, clock=lambda: board.now)
    client.begin()
    return board, client


def test_no_more_bytes_are_under_way_than_the_board_has_room_for():
    class SmallBoard(Board):
        window_bytes = 700
        most = 0

        def __init__(self):
            super().__init__()
            self.waiting = deque()  # bytes of each frame whose answer was not read

        def write(self, data):
            self.waiting.extend(len(code) + 1 for code in data.split(b"\0") if code)
            self.most = max(self.most, sum(self.waiting))
            super().write(data)

        def read(self, patience):
            data = super().read(patience)
            for _ in range(min(data.count(0), len(self.waiting))):
                self.waiting.popleft()
            return data

    board = SmallBoard()
    client = session.Session(board, clock=lambda: board.now)
    client.begin()
    client.exchange([Request(Command.WRITE, bytes(208))] * 20)
    assert [command for command, _ in board.applied].count(Command.WRITE) == 20
    assert 600 < board.most <= 700


def test_all_in_order_and_once():
    board, client = begun()
    assert len(client.exchange(WRITES * 20)) == 400  # the numbers come round
    assert board.written() == [r.payload for r in WRITES * 20]
    assert (client.retransmissions, board.now) == (0, 0)


def test_a_link_is_lost_after_ten_seconds_however_long_the_patience_has_grown():
    silent = False
    board, client = begun(fate=lambda n, _: "lost" if silent else "")
    client.patience = 2.0
    silent = True
    since = board.now
    with pytest.raises(HaptogramError, match="no answer to write"):
        client.exchange(WRITES)
    assert 9.9 < board.now - since < 10.6


@pytest.mark.parametrize("ended", [False, True])
def test_a_number_that_began_somebody_elses_session_is_not_taken_twice(ended):
    board = Board()
    client = session.Session(board, clock=lambda: board.now)
    first = (client._next + 128) % 256
    board.session, board.expected, board.ended = first, (first + 20) % 256, ended
    client.begin()
    assert board.session == (first + 85) % 256
    client.exchange(WRITES)
    assert board.written() == [r.payload for r in WRITES]


@pytest.mark.parametrize("fate", ["lost", "unanswered"])
@pytest.mark.parametrize("number", [2, 5, 9, 10, 21])
def test_one_frame_or_its_answer_is_lost(fate, number):
    board, client = begun(fate=lambda n, _: fate if n == number else "")
    client.exchange(WRITES)
    assert board.written() == [r.payload for r in WRITES]
    assert 0 < client.retransmissions <= session.LINK_WINDOW
    assert board.now == pytest.approx(0.3 * (number == 21), abs=0.01)  # only at the end nothing follows that tells of the gap
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
    client.make_room(214, 256)
    under_way = []
    write, read = board.write, board.read
    board.write = lambda data: (under_way.append(len(data) > 1), write(data))
    board.read = lambda patience: (most.append(sum(under_way)), under_way.clear(), read(patience))[-1]
    most = []
    assert len(client.exchange([STATUS] * 40)) == 40
    assert max(most) == min(session.LINK_WINDOW, 214 // session.LINK_ASKING_BYTES)
    client.make_room(40, 256)
    most.clear()
    client.exchange([STATUS] * 40)
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
    with refusal(HaptogramError) as error:
        client.exchange(WRITES[:6])
    assert error.value.code == 4
    assert board.written() == [r.payload for r in WRITES[:2]]
    client.exchange(WRITES[10:])
    assert board.written() == [r.payload for r in WRITES[:2] + WRITES[10:]]


def test_no_answer():
    board, client = begun(fate=lambda n, _: "lost" if n > 1 else "")
    with refusal(HaptogramError):
        client.exchange(WRITES)
    assert board.now == pytest.approx(0.3 * (session.LINK_TRIES + 1), abs=0.01)


def test_after_a_reset_the_session_is_lost_and_then_begun_anew():
    board, client = begun()
    board.expected = None
    with refusal(HaptogramError):
        client.exchange(WRITES)
    client.exchange(WRITES[:3])
    assert board.written() == [r.payload for r in WRITES[:3]]


def test_after_an_exchange_cut_short_no_request_is_taken_for_an_old_one():
    """Its frame is applied, its answer never seen; the next request with the same number would be ignored as repeated."""
    board, client = begun(fate=lambda n, _: "unanswered" if 2 <= n <= 2 + session.LINK_TRIES else "")
    with refusal(HaptogramError):
        client.exchange([STATUS])
    client.exchange(WRITES[:1])
    assert board.written() == [WRITES[0].payload]


def test_sessions_begin_at_any_number():
    assert len({begun()[0].expected for _ in range(20)}) > 5


def test_a_line_that_talks_without_end_is_no_board():
    """Bytes that answer nothing do not renew the patience."""
    board = Board()
    board.read = lambda patience: (setattr(board, "now", board.now + 0.001), b"$GPGGA,123519,4807.038,N*47\r\n\0")[1]
    with refusal(HaptogramError):
        session.Session(board, clock=lambda: board.now).begin()
    assert board.now == pytest.approx(0.3 * (session.LINK_FIRST_TRIES + 1), abs=0.1)


def test_a_line_without_a_zero_fills_no_memory():
    board = Board()
    board.read = lambda patience: (setattr(board, "now", board.now + 0.001), bytes([1]) * 4096)[1]
    client = session.Session(board, clock=lambda: board.now)
    with refusal(HaptogramError):
        client.begin()
    assert len(client._decoder._splitter._rest) <= 4096


def asks_for_nothing_else(board, limit):
    """Frames that reached the board within so much time, at most."""
    assert board.seen <= limit, f"{board.seen} frames in {board.now:.1f} s"


def test_a_data_reply_that_is_always_lost_ends_the_link():
    """Answers to what is behind it come all the time, each of which tells that this one was lost."""
    board, client = begun(fate=lambda n, command: "unanswered" if command == Command.STATUS else "")
    with refusal(HaptogramError):
        client.exchange([STATUS, *WRITES])
    assert 0.3 * session.LINK_TRIES - 0.1 < board.now < 0.3 * (session.LINK_TRIES + 2)
    asks_for_nothing_else(board, 3 * len(WRITES) + 2 * session.LINK_TRIES)


def test_replies_in_another_order_are_taken():
    board, client = begun()
    read = board.read

    def shuffled(patience):
        parts = board.answers.split(b"\0")[:-1]
        if parts:
            board.answers = b"".join(part + b"\0" for part in reversed(parts))
            board.read = lambda _: (board.answers, setattr(board, "answers", b""), setattr(board, "read", shuffled))[0]
            return board.read(patience)
        return read(patience)

    board.read = shuffled
    assert [r.command for r in client.exchange([STATUS, *WRITES, STATUS] * 5)] == [r.command for r in [STATUS, *WRITES, STATUS] * 5]
    assert board.written() == [r.payload for r in WRITES * 5]
    asks_for_nothing_else(board, 4 * 5 * 22)


@pytest.mark.parametrize("size", [0, 3, 5, 500])
def test_an_answer_of_another_length_is_an_error(size):
    board, client = begun()
    board.answer = size
    with refusal(HaptogramError) as error:
        client.exchange([Request(Command.STATUS, answer=4)])
    assert error.value.code == 4


def test_more_live_entries_than_there_is_room_for_are_an_error():
    board, client = begun()
    client.make_room(214, 256)
    board.level = 257
    with refusal(HaptogramError):
        client.exchange(WRITES[:1])


def test_something_new_is_said_while_an_answer_is_late():
    board, client = begun(fate=lambda n, command: "unanswered" if command == Command.STATUS and board_now() < 1.0 else "")
    board_now = lambda: board.now
    client.keep_alive = 0.1
    client.exchange([STATUS])
    kept = [command for command, _ in board.applied].count(Command.KEEP_ALIVE)
    assert 8 <= kept <= 12 and 1.0 <= board.now < 1.4


def test_a_lost_frame_does_not_keep_the_board_from_hearing_something_new():
    """Two frames in a row are lost; what comes behind them is refused as out of order until they have come again."""
    board, client = begun(fate=lambda n, _: "lost" if n in (3, 4) else "")
    times = []
    take = board.take
    board.take = lambda frame: (take(frame), times.append((board.now, len(board.applied))))
    client.keep_alive = 0.1
    client.exchange(WRITES[:1])
    client.exchange([STATUS])
    new = [time for i, (time, count) in enumerate(times) if count > (times[i - 1][1] if i else 1)]
    assert max(b - a for a, b in zip(new, new[1:], strict=False)) <= 0.31


def test_what_is_urgent_needs_no_session():
    board = Board()
    client = session.Session(board, clock=lambda: board.now)
    client.urge(Command.DISABLE, Command.STOP)  # refused as out of order, which tells that they came
    assert (board.seen, board.breaks, board.applied) == (2, 0, [])
    client.exchange(WRITES[:2])
    client.urge(Command.STOP)
    client.exchange(WRITES[2:4])
    assert board.written() == [r.payload for r in WRITES[:4]]
    assert board.seen == 2 + 1 + 2 + 1 + 2  # one session


def test_what_is_urgent_and_not_confirmed():
    board, client = begun(fate=lambda n, _: "lost" if n > 1 else "")
    with refusal(HaptogramError) as error:
        session.shut_off(client, 500)
    assert error.value.code == 4
    assert (board.seen, board.breaks) == (1 + 2 * session.URGENT_TRIES, 1)
    assert board.now <= 2.0


@pytest.mark.parametrize("lost", [1, 2, 3, 7])
def test_what_is_urgent_is_sent_until_it_is_confirmed(lost):
    board, client = begun(fate=lambda n, _: "unanswered" if 2 <= n < 2 + lost else "")
    client.urge(Command.DISABLE, Command.STOP)
    assert board.breaks == (lost >= 3)
    client.exchange(WRITES)
    assert board.written() == [r.payload for r in WRITES]


def test_after_a_signal_nothing_is_sent_but_what_is_urgent():
    board = Board(fate=lambda n, _: "unanswered" if n > 2 else "")
    client = session.Session(board, clock=lambda: board.now, stopped=lambda: board.now > 0.2)
    client.exchange(WRITES[:1])
    with refusal(Interrupted):
        client.exchange([Request(Command.ENABLE)])
    seen = board.seen
    with pytest.raises(Interrupted):
        client.exchange([Request(Command.ENABLE)])
    assert board.seen == seen and board.now < 0.3
    board.fate = lambda n, _: ""
    client.urge(Command.DISABLE)
    assert board.seen == seen + 1
