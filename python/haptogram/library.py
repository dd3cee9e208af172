# SPDX-License-Identifier: Apache-2.0
"""The C++ library, by its C interface (host/c/haptogram.h)."""
import ctypes
import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ._program import LIBRARY
from .errors import ErrorCode, HaptogramError, bad_input
from .native import ABI, FUNCTIONS

NAME = "libhaptogram.so.1"
CODES = {1: ErrorCode.RUN_FAILED, 2: ErrorCode.USAGE, 3: ErrorCode.BAD_INPUT, 4: ErrorCode.DEVICE, 5: ErrorCode.RUN_FAILED}


def find_library() -> str:
    """Of the environment's HAPTOGRAM_LIBRARY, of the wheel, of the checkout, of the prefix that has the package in its share/, or of the system."""
    if given := os.environ.get("HAPTOGRAM_LIBRARY"):
        return given
    here = Path(__file__).resolve()
    places = [LIBRARY, here.parents[2] / "build/release/host/c" / NAME]
    places += [found for folder in ("lib", "lib/*", "lib64") for found in here.parents[4].glob(f"{folder}/{NAME}")] if here.parents[1].match("share/haptogram/python") else []
    return next((str(place) for place in places if place.exists()), NAME)


@functools.cache
def library() -> ctypes.CDLL:
    path = find_library()
    try:
        found = ctypes.CDLL(path)
        abi = found.haptogram_abi()
    except (OSError, AttributeError) as error:
        raise bad_input(path, f"cannot be loaded ({error}); pip install the wheel, build it with make build, or let HAPTOGRAM_LIBRARY name it") from error
    missing = [name for name in FUNCTIONS if not hasattr(found, name)]
    if abi != ABI or missing:
        raise bad_input(path, f"is another version than this package: interface {abi}, expected {ABI}{f', without {missing[0]}' if missing else ''}; install one release of both")
    for name, (returns, given) in FUNCTIONS.items():
        function = getattr(found, name)
        function.restype, function.argtypes = returns, given
    return found


def call(name: str, *given: object, place: Callable[[str], str] = str) -> None:
    """Calls haptogram_`name`. Raises the HaptogramError that it says, whose `where` is place() of the library's."""
    code = getattr(library(), f"haptogram_{name}")(*given)
    if code:
        where, said, remedies = (getattr(library(), f"haptogram_{part}")().decode("utf-8", "backslashreplace") for part in ("error_place", "error", "remedies"))
        raise HaptogramError(CODES[code], place(where), said.removeprefix(f"{where}: "), remedies.split(",") if remedies else ())


def sized(struct: type[ctypes.Structure], **values: object) -> Any:
    """With its size, which each function asks for."""
    return struct(size=ctypes.sizeof(struct), **values)
