# SPDX-License-Identifier: Apache-2.0
"""haptogram-sweep as a process, and where its packages are."""
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# For the program, and for workers that a test starts itself.
PYTHONPATH = os.pathsep.join([str(ROOT / "python"), str(ROOT / "extras/sweep")])
sys.path[:0] = PYTHONPATH.split(os.pathsep)


def command(*arguments):
    return [sys.executable, "-m", "haptogram_sweep", *map(str, arguments)]
