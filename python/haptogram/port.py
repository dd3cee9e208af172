# SPDX-License-Identifier: Apache-2.0
"""A serial port, or the pseudo-terminal of a virtual board."""
import contextlib
import errno
import os
import select
import termios
import time
from collections.abc import Callable

import serial

from .errors import HaptogramError, Interrupted, RateRefused, device_error

MOST_WAIT_S = 10.0  # for the other end to take bytes
URGENT_WAIT_S = 0.1  # for what is urgent: it is sent again soon
SLICE_S = 0.05  # within which a wait notices that it shall end
BLOCK = 4096  # bytes
FAILURES = (OSError, termios.error, ValueError)  # what pyserial lets out


def never() -> bool:
    return False


class Port:
    """8N1 at any rate that the port's driver can make. flock keeps other programs of ours out, as it does in the C++
    program. TIOCEXCL would not do: on a pseudo-terminal it stays until the virtual board ends. Once `stopped` says true,
    write() raises Interrupted; urge() and send_break() do not ask it."""

    def __init__(self, path: str, baud: int, stopped: Callable[[], bool] = never) -> None:
        self.path = path
        self._baud = baud
        self._stopped = stopped
        try:
            self._serial = serial.Serial(path, baud, timeout=0, exclusive=True)
        except FAILURES as error:
            number = getattr(error, "errno", None)
            if number in (errno.EAGAIN, errno.EWOULDBLOCK):
                raise device_error(path, "another program is using it; end that one first") from error
            if isinstance(error, ValueError):
                raise RateRefused(path, f"it refuses {baud} baud: {error}") from error
            reason = os.strerror(number) if number else str(error)
            raise device_error(path, f"cannot be opened: {reason}; 'haptogram-py device list' shows the ports") from error
        with contextlib.suppress(*FAILURES, NotImplementedError):  # an FTDI chip keeps what it received for 16 ms otherwise; others have no such mode
            self._serial.set_low_latency_mode(True)

    def write(self, data: bytes) -> None:
        end = time.monotonic() + MOST_WAIT_S
        while data := self._put(data):
            if self._stopped():
                raise Interrupted(self.path)
            if time.monotonic() > end:
                raise device_error(self.path, f"it took no bytes for {MOST_WAIT_S:g} s; is a board behind it?")

    def urge(self, data: bytes) -> None:
        """Sends `data` ahead of what was written and has not left the port yet, which is dropped. Gives up when it is not taken soon."""
        try:
            self._serial.reset_output_buffer()
        except FAILURES as error:
            raise self._gone() from error
        end = time.monotonic() + URGENT_WAIT_S
        while (data := self._put(data)) and time.monotonic() < end:
            pass

    def send_break(self, bits: int) -> None:
        """Holds the line low for at least so many bits. Ports that have no break leave it out."""
        with contextlib.suppress(*FAILURES):
            self._serial.reset_output_buffer()
            self._serial.break_condition = True
            time.sleep(0.001 + 2 * bits / self._baud)
            self._serial.break_condition = False

    def read(self, patience: float) -> bytes:
        """What has arrived; waits at most `patience` seconds for the first byte."""
        try:
            if not select.select([self._serial], [], [], max(0.0, patience))[0]:
                return b""
            data = os.read(self._serial.fileno(), BLOCK)
        except BlockingIOError:
            return b""
        except FAILURES as error:
            raise self._gone() from error
        if not data:
            raise self._gone()
        return data

    def drain(self) -> None:
        """Drops what has arrived."""
        try:
            self._serial.reset_input_buffer()
        except FAILURES as error:
            raise self._gone() from error

    def close(self) -> None:
        self._serial.close()

    def _put(self, data: bytes) -> bytes:
        """Writes what fits; what is left of it."""
        try:
            if not select.select([], [self._serial], [], SLICE_S)[1]:
                return data
            return data[os.write(self._serial.fileno(), data) :]
        except BlockingIOError:
            return data
        except FAILURES as error:
            raise self._gone() from error

    def _gone(self) -> HaptogramError:
        return device_error(self.path, "the port is gone; was it unplugged, or its virtual board ended?")
