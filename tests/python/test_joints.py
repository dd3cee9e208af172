# SPDX-License-Identifier: Apache-2.0
"""Hands of other trackers: lines of joints are felt as the same hands in a recording of a Leap, and adapters make these lines."""
import json
import types

import numpy as np
import pytest
from haptogram.errors import HaptogramError
from haptogram.sensors.joints import MEDIAPIPE, NAMES, hand, line, of_mediapipe, of_openxr
from messages import notice
from processes import PROGRAM, ROOT, run
from test_sensors import BAD_INPUT, OK, refuse

FINGERS = ("thumb", "index", "middle", "ring", "little")


def places(time_s):
    """A right hand that goes down, in the tracker's frame (x right, y up, z to the user), metres."""
    y = 0.2 - 0.03 * time_s
    joints = {"wrist": (0.0, y, 0.06), "palm": (0.001, y, 0.02)}
    for k, finger in enumerate(FINGERS):
        bones = ("metacarpal", "proximal", "distal", "tip") if finger == "thumb" else ("proximal", "intermediate", "distal", "tip")
        for n, bone in enumerate(bones):
            joints[f"{finger}_{bone}"] = (0.02 * (k - 2), y - 0.002 * n * n, 0.03 * (k == 0) - 0.02 - 0.025 * n)
    return joints


def chain(joints, finger):
    bones = ("metacarpal", "proximal", "distal", "tip") if finger == "thumb" else ("proximal", "intermediate", "distal", "tip")
    return [[1e3 * number for number in joints[f"{finger}_{bone}"]] for bone in bones]


def recordings(folder, count=20, **more):
    """The same hand as joints.jsonl and as leap.json."""
    lines, frames = [], []
    for i in range(count):
        time_s = i / 100
        joints = places(time_s)
        lines.append(line(time_s + 1000, [hand("right", joints, id=7, normal=[0, -1, 0], direction=[0, 0, -1], velocity_m_s=[0, -0.03, 0], **more)]))
        palm = {"id": 7, "type": "right", "palmPosition": [1e3 * number for number in joints["palm"]], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, -30, 0]}
        pointables = [dict(zip(("handId", "id", "mcpPosition", "pipPosition", "dipPosition", "tipPosition"), (7, 70 + k, *chain(joints, finger)), strict=True)) for k, finger in enumerate(FINGERS)]
        frames.append({"timestamp": round(1e6 * time_s), "hands": [palm], "pointables": pointables})
    (folder / "joints.jsonl").write_bytes(b"".join(lines))
    (folder / "leap.json").write_text(json.dumps({"frames": frames}))
    return lines


def foci(path):
    return [(step["periods"], [focus["position_mm"] for focus in step["foci"]]) for step in json.loads(path.read_text())["steps"]]


@pytest.mark.parametrize("algorithm", ["A", "G"])
def test_joints_compile_to_what_a_recording_of_a_leap_does(tmp_path, algorithm):
    recordings(tmp_path)
    for name in ("joints.jsonl", "leap.json"):
        done = run([PROGRAM, "render", "sphere", "--size", "60", "--center", "0,0,180", "--hand", name, "--algorithm", algorithm, "-o", f"{name}.path.json"], tmp_path)
        assert done.returncode == OK, done.stderr
    ours, leaps = foci(tmp_path / "joints.jsonl.path.json"), foci(tmp_path / "leap.json.path.json")
    assert len(ours) == len(leaps) > 100
    for (a, p), (b, q) in zip(ours, leaps, strict=True):
        assert a == b and np.allclose(p, q, atol=1e-6)


def test_what_joints_leave_out_follows_from_them(tmp_path):
    """Without palm, normal, direction and velocity, and at another place than the array's middle."""
    recordings(tmp_path)
    few = [line(i / 100, [hand("right", {name: place for name, place in places(i / 100).items() if name != "palm"})]) for i in range(20)]
    (tmp_path / "few.jsonl").write_bytes(b"".join(few))
    found = {}
    for name in ("few.jsonl", "joints.jsonl"):
        command = ["live", "--from", f"joints:{name}", "--size", "60", "--center", "0,0,180", "--port", "reference:tile-100", "--algorithm", "A", "--scene", f"{name}.scene", "--json"]
        done = run([PROGRAM, *command], tmp_path)
        assert done.returncode == OK, done.stderr
        found[name] = [json.loads(row) for row in (tmp_path / f"{name}.scene").read_text().splitlines()]
    assert len(found["few.jsonl"]) == len(found["joints.jsonl"]) > 0
    for few_line, line_ in zip(found["few.jsonl"], found["joints.jsonl"], strict=True):
        (a,), (b,) = few_line["hands"], line_["hands"]
        assert a["fingers_mm"] == b["fingers_mm"] and a["right"] == b["right"]
        assert np.allclose(a["palm_mm"], b["palm_mm"], atol=15) and np.allclose(a["normal"], b["normal"], atol=0.05) and np.allclose(a["direction"], b["direction"], atol=0.05)


def test_joints_come_over_a_pipe(tmp_path):
    lines = recordings(tmp_path, count=60)
    (tmp_path / "lines").write_bytes(b"what is no frame\n" + b"".join(lines))
    command = ["live", "--from", "joints-pipe:lines", "--size", "60", "--center", "0,0,180", "--algorithm", "A", "--port", "reference:tile-100", "--json"]
    done = run([PROGRAM, *command], tmp_path)
    assert done.returncode == OK, done.stderr
    report = json.loads(done.stdout)
    assert report["shots"] + report["skipped"] == 60 and report["junk"] == 1 and report["with_rings"] > 0
    notice(done.stderr)


def test_the_frame_of_the_page_is_one(tmp_path):
    page = (ROOT / "extras/hands/README.md").read_text(encoding="utf-8")
    frame = page.split("## Hands of any tracker")[1].split("```json\n")[1].split("```")[0]
    (tmp_path / "page.jsonl").write_text(" ".join(frame.split()) + "\n")
    done = run([PROGRAM, "render", "sphere", "--size", "60", "--center", "-20,90,190", "--hand", "page.jsonl", "--frame", "1", "--algorithm", "A", "-o", "path.json"], tmp_path)
    assert done.returncode == OK and foci(tmp_path / "path.json"), done.stderr


def test_joints_that_are_wrong(tmp_path):
    good = json.loads(line(0, [hand("right", places(0))]))
    one = good["hands"][0]
    flat = {name: [0, 0, 0] for name in one["joints_m"] if name != "palm"}
    wrong = [{}, [], {"time_s": "now", "hands": []}, {"time_s": 0}, {**good, "frame": 1}, *({"time_s": 0, "hands": [hand_]} for hand_ in (
        {**one, "side": "both"}, {**one, "joints_m": {**one["joints_m"], "index_knuckle": [0, 0, 0]}}, {**one, "joints_m": {name: place for name, place in one["joints_m"].items() if name != "index_tip"}},
        {**one, "joints_m": {**one["joints_m"], "index_tip": [0, 0]}}, {**one, "joints_m": {**one["joints_m"], "index_tip": [0, 0, 1e9]}}, {**one, "joints_m": {}}, {**one, "joints_m": flat},
        {**one, "normal": [0, 0, 0]}, {**one, "grab": 2}, {**one, "id": "a"}, {**one, "widths_m": [1]})), {"time_s": 0, "hands": [one, one]}]  # fmt: skip
    contents = [json.dumps(each).encode() + b"\n" for each in wrong] + [b"", b"\n", b"nan\n", line(1, []) + line(0, []), line(0, [one])[:-20], b'{"time_s": NaN, "hands": []}']
    for content in contents:
        (tmp_path / "hands.jsonl").write_bytes(content)
        refuse(run([PROGRAM, "render", "sphere", "--hand", "hands.jsonl", "-o", "path.json"], tmp_path), BAD_INPUT)
        assert not (tmp_path / "path.json").exists()


@pytest.mark.parametrize("content", [{"frames": [{"time": 0.0, "right": {"palm": [0, 0.15, 0]}}]}, [{"landmarks": []}], {"hands": []}])
def test_recordings_of_other_trackers_are_told_the_way(tmp_path, content):
    (tmp_path / "hands.json").write_text(json.dumps(content))
    refuse(run([PROGRAM, "render", "sphere", "--hand", "hands.json", "-o", "path.json"], tmp_path), BAD_INPUT)


def test_names_of_openxr_and_webxr():
    assert len(NAMES) == 26 and len(MEDIAPIPE) == 21
    place = (0.0, 0.1, 0.2)
    for name, ours in (("XR_HAND_JOINT_INDEX_TIP_EXT", "index_tip"), ("index-finger-tip", "index_tip"), ("pinky-finger-phalanx-proximal", "little_proximal"), ("XR_HAND_JOINT_LITTLE_METACARPAL_EXT", "little_metacarpal"),
                       ("thumb-phalanx-distal", "thumb_distal"), ("wrist", "wrist"), ("middle_intermediate", "middle_intermediate")):  # fmt: skip
        assert of_openxr("left", {name: place}) == {"side": "left", "joints_m": {ours: list(place)}}
    for call in (lambda: of_openxr("left", {"elbow": place}), lambda: hand("both", {}), lambda: hand("left", {"wrist": (0, 1)}), lambda: hand("left", {"wrist": (0, 1, float("nan"))})):
        with pytest.raises(HaptogramError):
            call()


def seen_by_mediapipe(joints, width, height, focal_px, mirrored, tasks, label):
    """What MediaPipe would say of joints (x right, y up, z to the user) before a camera that looks along -z."""
    true = np.array([joints[name] for name in MEDIAPIPE]) * [1, -1, -1]  # of the camera: y down, z away
    middle = true.mean(axis=0)
    flip = -1 if mirrored else 1
    mark = lambda x, y, z: types.SimpleNamespace(x=x, y=y, z=z)  # noqa: E731
    picture = [mark(0.5 + flip * focal_px * x / z / width, 0.5 + focal_px * y / z / height, 0) for x, y, z in true]
    world = [mark(flip * x, y, z) for x, y, z in true - middle]
    if tasks:
        return types.SimpleNamespace(hand_landmarks=[picture], hand_world_landmarks=[world], handedness=[[types.SimpleNamespace(category_name=label, score=0.9)]])
    wrapped = lambda marks: [types.SimpleNamespace(landmark=marks)]  # noqa: E731
    said = [types.SimpleNamespace(classification=[types.SimpleNamespace(label=label, score=0.9)])]
    return types.SimpleNamespace(multi_hand_landmarks=wrapped(picture), multi_hand_world_landmarks=wrapped(world), multi_handedness=said)


@pytest.mark.parametrize("tasks", [True, False])
@pytest.mark.parametrize("mirrored", [True, False])
def test_a_hand_of_mediapipe_is_where_the_camera_saw_it(tasks, mirrored):
    joints = {name: (x + 0.05, y - 0.25, z - 0.4) for name, (x, y, z) in places(0).items()}
    # A mirror shows a right hand as MediaPipe expects it; a plain picture of one looks to it like a left hand.
    (found,) = of_mediapipe(seen_by_mediapipe(joints, 640, 480, 600, mirrored, tasks, "Right" if mirrored else "Left"), 640, 480, 600, mirrored)
    assert found["side"] == "right" and found["confidence"] == 0.9
    assert all(np.allclose(found["joints_m"][name], joints[name], atol=1e-9) for name in MEDIAPIPE)
    assert of_mediapipe(types.SimpleNamespace(multi_hand_landmarks=None, multi_hand_world_landmarks=None, multi_handedness=None), 640, 480, 600) == []
    with pytest.raises(HaptogramError):
        of_mediapipe(None, 640, 480, 0)
