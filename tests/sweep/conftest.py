# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the program as a process, and plans in an empty folder."""
import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
NATIVE = os.environ.get("PYTHONPATH") or str(ROOT / "build/release/python/native")
# For the program, and for workers that a test starts itself.
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT / "python"), *(os.path.abspath(part) for part in NATIVE.split(os.pathsep))])
sys.path[:0] = os.environ["PYTHONPATH"].split(os.pathsep)


def command(*arguments):
    return [sys.executable, "-m", "haptogram_sweep", *map(str, arguments)]


@pytest.fixture
def sweep(tmp_path):
    """Runs haptogram-sweep in an empty folder."""

    def run(*arguments, expected=0):
        done = subprocess.run(command(*arguments), cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == expected, done.stdout + done.stderr
        return done

    return run
