# SPDX-License-Identifier: Apache-2.0
"""Frames against the CRC catalogue's check value, and frames put together by the definitions of CRC and COBS."""
import random

import pytest
from haptogram import frame
from haptogram.interface import Command, Status


def crc(data):
    """CRC-16/IBM-3740 bit by bit."""
    register = 0xFFFF
    for bit in "".join(f"{byte:08b}" for byte in data):
        register = (register << 1 & 0xFFFF) ^ (0x1021 if (register >> 15) ^ int(bit) else 0)
    return register


def reply(sequence=7, command=Command.STATUS, status=Status.OK, expected=8, level=0, data=b""):
    """A reply as a board sends it, by rtl/INTERFACE.md."""
    body = bytes([sequence, command | 0x80, status, expected, level & 0xFF, level >> 8]) + data
    return stuff(body + crc(body).to_bytes(2, "big")) + b"\0"


def stuff(data):
    """COBS as its paper says it, byte by byte."""
    out, block = bytearray(), bytearray()
    for byte in data + b"\0":
        if byte:
            block.append(byte)
        if not byte or len(block) == 254:
            out += bytes([len(block) + 1]) + block
            block.clear()
    return bytes(out)


def unstuff(code):
    """The bytes of a COBS code that is one."""
    data = bytearray()
    while code:
        run, code = code[: code[0]], code[code[0] :]
        data += run[1:] + (b"\0" if code and run[0] < 255 else b"")
    return bytes(data)


def test_the_check_value_of_the_crc_catalogue():
    assert frame.crc16(b"123456789") == crc(b"123456789") == 0x29B1
    assert frame.crc16(b"123456789\x29\xb1") == 0


def test_a_request_by_hand():
    """STATUS numbered 0, whose zero is stuffed away."""
    assert frame.encode_request(0, frame.Request(Command.STATUS)) == b"\x01\x04\x0b" + crc(b"\0\x0b").to_bytes(2, "big") + b"\0"


def test_a_long_request_has_one_zero_at_its_end():
    for length in (200, 248, 249, 250, 251, 252, 253, 254, 255, 600):
        encoded = frame.encode_request(1, frame.Request(Command.WRITE, bytes([1]) * length))
        assert encoded.index(0) == len(encoded) - 1


def test_replies_in_any_pieces():
    expected = [(n, n * 3 % 256, bytes(range(n))) for n in range(1, 250, 31)]
    line = b"\0\0" + b"".join(reply(sequence=n, level=level, data=data) for n, level, data in expected)
    for size in (1, 2, 7, 1000):
        decoder = frame.ReplyDecoder()
        got = [r for at in range(0, len(line), size) for r in decoder.feed(line[at : at + size])]
        assert [(r.sequence, r.live_level, r.data) for r in got] == expected
        assert decoder.damaged == 0


def test_any_byte_wrong_is_noticed():
    good = reply(data=b"\0\1\2\0\xff")
    generator = random.Random(1)
    for at in range(len(good) - 1):
        bad = bytearray(good)
        bad[at] ^= generator.randrange(1, 256)
        assert frame.ReplyDecoder().feed(bytes(bad)) == []


@pytest.mark.parametrize("damaged", [b"\x05\x01\0", reply()[:-2] + b"\0", stuff(bytes(7)) + b"\0", b"\x01\0"])
def test_what_is_no_reply_is_counted(damaged):
    decoder = frame.ReplyDecoder()
    assert [r.sequence for r in decoder.feed(damaged + reply(sequence=9))] == [9]
    assert decoder.damaged == 1


def test_a_request_is_no_reply():
    assert frame.ReplyDecoder().feed(frame.encode_request(1, frame.Request(Command.WRITE, bytes(20)))) == []
