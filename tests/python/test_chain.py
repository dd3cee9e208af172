# SPDX-License-Identifier: Apache-2.0
"""Tiles of a chain behind one port: as bytes, and with two Verilated processes."""
import random
import time

import pytest
from messages import refusal
from processes import virtual_board
from haptogram import Client, HaptogramError
from haptogram.chain import ChainedLine, header, split


class Wire:
    """Remembers what is written; what is read comes in pieces of any size."""

    path = "port"

    def __init__(self, answers=b"", piece=1):
        self.written, self.answers, self.piece = b"", answers, piece

    def write(self, data):
        self.written += data

    def read(self, _):
        data, self.answers = self.answers[: self.piece], self.answers[self.piece :]
        return data


def test_frames_carry_the_number_of_their_tile():
    wire = Wire()
    line = ChainedLine(wire, 3)
    assert wire.written == b"\0" + 3 * b"\x02\xfd\0"
    wire.written = b""
    line.write(b"\0abc\0")
    line.write(b"d")
    line.write(b"ef\0")
    assert wire.written == b"\0" + b"\x07\xf9abc\0" + b"\x07\xf9def\0"


def test_only_answers_of_the_tile_are_read(seed=1):
    g = random.Random(seed)
    for _ in range(50):
        answers = [(g.randint(1, 4), bytes(g.randint(1, 255) for _ in range(g.randint(1, 20)))) for _ in range(20)]
        damaged = b"\x05\xf3lost\0"  # its two bytes do not fit each other
        wire = Wire(b"".join(header(2 * tile + 1) + data + b"\0" for tile, data in answers) + damaged, g.randint(1, 30))
        line = ChainedLine(wire, 2)
        heard = b""
        while wire.answers:
            heard += line.read(0.1)
        assert heard == b"".join(data + b"\0" for tile, data in answers if tile == 2)


def test_a_break_ends_the_chain_which_is_made_anew():
    wire = Wire()
    line = ChainedLine(wire, 3)
    wire.written, wire.send_break = b"", lambda bits: setattr(wire, "bits", bits)
    line.send_break(25)
    assert wire.bits >= 25 + 3 / 2 and wire.written == b"\0" + 3 * b"\x02\xfd\0"


def test_what_is_urgent_begins_a_frame_whatever_was_cut_short():
    wire = Wire()
    line = ChainedLine(wire, 3)
    line.write(b"half a fra")
    wire.written, wire.urge = b"", wire.write
    line.urge(b"\0abc\0")
    assert wire.written == b"\0\x07\xf9abc\0"


def test_frames_without_end_and_frames_of_others_cost_no_more_than_their_bytes():
    wire = Wire(b"\x01" * (1 << 22) + b"\0" + header(5) + b"mine\0" + (header(3) + b"not mine\0") * (1 << 15), 1 << 12)
    line = ChainedLine(wire, 2)
    begun, heard = time.process_time(), b""
    while wire.answers:
        heard += line.read(0.1)
        assert len(line._splitter._rest) <= 4096
    assert heard == b"mine\0"
    assert time.process_time() - begun < 10  # of it, the wire's own copying is the most


@pytest.mark.parametrize("port, expected", [("/dev/ttyUSB0", ("/dev/ttyUSB0", 0)), ("/dev/ttyUSB0#12", ("/dev/ttyUSB0", 12)), ("a#b", ("a#b", 0)), ("#1", ("#1", 0)), ("a#", ("a#", 0))])
def test_names(port, expected):
    assert split(port) == expected


@pytest.mark.parametrize("port", ["a#0", "a#127", "a#1#2"])
def test_numbers_that_no_tile_has(port):
    with refusal(HaptogramError):
        split(port)


def test_two_tiles_behind_one_port(folder):
    with virtual_board(folder, "--tiles", 2, "--chain", "--model", "rtl", "--speed", "max"):
        for tile in (1, 2):
            with Client.open(str(folder / f"port#{tile}"), 1_000_000) as client:
                assert client.identity.channels == 100
                client.write(0, bytes([tile, 0, 7, tile]))
        for tile in (2, 1):
            with Client.open(str(folder / f"port#{tile}"), 1_000_000) as client:
                assert client.read(0, 4) == bytes([tile, 0, 7, tile])
        with refusal(HaptogramError):
            Client.open(str(folder / "port#3"))
