# SPDX-License-Identifier: Apache-2.0
"""Files travel with the configurations that name them, because workers may be on other machines: a project goes with its shapes,
an array with its transducer's pattern."""

import pathlib
import tomllib
from collections.abc import Iterator
from typing import Any

from .errors import bad_input

Files = dict[str, bytes]  # by names relative to the plan's folder


def looks_like_file(name: str) -> bool:
    return "/" in name or pathlib.PurePath(name).suffix != ""


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for one in value.values():
            yield from _texts(one)
    elif isinstance(value, list):
        for one in value:
            yield from _texts(one)


def gather(folder: pathlib.Path, name: str) -> Files:
    """A file, and all files that it names, if it is TOML.
    @raises SweepError when it cannot be read, or is not in the plan's folder or below"""
    found: Files = {}
    wanted = [pathlib.PurePosixPath(name)]
    while wanted:
        one = wanted.pop()
        if one.is_absolute() or ".." in one.parts:
            raise bad_input(str(one), f"is not in the plan's folder or below, from where it can go to workers; put it into {folder.resolve()}")
        if str(one) in found:
            continue
        try:
            found[str(one)] = (folder / one).read_bytes()
        except OSError as error:
            raise bad_input(str(folder / one), f"cannot be read: {error.strerror}") from None
        if one.suffix == ".toml":
            try:
                document = tomllib.loads(found[str(one)].decode("utf-8"))
            except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
                raise bad_input(str(folder / one), f"is no TOML: {error}") from None
            wanted += [one.parent / text for text in _texts(document) if text and len(text) < 256 and (folder / one.parent / text).is_file()]
    return found


def place(files: dict[str, Files], folder: pathlib.Path) -> None:
    """Writes the files into a folder, under their names."""
    for each in files.values():
        for name, content in each.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
