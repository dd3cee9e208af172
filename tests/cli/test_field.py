# SPDX-License-Identifier: Apache-2.0
"""`haptogram field`: what it is of, where, and the files that it writes."""
import json
import struct
import xml.etree.ElementTree

import numpy as np
import pytest
from messages import program_said
from support import BAD_INPUT, USAGE, array_for, assert_one_message, read_json, refuse, run, succeed, text


def field_of(folder, *arguments):
    header, *rows = text(succeed(["field", *arguments], cwd=folder).stdout).splitlines()
    return header, np.array([[float(value) for value in row.split(",")] for row in rows])


def ideal_pressure(manifest, focus_mm, points_mm):
    """Point sources with exact phases, of the array's elements; by numpy alone."""
    elements = np.array(manifest["array"]["elements_mm"]) * 1e-3
    k = 2 * np.pi * manifest["array"]["carrier_hz"] / manifest["medium"]["speed_m_s"]
    to_focus = np.linalg.norm(np.array(focus_mm) * 1e-3 - elements, axis=1)
    distance = np.linalg.norm(np.array(points_mm)[:, None] * 1e-3 - elements[None], axis=2)
    return manifest["transducer"]["source_pa_m"] * (np.exp(1j * k * (to_focus - distance)) / distance).sum(axis=1)


@pytest.mark.check
def test_a_focus_of_exact_phases(small):
    header, field = field_of(small.folder, "--focus", "0,0,130", "--line", "x@y=0,z=130", "--extent", 20, "--step", 0.1, "--quantity", "rms")
    assert header == "x_mm,rms_pressure_pa" and len(field) == 401
    half = field[field[:, 1] ** 2 >= field[:, 1].max() ** 2 / 2, 0]
    assert half[-1] - half[0] == pytest.approx(10.8, abs=0.2)  # Haptogram's focus: full width at half maximum, pistons
    assert field[np.argmax(field[:, 1]), 0] == 0.0


def test_complex_pressure_as_numpy_reads_it(small):
    (small.folder / "points.toml").write_text("[array]\nrows = 10\ncolumns = 10\npitch_mm = 10.0\n[transducer]\nradius_mm = 0.1\n")
    succeed(["field", "--focus", "10,-5,120", "--array", "./points.toml", "--plane", "xz@y=-5", "--x", "-20:20", "--z", "100:140", "--step", 5,
             "--quantity", "complex", "-o", "p.npy"], cwd=small.folder)  # fmt: skip
    found = np.load(small.folder / "p.npy")
    assert found.shape == (9, 9) and found.dtype == np.complex64
    points = [(x, -5, z) for z in range(100, 141, 5) for x in range(-20, 21, 5)]
    manifest = read_json(small.manifest)
    expected = ideal_pressure(manifest, (10, -5, 120), points).reshape(9, 9)
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()  # pistons of 0.1 mm are all but points


def test_oblique_planes_of_a_focus_and_of_a_sequence(small):
    """The values of an oblique plane are those of points, summed by numpy; of a mean, too."""
    (small.folder / "points.toml").write_text("[array]\nrows = 10\ncolumns = 10\npitch_mm = 10.0\n[transducer]\nradius_mm = 0.1\n")
    manifest, plane = read_json(small.manifest), ["--plane", "uv@x=5,z=120,ny=-3,nz=4", "--x", "-30:30", "--y", "-50:20", "--step", 10]
    header, field = field_of(small.folder, "--focus", "10,-5,120", "--array", "./points.toml", *plane, "--quantity", "rms")
    assert header == "u_mm,v_mm,x_mm,y_mm,z_mm,rms_pressure_pa" and len(field) == 7 * 8
    assert np.allclose(field[:, 2:5], np.stack([5 + field[:, 0], 0.8 * field[:, 1], 120 + 0.6 * field[:, 1]], axis=1))
    expected = np.abs(ideal_pressure(manifest, (10, -5, 120), field[:, 2:5])) / np.sqrt(2)
    assert np.abs(field[:, 5] - expected).max() < 1e-3 * expected.max()
    _, mean = field_of(small.folder, "image.hex", *plane)
    for row in mean[::11]:  # each of these points as a plane of its own, along the axes
        at = [f"{axis}={value}" for axis, value in zip("xyz", row[2:5])]
        _, one = field_of(small.folder, "image.hex", "--plane", f"xy@{at[2]}", "--x", f"{row[2]}:{row[2] + 1}", "--y", f"{row[3]}:{row[3] + 1}", "--step", 1)
        assert one[0, 2] == pytest.approx(row[5], rel=2e-3, abs=1e-4 * mean[:, 5].max())
    succeed(["field", "image.hex", *plane, "-o", "o.vti"], cwd=small.folder)
    image = xml.etree.ElementTree.fromstring((small.folder / "o.vti").read_bytes().split(b"<AppendedData")[0] + b"</VTKFile>").find("ImageData")
    direction = np.array(image.get("Direction").split(), float).reshape(3, 3)
    corner = np.array(image.get("Origin").split(), float)
    assert np.allclose(corner, field[0, 2:5]) and np.allclose(corner + direction @ (60, 70, 0), field[-1, 2:5])


def test_how_it_was_computed_and_how_far_it_may_be_off(small):
    focus = ["--focus", "0,0,130"]
    near = json.loads(succeed(["field", *focus, "--plane", "xy@z=8", "-o", "n.npy", "--json"], cwd=small.folder).stdout)
    assert near["points"] == 161 * 161 and near["method"] in ("sums", "shifts") and 0 < near["error"] <= 1e-4
    far = json.loads(succeed(["field", *focus, "-o", "f.npy", "--json"], cwd=small.folder).stdout)
    assert (far["region"], far["quantity"], far["method"]) == ("xy@z=130", "radiation_pressure_pa", "interpolated") and 0 < far["error"] <= 1e-4
    said = text(succeed(["field", "image.hex", "--step", 20], cwd=small.folder).stderr)
    assert said.startswith("81 points by sums of all waves, off by at most 3e-05 of the largest pressure")
    assert "nominal level: 4 Pa·m of " in said and not near["level"]["calibrated"]
    (small.folder / "measured.toml").write_text("[array]\nrows = 2\ncolumns = 2\npitch_mm = 10\n[transducer]\nsource_pa_m = 2\nmeasured = 'by a balance'\n")
    measured = [*focus, "--array", "./measured.toml", "--step", 20]
    assert "calibrated level: 2 Pa·m, by a balance" in text(succeed(["field", *measured], cwd=small.folder).stderr)
    assert json.loads(succeed(["field", *measured, "-o", "m.npy", "--json"], cwd=small.folder).stdout)["level"]["calibrated"]
    assert "calibrated level: 2 Pa·m, by a balance" in text(succeed(["solve", *focus, "--array", "./measured.toml"], cwd=small.folder).stdout)
    assert json.loads(succeed(["solve", *focus, "--array", "./measured.toml", "--json"], cwd=small.folder).stdout)["source_level"]["calibrated"]
    assert b"largest velocity" in succeed(["field", *focus, "--step", 20, "--quantity", "velocity"], cwd=small.folder).stderr


@pytest.mark.check
def test_an_image_makes_the_field_of_its_pulses(small):
    succeed(["simulate", "image.hex", "--load", "direct", "--passes", 3, "--pulses", "p.csv"], cwd=small.folder)
    arguments = ["--extent", 40, "--step", 5]
    _, asked = field_of(small.folder, "image.hex", *arguments)
    _, measured = field_of(small.folder, "--pulses", "p.csv", "--manifest", "image.json", *arguments)
    assert np.allclose(asked[:, 2], measured[:, 2], rtol=0.02, atol=0.01 * asked[:, 2].max())
    _, level = field_of(small.folder, "image.hex", *arguments, "--quantity", "spl")
    medium = read_json(small.manifest)["medium"]
    square = asked[:, 2] * medium["density_kg_m3"] * medium["speed_m_s"] ** 2 / 2
    assert np.allclose(level[:, 2], 10 * np.log10(square / 4e-10), atol=1e-3)


def test_many_points_are_told_of(tmp_path):
    many = ["field", "--focus", "0,0,130", "--extent", "1600", "-o", "many.npy"]
    assert b"warning: 10246401 points" in succeed(many, cwd=tmp_path).stderr
    assert b"points take" not in succeed([*many, "--step", "20"], cwd=tmp_path).stderr


def test_a_manifest_alone_has_exact_phases(small):
    arguments = ["--extent", 40, "--step", 5]
    _, exact = field_of(small.folder, "image.json", *arguments)
    _, ticks = field_of(small.folder, "image.hex", *arguments)
    assert np.allclose(exact[:, 2], ticks[:, 2], rtol=0.02, atol=0.01 * exact[:, 2].max()) and not np.array_equal(exact, ticks)
    _, one = field_of(small.folder, "image.json", "--record", 2, *arguments)
    assert one[:, 2].max() > 4 * exact[:, 2].max()


def test_particle_velocity_far_away_is_that_of_a_plane_wave(small):
    line = ["--focus", "0,0,900", "--line", "z@x=0,y=0", "--z", "1000:1100", "--step", 50]
    medium = read_json(small.manifest)["medium"]
    _, velocity = field_of(small.folder, *line, "--quantity", "velocity")
    _, rms = field_of(small.folder, *line, "--quantity", "rms")
    assert np.allclose(velocity[:, 1] * medium["density_kg_m3"] * medium["speed_m_s"], rms[:, 1], rtol=5e-3)


@pytest.mark.check
def test_one_record_of_an_image(small):
    focus = read_json(small.manifest)["records"][2]["focus_mm"]
    _, field = field_of(small.folder, "image.hex", "--record", 3, "--plane", f"xy@z={focus[2]}", "--extent", 40)
    assert np.abs(field[np.argmax(field[:, 2]), :2] - focus[:2]).max() <= 1.5


def test_a_volume_for_paraview(small):
    succeed(["field", "--focus", "0,0,100", "--volume", "--extent", 20, "--step", 5, "-o", "v.vti"], cwd=small.folder)
    succeed(["field", "--focus", "0,0,100", "--volume", "--extent", 20, "--step", 5, "-o", "v.npy"], cwd=small.folder)
    content = (small.folder / "v.vti").read_bytes()
    head, appended = content.split(b'<AppendedData encoding="raw">\n_', 1)
    image = xml.etree.ElementTree.fromstring(head + b"</VTKFile>").find("ImageData")
    assert image.get("WholeExtent") == "0 8 0 8 0 7" and image.get("Spacing") == "5 5 5" and image.get("Origin") == "-20 -20 5"
    (array,) = image.iter("DataArray")
    (size,) = struct.unpack("<Q", appended[:8])
    values = np.frombuffer(appended[8 : 8 + size], "<f4")
    assert array.get("Name") == "radiation_pressure_pa" and np.array_equal(values, np.load(small.folder / "v.npy").ravel())


def test_the_surface_half_the_greatest_pressure(small):
    """As the reader of shapes finds it: a closed body around the focus, as wide as the line through the focus says."""
    around = ["--x", "-30:30", "--y", "-30:30", "--step", 1]
    said = succeed(["field", "--focus", "10,0,100", "--volume", *around, "--z", "60:160", "-o", "s.stl"], cwd=small.folder)
    assert "triangles" in text(said.stderr) and "open" not in text(said.stderr)
    corners = np.frombuffer((small.folder / "s.stl").read_bytes()[84:], dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("_", "<u2")])["corners"]
    _, line = field_of(small.folder, "--focus", "10,0,100", "--line", "x@y=0,z=100", "--x", "-30:30", "--step", 0.1, "--quantity", "rms")
    _, up = field_of(small.folder, "--focus", "10,0,100", "--line", "z@x=10,y=0", "--z", "60:160", "--step", 0.1, "--quantity", "rms")
    most = max(line[:, 1].max(), up[:, 1].max())
    wide = line[line[:, 1] > most * 10 ** (-6 / 20), 0]
    near = corners.reshape(-1, 3)[np.abs(corners.reshape(-1, 3)[:, 2] - 100) < 0.3]
    assert len(near) > 10 and near[:, 0].min() == pytest.approx(wide[0], abs=0.6) and near[:, 0].max() == pytest.approx(wide[-1], abs=0.6)
    wider = succeed(["field", "--focus", "10,0,100", "--volume", *around, "--z", "60:160", "--below", 12, "-o", "w.stl", "--json"], cwd=small.folder)
    assert "open where it leaves the volume" in json.loads(wider.stdout)["surface"]
    assert (small.folder / "w.stl").stat().st_size > (small.folder / "s.stl").stat().st_size
    succeed(["compile", "s.stl", "--points", 50, "--size", 20, "-o", "shape.hex"], cwd=small.folder)
    for wrong in (["--plane", "xy@z=100", "-o", "p.stl"], ["--volume", "--step", 5, "--quantity", "complex", "-o", "c.stl"]):
        result = run(["field", "--focus", "10,0,100", *wrong], cwd=small.folder)
        assert result.returncode == USAGE and not (small.folder / wrong[-1]).exists()
        program_said(result.returncode, result.stderr)


@pytest.mark.parametrize("arguments", [["image.hex", "--step", 8], ["--focus", "0,0,100", "--line", "z@x=0,y=0", "--quantity", "spl"]])
def test_a_picture(arguments, small):
    said = succeed(["field", *arguments, "-o", "f.png"], cwd=small.folder, timeout=300)
    assert said.stdout == b"" and b"points by" in said.stderr
    content = (small.folder / "f.png").read_bytes()
    width, height = struct.unpack(">II", content[16:24])
    assert content.startswith(b"\x89PNG") and width > 500 and height > 500
    assert not [path.name for path in small.folder.iterdir() if path.name.startswith(".")]


def test_what_probes_read_of_an_image_and_of_its_pulses(tmp_path):
    """Hoshi's measurement, on a small board: a focus under a square of 100 Hz, along x; and the other paper's."""
    board = ["--board", "small-16-wide", "--array", array_for("small-16-wide", tmp_path)]
    succeed(["compile", "--shape", "point", "--center", "0,0,60", *board, "--am", "square:100", "-o", "image.hex"], cwd=tmp_path)
    succeed(["simulate", "image.hex", "--load", "direct", "--passes", 3, "--pulses", "p.csv"], cwd=tmp_path, timeout=300)
    line = ["--line", "x@y=0,z=60", "--extent", 12, "--step", 3]
    pins = ["--pulses", "p.csv", "--manifest", "image.json"]
    (header, asked), (_, measured) = (field_of(tmp_path, *what, *line, "--probe", "hoshi:100") for what in (["image.hex"], pins))
    names = [f"radiation_pressure_pa_{name}" for name in ("mean", "least", "greatest")]
    assert header.split(",") == ["x_mm", *names] and np.allclose(asked[:, 1], asked[:, 3], rtol=1e-4)
    assert np.allclose(measured[:, 1:], asked[:, 1:], rtol=0.03, atol=0.01 * asked[:, 1].max())
    _, mean = field_of(tmp_path, "image.hex", *line)  # the mean of a square is half of its top, whose 2/π is at 100 Hz
    assert np.allclose(asked[:, 1], 4 / np.pi * mean[:, 1], rtol=0.03, atol=0.01 * mean[:, 1].max())
    heard = [field_of(tmp_path, *what, *line, "--probe", "haptogram")[1] for what in (["image.hex"], pins)]
    assert np.allclose(*heard, rtol=0.03, atol=0.01 * heard[0][:, 1].max())
    succeed(["field", "image.hex", *line, "--probe", "hoshi:100", "-o", "p.npy"], cwd=tmp_path)
    succeed(["field", "image.hex", *line, "--probe", "hoshi:100", "-o", "p.png"], cwd=tmp_path)
    assert np.allclose(np.load(tmp_path / "p.npy"), asked[:, 1:], rtol=1e-4)


USAGES = {
    "an unknown probe": ["--focus", "0,0,100", "--probe", "robot"],
    "a probe of a quantity": ["--focus", "0,0,100", "--probe", "haptogram", "--quantity", "rms"],
    "a probe of one record": ["image.hex", "--probe", "haptogram", "--record", 1],
    "nothing to make it of": [],
    "two at once": ["image.hex", "--focus", "0,0,100"],
    "a focus of two numbers": ["--focus", "0,100"],
    "a focus of four numbers": ["--focus", "0,0,100,1"],
    "a focus on an element": ["--focus", "5,5,0"],
    "a focus behind the array": ["--focus", "0,0,-100"],
    "a record too many": ["image.hex", "--record", 9],
    "the phases of a sequence": ["image.hex", "--quantity", "complex"],
    "a picture of a volume": ["--focus", "0,0,100", "--volume", "--step", "20", "-o", "x.png"],
    "an unknown ending": ["--focus", "0,0,100", "-o", "x.jpg"],
    "a line and a plane": ["--focus", "0,0,100", "--line", "z@x=0,y=0", "--plane", "xy@z=1"],
    "a line behind the array": ["--focus", "0,0,100", "--line", "x@y=0,z=-1"],
    "an oblique plane by turns and a normal": ["--focus", "0,0,100", "--plane", "uv@z=130,rx=1,nx=1"],
    "an oblique plane through the array": ["--focus", "0,0,100", "--plane", "uv@z=30,rx=40"],
    "JSON and the field on one output": ["--focus", "0,0,100", "--json"],
    "a range the wrong way": ["--focus", "0,0,100", "--x", "5:1"],
    "a volume that no memory holds": ["--focus", "0,0,100", "--volume", "--step", "0.005"],
}


@pytest.mark.parametrize("case", USAGES)
def test_what_makes_no_sense(case, small):
    arguments = USAGES[case]
    assert_one_message(run(["field", *arguments], cwd=small.folder), USAGE)


def test_a_manifest_of_another_image(small):
    small.manifest.write_text(small.manifest.read_text().replace('"image_sha256": "', '"image_sha256": "0'))
    refuse(small.folder, ["field", "image.hex", "-o", "f.csv"], BAD_INPUT, outputs=("f.csv",))


@pytest.mark.parametrize("name", ["missing/f.png", "missing/f.vti", "missing/f.npy"])
def test_an_output_that_cannot_be_written(name, small):
    refuse(small.folder, ["field", "--focus", "0,0,100", "--step", 20, "-o", name], BAD_INPUT, outputs=("f.csv",))


def test_no_room_for_what_the_picture_is_made_of(small):
    result = run(["field", "--focus", "0,0,100", "--step", 20, "-o", "f.png"], cwd=small.folder, env={"TMPDIR": "/nowhere"})
    assert_one_message(result, BAD_INPUT)
