# SPDX-License-Identifier: Apache-2.0
"""The computing functions of the C++ library, on numpy. Lengths are metres, pressures are complex peak values in Pa with the time factor e^{jwt}, and drives
are complex source strengths in Pa m. Numpy's memory is passed as it is, and results are views of the library's. Other threads run while anything computes,
and Ctrl-C ends the work."""
from __future__ import annotations

import functools
import json
import os
import threading
import weakref
from collections.abc import Callable, Sequence
from ctypes import POINTER, byref, c_double, c_int32, c_void_p, create_string_buffer, pointer
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import native, pictures
from .errors import BadArgument, BadInput, DeviceError, ErrorCode, Failed, HaptogramError
from .library import call, library, sized

__all__ = ["Array", "BadArgument", "BadInput", "Compiled", "DeviceError", "Excitation", "Failed", "Field", "FocusAnalysis", "HaptogramError", "ImageAnalysis",
           "MeanSquareField", "Pose", "PressureField", "Quality", "analyze", "analyze_focus", "array_names", "compile_project", "compile_text", "field",
           "gradient", "ideal_drives", "join", "mean_square", "mean_square_on", "pressure", "pressure_on", "quality", "solve", "workspace"]  # fmt: skip
Point: TypeAlias = Sequence[float] | NDArray[Any]
Range: TypeAlias = tuple[float, float] | None
QUICK_WAVES = 1e7  # elements × points: some ten milliseconds
KINDS = {ErrorCode.RUN_FAILED: Failed, ErrorCode.USAGE: BadArgument, ErrorCode.BAD_INPUT: BadInput, ErrorCode.DEVICE: DeviceError}


# ---- the library's memory


class _Owned:
    """A handle of the library's, freed when nothing refers to it any more."""

    def __init__(self, kind: str, handle: c_void_p) -> None:
        self.value = handle.value
        weakref.finalize(self, getattr(library(), f"haptogram_free_{kind}"), self.value).atexit = False

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("cannot be pickled: it is in the library's memory")


def _view(owner: _Owned, address: int, kind: np.dtype[Any], shape: tuple[int, ...], *, readonly: bool = False) -> NDArray[Any]:
    """Numbers in the library's memory, whose owner numpy keeps."""
    interface = {"version": 3, "data": (address, readonly), "typestr": kind.str, "shape": shape}
    return np.asarray(SimpleNamespace(owner=owner, __array_interface__=interface)) if all(shape) else np.empty(shape, kind)


def _call(name: str, *given: Any) -> None:
    try:
        call(name, *given)
    except HaptogramError as error:
        raise KINDS[error.code](error.code, error.where, error.message, error.remedies) from None


def _call_until_signal(name: str, request: Any, *given: Any, quick: bool = False) -> None:
    """In a thread of its own, so that this one, to which signals come, can cancel it. It ends soon after, so the request has to keep what it points to. A thread
    takes longer than what is quick."""
    if quick or threading.current_thread() is not threading.main_thread():
        _call(name, byref(request), *given)
        return
    cancel, failed = c_int32(), list[BaseException]()
    request.cancel = pointer(cancel)

    def work() -> None:
        try:
            _call(name, byref(request), *given)
        except BaseException as error:  # noqa: BLE001  # which is raised below
            failed.append(error)

    thread = threading.Thread(target=work, name=f"haptogram_{name}")
    try:
        thread.start()
        thread.join()
    except BaseException:
        cancel.value = 1
        raise
    if failed:
        raise failed[0]


def _bytes(name: str, *given: Any) -> bytes:
    function = getattr(library(), f"haptogram_{name}")
    size = function(*given, None, 0)
    to = create_string_buffer(size)
    function(*given, to, size)
    return to.raw


def _text(name: str, *given: Any) -> str:
    return _bytes(name, *given).decode("utf-8", "backslashreplace")


class _Result:
    """What a function gives, as numpy and Python have it."""

    def __init__(self, name: str, *given: Any, by: Callable[..., None] = _call) -> None:
        by(name, *given, byref(handle := c_void_p()))
        self.owned = _Owned("result", handle)
        self.about: dict[str, Any] = json.loads(_text("result_json", handle))

    @property
    def numbers(self) -> NDArray[Any]:
        return _view(self.owned, library().haptogram_result_numbers(self.owned.value), np.dtype(self.about["type"]), tuple(self.about["shape"]))


# ---- numpy's memory


ROW, POINTS, THREE = ("an array of one dimension", (None,)), ("an array of points × 3", (None, 3)), ("three numbers", (3,))


def _numbers(value: ArrayLike, setting: str, what: tuple[str, tuple[int | None, ...]] = ROW, kind: type = float) -> NDArray[Any]:
    array: NDArray[Any] = np.asarray(value, dtype=kind, order="C")
    if array.ndim != len(what[1]) or any(count not in (None, found) for count, found in zip(what[1], array.shape, strict=True)):
        raise BadArgument(ErrorCode.USAGE, setting, f"expected {what[0]}, found {' × '.join(map(str, array.shape)) or 'a single number'}")
    return array


def _doubles(array: NDArray[Any] | None) -> Any:
    """Its memory, which lives as long as the array."""
    return None if array is None else array.ctypes.data_as(POINTER(c_double))


# ---- arrays


@final
class Pose:
    """Where something is and how it is turned: an origin and three axes."""

    def __init__(self, origin_m: Point, angles_deg: Point = (0.0, 0.0, 0.0)) -> None:
        """Turned by degrees about the fixed x, then y, then z axis, and then moved to origin_m."""
        self._placed = np.concatenate([_numbers(origin_m, "origin_m", THREE), _numbers(angles_deg, "angles_deg", THREE)])
        (ca, cb, cc), (sa, sb, sc) = np.cos(angles := np.radians(self._placed[3:])), np.sin(angles)
        about_x, about_y, about_z = [[1, 0, 0], [0, ca, -sa], [0, sa, ca]], [[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]], [[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]]
        self._axes = np.transpose(np.linalg.multi_dot([about_z, about_y, about_x]))

    def outwards(self, points_m: ArrayLike) -> NDArray[np.float64]:
        """Points (n × 3) in the pose's own coordinates, in the surrounding ones."""
        found: NDArray[np.float64] = self._placed[:3] + _numbers(points_m, "points_m", POINTS) @ self._axes
        return found

    __repr__ = pictures.pose_repr


@final
@dataclass(frozen=True, eq=False, repr=False)
class Array:
    """Transducers that play together, and the air in front of them. Never changes.

    positions_m, normals: elements × 3: read-only views.
    transducer: the kind of its elements.
    level: what pressures and forces rest on, in a sentence that begins with nominal or calibrated.
    """

    name: str
    carrier_hz: float
    wavelength_m: float
    transducer: str
    level: str
    positions_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    _owned: _Owned

    @staticmethod
    def find(name: str) -> Array:
        """Reads an array file (TOML), or a shipped array."""
        return _made_array(name=os.fsencode(name))

    def with_elements(self, positions_m: ArrayLike, normals: ArrayLike | None = None) -> Array:
        """The same transducers and air with other elements; without normals they all face +z."""
        places, facing = _numbers(positions_m, "positions_m", POINTS), None if normals is None else _numbers(normals, "normals", POINTS)
        if facing is not None and len(facing) != len(places):
            raise BadArgument(ErrorCode.USAGE, "normals", f"found {len(facing)} for {len(places)} elements; give one each")
        return _made_array(like=self._owned.value, positions_m=_doubles(places), normals=_doubles(facing), elements=len(places))

    def with_transducer(self, name: str) -> Array:
        """The same elements of another kind: a transducer file (TOML), or a shipped transducer."""
        return _made_array(like=self._owned.value, transducer=os.fsencode(name))

    def seen_from(self, pose: Pose) -> Array:
        """The array in the coordinates of a pose. An oblique plane is an even one there."""
        return _made_array(like=self._owned.value, seen_from=_doubles(pose._placed))

    def unreachable(self, focus_m: Point) -> str:
        """Why a focal point cannot be reached, in words; empty when it can."""
        return _text("unreachable", self._owned.value, _doubles(_numbers(focus_m, "focus_m", THREE)))

    plot = pictures.array_plot

    def __len__(self) -> int:
        return len(self.positions_m)

    def __repr__(self) -> str:
        return f"<Array {self.name}: {len(self)} × {self.transducer}>"


def _array(handle: c_void_p) -> Array:
    owned = _Owned("array", handle)
    about = json.loads(_text("array_json", owned.value))
    elements = _view(owned, library().haptogram_array_elements(owned.value), np.dtype(float), (about.pop("elements"), 9), readonly=True)
    return Array(**about, positions_m=elements[:, :3], normals=elements[:, 3:6], _owned=owned)


def _made_array(**source: Any) -> Array:
    _call("make_array", byref(sized(native.ArraySource, **source)), byref(handle := c_void_p()))
    return _array(handle)


def array_names() -> list[str]:
    """The shipped arrays."""
    return _text("array_names").splitlines()


def join(arrays: Sequence[tuple[Array, Pose]], name: str = "rig") -> Array:
    """Several arrays, each in its pose, as one array."""
    parts = (native.PosedArray * len(arrays))(*[native.PosedArray(array._owned.value, _doubles(pose._placed)) for array, pose in arrays])
    _call("join", parts, len(arrays), name.encode(), byref(handle := c_void_p()))
    return _array(handle)


# ---- images


@final
@dataclass(frozen=True, eq=False, repr=False)
class Compiled:
    """An image with its manifest.

    hex: the image as Intel HEX: the bytes that the program writes.
    manifest: the manifest as JSON text: what the program writes.
    foci_m: every focal point (n × 3), record by record.
    """

    hex: bytes
    manifest: str
    foci_m: NDArray[np.float64]
    rate_hz: float
    warnings: list[str]
    _owned: _Owned

    def save(self, image: str) -> None:
        """Writes the image, and its manifest beside it."""
        _call("save_image", self._owned.value, os.fsencode(image))

    plot = pictures.compiled_plot
    __repr__ = pictures.compiled_repr


def _compiled(**project: Any) -> Compiled:
    _call_until_signal("compile", sized(native.Project, **project), byref(handle := c_void_p()))
    owned = _Owned("image", handle)
    foci = np.empty(library().haptogram_image_foci(owned.value, None, 0))
    library().haptogram_image_foci(owned.value, _doubles(foci), len(foci))
    manifest, warnings = (_text(f"image_{what}", owned.value) for what in ("manifest", "warnings"))
    rate_hz = json.loads(manifest)["rendering"]["rate_hz"]
    return Compiled(_bytes("image_hex", owned.value), manifest, foci.reshape(-1, 3), rate_hz, warnings.split("\n") if warnings else [], owned)


def compile_project(path: str) -> Compiled:
    """Compiles a project file."""
    return _compiled(file=os.fsencode(path))


def compile_text(toml: str, folder: str | os.PathLike[str] = "", name: str = "project") -> Compiled:
    """Compiles the text of a project file. Relative paths in it start from folder; name is for messages."""
    return _compiled(toml=toml.encode(), folder=os.fsencode(folder), name=name.encode())


# ---- what makes a sound field


@final
@dataclass(frozen=True, eq=False, repr=False)
class Excitation:
    """What makes a sound field: sets of drives, each for its share of the time.

    drives: sets × elements (complex128), Pa m.
    weights: of each set.
    """

    array: Array
    drives: NDArray[np.complex128]
    weights: NDArray[np.float64]

    @staticmethod
    def of_image(image: str, record: int = 0, manifest: str = "") -> Excitation:
        """Of an image (.hex), a manifest (.json) or a project (.toml); record 0 is all in turn."""
        return _excitation(file=os.fsencode(image), record=record, manifest=os.fsencode(manifest))

    @staticmethod
    def of_compiled(compiled: Compiled, record: int = 0) -> Excitation:
        """Of an image that was just compiled."""
        return _excitation(image=compiled._owned.value, record=record)

    @staticmethod
    def of_focus(array: Array, focus_m: Point) -> Excitation:
        """Exact phases for one focal point, at full strength."""
        return _excitation(array=array._owned.value, focus_m=_doubles(_numbers(focus_m, "focus_m", THREE)))

    @staticmethod
    def of_drives(array: Array, drives: ArrayLike, weights: ArrayLike | None = None, foci_m: ArrayLike | None = None) -> Excitation:
        """Of sets × elements of drives (Pa m), each for its weight's share of the time; foci are for pictures."""
        sets = np.array(drives, dtype=complex, order="C")
        if sets.ndim != 2 or sets.shape[1] != len(array):
            raise BadArgument(ErrorCode.USAGE, "drives", f"expected an array of sets × {len(array)}, the array's elements")
        shares = np.ones(len(sets)) if weights is None else np.array(_numbers(weights, "weights"))
        if len(shares) != len(sets):
            raise BadArgument(ErrorCode.USAGE, "weights", f"found {len(shares)} for {len(sets)} sets of drives; give one each")
        if foci_m is not None:
            _numbers(foci_m, "foci_m", POINTS)
        return Excitation(array, sets, shares)

    @staticmethod
    def of_pulses(pulses: str, manifest: str) -> Excitation:
        """Of pulses that were measured at the pins."""
        return _excitation(pulses=os.fsencode(pulses), manifest=os.fsencode(manifest))

    __repr__ = pictures.excitation_repr


def _excitation(**source: Any) -> Excitation:
    quick = "file" not in source and "pulses" not in source
    found = _Result("drives", sized(native.Source, **source), byref(array := c_void_p()), by=functools.partial(_call_until_signal, quick=quick))
    return Excitation(_array(array), found.numbers, np.array(found.about["weights"], dtype=float))


def ideal_drives(array: Array, focus_m: Point) -> NDArray[np.complex128]:
    """Drives (complex128, one an element) that focus with full strength."""
    found: NDArray[np.complex128] = Excitation.of_focus(array, focus_m).drives[0]
    return found


# ---- fields


@final
@dataclass(frozen=True, eq=False, repr=False)
class PressureField:
    """Complex pressures on a grid, and how far they may be off.

    values: complex64, z × y × x.
    method: sums, shifts or interpolated.
    error: of the largest |p| that the drives, with any phases, could make at any of the points.
    pattern_error: of the directivity, relative to the amplitude on the axis.
    """

    values: NDArray[np.complex64]
    method: str
    error: float
    pattern_error: float
    __repr__ = pictures.grid_repr


@final
@dataclass(frozen=True, eq=False, repr=False)
class MeanSquareField:
    """Mean squares on a grid, and how far they may be off.

    values: float32, z × y × x, Pa².
    method: sums, shifts or interpolated.
    error: of the rms pressure: of the largest that the drives, with any phases, could make.
    """

    values: NDArray[np.float32]
    method: str
    error: float
    __repr__ = pictures.grid_repr


@final
@dataclass(frozen=True, eq=False, repr=False)
class Field:
    """A quantity over a line, a plane or a volume.

    values: z × y × x: float32, or complex64 of a complex field.
    method: sums, shifts or interpolated.
    error: of the largest pressure, or velocity, that the drives, with any phases, could make.
    """

    values: NDArray[Any]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    z_m: NDArray[np.float64]
    quantity: str
    method: str
    error: float
    _pose: NDArray[np.float64] | None
    _result: _Result

    def point_m(self, index: int | NDArray[np.integer[Any]]) -> NDArray[np.float64]:
        """Where a point lies in the array's frame, counted as in values.ravel(); of several points a row each."""
        if np.min(index) < 0 or np.max(index) >= self.values.size:
            raise BadArgument(ErrorCode.USAGE, "index", f"found {np.max(index)}; the field has {self.values.size} points")
        z, y, x = np.unravel_index(index, self.values.shape)
        own = np.stack([self.x_m[x], self.y_m[y], self.z_m[z]], axis=-1)
        found: NDArray[np.float64] = own if self._pose is None else self._pose[0] + own @ self._pose[1:]
        return found

    def to_npy(self) -> bytes:
        """The bytes of the program's .npy file."""
        return _Result("field_file", self._result.owned.value, b"npy").numbers.tobytes()

    def to_csv(self) -> str:
        """The text of the program's .csv file."""
        return _Result("field_file", self._result.owned.value, b"csv").numbers.tobytes().decode()

    plot = pictures.field_plot
    __repr__ = pictures.field_repr


def _computed(quantity: str, array: Array, drives: NDArray[Any] | None = None, weights: NDArray[Any] | None = None, points: float = 1.0, **where: Any) -> _Result:
    """Drives are a set, or sets × elements. Arrays among what says where come with their sizes; a region has some `points`."""
    request = sized(native.Field, quantity=quantity.encode(), array=array._owned.value, weights=_doubles(weights))
    if drives is not None:
        request.drives, request.elements, request.sets = _doubles(drives), drives.shape[-1], drives.size // (drives.shape[-1] or 1)
    request.kept = array, drives, weights, where
    waves = points * (len(array) if drives is None else drives.size)
    for name, value in where.items():
        if isinstance(value, np.ndarray):
            setattr(request, "points" if name == "points_m" else f"{name[0]}_count", len(value))
            waves, value = waves * len(value), _doubles(value)
        setattr(request, name, value)
    return _Result("compute_field", request, by=functools.partial(_call_until_signal, quick=waves < QUICK_WAVES))


def _axes(x_m: ArrayLike, y_m: ArrayLike, z_m: ArrayLike) -> dict[str, Any]:
    return {name: _numbers(axis, name) for name, axis in (("x_m", x_m), ("y_m", y_m), ("z_m", z_m))}


def _sets(drives: ArrayLike, weights: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    sets, shares = np.asarray(drives, dtype=complex, order="C"), _numbers(weights, "weights")
    if sets.ndim != 2 or len(sets) != len(shares):
        raise BadArgument(ErrorCode.USAGE, "drives", f"expected an array of {len(shares)} × elements, a row for each weight")
    return sets, shares


def pressure(array: Array, drives: ArrayLike, points_m: ArrayLike, *, threads: int = 0, pattern_error: float = 0.0) -> NDArray[np.complex64]:
    """Complex pressure (complex64) at points (n × 3)."""
    return _computed("complex", array, _numbers(drives, "drives", kind=complex), points_m=_numbers(points_m, "points_m", POINTS), threads=threads, pattern_error=pattern_error).numbers


def pressure_on(array: Array, drives: ArrayLike, x_m: ArrayLike, y_m: ArrayLike, z_m: ArrayLike, *, threads: int = 0, interpolation_error: float = 1e-4,
                pattern_error: float = 0.0) -> PressureField:  # fmt: skip
    """Complex pressure on straight axes, by the quickest method."""
    found = _computed("complex", array, _numbers(drives, "drives", kind=complex), **_axes(x_m, y_m, z_m), threads=threads, interpolation_error=interpolation_error,
                      pattern_error=pattern_error)  # fmt: skip
    return PressureField(found.numbers, *(found.about[name] for name in ("method", "error", "pattern_error")))


def gradient(array: Array, drives: ArrayLike, points_m: ArrayLike, *, threads: int = 0, pattern_error: float = 0.0) -> NDArray[np.complex64]:
    """Gradient of the complex pressure (complex64, n × 3), Pa/m."""
    return _computed("gradient", array, _numbers(drives, "drives", kind=complex), points_m=_numbers(points_m, "points_m", POINTS), threads=threads, pattern_error=pattern_error).numbers


def mean_square(array: Array, drives: ArrayLike, weights: ArrayLike, points_m: ArrayLike, *, threads: int = 0) -> NDArray[np.float32]:
    """Mean square of the pressure (float32), Pa²: drives are sets × elements, with a weight each."""
    return _computed("mean_square", array, *_sets(drives, weights), points_m=_numbers(points_m, "points_m", POINTS), threads=threads).numbers


def mean_square_on(array: Array, drives: ArrayLike, weights: ArrayLike, x_m: ArrayLike, y_m: ArrayLike, z_m: ArrayLike, *, threads: int = 0,
                   interpolation_error: float = 1e-4) -> MeanSquareField:  # fmt: skip
    """The same on straight axes: a line, a plane or a volume; oblique ones by Array.seen_from()."""
    found = _computed("mean_square", array, *_sets(drives, weights), **_axes(x_m, y_m, z_m), threads=threads, interpolation_error=interpolation_error)
    return MeanSquareField(found.numbers, found.about["method"], found.about["error"])


def workspace(array: Array, x_m: ArrayLike, y_m: ArrayLike, z_m: ArrayLike) -> NDArray[np.float32]:
    """Pressure amplitude (float32, z × y × x) that a lone focus has at each point; NaN out of reach."""
    return _computed("workspace", array, **_axes(x_m, y_m, z_m)).numbers


def field(excitation: Excitation, *, plane: str | None = None, line: str | None = None, volume: bool = False, extent_m: float = 0.08, step_m: float = 0.001,
          x_m: Range = None, y_m: Range = None, z_m: Range = None, quantity: str = "radiation", threads: int = 0) -> Field:  # fmt: skip
    """The sound field of an excitation, as the program computes it. Regions are texts in mm: xy@z=130."""
    regions = {"plane": plane, "line": line, "volume": "xyz" if volume else None}
    given = {name: text for name, text in regions.items() if text is not None} or {"plane": "xy@z=130"}
    if len(given) > 1:
        raise BadArgument(ErrorCode.USAGE, "plane", "found more than one of plane, line and volume; give one")
    ((name, text),) = given.items()
    ranges = {axis: _numbers(both, axis) for axis, both in (("x_m", x_m), ("y_m", y_m), ("z_m", z_m)) if both is not None}
    span = max([2.0 * extent_m, *(np.ptp(both) for both in ranges.values())])
    points = (span / max(step_m, 1e-9)) ** {"line": 1, "plane": 2, "volume": 3}[name]
    found = _computed(quantity, excitation.array, excitation.drives, excitation.weights, points, region=text.encode(), region_name=name.encode(),
                      extent_m=extent_m, step_m=step_m, threads=threads, **ranges)  # fmt: skip
    about, pose = found.about, found.about.get("pose")
    x, y, z = (np.array(about[axis], dtype=float) for axis in ("x_m", "y_m", "z_m"))
    return Field(found.numbers, x, y, z, about["quantity"], about["method"], about["error"], None if pose is None else np.array(pose, dtype=float), found)


# ---- several foci


@final
@dataclass(frozen=True, eq=False, repr=False)
class Quality:
    """How good the foci are that some drives make, by direct sums.

    null_share: how much of what the array can make is left at foci of amplitude 0, the most; None without such.
    """

    pressure_pa: NDArray[np.float64]
    spread: float
    least_over_mean: float
    efficiency: float
    null_share: float | None
    __repr__ = pictures.quality_repr


def _foci(name: str, array: Array, foci_m: ArrayLike, amplitudes: ArrayLike | None, drives: ArrayLike | None, setting: str, level: str, **more: Any) -> _Result:
    places = _numbers(foci_m, "foci_m", POINTS)
    strengths = np.ones(len(places)) if amplitudes is None else _numbers(amplitudes, "amplitudes")
    if len(strengths) != len(places):
        raise BadArgument(ErrorCode.USAGE, "amplitudes", f"found {len(strengths)} for {len(places)} foci; give one each")
    both, given = np.column_stack([places, strengths]), None if drives is None else _numbers(drives, setting, kind=complex)
    return _Result(name, byref(sized(native.Foci, array=array._owned.value, foci=both.ctypes.data_as(POINTER(native.Focus)), count=len(both), level=level.encode(),
                                     drives=_doubles(given), elements=0 if given is None else len(given), **more)))  # fmt: skip


def solve(array: Array, foci_m: ArrayLike, amplitudes: ArrayLike | None = None, *, method: str = "gauss-newton", vary_amplitudes: bool = False,
          level: str = "reachable", rounds: int | None = None, start: ArrayLike | None = None) -> NDArray[np.complex128]:  # fmt: skip
    """Drives (complex128, 1 at full strength) that make several foci (n × 3) at the same time."""
    many = 0 if rounds is None else rounds or -1
    return _foci("solve_foci", array, foci_m, amplitudes, start, "start", level, method=method.encode(), vary_amplitudes=vary_amplitudes, rounds=many).numbers


def quality(array: Array, foci_m: ArrayLike, drives: ArrayLike, amplitudes: ArrayLike | None = None, *, level: str = "reachable") -> Quality:
    """How good the foci are that some drives make."""
    about = _foci("quality", array, foci_m, amplitudes, drives, "drives", level).about
    return Quality(**{**about, "pressure_pa": np.array(about["pressure_pa"], dtype=float)})


# ---- analyses


@final
@dataclass(frozen=True, eq=False, repr=False)
class FocusAnalysis:
    """What a focal point is like while it plays alone.

    pressure_pa: amplitude at the asked point.
    width_m: full width at half of the radiation pressure.
    side_lobe: highest radiation pressure beside it, over its peak.
    """

    pressure_pa: float
    radiation_pa: float
    width_m: float
    depth_m: float
    side_lobe: float
    force_n: float
    formation_s: float
    __repr__ = pictures.focus_repr


def analyze_focus(array: Array, drives: ArrayLike, focus_m: Point, *, core: str = "tile-100") -> FocusAnalysis:
    """What a focal point is like. The core, a board or a configuration, adds its time to load a record."""
    played, place = _numbers(drives, "drives", kind=complex), _numbers(focus_m, "focus_m", THREE)
    found = _Result("analyze_focus", array._owned.value, _doubles(played), len(played), _doubles(place), core.encode())
    return FocusAnalysis(**{name: float(np.array(value, dtype=float)) for name, value in found.about.items()})


@final
@dataclass(frozen=True, eq=False, repr=False)
class ImageAnalysis:
    """What each focus of an image is like, and how loud it is.

    highest_db: sound on the axis, averaged over the sequence, dB SPL: a model, no certification.
    level: what pressures and forces rest on, as of an Array.
    """

    foci_m: NDArray[np.float64]
    pressure_pa: NDArray[np.float64]
    radiation_pa: NDArray[np.float64]
    width_m: NDArray[np.float64]
    depth_m: NDArray[np.float64]
    side_lobe: NDArray[np.float64]
    force_n: NDArray[np.float64]
    formation_s: NDArray[np.float64]
    dwell_cycles: NDArray[np.uint64]
    dwell_needed_cycles: NDArray[np.uint32]
    highest_db: float
    pressure_left_least: float
    level: str
    warnings: list[str]
    __repr__ = pictures.image_repr


def analyze(image: str | os.PathLike[str] | Compiled, least_force_n: float = 0.58e-3) -> ImageAnalysis:
    """Of an image's or a project's path, or of what was just compiled."""
    source: dict[str, Any] = {"image": image._owned.value} if isinstance(image, Compiled) else {"file": os.fsencode(image)}
    request = sized(native.Source, **source)
    request.kept = image
    about = _Result("analyze", request, least_force_n, by=_call_until_signal).about
    alone = {name: about.pop(name) for name in ("highest_db", "pressure_left_least", "level", "warnings")}
    kinds = {"dwell_cycles": np.uint64, "dwell_needed_cycles": np.uint32}
    columns: dict[str, Any] = {name: np.array(about.get(name, []), dtype=kinds.get(name, float)) for name in list(ImageAnalysis.__dataclass_fields__)[:10]}
    return ImageAnalysis(**{**columns, "foci_m": columns["foci_m"].reshape(-1, 3)}, **alone)
