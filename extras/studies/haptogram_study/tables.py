# SPDX-License-Identifier: Apache-2.0
"""Strict reading of TOML: each key must be there and mean something, and what nobody asked for is an error."""
import builtins
import math
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any, NoReturn

from haptogram.errors import bad_input

REQUIRED: Any = object()
LARGEST_FILE = 1_000_000  # bytes


def load(path: Path) -> "Table":
    """The tables of a TOML file. Raises HaptogramError when it cannot be read, or is none."""
    try:
        if not path.is_file():
            raise bad_input(str(path), "is no file; check the path" if path.exists() else "there is no such file; check the path")
        if path.stat().st_size > LARGEST_FILE:
            raise bad_input(str(path), f"has {path.stat().st_size} bytes, expected at most {LARGEST_FILE}; is this the right file?")
        return Table(tomllib.loads(path.read_text(encoding="utf-8")), str(path))
    except OSError as error:
        raise bad_input(str(path), f"cannot be read: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise bad_input(str(path), f"byte {error.start} is no UTF-8; is this a TOML file?") from error
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise bad_input(str(path), f"is no TOML: {error or 'nested too deeply'}") from error


class Table:
    """A table of a TOML file. The methods take a key out of it; done() refuses what is left."""

    def __init__(self, values: dict[str, Any], where: str) -> None:
        self.where = where
        self._left = dict(values)
        self._known: list[str] = []

    def fail(self, key: str, found: object, expected: str) -> NoReturn:
        text = repr(found) if not isinstance(found, (dict, list)) else f"a {'table' if isinstance(found, dict) else 'list'}"
        raise bad_input(f"{self.where}: {key}", f"found {text[:80]}, expected {expected}")

    def __contains__(self, key: str) -> bool:
        return key in self._left

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(list(self._left))

    def _take(self, key: str, default: Any, expected: str) -> Any:
        self._known.append(key)
        if key in self._left:
            return self._left.pop(key)
        if default is REQUIRED:
            raise bad_input(f"{self.where}: {key}", f"is missing, expected {expected}; add it")
        return default

    def text(self, key: str, default: Any = REQUIRED, *, among: Collection[str] | None = None) -> Any:
        expected = f"one of {', '.join(sorted(among))}" if among else "a text in quotes"
        value = self._take(key, default, expected)
        if value is not default and (not isinstance(value, str) or not value.strip() or (among is not None and value not in among)):
            self.fail(key, value, expected)
        return value

    def number(self, key: str, default: Any = REQUIRED, *, low: float = -math.inf, high: float = math.inf, above: float = -math.inf) -> Any:
        limits = [f"{sign} {limit:g}" for sign, limit in ((">=", low), (">", above), ("<=", high)) if math.isfinite(limit)]
        expected = "a number" + (f" {' and '.join(limits)}" if limits else "")
        value = self._take(key, default, expected)
        if value is default:
            return value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not (low <= value <= high and value > above and math.isfinite(value)):
            self.fail(key, value, expected)
        return float(value)

    def whole(self, key: str, default: Any = REQUIRED, *, low: int, high: int = 1_000_000) -> Any:
        expected = f"a whole number from {low} to {high}"
        value = self._take(key, default, expected)
        if value is not default and (isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high):
            self.fail(key, value, expected)
        return value

    def list(self, key: str, default: Any = REQUIRED, *, of: type | tuple[type, ...] = object, least: int = 1, expected: str = "a list") -> Any:
        value = self._take(key, default, expected)
        if value is default:
            return value
        if not isinstance(value, list) or len(value) < least or not all(isinstance(v, of) and (of is object or not isinstance(v, bool)) for v in value):
            self.fail(key, value, f"{expected} of at least {least}" if isinstance(value, list) else expected)
        return value

    def table(self, key: str, default: Any = REQUIRED) -> Any:
        value = self._take(key, default, "a table")
        if value is default:
            return value
        if not isinstance(value, dict):
            self.fail(key, value, "a table")
        return Table(value, f"{self.where}: {key}")

    def tables(self, key: str, *, least: int = 0) -> "builtins.list[Table]":
        """The tables of [[key]]."""
        value = self.list(key, [] if least == 0 else REQUIRED, of=dict, least=least, expected=f"tables [[{key}]]")
        return [Table(v, f"{self.where}: {key} {number}") for number, v in enumerate(value, 1)]

    def any(self, key: str, default: Any = REQUIRED, expected: str = "a value") -> Any:
        return self._take(key, default, expected)

    def rest(self) -> dict[str, Any]:
        """All that is left, whatever its keys."""
        left, self._left = self._left, {}
        return left

    def done(self) -> None:
        for key in self._left:
            raise bad_input(f"{self.where}: {key}", f"has no meaning here; expected {', '.join(sorted(set(self._known))) or 'nothing'}; correct or remove it")
