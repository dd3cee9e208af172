# SPDX-License-Identifier: Apache-2.0
"""`haptogram scatter`: sound on rigid bodies; rigs in `field` and `solve`. The report is checked against the values that it is made of."""
import json
import struct
import xml.etree.ElementTree

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, refuse, succeed, text

BALL = ["scatter", "sphere", "--radius", 5, "--center", "0,0,120"]
AIM = ["--focus", "0,0,115"]
FLAT_ICOSAHEDRON = (1 + np.sqrt(5)) / 2


def icosphere(halvings, radius):
    """A ball of triangles that the program has no part in."""
    g = FLAT_ICOSAHEDRON
    corners = [np.array(c) / np.hypot(1, g) for c in [
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]]  # fmt: skip
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
                 (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]  # fmt: skip
    for _ in range(halvings):
        found, middles = [], {}

        def middle(a, b, middles=middles):
            key = (min(a, b), max(a, b))
            if key not in middles:
                m = corners[a] + corners[b]
                corners.append(m / np.linalg.norm(m))
                middles[key] = len(corners) - 1
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            found += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = found
    return radius * np.array(corners), triangles


def write_obj(path, corners, triangles):
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")


MADE_ONCE = ["ball"]


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scatter")
    report = json.loads(text(succeed([*BALL, *AIM, "--json", "--flat", "-o", "ball.csv"], cwd=folder).stdout))
    return report, np.loadtxt(folder / "ball.csv", delimiter=",", skiprows=1)


def test_the_report_is_the_sum_of_its_triangles(ball):
    report, values = ball
    place, normal, area, radiation = values[:, :3], values[:, 3:6], values[:, 6], values[:, 8]
    assert report["triangles"] == len(values)
    assert report["area_mm2"] == pytest.approx(area.sum(), rel=1e-4)
    assert report["volume_mm3"] == pytest.approx(4 / 3 * np.pi * 5**3, rel=1e-4)
    force = -(radiation * area) @ normal * 1e-6 * 1e3
    assert report["force_mn"] == pytest.approx(force, abs=2e-3 * np.linalg.norm(force))
    assert report["highest_radiation_pa"] == pytest.approx(radiation.max(), rel=1e-4)
    assert report["highest_at_mm"] == pytest.approx(place[radiation.argmax()], abs=1e-3)
    assert report["wavelength_mm"] == pytest.approx(343.2 / 40, rel=1e-3)
    assert report["elements_per_wavelength"] == pytest.approx(report["wavelength_mm"] / np.sqrt(4 / np.sqrt(3) * area.mean()), rel=1e-4)
    assert report["residual"] <= 3e-4 and 3 < report["rounds"] < 60
    assert 0 < report["pressure_error"]["low"] < report["pressure_error"]["high"] < 0.03


def test_flat_skin_takes_more_than_a_ball(ball):
    """A ball of little more than a wavelength sends much round itself that a wall would send back."""
    report, _ = ball
    assert report["highest_radiation_pa"] < report["flat_estimate"]["highest_radiation_pa"] < 2 * report["highest_radiation_pa"]
    assert 0.02 < report["flat_estimate"]["difference"] < 0.5


def test_pressure_doubles_before_a_large_body(ball):
    """Where the sound meets the ball upright it is nearly a wall: between once and twice the free field's pressure."""
    _, values = ball
    line = text(succeed(["field", "--focus", "0,0,115", "--line", "z@x=0,y=0", "--z", "115:116", "--quantity", "rms"]).stdout)
    free = float(line.splitlines()[1].split(",")[1])
    facing = values[values[:, 5] < -0.99]
    assert 1.3 * free < facing[:, 7].mean() < 2.0 * free


def test_what_the_level_rests_on_is_said(ball, tmp_path):
    """A plane wave comes from no array, so it has none."""
    assert ball[0]["level"]["calibrated"] is False
    assert "nominal" in text(succeed([*BALL, *AIM], cwd=tmp_path).stdout)
    wave = [*BALL, "--plane-wave", "0,0,1"]
    assert "level" not in json.loads(text(succeed([*wave, "--json"], cwd=tmp_path).stdout))
    assert "nominal" not in text(succeed(wave, cwd=tmp_path).stdout)


def test_a_mesh_from_a_file_is_as_the_built_in_ball(ball, tmp_path):
    report, _ = ball
    corners, triangles = icosphere(3, 0.5)
    write_obj(tmp_path / "ball.obj", corners, triangles)
    found = json.loads(text(succeed(["scatter", "ball.obj", "--unit", "cm", "--center", "0,0,120", *AIM, "--json"], cwd=tmp_path).stdout))
    assert found["force_mn"][2] == pytest.approx(report["force_mn"][2], rel=0.03)
    assert found["highest_radiation_pa"] == pytest.approx(report["highest_radiation_pa"], rel=0.03)


def test_the_files(tmp_path):
    succeed([*BALL, *AIM, "-o", "ball.vtp"], cwd=tmp_path)
    piece = xml.etree.ElementTree.parse(tmp_path / "ball.vtp").getroot().find("PolyData/Piece")
    count = int(piece.get("NumberOfPolys"))
    polygons = [int(n) for n in piece.find("Polys/DataArray[@Name='connectivity']").text.split()]
    assert len(polygons) == 3 * count and max(polygons) == int(piece.get("NumberOfPoints")) - 1
    radiation = np.array([float(v) for v in piece.find("CellData/DataArray[@Name='radiation_pressure_pa']").text.split()])
    table = np.array([line.split(",") for line in text(succeed([*BALL, *AIM, "-o", "-"], cwd=tmp_path).stdout).splitlines()[1:]], float)
    assert radiation == pytest.approx(table[:, 8], rel=1e-4, abs=1e-4)
    succeed([*BALL, *AIM, "-o", "ball.png"], cwd=tmp_path, timeout=300)
    content = (tmp_path / "ball.png").read_bytes()
    assert content.startswith(b"\x89PNG") and min(struct.unpack(">II", content[16:24])) > 300


def test_foci_in_turn_and_a_path(tmp_path):
    (tmp_path / "path.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,-2,0,115\n1,2,0,115\n")
    turn = json.loads(text(succeed([*BALL, "--focus", "-2,0,115", "--focus", "2,0,115", "--json"]).stdout))
    path = json.loads(text(succeed([*BALL, "--path", "path.csv", "--json"], cwd=tmp_path).stdout))
    assert [s["share"] for s in turn["steps"]] == [0.5, 0.5] == [s["share"] for s in path["steps"]]
    assert path["force_mn"] == pytest.approx(turn["force_mn"])
    assert turn["force_mn"] == pytest.approx(np.mean([s["force_mn"] for s in turn["steps"]], axis=0))
    assert turn["steps"][0]["highest_at_mm"][0] < 0 < turn["steps"][1]["highest_at_mm"][0]


def test_a_rig_in_field_solve_and_scatter(tmp_path):
    succeed(["field", "--focus", "5,-5,150", "--rig", "cube-300", "--plane", "xy@z=150", "--extent", 20, "--step", 0.5, "-o", "f.csv"], cwd=tmp_path)
    x, y, level = np.loadtxt(tmp_path / "f.csv", delimiter=",", skiprows=1).T
    assert (x[level.argmax()], y[level.argmax()]) == pytest.approx((5, -5), abs=0.5)
    solved = json.loads(text(succeed(["solve", "--rig", "cube-300", "--focus", "0,0,150", "--focus", "20,0,150", "--json"]).stdout))
    assert len(solved["steps"][0]["drives"]) == 4 * 249
    assert solved["steps"][0]["quality"]["quantised"]["spread"] < 0.01
    succeed(["solve", "--rig", "cube-300", "--focus", "0,0,150", "-o", "x.hex"], cwd=tmp_path)
    at_focus = ["--line", "z@x=0,y=0", "--z", "150:151", "--quantity", "rms"]
    exact, tiles = (float(text(succeed(["field", *what, *at_focus], cwd=tmp_path).stdout).splitlines()[1].split(",")[-1])
                    for what in (["--focus", "0,0,150", "--rig", "cube-300"], ["x.json"]))  # fmt: skip
    assert tiles == pytest.approx(exact, rel=1e-3)
    found = json.loads(text(succeed(["scatter", "sphere", "--radius", 4, "--center", "0,0,150", "--focus", "0,0,146", "--rig", "cube-300", "--json"]).stdout))
    assert found["array"] == "cube-300" and found["force_mn"][2] > 0
    refuse(tmp_path, ["field", "--focus", "0,0,150", "--rig", "cube-400"], BAD_INPUT)


RING = ["scatter", "finger", "--rotate", "0,90,0", "--center", "0,0,150", "--ring", "0,0,150", "--inward", "-1,0,0", "--json"]


@pytest.mark.deep
def test_a_ring_on_four_sides_is_even_when_it_is_weighed():
    plain, weighed = (json.loads(text(succeed([*RING, "--rig", "cube-300", *more], timeout=300).stdout)) for more in ([], ["--weighed"]))
    for report in (plain, weighed):
        highest = [step["highest_radiation_pa"] for step in report["steps"]]
        assert len(highest) == 10 == report["ring"]["foci"]
        assert report["ring"]["uneven"] == pytest.approx(max(highest) / min(highest))
        assert report["ring"]["farthest_mm"] < 2
        for step in report["steps"]:
            x, y, z = step["foci"][0]["position_mm"]
            assert x == pytest.approx(0, abs=1e-6) and np.hypot(y, z - 150) == pytest.approx(8, rel=0.01)
    assert plain["ring"]["uneven"] > 3
    assert weighed["ring"]["uneven"] < 1.5
    assert min(step["foci"][0]["amplitude"] for step in weighed["steps"]) < 0.7


def test_a_ring_that_one_tile_cannot_close():
    """From below alone the sound that is aimed at the finger's back presses on its underside."""
    tile = [word.replace("0,0,150", "0,0,130") for word in RING]
    plain, weighed = (json.loads(text(succeed([*tile, *more]).stdout)) for more in ([], ["--weighed"]))
    assert plain["ring"]["foci"] == 10 and plain["ring"]["farthest_mm"] > 8
    assert 3 <= weighed["ring"]["foci"] <= 6 and weighed["ring"]["farthest_mm"] < 5
    assert weighed["resting"] == pytest.approx(1 - weighed["ring"]["foci"] / 10)
    assert weighed["ring"]["uneven"] < 1.5


def test_what_is_refused_of_a_ring(tmp_path):
    refuse(tmp_path, [*BALL, "--ring", "0,0,120"], USAGE)
    refuse(tmp_path, [*RING[:6], "--ring", "0,0,190"], USAGE)
    refuse(tmp_path, [*RING, "--radius", "12", "--weighed"], USAGE)
    refuse(tmp_path, [*BALL, *AIM, "--weighed"], USAGE)


def test_what_is_refused(tmp_path):
    corners, triangles = icosphere(2, 5.0)
    write_obj(tmp_path / "open.obj", corners, triangles[:-1])
    write_obj(tmp_path / "inside-out.obj", corners, [(a, c, b) for a, b, c in triangles])
    write_obj(tmp_path / "coarse.obj", *icosphere(1, 5.0))
    (tmp_path / "cloud.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n")
    at = ["--center", "0,0,120", *AIM]
    refuse(tmp_path, ["scatter", "open.obj", *at], BAD_INPUT)
    refuse(tmp_path, ["scatter", "inside-out.obj", *at], BAD_INPUT)
    refuse(tmp_path, ["scatter", "coarse.obj", *at], BAD_INPUT)
    refuse(tmp_path, ["scatter", "cloud.xyz", *at], BAD_INPUT)
    refuse(tmp_path, [*BALL, "--focus", "0,0,120"], BAD_INPUT)
    refuse(tmp_path, [*BALL], USAGE)
    refuse(tmp_path, [*BALL, *AIM, "--length", 20], USAGE)
    refuse(tmp_path, [*BALL, *AIM, "--edge", 9], USAGE)
    refuse(tmp_path, [*BALL, *AIM, "--edge", 0.001], USAGE)
    refuse(tmp_path, [*BALL, *AIM, "-o", "ball.stl"], USAGE)
    refuse(tmp_path, [*BALL, "--focus", "0,0,-5"], BAD_INPUT)


def test_a_plane_wave(tmp_path):
    """On a rigid ball of ka = 1, the series of its total pressure has 1.418 in front (tests/unit/test_scattering.cpp)."""
    k = 2 * np.pi * 40e3 / 343.2
    ball = ["scatter", "sphere", "--radius", f"{1e3 / k:.9g}", "--edge", "0.1", "--center", "0,0,50"]
    succeed([*ball, "--plane-wave", "0,0,2", "-o", "wave.csv"], cwd=tmp_path)
    names, *rows = (tmp_path / "wave.csv").read_text().splitlines()
    column = [name for name in names.split(",") if "rms" in name][0]
    table = {name: np.array(values, float) for name, values in zip(names.split(","), zip(*(row.split(",") for row in rows)))}
    front = table[column][table["z_mm"].argmin()]
    assert front * np.sqrt(2) == pytest.approx(1.4184, rel=0.02)
    refuse(tmp_path, [*ball, "--plane-wave", "0,0,0"], USAGE)
    refuse(tmp_path, [*ball, "--plane-wave", "0,0,1", "--focus", "0,0,40"], USAGE)
