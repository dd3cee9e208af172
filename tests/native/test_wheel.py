# SPDX-License-Identifier: Apache-2.0
"""The distribution as pip builds it from the checkout, without network: the program with its page, the packages, the commands.
It is compiled as the build under test, so that ccache has what that compiled."""
import json
import os
import shutil
import subprocess
import sys

import pytest
from pistons import PROGRAM, ROOT

pytestmark = [pytest.mark.deep, pytest.mark.xdist_group("wheel")]

OPTIONS = {"HAPTOGRAM_QUICK": "OFF", "HAPTOGRAM_WERROR": "ON", "Python3_EXECUTABLE": sys.executable}
COMMANDS = ("haptogram", "haptogram-py", "haptogram-realsense", "haptogram-leap", "haptogram-study", "haptogram-sweep")


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip"]
    settings = [f"--config-settings=cmake.define.{name}={value}" for name, value in OPTIONS.items()] + ["--config-settings=build-dir=build/wheel-test"]
    build = [*pip, "wheel", "-q", "--no-index", "--no-deps", "--no-build-isolation", "-w", str(folder), *settings, str(ROOT)]
    compilers = {"CC": shutil.which("cc"), "CXX": shutil.which("c++")}  # as CMake finds them
    subprocess.run(build, check=True, timeout=1500, env={**os.environ, **compilers})
    (wheel,) = folder.glob("haptogram-*-py3-none-*.whl")  # of any Python
    place = folder / "place"
    subprocess.run([*pip, "install", "-q", "--no-index", "--no-deps", "--target", str(place), str(wheel)], check=True, timeout=300)
    return place


def run(place, *command):
    environment = {**os.environ, "PYTHONPATH": str(place)}
    done = subprocess.run([str(word) for word in command], env=environment, cwd=place, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, (command, done.stdout, done.stderr)
    return done.stdout


def test_every_command_starts(place):
    for command in COMMANDS:
        assert "usage" in run(place, place / "bin" / command, "--help").lower()
    assert "haptogram_shapes" in run(place, place / "bin/haptogram-study", "list")


def test_packages_come_from_it(place):
    for name in ("haptogram/py.typed", "haptogram_study/printed.toml", "haptogram_native/py.typed", "haptogram_sweep/py.typed"):
        assert (place / name).exists(), name
    assert "100" in run(place, sys.executable, "-c", "import haptogram; print(haptogram.Board.open('reference:tile-100').identity.channels)")
    say = "import haptogram, haptogram_native as n; print(haptogram.__file__, n.__file__, len(n.Array.find('tile-10x10')))"
    client, native, elements = run(place, sys.executable, "-c", say).split()
    assert client.startswith(str(place)) and native.startswith(str(place)) and elements == "100"


def test_the_program_compiles_simulates_draws_and_has_its_page(place, tmp_path):
    program = place / "bin/haptogram"
    run(place, program, "compile", "--shape", "point", "--center", "0,0,130", "-o", tmp_path / "point.hex")
    assert "contract violations" in run(place, program, "simulate", tmp_path / "point.hex")
    run(place, program, "field", tmp_path / "point.hex", "--plane", "xy@z=130", "--step", "2", "-o", tmp_path / "point.png")
    assert (tmp_path / "point.png").read_bytes().startswith(b"\x89PNG")
    assert (place / "haptogram/_program/share/haptogram/studio/page.json").exists()
    assert (place / "haptogram/_program/share/haptogram/schemas/project.schema.json").exists()


def test_without_openblas_it_solves_the_same(place):
    """The wheel solves by Eigen, the build under test by OpenBLAS."""
    command = ["scatter", "sphere", "--radius", "6", "--center", "0,0,150", "--focus", "0,0,142", "--edge", "1.2", "--json"]
    ours, theirs = (numbers_of(json.loads(run(place, program, *command))) for program in (place / "bin/haptogram", PROGRAM))
    assert len(ours) > 10 and ours == pytest.approx(theirs, rel=1e-3, abs=2e-3)


def numbers_of(report):
    if isinstance(report, dict):
        return [number for key, value in report.items() if key not in ("rounds", "residual") for number in numbers_of(value)]
    if isinstance(report, list):
        return [number for value in report for number in numbers_of(value)]
    return [report] if isinstance(report, (int, float)) else []


def test_no_path_of_the_build_is_in_it(place):
    """But for the one that Verilator writes into each model, for a message; the scripts in bin are written by pip, for its Python."""
    verilated = f"{ROOT}/rtl/haptogram_core.v".encode()
    for file in place.rglob("*"):
        if file.is_file() and file.suffix != ".pyc" and file.parent != place / "bin":
            assert str(ROOT).encode() not in file.read_bytes().replace(verilated, b""), file
