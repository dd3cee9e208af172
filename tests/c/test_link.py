# SPDX-License-Identifier: Apache-2.0
"""The commands of a board one by one, on a simulated board whose time passes only while it is waited for. tests/python has what Python makes of them."""
import ctypes
import os
import random
import struct

import bindings  # noqa: F401 (which finds the package)
import pytest
from haptogram.interface import Command


@pytest.fixture
def link(c):
    handle = c.made(c.open_link, c.struct("port", port=b"reference:tile-100-wide"))
    yield handle
    c.close_link(handle)


def ended(c, link):
    """How what was begun has ended."""
    busy = ctypes.c_int32(1)
    while busy.value:
        code = c.link_wait(link, 1000, ctypes.byref(busy))
    return code


def asked(*requests):
    return b"".join(struct.pack("<BH", command, len(payload)) + payload for command, payload in requests)


def ask(c, link, *requests, gate=0):
    data = asked(*requests)
    return c.link_ask(link, data, len(data), gate) or ended(c, link)


def replies(c, link):
    data, found = c.text(c.link_replies, link), []
    while data:
        level, size = struct.unpack_from("<HH", data)
        found.append((level, data[4 : 4 + size]))
        data = data[4 + size :]
    return found


@pytest.fixture
def begun(c, link):
    c.ok(c.link_identify(link))
    c.ok(ended(c, link))
    assert replies(c, link)[0][1].startswith(b"Haptogram\0")
    return link


def test_requests_have_their_replies_in_order(c, begun):
    data = [bytes([n, 0, n, 1]) for n in range(100)]
    c.ok(ask(c, begun, *[(Command.WRITE, struct.pack("<I", 4 * n) + data[n]) for n in range(100)]))
    assert replies(c, begun) == [(0, b"")] * 100
    c.ok(ask(c, begun, *[(Command.READ, struct.pack("<IH", 4 * n, 4)) for n in range(100)]))
    assert [reply for _, reply in replies(c, begun)] == data
    state = c.struct("link_state")
    c.ok(c.get_link_state(begun, ctypes.byref(state)))
    assert (state.found_baud, state.retransmissions) == (0, 0)


def test_after_one_that_is_refused_none_is_carried_out(c, begun):
    c.ok(ask(c, begun, (Command.WRITE, bytes(4) + b"\1\0")))
    c.fails(ask(c, begun, (Command.SELECT, struct.pack("<HH", 60000, 0)), (Command.WRITE, bytes(4) + b"\2\0")), "DEVICE", "bad_index")
    assert c.error_place() == b"command select" and replies(c, begun) == []
    c.ok(ask(c, begun, (Command.READ, struct.pack("<IH", 0, 2))))
    assert replies(c, begun)[0][1] == b"\1\0"
    c.fails(ask(c, begun, (Command.SELECT, struct.pack("<HH", 60000, 0)), gate=1 << 40), "DEVICE", "bad_index")
    c.ok(ask(c, begun, (Command.SELECT, struct.pack("<HH", 0, 0))))  # nothing waits


def test_nothing_is_said_beside_it_so_the_watchdog_watches_the_caller(c, begun):
    def status():
        c.ok(ask(c, begun, (Command.STATUS, b"")))
        return struct.unpack_from("<17H", replies(c, begun)[0][1])

    before = status()[4]
    c.ok(ask(c, begun, (Command.WATCHDOG, b"\1\0"), (Command.ENABLE, b"")))
    good = status()[4] - before
    assert good == 3  # frames
    c.ok(c.link_keep_alive(begun, 100))
    c.ok(c.link_shut_off(begun))
    c.ok(ended(c, begun))
    assert not status()[0] & 1 and replies(c, begun) != []


def test_outputs_go_off_without_a_session(c, link):
    c.ok(c.link_shut_off(link))
    c.ok(ended(c, link))
    assert replies(c, link) == []
    words = (ctypes.c_uint16 * 1)()
    c.fails(c.link_stream(link, 0, words, 1), "BAD_ARGUMENT", "identified")
    c.ok(ask(c, link, (Command.KEEP_ALIVE, b"")))  # for which one is begun


def test_a_line_without_a_board_can_be_left(c):
    ours, theirs = os.openpty()
    link = c.made(c.open_link, c.struct("port", port=os.ttyname(theirs).encode(), baud=115200))
    for begin in (c.link_identify, c.link_shut_off):
        c.ok(begin(link))
        busy = ctypes.c_int32()
        c.ok(c.link_wait(link, 1, ctypes.byref(busy)))
        assert busy.value == 1
        assert c.text(c.link_replies, link) == b""
        c.fails(c.link_keep_alive(link, 1), "BAD_ARGUMENT", "goes on")
        c.ok(c.link_interrupt(link))
        assert ended(c, link) in (c.header.codes["HAPTOGRAM_CANCELLED"], c.header.codes["HAPTOGRAM_DEVICE"])
    c.ok(c.link_identify(link))
    c.close_link(link)  # while it goes on
    os.close(ours)
    os.close(theirs)


def test_what_makes_no_sense_is_named(c, link):
    handle = ctypes.c_void_p()
    for wrong, word in (({}, "port"), ({"port": b"a", "rig": b"b"}, "rig"), ({"port": b"a", "patience_ms": 1}, "patience_ms")):
        c.fails(c.open_link(ctypes.byref(c.struct("port", **wrong)), ctypes.byref(handle)), "BAD_ARGUMENT", word)
        assert not handle
    c.fails(c.open_link(ctypes.byref(c.struct("port", port=b"a")), None), "BAD_ARGUMENT", "link")
    for call in (c.link_identify, c.link_shut_off, c.link_interrupt):
        c.fails(call(None), "BAD_ARGUMENT", "link")
    for call, more in ((c.link_ask, (b"", 0, 0)), (c.link_wait, (1, None)), (c.link_keep_alive, (1,)), (c.link_stream, (1, None, 0)), (c.get_link_state, (None,))):
        c.fails(call(None, *more), "BAD_ARGUMENT", "link")
    assert c.link_replies(None, None, 0) == 0
    c.close_link(None)
    c.fails(ask(c, link, (Command.STATUS, b"")), "BAD_ARGUMENT", "identified")
    c.fails(c.link_keep_alive(link, 1), "BAD_ARGUMENT", "identified")
    c.ok(c.link_identify(link))
    c.ok(ended(c, link))
    c.fails(c.link_ask(link, None, 0, 0), "BAD_ARGUMENT", "requests")
    for cut in range(1, 7):
        c.fails(c.link_ask(link, asked((Command.READ, b"1234")), cut, 0), "BAD_ARGUMENT", f"number 1 ends after {cut} bytes")
    for command in (Command.IDENTIFY, Command.STREAM):
        c.fails(ask(c, link, (command, b"")), "BAD_ARGUMENT", "there is a function for it")
    c.fails(ask(c, link, (Command.STATUS, b""), (Command.STATUS, b""), gate=5), "BAD_ARGUMENT", "gate: found 2 requests")
    c.fails(ask(c, link, (Command.STATUS, b""), gate=1 << 48), "BAD_ARGUMENT", "48 bits")


def test_whatever_is_asked_the_board_answers_again(c, begun):
    generator = random.Random(int(os.environ.get("HAPTOGRAM_SEED", "1")))
    for _ in range(60):
        requests = [(generator.randrange(256), generator.randbytes(generator.choice([0, 2, 4, 6, 20, 300]))) for _ in range(generator.randrange(1, 4))]
        data = asked(*requests)[: -generator.randrange(1, 3) if generator.random() < 0.2 else None]
        if c.link_ask(begun, data, len(data), generator.choice([0, 0, generator.randrange(1 << 49)])) == 0:
            assert ended(c, begun) in (0, c.header.codes["HAPTOGRAM_DEVICE"])
        if ask(c, begun, (Command.STATUS, b"")):  # SYNC and DISABLE end the session, and the next request begins one
            c.ok(ask(c, begun, (Command.STATUS, b"")))
        assert len(replies(c, begun)[0][1]) >= 34


def test_the_ports_are_lines(c):
    size = c.ports(None, 0)
    to = ctypes.create_string_buffer(size + 1)
    assert c.ports(to, size) == size and all(line.count(b"\t") == 1 for line in to.value.splitlines())
