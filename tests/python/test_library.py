# SPDX-License-Identifier: Apache-2.0
"""The C++ library behind the package: where it is looked for, what is no such library, and a link that is closed."""
import subprocess
import sys

import processes
import pytest
from messages import refusal
from haptogram import Board, ErrorCode, HaptogramError, library


@pytest.mark.parametrize("named", ["/nowhere/libhaptogram.so", "libc.so.6", "image.hex", "/"])
def test_what_is_no_library_is_named(named, folder):
    done = subprocess.run(processes.python_command("device", "info", "--port", "port"), cwd=folder, env={**processes.ENVIRONMENT, "HAPTOGRAM_LIBRARY": named},
                          capture_output=True, text=True)  # fmt: skip
    processes.assert_refused(done, processes.BAD_INPUT)
    assert f"haptogram-py: {named}: " in done.stderr and "HAPTOGRAM_LIBRARY" in done.stderr


def test_a_library_of_another_interface_is_refused(tmp_path):
    """One that says 2, and one that lacks what the package calls."""
    for number in (library.ABI, 2):
        (tmp_path / "other.c").write_text(f"int haptogram_abi(void) {{ return {number}; }}")
        subprocess.run(["cc", "-shared", "-fPIC", "-o", f"other{number}.so", "other.c"], cwd=tmp_path, check=True)
        say = "from haptogram import Board; Board.open('port')"
        done = subprocess.run([sys.executable, "-c", say], env={**processes.ENVIRONMENT, "HAPTOGRAM_LIBRARY": str(tmp_path / f"other{number}.so")}, capture_output=True, text=True)
        assert f"interface {number}, expected 1" in done.stderr and "install one release of both" in done.stderr


@pytest.mark.parametrize("port, baud", [("a\0b", None), ("port", 0), ("port", -1), ("port", 1 << 32)])
def test_what_is_no_port_and_no_rate(port, baud):
    with refusal(HaptogramError) as error:
        Board.open(port, baud)
    assert error.value.code == ErrorCode.USAGE


def test_a_board_that_is_closed_says_so(board):
    board.__exit__(None, None, None)
    board.__exit__(None, None, None)
    for use in (board.status, board.shut_off, board.identify, lambda: board.retransmissions, board.keep_alive):
        with refusal(HaptogramError) as error:
            use()
        assert error.value.code == ErrorCode.USAGE


def test_a_simulated_board_in_the_program_itself(image):
    with Board.open("reference:tile-100") as board:
        assert board.upload(image) == 9 and board.download() == image
        with board.outputs():
            board.start(1, 8, 0)
            assert board.status().mode == "sequence"
        assert not board.status().enabled
    with refusal(HaptogramError):
        Board.open("reference:nothing")
