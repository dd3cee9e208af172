# SPDX-License-Identifier: Apache-2.0
"""Bare fingers on an object: `haptogram live` on the reference board, its recordings, and what it refuses."""

import json

import numpy as np
from support import BAD_INPUT, USAGE, refuse, succeed

PRESS = ["live", "--from", "fingers:press", "--object", "cube:60", "--at", "0,0,170", "--seconds", "0.4"]
BOARD = ["--port", "reference:tile-100"]


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_a_run_and_its_recording_make_the_same_rings(tmp_path):
    first = json.loads(succeed([*PRESS, *BOARD, "--record", "hand", "--scene", "first.jsonl", "--json"], cwd=tmp_path).stdout)
    assert first["shots"] == 12 and first["missed"] == 0 and first["underruns"] == 0 and first["with_rings"] >= 7
    assert 20 < first["latency_ms"]["least"] < first["latency_ms"]["most"] < 50
    again = ["live", "--from", "depth:hand", "--object", "cube:60", "--at", "0,0,170", *BOARD, "--scene", "second.jsonl", "--json"]
    second = json.loads(succeed(again, cwd=tmp_path).stdout)
    assert {k: v for k, v in first.items() if k != "compute_ms"} == {k: v for k, v in second.items() if k != "compute_ms"}
    for a, b in zip(lines(tmp_path / "first.jsonl"), lines(tmp_path / "second.jsonl"), strict=True):
        assert a["sections"] == b["sections"]
    refuse(tmp_path, [*PRESS, *BOARD, "--record", "hand"], BAD_INPUT, "already")


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


def test_the_static_focus_is_said_to_be_modulated(tmp_path):
    said = succeed([*PRESS, *BOARD, "--focus", "static"], cwd=tmp_path).stdout.decode()
    assert "static, modulated at 200 Hz" in said


def test_a_recording_keeps_when_rings_were_played(tmp_path):
    run = json.loads(succeed([*PRESS, *BOARD, "--record", "hand", "--json"], cwd=tmp_path).stdout)
    kept = json.loads((tmp_path / "hand/run.json").read_text())
    assert len(kept["ring_times"]) == run["rings"] and kept["latency_ms"] == run["latency_ms"]
    assert all(ring["pushed_s"] > ring["shot_s"] for ring in kept["ring_times"])
    assert "began_s" not in kept["ring_times"][0]  # this board counts no carrier periods


def test_strength_and_pressing_foci(tmp_path):
    one = [*PRESS, *BOARD, "--focus", "static", "--magnitude", "1.5", "--json"]
    shared = json.loads(succeed(one, cwd=tmp_path).stdout)  # two fingers share the array's pressure
    assert shared["without_magnitude"] >= 7 and shared["with_rings"] == 0
    pressed = json.loads(succeed([*PRESS, *BOARD, "--focus", "press", "--json"], cwd=tmp_path).stdout)
    assert pressed["with_rings"] >= 7 and pressed["underruns"] == 0
    refuse(tmp_path, [*PRESS, *BOARD, "--magnitude", "1.5"], USAGE, "--focus static")
    refuse(tmp_path, [*PRESS, *BOARD, "--focus", "static", "--magnitude", "500"], USAGE, "magnitude")
    refuse(tmp_path, [*PRESS, *BOARD, "--focus", "press", "--press-radius", "9"], USAGE, "smaller circle")


def test_a_camera_that_vanishes_is_named(tmp_path):
    succeed([*PRESS, *BOARD, "--record", "hand"], cwd=tmp_path)
    for shot in range(4, 8):
        (tmp_path / f"hand/camera3/{shot:06}.png").unlink()
    again = ["live", "--from", "depth:hand", "--object", "cube:60", "--at", "0,0,170", *BOARD]
    told = succeed(again, cwd=tmp_path)
    assert "camera 3          gave no picture in 4 shots" in told.stdout.decode()
    assert told.stderr.decode().count("camera 3 gave no picture") == 4


def test_what_it_cannot_use_is_named(tmp_path):
    refuse(tmp_path, ["live", "--from", "camera", *BOARD], USAGE, "depth:FOLDER")
    refuse(tmp_path, ["live", "--from", "fingers:wave", *BOARD], USAGE, "fingers:press")
    refuse(tmp_path, ["live", "--from", "depth:none", *BOARD], BAD_INPUT, "cameras.toml")
    refuse(tmp_path, [*PRESS[:3], "--object", "cube:x", *BOARD], USAGE, "cube:40")
    refuse(tmp_path, [*PRESS[:3], "--object", "cone:40", "--mass", "100", *BOARD], USAGE, "cube, sphere or cylinder")
    refuse(tmp_path, [*PRESS, "--port", "reference:nothing"], USAGE, "nothing")
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad/cameras.toml").write_text('format = "haptogram-depth-1"\nrate_hz = 30\n')
    refuse(tmp_path, ["live", "--from", "depth:bad", *BOARD], BAD_INPUT, "no camera")
