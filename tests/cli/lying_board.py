# SPDX-License-Identifier: Apache-2.0
"""A board of a hundred lines on a pseudo-terminal that keeps the rules of rtl/INTERFACE.md, and lies as a test asks it to."""
import binascii
import os
import select
import struct
import threading
import time
import tty

IDENTIFY, WRITE, READ, ENABLE, DISABLE, SELECT, PUSH, START, STOP, WATCHDOG, STATUS, DIGEST = range(1, 13)
OK, REPEATED, OUT_OF_ORDER = 0, 1, 4
NEW = {"channels": 100, "records": 400, "sequence_depth": 1024, "live_depth": 256}


def identity(**change):
    says = {**NEW, **change}
    words = [says["channels"], says["records"], says["sequence_depth"], says["live_depth"], 8 << 8 | 16,
             50_000_000 & 0xFFFF, 50_000_000 >> 16, 15, 214, 5, 999, 128, 50_000_000 & 0xFFFF, 50_000_000 >> 16, 0, 0, 0]  # fmt: skip
    return says.get("name", b"Haptogram").ljust(16, b"\0") + struct.pack("<H17H", 2 << 8, *words)


def decode(code):
    data = bytearray()
    while code:
        run = code[0]
        if run == 0 or run > len(code):
            return None
        data += code[1:run]
        code = code[run:]
        if run != 255 and code:
            data.append(0)
    return bytes(data)


def encode(data):
    out = bytearray()
    for block in data.split(b"\0"):
        while len(block) >= 254:
            out += b"\xff" + block[:254]
            block = block[254:]
        out += bytes([len(block) + 1]) + block
    return bytes(out) + b"\0"


class LyingBoard:
    """`answers(command, count)` says whether the count-th frame of a command is answered; `babble` is said all the time."""

    def __init__(self, answers=lambda command, count: True, babble=b"", late=0.0, lie=lambda command, data: data, **change):
        self.answers, self.babble, self.late, self.lie = answers, babble, late, lie
        self.identity = identity(**change)
        self.ours, theirs = os.openpty()
        tty.setraw(theirs)
        self.port = os.ttyname(theirs)
        self.theirs = theirs
        self.heard, self.enabled, self.watchdog_ms, self.expected, self.ended = [], False, 500, None, False
        self.thread = threading.Thread(target=self.run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *what):
        self.ended = True
        self.thread.join()
        os.close(self.ours)
        os.close(self.theirs)

    def run(self):
        frame = b""
        os.set_blocking(self.ours, False)
        while not self.ended:
            if select.select([self.ours], [], [], 0.01)[0]:
                frame += os.read(self.ours, 65536)
            *frames, frame = frame.split(b"\0")
            for code in frames:
                self.take(code)
            if self.babble:
                self.say(self.babble)

    def say(self, data):
        try:
            os.write(self.ours, data)
        except BlockingIOError:  # nobody reads
            pass

    def take(self, code):
        data = decode(code)
        if not data or len(data) < 4 or binascii.crc_hqx(data, 0xFFFF) != 0:
            return
        number, command, payload = data[0], data[1], data[2:-2]
        self.heard.append(command)
        if command == IDENTIFY:
            self.expected = number
        if command == DISABLE:
            self.enabled = False
        ahead = None if self.expected is None else (number - self.expected) % 256
        status = OUT_OF_ORDER if ahead is None or 0 < ahead < 128 else REPEATED if ahead else OK
        if status == OK:
            self.expected = (number + 1) % 256
            if command == ENABLE:
                self.enabled = True
            if command == WATCHDOG:
                self.watchdog_ms = struct.unpack("<H", payload)[0]
        if not self.answers(command, self.heard.count(command)):
            return
        time.sleep(self.late)
        reply = {IDENTIFY: self.identity, READ: self.memory(payload) if command == READ else b"", DIGEST: bytes(4), STATUS: self.status()}.get(command, b"")
        reply = self.lie(command, reply if status != OUT_OF_ORDER else b"")
        body = bytes([number, command | 0x80, status, (self.expected or 0), 0, 0]) + reply
        crc = binascii.crc_hqx(body, 0xFFFF)
        self.say(encode(body + struct.pack(">H", crc)))

    @staticmethod
    def memory(payload):
        address, count = struct.unpack("<IH", payload)
        # A sequence of one entry, for ever; records of zeros.
        return (struct.pack("<II", 1, 1 | 1 << 16) + bytes(count))[:count] if address == 0x10000000 else bytes(count)

    def status(self):
        words = [int(self.enabled) | 1 << 1, 1] + [0] * 15
        words[10] = self.watchdog_ms
        return struct.pack("<17H", *words)
