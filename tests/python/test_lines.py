# SPDX-License-Identifier: Apache-2.0
"""Lines of a stream, as they come through a pipe."""
import os
from io import FileIO

import pytest
from haptogram import HaptogramError
from haptogram.lines import batches
from messages import refusal


@pytest.fixture
def pipe():
    out, into = os.pipe()
    with FileIO(out) as source, FileIO(into, "w") as sink:
        yield sink, batches(source, "lines", dwell=7, records=400, pause=lambda: 0.01)


def test_entries_come_as_soon_as_their_line_is_whole(pipe):
    sink, entries = pipe
    assert next(entries) == []
    sink.write(b"1\n2 3\n\t4 ,5,\r\n6")
    assert next(entries) == [(1, 7), (2, 3), (4, 5)]
    assert next(entries) == []
    sink.write(b"5 0\n0\n")
    assert next(entries) == [(65, 0), (0, 7)]
    sink.write(b"400")
    sink.close()
    assert list(entries) == [[], [(400, 7)]]


@pytest.mark.parametrize("line", [b"x", b"1 2 3", b"1x", b"-1", b"401", b"1 65536", b"", b"\xff\x1b", b"1" * 100])
def test_a_bad_line(line, pipe):
    sink, entries = pipe
    sink.write(b"1\n" + line + b"\n2\n")
    with refusal(HaptogramError) as error:
        next(entries)
    assert (error.value.code, error.value.where) == (3, "lines:2")
    assert str(error.value).isprintable() and len(str(error.value)) < 300
