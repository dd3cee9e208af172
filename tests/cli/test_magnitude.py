# SPDX-License-Identifier: Apache-2.0
"""`haptogram magnitude`: the printed tables worked out with numpy's roots, the chain to the pulse, and its domain."""
import json

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, Image, assert_one_message, refuse, run, succeed, text

# Tables I and II of the paper Multimodal, highest power first.
COMMAND = {80: (2.079, -3.131, 2.411, 0.2146), 180: (3.744, -4.675, 2.791, 0.2585), 300: (5.454, -6.006, 3.105, 0.2759)}
MAGNITUDE = {80: (-10.39, 23.17, -0.2071), 180: (-12.46, 20.88, -0.1070), 300: (-3.682, 6.118, 0.3376)}


def output_of(hz, magnitude):
    g, j, v = MAGNITUDE[hz]
    return min(root.real for root in np.roots((g, j, v - magnitude)) if abs(root.imag) < 1e-12)


def asked(*args, **more):
    return json.loads(succeed(["magnitude", *args, "--json"], **more).stdout)


@pytest.mark.parametrize(("hz", "magnitude"), [(80, 2), (80, 9), (180, 1.2), (180, 5), (300, 2)])
def test_from_a_magnitude_to_a_pulse(hz, magnitude):
    found = asked(magnitude, "--frequency", hz)
    output = output_of(hz, magnitude)
    command = np.polyval(COMMAND[hz], output)
    assert found["output_gf"] == pytest.approx(output, abs=1e-9)
    assert found["command"] == pytest.approx(command, abs=1e-9)
    assert np.sin(np.pi * found["pulse_duty"]) == pytest.approx(command, abs=1e-9)
    back = asked("--command", f"{found['command']:.12f}", "--frequency", hz)
    assert back["magnitude"] == pytest.approx(magnitude, abs=1e-6) and back["felt"] is True


def test_waveform_and_duty():
    output = output_of(180, 2)
    assert asked(2, "--frequency", 180, "--duty", 0.25)["needed_gf"] == pytest.approx(output * np.sqrt(2))
    assert asked(2, "--frequency", 180, "--duty", 0.25, "--weighing", "mean")["needed_gf"] == pytest.approx(output * 2)
    assert asked(2, "--frequency", 180, "--waveform", "sine")["needed_gf"] == pytest.approx(output * 4 / np.pi)


def test_what_can_be_felt():
    found = asked("--frequency", 180)
    assert found["threshold_interval_gf"] == pytest.approx([0.05903, 0.06903])
    assert found["least_felt_gf"] == pytest.approx(0.05903)
    full = max(r.real for r in np.roots((3.744, -4.675, 2.791, 0.2585 - 1)) if abs(r.imag) < 1e-12)
    assert found["full_output_gf"] == pytest.approx(full)
    assert found["magnitudes"] == pytest.approx([np.polyval(MAGNITUDE[180], 0.05903), np.polyval(MAGNITUDE[180], full)])
    finger = asked("--frequency", 200, "--region", "finger", "--grip", 10)
    assert finger["threshold_interval_gf"] == pytest.approx([0.1094, 0.1161]) and "magnitudes" not in finger
    assert "least felt by a palm" in text(succeed(["magnitude"]).stdout)


def test_for_an_array():
    # Nearer than this the sound comes from so far aside that the force falls again.
    near = asked(2, "--frequency", 180, "--array", "hoshi-18x18", "--focus", "0,0,200")
    far = asked(2, "--frequency", 180, "--array", "hoshi-18x18", "--focus", "0,0,300")
    assert near["command"] < far["command"] < 1
    for found in (near, far):
        assert found["command"] ** 2 * found["full_gf"] == pytest.approx(output_of(180, 2))
    (point,) = json.loads(succeed(["analyze", "--array", "hoshi-18x18", "--focus", "0,0,200", "--json"]).stdout)["points"]
    assert near["full_gf"] * 9.80665 == pytest.approx(point["force_mn"] / 2, rel=1e-4)  # one force; a square of 50 % has half of it


@pytest.mark.parametrize(("arguments", "code"), [
    ([9, "--frequency", 180], USAGE), ([0.1, "--frequency", 180], USAGE),
    ([2, "--frequency", 301], USAGE), (["--grip", 11], USAGE), ([2, "--region", "finger"], USAGE),
    (["--command", 0.1], USAGE), ([2, "--duty", 1], USAGE), (["--tables", "none.toml"], BAD_INPUT),
    ([2, "--array", "hoshi-18x18", "--focus", "900,0,10"], BAD_INPUT), ([2, "--command", 0.5], USAGE),
])  # fmt: skip
def test_what_is_refused(arguments, code):
    assert_one_message(run(["magnitude", *arguments]), code)


def compiled(folder, name, *args):
    """The report of `compile`, and the records' pulses as a part of their cycle."""
    report = json.loads(succeed(["compile", *args, "-o", name, "--json"], cwd=folder).stdout)
    return report, {record["pulse_length"] / record["cycle_length"] for record in Image(folder / name).records()}


POINT = ("--shape", "point", "--center", "0,0,150")


def test_an_image_that_feels_with_a_magnitude(tmp_path):
    setting = asked(2, "--frequency", 180, "--array", "tile-10x10", "--focus", "0,0,150")
    report, pulses = compiled(tmp_path, "image.hex", *POINT, "--am", "square:180", "--magnitude", 2)
    assert report["least_command"] == report["most_command"] == pytest.approx(setting["command"])
    assert report["focus_moves"] is False
    assert max(pulses) == pytest.approx(setting["pulse_duty"], abs=1 / 250)
    (tmp_path / "project.toml").write_text(
        'format = "haptogram-project-1"\nam = "square:180"\nmagnitude = 2.0\n'
        '[place]\ncenter_mm = [0, 0, 150]\n[[shape]]\nkind = "point"\n'
    )
    compiled(tmp_path, "same.hex", "project.toml")
    assert (tmp_path / "same.hex").read_bytes() == (tmp_path / "image.hex").read_bytes()


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--magnitude", 2], USAGE),
        (["--am", "sine:200", "--am-law", "radiation", "--magnitude", 2], USAGE),
        (["--am", "square:400", "--magnitude", 2], USAGE),
        (["--am", "square:180", "--magnitude", 7.6], USAGE),
        (["--am", "square:180", "--magnitude", 0], USAGE),
    ],
)
def test_magnitudes_that_no_image_has(tmp_path, options, code):
    refuse(tmp_path, ["compile", *POINT, *options], code)
