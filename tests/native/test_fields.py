# SPDX-License-Identifier: Apache-2.0
"""Fields against sums in numpy, in double precision."""
import haptogram_native as native
import numpy as np
from conftest import waves


def some_drives(rng, array):
    return rng.uniform(1.0, 5.0, len(array)) * np.exp(2j * np.pi * rng.random(len(array)))


def some_rig():
    tile = native.Array.find("tile-10x10")
    return native.join([(tile, native.Pose((0, 0, 0))), (tile, native.Pose((0.15, 0, 0.15), (0, -90, 0)))])


def test_pressure_at_points(rng):
    for array in (native.Array.find("tile-10x10"), some_rig()):
        drives = some_drives(rng, array)
        points = rng.uniform((-0.05, -0.05, 0.1), (0.05, 0.05, 0.2), (500, 3))
        each = waves(array, points) * drives
        found = native.pressure(array, drives, points)
        assert found.dtype == np.complex64
        assert np.abs(found - each.sum(axis=1)).max() <= 3e-5 * np.abs(each).sum(axis=1).max()


def test_planes_level_and_oblique(rng):
    array = native.Array.find("tile-10x10")
    drives = some_drives(rng, array)
    x, y = np.linspace(-0.06, 0.06, 150), np.linspace(-0.05, 0.05, 131)
    for pose in (native.Pose((0, 0, 0.13)), native.Pose((0.01, 0, 0.13), (30, -20, 45))):
        field = native.pressure_on(array.seen_from(pose), drives, x, y, [0.0])
        assert field.method == "interpolated"
        assert field.error <= 1e-4
        assert field.values.shape == (1, 131, 150)
        own = np.stack([*np.meshgrid(x, y), np.zeros((131, 150))], axis=2).reshape(-1, 3)
        chosen = rng.choice(len(own), 1500, replace=False)
        each = waves(array, pose.outwards(own[chosen])) * drives
        assert np.abs(field.values.reshape(-1)[chosen] - each.sum(axis=1)).max() <= field.error * np.abs(each).sum(axis=1).max()
        summed = native.pressure_on(array.seen_from(pose), drives, x, y, [0.0], interpolation_error=0.0)
        assert summed.method in ("sums", "shifts")


def test_gradients(rng):
    array = some_rig()
    drives = some_drives(rng, array)
    points = rng.uniform((-0.02, -0.02, 0.13), (0.02, 0.02, 0.17), (100, 3))
    step = 2e-6
    numeric = np.stack([((waves(array, points + e) - waves(array, points - e)) @ drives) / (2 * step) for e in step * np.eye(3)], axis=1)
    found = native.gradient(array, drives, points)
    k = 2 * np.pi / array.wavelength_m
    assert np.abs(found - numeric).max() <= 1e-4 * k * np.abs(waves(array, points) * drives).sum(axis=1).max()


def test_mean_squares(rng):
    array = some_rig()
    sets = np.stack([some_drives(rng, array) for _ in range(5)])
    weights = rng.uniform(0.1, 2.0, 5)
    points = rng.uniform((-0.02, -0.02, 0.13), (0.02, 0.02, 0.17), (200, 3))
    expected = (np.abs(waves(array, points) @ sets.T) ** 2 / 2) @ weights / weights.sum()
    assert np.abs(native.mean_square(array, sets, weights, points) - expected).max() <= 1e-4 * expected.max()


def test_measured_patterns_by_polynomials(rng):
    array = native.Array.find("hoshi-18x18").with_transducer("T4010A1")
    drives = native.ideal_drives(array, (0, 0, 0.2))
    points = rng.uniform((-0.1, -0.1, 0.15), (0.1, 0.1, 0.25), (300, 3))
    table = native.pressure(array, drives, points)
    fitted = native.pressure(array, drives, points, pattern_error=0.015)
    most = np.abs(waves(array, points, 0.0) * drives).sum(axis=1).max()
    assert 0.0 < np.abs(fitted - table).max() <= 0.015 * most
