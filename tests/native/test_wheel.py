# SPDX-License-Identifier: Apache-2.0
"""The package as pip builds it from the checkout, without network. ccache has what the build under test compiled."""
import os
import subprocess
import sys

import pytest
from conftest import PACKAGE


@pytest.mark.skipif(not os.environ.get("HAPTOGRAM_WHEEL"), reason="builds the libraries again; ctest asks for it")
def test_pip_builds_a_wheel(tmp_path):
    pip = [sys.executable, "-m", "pip"]
    build = [*pip, "wheel", "-q", "--no-index", "--no-deps", "--no-build-isolation", "-w", str(tmp_path), str(PACKAGE)]
    subprocess.run(build, check=True, timeout=1500)
    (wheel,) = tmp_path.glob("haptogram_native-*.whl")
    place = tmp_path / "place"
    subprocess.run([*pip, "install", "-q", "--no-index", "--no-deps", "--target", str(place), str(wheel)], check=True, timeout=120)
    for name in ("py.typed", "_native.pyi", "errors.py"):
        assert (place / "haptogram_native" / name).exists()
    say = "import haptogram_native as n; print(n.__file__, len(n.Array.find('tile-10x10')))"
    said = subprocess.run([sys.executable, "-c", say], env={**os.environ, "PYTHONPATH": str(place)}, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert said.stdout.startswith(str(place)) and said.stdout.endswith(" 100\n")
