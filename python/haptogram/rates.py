# SPDX-License-Identifier: Apache-2.0
"""At which rate the board behind a port listens. What answered is noted in $XDG_STATE_HOME/haptogram/ports, a line "RATE PORT"
each, as the C++ program does."""
import contextlib
import os
import random
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from .chain import split
from .errors import ErrorCode, HaptogramError, Interrupted, RateRefused
from .frame import ReplyDecoder, Request, encode_request
from .interface import KNOWN_RATES, PROBE_PATIENCE_MS, PROBE_ROUNDS, Command
from .port import SLICE_S, never
from .session import Line

MOST_PORTS = 100


class NoAnswer(HaptogramError):
    """At no rate."""


def _file() -> Path | None:
    for variable, rest in (("XDG_STATE_HOME", "haptogram/ports"), ("HOME", ".local/state/haptogram/ports")):
        if os.path.isabs(folder := os.environ.get(variable, "")):
            return Path(folder, rest)
    return None


def _key(port: str) -> str:
    """The tiles of a chain have one port."""
    return os.path.abspath(split(port)[0])


def _lines() -> list[str]:
    path = _file()
    try:
        return path.read_text(encoding="utf-8", errors="surrogateescape").splitlines() if path and path.is_file() else []
    except OSError:
        return []


def remembered(port: str) -> int | None:
    for line in _lines():
        rate, _, name = line.partition(" ")
        if name == _key(port) and rate.isascii() and rate.isdigit() and 0 < int(rate) < 1 << 32:
            return int(rate)
    return None


def remember(port: str, baud: int) -> None:
    """A file that cannot be written is left as it is."""
    path, key = _file(), _key(port)
    if path is None or "\n" in key:
        return
    lines, mine = _lines(), f"{baud} {key}"
    if mine in lines:
        return
    kept = [*(line for line in lines if line.partition(" ")[2] != key), mine][-MOST_PORTS:]
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8", errors="surrogateescape") as file:
            file.write("".join(f"{line}\n" for line in kept))
        os.replace(file.name, path)


def _answers(line: Line, question: Command, patience: float, stopped: Callable[[], bool]) -> bool:
    number, decoder, end = random.randrange(256), ReplyDecoder(), time.monotonic() + patience
    line.drain()
    line.write(b"\0" + encode_request(number, Request(question)))  # the zero ends whatever half frame the line left
    while (left := end - time.monotonic()) > 0:
        if stopped():
            raise Interrupted(line.path)
        if any(reply.sequence == number and reply.command == question for reply in decoder.feed(line.read(min(left, SLICE_S)))):
            return True
    return False


def find(port: str, open_at: Callable[[int], Line], stopped: Callable[[], bool] = never, question: Command = Command.IDENTIFY,
         found: Callable[[int], None] = lambda baud: None) -> Line:  # fmt: skip
    """The line to the board, opened at the rate at which it answers: the one that is remembered for the port is tried first, then
    those of all boards, from the fastest on. A board turns its outputs off when it hears bytes that are slower than its own.
    `found` is told a rate that had to be looked for."""
    before = remembered(port)
    rates = list(dict.fromkeys([*([before] if before else []), *KNOWN_RATES]))
    refused: HaptogramError | None = None
    for turn in range(PROBE_ROUNDS):
        for baud in tuple(rates):
            try:
                line = open_at(baud)
            except RateRefused as error:
                refused = error
                rates.remove(baud)
                continue
            try:
                if _answers(line, question, PROBE_PATIENCE_MS / 1000 * (1 << turn), stopped):
                    remember(port, baud)
                    if baud != before:
                        found(baud)
                    return line
            except BaseException:
                line.close()
                raise
            line.close()
    if refused and not rates:
        raise refused
    raise NoAnswer(ErrorCode.DEVICE, port, f"no answer to {question.name.lower()} at {', '.join(map(str, rates))} baud; check the cable and that the "
                   "board runs Haptogram, and give the baud rate if it is another")  # fmt: skip
