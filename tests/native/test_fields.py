# SPDX-License-Identifier: Apache-2.0
"""Fields against sums in numpy, in double precision."""
import haptogram_native as native
import numpy as np
from pistons import waves


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


def test_mean_squares_on_planes_and_in_volumes(rng):
    array = native.Array.find("tile-10x10")
    sets = np.stack([some_drives(rng, array) for _ in range(3)])
    weights = rng.uniform(0.1, 2.0, 3)
    x, y, z = np.linspace(-0.03, 0.04, 30), np.linspace(-0.02, 0.02, 21), np.array([0.1, 0.13])
    pose = native.Pose((0, 0.01, 0.13), (20, 10, 0))
    for of, place, height in ((array, native.Pose((0, 0, 0)), z), (array.seen_from(pose), pose, np.zeros(1))):
        grid = np.stack(np.meshgrid(height, y, x, indexing="ij")[::-1], axis=-1)
        each = waves(array, place.outwards(grid.reshape(-1, 3)))
        for drives, shares in ((sets, weights), (sets[:1], weights[:1])):  # a lone set may be interpolated
            found = native.mean_square_on(of, drives, shares, x, y, height)
            assert found.values.shape == grid.shape[:3] and found.values.dtype == np.float32
            rms = np.sqrt((np.abs(each @ drives.T) ** 2 / 2) @ shares / shares.sum())
            most = np.sqrt(((np.abs(each) @ np.abs(drives.T)) ** 2 / 2) @ shares / shares.sum()).max()
            assert np.abs(np.sqrt(found.values.reshape(-1)) - rms).max() <= found.error * most
            assert found.method == ("sums" if len(drives) > 1 else found.method) and 0 < found.error <= 1e-4


def test_what_pressures_rest_on(tmp_path):
    measured = tmp_path / "measured.toml"
    measured.write_text('[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n[transducer]\nsource_pa_m = 1.25\nmeasured = "by a balance"\n')
    assert native.Array.find(str(measured)).level == "calibrated level: 1.25 Pa·m, by a balance"
    assert native.Array.find("tile-10x10").level.startswith("nominal level: 4 Pa·m")


def test_a_focus_and_the_workspace():
    array = native.Array.find("tile-10x10")
    focus = native.analyze_focus(array, native.ideal_drives(array, (0.01, 0, 0.13)), (0.01, 0, 0.13))
    alone = 4.0 * np.abs(waves(array, [[0.01, 0, 0.13]])).sum()
    assert np.isclose(focus.pressure_pa, alone, rtol=1e-4)
    assert np.isclose(focus.width_m, 0.0108, atol=1e-3) and 0 < focus.side_lobe < 0.2 and focus.depth_m > focus.width_m
    x, z = np.array([-0.2, 0.0, 0.01]), np.array([0.001, 0.05, 0.13])
    reach = native.workspace(array, x, [0.0], z)
    assert reach.shape == (3, 1, 3) and np.isnan(reach[0]).all() and np.isnan(reach[1, 0, 0])  # too near, and too far aside
    assert np.isclose(reach[2, 0, 2], alone, rtol=1e-6)


def test_fields_of_given_drives():
    array = native.Array.find("tile-10x10")
    drives = native.ideal_drives(array, (0, 0, 0.12))
    given = native.field(native.Excitation.of_drives(array, drives[None, :]), plane="uv@z=120,ry=20", step_m=4e-3)
    asked = native.field(native.Excitation.of_focus(array, (0, 0, 0.12)), plane="uv@z=120,ry=20", step_m=4e-3)
    assert given.to_npy() == asked.to_npy() and given.method == asked.method and 0 < given.error <= 1e-4
    at = int(np.argmax(given.values))
    assert np.linalg.norm(given.point_m(at) - (0, 0, 0.12)) <= 5e-3
    both = native.Excitation.of_drives(array, np.stack([drives, 0 * drives]), [1.0, 3.0])
    quarter = native.field(both, plane="xy@z=120", step_m=8e-3).values
    whole = native.field(native.Excitation.of_focus(array, (0, 0, 0.12)), plane="xy@z=120", step_m=8e-3).values
    assert np.allclose(4 * quarter, whole, rtol=1e-3, atol=1e-3 * whole.max())


def test_measured_patterns_by_polynomials(rng):
    array = native.Array.find("hoshi-18x18").with_transducer("T4010A1")
    drives = native.ideal_drives(array, (0, 0, 0.2))
    points = rng.uniform((-0.1, -0.1, 0.15), (0.1, 0.1, 0.25), (300, 3))
    table = native.pressure(array, drives, points)
    fitted = native.pressure(array, drives, points, pattern_error=0.015)
    most = np.abs(waves(array, points, 0.0) * drives).sum(axis=1).max()
    assert 0.0 < np.abs(fitted - table).max() <= 0.015 * most
