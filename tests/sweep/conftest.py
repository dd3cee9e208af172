# SPDX-License-Identifier: Apache-2.0
"""What the tests share: sweeps in an empty folder."""
import subprocess

import pytest
from sweeping import PYTHONPATH, command


@pytest.fixture(autouse=True)
def packages(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", PYTHONPATH)


@pytest.fixture
def sweep(tmp_path):
    """Runs haptogram-sweep in an empty folder."""

    def run(*arguments, expected=0):
        done = subprocess.run(command(*arguments), cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == expected, done.stdout + done.stderr
        return done

    return run
