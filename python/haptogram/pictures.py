# SPDX-License-Identifier: Apache-2.0
"""What computed values say and show of themselves: __repr__, and plot() where there is something to see. matplotlib is asked for when something is drawn."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import BadArgument, ErrorCode, Failed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from . import calls

LABELS = {
    "radiation_pressure_pa": "radiation pressure / Pa",
    "rms_pressure_pa": "rms pressure / Pa",
    "spl_db": "sound pressure level / dB",
    "rms_velocity_m_s": "rms velocity / (m/s)",
    "pressure_pa": "pressure amplitude / Pa",
}


def _axes(axes: Axes | None, **options: Any) -> Any:
    if axes is not None:
        return axes
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise Failed(ErrorCode.RUN_FAILED, "plot", "matplotlib is missing; pip install matplotlib") from error
    return plt.subplots(constrained_layout=True, subplot_kw=options)[1]


def _range(values: Any, scale: float, unit: str) -> str:
    """Least and greatest, as text."""
    known = np.asarray(values)[np.isfinite(values)] * scale
    if not known.size:
        return f"no {unit}"
    least, most = f"{known.min():.3g}", f"{known.max():.3g}"
    return f"{least} {unit}" if least == most else f"{least} to {most} {unit}"


def compiled_repr(self: calls.Compiled) -> str:
    warned = f", {len(self.warnings)} warnings" if self.warnings else ""
    return f"<Compiled: {len(self.foci_m)} foci, {self.rate_hz:g} passes a second, {len(self.hex)} bytes of Intel HEX{warned}>"


def excitation_repr(self: calls.Excitation) -> str:
    return f"<Excitation: {len(self.weights)} sets of drives of {self.array!r}>"


def field_repr(self: calls.Field) -> str:
    points = " × ".join(str(len(axis)) for axis in (self.x_m, self.y_m, self.z_m))
    return f"<Field of {self.quantity}: {points} points, at most {np.nanmax(np.abs(self.values)):.4g}, by {self.method}>"


def grid_repr(self: calls.PressureField | calls.MeanSquareField) -> str:
    points = " × ".join(map(str, self.values.shape))
    return f"<{type(self).__name__}: {points} points, at most {np.nanmax(np.abs(self.values)):.4g}, by {self.method}>"


def quality_repr(self: calls.Quality) -> str:
    return f"<Quality: {len(self.pressure_pa)} foci of {_range(self.pressure_pa, 1.0, 'Pa')}, spread {100 * self.spread:.2g} %, efficiency {self.efficiency:.3g}>"


def focus_repr(self: calls.FocusAnalysis) -> str:
    size = f"{self.width_m * 1e3:.1f} mm wide, {self.depth_m * 1e3:.1f} mm deep"
    return f"<FocusAnalysis: {self.pressure_pa:.0f} Pa, {self.force_n * 1e3:.2f} mN, {size}, side lobes of {100 * self.side_lobe:.1f} %>"


def image_repr(self: calls.ImageAnalysis) -> str:
    foci, force = len(self.foci_m), _range(self.force_n, 1e3, "mN")
    return f"<ImageAnalysis: {foci} foci, {force}, {self.highest_db:.0f} dB SPL at most on the axis, {len(self.warnings)} warnings>"


def pose_repr(self: calls.Pose) -> str:
    origin, *ends = self.outwards([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    turned = np.round(np.subtract(ends, origin), 3).tolist()
    return f"<Pose at {np.round(origin * 1e3, 3).tolist()} mm, axes {turned}>"


def array_plot(self: Any, axes: Axes | None = None, **options: Any) -> Axes:
    """The elements as the hand sees them, with the numbers of the first and the last channel. Options are those of matplotlib's plot."""
    axes = _axes(axes)
    x, y, _ = self.positions_m.T * 1e3
    axes.plot(x, y, "o", **{"markersize": 6, "markerfacecolor": "none", **options})
    for channel in (0, len(self) - 1):  # beside the element, away from the middle
        away = 9 * np.sign([x[channel] - x.mean(), y[channel] - y.mean()])
        axes.annotate(str(channel), (x[channel], y[channel]), xytext=away, textcoords="offset points", ha="center", va="center", fontsize=9)
    axes.margins(0.1)
    axes.set(xlabel="x / mm", ylabel="y / mm", title=f"{self.name}: {len(self)} × {self.transducer}", aspect="equal")
    return axes


def compiled_plot(self: Any, axes: Axes | None = None, **options: Any) -> Axes:
    """The focal points in space, coloured in the order in which they play. Options are those of matplotlib's scatter."""
    axes = _axes(axes, projection="3d")
    x, y, z = self.foci_m.T * 1e3
    axes.plot(x, y, z, lw=0.6, color="#999999")
    axes.scatter(x, y, z, **{"c": np.arange(len(x)), "cmap": "viridis", "s": 14, **options})
    axes.set(xlabel="x / mm", ylabel="y / mm", zlabel="z / mm", title=f"{len(x)} foci, {self.rate_hz:g} passes a second")
    axes.set_box_aspect(None, zoom=0.85)  # else the label of z is cut off
    return axes


def field_plot(self: Any, axes: Axes | None = None, *, colorbar: bool = True, title: str | None = None, **options: Any) -> Axes:
    """A plane as a map, a line as a curve; of complex values the amplitude. Options are those of matplotlib's pcolormesh or plot; the limits vmin and
    vmax of a curve are those of its axis."""
    grid = {"x": self.x_m, "y": self.y_m, "z": self.z_m}
    wide = [name for name, axis in grid.items() if len(axis) > 1]
    if len(wide) not in (1, 2):
        raise BadArgument(ErrorCode.USAGE, "plot", f"found a field over {len(wide)} dimensions, expected a line or a plane; plot one of its planes")
    at = ", ".join(f"{name} = {axis[0] * 1e3:g} mm" for name, axis in grid.items() if name not in wide)
    names = dict(zip(wide, wide, strict=True))
    if not np.allclose(self.point_m(0), [axis[0] for axis in grid.values()]):  # an oblique plane has coordinates of its own
        names, at = {"x": "u", "y": "v"}, "oblique plane"
    axes, values, label = _axes(axes), np.squeeze(self.values), LABELS[self.quantity]
    values = np.abs(values) if np.iscomplexobj(values) else values
    ylabel = label if len(wide) == 1 else f"{names[wide[1]]} / mm"
    axes.set(title=at if title is None else title, xlabel=f"{names[wide[0]]} / mm", ylabel=ylabel)
    if len(wide) == 1:
        limits = {"bottom": options.pop("vmin", None), "top": options.pop("vmax", None)}
        axes.plot(grid[wide[0]] * 1e3, values, **options)
        if any(limit is not None for limit in limits.values()):
            axes.set_ylim(**limits)
        return axes
    options = {"cmap": "magma", "shading": "nearest", "rasterized": True, **options}
    image = axes.pcolormesh(grid[wide[0]] * 1e3, grid[wide[1]] * 1e3, values, **options)
    if colorbar:
        axes.figure.colorbar(image, ax=axes, label=label)
    axes.set(aspect="equal")
    return axes
