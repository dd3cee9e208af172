# SPDX-License-Identifier: Apache-2.0
"""Bare fingers on an object: `haptogram live` on the reference board, its recordings, and what it refuses."""

import contextlib
import json
import re
import signal
import socket
import subprocess

import numpy as np
import pytest
from patience import also_in_time
from support import BAD_INPUT, DEVICE, PROGRAM, ROOT, USAGE, refuse, succeed

PRESS = ["live", "--from", "fingers:press", "--size", "60", "--center", "0,0,170", "--seconds", "0.4"]
BOARD = ["--port", "reference:tile-100"]


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_a_run_and_its_recording_make_the_same_rings(tmp_path):
    first = json.loads(succeed([*PRESS, *BOARD, "--record", "hand", "--scene", "first.jsonl", "--json"], cwd=tmp_path).stdout)
    assert first["shots"] == 12 and first["missed"] == 0 and first["underruns"] == 0 and first["with_rings"] >= 7
    assert first["level"]["note"].startswith("nominal level: ")  # also of rings without a magnitude
    assert 20 < first["latency_ms"]["least"] < first["latency_ms"]["most"] < 50
    again = ["live", "--from", "depth:hand", "--size", "60", "--center", "0,0,170", *BOARD, "--scene", "second.jsonl", "--json"]
    second = json.loads(succeed(again, cwd=tmp_path).stdout)
    assert {k: v for k, v in first.items() if k != "compute_ms"} == {k: v for k, v in second.items() if k != "compute_ms"}
    for a, b in zip(lines(tmp_path / "first.jsonl"), lines(tmp_path / "second.jsonl"), strict=True):
        assert a["sections"] == b["sections"]
    refuse(tmp_path, [*PRESS, *BOARD, "--record", "hand"], BAD_INPUT)


def test_sections_are_where_the_fingers_are(tmp_path):
    succeed([*PRESS, *BOARD, "--scene", "s.jsonl"], cwd=tmp_path)
    seen = 0
    for shot in lines(tmp_path / "s.jsonl"):
        depth = 4.5 - 5.5 * np.cos(2 * np.pi * shot["time_s"])
        for section in shot["sections"]:
            x, y, z = section["centre_mm"]
            assert abs(abs(x) - 15) < 0.5 and abs(y) < 0.5 and abs(z - 200) < 1.5
            if depth > 3:  # the round tip's own circle at that depth; deeper than its radius, the finger's
                radius = 8 if depth > 8 else np.sqrt(2 * 8 * depth - depth * depth)
                assert abs(np.mean(section["half_axes_mm"]) / radius - 1) < 0.1
                seen += 1
    assert seen >= 10


def test_the_still_focus_is_said_to_be_modulated(tmp_path):
    said = succeed([*PRESS, *BOARD, "--algorithm", "still"], cwd=tmp_path).stdout.decode()
    assert "still, modulated at 200 Hz" in said


def test_a_recording_keeps_when_rings_were_played(tmp_path):
    run = json.loads(succeed([*PRESS, *BOARD, "--record", "hand", "--json"], cwd=tmp_path).stdout)
    kept = json.loads((tmp_path / "hand/run.json").read_text())
    assert len(kept["ring_times"]) == run["rings"] and kept["latency_ms"] == run["latency_ms"]
    assert all(ring["pushed_s"] > ring["shot_s"] for ring in kept["ring_times"])
    assert "began_s" not in kept["ring_times"][0]  # this board counts no carrier periods


def test_strength_and_pressing_foci(tmp_path):
    one = [*PRESS, *BOARD, "--algorithm", "still", "--magnitude", "1.5", "--json"]
    shared = json.loads(succeed(one, cwd=tmp_path).stdout)  # two fingers share the array's pressure
    assert shared["without_magnitude"] >= 7 and shared["with_rings"] == 0
    assert shared["level"]["calibrated"] is False and shared["level"]["note"].startswith("nominal level: ")
    pressed = json.loads(succeed([*PRESS, *BOARD, "--algorithm", "L", "--json"], cwd=tmp_path).stdout)
    assert pressed["with_rings"] >= 7 and pressed["underruns"] == 0
    refuse(tmp_path, [*PRESS, *BOARD, "--magnitude", "1.5"], USAGE)
    refuse(tmp_path, [*PRESS, *BOARD, "--algorithm", "still", "--magnitude", "500"], USAGE)
    refuse(tmp_path, [*PRESS, *BOARD, "--algorithm", "L", "--press-radius", "9"], USAGE)


def test_a_camera_that_vanishes_is_named(tmp_path):
    succeed([*PRESS, *BOARD, "--record", "hand"], cwd=tmp_path)
    for shot in range(4, 8):
        (tmp_path / f"hand/camera3/{shot:06}.png").unlink()
    again = ["live", "--from", "depth:hand", "--size", "60", "--center", "0,0,170", *BOARD]
    told = succeed(again, cwd=tmp_path)
    assert "camera 3          gave no picture in 4 shots" in told.stdout.decode()
    assert told.stderr.decode().count("camera 3 gave no picture") == 4


def test_what_it_cannot_use_is_named(tmp_path):
    refuse(tmp_path, ["live", "--from", "camera", *BOARD], USAGE)
    refuse(tmp_path, ["live", "--from", "fingers:wave", *BOARD], USAGE)
    refuse(tmp_path, ["live", "--from", "depth:none", *BOARD], BAD_INPUT)
    refuse(tmp_path, [*PRESS[:3], "--object", "cube:40", *BOARD], USAGE)
    refuse(tmp_path, [*PRESS[:3], "--object", "cone", "--mass", "100", *BOARD], USAGE)
    refuse(tmp_path, [*PRESS, "--port", "reference:nothing"], USAGE)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad/cameras.toml").write_text('format = "haptogram-depth-1"\nrate_hz = 30\n')
    refuse(tmp_path, ["live", "--from", "depth:bad", *BOARD], BAD_INPUT)


HAND = ["live", "--from", "synthetic:press", "--object", "sphere", "--size", "80", "--center", "0,40,160"]


@pytest.mark.parametrize("algorithm", ["A", "H", "L", "ring", "still"])
@pytest.mark.parametrize("board", ["tile-100-wide", "tile-100-3m"])
def test_a_hand_feels_by_every_kind_of_algorithm(tmp_path, algorithm, board):
    command = [*HAND, "--algorithm", algorithm, "--port", f"reference:{board}", "--seconds", "0.3", "--json"]
    done = succeed(command, cwd=tmp_path)
    felt = json.loads(done.stdout)
    assert felt["missed"] == 0 and felt["underruns"] == 0 and felt["lost"] == 0
    assert felt["with_rings"] > 0 and felt["latency_ms"]["rings"] > 0
    assert ("computes foci" if "wide" in board else "plays records") in done.stderr.decode()


def off_the_bone(foci, start, end):
    share = np.clip((foci - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
    return np.linalg.norm(foci - start - share[:, None] * (end - start), axis=1)


@pytest.mark.parametrize("script", ["press", "grasp"])
def test_fingers_that_cross_a_sphere_feel_it(tmp_path, script):
    """Of all fingers that are partly within it, in all frames, 95 % have a focus on their skin, which is 7.5 to 10.5 mm off their bones."""
    middle, radius, skin = np.array([0, 0, 200]), 50, 10.5
    words = ["live", "--from", f"synthetic:{script}", "--object", "sphere", "--size", "100", "--center", "0,0,200", "--algorithm", "A", "--predict", "none"]
    succeed([*words, "--port", "reference:tile-100-wide", "--seconds", "1", "--scene", "s"], cwd=tmp_path)
    across = felt = 0
    for shot in lines(tmp_path / "s"):
        foci = np.array(shot["foci"]).reshape(-1, 4)[:, :3]
        for finger in np.array(shot["hands"][0]["fingers_mm"]):
            within = np.linalg.norm(finger - middle, axis=1) < radius
            if within.any() and not within.all():  # joints on either side of the surface
                across += 1
                felt += len(foci) > 0 and min(off_the_bone(foci, *bone).min() for bone in zip(finger[:-1], finger[1:], strict=True)) <= skin
    assert across > 150 and felt >= 0.95 * across, f"{felt} of {across}"


MEASURES = {
    "A": ("speed 3", "frequency 30", "jump blank"),
    "B": ("corner triangle", "corner-line 4", "off-skin"),
    "C": ("am-frequency 90",),
    "D": ("solid-level 0.4", "two-foci"),
    "E": ("grain-spacing 20", "grain-length 3", "seed 5"),
    "G": ("blob-palm 0.5",),
    "H": ("gap 25", "priority finger"),
    "K": ("wait 0.05", "speed 0.3"),
    "L": ("press-radius 6", "press-foci 2", "press-frequency 9"),
}


@pytest.mark.parametrize("algorithm", MEASURES)
def test_an_algorithm_has_the_measures_that_render_gives_it(tmp_path, algorithm):
    """Each changes what is played; of another algorithm it is refused."""
    words = ["live", "--from", "synthetic:press", "--object", "cube", "--size", "80", "--center", "0,40,160", "--seconds", "0.1", "--port", "reference:tile-100-wide", "--scene", "s"]

    def played(letter, *more):
        succeed([*words, "--algorithm", letter, *more], cwd=tmp_path)
        return [shot["foci"] for shot in lines(tmp_path / "s")]

    usual = played(algorithm)
    assert any(usual)
    for measure in MEASURES[algorithm]:
        option, *value = f"--{measure}".split()
        assert played(algorithm, option, *value) != usual, measure
        for other in "AL" if option not in ("--speed", "--frequency", "--jump") else ():
            if measure not in MEASURES[other]:
                refuse(tmp_path, [*words, "--algorithm", other, option, *value], USAGE)
        refuse(tmp_path, [*words, "--algorithm", "ring", option, *value], USAGE)
    if algorithm == "L":
        refuse(tmp_path, [*PRESS, "--algorithm", "L", *BOARD, "--speed", "3"], USAGE)


def test_it_wants_to_know_what_sees_the_hand(tmp_path):
    refuse(tmp_path, ["live", "--port", "reference:tile-100-wide"], USAGE)
    (tmp_path / "settings.toml").write_text("[live]\nalgorithm = \"A\"\n")
    refuse(tmp_path, ["live", "--port", "reference:tile-100-wide", "--settings", "settings.toml"], USAGE)


def test_a_line_that_is_too_slow_is_refused_and_foci_fit_it(tmp_path):
    slow = "reference:colorlight-5a-75e-v7.1"
    refuse(tmp_path, [*PRESS, "--port", slow], DEVICE)
    rings = json.loads(succeed([*PRESS, "--port", slow + "-wide", "--json"], cwd=tmp_path).stdout)
    assert rings["shots"] == 12 and rings["missed"] == 0 and rings["underruns"] == 0 and rings["with_rings"] >= 7
    hand = json.loads(succeed([*HAND, "--algorithm", "A", "--port", slow + "-wide", "--seconds", "0.6", "--json"], cwd=tmp_path).stdout)
    assert hand["missed"] == 0 and hand["underruns"] == 0 and hand["latency_ms"]["rings"] > 0


def test_it_says_what_the_array_can_do_before_it_plays(tmp_path):
    told = succeed([*PRESS, *BOARD], cwd=tmp_path).stderr.decode()
    assert re.search(r"4 mm deep at \(0, 0, 200\) mm: from above, 10 of 10 places of its ring are reached", told)
    assert re.search(r"aslant [^:]*, [0-9]+ of 10 places", told)
    assert "warning" not in told
    told = succeed([*PRESS, "--port", "reference:colorlight-5a-75e-v7.1-wide"], cwd=tmp_path).stderr.decode()
    assert "warning: the line cannot keep up" in told
    out = succeed([*PRESS[:6], "0,200,40", "--seconds", "0.1", *BOARD], cwd=tmp_path).stderr.decode()
    assert "no ring, the array does not reach it" in out


def test_a_rig_on_one_board(tmp_path):
    words = [*HAND, "--algorithm", "A", "--rig", "hoshi-9x36", "--port", "reference:hoshi-324", "--seconds", "0.2", "--json"]
    felt = json.loads(succeed(words, cwd=tmp_path).stdout)
    assert felt["with_rings"] > 0
    refuse(tmp_path, [*HAND, "--algorithm", "A", "--rig", "cube-300", *BOARD], BAD_INPUT)
    refuse(tmp_path, [*HAND, "--rig", "cube-300", "--array", "tile-10x10", *BOARD], USAGE)


PAIR = '''format = "haptogram-rig-1"
name = "pair"
[[unit]]
array = "tile-10x10"
origin_mm = [-50, 0, 0]
board = "tile-100-wide"
port = "port-1"
[[unit]]
array = "tile-10x10"
origin_mm = [50, 0, 0]
board = "tile-100-wide"
port = "port-2"
'''


@pytest.mark.parametrize("words", [[*HAND, "--algorithm", "A"], [*HAND, "--algorithm", "H"], PRESS[:-2]], ids=["A", "H", "ring"])
def test_a_rig_of_two_boards(tmp_path, words):
    """Boards that play as one; in the board's time one has no underruns, and begins as often as the finger comes."""
    (tmp_path / "pair.toml").write_text(PAIR)
    two = ["--rig", "pair.toml", *["--port", "reference:tile-100-wide"] * 2]
    told = succeed([*words, *two, "--seconds", "0.4", "--scene", "s.jsonl", "--json"], cwd=tmp_path)
    felt = json.loads(told.stdout)
    assert felt["with_rings"] > 6 and felt["underruns"] == 0 and felt["begun_together"] >= 1 and felt["missed"] <= 1
    assert "the board computes foci" in told.stderr.decode()
    assert 0 < felt["latency_ms"]["least"] < felt["latency_ms"]["median"] < 60
    refuse(tmp_path, [*words, *two, "--port", "reference:tile-100-wide"], USAGE)
    refuse(tmp_path, [*words, *two[:-1], "reference:tile-100"], USAGE)
    refuse(tmp_path, [*words, *two[:-1], "port"], USAGE)
    refuse(tmp_path, [*words, *two[:2], *["--port", "reference:tile-100"] * 2], DEVICE)
    refuse(tmp_path, [*words, *two[2:]], USAGE)


@also_in_time
def test_a_rig_of_two_boards_behind_lines(tmp_path, figure, in_time):
    """The ports are those of the rig's file. The boards are off afterwards, also when the program is told to end, or one is cut off."""
    (tmp_path / "pair.toml").write_text(PAIR)
    command = [PROGRAM, "board", "run", "--tiles", "2", "--model", "reference", "--pty", "port", "--json"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as boards:
        try:
            boards.stdout.readline()
            words = [*HAND, "--algorithm", "A", "--rig", "pair.toml", "--watchdog", "60000", "--json"]
            felt = json.loads(succeed([*words, "--seconds", "0.6"], cwd=tmp_path).stdout)
            assert felt["with_rings"] > 0 and felt["rings"] > 0
            if in_time:
                assert felt["begun_together"] >= 1
                figure("live on two boards: shots of 60 without a ring", 60 - felt["with_rings"], 20, "")
            with heard_scenes() as (where, scenes), subprocess.Popen([PROGRAM, *words, "--scene", where], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as playing:
                while sum(bool(json.loads(scenes.recv(1 << 16))["foci"]) for _ in range(10)) < 5:  # it plays
                    pass
                playing.send_signal(signal.SIGINT)
                said = json.loads(playing.communicate(timeout=300)[0])
            assert said["rings"] > 0
            for port in ("port-1", "port-2"):
                status = json.loads(succeed(["device", "status", "--port", port, "--json"], cwd=tmp_path).stdout)
                assert status["outputs"] == "off"
            swapped = [*HAND, "--algorithm", "A", "--rig", "pair.toml", "--port", "port-1", "--port", "port-1"]
            refuse(tmp_path, swapped, USAGE)
        finally:
            boards.send_signal(signal.SIGINT)
            told = boards.communicate(timeout=300)[0]
    assert json.loads(told)["enabled"] == [False, False]


def test_cameras_and_a_tracker_at_a_time_each_in_its_place(tmp_path):
    """Two recordings of one press, of which one has its tracker turned and moved, and its mounting says so."""
    succeed([*PRESS, *BOARD, "--record", "hand"], cwd=tmp_path)
    cameras = (tmp_path / "hand/cameras.toml").read_text()
    (tmp_path / "moved").mkdir()
    for folder in (tmp_path / "hand").glob("camera[0-9]"):
        (tmp_path / "moved" / folder.name).symlink_to(folder)
    # Seen from 30 mm lower, all stands 30 mm higher.
    higher = re.sub(r"(position_mm = \[[^,]+,[^,]+,)([^\]]+)\]", lambda m: f"{m[1]} {float(m[2]) + 30}]", cameras)
    assert higher != cameras
    (tmp_path / "moved/cameras.toml").write_text(higher)
    (tmp_path / "desk.toml").write_text("position_mm = [0, 0, -30]\nright = [1, 0, 0]\nforward = [0, 0, 1]\n")
    place = ["--size", "60", "--center", "0,0,170", *BOARD, "--json"]
    one = json.loads(succeed(["live", "--from", "depth:hand", *place], cwd=tmp_path).stdout)
    same = json.loads(succeed(["live", "--from", "depth:moved@desk.toml", *place], cwd=tmp_path).stdout)
    assert same["with_rings"] == one["with_rings"] > 6
    both = json.loads(succeed(["live", "--from", "depth:hand", "--from", "depth:moved@desk.toml", "--from", "synthetic:press", *place, "--scene", "s.jsonl"], cwd=tmp_path).stdout)
    assert both["shots"] > one["shots"] and both["with_rings"] > one["with_rings"]  # the script goes on alone
    seen = lines(tmp_path / "s.jsonl")
    assert any(shot["hands"] for shot in seen) and any(shot["points"] > 100 and shot["sections"] for shot in seen)
    refuse(tmp_path, ["live", "--from", "depth:hand", "--from", "synthetic:press", "--algorithm", "A", *place], USAGE)
    refuse(tmp_path, ["live", "--from", "depth:hand", "--from", "depth:hand", "--record", "new", *place], USAGE)


def test_two_trackers_of_equal_times_feel_as_one_does(tmp_path):
    """A hand at 200 mm/s feels as much beside another tracker's still hand as alone, whatever the prediction."""
    moving = [frame_of(6_000_000 + 10_000 * i, dx=2 * i - 40) for i in range(40)]
    (tmp_path / "moving").write_text("\n".join(moving) + "\n")
    (tmp_path / "still").write_text("\n".join(frame_of(6_000_000 + 10_000 * i, dx=400) for i in range(40)) + "\n")
    command = ["live", "--from", "leap-pipe:moving", "--object", "sphere", "--size", "80", "--center", "0,40,160", "--algorithm", "A", "--port", "reference:tile-100-wide", "--json", "--scene", "s"]
    foci = {}
    for predict in ("none", "velocity", "kalman"):
        for other in ([], ["--from", "leap-pipe:still"]):
            felt = json.loads(succeed([*command, "--predict", predict, *other], cwd=tmp_path).stdout)
            assert felt["shots"] == 40
            foci[predict, bool(other)] = felt["with_rings"], [shot["contacts_mm"] for shot in lines(tmp_path / "s")]
        assert foci[predict, True] == foci[predict, False]
    assert foci["velocity", True][0] > 30


@contextlib.contextmanager
def heard_scenes():
    """Where to send the scene, and a socket that hears it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.settimeout(300)
        yield f"udp:127.0.0.1:{listening.getsockname()[1]}", listening


def test_the_scene_comes_while_it_happens(tmp_path):
    """Each line is as the table of the README says, and comes as a datagram before the run is over."""
    readme = (ROOT / "extras/live/README.md").read_text()
    table = readme.split("<!-- scene -->")[1]
    names = [name for row in table.splitlines() if row.startswith("| `") for name in re.findall("`([a-z_]+)`", row.split("|")[1])]
    with heard_scenes() as (where, listening):
        with subprocess.Popen([PROGRAM, *HAND, "--algorithm", "A", "--port", "reference:tile-100-wide", "--scene", where], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as running:
            first = json.loads(listening.recv(1 << 16))
            running.send_signal(signal.SIGSTOP)  # before it is over
            assert running.poll() is None
            running.send_signal(signal.SIGCONT)
            assert running.wait(300) == 0
    assert list(first) == names
    assert first["scene"] == 2 and first["foci"] and first["contacts_mm"] and len(first["hands"][0]["fingers_mm"]) == 5
    for x, y, z, _ in first["foci"]:
        assert abs(np.linalg.norm([x, y - 40, z - 160]) - 40) < 1  # on the sphere, which the line was cut from


def test_objects_come_move_and_go_by_a_script(tmp_path):
    script = [
        {"time_s": 0.2, "center_mm": [0, 40, 100]},  # out of the hand's reach
        {"time_s": 0.4, "name": "left", "object": "cylinder", "size_mm": 20, "height_mm": 30, "center_mm": [-30, 60, 180]},
        {"time_s": 0.6, "name": "right", "object": "cube", "size_mm": 20, "rotate_deg": [0, 0, 45], "center_mm": [30, 60, 180]},
        {"time_s": 0.8, "name": "left", "remove": True},
    ]
    (tmp_path / "script").write_text("".join(json.dumps(line) + "\n" for line in script))
    command = [*HAND, "--algorithm", "A", "--port", "reference:tile-100-wide", "--seconds", "1", "--scene-in", "script", "--scene", "lines"]
    succeed(command, cwd=tmp_path)
    sides = {0.1: {0}, 0.3: set(), 0.5: {-1}, 0.7: {-1, 1}, 0.88: {1}}  # where foci are, and thus which objects
    for shot in lines(tmp_path / "lines"):
        wanted = [side for time, side in sides.items() if abs(time - shot["time_s"]) < 0.05]
        if not wanted:
            continue
        xs = np.array([focus[0] for focus in shot["foci"]])
        if wanted[0] == {0}:
            assert xs.size and np.ptp(xs) > 30
        else:
            assert {int(np.sign(x)) for x in xs} <= wanted[0] and bool(xs.size) == bool(wanted[0]), shot["time_s"]
            assert np.all(abs(abs(xs) - 30) < 16)
    good = '{"center_mm": [0, 0, 0]}\n'
    for line in (
        '{"centre": [0, 0, 0]}',
        '{"time_s": 5000, "size_mm": -1}',  # whenever it is due
        '{"time_s": 9, "name": "other", "object": "bone.stl"}',
        '{"time_s": 9, "height_mm": 4}',
        '{"remove": 1}',
        '{"remove": true, "size_mm": 4}',
        '{"name": "other", "remove": true}',
        '{"time_s": 2}\n{"time_s": 1}',
    ):
        (tmp_path / "script").write_text(good + line + "\n")
        refuse(tmp_path, command, BAD_INPUT)
    (tmp_path / "script").write_text('{"remove": false}\n')  # which leaves it where it is
    succeed(command, cwd=tmp_path)
    assert any(shot["foci"] for shot in lines(tmp_path / "lines"))
    refuse(tmp_path, [*PRESS, *BOARD, "--scene-in", "script"], USAGE)


def placed(told, points):
    """Points of an object's own frame in the array's, by what the scene tells."""
    x, z = np.array(told["x"]), np.array(told["z"])
    return np.array(told["center_mm"]) + points @ np.array([x, np.cross(z, x), z])


@pytest.mark.parametrize("algorithm", ["A", "ring"])
def test_the_scene_tells_objects_as_they_stand(tmp_path, algorithm):
    """Kind, measures and pose are those of the command line, and of a script's lines when they are due."""
    words = ["live", "--from", "synthetic:press", "--algorithm", algorithm, "--port", "reference:tile-100-wide", "--seconds", "0.1", "--scene", "s"]
    turned = [*words, "--object", "cylinder", "--size", "60", "--height", "20", "--center", "1,2,180", "--rotate", "0,90,45"]
    succeed(turned, cwd=tmp_path)
    root = np.sqrt(0.5)
    for shot in lines(tmp_path / "s"):
        (told,) = shot["objects"]
        assert (told["name"], told["object"], told["size_mm"], told["height_mm"], told["center_mm"]) == ("object", "cylinder", 60, 20, pytest.approx([1, 2, 180], abs=1e-3))
        assert told["x"] == pytest.approx([0, 0, -1], abs=1e-6) and told["z"] == pytest.approx([root, root, 0], abs=1e-6)


def test_an_object_without_a_size_is_as_large_as_render_has_it(tmp_path):
    """100 mm, and a mesh as large as its file has it."""
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 50 0 0\nv 0 30 0\nv 0 0 70\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    for thing, size in (("sphere", 100), ("wedge.obj", 70)):
        succeed(["live", "--from", "synthetic:press", "--object", thing, "--algorithm", "A", "--port", "reference:tile-100-wide", "--seconds", "0.02", "--scene", "s"], cwd=tmp_path)
        sizes = [told["size_mm"] for shot in lines(tmp_path / "s") for told in shot["objects"]]
        assert sizes and sizes == pytest.approx([size] * len(sizes))


def test_the_scene_tells_a_script_and_a_mesh_that_it_moves(tmp_path):
    """A mesh that a script turns, scales and moves is told as it is felt: foci lie on its faces as told. Its file is read before, once."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 4)], float)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    (tmp_path / "block.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces))
    script = [
        {"time_s": 0.2, "name": "block", "object": "block.obj", "size_mm": 80, "center_mm": [30, 40, 190], "rotate_deg": [0, 90, 30]},
        {"time_s": 0.3, "name": "block", "size_mm": 60, "center_mm": [-30, 40, 190], "rotate_deg": [90, 20, 30]},
        {"time_s": 0.4, "remove": True},
    ]
    (tmp_path / "script").write_text("".join(json.dumps(line) + "\n" for line in script))
    words = ["live", "--from", "synthetic:press", "--object", "sphere", "--size", "20", "--center", "0,40,100", "--algorithm", "A", "--predict", "none"]
    succeed([*words, "--port", "reference:tile-100-wide", "--seconds", "0.6", "--scene-in", "script", "--scene", "s"], cwd=tmp_path)
    felt = 0
    for shot in lines(tmp_path / "s"):
        time = shot["time_s"]
        names = [told["name"] for told in shot["objects"]]
        assert names == (["object"] if time < 0.1999 else ["block", "object"] if time < 0.3999 else ["block"])
        if names[0] == "object":
            assert shot["objects"][0]["object"] == "sphere" and not shot["foci"]
            continue
        told = shot["objects"][0]
        assert told["object"] == "block.obj" and told["size_mm"] == (80 if time < 0.2999 else 60) and "height_mm" not in told
        half = 0.5 * told["size_mm"] * np.array([0.25, 0.5, 1])
        at = np.array([focus[:3] for focus in shot["foci"]]).reshape(-1, 3)
        axes = placed({**told, "center_mm": [0, 0, 0]}, np.eye(3))
        own = (at - told["center_mm"]) @ axes.T
        outside = np.max(abs(own) - half, axis=1, initial=-np.inf)
        assert np.all(abs(outside) < 1), (time, outside)
        felt += len(at) > 0
    assert felt > 20


def test_what_the_array_reaches_is_said_first(tmp_path):
    words = ["live", "--from", "synthetic:press", "--algorithm", "A", "--port", "reference:tile-100-wide", "--seconds", "0.05", "--size", "40", "--object", "sphere"]
    said = {place: succeed([*words, "--center", place], cwd=tmp_path).stderr.decode() for place in ("0,0,160", "300,0,40", "0,0,10")}
    assert re.search(r"object \(sphere\) at \(0, 0, 160\) mm: the array reaches 100 % of its surface, with [\d.e+]+ to [\d.e+]+ Pa", said["0,0,160"])
    assert "at (300, 0, 40) mm: nothing of it can be felt, the array does not reach it" in said["300,0,40"] and "off the axis" in said["300,0,40"]
    share = float(re.search(r"reaches (\d+) % of its surface", said["0,0,10"])[1])
    assert 0 < share < 75  # a quarter of it is below the array, and more is beside its reach


def test_what_the_array_reaches_of_an_object_that_comes_later_is_said(tmp_path):
    """Of one that a line brings, or makes another; not of one that moves."""
    script = [{"name": "far", "object": "cube", "size_mm": 20, "center_mm": [300, 0, 40]}, {"name": "far", "center_mm": [310, 0, 40]}, {"name": "far", "size_mm": 30}]
    (tmp_path / "script").write_text("".join(json.dumps({"time_s": 0.1 * (n + 1), **line}) + "\n" for n, line in enumerate(script)))
    words = ["live", "--from", "synthetic:press", "--algorithm", "A", "--port", "reference:tile-100-wide", "--seconds", "0.4", "--size", "40", "--object", "sphere"]
    said = succeed([*words, "--center", "0,0,160", "--scene-in", "script"], cwd=tmp_path).stderr.decode()
    assert said.count("object (sphere) at (0, 0, 160) mm: the array reaches 100 %") == 1
    assert [f"far (cube) at ({x}, 0, 40) mm: nothing of it can be felt" in said for x in (300, 310)] == [True, True] and said.count("far (cube)") == 2


def test_junk_in_the_pipe_is_counted_and_the_session_goes_on(tmp_path):
    at = [6_000_000 + 9_000 * i for i in range(60)]
    lines = [frame_of(t) for t in at]
    lines[10:10] = ["no json", lines[3], lines[12][:200], '{"event": {}}', ""]
    (tmp_path / "lines").write_text("\n".join(lines) + "\n")
    command = [*HAND, "--algorithm", "A", "--port", "reference:tile-100-wide", "--json"]
    command[2] = "leap-pipe:lines"
    done = succeed(command, cwd=tmp_path)
    felt = json.loads(done.stdout)
    assert felt["shots"] == 60 and felt["lost"] == 0 and felt["junk"] == 3
    refuse(tmp_path, [*HAND, "--algorithm", "A", *BOARD, "--press-foci", "2"], USAGE)
    refuse(tmp_path, [*PRESS, "--algorithm", "A", *BOARD], USAGE)
    refuse(tmp_path, [*HAND, "--algorithm", "K", *BOARD], DEVICE)


# Sessions by their options, on several lines of the table [live] or in words.
SESSIONS = {
    "hands": {"from": "synthetic:press", "object": "sphere", "size": 80, "center": [0, 40, 160], "algorithm": "A", "port": "reference:tile-100-wide", "seconds": 0.3},
    "cameras": {"from": "fingers:press", "size": 60, "center": "0,0,170", "algorithm": "L", "port": "reference:tile-100", "seconds": 0.4, "rate": 25, "cameras": 3, "seed": 5, "distance": 280.5, "press_frequency": 5, "press_radius": 2.5, "press_foci": 2, "voxel": 2.5, "filter": 3, "workspace_low": [-100, -100, 30], "static_friction": 0.9, "damping": 2, "mass": 90, "predict": "kalman", "latency": 30, "watchdog": 400},
    "several": {"from": ["fingers:press", "synthetic:press"], "size": 60, "center": [0, 0, 170], "port": "reference:tile-100", "seconds": 0.2},
}


def in_words(options):
    """Options as a command line has them."""
    words = []
    for key, value in options.items():
        for one in value if key == "from" and isinstance(value, list) else [value]:
            words += ["--" + key.replace("_", "-"), ",".join(map(str, one)) if isinstance(one, list) else str(one)]
    return words


@pytest.mark.parametrize("session", SESSIONS)
def test_a_table_of_a_project_makes_the_same_session(tmp_path, session):
    options = SESSIONS[session]
    table = "".join(f"{key} = {json.dumps(value)}\n" for key, value in options.items())
    (tmp_path / "p.toml").write_text(f'format = "haptogram-project-1"\nshape = [{{kind = "circle"}}]\n[live]\n{table}json = true\n')
    told = [json.loads(succeed(["live", *words, "--scene", f"scene{n}"], cwd=tmp_path).stdout) for n, words in enumerate((["--settings", "p.toml"], [*in_words(options), "--json"]))]
    for one in told:
        del one["compute_ms"]
    assert told[0] == told[1] and told[0]["with_rings"] > 0
    scenes = [lines(tmp_path / f"scene{n}") for n in (0, 1)]
    for shot in [*scenes[0], *scenes[1]]:
        del shot["compute_ms"]
    assert scenes[0] == scenes[1] and any(shot["foci"] for shot in scenes[0])


def test_what_a_project_says_of_live(tmp_path):
    """The command line comes first; every option has a key; what makes no sense is named by file and line."""
    head = "[live]\nfrom = 'synthetic:press'\nport = 'reference:tile-100-wide'\nalgorithm = 'A'\nseconds = 0.3\narray = 'hoshi'\n"
    (tmp_path / "p.toml").write_text(head)
    given = ["live", "--settings", "p.toml", "--array", "tile-10x10", "--json"]
    assert json.loads(succeed([*given, "--seconds", "0.1"], cwd=tmp_path).stdout)["shots"] == 10
    named = re.findall(r"^  --([a-z-]+)", re.sub(r"-h,--help", "", succeed(["live", "--help"]).stdout.decode()), re.MULTILINE)
    assert {name.replace("-", "_") for name in named} - {"settings"} == set(json.loads((ROOT / "docs/schemas/project.schema.json").read_text())["$defs"]["live"]["properties"])
    for line in ("sizes = 80", "size = -1", "size = []", "rig = 'hoshi-9x36'"):
        (tmp_path / "p.toml").write_text(f"{head}{line}\n")
        refuse(tmp_path, ["live", "--settings", "p.toml", *([] if "rig" in line else given[3:])], BAD_INPUT)
    (tmp_path / "p.toml").write_text(f"{head}voxel = 1\n")
    refuse(tmp_path, given, USAGE)
    (tmp_path / "p.toml").write_text("[lives]\n")
    refuse(tmp_path, given, BAD_INPUT)
    refuse(tmp_path, ["live"], USAGE)


def frame_of(at_us, dx=0.0):
    """A Leap's message: an open right hand, palm down, whose fingers lie in the upper part of the sphere of HAND; dx: mm aside."""
    names = ("mcpPosition", "pipPosition", "dipPosition", "tipPosition")
    fingers = [
        {"id": 10 + k, "handId": 1, "type": k, "width": 16.0, **{n: [20.0 * (k - 2) + dx, 195.0, -10.0 - 25.0 * i] for i, n in enumerate(names)}}
        for k in range(5)
    ]
    palm = {"id": 1, "type": "right", "palmPosition": [dx, 215.0, 60.0], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}
    return json.dumps({"id": at_us, "timestamp": at_us, "hands": [palm], "pointables": fingers})
