# SPDX-License-Identifier: Apache-2.0
"""The library as ctypes sees it, made from the header itself."""
import ctypes
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import c_header  # noqa: E402

LIBRARY = Path(os.environ.get("HAPTOGRAM_LIBRARY", ROOT / "build/release/host/c/libhaptogram.so")).resolve()
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()
NUMBERS = {"uint8_t": ctypes.c_uint8, "int32_t": ctypes.c_int32, "uint32_t": ctypes.c_uint32, "uint16_t": ctypes.c_uint16, "uint64_t": ctypes.c_uint64,
           "double": ctypes.c_double, "size_t": ctypes.c_size_t, "haptogram_code": ctypes.c_int}


class Haptogram:
    """Its functions without their prefix; struct("port", port=b"…") is one of its structs, with its size."""

    def __init__(self):
        self.header = c_header.read()
        self.library = ctypes.CDLL(str(LIBRARY))
        self.structs = {}
        for name, members in self.header.structs.items():
            fields = [(p.name, self.type_of(p)) for p in members]
            self.structs[name] = type(name, (ctypes.Structure,), {"_fields_": fields})
        for name, (returns, given) in self.header.functions.items():
            function = getattr(self.library, name)
            function.argtypes = [self.type_of(p) for p in given]
            function.restype = None if returns.type == "void" and not returns.stars else self.type_of(returns)
            setattr(self, name.removeprefix("haptogram_"), function)

    def type_of(self, p):
        if p.stars == 0:
            return NUMBERS[p.type]
        if p.stars == 1 and p.type == "char" and p.const:
            return ctypes.c_char_p
        if p.stars == 1 and p.type in self.structs:
            return ctypes.POINTER(self.structs[p.type])
        if p.stars == 1 and p.type in NUMBERS:
            return ctypes.POINTER(NUMBERS[p.type])
        return ctypes.POINTER(ctypes.c_void_p) if p.stars == 2 else ctypes.c_void_p

    def struct(self, name, **values):
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
