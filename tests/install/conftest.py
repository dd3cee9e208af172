# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the build under test, and CMake as a process."""
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("HAPTOGRAM_BUILD", ROOT / "build/release")).resolve()


def run(*command, cwd=None, expect=0, environment=None):
    """The process that ran; its exit code must be the expected one."""
    done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True, env={**os.environ, **(environment or {})}, timeout=1000)
    assert done.returncode == expect, f"{command} ended with {done.returncode}, expected {expect}\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done


def cached(name):
    """A variable of the build under test, as it was configured."""
    lines = (BUILD / "CMakeCache.txt").read_text().splitlines()
    return next((line.split("=", 1)[1] for line in lines if line.startswith(f"{name}:")), None)


def like_the_build():
    """Options with which sources compile as in the build under test, so that ccache has them."""
    options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O3"]
    launcher = cached("HAPTOGRAM_LAUNCHER")
    return options + ([f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"] if launcher else [])


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
