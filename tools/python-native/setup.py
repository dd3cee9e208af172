# SPDX-License-Identifier: Apache-2.0
"""Has CMake build the extension module from the libraries of this checkout; what that needs, CMake names when it is missing."""

import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/python-native"  # as deep as build/release, so that a ccache with relative paths has what was compiled there
SETUPTOOLS = BUILD / "setuptools"  # and nothing is written beside the sources
SETUPTOOLS.mkdir(parents=True, exist_ok=True)
LEFT_OUT = ("PROGRAM", "SIMULATION", "FTDI", "TESTS", "INSTALL")


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        options = ["-DCMAKE_BUILD_TYPE=Release", "-DHAPTOGRAM_PYTHON_MODULE=ON", f"-DPython3_EXECUTABLE={sys.executable}"]
        options += [f"-DHAPTOGRAM_{part}=OFF" for part in LEFT_OUT]
        subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", *options], check=True)
        subprocess.run(["cmake", "--build", BUILD, "--target", "haptogram_native_module"], check=True)
        (built,) = BUILD.glob("tools/python-native/haptogram_native/_native*.so")
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        self.copy_file(str(built), str(target))


setup(
    ext_modules=[Extension("haptogram_native._native", [])],
    cmdclass={"build_ext": CMakeBuild},
    options={"build": {"build_base": str(SETUPTOOLS)}, "egg_info": {"egg_base": str(SETUPTOOLS)}},
)
