#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Uploads an image and plays it."""
import argparse
import sys
import time

from haptogram import Client, HaptogramError, Image, end_like_ctrl_c, play

WATCHDOG_MS = 500  # if this program dies, the outputs go off after so long


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("image", help="Intel HEX file, from 'haptogram compile'")
    parser.add_argument("--port", required=True)
    parser.add_argument("--baud", type=int, help="default: the one at which the board answers")
    parser.add_argument("--seconds", type=float, default=10.0, help="to play, at most")
    parser.add_argument("--loops", type=int, help="passes over the sequence (default: as the image says)")
    options = parser.parse_args()

    image = Image.load(options.image)
    with Client.open(options.port, options.baud) as board:
        begun = time.monotonic()
        written = board.upload(image, options.image)
        print(f"uploaded {written} of {len(image.pieces())} frames in {time.monotonic() - begun:.2f} s", flush=True)
        outcome = play(board, loops=options.loops, seconds=options.seconds, watchdog_ms=WATCHDOG_MS)
        print(f"played {len(image.entries)} entries: {outcome.underruns} underruns, {outcome.refused_records} refused records")


if __name__ == "__main__":
    end_like_ctrl_c()
    try:
        main()
    except HaptogramError as error:
        sys.exit(f"upload_image.py: {error}")
    except KeyboardInterrupt:
        sys.exit("upload_image.py: interrupted; outputs are off")
