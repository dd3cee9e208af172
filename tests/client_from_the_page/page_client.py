# SPDX-License-Identifier: Apache-2.0
"""A client written from rtl/INTERFACE.md alone, with nothing of this project's: what the page says must be enough. It waits for the
answer to each frame before it sends the next, and is as short as it can be, so for work the package haptogram in python/ is better."""
import binascii
import random
import struct
import time

import serial

IDENTIFY, WRITE, READ, ENABLE, DISABLE, SELECT, PUSH, START, STOP, WATCHDOG, STATUS = range(1, 12)
DIGEST, KEEP_ALIVE, RESET, MODULATE, GATE, PUSH_FOCI, SYNC = 12, 13, 14, 15, 16, 17, 24
OK, REPEATED = 0, 1
PRIMARY, SEQUENCE, PARAMETERS, GEOMETRY, MODULATION = 0x00000000, 0x10000000, 0x50000000, 0x60000000, 0x70000000
ALONE, MASTER, SLAVE = 0, 1, 2
FULL_GAIN = 39953  # a lone focus of amplitude 255 is full
TRIES, PATIENCE_S = 8, 0.3


def stuff(data):
    code = b""
    for run in (data + b"\0").split(b"\0")[:-1]:
        while len(run) > 253:
            code, run = code + b"\xff" + run[:254], run[254:]
        code += bytes([len(run) + 1]) + run
    return code


def unstuff(code):
    data = b""
    while code:
        data += code[1 : code[0]] + (b"\0" if code[0] < 255 else b"")
        code = code[max(code[0], 1) :]
    return data[:-1]


def crc(data):
    return binascii.crc_hqx(data, 0xFFFF).to_bytes(2, "big")


class Line:
    """A serial port and the frames that come through it."""

    def __init__(self, path, baud=1_000_000):
        self.port = serial.Serial(path, baud, timeout=0.01)
        self.rest = b""

    def frames(self):
        *frames, self.rest = (self.rest + self.port.read(max(1, self.port.in_waiting))).split(b"\0")
        return frames

    def make_chain(self, tiles):
        self.port.write(b"\0" + bytes([2, 253, 0]) * tiles)

    def shut_off(self):
        """For all boards, and blind: a zero ends what was half sent; the numbers do not matter."""
        for before in (b"", bytes([2, 253])):
            for command in (DISABLE, STOP):
                body = bytes([0, command])
                self.port.write(b"\0" + before + stuff(body + crc(body)) + b"\0")


class Board:
    """The board at a line, or the tile with this number of the chain there."""

    def __init__(self, line, tile=0):
        self.line, self.number = line, random.randrange(256)
        self.before = bytes([2 * tile + 1, (~(2 * tile + 1) & 0xFE) | 1]) if tile else b""
        block = self.ask(IDENTIFY)
        assert block[:16].rstrip(b"\0") == b"Haptogram" and block[17] == 2, f"found {block[:18]}, expected Haptogram 2.x"
        words = struct.unpack("<26H", block)
        self.channels, self.records, self.clock_hz, self.features = words[9], words[10], words[14] | words[15] << 16, words[16]

    def ask(self, command, *words, data=b""):
        """Data of the reply."""
        body = bytes([self.number, command]) + struct.pack(f"<{len(words)}H", *words) + data
        for _ in range(TRIES):
            self.line.port.write(b"\0" + self.before + stuff(body + crc(body)) + b"\0")
            end = time.monotonic() + PATIENCE_S
            while time.monotonic() < end:
                for frame in self.line.frames():
                    if frame[: len(self.before)] != self.before:
                        continue
                    reply = unstuff(frame[len(self.before) :])
                    if len(reply) < 8 or crc(reply[:-2]) != reply[-2:] or reply[:2] != bytes([self.number, command | 0x80]):
                        continue
                    assert reply[2] in (OK, REPEATED), f"command {command} was refused with status {reply[2]}"
                    self.number = (self.number + 1) % 256
                    return reply[6:-2]
        raise TimeoutError(f"no answer to command {command}")

    def write(self, address, data):
        most = 2 * (self.channels + 4)  # a frame holds a record
        for at in range(0, len(data), most):
            self.ask(WRITE, (address + at) & 0xFFFF, (address + at) >> 16, data=data[at : at + most])

    def read(self, address, size):
        return self.ask(READ, address & 0xFFFF, address >> 16, size)

    def status(self):
        words = struct.unpack_from("<17H", self.ask(STATUS))
        return {"enabled": words[0] & 1, "mode": words[0] >> 1 & 3, "modulated": words[0] >> 4 & 1, "index": words[1], "underruns": words[2],
                "refused_records": words[3], "far_foci": words[13], "role": words[14] & 3, "in_step": words[14] >> 2 & 1, "numbered": words[14] >> 3 & 1}

    def write_record(self, index, words, cycle, pulse=0, prescaler=1, kind=0):
        """kind 0: ticks at which pulses start; 1: phase | amplitude << 8, and the pulse length does not count."""
        head = [cycle & 0xFFFF, cycle >> 16 | pulse << 8, prescaler & 0xFFFF, prescaler >> 16 | kind << 8]
        self.write(PRIMARY + (index - 1) * 2 * (self.channels + 4), struct.pack(f"<{4 + self.channels}H", *head, *words))

    def write_sequence(self, entries, loops):
        self.write(SEQUENCE, struct.pack("<HH", len(entries), loops) + b"".join(struct.pack("<HH", *entry) for entry in entries))

    def write_foci(self, records, places_mm, wavelength_mm, base=0):
        """Records of foci (x, y, z in mm, amplitude 0 to 1), all with as many; places are the channels', in the array's frame."""
        units = [[round(128 * value) for value in place] for place in places_mm]
        self.write(GEOMETRY, b"".join(struct.pack("<3hH", *place, 0) for place in units))
        wave = round(2**27 / (128 * wavelength_mm))
        self.write(PARAMETERS, struct.pack("<7H", base, len(records), len(records[0]) - 1, self.clock_hz // 40_000, wave & 0xFFFF, wave >> 16, FULL_GAIN))
        data = b""
        for x, y, z, amplitude in (focus for record in records for focus in record):
            x, y, z = (round(128 * value) for value in (x, y, z))
            high = (x >> 16 & 3) | (y >> 16 & 3) << 2 | (z >> 16 & 3) << 4
            data += struct.pack("<4H", x & 0xFFFF, y & 0xFFFF, z & 0xFFFF, round(255 * amplitude) << 8 | high)
        self.write(PRIMARY + 8 * base, data)

    def modulate(self, samples, divider, loop=True):
        self.write(MODULATION, bytes(samples))
        self.ask(MODULATE, divider, len(samples), int(loop))
