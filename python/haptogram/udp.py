# SPDX-License-Identifier: Apache-2.0
"""A board behind Ethernet: see "Over Ethernet" in rtl/INTERFACE.md."""
import select
import socket

from .errors import ErrorCode, HaptogramError, device_error
from .interface import NETWORK_DATAGRAM_BYTES, NETWORK_PATIENCE_MS, NETWORK_PORT, NETWORK_WINDOW, Command

SCHEME = "udp:"


def names_udp(port: str) -> bool:
    return port.startswith(SCHEME)


def _target(port: str) -> tuple[str, int]:
    host, colon, number = port.removeprefix(SCHEME).partition(":")
    value = number if colon else str(NETWORK_PORT)
    if not host or "#" in port or not (value.isascii() and value.isdigit() and 0 < int(value) < 65535):
        message = "expected udp:ADDRESS or udp:ADDRESS:PORT, such as udp:169.254.71.1, with a port from 1 to 65534"
        raise HaptogramError(ErrorCode.USAGE, port, message)
    return host, int(value)


class UdpLine:
    """A Line. What is written gathers to whole frames in a datagram until something is read."""

    patience, window = NETWORK_PATIENCE_MS / 1000, NETWORK_WINDOW  # of a Session on it
    window_bytes = 4096  # of datagrams that a board's port has room for

    def __init__(self, port: str) -> None:
        self.path = port
        host, number = _target(port)
        self._waiting = b""
        self._socket, self._open_socket = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        try:
            for one, at in ((self._socket, number), (self._open_socket, number + 1)):
                one.connect((host, at))
                one.setblocking(False)
        except OSError as error:
            self.close()
            raise device_error(port, f"there is no way to it: {error.strerror or error}") from error

    def _send(self, line: socket.socket, data: bytes) -> None:
        """What cannot go out is lost like any other datagram: the session finds out."""
        try:
            line.send(data)
        except (ConnectionRefusedError, BlockingIOError):
            pass
        except OSError as error:
            raise device_error(self.path, f"nothing can be sent: {error.strerror or error}; is the network's cable in?") from error

    def _flush(self) -> None:
        data, self._waiting = self._waiting, b""
        if data:
            self._send(self._socket, data)

    def write(self, data: bytes) -> None:
        if len(self._waiting) + len(data) > NETWORK_DATAGRAM_BYTES:
            self._flush()
        self._waiting += data

    def urge(self, data: bytes) -> None:
        self._waiting = data
        self._flush()

    def send_break(self, bits: int) -> None:
        """The open port turns the outputs off, for anybody."""
        self._flush()
        for command in (Command.DISABLE, Command.STOP):
            self._send(self._open_socket, b"HG" + bytes([command, 0]))

    def read(self, patience: float) -> bytes:
        self._flush()
        if not select.select([self._socket], [], [], max(0.0, patience))[0]:
            return b""
        data = b""
        try:
            while True:
                data += self._socket.recv(65536)
        except (BlockingIOError, ConnectionRefusedError):
            return data
        except OSError as error:
            raise device_error(self.path, f"nothing can be received: {error.strerror or error}") from error

    def drain(self) -> None:
        while self.read(0.0):
            pass

    def close(self) -> None:
        self._socket.close()
        self._open_socket.close()
