#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints a board's parameters as a row of sim/models.cmake has them."""
import sys
import tomllib
from pathlib import Path

NAMES = "CHANNELS RECORDS SEQUENCE_DEPTH LIVE_DEPTH TIMING_BITS PULSE_BITS CLOCK_HZ BAUD WATCHDOG_MS MAX_HIGH_CLOCKS".split()
board = Path(__file__).resolve().parent.parent.parent / "constraints" / f"{sys.argv[1]}.toml"
parameters = tomllib.loads(board.read_text())["parameters"]
print(":".join(str(parameters[name]) for name in NAMES) + ":")
