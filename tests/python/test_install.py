# SPDX-License-Identifier: Apache-2.0
"""The package as pip installs it, from a copy, without network: its program starts and its types are there."""
import os
import shutil
import subprocess
import sys

from boards import PACKAGE


def test_pip_installs_it(tmp_path):
    source = shutil.copytree(PACKAGE, tmp_path / "source", ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    place = tmp_path / "place"
    command = [sys.executable, "-m", "pip", "install", "-q", "--no-index", "--no-deps", "--no-build-isolation", "--target", place, source]
    subprocess.run([str(word) for word in command], check=True, timeout=120)
    environment = {**os.environ, "PYTHONPATH": str(place)}
    said = subprocess.run([place / "bin/haptogram-py", "--help"], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "upload" in said.stdout and "stream" in said.stdout
    assert (place / "haptogram/py.typed").exists()
    for program in ("realsense", "leap"):
        subprocess.run([place / f"bin/haptogram-{program}", "--help"], env=environment, cwd=tmp_path, capture_output=True, check=True)
    listed = subprocess.run([place / "bin/haptogram-study", "list"], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "haptogram_shapes" in listed.stdout and (place / "haptogram/study/printed.toml").exists()
    where = subprocess.run([sys.executable, "-c", "import haptogram; print(haptogram.__file__)"], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert where.stdout.startswith(str(place))
