# SPDX-License-Identifier: Apache-2.0
"""`haptogram robot`: kinematics and tensions worked out with numpy, workspaces, pictures, and runs with faults."""
import io
import json
from pathlib import Path

import numpy as np
import pytest
from support import BAD_INPUT, RUN_FAILED, USAGE, assert_one_message, run, succeed, text

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
ANCHORS = CORNERS * 195.0
ATTACHMENTS = (CORNERS * [19.0, 19.0, 30.0])[[5, 2, 6, 1, 0, 7, 3, 4]]
CROSSING = Path(__file__).parent.parent / "data/robots/crossing.toml"  # a robot whose cables meet
POSE = ["--position", "20,-10,30", "--angles", "5,-3,10"]


def turned(x, y, z):
    cx, cy, cz, sx, sy, sz = *np.cos(np.radians([x, y, z])), *np.sin(np.radians([x, y, z]))
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    return about_z @ about_y @ about_x


ARMS = ATTACHMENTS @ turned(5, -3, 10).T
CABLES = ANCHORS - [20, -10, 30] - ARMS
LENGTHS = np.linalg.norm(CABLES, axis=1)


def asked(*args, code=0, **more):
    result = run(["robot", *args, "--json"], timeout=300, **more)
    assert result.returncode == code, text(result.stderr)
    return json.loads(result.stdout)


def test_there_and_back():
    found = asked("ik", *POSE)
    assert found["lengths_mm"] == pytest.approx(LENGTHS, abs=1e-5) and found["within_limits"] is True
    pose = asked("fk", *(f"{length:.9f}" for length in LENGTHS))
    assert pose["position_mm"] == pytest.approx([20, -10, 30], abs=1e-5)
    assert pose["angles_deg"] == pytest.approx([5, -3, 10], abs=1e-5)
    assert pose["steps"] <= 5 and pose["mismatch_mm"] < 1e-6
    outside = asked("ik", "--position", "0,0,400", code=RUN_FAILED)
    assert outside["within_limits"] is False


def apart(first, other):
    """The least distance of two segments, by trying places on both."""
    (a, b), (c, d) = first, other
    along = np.linspace(0, 1, 1001)[:, None]
    one, two = a + along * (b - a), c + along * (d - c)
    return min(np.linalg.norm(two - place, axis=1).min() for place in one)


def test_distances_of_cables():
    ends = np.array([20, -10, 30]) + ARMS
    cables = [(ANCHORS[i], ends[i]) for i in range(8)]
    pairs = {(i + 1, j + 1): apart(cables[i], cables[j]) for i in range(8) for j in range(i + 1, 8)}
    found = asked("ik", *POSE)
    nearest = found["nearest_cables"]
    assert (nearest["cable"], nearest["other_cable"]) == min(pairs, key=pairs.get)
    assert nearest["distance_mm"] == pytest.approx(min(pairs.values()), abs=0.1) and found["interference"] is False
    assert nearest["room_mm"] == pytest.approx(nearest["distance_mm"] - 1, abs=1e-6)
    half = np.array([0, 0, 15]) @ turned(5, -3, 10).T
    grip = (np.array([20, -10, 30]) - half, np.array([20, -10, 30]) + half)
    assert found["nearest_to_grip"]["distance_mm"] == pytest.approx(min(apart(cable, grip) for cable in cables) - 15, abs=0.1)


def test_cables_that_meet():
    met = asked("ik", "--robot", CROSSING, code=RUN_FAILED)
    assert met["within_limits"] is True and met["interference"] is True and met["nearest_cables"]["distance_mm"] == 0
    assert "cables 1 and 5 are 0.00 mm apart, and a cable is 1 mm thick" in text(run(["robot", "ik", "--robot", CROSSING]).stdout)
    assert asked("workspace", "--robot", CROSSING, "--turns", "none")["useful"] == 0
    assert_one_message(run(["robot", "simulate", "--robot", CROSSING]), USAGE)


def test_lengths_of_no_pose():
    assert_one_message(run(["robot", "fk", *[700] * 8]), BAD_INPUT)
    assert asked("fk", *(f"{length:.1f}" for length in LENGTHS))["mismatch_mm"] < 0.1


@pytest.mark.parametrize("choice", ["norm", "sum", "centroid", "paper"])
def test_tensions_balance(choice):
    force, torque = np.array([1.0, -2.0, 3.0]), np.array([0.01, 0.02, -0.03])
    found = asked("tension", *POSE, "--force", "1,-2,3", "--torque", "0.01,0.02,-0.03", "--choice", choice)
    tensions = np.array(found["tensions_n"])
    directions = CABLES / LENGTHS[:, None]
    assert tensions @ directions + force + [0, 0, -0.1 * 9.80665] == pytest.approx([0, 0, 0], abs=1e-5)
    assert tensions @ np.cross(ARMS * 1e-3, directions) + torque == pytest.approx([0, 0, 0], abs=1e-6)
    assert tensions.min() >= 0.5 - 1e-6 and (tensions.max() <= 10 + 1e-6) == found["within_limits"]


def test_the_largest_forces():
    found = asked("tension", "--largest")["largest_n"]
    assert found["+z"] == pytest.approx(21.74, abs=0.005) and found["-z"] == pytest.approx(19.78, abs=0.005)
    assert all(found[name] == pytest.approx(12.49, abs=0.005) for name in ("+x", "-x", "+y", "-y"))


def test_workspace(tmp_path):
    found = asked("workspace", "--turns", "one", "-o", "w.csv", cwd=tmp_path)
    table = np.genfromtxt(tmp_path / "w.csv", delimiter=",", names=True)
    assert found["volume_mm3"] == table["useful"].sum() * 27000 == 7533000
    assert found["ball_radius_mm"] == pytest.approx((3 * 7533000 / 4 / np.pi) ** (1 / 3))
    asked("workspace", "--step", 60, "-o", "w.png", cwd=tmp_path)
    assert (tmp_path / "w.png").read_bytes().startswith(b"\x89PNG")
    wide = asked("workspace", "--turns", "none", "--step", 60)
    assert wide["useful"] > asked("workspace", "--turns", "all", "--step", 60)["useful"]


def test_a_run_and_its_trace(tmp_path):
    found = asked("simulate", "--push", "0.5:5:0,0,4", "--duration", 5, "-o", "t.csv", cwd=tmp_path)
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    assert found["events"] == [] and found["end_mm"][2] == pytest.approx(4 / 150 * 1e3, abs=0.5)
    assert table["z_mm"][-1] == pytest.approx(found["end_mm"][2], abs=1e-3)
    assert table["measured_z_n"][-10:].mean() == pytest.approx(4, abs=0.05)
    tensions = np.array([table[f"tension_{i}_n"] for i in range(1, 9)])
    assert min(found["least_tension_n"]) <= tensions.min() and tensions.min() > 0.5
    succeed(["robot", "simulate", "--duration", 1, "-o", "t.png"], cwd=tmp_path, timeout=300)
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")
    printed = succeed(["robot", "simulate", "--duration", 0.3, "-o", "-"], cwd=tmp_path).stdout
    assert len(np.genfromtxt(io.BytesIO(printed), delimiter=",", names=True)) == 10


def test_a_fault_is_told():
    found = asked("simulate", "--duration", 4, "--fault", "slip:4:1", code=RUN_FAILED)
    (event,) = found["events"]
    assert event["kind"] == "encoder slip" and event["cable"] == 4 and event["time_s"] == pytest.approx(1, abs=0.01)
    assert found["steadiness_mm"] < 0.1


def test_an_overload_is_told_once_and_yielded_to(tmp_path):
    found = asked("simulate", "--push", "1:2:0,0,30", "--duration", 5, "-o", "t.csv", code=RUN_FAILED, cwd=tmp_path)
    (event,) = found["events"]
    assert event["kind"] == "overload" and "the motors yield" in event["text"]
    assert found["most_off_mm"] > 50 and np.linalg.norm(found["end_mm"]) < 1 and max(found["most_tension_n"]) < 25
    assert found["interference_s"] == 0


def test_a_handle_that_turns_over_is_told():
    arguments = ["simulate", "--push", "0:2:0,0,5", "--duration", 7, "--fault", "broken:4:5"]
    assert asked(*arguments, code=RUN_FAILED)["most_turn_deg"] > 90
    assert "it turned over" in text(run(["robot", *arguments], timeout=300).stdout)
    assert asked("simulate", "--duration", 3, "--fault", "broken:4:1", code=RUN_FAILED)["most_turn_deg"] < 18


@pytest.mark.parametrize("pattern", ["focus", "ring"])
def test_what_is_told_is_at_the_pins(pattern):
    """Its sequences have silence in their middle, which is not their end."""
    succeed(["robot", "tell", "--pattern", pattern])


def test_a_scene_says_what_the_cables_could_not_render():
    found = asked("explore", "cube", "--weight", 60, "--frames", 0, code=RUN_FAILED)
    assert found["most_force_n"] == 60 and found["rendered_n"] == 0 and found["missing_n"] == 60
    told = text(run(["robot", "explore", "cube", "--weight", 60, "--frames", 0], timeout=300).stdout)
    assert "60.000 N could not be rendered" in told and "rendered up to 60" not in told


@pytest.mark.parametrize(("arguments", "code"), [
    ([], USAGE), (["ik", "--position", "1,2"], USAGE), (["fk", 1, 2], USAGE),
    (["tension", "--force", "99,0,0"], BAD_INPUT), (["tension", "--largest", "--choice", "sum"], USAGE),
    (["workspace", "--angle", 90], USAGE), (["workspace", "--step", 0.01], USAGE), (["workspace", "-o", "w.gif"], USAGE),
    (["simulate", "--push", "1:2"], USAGE), (["simulate", "--fault", "burnt:1:1"], USAGE),
    (["simulate", "--position", "0,0,170"], USAGE), (["ik", "--robot", "none"], BAD_INPUT), (["ik", "--edge", 0], USAGE),
    (["ik", "--angles", "1,2"], USAGE), (["workspace", "--step", 1000], USAGE),
    (["simulate", "--duration", 1, "--fault", "broken:1:5"], USAGE), (["simulate", "--duration", 1, "--push", "20:21:0,0,8"], USAGE),
])  # fmt: skip
def test_what_is_refused(arguments, code, tmp_path):
    assert_one_message(run(["robot", *arguments], cwd=tmp_path), code)
