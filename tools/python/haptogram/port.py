# SPDX-License-Identifier: Apache-2.0
"""A serial port, or the pseudo-terminal of a virtual board."""
import errno
import os
import termios

import serial

from .errors import HaptogramError, device_error

MOST_WAIT_S = 10.0  # for the other end to take bytes
FAILURES = (OSError, termios.error, ValueError)  # what pyserial lets out


class Port:
    """8N1 at any rate that the port's driver can make. flock keeps other programs of ours out, as it does in the C++
    program. TIOCEXCL would not do: on a pseudo-terminal it stays until the virtual board ends."""

    def __init__(self, path: str, baud: int = 1_000_000) -> None:
        self.path = path
        try:
            self._serial = serial.Serial(path, baud, timeout=0, write_timeout=MOST_WAIT_S, exclusive=True)
        except FAILURES as error:
            number = getattr(error, "errno", None)
            if number in (errno.EAGAIN, errno.EWOULDBLOCK):
                raise device_error(path, "another program is using it; end that one first") from error
            reason = os.strerror(number) if number else str(error)
            raise device_error(path, f"cannot be opened: {reason}; 'haptogram-py device list' shows the ports") from error

    def write(self, data: bytes) -> None:
        try:
            self._serial.write(data)
        except serial.SerialTimeoutException as error:
            raise device_error(self.path, f"it took no bytes for {MOST_WAIT_S:g} s; is a board behind it?") from error
        except FAILURES as error:
            raise self._gone(error) from error

    def read(self, patience: float) -> bytes:
        """What has arrived; waits at most `patience` seconds for the first byte."""
        try:
            if self._serial.timeout != patience:
                self._serial.timeout = patience
            return self._serial.read(1) + self._serial.read(self._serial.in_waiting)
        except FAILURES as error:
            raise self._gone(error) from error

    def drain(self) -> None:
        """Drops what has arrived."""
        try:
            self._serial.reset_input_buffer()
        except FAILURES as error:
            raise self._gone(error) from error

    def close(self) -> None:
        self._serial.close()

    def _gone(self, error: Exception) -> HaptogramError:
        return device_error(self.path, f"the port is gone ({error}); was it unplugged, or its virtual board ended?")
