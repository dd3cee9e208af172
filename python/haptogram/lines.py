# SPDX-License-Identifier: Apache-2.0
"""Indices to be streamed, from the lines of a file, a pipe or a terminal. Each line is taken as soon as it is there."""
import re
import select
from collections.abc import Callable, Iterator, Sequence
from io import RawIOBase

from .driving import Entry
from .errors import bad_input

SEPARATOR = rb"[ \t,\r]"
LINE = re.compile(rb"%b*([0-9]+)(?:%b+([0-9]+))?%b*" % (SEPARATOR, SEPARATOR, SEPARATOR))
BLOCK = 4096  # bytes


def batches(source: RawIOBase, where: str, *, dwell: int, records: int, pause: Callable[[], float]) -> Iterator[Sequence[Entry]]:
    """The entries that are there, waiting at most pause() seconds for the first one. `dwell` is that of a line without."""
    rest, number = b"", 0
    while True:
        if not select.select([source], [], [], pause())[0]:
            yield []
            continue
        block = source.read(BLOCK) or b""
        *lines, rest = (rest + block).split(b"\n")
        if not block and rest:
            lines.append(rest)
        entries = []
        for line in lines:
            number += 1
            entries.append(_parse(line, f"{where}:{number}", dwell, records))
        yield entries
        if not block:
            return


def _parse(line: bytes, where: str, dwell: int, records: int) -> Entry:
    match = LINE.fullmatch(line)
    entry = (int(match[1]), int(match[2] or dwell)) if match else None
    if entry is None or entry[0] > records or entry[1] > 0xFFFF:
        found = line[:40].decode("utf-8", "backslashreplace")
        raise bad_input(where, f"found {found!r}, expected 'index' or 'index dwell': an index from 0 to {records}, a dwell from 0 to "
                        "65535 cycles")  # fmt: skip
    return entry
