# SPDX-License-Identifier: Apache-2.0
"""The plan: which configurations there are, and which of their numbers are wanted. README.md describes its keys."""

import functools
import hashlib
import itertools
import json
import pathlib
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from haptogram.library import find_library, library

from .errors import SweepError, bad_input
from .files import Files, gather, looks_like_file

FORMAT = "haptogram-sweep-1"
Configuration = dict[str, Any]  # a value for each key of VARIED that the plan has


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _point(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(_number(one) for one in value)


def _text(value: Any) -> bool:
    return isinstance(value, str) and value != ""


# What may vary: whether a value is one, and what it should be.
VARIED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "array": (_text, "the name of a shipped array, or an array file"),
    "side": (lambda v: isinstance(v, int) and not isinstance(v, bool) and v >= 1, "a whole number of elements along each side"),
    "pitch_mm": (lambda v: _number(v) and v > 0, "a positive distance between elements, mm"),
    "transducer": (_text, "the name of a shipped transducer, or a transducer file"),
    "focus_mm": (_point, "a focal point [x, y, z], mm"),
    "foci_mm": (lambda v: isinstance(v, list) and len(v) >= 2 and all(map(_point, v)), "a list of two focal points or more, played at the same time, mm"),
    "path": (_text, "a path file"),
    "project": (_text, "a project file"),
}
PLAYED = ("focus_mm", "foci_mm", "path", "project")

ONE, SEVERAL, PATH = "focus_mm", "foci_mm", "path"
# Each quantity: what it is of, which of the plan's tables it needs, and what it is.
QUANTITIES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "pressure_pa": ((ONE, SEVERAL, PATH), "", "pressure amplitude at the focus; at the weakest of several"),
    "radiation_pa": ((ONE, PATH), "", "radiation pressure on skin at the focus; at the weakest of a path"),
    "width_mm": ((ONE, PATH), "", "full width at half of the radiation pressure; the widest of a path"),
    "depth_mm": ((ONE, PATH), "", "the same along z"),
    "side_lobe": ((ONE, PATH), "", "highest radiation pressure beside the focus over that at its peak; the worst of a path"),
    "force_mn": ((ONE, PATH), "", "force through the square of the width; the least of a path"),
    "formation_us": ((ONE, PATH), "", "how long the focus takes to form, T_f of the Haptogram paper; the longest of a path"),
    "spread": ((SEVERAL,), "", "standard deviation of the foci's pressures over their mean"),
    "least_over_mean": ((SEVERAL,), "", "the weakest focus over the mean"),
    "efficiency": ((SEVERAL,), "", "mean pressure over that of a single focus, times the root of their number"),
    "points": ((PATH,), "", "focal points of the path"),
    "highest_db": ((PATH,), "", "loudest place on the axis, dB SPL"),
    "pressure_left": ((PATH,), "", "what the transducers' bandwidth leaves of the pressure at the worst point"),
    "workspace_cm3": ((ONE, SEVERAL, PATH), "workspace", "volume in which a lone focus has the least pressure asked for"),
    "peak_rms_pa": ((ONE, SEVERAL, PATH), "field", "largest rms pressure of the plane"),
    "peak_x_mm": ((ONE, SEVERAL, PATH), "field", "where that is"),
    "peak_y_mm": ((ONE, SEVERAL, PATH), "field", "where that is"),
    "peak_z_mm": ((ONE, SEVERAL, PATH), "field", "where that is"),
}
# The keys of the tables that quantities need; those with None must be there.
TABLES: dict[str, dict[str, Any]] = {
    "workspace": {"least_pa": None, "step_mm": 5.0, "x_mm": [-100.0, 100.0], "y_mm": [-100.0, 100.0], "z_mm": [20.0, 300.0]},
    "field": {"plane": "xy@z=130", "extent_mm": 80.0, "step_mm": 1.0},
}


@dataclass(frozen=True)
class Plan:
    path: pathlib.Path
    configurations: list[Configuration]
    quantities: list[str]
    tables: dict[str, dict[str, Any]]
    plot: dict[str, str]
    files: dict[str, Files]  # of each name in a configuration that is a file: it, and all that it names

    @functools.cached_property
    def digests(self) -> dict[str, dict[str, str]]:
        """Of the contents of all files."""
        return {name: {file: hashlib.sha256(content).hexdigest() for file, content in files.items()} for name, files in self.files.items()}

    @property
    def varied(self) -> list[str]:
        """The keys with more than one value."""
        keys = list(self.configurations[0])
        return [key for key in keys if any(c[key] != self.configurations[0][key] for c in self.configurations)]

    def files_of(self, configuration: Configuration) -> dict[str, Files]:
        return {value: self.files[value] for value in configuration.values() if isinstance(value, str) and value in self.files}

    def key_of(self, configuration: Configuration) -> str:
        """Names a configuration's row: the same only when everything is the same that the row follows from."""
        digests = {name: self.digests[name] for name in self.files_of(configuration)}
        what = [FORMAT, configuration, self.quantities, self.tables, digests, library_digest()]
        return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()


@functools.cache
def library_digest() -> str:
    """Of the compiled library: rows of other ones are not taken for the same."""
    found = pathlib.Path(find_library())
    return hashlib.sha256(found.read_bytes() if found.exists() else library().haptogram_version()).hexdigest()  # the system's is known by its version


def _values(where: str, key: str, given: Any) -> list[Any]:
    """A list of values; a range {from, to, steps} is one, too."""
    good, what = VARIED[key]
    if isinstance(given, dict):
        if set(given) != {"from", "to", "steps"} or key not in ("side", "pitch_mm") or not all(map(_number, given.values())) or given["steps"] < 2:
            raise bad_input(where, f"found {given}; a range is {{ from = 8, to = 12, steps = 5 }}, of side or pitch_mm, with at least two steps")
        low, high, steps = given["from"], given["to"], int(given["steps"])
        values = [low + (high - low) * i / (steps - 1) for i in range(steps)]
        given = [round(v) for v in values] if key == "side" else [round(v, 9) for v in values]
    if not isinstance(given, list) or not given:
        raise bad_input(where, f"found {given!r}; expected a list, each of it {what}")
    for value in given:
        if not good(value):
            raise bad_input(where, f"found {value!r}; expected {what}")
    if len({json.dumps(v) for v in given}) != len(given):
        raise bad_input(where, "has a value twice; each would give the same row")
    return list(given)


def _configurations(where: str, vary: Any) -> list[Configuration]:
    if not isinstance(vary, dict) or not vary:
        raise bad_input(where, "has no table [vary]; it lists the values of " + ", ".join(VARIED))
    for key in vary:
        if key not in VARIED:
            raise bad_input(f"{where}: vary", f"found '{key}'; expected some of {', '.join(VARIED)}")
    played = [key for key in PLAYED if key in vary]
    if len(played) != 1:
        raise bad_input(f"{where}: vary", f"found {' and '.join(played) or 'nothing that is played'}; expected one of {', '.join(PLAYED)}")
    if ("side" in vary) != ("pitch_mm" in vary) or ("side" in vary and "array" in vary):
        raise bad_input(f"{where}: vary", "side and pitch_mm make a square array together, in place of array")
    if "transducer" in vary and "side" not in vary and played[0] in ("path", "project"):
        raise bad_input(f"{where}: vary", "the transducers of a path's array are in its file; transducer needs side and pitch_mm")
    values = {key: _values(f"{where}: vary.{key}", key, given) for key, given in vary.items()}
    return [dict(zip(values, combination)) for combination in itertools.product(*values.values())]


def _tables(where: str, document: dict[str, Any], quantities: list[str]) -> dict[str, dict[str, Any]]:
    needed = {QUANTITIES[name][1] for name in quantities} - {""}
    found = {}
    for name, keys in TABLES.items():
        given = document.get(name, {})
        if name in document and name not in needed:
            raise bad_input(f"{where}: {name}", "no quantity of this plan needs this table; take it out, or name the quantity")
        if name not in needed:
            continue
        for key, value in given.items():
            if key not in keys:
                raise bad_input(f"{where}: {name}", f"found '{key}'; expected some of {', '.join(keys)}")
            default = keys[key]
            is_range = isinstance(value, list) and len(value) == 2 and all(map(_number, value)) and value[0] < value[1]
            good = is_range if isinstance(default, list) else _text(value) if isinstance(default, str) else _number(value) and value > 0
            if not good:
                what = "a range [from, to]" if isinstance(default, list) else "a text such as xy@z=130" if isinstance(default, str) else "a positive number"
                raise bad_input(f"{where}: {name}.{key}", f"found {value!r}; expected {what}")
        full = {**keys, **given}
        missing = [key for key, value in full.items() if value is None]
        if missing:
            raise bad_input(f"{where}: {name}", f"expected {', '.join(missing)}")
        found[name] = full
    return found


def read(path: pathlib.Path) -> Plan:
    """Reads a plan.
    @raises SweepError naming the file and the key, what was found and what was expected"""
    where = str(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise bad_input(where, f"cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise bad_input(where, f"is no TOML: {error}") from None
    if document.get("format") != FORMAT:
        raise bad_input(f"{where}: format", f"found {document.get('format')!r}; expected '{FORMAT}'")
    for key in document:
        if key not in ("format", "quantities", "vary", "plot", *TABLES):
            raise bad_input(where, f"found '{key}'; expected some of format, quantities, vary, plot, {', '.join(TABLES)}")
    configurations = _configurations(where, document.get("vary"))
    kind = next(key for key in PLAYED if key in configurations[0])
    kind = PATH if kind == "project" else kind
    quantities = document.get("quantities")
    if not isinstance(quantities, list) or not quantities:
        raise bad_input(f"{where}: quantities", f"expected a list of some of {', '.join(QUANTITIES)}")
    for name in quantities:
        if name not in QUANTITIES or kind not in QUANTITIES[name][0]:
            raise bad_input(f"{where}: quantities", f"found {name!r}; of {kind}, expected some of " + ", ".join(q for q, of in QUANTITIES.items() if kind in of[0]))
    files: dict[str, Files] = {}
    for configuration in configurations:
        for key in ("array", "transducer", "path", "project"):
            name = configuration.get(key)
            if name is not None and name not in files and (key in ("path", "project") or looks_like_file(name)):
                files[name] = gather(path.parent, name)
    plot = document.get("plot", {})
    if not isinstance(plot, dict) or any(key not in ("x", "lines") or value not in configurations[0] for key, value in plot.items()):
        raise bad_input(f"{where}: plot", f"found {plot!r}; expected x and lines, each a key of [vary]")
    return Plan(path, configurations, list(quantities), _tables(where, document, quantities), plot, files)


__all__ = ["Configuration", "Plan", "QUANTITIES", "SweepError", "library_digest", "read"]
