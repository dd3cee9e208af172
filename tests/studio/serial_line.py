# SPDX-License-Identifier: Apache-2.0
"""Serial lines for tests in JavaScript, which has no terminals.

serial_line.py port PATH BAUD   stdin goes to the port, and what the port sends to stdout
serial_line.py tap PATH BAUD    prints the name of another port that leads to PATH; what is written there goes to stdout, too
"""
import os
import pty
import select
import sys
import termios
import tty


def write_all(file, data):
    while data:
        data = data[os.write(file, data):]


def carry(ways):
    """Carries bytes until an end is closed. Of each way: from where, and where to."""
    while True:
        for ready in select.select(list(ways), [], [])[0]:
            try:
                data = os.read(ready, 65536)
            except OSError:
                return
            if not data:
                return
            for target in ways[ready]:
                write_all(target, data)


def main():
    kind, path, baud = sys.argv[1:]
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(port)
    settings = termios.tcgetattr(port)
    settings[4:6] = [getattr(termios, f"B{baud}")] * 2  # a virtual board hears its own rate alone
    termios.tcsetattr(port, termios.TCSANOW, settings)
    if kind == "port":
        return carry({0: [port], port: [1]})
    host, other = pty.openpty()  # the other end stays open, so that its name is there between two users
    tty.setraw(other)
    print(os.ttyname(other), flush=True)
    return carry({host: [port, 1], port: [host]})


main()
