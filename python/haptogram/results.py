# SPDX-License-Identifier: Apache-2.0
"""What the computing half gives: numpy arrays with their coordinates. Every result can be pickled."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import pictures
from .errors import ErrorCode, HaptogramError

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes


def usage(where: str, message: str) -> HaptogramError:
    return HaptogramError(ErrorCode.USAGE, where, message)


def needed(module: str, package: str = "") -> Any:
    """An optional module. Raises HaptogramError that says what to install."""
    try:
        return __import__(module)
    except ImportError as error:
        raise HaptogramError(ErrorCode.RUN_FAILED, module, f"is not installed; pip install {package or module}") from error


@dataclass(frozen=True, eq=False)
class Field:
    """A quantity of a sound field along a line, in a plane or in a volume.

    values: float32, or complex64 of a complex field. Its axes are z, y, x without those of a single coordinate: a plane z_m = 0.13 has y × x.
        np.asarray(field) is the same.
    x_m, y_m, z_m: the coordinates along each axis, metres. In an oblique plane x_m and y_m run along the plane's own axes, and z_m is [0].
    quantity, label: its name with its unit, such as "radiation_pressure_pa" and "radiation pressure / Pa".
    error: how far the pressure may be off, as a share of the largest that the drives, with any phases, could make.
    method: how it was computed: sums, shifts or interpolated.
    level: what absolute pressures rest on, in a sentence that begins with nominal or calibrated.
    oblique_m: points × 3, the places of an oblique plane's points in the array's frame; None otherwise.
    """

    values: npt.NDArray[Any]
    x_m: npt.NDArray[np.float64]
    y_m: npt.NDArray[np.float64]
    z_m: npt.NDArray[np.float64]
    quantity: str
    label: str
    method: str
    error: float
    level: str
    oblique_m: npt.NDArray[np.float64] | None = None

    @property
    def points_m(self) -> npt.NDArray[np.float64]:
        """Where each point lies in the array's frame: values.shape × 3."""
        z, y, x = np.meshgrid(self.z_m, self.y_m, self.x_m, indexing="ij")
        found: npt.NDArray[np.float64] = np.stack([x, y, z], axis=-1) if self.oblique_m is None else self.oblique_m
        return found.reshape(*self.values.shape, 3)

    @property
    def unit(self) -> str:
        return self.label.split(" / ")[1].strip("()")

    @property
    def coordinates(self) -> dict[str, npt.NDArray[np.float64]]:
        """Of each axis of values: {"y_m": …, "x_m": …}."""
        return {name: axis for name, axis in (("z_m", self.z_m), ("y_m", self.y_m), ("x_m", self.x_m)) if len(axis) > 1}

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        found = self.values if dtype is None else self.values.astype(dtype, copy=False)
        return found.copy() if copy else found

    def point_m(self, index: int) -> npt.NDArray[np.float64]:
        """Where a point lies in the array's frame, counted as in values.ravel()."""
        found: npt.NDArray[np.float64] = self.points_m.reshape(-1, 3)[index]
        return found

    def to_xarray(self) -> xarray.DataArray:
        """With x_m, y_m and z_m as coordinates. It needs xarray."""
        coordinates: dict[str, Any] = {name: (name, axis, {"units": "m"}) for name, axis in self.coordinates.items()}
        fixed = {name: axis[0] for name, axis in (("x_m", self.x_m), ("y_m", self.y_m), ("z_m", self.z_m)) if len(axis) == 1}
        about = {"long_name": self.label.split(" / ")[0], "units": self.unit, "method": self.method, "error": self.error, "level": self.level}
        return needed("xarray").DataArray(self.values, coords=coordinates | fixed, dims=list(self.coordinates), name=self.quantity, attrs=about)

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each point: its place in the array's frame x_m, y_m, z_m, and the quantity. It needs pandas."""
        x, y, z = self.points_m.reshape(-1, 3).T
        return needed("pandas").DataFrame({"x_m": x, "y_m": y, "z_m": z, self.quantity: self.values.ravel()})

    def plot(self, ax: Axes | None = None, **options: Any) -> Axes:
        """Draws a plane as a map, a line as a curve; of complex values the amplitude.

        ax: where to draw; a new figure without it.
        options: those of matplotlib's pcolormesh (vmin, vmax, cmap, …) or plot (color, label, …), and title and colorbar (True)
        """
        return pictures.field_plot(self, ax, **options)

    def __repr__(self) -> str:
        points, most = " × ".join(map(str, self.values.shape)), np.nanmax(np.abs(self.values))
        return f"<Field of {self.quantity}: {' × '.join(self.coordinates)} = {points}, at most {most:.4g} {self.unit}>"


def compare(fields: Sequence[Field], titles: Sequence[str] | None = None, *, axes: Any = None, **options: Any) -> Any:
    """Draws fields of the same quantity on one scale: planes beside each other, with one colour bar; lines as curves in one diagram.

    titles: a name for each field.
    axes: where to draw: an axes for each plane, or one axes for curves; a new figure without it.
    options: as of Field.plot(); vmin and vmax are those of all fields unless they are given.
    Returns the axes: an array of them for planes, one for curves.
    """
    fields = list(fields)
    names = list(titles) if titles is not None else [""] * len(fields)
    if not fields or len({(field.quantity, field.values.ndim) for field in fields}) > 1 or fields[0].values.ndim not in (1, 2):
        raise usage("compare", "expected lines, or planes, of one quantity")
    if len(names) != len(fields):
        raise usage("titles", f"found {len(names)} for {len(fields)} fields; give one each")
    needed("matplotlib")
    import matplotlib.pyplot as plt

    if fields[0].values.ndim == 1:
        axes = axes or plt.subplots(constrained_layout=True)[1]
        for field, name in zip(fields, names, strict=True):
            field.plot(axes, label=name, **options)
        if titles is not None:
            axes.legend()
        return axes
    if axes is None:
        axes = plt.subplots(1, len(fields), figsize=(3.8 * len(fields) + 0.8, 3.8), constrained_layout=True, squeeze=False)[1][0]
    panels, shown = np.ravel(axes), [np.abs(field.values) if np.iscomplexobj(field.values) else field.values for field in fields]
    if len(panels) != len(fields):
        raise usage("axes", f"found {len(panels)} for {len(fields)} fields; give one each")
    options = {"vmin": min(map(np.nanmin, shown)), "vmax": max(map(np.nanmax, shown))} | options
    for field, name, panel in zip(fields, names, panels, strict=True):
        field.plot(panel, colorbar=False, **({"title": name} if titles is not None else {}), **options)
    for panel in panels[1:]:
        panel.set_ylabel("")
    panels[0].figure.colorbar(panels[0].collections[0], ax=list(panels), label=fields[0].label)
    return axes


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers of several foci, places or records: a row each.

    columns: {name: array}, an entry for each row; places are rows × 3. A column is also an attribute: table.force_n.
    about: what belongs to all rows: {name: number, text or list}; also as attributes.
    rows: what a row is, such as "focus".

    np.asarray(table) is a structured array with the columns' names.
    """

    rows: str
    columns: dict[str, npt.NDArray[Any]]
    about: dict[str, Any]

    def __getattr__(self, name: str) -> Any:
        for found in (self.__dict__.get("columns", {}), self.__dict__.get("about", {})):
            if name in found:
                return found[name]
        raise AttributeError(f"this table has no {name}; it has {', '.join(self.names())}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.names()]

    def names(self) -> list[str]:
        return [*self.__dict__.get("columns", {}), *self.__dict__.get("about", {})]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        found = np.empty(len(self), [(name, column.dtype, column.shape[1:]) for name, column in self.columns.items()])
        for name, column in self.columns.items():
            found[name] = column
        return found if dtype is None else found.astype(dtype)

    def _flat(self) -> Iterator[tuple[str, npt.NDArray[Any]]]:
        """Columns of one number a row."""
        for name, column in self.columns.items():
            if column.ndim == 1:
                yield name, column
            else:
                yield from zip(("x_m", "y_m", "z_m"), column.T, strict=True)

    def to_pandas(self) -> pandas.DataFrame:
        """A row each; places are the columns x_m, y_m and z_m. `about` is in its attrs. It needs pandas."""
        frame = needed("pandas").DataFrame(dict(self._flat()))
        frame.attrs = dict(self.about)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Variables along the dimension of the rows' name; places are the coordinates x_m, y_m and z_m. It needs xarray."""
        flat = {name: (self.rows, column) for name, column in self._flat()}
        places = {name: flat.pop(name) for name in ("x_m", "y_m", "z_m") if name in flat}
        return needed("xarray").Dataset(flat, coords=places, attrs=self.about)

    def __repr__(self) -> str:
        return f"<Table, a row for each {self.rows}: {len(self)} × {', '.join(self.columns)}; about: {', '.join(self.about)}>"
