#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes COBS test vectors made by the `cobs` package: a line a case, data and code in hexadecimal."""

import random
import sys

from cobs import cobs


def cases():
    yield b""
    for length in (1, 2, 253, 254, 255, 256, 507, 508, 509, 762):
        yield b"\x00" * length
        yield b"\x01" * length
        yield b"\xff" * (length - 1) + b"\x00"
        yield b"\x00" + b"\x11" * (length - 1)
    generator = random.Random(20260101)
    for _ in range(300):
        yield bytes(generator.choice((0, 0, 1, 255, generator.randrange(256))) for _ in range(generator.randrange(700)))


with open(sys.argv[1], "w", encoding="ascii") as file:
    for data in cases():
        file.write(f"{data.hex()}:{cobs.encode(data).hex()}\n")
