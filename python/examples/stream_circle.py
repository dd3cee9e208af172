#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plays an image's records round and round through the live FIFO, no faster than the board takes them."""
import argparse
import itertools
import sys
import time

from haptogram import Client, HaptogramError, Image, end_like_ctrl_c, stream

WATCHDOG_MS = 500  # if this program dies, the outputs go off after so long


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("image", help="Intel HEX file, as from 'haptogram compile --shape circle'")
    parser.add_argument("--port", required=True)
    parser.add_argument("--baud", type=int, help="default: the one at which the board answers")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=7.0, help="turns per second")
    options = parser.parse_args()

    image = Image.load(options.image)
    count = len(image.records)
    cycle_s = image.records[0].cycle_length * image.records[0].prescaler / image.clock_hz
    dwell = round(1 / (options.rate * count * cycle_s))
    if not 0 < dwell <= 0xFFFF:
        sys.exit(f"stream_circle.py: at {options.rate} turns per second a point would last {dwell} cycles, expected 1 to 65535")
    turn = [(index, dwell) for index in range(1, count + 1)]

    with Client.open(options.port, options.baud) as board:
        board.upload(image, options.image)
        begun = time.monotonic()
        sent, outcome = stream(board, itertools.repeat(turn), watchdog_ms=WATCHDOG_MS,
                               stopped=lambda: time.monotonic() - begun >= options.seconds)  # fmt: skip
        print(f"{sent} indices, {sent / (time.monotonic() - begun):.1f} per second, {outcome.underruns} underruns")


if __name__ == "__main__":
    end_like_ctrl_c()
    try:
        main()
    except HaptogramError as error:
        sys.exit(f"stream_circle.py: {error}")
    except KeyboardInterrupt:
        sys.exit("stream_circle.py: interrupted; outputs are off")
