# SPDX-License-Identifier: Apache-2.0
"""extras/papers/floating.py: a ball, raindrops and a creature for a hand that `haptogram live` follows."""
import json
import math
import os
import subprocess
import sys

import pytest
from support import PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "extras/papers"))
import floating  # noqa: E402

PALM = (5.0, -7.0, 200.0)


def flight(name, seconds, step=0.01):
    """Where the things are, frame by frame, above a palm at rest: lists of (x, y, z) from the palm's middle, by name."""
    scene = [json.dumps({"time_s": n * step, "hands": [{"palm_mm": PALM}]}) + "\n" for n in range(round(seconds / step))]
    found = {}
    for line in floating.lines(iter(scene), floating.THINGS[name](1)):
        told = json.loads(line)
        assert told["object"] == "sphere" and told["size_mm"] == 30
        found.setdefault(told["name"], []).append([a - b for a, b in zip(told["center_mm"], PALM, strict=True)])
    return found


def test_a_ball_bounces_without_loss():
    (heights,) = [[z for _, _, z in places] for places in flight("ball", 3).values()]
    assert heights[::100] == pytest.approx([0, 0, 0]) and heights[50::100] == pytest.approx([200, 200, 200])
    curves = {round(a - 2 * b + c, 6) for a, b, c in zip(heights[1:97], heights[2:98], heights[3:99], strict=True)}
    assert max(curves) - min(curves) < 0.005 and max(curves) == pytest.approx(-8 * 200 * 0.01**2, abs=0.003)  # one gravity


def test_drops_fall_on_the_palm_at_other_places():
    drops = flight("rain", 20)
    assert len(drops) == 3
    for places in drops.values():
        fell = [(x, y) for (x, y, z), (_, _, before) in zip(places[201:], places[200:], strict=False) if z > before]  # began anew
        assert len(fell) >= 16 and len(set(fell)) == len(fell) and all(math.hypot(x, y) <= 40.001 for x, y in fell)


def test_a_creature_walks_on_the_palm():
    (places,) = flight("creature", 30).values()
    assert all(z == 0 and math.hypot(x, y) <= 40.002 for x, y, z in places)
    steps = [math.dist(a, b) for a, b in zip(places, places[1:], strict=False)]
    assert max(steps) == pytest.approx(0.3, abs=0.002) and sum(step > 0.29 for step in steps) > 0.9 * len(steps)
    assert max(math.hypot(x, y) for x, y, _ in places) > 30


def test_without_a_hand_all_are_away():
    scene = [json.dumps({"time_s": at, "hands": hands}) + "\n" for at, hands in ((0.0, [{"palm_mm": PALM}]), (0.1, []))]
    scene.append(scene[0][:20])  # where the session ended
    told = [json.loads(line) for line in floating.lines(iter(scene), floating.Ball(1))]
    assert [line["center_mm"] for line in told] == [[5.0, -7.0, 200.0], [0.0, 0.0, 400.0]]


@pytest.mark.parametrize(("thing", "least"), [("ball", 1), ("rain", 1), ("creature", 150)])
def test_a_hand_feels_it_live(thing, least, tmp_path):
    for pipe in ("scene", "objects"):
        os.mkfifo(tmp_path / pipe)
    with subprocess.Popen([sys.executable, floating.__file__, thing, "scene", "objects"], cwd=tmp_path) as content:
        try:
            words = ["live", "--from", "synthetic:slide:200", "--algorithm", "C", "--object", "sphere", "--size", "30", "--center", "0,0,400"]
            words += ["--port", "reference:tile-100-wide", "--seconds", "3", "--scene", "scene", "--scene-in", "objects", "--json"]
            done = subprocess.run([PROGRAM, *words], cwd=tmp_path, check=False, capture_output=True, text=True, timeout=120)
            assert done.returncode == 0, done.stderr
            report = json.loads(done.stdout)
            assert report["shots"] == 300 and report["with_rings"] >= least, report
            assert content.wait(30) == 0  # the session's end is its own
        finally:
            content.kill()
