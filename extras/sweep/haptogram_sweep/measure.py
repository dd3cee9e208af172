# SPDX-License-Identifier: Apache-2.0
"""One configuration to its numbers, through the library. Runs on the workers, on one thread each."""

import contextlib
import os
import pathlib
import tempfile
from collections.abc import Iterator
from typing import Any

import numpy as np
from haptogram import calls as hn
from haptogram.errors import ErrorCode

from .files import Files, looks_like_file, place
from .plan import Configuration, library_digest

MM = 1e-3


@contextlib.contextmanager
def _folder(files: dict[str, Files]) -> Iterator[pathlib.Path]:
    with tempfile.TemporaryDirectory(prefix="haptogram-sweep-") as name:
        place(files, pathlib.Path(name))
        yield pathlib.Path(name)


def _array_file(configuration: Configuration, folder: pathlib.Path) -> str:
    """The array's name or file; one is written for a square array."""
    if "side" not in configuration:
        name = str(configuration.get("array", "tile-10x10"))
        return str(folder / name) if looks_like_file(name) else name
    side = configuration["side"]
    text = f"name = \"{side} x {side}\"\n[array]\nrows = {side}\ncolumns = {side}\npitch_mm = {configuration['pitch_mm']}\n[board]\nchannels = {max(2, side * side)}\n"
    if "transducer" in configuration:
        text += f"[transducer]\nfile = \"{configuration['transducer']}\"\n"
    (folder / "square-array.toml").write_text(text, encoding="utf-8")
    return str(folder / "square-array.toml")


def _compiled(configuration: Configuration, array: str, folder: pathlib.Path) -> hn.Compiled:
    """The image of a path or a project. A varied array takes the place of the project's own."""
    if "path" in configuration:
        text = f"format = \"haptogram-project-1\"\npath = '{configuration['path']}'\narray = '{array}'\n"
        return hn.compile_text(text, folder, configuration["path"])
    file = folder / configuration["project"]
    text = file.read_text(encoding="utf-8")
    if "array" in configuration or "side" in configuration:
        text = f"array = '{array}'\n{text}"
    return hn.compile_text(text, file.parent, configuration["project"])


def _of_path(compiled: hn.Compiled, wanted: set[str]) -> dict[str, float]:
    a = hn.analyze(compiled)
    found = {
        "pressure_pa": a.pressure_pa.min(),
        "radiation_pa": a.radiation_pa.min(),
        "width_mm": a.width_m.max() / MM,
        "depth_mm": a.depth_m.max() / MM,
        "side_lobe": a.side_lobe.max(),
        "force_mn": 1e3 * a.force_n.min(),
        "formation_us": 1e6 * a.formation_s.max(),
        "points": float(len(a.foci_m)),
        "highest_db": a.highest_db,
        "pressure_left": a.pressure_left_least,
    }
    return {name: float(value) for name, value in found.items() if name in wanted}


def _of_foci(array: hn.Array, foci: list[list[float]], drives: np.ndarray[Any, Any], wanted: set[str]) -> dict[str, float]:
    points = MM * np.asarray(foci, float)
    if len(points) == 1:
        a = hn.analyze_focus(array, drives, points[0])
        found = {
            "pressure_pa": a.pressure_pa,
            "radiation_pa": a.radiation_pa,
            "width_mm": a.width_m / MM,
            "depth_mm": a.depth_m / MM,
            "side_lobe": a.side_lobe,
            "force_mn": 1e3 * a.force_n,
            "formation_us": 1e6 * a.formation_s,
        }
    else:
        q = hn.quality(array, points, drives)
        pressure = np.abs(hn.pressure(array, drives, points, threads=1))
        found = {"pressure_pa": pressure.min(), "spread": q.spread, "least_over_mean": q.least_over_mean, "efficiency": q.efficiency}
    return {name: float(value) for name, value in found.items() if name in wanted}


def _workspace_cm3(array: hn.Array, table: dict[str, Any]) -> float:
    step = table["step_mm"] * MM
    axes = [np.arange(low * MM, high * MM + step / 2, step) for low, high in (table["x_mm"], table["y_mm"], table["z_mm"])]
    return float(1e6 * step**3 * np.count_nonzero(hn.workspace(array, *axes) >= table["least_pa"]))  # NaN is out of reach, and is not


def _peak(excitation: hn.Excitation, table: dict[str, Any]) -> dict[str, float]:
    field = hn.field(excitation, plane=table["plane"], extent_m=table["extent_mm"] * MM, step_m=table["step_mm"] * MM, quantity="rms", threads=1)
    at = np.unravel_index(int(np.argmax(field.values)), field.values.shape)
    place_mm = field.point_m(int(np.ravel_multi_index(at, field.values.shape))) / MM
    return {"peak_rms_pa": float(field.values[at]), **{f"peak_{axis}_mm": float(value) for axis, value in zip("xyz", place_mm)}}


def measure(configuration: Configuration, quantities: list[str], tables: dict[str, dict[str, Any]], files: dict[str, Files]) -> dict[str, float]:
    """The quantities of a configuration.
    @raises HaptogramError when the libraries refuse it, such as a focus out of reach"""
    wanted = set(quantities)
    with _folder(files) as folder:
        name = _array_file(configuration, folder)
        if "path" in configuration or "project" in configuration:
            compiled = _compiled(configuration, name, folder)
            excitation = hn.Excitation.of_compiled(compiled)
            array = excitation.array
            found = _of_path(compiled, wanted)
        else:
            array = hn.Array.find(name)
            if "transducer" in configuration and "side" not in configuration:
                transducer = configuration["transducer"]
                array = array.with_transducer(str(folder / transducer) if looks_like_file(transducer) else transducer)
            foci = configuration.get("foci_mm") or [configuration["focus_mm"]]
            for focus in foci:
                why = array.unreachable(MM * np.asarray(focus, float))
                if why:
                    raise hn.BadArgument(ErrorCode.USAGE, "focus_mm", f"{focus}: {why}")
            drives = hn.ideal_drives(array, MM * np.asarray(foci[0], float))
            if len(foci) > 1:
                drives = np.abs(drives[0]) * hn.solve(array, MM * np.asarray(foci, float))
            excitation = hn.Excitation.of_drives(array, drives[None, :])
            found = _of_foci(array, foci, drives, wanted)
    if "workspace" in tables:
        found["workspace_cm3"] = _workspace_cm3(array, tables["workspace"])
    if "field" in tables:
        found.update(_peak(excitation, tables["field"]))
    return {name: found[name] for name in quantities}


def measure_batch(
    batch: list[tuple[Configuration, dict[str, Files]]], quantities: list[str], tables: dict[str, dict[str, Any]], library: str
) -> list[dict[str, float] | str]:
    """What measure() gives for each, or why there is none. Refuses to work with other libraries than the client's."""
    if library != library_digest():
        raise RuntimeError(f"the worker on {os.uname().nodename} has another libhaptogram than this machine; install the same there")
    found: list[dict[str, float] | str] = []
    for configuration, files in batch:
        try:
            found.append(measure(configuration, quantities, tables, files))
        except hn.HaptogramError as error:
            found.append(str(error))
    return found
