# SPDX-License-Identifier: Apache-2.0
"""The licences that a wheel brings of the libraries in it, named as auditwheel names them."""
import base64
import hashlib
import pathlib
import subprocess
import sys
import zipfile

import pytest

SBOM = pathlib.Path(__file__).resolve().parents[2] / "tools/sbom.py"


def noticed(tmp_path, *libraries):
    wheel = tmp_path / "haptogram-0.1.0-py3-none-manylinux_2_35_x86_64.whl"
    with zipfile.ZipFile(wheel, "w") as packed:
        packed.writestr("haptogram.libs/", "")  # as auditwheel packs it
        for library in libraries:
            packed.writestr(f"haptogram.libs/{library}", "x")
        packed.writestr("haptogram-0.1.0.dist-info/RECORD", "haptogram-0.1.0.dist-info/RECORD,,\n")
    return wheel, subprocess.run([sys.executable, SBOM, "notices", wheel], capture_output=True, text=True, check=False)


def test_the_licence_of_each_library_is_in_the_wheel(tmp_path):
    found = list(pathlib.Path("/usr/lib/x86_64-linux-gnu").glob("libminizip.so.1.*"))
    if not found:
        pytest.skip("minizip is not where a Debian of this kind has it")
    stem, rest = found[0].name.split(".", 1)
    wheel, done = noticed(tmp_path, f"{stem}-0a1b2c3d.{rest}")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(wheel) as packed:
        name = "haptogram-0.1.0.dist-info/licenses/NOTICES.txt"
        text, record = packed.read(name), packed.read("haptogram-0.1.0.dist-info/RECORD").decode()
        assert packed.read(f"haptogram.libs/{stem}-0a1b2c3d.{rest}") == b"x"
    assert b"libminizip1 " in text and b"Gilles Vollant" in text and b"libfmt-dev " in text
    digest = base64.urlsafe_b64encode(hashlib.sha256(text).digest()).rstrip(b"=").decode()
    assert f"{name},sha256={digest},{len(text)}\n" in record


def test_a_library_of_nobody_is_named(tmp_path):
    wheel, done = noticed(tmp_path, "libnobody-0a1b2c3d.so.1")
    assert done.returncode == 1 and "libnobody.so.1" in done.stderr
    assert "NOTICES" not in "".join(zipfile.ZipFile(wheel).namelist())
