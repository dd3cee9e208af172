# SPDX-License-Identifier: Apache-2.0
import os
import sys

import boards
import pytest

sys.path.insert(0, str(boards.PACKAGE))


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory):
    """The rates that programs remember."""
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


def pytest_report_header():
    return f"program: {boards.PROGRAM}"


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Eight points of a circle that plays in 2 ms, for ever; made once, not to be changed."""
    folder = tmp_path_factory.mktemp("compiled")
    boards.haptogram(folder, "compile", "--shape", "circle", "--points", 8, "--rate", 500, "-o", "image.hex")
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

    with boards.virtual_board(folder), Client.open(str(folder / "port")) as client:
        yield client


@pytest.fixture
def image(compiled):
    from haptogram import Image

    return Image.load(str(compiled))
