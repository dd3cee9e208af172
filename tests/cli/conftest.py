# SPDX-License-Identifier: Apache-2.0
import stat
import types
from pathlib import Path

import pytest
import support


@pytest.fixture(scope="session", autouse=True)
def program():
    assert support.PROGRAM.is_file(), f"{support.PROGRAM} is missing: build it, or name it in HAPTOGRAM_PROGRAM"
    return support.PROGRAM


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Eight points of a circle, at a rate that plays in 2 ms; made once, to be copied, not changed."""
    folder = tmp_path_factory.mktemp("compiled")
    support.succeed(["compile", "--shape", "circle", "--points", 8, "--rate", 500, "-o", "image.hex"], cwd=folder)
    return folder


@pytest.fixture
def small(compiled, tmp_path):
    """The small image in a folder of the test's own."""
    for name in ("image.hex", "image.json"):
        (tmp_path / name).write_bytes((compiled / name).read_bytes())
    return types.SimpleNamespace(folder=tmp_path, hex=tmp_path / "image.hex", manifest=tmp_path / "image.json")


@pytest.fixture
def full_device():
    """The device that is always full; a test that found a file there would prove nothing."""
    device = Path("/dev/full")
    if not device.exists() or not stat.S_ISCHR(device.stat().st_mode):
        pytest.skip("/dev/full is no device here")
    return device


@pytest.fixture
def image(tmp_path):
    """Four points that play in 1 ms, in the test's own folder."""
    support.succeed(["compile", "--shape", "circle", "--diameter", 60, "--points", 4, "--rate", 1000, "-o", "circle.hex"], cwd=tmp_path)
    return "circle.hex"
