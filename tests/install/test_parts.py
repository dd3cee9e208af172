# SPDX-License-Identifier: Apache-2.0
"""Builds that leave parts out, and what a build says that misses something. One folder, so that only what differs is built again."""
import re
import shutil
from pathlib import Path

import pytest
from building import ROOT, like_the_build, run

pytestmark = pytest.mark.xdist_group("install")  # one folder, where one worker builds

USAGE = 2
# As if it were not installed.
NO_VERILATOR = "-DCMAKE_DISABLE_FIND_PACKAGE_verilator=ON"


def configure(folder, *options, expect=0, environment=None):
    return run("cmake", "-S", ROOT, "-B", folder, *like_the_build(), *options, expect=expect, environment=environment)


def build(folder, *targets):
    run("cmake", "--build", folder, "-j", "2", *(word for target in targets for word in ("--target", target)))
    return folder / "host/cli/haptogram"


def says(program, folder, *arguments, expect):
    """Nothing on standard output, and one line of complaint, which is returned."""
    done = run(program, *arguments, cwd=folder, expect=expect)
    assert done.stdout == "" and done.stderr.count("\n") == 1, (done.stdout, done.stderr)
    return done.stderr


@pytest.fixture(scope="module")
def folder(beside):
    return beside("parts")


@pytest.fixture(scope="module")
def without_both(folder, work):
    """The core alone, without simulated board and FTDI, on a machine that has the packages of none of these."""
    known = work / "pkgconfig"
    known.mkdir()
    for place in run("pkg-config", "--variable", "pc_path", "pkg-config").stdout.strip().split(":"):
        for package in Path(place).glob("*.pc"):
            if not package.stem.startswith(("libftdi", "libusb", "bullet")) and not (known / package.name).exists():
                (known / package.name).symlink_to(package)
    configure(folder, "-DHAPTOGRAM_SIMULATION=OFF", "-DHAPTOGRAM_FTDI=OFF", "-DHAPTOGRAM_TESTS=OFF", "-DHAPTOGRAM_EXTRAS=",
              NO_VERILATOR, *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("LAPACK", "PNG")), environment={"PKG_CONFIG_LIBDIR": str(known)})
    program = work / "haptogram-without-both"
    shutil.copy(build(folder), program)
    return program


@pytest.mark.deep
def test_without_simulation_and_ftdi_the_rest_works(without_both, work):
    run(without_both, "compile", "--shape", "point", "--center", "0,0,100", "-o", "point.hex", cwd=work)
    run(without_both, "inspect", "point.hex", cwd=work)
    run(without_both, "analyze", "point.hex", cwd=work)
    run(without_both, "field", "point.hex", "--line", "z@x=0,y=0", "-o", "line.csv", cwd=work)
    assert "colorlight" in run(without_both, "board", "list").stdout
    for command in ("upload", "play", "stream", "bitstream", "device", "download"):
        assert "Usage" in run(without_both, command, "--help").stdout


@pytest.mark.deep
def test_simulation_that_is_left_out_says_so(without_both, work):
    assert "this build leaves out simulation" in says(without_both, work, "simulate", "point.hex", "--pulses", "p.csv", expect=USAGE)


@pytest.mark.deep
def test_ftdi_that_is_left_out_says_so(without_both, work):
    assert "HAPTOGRAM_FTDI=ON" in says(without_both, work, "device", "info", "--port", "ftdi:", expect=USAGE)


@pytest.mark.deep
@pytest.mark.parametrize("command, extra", [("calibrate", "calibration"), ("render", "hands"), ("align", "hands"), ("scatter", "scattering"), ("feel", "feel"), ("live", "live"), ("task", "live"),
                                            ("robot", "robot"), ("studio", "studio"), ("serve", "serve")])  # fmt: skip
def test_an_extra_that_is_left_out_says_so(without_both, work, command, extra):
    said = says(without_both, work, command, expect=USAGE)
    assert extra in said.split("this build leaves out ")[1]


@pytest.mark.deep
def test_a_hand_where_hands_are_left_out_says_so(without_both, work):
    (work / "hand.toml").write_text('format = "haptogram-project-1"\n[hand]\nrecording = "synthetic:press"\n')
    assert "the extra hands" in says(without_both, work, "compile", "hand.toml", "-o", "hand.hex", expect=USAGE)
    assert not (work / "hand.hex").exists()


@pytest.mark.deep
def test_a_format_where_formats_are_left_out_says_so(without_both, work):
    (work / "cloud.pcd").write_text("# .PCD v0.7\n")
    assert "the extra formats" in says(without_both, work, "compile", "cloud.pcd", "-o", "cloud.hex", expect=USAGE)


def test_extras_that_are_not_there_or_needed_by_tests(work):
    assert "there is no extra 'unity'" in " ".join(configure(work / "wrong", "-DHAPTOGRAM_EXTRAS=unity", expect=1).stderr.split())
    assert "the tests need all" in " ".join(configure(work / "wrong", "-DHAPTOGRAM_EXTRAS=live", expect=1).stderr.split())


@pytest.mark.deep
def test_tests_without_simulation(without_both, folder):
    """The unit tests do not need it."""
    configure(folder, "-DHAPTOGRAM_SIMULATION=OFF", "-DHAPTOGRAM_FTDI=ON", "-DHAPTOGRAM_TESTS=ON", "-DHAPTOGRAM_EXTRAS=all", NO_VERILATOR,
              *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=OFF" for name in ("LAPACK", "PNG")))
    build(folder, "test_unit", "haptogram")
    listed = re.findall(r"Test +#\d+: (.*)", run("ctest", "--test-dir", folder, "-N").stdout)
    assert any(name.startswith("unit/") for name in listed)
    assert not any(name == "cli" or name.startswith("cosim/") for name in listed)


@pytest.mark.parametrize("options", [*(pytest.param(options, marks=pytest.mark.deep) for options in (["-DHAPTOGRAM_FTDI=OFF"], ["-DHAPTOGRAM_EXTRAS=robot", "-DHAPTOGRAM_TESTS=OFF"], ["-DHAPTOGRAM_TESTS=OFF"], ["-DHAPTOGRAM_PROGRAM=OFF"])),
                                     ["--preset=quick"], ["-DHAPTOGRAM_PROGRAM=OFF", "-DHAPTOGRAM_SIMULATION=OFF"]], ids=" ".join)  # fmt: skip
def test_other_combinations_configure(work, options):
    configure(work / "configured", "--fresh", *options)


def test_a_missing_package_is_one_line(work):
    done = configure(work / "missing", "-DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_hwy=ON", "-DHAPTOGRAM_SIMULATION=OFF", expect=1)
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("haptogram: missing")]
    assert "fmt (libfmt-dev), hwy (libhwy-dev)" in line and "tools/setup" in line


def test_make_names_missing_programs_in_one_line(work):
    """A path on which there is make, a shell and nothing else."""
    path = work / "bare_path"
    path.mkdir()
    for program in ("make", "sh"):
        (path / program).symlink_to(shutil.which(program))
    copy = work / "bare_tree"
    copy.mkdir()
    shutil.copy(ROOT / "Makefile", copy)
    done = run(path / "make", "-C", copy, "build", expect=2, environment={"PATH": str(path), "MAKEFLAGS": "", "MAKELEVEL": ""})
    said = [line for line in done.stderr.splitlines() if "***" not in line]
    assert len(said) == 1 and "cmake ninja" in said[0] and "tools/setup" in said[0], done.stderr


def test_make_asks_for_no_package_manager():
    """Whatever make would do for these, it is neither the set-up nor apt."""
    for target in ("build", "demo", "test", "lint", "bench", "install"):
        told = run("make", "-n", target, cwd=ROOT, environment={"MAKEFLAGS": "", "MAKELEVEL": ""}).stdout
        commands = [line for line in told.splitlines() if "missing" not in line]
        assert commands and not any("tools/setup" in line or "apt" in line.split() for line in commands)
