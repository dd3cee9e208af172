# SPDX-License-Identifier: Apache-2.0
"""What compile makes of shapes and options, seen in its report and its manifest."""
import json
import os
import re
import shutil

import numpy as np
import pytest
from support import BAD_INPUT, OK, ROOT, USAGE, Image, foci_mm, read_json, refuse, run, snapshot, succeed, text

KINDS = ["point", "line", "circle", "triangle", "square", "plus", "polygon", "sphere", "hemisphere", "cube", "cone", "cylinder", "helix"]


def manifest_of(folder, *arguments):
    succeed(["compile", *arguments, "-o", "image.hex"], cwd=folder)
    return read_json(folder / "image.json")


def foci_of(folder, *arguments):
    return foci_mm(manifest_of(folder, *arguments))


def report_of(folder, *arguments):
    return json.loads(succeed(["compile", *arguments, "-o", "image.hex", "--json"], cwd=folder).stdout)


def extent(points):
    return points.max(axis=0) - points.min(axis=0)


def centre(points):
    return (points.max(axis=0) + points.min(axis=0)) / 2


@pytest.mark.parametrize("kind", KINDS)
def test_every_built_in_shape_compiles(kind, tmp_path):
    points = foci_of(tmp_path, "--shape", kind, "--points", "40", "--seed", "3")
    assert len(points) == (1 if kind == "point" else 40)
    assert len({tuple(p) for p in points}) == len(points), "a point twice"
    assert np.all(np.abs(centre(points) - [0, 0, 130]) < 6), "not where the paper shows its shapes"
    flat = kind in ("line", "circle", "triangle", "square", "plus", "polygon")
    assert (extent(points)[2] < 1e-3) == (flat or kind == "point")
    assert run(["inspect", "image.hex"], cwd=tmp_path).returncode == OK


def test_the_help_lists_every_built_in_shape():
    assert ", ".join(KINDS) in text(succeed(["compile", "--help"]).stdout)


@pytest.mark.check
def test_a_circle_is_one(tmp_path):
    points = foci_of(tmp_path, "--shape", "circle", "--diameter", "70", "--points", "30")
    assert np.allclose(np.hypot(points[:, 0], points[:, 1]), 35.0, atol=1e-3) and np.all(points[:, 2] == 130.0)
    gaps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    assert np.allclose(gaps, 2 * 35 * np.sin(np.pi / 30), atol=1e-3), "not even, or not visited in order"


def test_a_sphere_is_covered_evenly(tmp_path):
    points = foci_of(tmp_path, "--shape", "sphere", "--diameter", "60", "--points", "100") - [0, 0, 130]
    assert np.allclose(np.linalg.norm(points, axis=1), 30.0, atol=0.2)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + np.diag(np.full(100, np.inf))
    assert apart.min() > 0.6 * np.sqrt(4 * np.pi * 30**2 / 100), "clumps"


def test_measures_of_built_in_shapes(tmp_path):
    assert np.allclose(extent(foci_of(tmp_path, "--shape", "line", "--length", "44", "--points", "5")), [44, 0, 0], atol=1e-3)
    assert np.allclose(extent(foci_of(tmp_path, "--shape", "square", "--length", "40", "--points", "80")), [40, 40, 0], atol=1e-3)
    assert np.allclose(extent(foci_of(tmp_path, "--shape", "helix", "--height", "33", "--points", "80"))[2], 33, atol=1e-3)
    assert len(foci_of(tmp_path, "--shape", "polygon", "--sides", "5", "--points", "5")) == 5


CLOUD = b"0 0 100\n20 0 100\n0 10 100\n0 0 104\n"


@pytest.fixture
def cloud(tmp_path):
    (tmp_path / "cloud.xyz").write_bytes(CLOUD)
    return tmp_path


def as_set(points):
    return {tuple(np.round(p, 3) + 0.0) for p in points}


def test_a_small_cloud_is_taken_whole_and_where_it_is(cloud):
    assert as_set(foci_of(cloud, "cloud.xyz")) == {(0, 0, 100), (20, 0, 100), (0, 10, 100), (0, 0, 104)}


def test_unit(cloud):
    (cloud / "metres.xyz").write_bytes(b"0 0 0.100\n0.020 0 0.100\n0 0.010 0.100\n0 0 0.104\n")
    (cloud / "cm.xyz").write_bytes(b"0 0 10\n2 0 10\n0 1 10\n0 0 10.4\n")
    expected = as_set(foci_of(cloud, "cloud.xyz"))
    assert as_set(foci_of(cloud, "metres.xyz", "--unit", "m")) == expected
    assert as_set(foci_of(cloud, "cm.xyz", "--unit", "cm")) == expected


@pytest.mark.check
def test_a_shape_from_standard_input(cloud):
    expected = foci_of(cloud, "cloud.xyz")
    with open(cloud / "cloud.xyz", "rb") as piped:
        succeed(["compile", "-", "-o", "piped.hex"], cwd=cloud, stdin=piped)
    assert np.allclose(foci_mm(read_json(cloud / "piped.json")), expected)
    refuse(cloud, ["compile", "-"], BAD_INPUT)


def test_files_with_y_upwards_are_stood_up(cloud):
    corners = b"v 0 100 0\nv 20 100 0\nv 0 100 -10\nf 1 2 3\n"
    (cloud / "up.obj").write_bytes(corners)
    (cloud / "habit.obj").write_bytes(b"# Blender v2.80 OBJ File\n" + corners)
    (cloud / "up.toml").write_text('format = "haptogram-project-1"\n[[shape]]\nfile = "up.obj"\nup = "y"\n', encoding="utf-8")
    expected = foci_of(cloud, "up.obj", "--up", "y", "--points", "20")
    assert np.allclose(expected[:, 2], 100) and np.all(expected[:, 1] > -1e-3)
    assert np.allclose(foci_of(cloud, "up.toml", "--points", "20"), expected)
    refuse(cloud, ["compile", "--shape", "circle", "--up", "y"], USAGE)
    for more, told in (([], True), (["--up", "z"], False)):
        said = text(run(["compile", "habit.obj", "--center", "0,0,120", *more, "-o", "h.hex"], cwd=cloud).stderr)
        assert ("y upwards" in said) is told


def test_a_face_that_crosses_itself_is_told(cloud):
    (cloud / "tie.obj").write_bytes(b"v 0 0 100\nv 20 0 100\nv 20 20 100\nv 0 20 100\nf 1 3 2 4\n")
    told = text(succeed(["compile", "tie.obj", "--points", "20", "-o", "tie.hex"], cwd=cloud).stderr)
    assert "tie.obj: 1 of its 1 faces cross themselves, face 1 first" in told


def test_center_moves_the_middle_of_the_box(cloud):
    points = foci_of(cloud, "cloud.xyz", "--center", "5,-6,120")
    assert np.allclose(centre(points), [5, -6, 120], atol=1e-3) and np.allclose(extent(points), [20, 10, 4], atol=1e-3)


def test_size_sets_the_largest_extent_and_keeps_the_middle(cloud):
    points = foci_of(cloud, "cloud.xyz", "--size", "50")
    assert np.allclose(extent(points), [50, 25, 10], atol=1e-3) and np.allclose(centre(points), [10, 5, 102], atol=1e-3)


def test_scale_multiplies_every_coordinate(cloud):
    assert as_set(foci_of(cloud, "cloud.xyz", "--scale", "1.5")) == {(0, 0, 150), (30, 0, 150), (0, 15, 150), (0, 0, 156)}


def test_rotate_turns_about_x_then_y_then_z(cloud):
    assert np.allclose(extent(foci_of(cloud, "cloud.xyz", "--rotate", "0,0,90")), [10, 20, 4], atol=1e-3)
    assert np.allclose(extent(foci_of(cloud, "cloud.xyz", "--rotate", "90,0,0")), [20, 4, 10], atol=1e-3)
    assert np.allclose(extent(foci_of(cloud, "cloud.xyz", "--rotate", "90,0,90")), [4, 20, 10], atol=1e-3)
    # Counter-clockwise, seen from the tip of the axis: the corner at +x goes to +y.
    turned = foci_of(cloud, "cloud.xyz", "--rotate", "0,0,90", "--center", "0,0,102")
    assert as_set(turned) == {(5, -10, 100), (5, 10, 100), (-5, -10, 100), (5, -10, 104)}


@pytest.mark.check
def test_several_inputs_become_one_shape(cloud):
    (cloud / "more.csv").write_bytes(b"x,y,z\n-30,0,110\n-30,5,110\n")
    points = as_set(foci_of(cloud, "cloud.xyz", "more.csv"))
    assert points == {(0, 0, 100), (20, 0, 100), (0, 10, 100), (0, 0, 104), (-30, 0, 110), (-30, 5, 110)}
    both = foci_of(cloud, "cloud.xyz", "more.csv", "--center", "0,0,120")
    assert len(both) == 6 and np.allclose(centre(both), [0, 0, 120], atol=1e-3), "each placed by itself"


def test_a_file_and_a_built_in_shape_together(cloud):
    assert len(foci_of(cloud, "cloud.xyz", "--shape", "circle", "--points", "30", "--center", "0,0,120")) == 30


def test_duplicates_are_left_out_and_counted(cloud):
    (cloud / "twice.xyz").write_bytes(CLOUD + CLOUD)
    report = report_of(cloud, "twice.xyz")
    assert (report["points"], report["duplicates"]) == (4, 4)


@pytest.mark.parametrize("name", ["trimesh_ascii.ply", "trimesh_little.ply", "plyfile_big.ply", "trimesh.obj", "meshio_binary.stl", "meshio_ascii.stl"])
def test_a_mesh_of_another_program_gives_points_on_its_surface(name, tmp_path):
    shutil.copy(ROOT / "tests/data/shapes" / name, tmp_path / name)
    points = foci_of(tmp_path, name, "--points", "60", "--center", "5,10,120.25") - [0, 0, 100]
    assert len(points) == 60
    weights = points / [10, 20, 40.5]
    inside = 1 - weights.sum(axis=1)
    nearest = np.minimum(np.abs(inside), np.abs(weights).min(axis=1))
    assert np.all(nearest < 1e-4) and np.all(weights > -1e-4) and np.all(inside > -1e-4)


# Reach: the tile's farthest angle is 60°, its nearest range 23.6 mm (10·d²/4λ for d = 9 mm).

OUT_OF_REACH = {
    "behind": b"0 0 100\n7 8 -5\n",
    "on the array": b"0 0 100\n7 8 0\n",
    "too near": b"0 0 100\n5 5 23\n",
    "beyond the angle": b"0 0 100\n180 0 100\n",
}


@pytest.mark.parametrize("case", OUT_OF_REACH)
def test_points_out_of_reach_are_listed(case, tmp_path):
    (tmp_path / "cloud.xyz").write_bytes(OUT_OF_REACH[case])
    refuse(tmp_path, ["compile", "cloud.xyz", "-o", "image.hex"], BAD_INPUT)


@pytest.mark.parametrize("case", OUT_OF_REACH)
def test_clip_leaves_them_out_and_says_so(case, tmp_path):
    (tmp_path / "cloud.xyz").write_bytes(OUT_OF_REACH[case])
    assert report_of(tmp_path, "cloud.xyz", "--clip")["clipped"] == 1
    assert as_set(foci_of(tmp_path, "cloud.xyz", "--clip")) == {(0, 0, 100)}
    assert b"1 out of reach left out" in succeed(["compile", "cloud.xyz", "--clip", "-o", "image.hex"], cwd=tmp_path).stdout


def test_a_point_just_within_reach(tmp_path):
    (tmp_path / "cloud.xyz").write_bytes(b"173 0 100\n5 5 24\n")
    assert len(foci_of(tmp_path, "cloud.xyz")) == 2


def test_clip_that_leaves_nothing(tmp_path):
    refuse(tmp_path, ["compile", "--shape", "circle", "--center", "0,0,-50", "--clip"], BAD_INPUT)


def test_many_points_out_of_reach_are_counted(tmp_path):
    refuse(tmp_path, ["compile", "--shape", "circle", "--center", "0,0,-50"], BAD_INPUT)


@pytest.mark.check
def test_the_tour_is_closed_and_reported(tmp_path):
    rows = [(x, y) for x in range(0, 60, 10) for y in range(0, 60, 10)]
    shuffled = sorted(rows, key=lambda r: (r[0] * 7 + r[1] * 13) % 101)
    (tmp_path / "grid.xyz").write_text("".join(f"{x} {y} 120\n" for x, y in shuffled))
    report = report_of(tmp_path, "grid.xyz")
    points = foci_mm(read_json(tmp_path / "image.json"))

    def closed(p):
        return np.linalg.norm(p - np.roll(p, -1, axis=0), axis=1).sum()

    assert report["tour_mm"] == pytest.approx(closed(points), abs=1e-2)
    assert report["tour_as_given_mm"] == pytest.approx(closed(np.array([(x, y, 120) for x, y in shuffled])), abs=1e-2)
    assert report["tour_mm"] < 1.1 * 360, "36 points 10 mm apart can be visited in 360 mm"
    assert as_set(points) == {(x, y, 120) for x, y in rows}
    assert re.search(r"tour +3\d\d\.\d mm, \d+\.\d mm as given", text(succeed(["compile", "grid.xyz", "-o", "image.hex"], cwd=tmp_path).stdout))


@pytest.mark.check
def test_the_json_report(tmp_path):
    result = succeed(["compile", "--shape", "circle", "--points", "8", "--rate", "500", "-o", "image.hex", "--json"], cwd=tmp_path)
    report = json.loads(result.stdout)
    assert set(report) >= {
        "array", "points", "clipped", "duplicates", "tour_mm", "tour_as_given_mm", "prescaler", "cycle_ticks", "pulse_ticks", "carrier_hz", "rate_hz",
        "shortest_dwell_s", "flight_spread_s", "beta_periods", "formation_s", "formation_with_ring_up_s", "most_points", "most_points_with_ring_up",
        "image", "image_bytes", "manifest"}
    assert report["image_bytes"] == (tmp_path / "image.hex").stat().st_size
    assert (report["image"], report["manifest"]) == ("image.hex", "image.json")
    assert report["prescaler"] * report["cycle_ticks"] == 50_000_000 / 40_000 and report["pulse_ticks"] == report["cycle_ticks"] / 2


def test_formation_follows_the_paper(tmp_path):
    """Haptogram III-G, recomputed from the manifest: ΔT, β, T_f and V."""
    report = report_of(tmp_path, "--shape", "circle", "--points", "8", "--rate", "30")
    manifest = read_json(tmp_path / "image.json")
    elements = np.array(manifest["array"]["elements_mm"]) * 1e-3
    flights = np.linalg.norm(foci_mm(manifest)[:, None] * 1e-3 - elements[None], axis=2) / manifest["medium"]["speed_m_s"]
    spread = (flights.max(axis=1) - flights.min(axis=1)).max()
    beta = int(np.ceil(40e3 * spread))
    assert report["flight_spread_s"] == pytest.approx(spread, rel=1e-5)
    assert report["beta_periods"] == beta
    clocks = (report["formation_s"] - beta / 40e3) * 50e6
    assert 100 <= clocks <= 108.5, "C, the clocks to load a record: a word a clock, at most the paper's 108"
    ring_up = 2.302585 / (np.pi * 2000)
    assert report["formation_with_ring_up_s"] - report["formation_s"] == pytest.approx(ring_up, rel=1e-4)
    assert report["most_points"] == int(1 / (30 * report["formation_s"]))
    assert report["most_points_with_ring_up"] == int(1 / (30 * report["formation_with_ring_up_s"]))
    shown = text(succeed(["compile", "--shape", "circle", "--points", "8", "--rate", "30", "-o", "image.hex"], cwd=tmp_path).stdout)
    assert f"ΔT  {spread * 1e6:.1f} µs, β = {beta} periods" in shown and f"at most {report['most_points']} points" in shown


def test_a_short_dwell_is_warned_of_with_the_numbers(tmp_path):
    result = succeed(["compile", "--shape", "circle", "--points", "200", "--rate", "100", "-o", "image.hex", "--json"], cwd=tmp_path)
    report = json.loads(result.stdout)
    warning = text(result.stderr)
    assert report["shortest_dwell_s"] == pytest.approx(50e-6) and report["shortest_dwell_s"] < report["formation_s"]
    assert warning.startswith("haptogram: warning: ") and warning.count("\n") == 1
    assert "50.0 µs" in warning and f"{report['formation_s'] * 1e6:.1f} µs" in warning


def test_a_warning_does_not_contradict_its_own_numbers(tmp_path):
    # 250 µs is longer than the 102 µs in which a focus forms, but shorter than with ring-up.
    warning = text(succeed(["compile", "--shape", "circle", "--points", "8", "--rate", "500", "-o", "image.hex"], cwd=tmp_path).stderr)
    compared = re.findall(r"([\d.]+) µs, (?:which is )?shorter than (?:the )?([\d.]+) µs", warning)
    assert compared or not warning
    for shown, limit in compared:
        assert float(shown) < float(limit), warning


def test_a_long_dwell_is_not_warned_of(tmp_path):
    assert succeed(["compile", "--shape", "circle", "--points", "8", "--rate", "10", "-o", "image.hex"], cwd=tmp_path).stderr == b""


def test_an_amplitude_makes_pulses_shorter_and_nothing_else(tmp_path):
    """By D = (T/π)·asin(a): a half is a third of the full length, which is T/2."""
    full = manifest_of(tmp_path, "--shape", "circle", "--points", "4")
    before = Image(tmp_path / "image.hex").records()
    half = manifest_of(tmp_path, "--shape", "circle", "--points", "4", "--amplitude", "0.5")
    after = Image(tmp_path / "image.hex").records()
    assert [r["amplitude"] for r in half["records"]] == [0.5] * 4 and "amplitude" not in full["records"][0]
    ticks = half["timer"]["cycle_ticks"]
    assert [r["pulse_length"] for r in after] == [round(ticks / np.pi * np.arcsin(0.5))] * 4
    assert [r["timings"] for r in after] == [r["timings"] for r in before]
    (tmp_path / "half.toml").write_text('format = "haptogram-project-1"\npoints = 4\namplitude = 0.5\n[[shape]]\nkind = "circle"\n')
    succeed(["compile", "half.toml", "-o", "project.hex"], cwd=tmp_path)
    assert (tmp_path / "project.hex").read_bytes() == (tmp_path / "image.hex").read_bytes()
    assert (tmp_path / "project.json").read_bytes() == (tmp_path / "image.json").read_bytes()
    refuse(tmp_path, ["compile", "--shape", "circle", "--amplitude", "0"], USAGE)
    refuse(tmp_path, ["compile", "--shape", "circle", "--amplitude", "1.5"], USAGE)
    refuse(tmp_path, ["compile", "--shape", "circle", "--amplitude", "0.001"], USAGE)
    refuse(tmp_path, ["compile", "--shape", "circle", "--amplitude", "0.5", "--magnitude", "2", "--am", "sine:200"], USAGE)


@pytest.mark.parametrize("fade", ["left:0.5", "right:0.25", "front:0", "back:0.9"])
@pytest.mark.parametrize("kind", ["--records", "--foci"])
def test_a_fade_makes_one_side_weaker_by_a_line(fade, kind, tmp_path):
    """At a part u of the way from the weakest to the strongest side the amplitude is s + (1 - s)·u; pulses are as long as that says."""
    side, share = fade.split(":")[0], float(fade.split(":")[1])
    axis, way = {"left": (0, -1), "right": (0, 1), "front": (1, -1), "back": (1, 1)}[side]
    board = ["--board", "colorlight-5a-75e-v7.1-wide"] if kind == "--foci" else []
    arguments = ["--shape", "circle", "--diameter", 60, "--points", 24, "--center", "5,-7,140", kind, *board]
    plain = foci_of(tmp_path, *arguments)
    faded = manifest_of(tmp_path, *arguments, "--fade", fade)
    along = way * (plain[:, axis] - (5, -7)[axis]) / 30
    wanted = share + (1 - share) * (along + 1) / 2
    played = wanted > 1e-9  # the one point of no amplitude is silence
    assert np.allclose(foci_mm(faded), plain[played], atol=1e-6)
    amplitudes = [record.get("amplitude", 1.0) for record in faded["records"]]
    assert np.allclose(amplitudes, wanted[played], atol=1 / 255 if kind == "--foci" else 1e-6)
    if kind == "--records":
        ticks = faded["timer"]["cycle_ticks"]
        pulses = np.array([record["pulse_length"] for record in Image(tmp_path / "image.hex").records()])
        assert np.allclose(np.sin(np.pi * pulses / ticks), wanted[played], atol=np.pi / ticks)
    assert sum(record["dwell_cycles"] for record in faded["records"]) >= 4000 * (len(amplitudes) - 1) / 24


def test_a_fade_moves_with_its_shape_and_says_what_it_cannot_be(tmp_path):
    ring = 'format = "haptogram-project-1"\npoints = 8\nrate_hz = 10\nfade = "right:0.5"\n[[shape]]\nkind = "circle"\ndiameter_mm = 40\n'
    turned = "[[keyframe]]\ntime_s = 0\nrotate_deg = [0, 0, 180]\n[[keyframe]]\ntime_s = 0.1\nrotate_deg = [0, 0, 180]\n"
    (tmp_path / "ring.toml").write_text(ring + turned)
    records = manifest_of(tmp_path, "ring.toml")["records"]
    for record in records:
        assert abs(record.get("amplitude", 1.0) - (0.75 - record["focus_mm"][0] / 80)) < 1e-6, "the strong side was turned to the left"
    (tmp_path / "none.toml").write_text(ring.replace("right:0.5", "x:0.5"))
    refuse(tmp_path, ["compile", "none.toml"], BAD_INPUT)
    circle = ["compile", "--shape", "circle"]
    for wrong in ("left", "-x:0.5", "up:0.5", "left:1", "left:-0.1", "left:nan", "left:0.5mm", "left:", "left:1E-1", "left:9.9e-0", "left:0.1234567", "left:00.5"):
        refuse(tmp_path, [*circle, f"--fade={wrong}"], USAGE)
    refuse(tmp_path, [*circle, "--fade", "below:0.5"], USAGE)
    refuse(tmp_path, [*circle, "--fade", "left:0.5", "--magnitude", "2", "--am", "sine:200"], USAGE)


@pytest.mark.parametrize("rate", [7, 10, 30, 33.3, 123.4])
def test_dwells_add_up_to_one_period_of_the_rate(rate, tmp_path):
    manifest = manifest_of(tmp_path, "--shape", "circle", "--points", "97", "--rate", rate)
    dwells = [r["dwell_cycles"] for r in manifest["records"]]
    assert sum(dwells) == round(40_000 / rate) and max(dwells) - min(dwells) <= 1 and min(dwells) >= 1
    assert manifest["rendering"]["rate_hz"] == pytest.approx(40_000 / sum(dwells))
    assert [e >> 16 for e in Image(tmp_path / "image.hex").sequence()[1:]] == dwells


@pytest.mark.check
def test_the_manifest_says_what_the_image_means(compiled):
    manifest = read_json(compiled / "image.json")
    assert manifest["tool"]["name"] == "haptogram" and text(run(["--version"]).stdout).startswith(f"haptogram {manifest['tool']['version']}\n")
    for name in ("inputs_sha256", "image_sha256"):
        assert re.fullmatch("[0-9a-f]{64}", manifest[name])
    grid = [[(q - 4.5) * 10, (r - 4.5) * 10, 0.0] for r in range(10) for q in range(10)]
    assert manifest["array"]["elements_mm"] == grid, "channel order is row · columns + column"
    timer = manifest["timer"]
    assert timer["tick_s"] == pytest.approx(timer["prescaler"] / 50e6) and timer["cycle_ticks"] * timer["tick_s"] == pytest.approx(25e-6)
    assert timer["pulse_ticks"] * 2 == timer["cycle_ticks"]
    assert [r["index"] for r in manifest["records"]] == list(range(1, 9))
    assert all(len(r["focus_mm"]) == 3 and r["dwell_cycles"] == 10 for r in manifest["records"])


def test_the_manifest_of_the_larger_array(tmp_path):
    manifest = manifest_of(tmp_path, "--shape", "circle", "--points", "4", "--array", "hoshi-18x18")
    elements = manifest["array"]["elements_mm"]
    assert len(elements) == 324 and elements[0] == [-85, -85, 0] and elements[1] == [-75, -85, 0] and elements[18] == [-85, -75, 0]
    assert manifest["medium"]["speed_m_s"] == 340.0 and Image(tmp_path / "image.hex").channels == 324


def test_elements_in_an_order_of_their_own_and_silent_channels(tmp_path):
    (tmp_path / "ring.toml").write_text("[array]\nelements_mm = [[30, 0], [0, 30.5], [-30, 0]]\n[medium]\ntemperature_c = 30\n[board]\nchannels = 16\n")
    manifest = manifest_of(tmp_path, "--shape", "point", "--array", "./ring.toml")
    assert manifest["array"]["elements_mm"] == [[30, 0, 0], [0, 30.5, 0], [-30, 0, 0]]
    assert manifest["medium"]["speed_m_s"] == pytest.approx(349.0, abs=0.1)  # 331.3·√(1 + 30/273.15)
    timings = Image(tmp_path / "image.hex").records()[0]["timings"]
    assert len(timings) == 16 and timings[3:] == [0xFFFF] * 13 and max(timings[:3]) < 250


def test_the_image_hash_is_of_the_image(compiled):
    import hashlib

    assert read_json(compiled / "image.json")["image_sha256"] == hashlib.sha256((compiled / "image.hex").read_bytes()).hexdigest()


def test_the_input_hash_follows_every_input(cloud):
    def hashes(*arguments):
        return manifest_of(cloud, *arguments)["inputs_sha256"]

    first = hashes("cloud.xyz")
    assert hashes("cloud.xyz") == first
    others = [hashes("cloud.xyz", *more) for more in (["--rate", "11"], ["--seed", "2"], ["--center", "0,0,110"], ["--scale", "1.1"], ["--array", "hoshi-18x18"])]
    (cloud / "cloud.xyz").write_bytes(CLOUD.replace(b"104", b"105"))
    assert len({first, hashes("cloud.xyz"), *others}) == 7


def test_image_on_standard_output(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 8, "-o", "image.hex"], cwd=tmp_path)
    result = succeed(["compile", "--shape", "circle", "--points", 8, "-o", "-", "--manifest", "other.json"], cwd=tmp_path)
    assert result.stdout == (tmp_path / "image.hex").read_bytes()
    assert (tmp_path / "other.json").read_bytes() == (tmp_path / "image.json").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["image.hex", "image.json", "other.json"]


def test_readmemh_words_are_those_of_the_image(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 8, "--loops", 3, "-o", "image.hex", "--readmemh", "words"], cwd=tmp_path)
    image = Image(tmp_path / "image.hex")
    assert (tmp_path / "words.primary.mem").read_text() == "".join(f"{w:04x}\n" for w in image.primary())
    assert (tmp_path / "words.sequence.mem").read_text() == "".join(f"{w:08x}\n" for w in image.sequence())


@pytest.mark.check
def test_same_input_same_bytes(tmp_path):
    mesh = (ROOT / "tests/data/shapes/trimesh_little.ply").read_bytes()
    results = []
    for number, (locale, mtime) in enumerate((("C", 1e9), ("C.UTF-8", 1.5e9), ("en_US.UTF-8", 5e8))):
        folder = tmp_path / f"folder {number}"  # of another name each, with a space
        folder.mkdir()
        (folder / "mesh.ply").write_bytes(mesh)
        os.utime(folder / "mesh.ply", (mtime, mtime))
        arguments = ["compile", "mesh.ply", "--points", 50, "--center", "0,0,120", "-o", "image.hex", "--readmemh", "words"]
        shown = succeed(arguments, cwd=folder, env={"LC_ALL": locale, "TZ": f"UTC{number}"}).stdout
        results.append((shown, snapshot(folder)))
    assert results[0] == results[1] == results[2]
    outside = tmp_path / "outside"
    outside.mkdir()
    succeed(["compile", tmp_path / "folder 0" / "mesh.ply", "--points", 50, "--center", "0,0,120", "-o", "image.hex"], cwd=outside)
    for name in ("image.hex", "image.json"):
        assert (outside / name).read_bytes() == results[0][1][name], "the folder it is called from changes the bytes"


def test_another_seed_gives_other_points_of_a_surface(tmp_path):
    one, again, two = (as_set(foci_of(tmp_path, "--shape", "sphere", "--points", "40", "--seed", seed)) for seed in ("1", "1", "2"))
    assert one == again and len(one & two) < 10
