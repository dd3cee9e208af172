# SPDX-License-Identifier: Apache-2.0
"""`haptogram feel`: forces and spectra beside numpy's sums over the image, what is said out of range, and what is refused."""
import json
import re

import numpy as np
import pytest
from messages import notice
from support import BAD_INPUT, ROOT, USAGE, assert_one_message, read_json, refuse, run, succeed, text

POINT = ("--shape", "point", "--center", "0,0,150")
GRAM_FORCE = 9.80665  # mN


def compiled(folder, name, *args):
    succeed(["compile", *args, "-o", f"{name}.hex"], cwd=folder)
    return f"{name}.hex"


def feel(folder, *args):
    return json.loads(succeed(["feel", *args, "--json"], cwd=folder).stdout)


def radiation_pa(manifest, focus_mm, points_mm):
    """On rigid skin that faces the array, of a focus with exact phases, at points; the free field of pistons, twice."""
    elements = np.array(manifest["array"]["elements_mm"], dtype=float) * 1e-3
    c, rho = manifest["medium"]["speed_m_s"], manifest["medium"]["density_kg_m3"]
    k = 2 * np.pi * manifest["array"]["carrier_hz"] / c
    r0 = np.linalg.norm(np.array(focus_mm) * 1e-3 - elements, axis=1)
    way = np.array(points_mm)[:, None] * 1e-3 - elements[None]
    r = np.linalg.norm(way, axis=2)
    from scipy.special import j1

    sine = np.hypot(way[..., 0], way[..., 1]) / r
    ka = np.maximum(k * manifest["transducer"]["radius_mm"] * 1e-3 * sine, 1e-9)
    alpha = manifest["medium"].get("absorption_np_m", 0.0)
    p = manifest["transducer"]["source_pa_m"] * 2 * j1(ka) / ka / r * np.exp(1j * k * (r0 - r) - alpha * r)
    grazing = (np.abs((p[..., None] * way[..., :2] / r[..., None]).sum(axis=1)) ** 2).sum(axis=1)
    return (np.abs(p.sum(axis=1)) ** 2 - grazing) / (rho * c**2)


def test_the_pages_about_safety_have_the_numbers_of_the_command(tmp_path):
    """No mean of something that is off now and then: the loudest counts where somebody decides about ears."""
    found = feel(tmp_path, "--focus", "0,0,100")
    around, ear = (f"{level['most_db_spl']:.1f} dB" for level in (found["loudest_at_500_mm"], found["ears"][0]))
    assert [found["array"], found["ears"][0]["at_mm"]] == ["tile-10x10", [0, -400, 300]]
    for page in ("docs/build-one.md", "docs/README.md"):
        said = (ROOT / page).read_text(encoding="utf-8")
        assert f"p to {around}" in said and f"{ear} at the ear of a person" in said.replace("\n", " "), (page, around, ear)
        assert not re.search(r"\b1[123]\d(\.\d)? dB", re.sub(f"{around}|{ear}|Limits are 110 dB", "", said)), page


@pytest.mark.check
def test_a_point_under_a_slow_square_wave(tmp_path):
    image = compiled(tmp_path, "slow", *POINT, "--am", "square:100")
    found = feel(tmp_path, image)
    manifest = read_json(tmp_path / "slow.json")
    place = found["places"][0]
    assert place["at_mm"] == pytest.approx([0, 0, 150])
    assert found["seconds"] == pytest.approx(0.01)
    steady = radiation_pa(manifest, (0, 0, 150), [(0, 0, 150)])[0]
    assert place["most_pa"] == pytest.approx(steady, rel=2e-3)  # rounding to ticks
    # A carrier that rises and falls with τ = 1/(πB) has the mean square ½·(1 − 2τ/T·…): by numbers.
    t = (np.arange(400) + 0.5) / 40000
    left = np.exp(-np.pi * manifest["transducer"]["bandwidth_hz"] * (t % 0.005))
    envelope = np.where(t < 0.005, 1 - left, left)
    assert place["mean_pa"] == pytest.approx(steady * (envelope**2).mean(), rel=5e-3)
    side = np.linspace(-10, 10, 81)
    x, y = np.meshgrid(side, side)
    disc = np.stack([x, y, np.full_like(x, 150)], axis=-1)[np.hypot(x, y) <= 10]
    force = radiation_pa(manifest, (0, 0, 150), disc).sum() * 0.25e-3**2
    spectrum = np.abs(np.fft.rfft(force * 1e3 * envelope**2)) * 2 / 400
    assert place["lines"][0]["hz"] == pytest.approx(100)
    assert place["lines"][0]["force_mn"] == pytest.approx(spectrum[1], rel=0.02)
    # Table III: 0.05903 to 0.06903 gf; ours takes the high end at 80 Hz and the low end at 180 Hz.
    share = np.log(180 / 100) / np.log(180 / 80)
    least = (0.05903 + 0.01 * share) * GRAM_FORCE * 4 / np.pi
    assert place["lines"][0]["least_mn"] == pytest.approx(least, rel=1e-6)
    assert place["lines"][0]["threshold_by"] == "tables"
    assert place["expected_to_be_felt"] is True and found["places_expected_to_be_felt"] == 1
    gf = place["lines"][0]["force_mn"] / GRAM_FORCE / (4 / np.pi)
    assert place["magnitude"] == pytest.approx(np.polyval((-20.49, 27.86, -0.3396), gf))
    assert "nothing was measured on people" in found["note"]


def test_what_lies_outside_of_the_tables_is_said(tmp_path):
    image = compiled(tmp_path, "slow", *POINT, "--am", "sine:40")
    result = succeed(["feel", image, "--json"], cwd=tmp_path)
    place = json.loads(result.stdout)["places"][0]
    assert place["lines"][0]["threshold_by"] in ("displacement", "tables")
    slow = next(line for line in place["lines"] if line["hz"] == pytest.approx(40))
    assert slow["threshold_by"] == "displacement"
    steady = compiled(tmp_path, "steady", *POINT)
    found = feel(tmp_path, steady)
    assert found["places"][0]["lines"] == [] and found["places"][0]["expected_to_be_felt"] is False
    assert "80 and 300 Hz" in found["places"][0]["no_magnitude"] and found["noise"]["relative_db"] is None
    assert "nothing alternates" in text(succeed(["feel", steady], cwd=tmp_path).stdout)
    finger = feel(tmp_path, compiled(tmp_path, "am", *POINT, "--am", "square:200"), "--region", "finger")
    assert "palms alone" in finger["places"][0]["no_magnitude"]


def test_tilted_skin_and_places(tmp_path):
    image = compiled(tmp_path, "am", *POINT, "--am", "square:200")
    flat = feel(tmp_path, image)["places"][0]
    for degrees in (30, 60):
        a = np.radians(degrees)
        tilted = feel(tmp_path, image, "--normal", f"{np.sin(a)},0,{-np.cos(a)}")["places"][0]
        assert tilted["tilt"] == pytest.approx(np.cos(a) ** 2, abs=1e-6)
        # Waves of a focus come from many sides, 17 degrees to each here, which cos² of one wave leaves out.
        assert tilted["mean_pa"] / flat["mean_pa"] == pytest.approx(np.cos(a) ** 2, abs=0.06)
    away = succeed(["feel", image, "--normal", "0,0,1", "--json"], cwd=tmp_path)
    assert json.loads(away.stdout)["places"][0]["mean_pa"] == 0
    notice(away.stderr)
    two = feel(tmp_path, image, "--at", "0,0,150", "--at", "30,0,150")["places"]
    assert two[0]["mean_pa"] == pytest.approx(flat["mean_pa"]) and two[1]["mean_pa"] < 0.1 * flat["mean_pa"]


def test_a_path_that_is_drawn(tmp_path):
    image = compiled(tmp_path, "circle", "--shape", "circle", "--diameter", 40, "--points", 200, "--speed", 7)
    found = feel(tmp_path, image, "--places", 4, "--ear", "0,-300,200", "--ear", "0,0,500")
    assert len(found["places"]) == 4 and found["speed_m_s"] == pytest.approx(7, rel=0.005)
    assert found["wave_gain"] > 1
    frequency = 7 / (np.pi * 0.04)
    for place in found["places"]:
        assert place["lines"][0]["hz"] / frequency == pytest.approx(round(place["lines"][0]["hz"] / frequency), rel=0.005)
        assert place["modulation_depth"] > 0.9
    assert found["noise"]["largest_phase_step_deg"] > 2 and len(found["ears"]) == 2
    assert found["loudest_at_500_mm"]["mean_db_spl"] >= found["ears"][1]["mean_db_spl"] - 1e-3
    path = tmp_path / "circle.json.path.json"
    succeed(["compile", "--shape", "circle", "--diameter", 40, "--points", 200, "--speed", 7, "--save-path", path, "-o", "b.hex"], cwd=tmp_path)
    assert feel(tmp_path, path, "--places", 4)["places"] == found["places"]


def test_the_pins_give_what_the_image_gives(tmp_path):
    """Three passes on the Verilated core; the focus that is measured at its pins has the speed that was asked."""
    image = compiled(tmp_path, "circle", "--shape", "circle", "--diameter", 40, "--points", 60, "--speed", 7)
    succeed(["simulate", image, "--load", "direct", "--passes", 3, "--pulses", "pulses.csv"], cwd=tmp_path, timeout=300)
    pins = feel(tmp_path, "--pulses", "pulses.csv", "--manifest", "circle.json", "--places", 3)
    expected = feel(tmp_path, image, "--places", 3)
    assert pins["speed_m_s"] == pytest.approx(7, rel=0.005)
    assert pins["seconds"] == pytest.approx(2 * expected["seconds"])  # without the first pass
    assert pins["played"].endswith("as measured at the pins")
    for measured, computed in zip(pins["places"], expected["places"], strict=True):
        assert measured["mean_pa"] == pytest.approx(computed["mean_pa"], rel=0.02)
        assert measured["lines"][0]["hz"] == pytest.approx(computed["lines"][0]["hz"])
        assert measured["lines"][0]["force_mn"] == pytest.approx(computed["lines"][0]["force_mn"], rel=0.02)


def test_the_skin_of_a_hand(tmp_path):
    """What render drew on a hand is on that hand's skin; other places move to it; normals and regions are those of the skin."""
    hand = ("--hand", "synthetic:press", "--hand-frame", 30)
    succeed(["render", "sphere", *hand[:2], "--frame", 30, "--center", "0,0,180", "--size", 60, "-o", "path.json"], cwd=tmp_path)
    image = compiled(tmp_path, "touch", "--path", "path.json")
    found = feel(tmp_path, image, *hand, "--places", 3)
    assert "region" not in found and len(found["places"]) == 3
    for place in found["places"]:
        assert place["part"] == "palm" and place["off_skin_mm"] < 0.01 and place["normal"] == pytest.approx([0, 0, -1])
    flat = feel(tmp_path, image, "--places", 3)["places"]
    assert [p["mean_pa"] for p in found["places"]] == pytest.approx([p["mean_pa"] for p in flat], rel=1e-3)
    # Below a finger: its skin is round, and the tables have no magnitudes for it.
    finger = feel(tmp_path, image, *hand, "--at", "-8,100,150")["places"][0]
    assert finger["part"] in ("index", "middle", "ring") and finger["off_skin_mm"] > 1
    assert np.linalg.norm(finger["normal"]) == pytest.approx(1) and np.array(finger["at_mm"]) @ finger["normal"] < 0
    assert np.linalg.norm(np.array(finger["at_mm"]) - [-8, 100, 150]) == pytest.approx(finger["off_skin_mm"])
    at, normal = (",".join(str(x) for x in finger[key]) for key in ("at_mm", "normal"))
    same = feel(tmp_path, image, "--at", at, "--normal", normal, "--region", "finger")["places"][0]
    assert same["mean_pa"] == pytest.approx(finger["mean_pa"], rel=1e-6)
    assert same["expected_to_be_felt"] == finger["expected_to_be_felt"]
    away = succeed(["feel", image, *hand, "--at", "0,0,100"], cwd=tmp_path)
    assert "mm away from what plays" in text(away.stderr) and "mm off" in text(away.stdout)
    for options, code in ((["--hand-frame", 999], USAGE), (["--normal", "0,0,-1"], USAGE), (["--region", "palm"], USAGE)):
        assert_one_message(run(["feel", image, *hand[:2], *options], cwd=tmp_path), code)


def test_what_could_be_told_apart(tmp_path):
    image = compiled(tmp_path, "am", *POINT, "--am", "square:200")
    place = feel(tmp_path, image)["places"][0]
    over, hz = place["lines"][0]["over_db"], place["lines"][0]["hz"]
    assert place["strength_steps"] == [int(over / 2.98), int(over / 1.65)] and place["strength_steps"][0] > 2
    assert place["next_frequency_hz"] == pytest.approx([hz * 1.13, hz * 1.38])
    assert re.search(r"can be told apart: \d+ to \d+ strengths .*200 Hz from 226 to 276 Hz or more; a place to within 8.5 mm", text(succeed(["feel", image], cwd=tmp_path).stdout))
    small = compiled(tmp_path, "small", "--shape", "circle", "--diameter", 10, "--points", 100, "--speed", 3)
    notice(succeed(["feel", small], cwd=tmp_path).stderr)
    large = compiled(tmp_path, "large", "--shape", "circle", "--diameter", 40, "--points", 100, "--speed", 3)
    result = succeed(["feel", large, "--json"], cwd=tmp_path)
    assert "felt as one" not in text(result.stderr) and json.loads(result.stdout)["extent_mm"] == pytest.approx(40 * 2**0.5, rel=0.01)
    (tmp_path / "two.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,0,0,150\n5,0,0,150\n")
    steady = feel(tmp_path, tmp_path / "two.csv")["places"][0]
    assert "strength_steps" not in steady and steady["expected_to_be_felt"] is False


def test_pictures(tmp_path):
    image = compiled(tmp_path, "am", *POINT, "--am", "square:200")
    succeed(["feel", image, "-o", "feel.png"], cwd=tmp_path, timeout=300)
    assert (tmp_path / "feel.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    refuse(tmp_path, ["feel", image, "-o", "feel.csv"], USAGE, outputs=("feel.csv",))


@pytest.mark.parametrize(("arguments", "code"), [
    ([], USAGE), (["none.hex"], BAD_INPUT), (["am.hex", "--at", "1,2"], USAGE),
    (["am.hex", "--normal", "0,0,0"], USAGE), (["am.hex", "--grip", 0.5], USAGE), (["am.hex", "--array", "hoshi"], BAD_INPUT),
    (["am.hex", "--contact", 0], USAGE), (["am.hex", "--pulses", "x.csv", "--manifest", "am.json"], USAGE),
    (["--pulses", "am.json", "--manifest", "am.json"], BAD_INPUT), (["--focus", "0,0,900", "--pulses", "x.csv"], USAGE), (["--focus", "0,0,-9"], USAGE),
])  # fmt: skip
def test_what_is_refused(tmp_path, arguments, code):
    compiled(tmp_path, "am", *POINT, "--am", "square:200")
    assert_one_message(run(["feel", *arguments], cwd=tmp_path), code)
