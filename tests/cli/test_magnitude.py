# SPDX-License-Identifier: Apache-2.0
"""`haptogram magnitude`: the printed tables worked out with numpy's roots, the chain to the pulse, and its domain."""
import json

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, assert_one_message, run, succeed, text

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
    near = asked(2, "--frequency", 180, "--array", "hoshi-18x18", "--focus", "0,0,150")
    far = asked(2, "--frequency", 180, "--array", "hoshi-18x18", "--focus", "0,0,300")
    assert near["command"] < far["command"] < 1
    for found in (near, far):
        assert found["command"] ** 2 * found["full_gf"] == pytest.approx(output_of(180, 2))


@pytest.mark.parametrize(("arguments", "code", "needle"), [
    ([9, "--frequency", 180], USAGE, "cannot be made at 180 Hz"), ([0.1, "--frequency", 180], USAGE, "less than the 0.0590 gf"),
    ([2, "--frequency", 301], USAGE, "80…300 Hz"), (["--grip", 11], USAGE, "1…10 N"), ([2, "--region", "finger"], USAGE, "palm only"),
    (["--command", 0.1], USAGE, "no output"), ([2, "--duty", 1], USAGE, "does not alternate"), (["--tables", "none.toml"], BAD_INPUT, "none.toml"),
    ([2, "--array", "hoshi-18x18", "--focus", "900,0,10"], BAD_INPUT, "--focus"), ([2, "--command", 0.5], USAGE, "exclude"),
])  # fmt: skip
def test_what_is_refused(arguments, code, needle):
    assert_one_message(run(["magnitude", *arguments]), code, needle)
