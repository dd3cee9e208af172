# SPDX-License-Identifier: Apache-2.0
"""Playing: outputs on, what is to be played, outputs off. Asking for the status also keeps the board's watchdog quiet."""
import contextlib
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

from .board import Status
from .client import Board
from .errors import Interrupted, bad_input, device_error
from .link import never

Entry = tuple[int, int]  # index; dwell in cycles, 0 until the next
FULL_PAUSE_S = 0.001  # until a full live FIFO is looked at again


class Outcome(NamedTuple):
    underruns: int
    refused_records: int
    watchdog_trips: int
    guard_trips: int
    interrupted: bool


def end_like_ctrl_c() -> None:
    """SIGTERM, SIGQUIT and the terminal that closes then end a program as Ctrl-C does, with a KeyboardInterrupt, so that outputs()
    turns the outputs off; without this they end it at once, and the watchdog must."""
    for number in (signal.SIGTERM, signal.SIGQUIT, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # nohup has SIGHUP ignored
            signal.signal(number, signal.default_int_handler)


def _is_over(status: Status) -> bool:
    """Whether nothing plays and nothing is to come."""
    return status.present_index == 0 and status.live_level == 0 and status.mode in ("idle", "live")


def _watch(board: Board, before: Status) -> Status:
    """The board's status; when it says that all is over, it is asked for a second time. For between the clock in which a record of
    amplitudes is taken and its first pulse passes up to one carrier period, which is less than a status takes on the line.
    Raises HaptogramError when the board has turned its outputs off by itself."""
    now = board.status()
    if _is_over(now):
        now = board.status()
    if not now.enabled:
        why = "its watchdog or guard tripped"
        if now.watchdog_trips != before.watchdog_trips:
            why = f"its watchdog heard nothing from this host for {now.watchdog_ms} ms"
        elif now.guard_trips != before.guard_trips:
            why = "its guard found a pin high for too long; nothing that was sent may do that: reset the board"
        elif now.stopped:
            why = "its stop input is active"
        raise device_error("board", f"it has turned its outputs off: {why}")
    return now


def _outcome(before: Status, now: Status, interrupted: bool) -> Outcome:
    def since(name: str) -> int:
        return int(getattr(now, name) - getattr(before, name)) % 65536

    return Outcome(since("underruns"), since("refused_records"), since("watchdog_trips"), since("guard_trips"), interrupted)


def _nothing() -> None: ...


def play(board: Board, *, index: int = 0, loops: int | None = None, seconds: float = 0.0, watchdog_ms: int = 500, on_trigger: bool = False,
         stopped: Callable[[], bool] = never, started: Callable[[], None] = _nothing, pause: Callable[[float], object] = time.sleep) -> Outcome:  # fmt: skip
    """Plays one record, or with index 0 the sequence, `loops` times (0 for ever; None as its header says), until its end,
    for at most so many seconds (0: no limit), or until `stopped` says so; if it does before the outputs are on, they stay off.
    With `on_trigger` the sequence waits, with outputs on and silent, until the trigger input says so. Calls `started` when the
    board has said that it plays; the seconds begin then. `pause` sleeps between two looks at `stopped`, and may end early."""
    if on_trigger and index:
        raise bad_input("on_trigger", "one record cannot wait for a trigger; the sequence can")
    length = 0 if index else board.sequence_length()
    before = now = board.status()
    interrupted = True
    with contextlib.suppress(Interrupted), board.outputs(watchdog_ms, stopped):
        if index:
            board.select(index)
        elif loops is None:
            board.start(on_trigger=on_trigger)
        else:
            board.start(1, length, loops, on_trigger=on_trigger)
        waits = on_trigger
        if not waits:
            started()
        end = time.monotonic() + seconds
        while not stopped() and (waits or not (seconds and time.monotonic() >= end)):
            board.rest(pause)
            now = _watch(board, before)
            if waits and not now.waiting:
                waits, end = False, time.monotonic() + seconds
                started()
            if not waits and _is_over(now):
                break
        interrupted = stopped()
    return _outcome(before, now, interrupted)


def stream(board: Board, batches: Iterable[Sequence[Entry]], *, watchdog_ms: int = 500,
           stopped: Callable[[], bool] = never) -> tuple[int, Outcome]:  # fmt: skip
    """Plays entries as they come, no faster than the board takes them, to the last one or until `stopped` says so; if it does
    before the outputs are on, they stay off. Returns how many were sent. A source that has nothing yet gives an empty batch,
    at least every keep_alive_pause()."""
    before = now = board.status()
    sent, interrupted = 0, True
    with contextlib.suppress(Interrupted), board.outputs(watchdog_ms, stopped):
        for run in _runs(board, before, batches, stopped):
            sent += run
        # Silence for good comes last: running out of indices would count as an underrun.
        silent = False
        now = _watch(board, before)
        while not stopped() and not (silent and _is_over(now)):
            if not silent and now.live_level < board.identity.live_depth:
                board.push([0], 0)
                silent = True
            board.rest()
            now = _watch(board, before)
        interrupted = stopped()
    return sent, _outcome(before, now, interrupted)


def _runs(board: Board, before: Status, batches: Iterable[Sequence[Entry]], stopped: Callable[[], bool]) -> Iterator[int]:
    """Pushes entries of one dwell together; says of each push how many they were."""
    depth = board.identity.live_depth
    most = min(depth, board.identity.channels)  # a frame holds at most as many indices as a record has words
    level = 0
    for batch in batches:
        if not batch:
            level = _watch(board, before).live_level
        at = 0
        while at < len(batch) and not stopped():
            room = min(most, depth - level)
            if room < min(most, depth // 2):
                time.sleep(FULL_PAUSE_S)
                level = _watch(board, before).live_level
                continue
            dwell, group = next(groupby(batch[at : at + room], key=itemgetter(1)))
            run = [index for index, _ in group]
            level = board.push(run, dwell)
            at += len(run)
            yield len(run)
        if stopped():
            return
