# SPDX-License-Identifier: Apache-2.0
import sys

import processes
import pytest

sys.path[:0] = processes.PACKAGES


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Eight points of a circle that plays in 2 ms, for ever; made once, not to be changed."""
    folder = tmp_path_factory.mktemp("compiled")
    processes.haptogram(folder, "compile", "--shape", "circle", "--points", 8, "--rate", 500, "-o", "image.hex")
    return folder / "image.hex"


@pytest.fixture
def folder(compiled, tmp_path):
    """The image in a folder of the test's own."""
    (tmp_path / "image.hex").write_bytes(compiled.read_bytes())
    return tmp_path


@pytest.fixture
def board(folder):
    """A client of a virtual board with empty memories."""
    from haptogram import Client

    with processes.virtual_board(folder), Client.open(str(folder / "port")) as client:
        yield client


@pytest.fixture
def image(compiled):
    from haptogram import Image

    return Image.load(str(compiled))
