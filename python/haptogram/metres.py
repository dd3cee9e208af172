# SPDX-License-Identifier: Apache-2.0
"""Lengths: metres in Python, millimetres in files and on the command line."""
from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .results import usage

FileName: TypeAlias = str | os.PathLike[str]
Numbers: TypeAlias = npt.NDArray[np.float64]

FARTHEST_M = 5.0  # beyond it nothing can be felt; a length that is longer was meant to be millimetres
LENGTHS = ("center", "diameter", "height", "length", "move", "nearest", "pitch", "position", "radius", "size")  # in files with _mm, here with _m


def kind(value: object) -> str:
    return f"{type(value).__name__} of shape {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__


def numbers(where: str, value: Any) -> Numbers:
    try:
        found = np.ascontiguousarray(value, dtype=float)
    except (TypeError, ValueError):
        raise usage(where, f"expected numbers, found {kind(value)}") from None
    if not np.isfinite(found).all():
        raise usage(where, "expected finite numbers, found nan or inf")
    return found.reshape(np.shape(value))


def metres(where: str, value: Any) -> Numbers:
    found = numbers(where, value)
    if (far := np.abs(found) > FARTHEST_M).any():
        first = found[far].ravel()[0]
        raise usage(where, f"found {first:g} m; lengths are metres: did you mean {first / 1000:g}?")
    return found


def mm(where: str, given: Any) -> Any:
    """As files and the command line have it: the number that a person would type."""
    found = np.vectorize(lambda value: float(f"{1000 * value:.15g}"), otypes=[float])(metres(where, given))
    return found.tolist()


def place_text(point: Sequence[float] | Numbers) -> str:
    return f"({', '.join(f'{axis:g}' for axis in point)})"


def points_of(where: str, value: Any) -> Numbers:
    """n × 3; one point may be given alone."""
    found = numbers(where, value)
    found = found[None] if found.shape == (3,) else found
    if found.ndim != 2 or found.shape[1] != 3:
        raise usage(where, f"expected points × 3, found {kind(value)}")
    away = np.linalg.norm(found, axis=1)
    for number in np.flatnonzero(away > FARTHEST_M):
        at, meant = place_text(found[number]), place_text(found[number] / 1000)
        raise usage(f"{where}[{number}]", f"{at} m is {away[number]:g} m away; lengths are metres: did you mean {meant}?")
    return found


def millimetres(where: str, given: Any) -> Any:
    """A file's table: whichever lengths end in _m here end in _mm there, and paths are texts."""
    if isinstance(given, Mapping):
        found: dict[str, Any] = {}
        for key, value in given.items():
            is_length = key.endswith("_m") and key[:-2] in LENGTHS
            name = f"{key[:-2]}_mm" if is_length else key
            if name in found:
                raise usage(f"{where}{key}", f"there is {name}, too; give one")
            found[name] = mm(f"{where}{key}", value) if is_length else millimetres(f"{where}{key}.", value)
        return found
    if isinstance(given, os.PathLike):
        return str(Path(given).resolve())
    if isinstance(given, np.ndarray | np.generic):
        return given.tolist()
    return [millimetres(where, each) for each in given] if isinstance(given, list | tuple) else given


def toml(where: str, value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool | int | float):
        return repr(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(where, key)} = {toml(f'{where}.{key}', each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(where, each) for each in value) + "]"
    raise usage(where, f"expected a text, a number, a list or a dict, found {kind(value)}")


def toml_file(where: str, table: dict[str, Any]) -> str:
    """A table as the text of a TOML file."""
    return "".join(f"{toml(where, key)} = {toml(key, value)}\n" for key, value in table.items())


def is_file(name: FileName) -> bool:
    return isinstance(name, os.PathLike) or os.sep in name or "." in name
