# SPDX-License-Identifier: Apache-2.0
"""Tiles of a chain behind one port, with two Verilated processes. How their frames look is tested with the C++ library."""
import pytest
from messages import refusal
from processes import virtual_board
from haptogram import Board, HaptogramError


@pytest.mark.parametrize("port", ["a#0", "a#127", "a#1#2"])
def test_numbers_that_no_tile_has(port):
    with refusal(HaptogramError):
        Board.open(port)


def test_two_tiles_behind_one_port(folder):
    with virtual_board(folder, "--tiles", 2, "--chain", "--model", "rtl", "--speed", "max"):
        for tile in (1, 2):
            with Board.open(str(folder / f"port#{tile}"), 1_000_000) as board:
                assert board.identity.channels == 100
                board.write(0, bytes([tile, 0, 7, tile]))
        for tile in (2, 1):
            with Board.open(str(folder / f"port#{tile}"), 1_000_000) as board:
                assert board.read(0, 4) == bytes([tile, 0, 7, tile])
        with refusal(HaptogramError):
            Board.open(str(folder / "port#3"))
