# SPDX-License-Identifier: Apache-2.0
"""The build under test, and CMake as a process."""
import os
import subprocess
from pathlib import Path

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
