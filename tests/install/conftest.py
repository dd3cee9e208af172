# SPDX-License-Identifier: Apache-2.0
"""What the tests share: folders to build in, and the installed package."""
import shutil

import pytest
from building import BUILD, run


@pytest.fixture(scope="session")
def work():
    """An empty folder in the build, large enough for what is built in it."""
    folder = BUILD / "install_test"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


@pytest.fixture(scope="session")
def beside():
    """Folders beside the build, where all libraries are built again: as deep as it, so that a ccache with relative paths has them, too."""
    made = []

    def make(name):
        made.append(BUILD.with_name(f"{BUILD.name}-{name}"))
        shutil.rmtree(made[-1], ignore_errors=True)
        return made[-1]

    yield make
    for folder in made:
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def package(work):
    """The installed package, in a place other than the one that it was configured for."""
    run("cmake", "--install", BUILD, "--prefix", work / "configured")
    (work / "configured").rename(work / "prefix")
    return work / "prefix"
