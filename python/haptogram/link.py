# SPDX-License-Identifier: Apache-2.0
"""The line to a board and its session, which the C++ library has: requests in a window, each carried out once and in order."""
import ctypes
import os
import struct
import time
import weakref
from collections.abc import Callable, Sequence
from typing import NamedTuple

from .errors import ErrorCode, HaptogramError, Interrupted
from .interface import LINK_KEEP_ALIVE_MS, LINK_KEEP_ALIVE_SHARE, Command
from .library import call, library, sized
from .native import LinkState, Port

SLICE_MS = 20  # within which a wait notices a signal
HEAD = struct.Struct("<HH")  # of a reply: live level, bytes of data


def never() -> bool:
    return False


class Request(NamedTuple):
    """A command, its payload (arguments, then data)."""

    command: Command
    payload: bytes = b""


class Reply(NamedTuple):
    live_level: int  # entries in the live FIFO
    data: bytes


class Link:
    """Once `stopped` says true, everything but shut_off() raises Interrupted. Signals are heard while an answer is waited for."""

    def __init__(self, port: str, baud: int | None, stopped: Callable[[], bool]) -> None:
        if "\0" in port:
            raise HaptogramError(ErrorCode.USAGE, repr(port), "no port has a zero in its name")
        if baud is not None and not 0 < baud < 1 << 32:
            raise HaptogramError(ErrorCode.USAGE, "baud", f"{baud}, expected a rate, or None: then it is found")
        self.path = port  # what messages call it
        self._stopped = stopped
        self._said = time.monotonic()
        self._pause_s = 0.0
        handle = ctypes.c_void_p()
        self._call("open_link", sized(Port, port=os.fsencode(port), baud=baud or 0), ctypes.byref(handle))
        self._handle = handle
        self.close = weakref.finalize(self, library().haptogram_close_link, handle)

    def begin(self) -> bytes:
        """Opens the port, if it is not open, and begins a session. Returns the identity block."""
        self._require_wanted()
        self._call("link_identify", self._open())
        return self._replies(self._stopped)[0].data

    def exchange(self, requests: Sequence[Request], gate: int = 0) -> list[Reply]:
        """Replies in order. Raises HaptogramError when the board refuses a request; those after it are not applied. One that is alone can
        wait, as `gate` says."""
        self._require_wanted()
        if not requests:
            return []
        asked = b"".join(struct.pack("<BH", command, len(payload)) + payload for command, payload in requests)
        self._said = time.monotonic()
        self._call("link_ask", self._open(), asked, len(asked), gate)
        return self._replies(self._stopped)

    def stream(self, period: int, words: memoryview, patterns: int) -> None:
        """Patterns, without an answer."""
        self._require_wanted()
        self._said = time.monotonic()
        self._call("link_stream", self._open(), period, ctypes.cast(bytes(words), ctypes.POINTER(ctypes.c_uint16)), patterns)

    def shut_off(self) -> None:
        """Outputs off and silence, whatever came before. Raises HaptogramError when the board does not confirm it."""
        self._pause_s = 0.0
        self._call("link_shut_off", self._open())
        self._replies(never)

    def interrupt(self) -> None:
        """Whatever goes on ends soon, and shut_off() waits no longer than it must."""
        self._call("link_interrupt", self._open())

    def keep_alive(self, watchdog_ms: int) -> None:
        """For outputs that go on with this watchdog: until shut_off(), something new is said often enough during an exchange."""
        pause_ms = min(LINK_KEEP_ALIVE_MS, watchdog_ms // LINK_KEEP_ALIVE_SHARE + 1) if watchdog_ms else LINK_KEEP_ALIVE_MS
        self._pause_s = pause_ms / 1000
        self._call("link_keep_alive", self._open(), pause_ms)

    def rest(self) -> float:
        """Seconds until something new must be said, while outputs are on."""
        return max(0.0, self._said + self._pause_s - time.monotonic())

    def state(self) -> LinkState:
        state: LinkState = sized(LinkState)
        self._call("get_link_state", self._open(), ctypes.byref(state))
        return state

    def _open(self) -> ctypes.c_void_p:
        if not self.close.alive:
            raise HaptogramError(ErrorCode.USAGE, self.path, "is closed; open it again")
        return self._handle

    def _call(self, name: str, *given: object) -> None:
        call(name, *given, place=self._place)

    def _place(self, where: str) -> str:
        """The library knows one board; here it is named by its port."""
        return self.path if where == "board" else f"{self.path}, {where}" if where.startswith("command ") else where

    def _require_wanted(self) -> None:
        if self._stopped():
            raise Interrupted(self.path)

    def _replies(self, stopped: Callable[[], bool]) -> list[Reply]:
        busy = ctypes.c_int32(1)
        try:
            while busy.value:
                self._call("link_wait", self._open(), SLICE_MS, ctypes.byref(busy))
                if busy.value and stopped():
                    raise Interrupted(self.path)
        except BaseException:
            if busy.value:
                self.interrupt()
            raise
        size = library().haptogram_link_replies(self._handle, None, 0)
        data = ctypes.create_string_buffer(size)
        library().haptogram_link_replies(self._handle, data, size)
        replies, at = [], 0
        while at < size:
            level, length = HEAD.unpack_from(data, at)
            at += HEAD.size + length
            replies.append(Reply(level, data[at - length : at]))
        return replies
