# SPDX-License-Identifier: Apache-2.0
"""The C# classes under mono, and the Unity package as far as a compiler without Unity can read it."""
import os
import re
import subprocess
import sys

from bindings import LIBRARY, ROOT
from patience import also_in_time
from test_c_interface import DOME

UNITY = ROOT / "extras/unity"


def test_the_generated_file_is_fresh():
    subprocess.run([sys.executable, ROOT / "tools/c_header.py", "--check"], check=True)


@also_in_time
def test_images_and_boards_from_csharp(c, tmp_path, figure, in_time):
    sources = [*sorted((UNITY / "Runtime").glob("*.cs")), *sorted((UNITY / "Samples~").rglob("*.cs")), *sorted((ROOT / "tests/c").glob("*.cs"))]
    subprocess.run(["mcs", "-langversion:7.2", "-warnaserror", "-nowarn:0649", "-out:tries.exe", *sources], cwd=tmp_path, check=True)
    environment = {**os.environ, "LD_LIBRARY_PATH": str(LIBRARY.parent)}
    done = subprocess.run(["mono", "tries.exe", DOME], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    said = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert said["version"] == c.version().decode()
    image = c.made(c.compile, c.struct("project", toml=DOME.encode()))
    assert (tmp_path / "csharp.hex").read_bytes() == c.text(c.image_hex, image)
    assert said["hex"] == f"{len(c.text(c.image_hex, image))} manifest {len(c.text(c.image_manifest, image))}"
    assert said["nominal"] == c.text(c.image_level, image).decode().removeprefix("nominal ")
    c.free_image(image)
    assert float(said["pressure"]) > 100 and said["solved"] == "200"
    assert re.match(r"3 project.*points", said["error"])  # the words that any other language hears
    assert said["gone"] == " ".join(["ObjectDisposedException"] * 3)
    moved = re.match(r"([0-9.]+) enabled True channels 100", said["moved"])
    if in_time:
        figure("C#: a thousand live foci take", 1000 / float(moved[1]), 1)
    assert said["patterns"] == "8 enabled True"
    assert said["busy"] == "False" and said["axes"] == "0.01 0.02 0.15"


def test_the_package_has_what_unity_looks_for():
    assert {path.name for path in UNITY.iterdir()} >= {"package.json", "Runtime", "Samples~", "README.md"}
    cmake = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    assert re.search(r'"version": "([0-9.]+)"', (UNITY / "package.json").read_text(encoding="utf-8"))[1] == re.search(r"VERSION ([0-9.]+) D", cmake)[1]
