# SPDX-License-Identifier: Apache-2.0
"""`haptogram robot explore` and `robot tell`: both modes of cables and ultrasound together, from the scene to the board's pins."""
import json

import numpy as np
import pytest
from support import USAGE, assert_one_message, read_json, run, succeed

CLOCK = 0.030


def played(folder, *arguments):
    """The report, the trace, and the path of the ultrasound."""
    found = succeed(["robot", *arguments, "--json", "-o", "t.csv", "-o", "p.json"], cwd=folder, timeout=600)
    rows = np.genfromtxt(folder / "t.csv", delimiter=",", names=True)
    path = read_json(folder / "p.json")
    assert len(rows) * 1200 == sum(step["periods"] for step in path["steps"]) and np.diff(rows["time_s"]) == pytest.approx(CLOCK)
    report = json.loads(found.stdout)
    assert report["events"] == [] and report["frames"] == len(rows) and report["most_force_off_n"] < 2
    return report, rows, path


def check_pins(report, rows, count):
    """The bursts have the frequency of the row, and the pulses the length of the command, to what rounding may do."""
    assert len(report["pins"]) == count
    for pin in report["pins"]:
        row = rows[int(round(pin["time_s"] / CLOCK)) - 1]
        assert pin["violations"] == [] and pin["pulses"] > 10_000 and pin["good"] is True
        assert pin["frequency_hz_at_pins"] == pytest.approx(row["frequency_hz"], rel=0.005)
        assert len(pin["points"]) == row["points"] > 0
        for point in pin["points"]:
            ticks = [250 * np.arcsin(point[key]) / np.pi for key in ("command", "command_at_pins")]
            assert abs(ticks[1] - ticks[0]) < 0.6 and ticks[1] == pytest.approx(round(ticks[1]), abs=0.05)


def test_explore(tmp_path):
    way = ["--way", "-35,5,250", "--way", "-35,5,236", "--way", "35,5,236"]
    report, rows, path = played(tmp_path, "explore", "cube", "--size", 60, *way, "--frames", 3)
    check_pins(report, rows, 3)
    # At rest on the surface: the springs of the hand, 100 N/m, and of the surface, 1000 N/m, balance.
    assert rows["z_mm"][-1] == pytest.approx((100 * 236 + 1000 * 240) / 1100, abs=0.2)
    assert rows["fz_n"][-1] == pytest.approx(1000 * (240 - rows["z_mm"][-1]) * 1e-3 - 1, abs=0.02)
    assert rows["user_z_n"][-1] == pytest.approx(-rows["fz_n"][-1], abs=0.05)
    # The cube's upright edges, and nothing else, at one magnitude.
    places = np.array([focus["position_mm"] for step in path["steps"] for focus in step["foci"]])
    assert np.abs(np.abs(places[:, :2]) - 30).max() < 10.1
    assert set(rows["magnitude"]) <= {0.0, 2.0} and (rows["points"] > 0).sum() == report["frames_felt"] > 20


@pytest.mark.parametrize(
    ("value", "sign", "pattern"),
    [("distance", "frequency", "focus"), ("texture", "intensity", "focus"),
     pytest.param("distance", "scaling", "ring", marks=pytest.mark.deep), pytest.param("hardness", "rotation", "line", marks=pytest.mark.deep)],
)
def test_tell(value, sign, pattern, tmp_path):
    arguments = ["tell", "--value", value, "--sign", sign, "--pattern", pattern, "--frames", 2]
    arguments += ["--frequency", 240] if sign == "intensity" else []
    way = ["--way", "-30,0,275", "--way", "-30,0,245", "--way", "30,0,245"]
    report, rows, path = played(tmp_path, *arguments, *way, "--wait", 2)
    check_pins(report, rows, 2)
    assert set(rows["fz_n"]) == {-1.0} and rows["user_z_n"][-1] == pytest.approx(1, abs=0.05)
    # What a period tells follows from where the palm was when it began.
    before = {axis: np.concatenate([[start], rows[f"{axis}_mm"][:-1]]) for axis, start in (("x", -30), ("y", 0), ("z", 275))}
    if value == "distance":
        told = 1 - np.abs(before["z"] - 250) / 100
    elif value == "texture":
        told = 0.5 + 0.5 * np.sin(2 * np.pi * before["x"] / 20) * np.sin(2 * np.pi * before["y"] / 20)
    else:
        told = np.full(len(rows), 0.5)  # 500 N/m is the geometric mean of 50 and 5000 N/m
    felt = rows["points"] > 0
    assert np.array_equal(felt, np.full(len(rows), True) if value == "distance" else before["z"] <= 250)
    if sign == "frequency":
        assert rows["frequency_hz"] == pytest.approx(80 + 220 * told, abs=1e-3)
    elif sign == "intensity":
        assert rows["magnitude"][felt] == pytest.approx(1 + 3 * told[felt], abs=1e-3)
    else:
        assert set(rows["frequency_hz"][felt]) == {200.0} and set(rows["points"][felt]) == {6.0}
    if sign == "scaling":
        begins = np.cumsum([0] + [step["periods"] for step in path["steps"]])[:-1] // 1200
        foci = [(frame, step["foci"][0]["position_mm"]) for frame, step in zip(begins, path["steps"]) if step["foci"]]
        radius = np.array([np.hypot(x - before["x"][frame], y - before["y"][frame]) for frame, (x, y, _) in foci])
        assert radius == pytest.approx([10 * (0.5 + 1.5 * told[frame]) for frame, _ in foci], abs=1e-3)


def test_a_picture(tmp_path):
    succeed(["robot", "tell", "--frames", 0, "-o", "t.png"], cwd=tmp_path, timeout=300)
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("arguments", "code"), [
    (["explore", "cup"], USAGE), (["explore", "--way", "1,2"], USAGE), (["explore", "--magnitude", 9], USAGE),
    (["explore", "--stiffness", 9000, "--way", "0,0,236"], USAGE), (["tell", "--sign", "rotation"], USAGE),
    (["tell", "--value", "colour"], USAGE), (["tell", "--low", 20, "--high", 60], USAGE), (["tell", "-o", "t.gif"], USAGE),
    (["tell", "--value", "hardness", "--stiffness", 9000], USAGE), (["tell", "--way", "0,0,900"], USAGE),
])  # fmt: skip
def test_what_is_refused(arguments, code, tmp_path):
    assert_one_message(run(["robot", *arguments, "--frames", 0], cwd=tmp_path, timeout=300), code)
