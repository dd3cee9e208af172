# SPDX-License-Identifier: Apache-2.0
"""Playing: outputs on, what is to be played, outputs off. Asking for the status also keeps the board's watchdog quiet."""
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

from .board import Status
from .client import Client
from .errors import device_error
from .interface import LINK_KEEP_ALIVE_MS, LINK_KEEP_ALIVE_SHARE

Entry = tuple[int, int]  # index; dwell in cycles, 0 until the next
FULL_PAUSE_S = 0.001  # until a full live FIFO is looked at again


class Outcome(NamedTuple):
    underruns: int
    refused_records: int
    watchdog_trips: int
    guard_trips: int
    interrupted: bool


def never() -> bool:
    return False


def keep_alive_pause(watchdog_ms: int) -> float:
    """Seconds within which a host must say something while outputs are on."""
    within_watchdog = watchdog_ms // LINK_KEEP_ALIVE_SHARE + 1
    return 0.001 * (min(LINK_KEEP_ALIVE_MS, within_watchdog) if watchdog_ms else LINK_KEEP_ALIVE_MS)


def _is_over(status: Status) -> bool:
    """Whether nothing plays and nothing is to come."""
    return status.present_index == 0 and status.live_level == 0 and status.mode in ("idle", "live")


def _watch(board: Client) -> Status:
    """The board's status; when it says that all is over, it is asked for a second time. For between the clock in which a record of
    amplitudes is taken and its first pulse passes up to one carrier period, which is less than a status takes on the line.
    Raises HaptogramError when the board has turned its outputs off by itself."""
    now = board.status()
    if _is_over(now):
        now = board.status()
    if not now.enabled:
        raise device_error("board", "it has turned its outputs off: its watchdog or guard tripped")
    return now


def _outcome(before: Status, now: Status, interrupted: bool) -> Outcome:
    def since(name: str) -> int:
        return int(getattr(now, name) - getattr(before, name)) % 65536

    return Outcome(since("underruns"), since("refused_records"), since("watchdog_trips"), since("guard_trips"), interrupted)


def play(board: Client, *, index: int = 0, loops: int | None = None, seconds: float = 0.0, watchdog_ms: int = 500,
         stopped: Callable[[], bool] = never) -> Outcome:  # fmt: skip
    """Plays one record, or with index 0 the sequence, `loops` times (0 for ever; None as its header says), until its end,
    for at most so many seconds (0: no limit), or until `stopped` says so."""
    length = 0 if index else board.sequence_length()
    pause = keep_alive_pause(watchdog_ms)
    before = now = board.status()
    with board.outputs(watchdog_ms):
        if index:
            board.select(index)
        elif loops is None:
            board.start()
        else:
            board.start(1, length, loops)
        end = time.monotonic() + seconds
        while not stopped() and not (seconds and time.monotonic() >= end):
            time.sleep(pause)
            now = _watch(board)
            if _is_over(now):
                break
    return _outcome(before, now, stopped())


def stream(board: Client, batches: Iterable[Sequence[Entry]], *, watchdog_ms: int = 500,
           stopped: Callable[[], bool] = never) -> tuple[int, Outcome]:  # fmt: skip
    """Plays entries as they come, no faster than the board takes them, to the last one or until `stopped` says so.
    Returns how many were sent. A source that has nothing yet gives an empty batch, at least every keep_alive_pause()."""
    depth = board.identity.live_depth
    most = min(depth, board.identity.channels)  # a frame holds at most as many indices as a record has words
    before = now = board.status()
    sent = level = 0
    with board.outputs(watchdog_ms):
        for batch in batches:
            if not batch:
                level = _watch(board).live_level
            at = 0
            while at < len(batch) and not stopped():
                room = min(most, depth - level)
                if room < min(most, depth // 2):
                    time.sleep(FULL_PAUSE_S)
                    level = _watch(board).live_level
                    continue
                dwell, group = next(groupby(batch[at : at + room], key=itemgetter(1)))
                run = [index for index, _ in group]
                level = board.push(run, dwell)
                at += len(run)
                sent += len(run)
            if stopped():
                break
        # Silence for good comes last: running out of indices would count as an underrun.
        silent = False
        now = _watch(board)
        while not stopped() and not (silent and _is_over(now)):
            if not silent and now.live_level < depth:
                board.push([0], 0)
                silent = True
            time.sleep(keep_alive_pause(watchdog_ms))
            now = _watch(board)
    return sent, _outcome(before, now, stopped())
