#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Moves one focal point on a circle, each position computed here and sent while the one before it is felt."""
import argparse
import sys
import time

import numpy as np
import numpy.typing as npt
from haptogram import Client, HaptogramError, Record, end_like_ctrl_c

SPEED_M_S = 343.2
CLOCK_HZ, PRESCALER, CYCLE, PULSE = 50_000_000, 5, 250, 125  # a 40 kHz carrier in ticks of 100 ns
PRIMARY = 0x00000000  # address of record 1
WATCHDOG_MS = 500  # if this program dies, the outputs go off after so long


def timings(focus: npt.NDArray[np.float64], elements: npt.NDArray[np.float64]) -> list[int]:
    """Ticks at which the elements fire, for all waves to be in phase at the focus; metres."""
    flight = np.linalg.norm(focus - elements, axis=1) / SPEED_M_S
    return [int(tick) % CYCLE for tick in np.rint((flight.max() - flight) * CLOCK_HZ / PRESCALER)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", required=True)
    parser.add_argument("--baud", type=int, help="default: the one at which the board answers")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=100.0, help="positions per second")
    parser.add_argument("--rows", type=int, default=10)
    parser.add_argument("--columns", type=int, default=10)
    parser.add_argument("--pitch", type=float, default=10.0, help="mm")
    options = parser.parse_args()
    row, column = (axis.ravel() for axis in np.indices((options.rows, options.columns)))
    x, y = column - (options.columns - 1) / 2, row - (options.rows - 1) / 2
    elements = np.stack([x, y, np.zeros_like(x)], axis=1) * options.pitch * 1e-3

    with Client.open(options.port, options.baud) as board:
        if (board.identity.channels, board.identity.clock_hz) != (len(elements), CLOCK_HZ):
            sys.exit(f"follow_point.py: the board has {board.identity.channels} channels and {board.identity.clock_hz} Hz")
        updates, begun = 0, time.monotonic()
        with board.outputs(watchdog_ms=WATCHDOG_MS):
            while (now := time.monotonic() - begun) < options.seconds:
                angle = 2 * np.pi * now  # once a second
                focus = np.array([0.02 * np.cos(angle), 0.02 * np.sin(angle), 0.15])
                record = Record(CYCLE, PRESCALER, PULSE, timings(focus, elements)).pack()
                index = 1 + updates % 2  # the record that is not being played
                board.write(PRIMARY + (index - 1) * len(record), record)
                board.select(index)
                updates += 1
                time.sleep(max(0.0, begun + updates / options.rate - time.monotonic()))
        print(f"{updates} updates, {updates / (time.monotonic() - begun):.1f} per second")


if __name__ == "__main__":
    end_like_ctrl_c()
    try:
        main()
    except HaptogramError as error:
        sys.exit(f"follow_point.py: {error}")
    except KeyboardInterrupt:
        sys.exit("follow_point.py: interrupted; outputs are off")
