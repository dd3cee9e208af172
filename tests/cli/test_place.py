# SPDX-License-Identifier: Apache-2.0
"""`haptogram robot place`: the cube is placed by touch, and the pins of the simulated board show what each mapping asked for."""
import json

import numpy as np
import pytest
from support import RUN_FAILED, USAGE, assert_one_message, run, succeed, text

# Tables I and II of the paper Multimodal at 240 Hz, highest power first.
MAGNITUDE_240 = (-9.518, 12.93, 0.1897)


@pytest.mark.parametrize("mapping", [*(pytest.param(mapping, marks=pytest.mark.deep) for mapping in ("G1", "G2")), "G3"])
def test_a_cube_is_placed(mapping, tmp_path):
    found = json.loads(succeed(["robot", "place", "--mapping", mapping, "--frames", 3, "--json", "-o", "t.csv"], cwd=tmp_path, timeout=600).stdout)
    rows = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    assert found["placed"] is True and found["events"] == [] and abs(found["error_mm"]) < 2
    assert rows["height_mm"][-1] - 250 == pytest.approx(found["error_mm"], abs=1e-3)
    assert found["weight_felt_n"] == pytest.approx(1, abs=0.02) and rows["user_n"][-30:].mean() == pytest.approx(1, abs=0.02)
    assert found["wrench"] == [0, 0, -1, 0, 0, 0] and len(rows) == found["frames"] and np.diff(rows["time_s"]) == pytest.approx(0.030)
    assert len(found["pins"]) == 3
    for pin in found["pins"]:
        row = int(round(pin["time_s"] / 0.030)) - 1
        before = abs(rows["height_mm"][row - 1] - 250) if row else 50
        asked = {"G1": 200, "G2": 300 - 220 * before / 100, "G3": 240}[mapping]
        assert pin["frequency_hz"] == pytest.approx(asked, rel=1e-4)
        assert pin["frequency_hz_at_pins"] == pytest.approx(asked, rel=0.005)
        assert pin["violations"] == [] and pin["pulses"] > 10_000 and pin["good"] is True
        assert len(pin["points"]) == {"G1": 6, "G2": 1, "G3": 1}[mapping]
        for point in pin["points"]:
            # A pulse has whole ticks of 1/250 period: half of one is what rounding may do to the carrier's amplitude.
            ticks = [250 * np.arcsin(point[key]) / np.pi for key in ("command", "command_at_pins")]
            assert abs(ticks[1] - ticks[0]) < 0.6 and ticks[1] == pytest.approx(round(ticks[1]), abs=0.05)
            # The magnitude goes with the square of the command, by eq. 10.
            if mapping == "G3":
                g, j, v = MAGNITUDE_240
                output = min(r.real for r in np.roots((g, j, v - pin["magnitude"])))
                output *= (point["command_at_pins"] / point["command"]) ** 2
                assert point["magnitude_at_pins"] == pytest.approx(np.polyval(MAGNITUDE_240, output), rel=1e-6)


@pytest.mark.deep
def test_a_picture_and_words(tmp_path):
    said = text(succeed(["robot", "place", "--mapping", "G3", "--frames", 1, "-o", "t.png"], cwd=tmp_path, timeout=600).stdout)
    assert "G3: placed after" in said and "at the pins" in said and "1200 carrier periods" in said
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")


def test_a_run_that_is_too_short():
    result = run(["robot", "place", "--mapping", "G3", "--longest", 0.3, "--frames", 0, "--json"], timeout=300)
    assert result.returncode == RUN_FAILED
    found = json.loads(result.stdout)
    assert found["placed"] is False and "error_mm" not in found and found["frames"] == 10


@pytest.mark.parametrize("arguments", [
    [], ["--mapping", "G4"], ["--mapping", "G1", "--start", 200],
    ["--mapping", "G2", "--magnitude", 3], ["--mapping", "G3", "-o", "t.gif"],
    ["--mapping", "G3", "--start", 420],
])  # fmt: skip
def test_what_is_refused(arguments, tmp_path):
    assert_one_message(run(["robot", "place", *arguments, "--frames", 0], cwd=tmp_path, timeout=300), USAGE)
