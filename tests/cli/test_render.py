# SPDX-License-Identifier: Apache-2.0
"""Hands that feel objects: from a hand to a path, its image and the simulated board, with the report and the picture beside it."""

import json

import numpy as np
import pytest
from messages import notice
from support import BAD_INPUT, USAGE, Image, foci_mm, read_json, refuse, succeed, text

CARRIER_HZ = 40_000
PRESS = ["--hand", "synthetic:press:150", "--center", "0,0,150"]
# Of a Leap, which has y up: a flat hand without fingers, 150 mm above the array, and one frame without a hand.
LEAP = {
    "frames": [
        {"timestamp": 1_000_000, "pointables": [],
         "hands": [{"id": 7, "type": "right", "palmPosition": [0, 150, 0], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}]},
        {"timestamp": 1_010_000, "hands": [], "pointables": []},
    ]
}  # fmt: skip


def rendered(folder, *arguments):
    """The report, and where the focus is in each carrier period (NaN in silence)."""
    report = json.loads(succeed(["render", *arguments, "-o", "path.json", "--report", "--json"], cwd=folder).stdout)
    path = read_json(folder / "path.json")
    assert path["format"] == "haptogram-path-1"
    where = [(step["foci"][0]["position_mm"] if step["foci"] else [np.nan] * 3, step["periods"]) for step in path["steps"]]
    return report, np.concatenate([np.tile(p, (periods, 1)) for p, periods in where]), path


@pytest.mark.parametrize("letter", "ABCDEFGHIJKL")
def test_every_algorithm_becomes_a_path(letter, tmp_path):
    report, where, path = rendered(tmp_path, "pyramid", *PRESS, "--size", 80, "--height", 40, "--frame", 30, "--algorithm", letter)
    (frame,) = report["frames"]
    assert report["algorithm"] == letter and frame["frame"] == 30 and frame["foci"] >= 1 and len(report["warnings"]) <= 2
    assert len(where) / CARRIER_HZ == pytest.approx(1 / frame["draw_hz"], abs=1.5 / CARRIER_HZ)
    # All foci are at the hand: on its skin, within the flat figures' distance from a round finger.
    assert np.all((where[:, 2] > 110) & (where[:, 2] < 160))
    assert ("modulation" in path) == (letter == "K")


def test_the_path_of_one_frame_is_compiled_and_simulated(tmp_path):
    (tmp_path / "hand.json").write_text(json.dumps(LEAP))
    report, where, _ = rendered(tmp_path, "sphere", "--hand", "hand.json", "--center", "0,0,150", "--size", 30, "--frame", 1,
                                "--frequency", 125, "--points", 16)  # fmt: skip
    # A palm through the middle of a sphere: a circle of 15 mm radius.
    assert np.hypot(where[:, 0], where[:, 1]) == pytest.approx(15, abs=0.05) and where[:, 2] == pytest.approx(150)
    assert report["frames"][0]["length_mm"] == pytest.approx(2 * np.pi * 15, rel=0.002)
    assert report["level"]["note"].startswith("nominal level: ")  # of strength_pa
    succeed(["compile", "--path", "path.json", "-o", "image.hex"], cwd=tmp_path)
    manifest = read_json(tmp_path / "image.json")
    entries = [(int(e & 0xFFFF), int(e >> 16)) for e in Image(tmp_path / "image.hex").sequence()[1:]]
    foci = foci_mm(manifest)
    played = np.concatenate([np.tile(foci[index - 1], (dwell, 1)) for index, dwell in entries])
    assert played == pytest.approx(where, abs=6e-5)  # a manifest rounds to a ten-thousandth of a millimetre
    succeed(["simulate", "image.hex", "--report", "report.json"], cwd=tmp_path, timeout=300)


def test_an_amplitude_is_of_every_focus_and_its_square_of_the_strength(tmp_path):
    arguments = ["sphere", *PRESS, "--size", 60, "--frame", 30]
    full, _, _ = rendered(tmp_path, *arguments)
    half, _, path = rendered(tmp_path, *arguments, "--amplitude", "0.5")
    assert {focus["amplitude"] for step in path["steps"] for focus in step["foci"]} == {0.5}
    for name in ("focus_pa", "strength_pa"):
        assert half["frames"][0][name] == pytest.approx(full["frames"][0][name] / 4)


def test_a_slow_focus_has_the_speed_at_the_image(tmp_path):
    """Shapes' speed, and a tenth of it, from the image's own foci and dwells."""
    for speed in (7.0, 0.7):
        rendered(tmp_path, "sphere", *PRESS, "--size", 40, "--frame", 1, "--speed", speed, "--points", 100)
        succeed(["compile", "--path", "path.json", "-o", "image.hex"], cwd=tmp_path)
        foci = foci_mm(read_json(tmp_path / "image.json"))
        entries = [(int(e & 0xFFFF), int(e >> 16)) for e in Image(tmp_path / "image.hex").sequence()[1:]]
        where = foci[[index - 1 for index, _ in entries]]
        steps_mm = np.linalg.norm(where - np.roll(where, -1, axis=0), axis=1)
        periods = sum(dwell for _, dwell in entries)
        assert steps_mm.sum() * 1e-3 * CARRIER_HZ / periods == pytest.approx(speed, rel=0.01)
        assert np.ptp([dwell for _, dwell in entries]) <= 1


def test_a_recording_keeps_its_time_and_says_what_each_frame_is(tmp_path):
    report, where, _ = rendered(tmp_path, "sphere", *PRESS, "--size", 60)
    assert len(report["frames"]) == 200 and len(where) / CARRIER_HZ == pytest.approx(2.0, abs=1e-3)
    depth = np.array([0.5 - 0.5 * np.cos(np.pi * frame["time_s"]) for frame in report["frames"]]) * 30
    # The palm goes down from the sphere's middle by `depth`: the circle shrinks, and with the fingers there is more of it.
    palm = 2 * np.pi * np.sqrt(30**2 - np.minimum(depth, 30) ** 2)
    lengths = np.array([frame["length_mm"] for frame in report["frames"]])
    assert np.all(lengths[depth < 25] > 0.9 * palm[depth < 25])
    lines = text(succeed(["render", "sphere", *PRESS, "--size", 60, "--report"], cwd=tmp_path).stdout).splitlines()
    assert lines[0].split()[0] == "frame" and len(lines[1].split()) == 11 and lines[1].split()[0] == "1"
    assert any("ms a frame" in line for line in lines[-4:])


def test_a_project_is_rendered_as_the_options_do_and_compiled_as_its_path(tmp_path):
    (tmp_path / "hand.json").write_text(json.dumps(LEAP))
    (tmp_path / "p.toml").write_text("""format = "haptogram-project-1"
points = 24
frequency_hz = 100

[hand]
recording = "hand.json"
object = "pyramid"
size_mm = 61.5
height_mm = 40
center_mm = [1.25, -2, 151]
rotate_deg = [10, 20, 30]
algorithm = "H"
frame = 1
""")
    _, _, project = rendered(tmp_path, "p.toml")
    _, _, options = rendered(tmp_path, "pyramid", "--hand", "hand.json", "--size", 61.5, "--height", 40, "--center=1.25,-2,151", "--rotate",
                             "10,20,30", "--algorithm", "H", "--frame", 1, "--points", 24, "--frequency", 100)  # fmt: skip
    assert project == options
    succeed(["compile", "--path", "path.json", "-o", "image.hex"], cwd=tmp_path)
    succeed(["compile", "p.toml", "-o", "project.hex"], cwd=tmp_path)
    assert (tmp_path / "image.hex").read_bytes() == (tmp_path / "project.hex").read_bytes()
    refuse(tmp_path, ["render", "p.toml", "--speed", 3], USAGE)
    refuse(tmp_path, ["render", "p.toml", "--frame", 3], USAGE)
    refuse(tmp_path, ["render", "sphere"], USAGE)
    refuse(tmp_path, ["compile", "p.toml", "--clip"], USAGE)
    (tmp_path / "shape.toml").write_text('format = "haptogram-project-1"\n[[shape]]\nkind = "circle"\n')
    refuse(tmp_path, ["render", "shape.toml"], BAD_INPUT)


def test_a_lost_hand_is_silence(tmp_path):
    (tmp_path / "hand.json").write_text(json.dumps(LEAP))
    report, where, _ = rendered(tmp_path, "sphere", "--hand", "hand.json", "--center", "0,0,150")
    assert report["touching"] == 1 and len(where) == pytest.approx(0.02 * CARRIER_HZ, abs=10)
    assert np.isnan(where[:, 0]).sum() == pytest.approx(0.01 * CARRIER_HZ, abs=10)


def test_out_of_reach_is_said(tmp_path):
    # The fingers are 60° off the array's axis, and the palm is not.
    command = ["render", "cube", "--hand", "synthetic:press:35", "--center", "60,0,35", "--frame", 1, "-o", "path.json", "--json", "--report"]
    result = succeed(command, cwd=tmp_path)
    notice(result.stderr)
    (frame,) = json.loads(result.stdout)["frames"]
    path = read_json(tmp_path / "path.json")
    silent = sum(step["periods"] for step in path["steps"] if not step["foci"]) / sum(step["periods"] for step in path["steps"])
    assert 0.1 < frame["out_of_reach"] < 0.6 and silent == pytest.approx(frame["out_of_reach"], abs=0.02)


def test_a_mesh_is_an_object(tmp_path):
    x = 20
    (tmp_path / "cube.obj").write_text(
        "".join(f"v {a} {b} {c}\n" for c in (-x, x) for b in (-x, x) for a in (-x, x))
        + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    )
    mesh, _, _ = rendered(tmp_path, "cube.obj", *PRESS, "--frame", 1, "--algorithm", "H")
    cube, _, _ = rendered(tmp_path, "cube", "--size", 40, *PRESS, "--frame", 1, "--algorithm", "H")
    assert mesh["frames"][0]["length_mm"] == pytest.approx(cube["frames"][0]["length_mm"], rel=1e-6)
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    refuse(tmp_path, ["render", "open.obj", *PRESS, "-o", "path.json"], BAD_INPUT, outputs=("path.json",))
    (tmp_path / "points.xyz").write_text("0 0 0\n1 0 0\n0 1 0\n")
    refuse(tmp_path, ["render", "points.xyz", *PRESS, "-o", "path.json"], BAD_INPUT, outputs=("path.json",))


def test_a_picture(tmp_path):
    succeed(["render", "cube", "--size", 50, *PRESS, "--frame", 1, "--algorithm", "H", "-o", "touch.png", "-o", "path.json"], cwd=tmp_path, timeout=300)
    assert (tmp_path / "touch.png").read_bytes().startswith(b"\x89PNG") and (tmp_path / "path.json").exists()


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["torus", *PRESS], USAGE),
        (["sphere", "--hand", "synthetic:clap"], USAGE),
        (["sphere", "--hand", "missing.json"], BAD_INPUT),
        (["sphere", "--hand", "hand.txt"], BAD_INPUT),
        (["sphere", *PRESS, "--algorithm", "M"], USAGE),
        (["sphere", *PRESS, "--frame", 1000], USAGE),
        (["sphere", *PRESS, "--speed", 7, "--frequency", 20], USAGE),
        (["sphere", *PRESS, "--frame", 1, "--points", 1_000_000], BAD_INPUT),
        (["sphere", *PRESS, "--points", 100], USAGE),
        (["sphere", *PRESS, "--algorithm", "B"], BAD_INPUT),
        (["sphere", "--hand", "synthetic:press", "--center", "0,0,400"], BAD_INPUT),
        (["cube", *PRESS, "--size", 0], USAGE),
        (["cube", *PRESS, "--solid-level", 2, "--algorithm", "D"], USAGE),
    ],
    ids=lambda value: " ".join(str(v) for v in value[:1] + value[-2:]) if isinstance(value, list) else None,
)
def test_what_makes_no_sense_is_refused(arguments, code, tmp_path):
    refuse(tmp_path, ["render", *arguments, "-o", "path.json"], code, outputs=("path.json",))


def test_outputs_of_other_kinds(tmp_path):
    refuse(tmp_path, ["render", "sphere", *PRESS, "-o", "path.txt"], USAGE, outputs=("path.txt",))
    refuse(tmp_path, ["render", "sphere", *PRESS, "-o", "a.json", "-o", "b.json"], USAGE, outputs=("a.json", "b.json"))


def test_foci_that_feel_with_a_magnitude(tmp_path):
    arguments = ["pyramid", *PRESS, "--size", 80, "--height", 40, "--frame", 30]
    plain, _, before = rendered(tmp_path, *arguments)
    report, _, path = rendered(tmp_path, *arguments, "--am", "square:200", "--magnitude", 1.5)
    assert "least_command" not in plain and report["focus_moves"] is True
    assert path["modulation"]["samples"].count(1.0) * 2 == pytest.approx(len(path["modulation"]["samples"]), rel=0.03)
    foci = [step["foci"][0] for step in path["steps"] if step["foci"]]
    assert [focus["position_mm"] for focus in foci] == [step["foci"][0]["position_mm"] for step in before["steps"] if step["foci"]]
    for focus in foci[:: len(foci) // 4]:
        place = ",".join(map(str, focus["position_mm"]))
        setting = json.loads(succeed(["magnitude", 1.5, "--frequency", 200, "--array", "tile-10x10", "--focus", place, "--json"]).stdout)
        assert focus["amplitude"] == pytest.approx(setting["command"], rel=0.003)
        assert report["least_command"] <= focus["amplitude"] + 1e-4 and focus["amplitude"] <= report["most_command"] + 1e-4


def test_a_magnitude_under_the_algorithms_own_modulation(tmp_path):
    arguments = ["pyramid", *PRESS, "--size", 80, "--height", 40, "--frame", 30, "--algorithm", "K"]
    sine, _, _ = rendered(tmp_path, *arguments, "--magnitude", 1.5)
    square, _, _ = rendered(tmp_path, *arguments[:-1], "A", "--am", "square:200", "--magnitude", 1.5)
    # The force goes with the square of the command. A sine's alternating part is π/4 of the square wave's.
    assert (square["most_command"] / sine["most_command"]) ** 2 == pytest.approx(np.pi / 4, rel=0.02)


@pytest.mark.parametrize(
    "options",
    [
        ["--magnitude", 2],
        ["--am", "square:200", "--magnitude", 6],
        ["--am", "square:200", "--magnitude", 0.1],
        ["--am", "square:400", "--magnitude", 2],
        ["--am", "square:200", "--magnitude", 1.5, "--algorithm", "L"],
        ["--am", "square:200", "--algorithm", "K"],
        ["--am", "sine:200", "--am-law", "radiation", "--magnitude", 1],
    ],
)
def test_magnitudes_that_no_path_has(tmp_path, options):
    arguments = ["render", "pyramid", *PRESS, "--size", 80, "--height", 40, "--frame", 30, *options, "-o", "path.json"]
    refuse(tmp_path, arguments, USAGE, outputs=("path.json",))
