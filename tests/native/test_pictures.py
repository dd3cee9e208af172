# SPDX-License-Identifier: Apache-2.0
"""What values say of themselves, and what plot() draws: read back from the axes, beside the numbers that went in."""
import builtins

import haptogram_native as native
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from messages import refusal

RING = 'format = "haptogram-project-1"\npoints = 12\nrate_hz = 20\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n'


@pytest.fixture(scope="module")
def ring():
    return native.compile_text(RING)


@pytest.fixture(autouse=True)
def no_figure_stays():
    yield
    plt.close("all")


def test_every_value_says_what_it_is(ring):
    array, foci = native.Array.find("tile-10x10"), [[-0.02, 0, 0.13], [0.02, 0, 0.13]]
    axis = np.linspace(-0.01, 0.01, 3)
    drives = native.solve(array, foci)
    played = native.Excitation.of_compiled(ring)
    assert repr(ring) == f"<Compiled: 12 foci, 20 passes a second, {len(ring.hex)} bytes of Intel HEX>"
    assert repr(played) == "<Excitation: 12 sets of drives of <Array tile-10x10: 100 × MA40S4S>>"
    assert repr(native.pressure_on(array, drives, axis, axis, [0.13])).startswith("<PressureField: 1 × 3 × 3 points, at most ")
    assert repr(native.mean_square_on(array, [drives], [1], axis, axis, [0.13])).startswith("<MeanSquareField: 1 × 3 × 3 points, at most ")
    assert repr(native.quality(array, foci, drives)).startswith("<Quality: 2 foci of ")
    focus = native.analyze_focus(array, native.ideal_drives(array, foci[0]), foci[0])
    assert repr(focus).startswith(f"<FocusAnalysis: {focus.pressure_pa:.0f} Pa, {focus.force_n * 1e3:.2f} mN, ")
    analysis = native.analyze(ring)
    with pytest.raises(TypeError):
        native.analyze(None)
    assert repr(analysis).startswith("<ImageAnalysis: 12 foci, ") and f"{analysis.highest_db:.0f} dB SPL" in repr(analysis)
    assert repr(native.Pose((0, 0, 0.13), (0, 0, 90))) == "<Pose at [0.0, 0.0, 130.0] mm, axes [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]>"


def test_a_plane_is_a_map_of_its_values(ring):
    field = native.field(native.Excitation.of_compiled(ring), plane="xz@y=0", extent_m=0.01, step_m=0.005, z_m=(0.14, 0.16))
    assert repr(field).startswith("<Field of radiation_pressure_pa: 5 × 1 × 5 points, at most ")
    axes = field.plot()
    (drawn,) = axes.collections
    assert np.array_equal(drawn.get_array().reshape(5, 5), field.values[:, 0, :])
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("x / mm", "z / mm", "y = 0 mm")


def test_an_oblique_plane_is_named_by_its_own_coordinates(ring):
    axes = native.field(native.Excitation.of_compiled(ring), plane="uv@z=150,rx=30", extent_m=0.01, step_m=0.005).plot()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("u / mm", "v / mm")


def test_a_line_is_a_curve_and_complex_values_their_amplitude():
    played = native.Excitation.of_focus(native.Array.find("tile-10x10"), (0, 0, 0.13))
    field = native.field(played, line="z@x=0,y=0", z_m=(0.12, 0.14), step_m=0.005, quantity="complex")
    own = plt.figure().add_subplot()
    (curve,) = field.plot(own).lines
    assert np.allclose(curve.get_xdata(), [120, 125, 130, 135, 140])
    assert np.array_equal(curve.get_ydata(), abs(field.values).ravel())
    assert own.get_ylabel() == "pressure amplitude / Pa"


@pytest.mark.parametrize("quantity", ["radiation", "rms", "spl", "velocity", "complex"])
def test_every_quantity_has_a_label_with_its_unit(ring, quantity):
    field = native.field(native.Excitation.of_compiled(ring, 1), line="z@x=0,y=0", z_m=(0.12, 0.14), step_m=0.01, quantity=quantity)
    assert " / " in field.plot().get_ylabel()


def test_a_volume_is_refused(ring):
    field = native.field(native.Excitation.of_compiled(ring), volume=True, extent_m=0.01, step_m=0.01, z_m=(0.14, 0.16))
    with refusal(native.BadArgument):
        field.plot()


def test_elements_and_foci_lie_where_they_are(ring):
    array = native.Array.find("tile-7x8")
    (elements,) = array.plot().lines
    assert np.allclose(np.transpose(elements.get_data()), array.positions_m[:, :2] * 1e3)
    (tour,) = ring.plot().lines
    assert np.allclose(np.transpose(tour.get_data_3d()), ring.foci_m * 1e3)


def test_without_matplotlib_an_error_says_what_to_install(ring, monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with refusal(native.Failed):
        ring.plot()
