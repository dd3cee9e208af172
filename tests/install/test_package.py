# SPDX-License-Identifier: Apache-2.0
"""Other people's projects, out of the tree: with the installed package, by find_package and by pkg-config, and with the sources."""
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from building import ROOT, cached, like_the_build, run

pytestmark = pytest.mark.xdist_group("install")  # one folder, where one worker builds

CONSUMER = Path(__file__).parent / "consumer"
EXAMPLES = ROOT / "host"


def check_link_example(folder):
    """It says what it misses."""
    assert subprocess.run([folder / "play_image"], capture_output=True, text=True).stderr == "haptogram_example: expected a port and an image\n"


def check_examples(folder):
    """Both programs run: one computes a field, the other speaks to a board."""
    said = run(folder / "field_at_a_point", cwd=folder).stdout
    assert re.match(r"40 records of 100 channels\n", said), said
    at, beside = (float(number) for number in re.findall(r"(\d+) Pa", said))
    assert at > 1000 and beside < 0.7 * at, said
    check_link_example(folder)


def consume(folder, *options):
    run("cmake", "-S", CONSUMER, "-B", folder, f"-DEXAMPLES={EXAMPLES}", *like_the_build(), *options)
    run("cmake", "--build", folder, "-j", "2")
    check_examples(folder)


def public_headers(package):
    return sorted((package / "include/haptogram").rglob("*.hpp"))


def test_headers_need_only_public_dependencies(package):
    """A user has the standard library and what haptogramConfig.cmake calls public, and every header of ours that one includes."""
    headers = public_headers(package)
    assert len(headers) > 20
    for header in headers:
        for kind, name in re.findall(r'^#include ([<"])([^>"]+)', header.read_text(), re.MULTILINE):
            if kind == '"':
                assert (package / "include" / name).exists(), f"{header} includes {name}, which is not installed"
            else:
                assert "/" not in name and "." not in name or name.startswith(("nlohmann/", "Eigen/")), f"{header} includes <{name}>"


def stand_first():
    """The headers that a source of the libraries includes before anything else: the build has compiled these for themselves."""
    first = (re.search(r'^#include (.*)$', source.read_text(), re.MULTILINE) for folder in (ROOT / "host/haptogram", *(ROOT / "extras").glob("*/haptogram"))
             for source in folder.rglob("*.cpp"))
    return {found[1].strip('"') for found in first if found}


def test_find_package(package, work):
    """Every header stands for itself, and all of them can be included together."""
    all_headers = [str(header.relative_to(package / "include")) for header in public_headers(package)]
    alone = sorted(set(all_headers) - stand_first())
    assert len(alone) < len(all_headers) / 3
    consume(work / "find_package", f"-DCMAKE_PREFIX_PATH={package}", f"-DHEADERS={';'.join(alone)}", f"-DALL_HEADERS={';'.join(all_headers)}")


def test_one_component(package, work):
    """The link needs nothing of what computes fields, hands or robots."""
    folder = work / "component"
    absent = ("Eigen3", "TBB", "LAPACK", "hwy", "PNG", "Boost")
    run("cmake", "-S", CONSUMER, "-B", folder, f"-DEXAMPLES={EXAMPLES}", *like_the_build(), f"-DCMAKE_PREFIX_PATH={package}",
        "-DCOMPONENTS=link", *(f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in absent))  # fmt: skip
    run("cmake", "--build", folder, "-j", "2")
    check_link_example(folder)
    found = run("ldd", folder / "play_image").stdout
    assert not re.search("tbb|openblas|hwy|png|Bullet", found), found


def test_a_component_that_is_not_there(package, work):
    done = subprocess.run([str(word) for word in ("cmake", "-S", CONSUMER, "-B", work / "absent", f"-DEXAMPLES={EXAMPLES}", *like_the_build(),
                           f"-DCMAKE_PREFIX_PATH={package}", "-DCOMPONENTS=unity")], capture_output=True, text=True)  # fmt: skip
    assert done.returncode != 0
    assert "no component unity" in " ".join(done.stderr.split())


def test_pkg_config(package, work):
    folder = work / "pkg_config"
    folder.mkdir()
    environment = {"PKG_CONFIG_PATH": str(next(package.rglob("haptogram.pc")).parent)}
    flags = run("pkg-config", "--cflags", "--libs", "haptogram", environment=environment).stdout.split()
    compiler = cached("CMAKE_CXX_COMPILER")
    run(compiler, "-std=c++20", EXAMPLES / "example/field_at_a_point.cpp", "-o", folder / "field_at_a_point", *flags)
    run(compiler, "-std=c++20", EXAMPLES / "haptogram/link/example.cpp", "-o", folder / "play_image", *flags)
    check_examples(folder)
    assert run("pkg-config", "--modversion", "haptogram", environment=environment).stdout.strip() == cached("CMAKE_PROJECT_VERSION")


@pytest.mark.deep
def test_add_subdirectory(beside):
    folder = beside("add_subdirectory")
    consume(folder, f"-DHAPTOGRAM_SOURCE={ROOT}", "-DHAPTOGRAM_WERROR=ON")
    names = run("cmake", "--build", folder, "--target", "help").stdout
    assert "haptogram_link:" in names
    for absent in ("test_unit", "haptogram_models", "interface:", "haptogram_figures"):
        assert absent not in names, f"{absent} is built in a project that only wants the libraries"


def test_fetch_content(work):
    """Configured alone: what it builds is what add_subdirectory does."""
    run("cmake", "-S", CONSUMER, "-B", work / "fetch_content", f"-DEXAMPLES={EXAMPLES}", f"-DHAPTOGRAM_SOURCE={ROOT}", "-DFETCH=ON", *like_the_build())


def test_the_installed_program_works(package, work):
    run(package / "bin/haptogram", "compile", "--shape", "circle", "--points", "8", "-o", "image.hex", cwd=work)
    run(package / "bin/haptogram", "inspect", "image.hex", cwd=work)


def studio_address(program):
    """What the studio says first; it is ended then."""
    studio = subprocess.Popen([program, "studio", "--no-browser", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        return studio.stdout.readline() or studio.stderr.read()
    finally:
        studio.terminate()
        studio.communicate(timeout=60)


def test_the_runner_of_studies_drives_boards(package):
    """By the library of its prefix, which also computes."""
    say = "from haptogram import Array, Board, library; print(library.find_library(), Board.open('reference:tile-100').identity.channels, len(Array('tile-7x8')))"
    environment = {name: value for name, value in os.environ.items() if name != "HAPTOGRAM_LIBRARY"} | {"PYTHONPATH": str(package / "share/haptogram/python"), "PYTHONDONTWRITEBYTECODE": "1"}
    said = subprocess.run([sys.executable, "-c", say], env=environment, capture_output=True, text=True)
    assert said.stdout.startswith(str(package)) and said.stdout.endswith("libhaptogram.so.1 100 56\n"), said


def test_the_installed_studio_has_its_page(package, work):
    """It takes the installed page, not the one in the build: it notices when one of the installed files is another."""
    page = Path("share/haptogram/studio")
    if not (ROOT / "extras/studio/web/node_modules/esbuild").exists():
        assert json.loads(studio_address(package / "bin/haptogram"))["page"] is False
        return
    assert json.loads(studio_address(package / "bin/haptogram"))["page"] is True
    assert (package / "share/haptogram/python/haptogram_study/protocols/haptogram_shapes.toml").is_file(), "the runner of studies"
    assert (package / "share/haptogram/schemas/project.schema.json").is_file(), "the schemas of file formats"
    moved = work / "moved"
    shutil.copytree(package / "bin", moved / "bin")
    shutil.copytree(package / page, moved / page)
    (moved / page / "index.html.gz").write_bytes(gzip.compress(b"another"))
    assert "is not the file that page.json lists" in studio_address(moved / "bin/haptogram")
