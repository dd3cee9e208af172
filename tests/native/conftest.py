# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the C++ program as a process, and random numbers."""
import os
import subprocess

import numpy as np
import pytest
from pistons import PROGRAM


@pytest.fixture
def program(tmp_path):
    """Runs the program in an empty folder and returns what it printed."""

    def run(*arguments):
        command = [str(PROGRAM), *map(str, arguments)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout

    return run


@pytest.fixture
def rng():
    """Other random numbers in each run; a failure shows the seed, and HAPTOGRAM_SEED repeats it."""
    seed = int(os.environ.get("HAPTOGRAM_SEED") or np.random.SeedSequence().entropy % 2**32)
    print(f"HAPTOGRAM_SEED={seed}")
    return np.random.default_rng(seed)
