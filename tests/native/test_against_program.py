# SPDX-License-Identifier: Apache-2.0
"""The same bytes as the program's."""
import io
import json

import haptogram_native as native
import numpy as np
import pytest

PROJECT = """format = "haptogram-project-1"
points = 30
rate_hz = 20

[[shape]]
kind = "circle"
diameter_mm = 40
"""


@pytest.fixture
def ring(tmp_path, program):
    """A project, and what the program makes of it: ring.toml, ring.hex, ring.json."""
    (tmp_path / "ring.toml").write_text(PROJECT)
    program("compile", "ring.toml", "-o", "ring.hex")
    return tmp_path


def test_images_and_manifests(ring):
    for compiled in (native.compile_project(str(ring / "ring.toml")), native.compile_text(PROJECT)):
        assert compiled.hex == (ring / "ring.hex").read_bytes()
        assert compiled.manifest == (ring / "ring.json").read_text()
    compiled.save(str(ring / "again.hex"))
    assert (ring / "again.hex").read_bytes() == compiled.hex
    assert (ring / "again.json").read_text() == compiled.manifest
    assert compiled.foci_m.shape == (30, 3)
    assert np.allclose(np.hypot(*compiled.foci_m[:, :2].T), 0.02)
    assert compiled.rate_hz == pytest.approx(20.0, rel=0.05)


@pytest.mark.parametrize("quantity", ["radiation", "rms", "spl", "velocity"])
def test_fields_of_an_image(ring, program, quantity):
    program("field", "ring.hex", "--plane", "xy@z=130", "--step", 4, "--quantity", quantity, "-o", "plane.npy")
    compiled = native.compile_text(PROJECT)
    for excitation in (native.Excitation.of_image(str(ring / "ring.hex")), native.Excitation.of_compiled(compiled)):
        field = native.field(excitation, plane="xy@z=130", step_m=4e-3, quantity=quantity, threads=2)
        assert field.to_npy() == (ring / "plane.npy").read_bytes()
        assert np.array_equal(field.values[0], np.load(ring / "plane.npy"))
    assert excitation.drives.shape == (30, 100)
    assert len(excitation.weights) == 30


def test_complex_fields_lines_and_volumes(tmp_path, program):
    array = native.Array.find("tile-10x10")
    excitation = native.Excitation.of_focus(array, (0.0, 0.01, 0.12))
    asked = [
        (["--plane", "xz@y=0", "--step", "0.7"], {"plane": "xz@y=0", "step_m": 0.7e-3}),
        (["--plane", "uv@z=120,rx=30,rz=5", "--step", "2"], {"plane": "uv@z=120,rx=30,rz=5", "step_m": 2e-3}),
        (["--line", "z@x=0,y=10"], {"line": "z@x=0,y=10"}),
        (["--volume", "--step", "4", "--z", "80:160"], {"volume": True, "step_m": 4e-3, "z_m": (80e-3, 160e-3)}),
    ]
    for options, keywords in asked:
        program("field", "--focus", "0,10,120", *options, "--quantity", "complex", "-o", "field.npy")
        field = native.field(excitation, quantity="complex", **keywords)
        assert field.to_npy() == (tmp_path / "field.npy").read_bytes()
        assert np.array_equal(field.values.squeeze(), np.load(io.BytesIO(field.to_npy())))
        assert field.values.shape == (len(field.z_m), len(field.y_m), len(field.x_m))


def test_analyses(ring, program):
    theirs = json.loads(program("analyze", "ring.hex", "--json"))
    # A manifest's file has its foci rounded; what was just compiled has not.
    for image, apart in ((str(ring / "ring.hex"), 0.0), (native.compile_text(PROJECT), 1e-5)):
        ours = native.analyze(image)
        assert ours.warnings == theirs["warnings"]
        assert ours.level == theirs["level"]["note"]
        assert ours.pressure_left_least == pytest.approx(theirs["pressure_left_least"], rel=apart, abs=0.0)
        columns = {"pressure_pa": (ours.pressure_pa, 1.0), "radiation_pressure_pa": (ours.radiation_pa, 1.0), "width_mm": (ours.width_m, 1e3),
                   "depth_mm": (ours.depth_m, 1e3), "side_lobe": (ours.side_lobe, 1.0), "force_mn": (ours.force_n, 1e3),
                   "formation_us": (ours.formation_s, 1e6), "dwell_cycles": (ours.dwell_cycles, 1.0),
                   "dwell_needed_cycles": (ours.dwell_needed_cycles, 1.0)}  # fmt: skip
        for name, (values, factor) in columns.items():
            assert np.allclose(values * factor, [point[name] for point in theirs["points"]], rtol=apart, atol=0.51e-4), name
        assert np.allclose(ours.foci_m * 1e3, [point["focus_mm"] for point in theirs["points"]], atol=0.51e-4)
        assert ours.highest_db == pytest.approx(theirs["safety"]["highest_on_axis_db_spl"], abs=0.051)


@pytest.mark.parametrize("method", ["gauss-newton", "weighted-gs", "superposition"])
def test_solved_foci(program, method):
    array = native.Array.find("tile-10x10")
    foci = np.array([[-0.02, 0.0, 0.12], [0.02, 0.01, 0.13], [0.0, -0.015, 0.14]])
    texts = [word for focus in foci * 1e3 for word in ("--focus", ",".join(f"{x:.17g}" for x in focus))]
    (theirs,) = json.loads(program("solve", *texts, "--solver", method, "--json"))["steps"]
    drives = native.solve(array, foci, method=method)
    assert np.allclose(np.abs(drives), [d["amplitude"] for d in theirs["drives"]], rtol=0.0, atol=1e-14)
    assert np.allclose(np.exp(1j * np.angle(drives)), np.exp(1j * np.array([d["phase_rad"] for d in theirs["drives"]])), rtol=0.0, atol=1e-12)
    quality = native.quality(array, foci, drives)
    assert quality.efficiency == pytest.approx(theirs["quality"]["exact"]["efficiency"], rel=1e-12)
    assert quality.null_share is None


def test_foci_that_follow(tmp_path, program):
    """Each set begun with the drives of the one before, as the program's --follow does."""
    array = native.Array.find("tile-10x10")
    frames = [np.array([[-0.02 + shift, 0.0, 0.12], [0.02, 0.01 + shift, 0.13]]) for shift in (0.0, 0.0002)]
    lines = [[",".join(f"{x:.17g}" for x in focus * 1e3) for focus in foci] for foci in frames]
    (tmp_path / "foci.txt").write_text("\n\n".join("\n".join(one) for one in lines) + "\n")
    steps = json.loads(program("solve", "foci.txt", "--follow", "--rounds", 1, "--json"))["steps"]
    drives = native.solve(array, frames[0])
    drives = native.solve(array, frames[1], start=drives, rounds=1)
    theirs = np.array([d["amplitude"] * np.exp(1j * d["phase_rad"]) for d in steps[1]["drives"]])
    assert np.allclose(drives, theirs, rtol=0.0, atol=1e-12)
    assert not np.allclose(drives, native.solve(array, frames[1], rounds=1), rtol=0.0, atol=1e-3)
