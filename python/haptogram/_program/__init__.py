# SPDX-License-Identifier: Apache-2.0
"""The program that came with the wheel, and what it looks for beside itself."""

import os
import pathlib
import sys

PROGRAM = pathlib.Path(__file__).parent / "bin/haptogram"
LIBRARY = pathlib.Path(__file__).parent / "lib/libhaptogram.so"


def main() -> None:
    """Becomes the program, which draws pictures and runs studies with this Python."""
    if not PROGRAM.exists():
        sys.exit("haptogram: this package has no program; install the wheel, or build it from the sources with make build")
    os.environ.setdefault("HAPTOGRAM_PYTHON", sys.executable)
    os.execv(PROGRAM, ["haptogram", *sys.argv[1:]])
