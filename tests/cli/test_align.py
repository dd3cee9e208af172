# SPDX-License-Identifier: Apache-2.0
"""Where a tracker is: from touches that a recording has, and from points that both know. The mounting is computed by scipy here."""
import json

import numpy as np
from scipy.spatial.transform import Rotation
from support import BAD_INPUT, USAGE, refuse, succeed, text

POINTS = np.array([[-45, -45, 12], [45, -45, 12], [45, 45, 12], [-45, 45, 12], [0, 0, 120], [30, 0, 150]], float)
TURN = Rotation.from_euler("xyz", [20, -15, 160], degrees=True)
PLACE = np.array([60.0, -130.0, 25.0])


def seen_by_the_tracker(points):
    return TURN.inv().apply(points - PLACE)


def mounting(path):
    values = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            key, value = line.split(" = ")
            values[key] = np.array(json.loads(value))
    return values


def assert_found(path, mm):
    found = mounting(path)
    assert np.abs(found["position_mm"] - PLACE).max() < mm
    assert np.allclose(found["right"], TURN.apply([1, 0, 0]), atol=mm / 50) and np.allclose(found["forward"], TURN.apply([0, 0, 1]), atol=mm / 50)


def frame_at(tip, time_us):
    """A frame of a Leap with an index finger, whose axes are x, up, and to the user: x, z and −y of what the tracker's frame is here."""
    x, y, z = tip
    joints = {key: [x, z, -y + back] for key, back in (("tipPosition", 0), ("dipPosition", 20), ("pipPosition", 45), ("mcpPosition", 85))}
    hand = {"id": 7, "type": "right", "palmPosition": [x, z, -y + 110], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}
    return {"timestamp": time_us, "hands": [hand], "pointables": [{"id": 71, "handId": 7, "type": 1, "width": 16, "extended": True, **joints}]}


def recording(tips):
    frames, time_us = [], 0
    for a, b in zip(tips, [*tips[1:], None], strict=True):
        places = [a] * 100 + ([a + (b - a) * k / 20 for k in range(20)] if b is not None else [])
        for place in places:
            frames.append(frame_at(place, time_us))
            time_us += 10_000
    return {"frames": frames}


def test_points_that_both_know(tmp_path):
    rows = np.hstack([POINTS, seen_by_the_tracker(POINTS)])
    (tmp_path / "points.txt").write_text("# known, seen\n" + "\n".join(" ".join(f"{v:.6f}" for v in row) for row in rows) + "\n")
    report = json.loads(succeed(["align", "points.txt", "-o", "desk.toml", "--json"], cwd=tmp_path).stdout)
    assert report["points"] == 6 and report["rms_mm"] < 1e-5
    assert_found(tmp_path / "desk.toml", 1e-3)


def test_touches_of_a_recording(tmp_path):
    (tmp_path / "points.txt").write_text("\n".join(", ".join(map(str, p)) for p in POINTS))
    (tmp_path / "hand.json").write_text(json.dumps(recording(list(seen_by_the_tracker(POINTS)))))
    said = text(succeed(["align", "points.txt", "hand.json", "-o", "desk.toml"], cwd=tmp_path).stdout)
    assert said.startswith("6 points, which it misses by 0.0"), said
    assert_found(tmp_path / "desk.toml", 0.3)
    # Whatever takes a recording takes it with its mounting: the finger is where it was.
    succeed(["render", "sphere", "--hand", "hand.json@desk.toml", "--center", "0,0,120", "--size", 30, "-o", "path.json"], cwd=tmp_path)
    refuse(tmp_path, ["align", "points.txt", "hand.json", "--finger", "ring", "-o", "x.toml"], BAD_INPUT, outputs=["x.toml"])
    refuse(tmp_path, ["align", "points.txt", "hand.json", "--still", "5", "-o", "x.toml"], BAD_INPUT, outputs=["x.toml"])


def test_it_asks_for_touches_and_says_when_they_are_enough(tmp_path):
    asked = json.loads(succeed(["align", "--ask", "10", "-o", "points.txt", "--json"], cwd=tmp_path).stdout)
    places = np.loadtxt(tmp_path / "points.txt")
    assert np.allclose(places, asked["places_mm"]) and len(np.unique(places, axis=0)) == 10
    assert np.all(np.hypot(places[:, 0], places[:, 1]) <= np.tan(np.radians(60.001)) * places[:, 2])  # the tile's reach
    assert asked["within_mm"] <= 1 and asked["within_deg"] <= 0.5
    # What it promises is what happens; the mountings are computed by scipy here.
    random = np.random.default_rng(3)

    def seen(points, noise_mm):
        return seen_by_the_tracker(points) + random.normal(0, noise_mm / np.sqrt(3), points.shape)

    turned = []
    for _ in range(400):
        turn, _ = Rotation.align_vectors(places - places.mean(0), (made := seen(places, 1)) - made.mean(0))
        turned.append(np.degrees((turn * TURN.inv()).magnitude()))
    assert 0.92 < np.mean(np.array(turned) <= asked["within_deg"]) < 0.98

    def aligned(points, noise_mm):
        (tmp_path / "both.txt").write_text("\n".join(" ".join(f"{v:.6f}" for v in row) for row in np.hstack([points, seen(points, noise_mm)])))
        return json.loads(succeed(["align", "both.txt", "-o", "desk.toml", "--json"], cwd=tmp_path).stdout)

    assert aligned(places, 0.7)["enough"] is True
    few = aligned(np.array([[0, 0, 20], [20, 0, 20], [0, 20, 30], [20, 20, 40.0]]), 1)
    assert few["enough"] is False and few["within_deg"] > 0.5 and len(few["next_mm"]) >= 1
    more = np.vstack([[[0, 0, 20], [20, 0, 20], [0, 20, 30], [20, 20, 40.0]], few["next_mm"]])
    assert aligned(more, 0.5)["enough"] is True


def test_what_is_wrong_is_said(tmp_path):
    (tmp_path / "line.txt").write_text("0 0 0 0 0 0\n10 0 0 10 0 0\n20 0 0 20 0 0\n")
    refuse(tmp_path, ["align", "line.txt", "-o", "x.toml"], BAD_INPUT, outputs=["x.toml"])
    (tmp_path / "short.txt").write_text("0 0 0 0 0 0\n10 0 0 10 0\n")
    refuse(tmp_path, ["align", "short.txt", "-o", "x.toml"], BAD_INPUT, outputs=["x.toml"])
    refuse(tmp_path, ["align", "short.txt", "hand.json", "--finger", "toe", "-o", "x.toml"], USAGE, outputs=["x.toml"])
    refuse(tmp_path, ["align", "-o", "x.toml"], USAGE, outputs=["x.toml"])
    refuse(tmp_path, ["align", "short.txt", "--ask", "10", "-o", "x.toml"], USAGE, outputs=["x.toml"])
    refuse(tmp_path, ["align", "--ask", "2", "-o", "x.toml"], USAGE, outputs=["x.toml"])
    refuse(tmp_path, ["align", "short.txt", "--noise", "2", "-o", "x.toml"], USAGE, outputs=["x.toml"])
