# SPDX-License-Identifier: Apache-2.0
"""`haptogram feel`: forces and spectra beside numpy's sums over the image, what is said out of range, and what is refused."""
import json
import re
import subprocess
import sys

import numpy as np
import pytest
from messages import notice
from support import BAD_INPUT, PROGRAM, ROOT, USAGE, assert_one_message, read_json, refuse, run, succeed, text

POINT = ("--shape", "point", "--center", "0,0,150")
GRAM_FORCE = 9.80665  # mN


def compiled(folder, name, *args):
    succeed(["compile", *args, "-o", f"{name}.hex"], cwd=folder)
    return f"{name}.hex"


def feel(folder, *args):
    return json.loads(succeed(["feel", *args, "--json"], cwd=folder).stdout)


def radiation_pa(manifest, level_pa_m, focus_mm, points_mm):
    """At a level, on rigid skin that faces the array, of a focus with exact phases, at points; the free field of pistons, twice."""
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
    p = level_pa_m * 2 * j1(ka) / ka / r * np.exp(1j * k * (r0 - r) - alpha * r)
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
    level = found["level"]["used_pa_m"]
    # Whole arrays made 0.322 of what the data sheet says; a square wave of 20 V has 20·√2/π V rms at the carrier.
    assert level == pytest.approx(8.49 * 0.322 * 20 * 2**0.5 / np.pi / 10) and found["level"]["source_pa_m"] == 4.0
    steady = radiation_pa(manifest, level, (0, 0, 150), [(0, 0, 150)])[0]
    assert place["most_pa"] == pytest.approx(steady, rel=2e-3)  # rounding to ticks
    # A carrier that rises and falls with τ = 1/(πB) has the mean square ½·(1 − 2τ/T·…): by numbers.
    t = (np.arange(400) + 0.5) / 40000
    left = np.exp(-np.pi * manifest["transducer"]["bandwidth_hz"] * (t % 0.005))
    envelope = np.where(t < 0.005, 1 - left, left)
    assert place["mean_pa"] == pytest.approx(steady * (envelope**2).mean(), rel=5e-3)
    side = np.linspace(-10, 10, 81)
    x, y = np.meshgrid(side, side)
    disc = np.stack([x, y, np.full_like(x, 150)], axis=-1)[np.hypot(x, y) <= 10]
    force = radiation_pa(manifest, level, (0, 0, 150), disc).sum() * 0.25e-3**2
    spectrum = np.abs(np.fft.rfft(force * 1e3 * envelope**2)) * 2 / 400
    assert place["lines"][0]["hz"] == pytest.approx(100)
    assert place["lines"][0]["force_mn"] == pytest.approx(spectrum[1], rel=0.02)
    # Table III: 0.05903 to 0.06903 gf; ours takes the high end at 80 Hz and the low end at 180 Hz.
    share = np.log(180 / 100) / np.log(180 / 80)
    least = (0.05903 + 0.01 * share) * GRAM_FORCE * 4 / np.pi
    assert place["lines"][0]["least_mn"] == pytest.approx(least, rel=1e-6)
    assert place["lines"][0]["threshold_by"] == "tables"
    # Lines from 40 Hz on are felt by one channel, which sums their power; level and table are known to 1 and 0.68 dB.
    over = 10 * np.log10(sum((line["force_mn"] / line["least_mn"]) ** 2 for line in place["lines"]))
    verdict = place["verdict"]
    assert verdict["over_db"] == pytest.approx(over, abs=0.02) and verdict["answer"] == found["answer"] == "felt"
    known = np.hypot(1.0, 10 * np.log10(0.06903 / 0.05903))
    assert verdict["least_db"] == pytest.approx(verdict["over_db"] - known, abs=1e-3)
    bare = 20 * np.log10((0.06794 + 0.08392) / (0.05903 + 0.06903))
    assert verdict["most_db"] == pytest.approx(verdict["over_db"] + known + bare, abs=1e-3)
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
    assert found["places"][0]["lines"] == [] and found["places"][0]["verdict"]["answer"] == "not felt"
    assert "80 and 300 Hz" in found["places"][0]["no_magnitude"] and found["noise"]["relative_db"] is None
    assert "nothing alternates" in text(succeed(["feel", steady], cwd=tmp_path).stdout)
    finger = feel(tmp_path, compiled(tmp_path, "am", *POINT, "--am", "square:200"), "--region", "finger")
    assert "palms alone" in finger["places"][0]["no_magnitude"]


def last_line(folder, *args):
    return text(succeed(["compile", *args, "-o", "image.hex"], cwd=folder).stdout).strip().splitlines()[-1].split(maxsplit=1)


def test_the_verdict_is_one_wherever_it_is_said(tmp_path):
    """compile ends with it, a report has it, feel says it of the same image, for all three answers; and it follows the level."""
    point, circle = ("--shape", "point", "--am", "square:200"), ("--shape", "circle", "--diameter", 40, "--points", 30, "--rate", 70)
    for answer, shape in (("felt", point), ("perhaps", circle), ("not felt", ("--shape", "point"))):
        name, said = last_line(tmp_path, *shape)
        found = feel(tmp_path, "image.hex")
        verdict = f"{found['verdict']}; at 2.46 Pa·m an element"
        assert name == "hand" and found["answer"] == answer and verdict.startswith(answer)
        advice = {"felt": "", "perhaps": "; try --am square:200 --points 12 --rate 0.4", "not felt": "; try --am square:200"}
        assert said == verdict + advice[answer]
        assert json.loads(succeed(["compile", *shape, "-o", "image.hex", "--json"], cwd=tmp_path).stdout)["verdict"] == said
        succeed(["report", "image.hex", "--no-picture", "-o", "page.html"], cwd=tmp_path)
        assert f"by models: {verdict}." in (tmp_path / "page.html").read_text(encoding="utf-8")
    compiled(tmp_path, "point", *point)
    assert "felt: clear everywhere" in text(succeed(["feel", "point.hex"], cwd=tmp_path).stdout)
    at = {volts: feel(tmp_path, "point.hex", "--volts", volts)["places"][0]["verdict"] for volts in (12, 18, 20)}
    assert at[20] == feel(tmp_path, "point.hex")["places"][0]["verdict"]
    assert at[20]["over_db"] - at[12]["over_db"] == pytest.approx(40 * np.log10(20 / 12), abs=1e-6)  # force goes with the voltage's square
    weak = feel(tmp_path, "point.hex", "--level", 1.0)
    assert weak["level"]["used_pa_m"] == 1.0 and weak["answer"] == "not felt"
    assert_one_message(run(["feel", "point.hex", "--level", 1, "--volts", 12], cwd=tmp_path), USAGE)
    assert_one_message(run(["feel", "point.hex", "--volts", "12 volts"], cwd=tmp_path), USAGE)
    # A number in an array file that is no shipped one may be a data sheet's, unless it was measured.
    for measured, answer in (("", "perhaps"), ('measured = "by a balance"\n', "felt")):
        (tmp_path / "own.toml").write_text(f"[array]\nrows = 10\ncolumns = 10\npitch_mm = 10\n[transducer]\nsource_pa_m = 3\n{measured}")
        own = compiled(tmp_path, "own", *point, "--array", "own.toml")
        assert feel(tmp_path, own)["answer"] == answer
    assert_one_message(run(["feel", "own.hex", "--volts", 12], cwd=tmp_path), USAGE)


def test_a_focus_that_passes_is_felt_as_it_passes(tmp_path):
    """Under a modulation, 50 mm/s slow: nearly as one that rests, and not as its mean over a round."""
    (tmp_path / "way.csv").write_text("time_ms,x_mm,y_mm,z_mm\n" + "".join(f"{i * 20},{i - 20},0,130\n" for i in range(41)))
    slow = compiled(tmp_path, "slow", "--path", "way.csv", "--am", "square:200")
    passing = feel(tmp_path, slow, "--at", "0,0,130")["places"][0]["verdict"]
    resting = feel(tmp_path, compiled(tmp_path, "rest", "--shape", "point", "--am", "square:200"))["places"][0]["verdict"]
    assert resting["over_db"] - 3 < passing["over_db"] < resting["over_db"]


def test_every_built_in_shape_is_felt_or_says_how(tmp_path):
    """At its defaults, or as the last line of compile says."""
    kinds = re.search(r"Built-in shape.*?: (.*?)\n\s*--", text(succeed(["compile", "--help"]).stdout), re.DOTALL)[1].replace("\n", " ")
    kinds = [kind for kind in re.split(r"[,\s]+", kinds) if kind]
    assert len(kinds) == 13
    answers = {}
    for kind in kinds:
        _, said = last_line(tmp_path, "--shape", kind)
        answers[kind] = [said.split(":")[0]]
        if "; try " in said:
            answers[kind].append(last_line(tmp_path, "--shape", kind, *said.split("; try ")[1].split())[1].split(":")[0])
    assert {kind: said for kind, said in answers.items() if said[-1] != "felt"} == {}


def test_the_designs_of_the_gallery(tmp_path):
    """All are felt, beyond what is not known, but two; and compile, feel and report say the same of each."""
    not_surely = {}
    for project in sorted((ROOT / "extras/studio/gallery").glob("*/project.toml")):
        _, said = last_line(tmp_path, project)
        verdict = said.split("; try ")[0]
        assert verdict.startswith(feel(tmp_path, "image.hex")["verdict"])
        succeed(["report", "image.hex", "--no-picture", "-o", "page.html"], cwd=tmp_path)
        assert f"by models: {verdict}." in (tmp_path / "page.html").read_text(encoding="utf-8")
        if not verdict.startswith("felt: clear everywhere"):
            not_surely[project.parent.name] = verdict.split(":")[0]
    assert not_surely == {"bloom": "not felt", "touch": "perhaps"}


def test_what_people_felt():
    """The table of the page is what its command prints, and no verdict in it contradicts people but those that it names."""
    done = subprocess.run([sys.executable, ROOT / "extras/feel/evidence.py", PROGRAM, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


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
    assert same["verdict"] == pytest.approx(finger["verdict"], rel=1e-6)
    away = succeed(["feel", image, *hand, "--at", "0,0,100"], cwd=tmp_path)
    assert "mm away from what plays" in text(away.stderr) and "mm off" in text(away.stdout)
    for options, code in ((["--hand-frame", 999], USAGE), (["--normal", "0,0,-1"], USAGE), (["--region", "palm"], USAGE)):
        assert_one_message(run(["feel", image, *hand[:2], *options], cwd=tmp_path), code)


def test_what_could_be_told_apart(tmp_path):
    image = compiled(tmp_path, "am", *POINT, "--am", "square:200")
    place = feel(tmp_path, image)["places"][0]
    over, hz = place["verdict"]["over_db"], place["lines"][0]["hz"]
    assert place["strength_steps"] == [int(over / 2.98), int(over / 1.65)] and place["strength_steps"][1] > 1
    assert place["next_frequency_hz"] == pytest.approx([hz * 1.13, hz * 1.38])
    assert re.search(r"can be told apart: \d+ to \d+ strengths .*200 Hz from 226 to 276 Hz or more; a place to within 8.5 mm", text(succeed(["feel", image], cwd=tmp_path).stdout))
    small = compiled(tmp_path, "small", "--shape", "circle", "--diameter", 10, "--points", 100, "--speed", 3)
    notice(succeed(["feel", small], cwd=tmp_path).stderr)
    large = compiled(tmp_path, "large", "--shape", "circle", "--diameter", 40, "--points", 100, "--speed", 3)
    result = succeed(["feel", large, "--json"], cwd=tmp_path)
    assert "felt as one" not in text(result.stderr) and json.loads(result.stdout)["extent_mm"] == pytest.approx(40 * 2**0.5, rel=0.01)
    (tmp_path / "two.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,0,0,150\n5,0,0,150\n")
    steady = feel(tmp_path, tmp_path / "two.csv")["places"][0]
    assert "strength_steps" not in steady and steady["verdict"]["answer"] == "not felt"


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
