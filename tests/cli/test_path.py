# SPDX-License-Identifier: Apache-2.0
"""Paths: drawing at a speed, path files, dwells for an even feeling, modulation; judged by numpy from image and manifest."""

import json
import re

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, Image, foci_mm, read_json, refuse, succeed, text

CARRIER_HZ = 40_000


def compiled(folder, *arguments):
    """The report, the foci in millimetres, and (index, dwell) of each entry."""
    report = json.loads(succeed(["compile", *arguments, "-o", "image.hex", "--json"], cwd=folder).stdout)
    manifest = read_json(folder / "image.json")
    entries = [(int(e & 0xFFFF), int(e >> 16)) for e in Image(folder / "image.hex").sequence()[1:]]
    return report, foci_mm(manifest), entries


def positions(foci, entries):
    """Where the focus is in each carrier period of a pass; NaN in silence."""
    silent = np.full(3, np.nan)
    return np.concatenate([np.tile(foci[index - 1] if index else silent, (dwell, 1)) for index, dwell in entries])


@pytest.mark.parametrize("speed", [1, 7, 11.5])
@pytest.mark.parametrize("shape", [["circle", "--diameter", 60], ["square", "--length", 70], ["triangle"]], ids=lambda shape: shape[0])
def test_the_focus_moves_at_the_speed(shape, speed, tmp_path):
    report, foci, entries = compiled(tmp_path, "--shape", *shape, "--speed", speed, "--points", 90)
    where = positions(foci, entries)
    way_m = np.linalg.norm(where - np.roll(where, -1, axis=0), axis=1).sum() * 1e-3
    length = report["length_mm"] * 1e-3
    # The way from point to point cuts corners: half a spacing at each of a triangle.
    assert way_m == pytest.approx(length, abs=1.6 * length / 90)
    assert length * CARRIER_HZ / len(where) == pytest.approx(speed, rel=0.005)
    assert report["speed_m_s"] == pytest.approx(length * CARRIER_HZ / len(where), rel=1e-9)
    dwells = [dwell for _, dwell in entries]
    assert max(dwells) - min(dwells) <= 1


def test_a_frequency_gives_the_speed(tmp_path):
    report, foci, entries = compiled(tmp_path, "--shape", "circle", "--diameter", 100, "--frequency", 22.282)
    assert len(positions(foci, entries)) == round(CARRIER_HZ / 22.282)
    assert report["speed_m_s"] == pytest.approx(7.0, rel=0.005) and report["frequency_hz"] == pytest.approx(22.282, rel=1e-3)


def test_jumps_are_silent_or_take_no_time(tmp_path):
    _, foci, entries = compiled(tmp_path, "--shape", "plus", "--speed", 5, "--jump", "blank")
    where = positions(foci, entries)
    silent = np.isnan(where[:, 0])
    assert silent.sum() / CARRIER_HZ * 5 == pytest.approx(2 * 100 / np.sqrt(2) * 1e-3, rel=0.005)
    _, foci, entries = compiled(tmp_path, "--shape", "plus", "--speed", 5)
    assert not np.isnan(positions(foci, entries)).any() and len(positions(foci, entries)) == 0.2 / 5 * CARRIER_HZ


def test_too_many_points_for_the_speed_says_how_many(tmp_path):
    refuse(tmp_path, ["compile", "--shape", "circle", "--diameter", 10, "--speed", 7], BAD_INPUT)
    refuse(tmp_path, ["compile", "--shape", "circle", "--speed", 7, "--frequency", 7], USAGE)
    refuse(tmp_path, ["compile", "--shape", "circle", "--speed", 7, "--rate", 7], USAGE)
    refuse(tmp_path, ["compile", "--shape", "point", "--speed", 7], BAD_INPUT)


def test_project_files_say_the_same(tmp_path):
    (tmp_path / "p.toml").write_text(
        'format = "haptogram-project-1"\npoints = 50\nspeed_m_s = 6.5\njump = "blank"\neven = true\n[[shape]]\nkind = "plus"\n'
    )
    succeed(["compile", "p.toml", "-o", "p.hex"], cwd=tmp_path)
    succeed(["compile", "--shape", "plus", "--points", 50, "--speed", 6.5, "--jump", "blank", "--even", "-o", "o.hex"], cwd=tmp_path)
    assert (tmp_path / "p.hex").read_bytes() == (tmp_path / "o.hex").read_bytes()
    assert (tmp_path / "p.json").read_bytes() == (tmp_path / "o.json").read_bytes()
    succeed(["compile", "p.toml", "--rate", 10, "-o", "r.hex"], cwd=tmp_path)
    assert json.loads((tmp_path / "r.json").read_text())["rendering"]["rate_hz"] == pytest.approx(10)


def test_a_saved_path_gives_the_same_image(tmp_path):
    compiled(tmp_path, "--shape", "circle", "--speed", 7, "--points", 40, "--save-path", "path.json")
    path = read_json(tmp_path / "path.json")
    assert path["format"] == "haptogram-path-1" and path["carrier_hz"] == CARRIER_HZ and len(path["steps"]) == 40
    succeed(["compile", "--path", "path.json", "-o", "again.hex"], cwd=tmp_path)
    assert (tmp_path / "again.hex").read_bytes() == (tmp_path / "image.hex").read_bytes()


def test_a_csv_is_played_row_by_row(tmp_path):
    rows = ["time_ms,x_mm,y_mm,z_mm,intensity"] + [f"{i},{10 * np.cos(i)},{10 * np.sin(i)},130,{1 - i / 20}" for i in range(10)]
    (tmp_path / "ring.csv").write_text("\n".join(rows) + "\n")
    _, foci, entries = compiled(tmp_path, "--path", "ring.csv")
    assert [dwell for _, dwell in entries] == [40] * 10
    assert np.allclose(foci, [[10 * np.cos(i), 10 * np.sin(i), 130] for i in range(10)], atol=1e-4)
    amplitudes = [r.get("amplitude", 1.0) for r in read_json(tmp_path / "image.json")["records"]]
    assert np.allclose(amplitudes, [1 - i / 20 for i in range(10)])
    pulses = [r["pulse_length"] for r in Image(tmp_path / "image.hex").records()]
    assert np.allclose(np.sin(np.pi * np.array(pulses) / 250), amplitudes, atol=np.pi / 250)


def test_a_path_out_of_reach_or_with_a_shape_is_refused(tmp_path):
    (tmp_path / "far.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,0,0,130\n1,500,0,130\n")
    refuse(tmp_path, ["compile", "--path", "far.csv"], BAD_INPUT)
    refuse(tmp_path, ["compile", "--path", "far.csv", "--shape", "circle"], USAGE)
    refuse(tmp_path, ["compile", "--path", "far.csv", "--center", "0,0,100"], USAGE)
    refuse(tmp_path, ["compile", "--path", "none.json"], BAD_INPUT)
    (tmp_path / "image.json").write_text("{}")
    refuse(tmp_path, ["compile", "--path", "image.json", "-o", "image.hex"], USAGE, outputs=("image.hex",))
    refuse(tmp_path, ["compile", "--path", "far.csv", "--rate", 3], USAGE)


def piston(x):
    """2·J1(x)/x, by Bessel's integral J1(x) = mean of cos(τ − x·sin τ) over a turn."""
    turn = np.arange(64) * 2 * np.pi / 64
    bessel = np.cos(turn - x[..., None] * np.sin(turn)).mean(axis=-1)
    return np.where(x < 1e-6, 1.0, 2 * bessel / np.maximum(x, 1e-6))


def mean_square_at_foci(manifest):
    """Time-averaged |p|² at each focus, with every focus' field there: pistons, spherical waves, exact phases."""
    elements = np.array(manifest["array"]["elements_mm"]) * 1e-3
    k = 2 * np.pi * CARRIER_HZ / manifest["medium"]["speed_m_s"]
    foci = foci_mm(manifest) * 1e-3
    gap = foci[:, None, :] - elements[None]
    distance = np.linalg.norm(gap, axis=2)
    sine = np.hypot(gap[..., 0], gap[..., 1]) / distance
    waves = piston(k * manifest["transducer"]["radius_mm"] * 1e-3 * sine) / distance * np.exp(-(1j * k + manifest["medium"]["absorption_np_m"]) * distance)
    fields = np.abs(waves @ np.exp(1j * k * distance).T) ** 2
    return fields @ np.array([r["dwell_cycles"] for r in manifest["records"]], dtype=float)


def test_even_dwells_feel_even(tmp_path):
    felt = []
    for options in ([], ["--even"]):
        report, _, entries = compiled(tmp_path, "--shape", "hemisphere", "--points", 100, *options)
        assert sum(dwell for _, dwell in entries) == 4000
        felt.append(mean_square_at_foci(read_json(tmp_path / "image.json")))
    before, after = felt
    assert after.std() / after.mean() <= 0.03 < before.std() / before.mean()
    assert report["spread"] == pytest.approx(after.std() / after.mean(), rel=0.02)
    assert report["spread_before"] == pytest.approx(before.std() / before.mean(), rel=0.02)
    assert report["weakest_of_before"] == pytest.approx(after.min() / before.min(), rel=0.01)
    assert min(dwell for _, dwell in entries) >= 40 / 3 - 0.5


def test_modulation_is_in_the_pulses(tmp_path):
    report, _, entries = compiled(tmp_path, "--shape", "point", "--am", "sine:200")
    lengths = [0] + [r["pulse_length"] for r in Image(tmp_path / "image.hex").records()]
    amplitude = np.concatenate([np.full(dwell, np.sin(np.pi * lengths[index] / 250)) for index, dwell in entries])
    assert len(amplitude) == 200 and report["am_hz"] == [200.0]
    lines = np.abs(np.fft.rfft(amplitude)) / len(amplitude) * 2
    assert 20 * np.log10(lines[1] / 0.5) == pytest.approx(0, abs=0.1)
    assert 20 * np.log10(lines[2:6].max() / lines[1]) <= -40, "spurs below 1 kHz"
    refuse(tmp_path, ["compile", "--shape", "point", "--am", "tone:200"], USAGE)
    refuse(tmp_path, ["compile", "--shape", "circle", "--am", "sine:200"], BAD_INPUT)


def test_field_of_a_modulated_image_is_its_mean(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 8, "-o", "image.hex"], cwd=tmp_path)

    def radiation(*options):
        shown = text(succeed(["field", "image.hex", "--line", "z@x=0,y=0", "--step", 10, *options], cwd=tmp_path).stdout)
        return np.array([float(line.split(",")[1]) for line in shown.splitlines()[1:]])

    for wave, mean in (("sine:200", 0.375), ("square:200", 0.5), ("sine:200 --am-law radiation", 0.5)):
        assert np.allclose(radiation("--am", *wave.split()) / radiation(), mean, rtol=2e-3)


def test_the_bandwidth_is_reported(tmp_path):
    fine = compiled(tmp_path, "--shape", "circle", "--diameter", 20, "--speed", 7, "--points", 359)[0]
    coarse = compiled(tmp_path, "--shape", "sphere", "--rate", 200)[0]
    assert 0.9 < fine["pressure_left_least"] <= fine["pressure_left_mean"] <= 1.001
    assert coarse["pressure_left_least"] < 0.7
    shown = text(succeed(["compile", "--shape", "circle", "-o", "image.hex"], cwd=tmp_path).stdout)
    assert re.search(r"bandwidth leaves +\d+\.\d % of the pressure", shown)
    analysis = json.loads(succeed(["analyze", "image.hex", "--json"], cwd=tmp_path).stdout)
    assert 0.5 < analysis["pressure_left_least"] <= analysis["pressure_left_mean"] <= 1.001
