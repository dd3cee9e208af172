# SPDX-License-Identifier: Apache-2.0
"""From shapes to images, sound fields and what is felt, on numpy. Lengths are metres in the array's frame; drives are complex peak amplitudes in Pa m.

The C++ library computes everything, or for feel() and simulate() the program. Both are in the wheel."""
from __future__ import annotations

import contextlib
import csv
import json
import os
import subprocess
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import calls, pictures
from .errors import ErrorCode, HaptogramError, bad_input
from .image import Image
from .metres import FileName, Numbers, is_file, kind, metres, millimetres, mm, numbers, points_of, toml_file
from .program import find_program
from .results import Field, Table, usage

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OF_A_SHAPE = ("diameter_m", "length_m", "height_m", "sides", "turns", "unit", "up")
OF_THE_PLACE = ("scale", "size_m", "rotate_deg", "center_m")


# ---- what all functions need


@contextlib.contextmanager
def _work() -> Iterator[Path]:
    """A folder for the files that the libraries read. What they throw comes out as one HaptogramError of one line."""
    with tempfile.TemporaryDirectory(prefix="haptogram-") as name:
        try:
            yield Path(name)
        except HaptogramError as error:
            where, message = (_one_line(text.replace(f"{name}/", "")) for text in (error.where, error.message))
            raise HaptogramError(error.code, where, message, error.remedies) from None


def _one_line(message: str) -> str:
    """Of a list in the message only the first item stays."""
    lines = message.rstrip().splitlines() or [""]
    listed = [number for number, line in enumerate(lines) if line.startswith("  ")]
    kept = [line.strip() for number, line in enumerate(lines) if number not in listed[1:]]
    return kept[0] + "".join((" " if kept[number].endswith(":") else "; ") + line for number, line in enumerate(kept[1:]))


# ---- what is computed with


class Array:
    """Transducers that play together, and the air in front of them. It never changes.

    Array("tile-10x10")          a shipped array; haptogram.array_names() has them all
    Array(Path("mine.toml"))     an array file
    Array(compiled)              the array of what compile() gave
    Array(positions_m=…)         an own one: elements × 3, or × 2 in the plane z = 0; channel k drives element k

    normals: elements × 3, where the elements of an own array face; without it +z.
    tables: the other tables of an array file as dicts, such as transducer={"file": "T4010A1"}, medium={"temperature_c": 25}, board={…}, name="mine".
    """

    def __init__(self, source: FileName | Compiled | None = None, *, positions_m: npt.ArrayLike | None = None, normals: npt.ArrayLike | None = None,
                 **tables: Any) -> None:  # fmt: skip
        if (source is None) == (positions_m is None) or (source is not None and (normals is not None or tables)):
            raise usage("Array", "expected a name, a file, or what compile() gave; or positions_m with the tables of an own array")
        self._source: str | Compiled | dict[str, Any]
        if positions_m is not None:
            places = metres("positions_m", positions_m)
            if places.ndim != 2 or places.shape[1] not in (2, 3):
                raise usage("positions_m", f"expected elements × 3, or × 2, found {kind(positions_m)}")
            elements = mm("positions_m", places)
            if normals is not None:
                facing = numbers("normals", normals)
                if facing.shape != (len(places), 3):
                    raise usage("normals", f"expected {len(places)} × 3, found {kind(normals)}")
                elements = [[*(place + [0.0])[:3], *normal] for place, normal in zip(elements, facing.tolist(), strict=True)]
            given = millimetres("", tables)
            self._source = {"name": "own array", **given, "array": {**given.get("array", {}), "elements_mm": elements}}
        elif isinstance(source, Compiled):
            self._source = source
        elif isinstance(source, str | os.PathLike):
            self._source = str(Path(source).resolve()) if is_file(source) else str(source)
        else:
            raise usage("Array", f"expected a name, a file, or what compile() gave, found {kind(source)}")
        with _work() as folder:
            self.native = (calls.Excitation.of_image(self._source.write_to(folder)).array if isinstance(self._source, Compiled)
                           else calls.Array.find(self.file_in(folder)))  # fmt: skip

    def file_in(self, folder: Path) -> str:
        """Its name, or a file that describes it."""
        if isinstance(self._source, Compiled):
            raise usage("array", f"{self.name} is known from an image alone; give its name, its file or its positions_m")
        if isinstance(self._source, str):
            return self._source
        file = folder / "array.toml"
        file.write_text(toml_file("array", self._source), encoding="utf-8")
        return str(file)

    def save(self, file: FileName) -> None:
        """Writes an own array as an array file, which the program, the board and the studio take."""
        if not isinstance(self._source, dict):
            raise usage("save", f"{self.name} is no array of your own")
        Path(file).write_text(toml_file("array", self._source), encoding="utf-8")

    @property
    def positions_m(self) -> Numbers:
        """Elements × 3: a read-only view."""
        return self.native.positions_m

    @property
    def normals(self) -> Numbers:
        """Elements × 3, of length 1: a read-only view."""
        return self.native.normals

    @property
    def name(self) -> str:
        return self.native.name

    @property
    def carrier_hz(self) -> float:
        return self.native.carrier_hz

    @property
    def wavelength_m(self) -> float:
        return self.native.wavelength_m

    @property
    def transducer(self) -> str:
        """The kind of its transducers."""
        return self.native.transducer

    @property
    def level(self) -> str:
        """What pressures and forces rest on, in a sentence that begins with nominal or calibrated."""
        return self.native.level

    @property
    def full_pa_m(self) -> float:
        """Amplitude of a drive at full strength, Pa m."""
        return float(f"{np.abs(calls.ideal_drives(self.native, (0.0, 0.0, 1.0))).max():.12g}")

    def unreachable(self, focus_m: npt.ArrayLike) -> str:
        """Why a focal point cannot be reached, in words; empty when it can."""
        (point,) = points_of("focus_m", focus_m)
        return self.native.unreachable(point)

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """The elements as the hand sees them. Options are those of matplotlib's plot."""
        return pictures.array_plot(self, ax, **options)

    def __reduce__(self) -> tuple[Callable[..., Array], tuple[Any, ...]]:
        return _array_again, (self._source,)

    def __len__(self) -> int:
        return len(self.native)

    def __repr__(self) -> str:
        return f"<Array {self.name}: {len(self)} × {self.transducer}>"


@dataclass(frozen=True, eq=False)
class Compiled:
    """An image with its manifest, for field(), analyze(), feel(), solve(), simulate() and Board.upload(). np.asarray(compiled) is foci_m.

    hex: the image as Intel HEX: the bytes that the program writes.
    manifest: the manifest as JSON text: what the program writes.
    foci_m: every focal point, n × 3, record by record.
    rate_hz: passes a second.
    warnings: what the compiler warned of, in sentences.
    """

    hex: bytes
    manifest: str
    foci_m: Numbers
    rate_hz: float
    warnings: tuple[str, ...]

    @property
    def image(self) -> Image:
        """As the client of boards has it."""
        return Image.from_bytes(self.hex)

    def save(self, file: FileName) -> None:
        """Writes the image, NAME.hex, and its manifest, NAME.json."""
        self.write_to(Path(file).parent, Path(file).name)

    def write_to(self, folder: Path, name: str = "image.hex") -> str:
        """The same into a folder; returns the image's name."""
        if not name.endswith(".hex"):
            raise usage("save", f"expected a name that ends in .hex, found {name!r}")
        (folder / name).write_bytes(self.hex)
        (folder / name).with_suffix(".json").write_text(self.manifest, encoding="utf-8")
        return str(folder / name)

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """The focal points in space, coloured in the order in which they play. Options are those of matplotlib's scatter."""
        return pictures.compiled_plot(self, ax, **options)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Numbers:
        found = self.foci_m if dtype is None else self.foci_m.astype(dtype, copy=False)
        return found.copy() if copy else found

    def __repr__(self) -> str:
        warned = f", {len(self.warnings)} warnings" if self.warnings else ""
        return f"<Compiled: {len(self.foci_m)} foci, {self.rate_hz:g} passes a second, {len(self.hex)} bytes of Intel HEX{warned}>"


@dataclass(frozen=True, eq=False)
class Drives:
    """What each element radiates, for field(), pressure() and analyze(): what solve() gives, or an own Drives(array, values_pa_m).

    array: an Array.
    values_pa_m: complex128, elements, or sets × elements that play in turn: pressure times distance on the element's axis, a peak amplitude with
        the time factor e^{jwt}. Full strength is array.full_pa_m. np.asarray(drives) is the same.
    weights: a number for each set, its share of the time; without it all are alike.
    foci: of solve(), a Table with a row for each focus: set, foci_m, amplitude, pressure_pa; and about each set spread, least_over_mean, efficiency.
    """

    array: Array
    values_pa_m: npt.NDArray[np.complex128]
    weights: Numbers | None = None
    foci: Table | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.array, Array):
            raise usage("array", f"expected an Array, found {kind(self.array)}")
        values = np.asarray(self.values_pa_m, dtype=complex)
        if values.ndim not in (1, 2) or values.shape[-1] != len(self.array):
            raise usage("values_pa_m", f"expected {len(self.array)} drives, or sets × {len(self.array)}, found {kind(self.values_pa_m)}")
        if not np.isfinite(values).all():
            raise usage("values_pa_m", "expected finite numbers, found nan or inf")
        object.__setattr__(self, "values_pa_m", values)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        found = self.values_pa_m if dtype is None else self.values_pa_m.astype(dtype, copy=False)
        return found.copy() if copy else found

    def __repr__(self) -> str:
        sets = f"{len(self.values_pa_m)} sets of drives" if self.values_pa_m.ndim == 2 else "drives"
        return f"<Drives: {sets} of {self.array!r}>"


def _array_again(source: str | Compiled | dict[str, Any]) -> Array:
    if not isinstance(source, dict):
        return Array(source)
    again = Array.__new__(Array)
    again._source = source
    with _work() as folder:
        again.native = calls.Array.find(again.file_in(folder))
    return again


Source: TypeAlias = Compiled | FileName | Array | Drives


def _array(given: object) -> Array:
    if isinstance(given, Array):
        return given
    if isinstance(given, str | os.PathLike | Compiled):
        return Array(given)
    raise usage("array", f"expected an Array, or the name or file of one, found {kind(given)}")


def array_names() -> list[str]:
    """The shipped arrays."""
    return calls.array_names()


# ---- what a user asks for


def _shapes(shape: object, own: dict[str, Any]) -> list[dict[str, Any]]:
    """The tables [[shape]] of a project."""
    found = []
    for each in shape if isinstance(shape, list | tuple) else [shape]:
        if isinstance(each, Mapping):
            found.append({**own, **each})
        elif isinstance(each, str | os.PathLike):
            found.append({**own, "file": Path(each).resolve()} if is_file(each) else {**own, "kind": each})
        else:
            raise usage("shape", f"expected the name of a built-in shape, a file, a dict, or a list of these, found {kind(each)}")
    return found


def _written_points(folder: Path, points_m: Any, times_s: Any, intensity: Any) -> dict[str, Any]:
    """The part of a project that plays points, with the file that they are in."""
    points = points_of("points_m", points_m)
    columns = [points.tolist()]
    for name, given in (("times_s", times_s), ("intensity", intensity)):
        if given is not None:
            columns.append(numbers(name, given).tolist())
            if np.shape(given) != (len(points),):
                raise usage(name, f"found {kind(given)} of {np.size(given)} for {len(points)} points; give one each")
    if times_s is None:
        if intensity is not None:
            raise usage("intensity", "is of points with times_s")
        (folder / "points.csv").write_text("".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()), encoding="utf-8")
        return {"points": len(points), "shape": [{"file": str(folder / "points.csv"), "unit": "m"}]}
    with open(folder / "points.csv", "w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time_s", "x_mm", "y_mm", "z_mm", *(["intensity"] if intensity is not None else [])])
        for place, time_s, *strength in zip(mm("points_m", points), *columns[1:], strict=True):
            rows.writerow([repr(time_s), *map(repr, place), *map(repr, strength)])
    return {"path": str(folder / "points.csv")}


def _project(given: object, settings: dict[str, Any]) -> tuple[dict[str, Any], Path]:
    """A project's table, and the folder from which its paths start."""
    if isinstance(given, Mapping):
        return {**given, **settings}, Path.cwd()
    if not isinstance(given, str | os.PathLike):
        raise usage("project", f"expected a file or a dict, found {kind(given)}")
    try:
        return {**tomllib.loads(Path(given).read_text(encoding="utf-8")), **settings}, Path(given).resolve().parent
    except (OSError, ValueError) as error:
        raise bad_input(str(given), str(getattr(error, "strerror", None) or error)) from None


def compile(*, points_m: npt.ArrayLike | None = None, times_s: npt.ArrayLike | None = None, intensity: npt.ArrayLike | None = None,
            shape: Any = None, path: FileName | Mapping[str, Any] | None = None, project: FileName | Mapping[str, Any] | None = None,
            array: Array | FileName | None = None, board: FileName | None = None, **settings: Any) -> Compiled:  # fmt: skip
    """Turns points, a shape, a path or a project into an image for a board. Give one of the four:

    points_m: n × 3. With times_s (n, rising) each point plays from its time to the next one's, with its intensity (n, 0 to 1) if that is given.
        Without times_s they are a shape: a short tour through them is played rate_hz times a second.
    shape: a built-in shape's name (point, line, circle, triangle, square, plus, polygon, sphere, hemisphere, cube, cone, cylinder, helix), a PLY, OBJ,
        STL, OFF, PCD, 3MF, glTF, SVG, XYZ or CSV file, a dict of a project's [[shape]], or a list of these.
    path: a path file (.json, .csv, .adaptics), or a path as a dict.
    project: a project file, or a project as a dict.

    array: an Array, a shipped one's name or a file; by default the board's, or tile-10x10.
    board: a shipped board, a board file or a configuration of the core, such as "tile-100-wide".
    settings: any other key of a project: points (how many, of a shape), rate_hz, speed_m_s, frequency_hz, am ("sine:200"), amplitude, even, clip,
        image ("foci" or "records"), …; of shapes diameter_m, length_m, height_m, sides, turns, unit, up; and of where they all go center_m (3), size_m,
        rotate_deg (3), scale. Settings replace a project's own.

    Lengths are metres; those in a dict have a name with _m, or with _mm as in files. A file's unit is "mm" unless you say unit="cm" or "m".

    Raises HaptogramError when a point is out of the array's reach, or the board cannot hold the image.
    """
    sources = {"points_m": points_m, "shape": shape, "path": path, "project": project}
    if len(given := [name for name, source in sources.items() if source is not None]) != 1:
        raise usage("compile", f"expected one of {', '.join(sources)}, found {' and '.join(given) or 'none'}")
    if points_m is None and (times_s is not None or intensity is not None):
        raise usage("times_s" if times_s is not None else "intensity", "belongs to points_m")
    if np.ndim(settings.get("points", 0)):
        raise usage("points", "is how many points a shape gets; the points themselves are points_m, n × 3 in metres")
    for name in settings:
        if name.endswith("_mm"):
            raise usage(name, f"lengths are metres: did you mean {name[:-1]}?")
    folder = Path.cwd()
    with _work() as work:
        own = {name: settings.pop(name) for name in OF_A_SHAPE if name in settings} if shape is not None else {}
        where = {name: settings.pop(name) for name in OF_THE_PLACE if name in settings} if shape is not None or points_m is not None else {}
        if board is not None:
            settings["board"] = str(Path(board).resolve()) if is_file(board) else board
        if array is not None:
            settings["array"] = _array(array).file_in(work)
        if where:
            settings["place"] = {**settings.get("place", {}), **where}
        if project is not None:
            if isinstance(project, str | os.PathLike) and not settings:
                return _compiled(calls.compile_project(str(project)))
            table, folder = _project(project, settings)
        elif points_m is not None:
            table = {**_written_points(work, points_m, times_s, intensity), **settings}
        elif shape is not None:
            table = {**settings, "shape": _shapes(shape, own)}
        elif isinstance(path, Mapping):
            (work / "path.json").write_text(json.dumps(millimetres("path.", path)), encoding="utf-8")
            table = {**settings, "path": str(work / "path.json")}
        else:
            table = {**settings, "path": str(Path(path).resolve())}  # type: ignore[arg-type]  # as `given` says
        text = toml_file("project", {"format": "haptogram-project-1", **millimetres("", table)})
        return _compiled(calls.compile_text(text, folder, "project"))


def _compiled(made: calls.Compiled) -> Compiled:
    return Compiled(made.hex, made.manifest, made.foci_m, made.rate_hz, tuple(made.warnings))


def _one_focus(focus_m: npt.ArrayLike | None) -> Numbers:
    if focus_m is None:
        raise usage("focus_m", "of an array it must be given where it focuses: (x, y, z) in metres")
    foci = points_of("focus_m", focus_m)
    if len(foci) != 1:
        raise usage("focus_m", f"expected one focus, found {len(foci)}; solve() makes several")
    return foci[0]  # type: ignore[no-any-return]


def _excitation(source: Source, focus_m: npt.ArrayLike | None, record: int, work: Path) -> calls.Excitation:
    """What makes the sound."""
    kinds = calls.Excitation
    if isinstance(source, Array):
        return kinds.of_focus(source.native, _one_focus(focus_m))
    if focus_m is not None:
        raise usage("focus_m", "is of an Array, which can focus anywhere")
    if isinstance(source, Drives):
        foci = None if source.foci is None else source.foci.foci_m
        return kinds.of_drives(source.array.native, np.atleast_2d(source.values_pa_m), source.weights, foci)
    return kinds.of_image(_image(source, work), record)


def _image(source: object, work: Path) -> str:
    """The file of what plays."""
    if isinstance(source, Compiled):
        return source.write_to(work)
    if isinstance(source, str | os.PathLike):
        return os.fspath(source)
    raise usage("source", f"expected what compile() gives, the file of an image, a manifest, a project or a shape, or an Array; found {kind(source)}")


def _region(x_m: Any, y_m: Any, z_m: Any, center_m: Any, rotate_deg: Any, normal: Any, volume: bool) -> dict[str, Any]:
    """The region of calls.field(): texts in millimetres, and ranges in metres."""
    fixed, ranges = {}, {}
    for name, given in (("x_m", x_m), ("y_m", y_m), ("z_m", z_m)):
        if given is None:
            continue
        number = metres(name, given)
        if number.shape not in ((), (2,)):
            raise usage(name, f"expected a number, or from and to, found {kind(given)}")
        if number.shape == ():
            fixed[name[0]] = mm(name, number)
        else:
            ranges[name] = tuple(number.tolist())
    if center_m is not None:
        if fixed or volume or (rotate_deg is None) == (normal is None):
            raise usage("center_m", "is of an oblique plane, which is told by it, by rotate_deg or normal, and by no other number")
        turned = numbers("normal" if rotate_deg is None else "rotate_deg", normal if rotate_deg is None else rotate_deg)
        if turned.shape != (3,):
            raise usage("normal" if rotate_deg is None else "rotate_deg", f"expected three numbers, found {kind(normal if rotate_deg is None else rotate_deg)}")
        at = dict(zip("xyz", mm("center_m", points_of("center_m", center_m)[0]), strict=True))
        at |= {f"{'n' if rotate_deg is None else 'r'}{axis}": angle for axis, angle in zip("xyz", turned.tolist(), strict=True)}
        return {"plane": "uv@" + ",".join(f"{name}={value!r}" for name, value in at.items()), **ranges}
    if rotate_deg is not None or normal is not None:
        raise usage("center_m", "is missing: rotate_deg and normal are of an oblique plane through it")
    free = "".join(axis for axis in "xyz" if axis not in fixed)
    if volume != (not fixed):
        raise usage("volume", "it has no fixed coordinate" if volume else "give a plane, such as z_m=0.13, a line, such as x_m=0, y_m=0, or volume=True")
    if volume:
        return {"volume": True, **ranges}
    if not free:
        raise usage("x_m", "that is a point; pressure() computes it")
    return {"plane" if len(free) == 2 else "line": f"{free}@" + ",".join(f"{axis}={value!r}" for axis, value in fixed.items()), **ranges}


def field(source: Source, *, focus_m: npt.ArrayLike | None = None, record: int = 0, x_m: Any = None, y_m: Any = None, z_m: Any = None,
          center_m: npt.ArrayLike | None = None, rotate_deg: npt.ArrayLike | None = None, normal: npt.ArrayLike | None = None, volume: bool = False,
          extent_m: float = 0.08, step_m: float = 0.001, quantity: str = "radiation", threads: int = 0) -> Field:  # fmt: skip
    """The sound field of what plays, on average over its sequence.

    source: what compile() gives; the file of an image, a manifest, a project or a shape; an Array with focus_m (3), which it focuses on at full strength;
        or Drives.
    record: only this record of an image, from 1; 0 is all in turn.
    x_m, y_m, z_m: a number where the region stays, or (from, to) where it spreads: z_m=0.13 is a plane, x_m=0, y_m=0 a line. An axis without either
        spreads over ±extent_m; z spreads from one step to twice extent_m.
    center_m (3) with rotate_deg (3: about x, then y, then z) or normal (3): an oblique plane through a point; x_m and y_m are then its own axes.
    volume: all three axes spread.
    step_m: between points.
    quantity: "radiation" (radiation pressure on skin, Pa), "rms" (sound pressure, Pa), "spl" (dB re 20 µPa), "velocity" (of the air, rms, m/s) or
        "complex" (complex peak pressure, Pa; of one set of drives).
    threads: 0 takes one a processor.

    Returns a Field.
    """
    region = _region(x_m, y_m, z_m, center_m, rotate_deg, normal, volume)
    sizes: dict[str, Any] = {"extent_m": float(metres("extent_m", extent_m)), "step_m": float(metres("step_m", step_m))}
    with _work() as work:
        excitation = _excitation(source, focus_m, record, work)
        found = calls.field(excitation, **region, **sizes, quantity=quantity, threads=threads)
        oblique = None if center_m is None else found.point_m(np.arange(found.values.size))
        return Field(found.values.squeeze(), found.x_m, found.y_m, found.z_m, found.quantity, pictures.LABELS[found.quantity], found.method, found.error,
                     excitation.array.level, oblique)  # fmt: skip


def workspace(array: Array | FileName, *, x_m: npt.ArrayLike, y_m: npt.ArrayLike, z_m: npt.ArrayLike) -> Field:
    """The pressure amplitude in Pa that a lone focus has at each point of straight axes: numbers, or arrays of metres. It is nan out of reach.

    Returns a Field with the quantity pressure_pa.
    """
    x, y, z = (np.atleast_1d(metres(name, axis)) for name, axis in (("x_m", x_m), ("y_m", y_m), ("z_m", z_m)))
    known = _array(array)
    with _work():
        values = calls.workspace(known.native, x, y, z)
    return Field(values.squeeze(), x, y, z, "pressure_pa", pictures.LABELS["pressure_pa"], "sums", 0.0, known.level)


def pressure(source: Array | Drives, points_m: npt.ArrayLike, *, focus_m: npt.ArrayLike | None = None, threads: int = 0) -> npt.NDArray[np.complex64]:
    """Complex peak pressure in Pa (complex64, n) at points (n × 3), by direct sums.

    source: Drives of one set, or an Array with focus_m (3), which it focuses on at full strength.
    """
    points = points_of("points_m", points_m)
    if not isinstance(source, Array | Drives):
        raise usage("source", f"expected Drives of one set, or an Array with focus_m; found {kind(source)}")
    with _work() as work:
        excitation = _excitation(source, focus_m, 0, work)
        if len(excitation.drives) != 1:
            raise usage("source", f"found {len(excitation.drives)} sets of drives, expected one")
        return calls.pressure(excitation.array, excitation.drives[0], points, threads=threads)


def _sets(foci_m: Any, amplitudes: Any) -> list[tuple[Numbers, Numbers]]:
    """Foci and amplitudes of each set."""
    given = numbers("foci_m", foci_m)
    if given.ndim not in (1, 2, 3) or given.shape[-1] != 3 or not given.size:
        raise usage("foci_m", f"expected foci × 3, or sets × foci × 3, found {kind(foci_m)}")
    sets = given if given.ndim == 3 else [given]
    strengths = np.ones(given.shape[:-1]) if amplitudes is None else numbers("amplitudes", amplitudes)
    if strengths.shape != given.shape[:-1]:
        raise usage("amplitudes", f"found {kind(amplitudes)} for {kind(given)}; give one for each focus")
    each = np.atleast_1d(strengths) if given.ndim < 3 else strengths
    return [(points_of("foci_m", foci), one) for foci, one in zip(sets, [each] if given.ndim < 3 else each, strict=True)]


def _played_foci(compiled: Compiled) -> tuple[list[tuple[Numbers, Numbers]], Numbers]:
    """Foci and amplitudes of each record, and how long it plays."""
    records = json.loads(compiled.manifest)["records"]
    sets = []
    for record in records:
        foci = record.get("foci") or [{"position_mm": record["focus_mm"], "amplitude": record.get("amplitude", 1.0)}]
        places = np.array([focus["position_mm"] for focus in foci], dtype=float) / 1000
        sets.append((places, np.array([focus.get("amplitude", 1.0) for focus in foci], dtype=float)))
    return sets, np.array([record.get("dwell_cycles", 1) for record in records], dtype=float)


def solve(source: Array | FileName | Compiled, foci_m: npt.ArrayLike | None = None, amplitudes: npt.ArrayLike | None = None, *,
          method: str = "gauss-newton", vary_amplitudes: bool = False, level: str = "reachable", rounds: int | None = None) -> Drives:  # fmt: skip
    """Drives that make several foci at the same time.

    source: an Array, a shipped one's name or a file; or what compile() gives, for the foci of each record, without foci_m.
    foci_m: foci × 3; or sets × foci × 3, each set solved by itself.
    amplitudes: a number from 0 to 1 for each focus; 0 holds the pressure down there.
    method: "gauss-newton", "weighted-gs", "gs", "gs-pat", "superposition", "distance-weighted" or "inverse-transform".
    vary_amplitudes: drives may differ in amplitude; otherwise all are at full strength.
    level: what amplitudes are fractions of: "reachable", the most that the array can make there, or "pressure", one for all.
    rounds: of an iterating method; by default 10 of gauss-newton, 100 of others.

    Returns Drives, in Pa m. Raises HaptogramError for a focus out of the array's reach.
    """
    array = _array(source)
    weights = None
    if isinstance(source, Compiled):
        if foci_m is not None or amplitudes is not None:
            raise usage("foci_m", "what was compiled has its own foci; give its array instead, haptogram.Array(compiled)")
        sets, weights = _played_foci(source)
    elif foci_m is None:
        raise usage("foci_m", "give the foci, n × 3 in metres")
    else:
        sets = _sets(foci_m, amplitudes)
    found, tables = [], []
    with _work():
        for places, strengths in sets:
            drives = calls.solve(array.native, places, strengths, method=method, vary_amplitudes=vary_amplitudes, level=level, rounds=rounds)
            found.append(drives * array.full_pa_m)
            tables.append(calls.quality(array.native, places, drives, strengths, level=level))
    alone = foci_m is not None and np.ndim(foci_m) < 3
    columns = {
        "set": np.repeat(np.arange(len(sets)), [len(places) for places, _ in sets]),
        "foci_m": np.concatenate([places for places, _ in sets]),
        "amplitude": np.concatenate([strengths for _, strengths in sets]),
        "pressure_pa": np.concatenate([one.pressure_pa for one in tables]),
    }
    about = {name: [getattr(one, name) for one in tables] for name in ("spread", "least_over_mean", "efficiency", "null_share")}
    foci = Table("focus", columns, {name: values[0] if alone else values for name, values in about.items()} | {"level": array.level})
    return Drives(array, found[0] if alone else np.array(found), weights, foci)


def analyze(source: Source, *, focus_m: npt.ArrayLike | None = None, least_force_n: float = 0.58e-3) -> Table:
    """What each focus is like while it plays alone, and how loud it all is.

    source: what compile() gives; the file of an image, a manifest, a project or a shape; an Array with focus_m (3); or Drives of one set from solve().
    least_force_n: it warns of foci with less, N.

    Returns a Table with a row for each focus: foci_m, pressure_pa (amplitude at the asked point), radiation_pa, width_m and depth_m (full, at half of the
    radiation pressure), side_lobe (over the peak), force_n (on a disc of 20 mm), formation_s. Of what plays also dwell_cycles and dwell_needed_cycles, and
    about it all highest_db (dB SPL on the axis: a model, no certification), pressure_left_least (by the transducers' bandwidth), level and warnings.
    """
    names = ["foci_m", "pressure_pa", "radiation_pa", "width_m", "depth_m", "side_lobe", "force_n", "formation_s"]
    with _work() as work:
        if not isinstance(source, Array | Drives):
            if focus_m is not None:
                raise usage("focus_m", "is of an Array, which can focus anywhere")
            all_ = calls.analyze(_image(source, work), least_force_n)
            columns = {name: getattr(all_, name) for name in [*names, "dwell_cycles", "dwell_needed_cycles"]}
            return Table("focus", columns, {name: getattr(all_, name) for name in ("highest_db", "pressure_left_least", "level", "warnings")})
        excitation = _excitation(source, focus_m, 0, work)
        if isinstance(source, Array):
            foci = points_of("focus_m", focus_m)
        elif source.foci is None or source.values_pa_m.ndim != 1:
            raise usage("source", "expected Drives of one set from solve(), which know their foci")
        else:
            foci = source.foci.foci_m
        each = [calls.analyze_focus(excitation.array, excitation.drives[0], focus) for focus in foci]
        rows = {name: np.array([getattr(one, name) for one in each]) for name in names[1:]}
        return Table("focus", {"foci_m": foci, **rows}, {"level": excitation.array.level})


def _metric(key: str, value: Any) -> tuple[str, Any]:
    """A member of a report with its lengths in metres and its forces in newtons."""
    if isinstance(value, dict):
        return key, dict(_metric(*item) for item in value.items())
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return key, [_metric(key, each)[1] for each in value]
    ending = key[-3:]
    if ending not in ("_mm", "_mn") or not isinstance(value, int | float | list):
        return key, value
    return key[:-2] + ending[-1], (np.array(value) / 1000 if isinstance(value, list) else value / 1000)


def _table(rows: str, found: list[dict[str, Any]], about: dict[str, Any]) -> Table:
    """A column is of numbers where all rows have one, of places where they have three, and else of whatever they have."""
    columns = {}
    for name in dict.fromkeys(key for row in found for key in row):
        values = [row.get(name) for row in found]
        if not all(isinstance(value, bool | int | float) or getattr(value, "shape", ()) == (3,) for value in values):
            column = np.empty(len(values), dtype=object)
            column[:] = values
            columns[name] = column
        else:
            columns[name] = np.array(values)
    return Table(rows, columns, about)


def _program_said(code: ErrorCode, about: str, said: str) -> HaptogramError:
    """Its message as an error, with the place that it names."""
    message = _one_line(said).removeprefix("haptogram: ")
    where, _, rest = message.partition(": ")
    return HaptogramError(code, where.removeprefix("--"), rest) if rest and " " not in where else HaptogramError(code, about, message)


def _report(verb: str, source: Source, focus_m: npt.ArrayLike | None, options: Mapping[str, Any]) -> dict[str, Any]:
    """What a command of the program reports as JSON, in metres and newtons."""
    with _work() as work:
        words = [find_program(), verb, "--json"]
        if isinstance(source, Array):
            place = ",".join(map(repr, mm("focus_m", _one_focus(focus_m))))
            words += [f"--focus={place}", f"--array={source.file_in(work)}"]
        elif focus_m is not None:
            raise usage("focus_m", "is of an Array, which can focus anywhere")
        else:
            words.append(_image(source, work))
        for name, value in options.items():
            words += [f"--{name}={each}" for each in (value if isinstance(value, list) else [value]) if value is not None]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            said = [line for line in done.stderr.replace(f"{work}/", "").splitlines() if not line.startswith("haptogram: warning:")]
            code = ErrorCode(done.returncode) if done.returncode in (1, 2, 3, 4) else ErrorCode.RUN_FAILED
            raise _program_said(code, verb, "\n".join(said) or f"the program ended with {done.returncode}")
        found: dict[str, Any] = _metric("", json.loads(done.stdout))[1]
        return found


def _lengths(where: str, places: npt.ArrayLike | None) -> list[str] | None:
    return None if places is None else [",".join(map(repr, point)) for point in mm(where, points_of(where, places))]


def feel(source: Compiled | FileName | Array, *, focus_m: npt.ArrayLike | None = None, at_m: npt.ArrayLike | None = None, places: int | None = None,
         normal: npt.ArrayLike | None = None, contact_m: float | None = None, ears_m: npt.ArrayLike | None = None, region: str | None = None,
         grip_n: float | None = None) -> Table:  # fmt: skip
    """What a hand is expected to feel of what plays, and an ear to hear: models, nothing was measured on people.

    source: what compile() gives; the file of an image, a manifest, a project or a shape; or an Array with focus_m (3).
    at_m: places on the skin, n × 3; by default the foci, of which `places` (8) are chosen evenly.
    normal: out of the skin, 3; by default (0, 0, -1), towards the array.
    contact_m: diameter of the skin whose force is compared (0.02).
    ears_m: where ears are, n × 3; by default (0, -0.4, 0.3).
    region: "palm" or "finger".
    grip_n: force that the hand holds at the same time, N (1).

    Returns a Table with a row for each place: at_m, mean_pa, most_pa, mean_n, modulation_depth, lines (a list for each place: hz, force_n, least_n, over_db,
    strongest first), …; about it all answer ("felt", "perhaps" or "not felt"), ears, loudest_at_500_mm, noise, level, warnings, ….
    """
    facing = None if normal is None else ",".join(map(repr, numbers("normal", normal).tolist()))
    contact = None if contact_m is None else mm("contact_m", contact_m)
    options = {"at": _lengths("at_m", at_m), "places": places, "normal": facing, "contact": contact, "ear": _lengths("ears_m", ears_m), "region": region,
               "grip": grip_n}  # fmt: skip
    about = _report("feel", source, focus_m, options)
    return _table("place", about.pop("places"), about)


def simulate(source: Compiled | FileName, *, passes: int | None = None, duration_s: float | None = None, load: str | None = None) -> Table:
    """Plays an image on the Verilated FPGA and measures its pins.

    source: what compile() gives; the file of an image, a manifest, a project or a shape.
    passes: over the sequence (1); or duration_s, for how long it plays.
    load: "uart", through the simulated serial line, or "direct", straight into the memories.

    Returns a Table with a row for each record: index, cycles, pressure_pa, pressure_kept (by the ticks), focus_error_m, …; about it all pulses,
    pulses_equal_to_image, contract_violations, worst_focus_error_m, simulated_s, ….
    Raises HaptogramError when a contract is broken or a focus is off.
    """
    options = {"passes": passes, "duration": None if duration_s is None else float(f"{1000 * duration_s:.15g}"), "load": load}
    about = _report("simulate", source, None, options)
    return _table("record", about.pop("records"), about)


@contextlib.contextmanager
def simulated_board(board: str = "tile-100-wide", *, model: str = "reference") -> Iterator[str]:
    """A simulated board, whose port Board.open() takes. It ends with the block.

    board: a shipped board, a board file or a configuration of the core; "tile-100-wide" computes foci.
    model: "reference", as fast as a real board, or "rtl", the Verilated FPGA.
    """
    with tempfile.TemporaryDirectory(prefix="haptogram-") as folder, open(Path(folder, "said"), "w+", encoding="utf-8") as said:
        words = [find_program(), "board", "run", "--board", str(Path(board).resolve()) if is_file(board) else board, "--model", model]
        with subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=said, text=True) as process:
            try:
                assert process.stdout is not None
                if not (port := process.stdout.readline().strip()):
                    said.seek(0)
                    raise _program_said(ErrorCode.RUN_FAILED, board, said.read())
                yield port
            finally:
                process.terminate()
