# SPDX-License-Identifier: Apache-2.0
"""Every command, on a virtual board behind its pseudo-terminal."""
import time
import zlib

import processes
import pytest
from messages import program_said, refusal
from patience import until
from haptogram import Client, ErrorCode, HaptogramError, Image
from haptogram.interface import PRIMARY_BASE, SEQUENCE_BASE

RECORD_BYTES = 208


def test_what_the_board_says_of_itself(board):
    identity = board.identity
    assert (identity.name, identity.channels, identity.records, identity.clock_hz) == ("Haptogram", 100, 400, 50_000_000)
    status = board.status()
    assert (status.enabled, status.mode, status.watchdog_ms, status.frames_damaged) == (False, "idle", 500, 0)
    before = board.status().frames_good
    board.identify()
    assert board.status().frames_good == before + 2


def test_memory_is_written_read_and_digested(board):
    data = bytes(range(RECORD_BYTES))
    for address in (PRIMARY_BASE, PRIMARY_BASE + 399 * RECORD_BYTES, SEQUENCE_BASE + 4):
        board.write(address, data)
        assert board.read(address, RECORD_BYTES) == data
        assert board.digest(address, RECORD_BYTES) == zlib.crc32(data)
    assert board.digest(PRIMARY_BASE + 2, 4) == zlib.crc32(data[2:6])
    assert board.digest(PRIMARY_BASE, 2) == zlib.crc32(data[:2])


def test_what_is_refused(board):
    for refused in (
        lambda: board.select(401),
        lambda: board.push([1, 401], 1),
        lambda: board.start(1000, 100, 1),
        lambda: board.read(0x20000000 - 2, 2),
        lambda: board.digest(PRIMARY_BASE + 400 * RECORD_BYTES, 2),
        lambda: board.write(1, b"ab"),
    ):
        with refusal(HaptogramError) as error:
            refused()
        assert error.value.code == ErrorCode.DEVICE
    with refusal(HaptogramError):
        board.write(PRIMARY_BASE, bytes(RECORD_BYTES + 2))
    for impossible in (lambda: board.select(-1), lambda: board.set_watchdog(65536), lambda: board.push([70000], 1)):
        with refusal(HaptogramError):
            impossible()
    assert board.status().mode == "idle"


def test_select_push_start_stop(board, image):
    board.upload(image)
    with board.outputs():
        assert board.status().enabled
        board.select(3)
        assert (board.status().mode, board.status().present_index) == ("single", 3)
        board.start(5, 4, 0)
        assert board.status().mode == "sequence" and board.status().present_index in (5, 6, 7, 8)
        board.stop()
        assert board.status().present_index == 0
        assert 48 <= board.push([1] * 50, 60000) <= 50  # one is played, one is ready
        assert (board.status().mode, board.status().present_index) == ("live", 1)
        for _ in range(4):
            board.push([2] * 50, 60000)
        with refusal(HaptogramError):
            board.push([3] * 100, 1)
        assert board.status().live_level == 248
    status = board.status()
    assert (status.enabled, status.live_level, status.present_index) == (False, 0, 0)


def test_outputs_go_off_whatever_ends_it(board):
    for end in (ZeroDivisionError, KeyboardInterrupt, HaptogramError):
        with pytest.raises(end), board.outputs(100):
            assert board.status().enabled and board.status().watchdog_ms == 100
            raise end(4, "here", "why") if end is HaptogramError else end()
        assert not board.status().enabled


def test_the_watchdog_and_that_there_can_be_none(board):
    board.set_watchdog(1)
    board.enable()
    until(lambda: time.sleep(0.05) or not board.status().enabled, "the watchdog's turn")  # who asks keeps it away
    assert board.status().watchdog_trips == 1
    board.set_watchdog(0)
    board.enable()
    time.sleep(0.6)  # it would have been 500 ms
    assert board.status().enabled
    board.disable()
    assert not board.status().enabled


def test_keep_alive_and_reset(board, image):
    board.upload(image)
    with board.outputs(watchdog_ms=60000):
        board.start(1, 4, 0)
        board.keep_alive()
        assert board.status().enabled and board.status().mode == "sequence"
        board.reset()
        status = board.status()
        assert (status.enabled, status.stopped, status.mode, status.watchdog_ms) == (False, False, "idle", 500)
    assert board.identity.max_duty_256 == 128 and board.identity.max_cycle_clocks == board.identity.clock_hz


def test_upload_writes_what_differs_and_download_brings_it_back(board, folder, image):
    assert board.upload(image) == 9
    assert board.upload(image) == 0
    board.write(PRIMARY_BASE + 3 * RECORD_BYTES + 8, b"xy")
    with refusal(HaptogramError):
        board.compare(image)
    assert board.upload(image) == 1
    board.compare(image)
    assert board.download() == image
    assert board.retransmissions == 0


def test_upload_notices_a_memory_that_forgets(board, image):
    board.upload(image)
    board.write(PRIMARY_BASE, b"xy")
    write = board._link.exchange
    board._link.exchange = lambda requests, gate=0: [] if requests and requests[0].command == 2 else write(requests, gate)
    with refusal(HaptogramError):
        board.upload(image)


def test_an_image_for_another_board(board, folder):
    processes.haptogram(folder, "compile", "--shape", "point", "--board", "ice40-hx8k-breakout", "-o", "other.hex")
    before = board.status().frames_good
    with refusal(HaptogramError) as error:
        board.upload(Image.load(str(folder / "other.hex")))
    assert error.value.code == ErrorCode.BAD_INPUT
    assert board.status().frames_good == before + 1


def test_nothing_to_download(board):
    with refusal(HaptogramError):
        board.download()


def test_one_program_at_a_time(board, folder):
    path = str(folder / "port")
    with refusal(HaptogramError):
        Client.open(path)
    theirs = processes.run([processes.PROGRAM, "device", "info", "--port", "port"], folder)
    assert theirs.returncode == processes.DEVICE
    program_said(theirs.returncode, theirs.stderr)
