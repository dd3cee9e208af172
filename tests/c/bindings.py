# SPDX-License-Identifier: Apache-2.0
"""The library as ctypes sees it, by what tools/c_header.py has written for Python."""
import ctypes
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
sys.path.insert(0, str(ROOT / "python"))
import c_header  # noqa: E402
from haptogram import native  # noqa: E402

LIBRARY = Path(os.environ.get("HAPTOGRAM_LIBRARY", ROOT / "build/release/host/c/libhaptogram.so")).resolve()
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()


class Haptogram:
    """Its functions without their prefix; struct("port", port=b"…") is one of its structs, with its size."""

    def __init__(self):
        self.header = c_header.read()
        self.library = ctypes.CDLL(str(LIBRARY))
        self.structs = {name: getattr(native, c_header.camel(name)) for name in self.header.structs}
        for name, (returns, given) in native.FUNCTIONS.items():
            function = getattr(self.library, name)
            function.restype, function.argtypes = returns, given
            setattr(self, name.removeprefix("haptogram_"), function)

    def struct(self, name, /, **values):
        if name == "playing":
            values.setdefault("watchdog_ms", 60000)  # which lets a busy machine pause
        made = self.structs[f"haptogram_{name}"](**values)
        if made._fields_[0][0] == "size":
            made.size = ctypes.sizeof(made)
        return made

    def foci(self, *places):
        return (self.structs["haptogram_focus"] * len(places))(*[(*place, 1.0)[:4] for place in places])

    def ok(self, code):
        assert code == 0, f"code {code}: {self.error().decode()}"

    def fails(self, code, name, *words):
        said = self.error().decode()
        assert code == self.header.codes[f"HAPTOGRAM_{name}"], f"code {code}: {said}"
        for word in words:
            assert word in said, said

    def made(self, function, argument):
        handle = ctypes.c_void_p()
        self.ok(function(ctypes.byref(argument), ctypes.byref(handle)))
        return handle

    def text(self, function, image):
        size = function(image, None, 0)
        to = ctypes.create_string_buffer(size)
        assert function(image, to, size) == size
        return to.raw
