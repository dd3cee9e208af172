# SPDX-License-Identifier: Apache-2.0
"""`haptogram analyze`: each point of an image beside closed forms, its warnings, its safety note, and an array's workspace."""
import json

import numpy as np
import pytest
from support import BAD_INPUT, ROOT, USAGE, assert_one_message, read_json, refuse, run, succeed


@pytest.fixture(scope="module")
def centre(tmp_path_factory):
    folder = tmp_path_factory.mktemp("centre")
    succeed(["compile", "--shape", "point", "--center", "0,0,130", "--rate", 400, "-o", "image.hex"], cwd=folder)
    return folder


def analyzed(folder, *arguments):
    return json.loads(succeed(["analyze", "image.hex", "--json", *arguments], cwd=folder).stdout)


@pytest.mark.check
def test_a_focus_on_the_axis(centre):
    found = analyzed(centre)
    (point,) = found["points"]
    manifest = read_json(centre / "image.json")
    elements = np.array(manifest["array"]["elements_mm"])
    distance = np.linalg.norm(elements - [0, 0, 130], axis=1)
    assert point["flight_spread_us"] == pytest.approx((distance.max() - distance.min()) / manifest["medium"]["speed_m_s"] * 1e3, rel=1e-4)
    assert point["width_mm"] == pytest.approx(10.8, abs=0.1)  # pistons of 4.5 mm
    # |p| of the same number of points, less their directivity, which is 0.9 or more here; and P = 2 p_rms² / ρc² of it.
    most = manifest["transducer"]["source_pa_m"] * (1e3 / distance).sum()
    assert 0.85 * most < point["pressure_pa"] < most
    medium = manifest["medium"]
    assert point["radiation_pressure_pa"] == pytest.approx(point["pressure_pa"] ** 2 / (medium["density_kg_m3"] * medium["speed_m_s"] ** 2), rel=1e-3)
    assert 0 < point["side_lobe"] < 0.1 and 40 < point["depth_mm"] < 90
    # A disc of 20 mm holds more than half of the peak over the half width, and less than the peak over two of them.
    across = np.pi / 4 * point["width_mm"] ** 2 * 1e-3
    assert 0.5 < point["force_mn"] / (point["radiation_pressure_pa"] * across) < 2
    # What warms skin is the peak: 2·I/c of 100 W/cm², of which tissue gets a thousandth.
    assert point["heat_limit_mn"] == pytest.approx(point["force_mn"] * 2e6 / medium["speed_m_s"] / point["radiation_pressure_pa"], rel=1e-3)
    assert point["impulse_mn_ms"] == pytest.approx(point["force_mn"] * point["dwell_cycles"] / 40, rel=1e-3)
    assert found["warnings"] == [] and point["too_weak"] is False


def test_a_map_says_its_level(tmp_path):
    assert b"nominal level: 4 Pa" in succeed(["analyze", "--array", "tile-10x10", "--step", "50", "-o", "map.csv"], cwd=tmp_path).stderr


def test_warnings(centre, small):
    assert "too weak" in analyzed(centre, "--least-force", 1000)["warnings"][0]
    found = json.loads(succeed(["analyze", "image.hex", "--json"], cwd=small.folder).stdout)  # 8 points in 2 ms: 10 cycles each
    assert any("left before 90 %" in warning for warning in found["warnings"])
    table = succeed(["analyze", "image.hex"], cwd=small.folder).stdout.decode()
    assert len(table.splitlines()) == 1 + 8 + len(found["warnings"]) + 8 and "no certification" in table
    impulse = max(point["impulse_mn_ms"] for point in found["points"])
    assert f"{impulse:.4g} mN·ms at most (Hoshi 2010, eq. 8)" in table and "eq. 8" in found["source_of_impulse"]


def test_loudness_of_one_focus(centre):
    safety = analyzed(centre)["safety"]
    field = succeed(["field", "image.hex", "--line", "z@x=0,y=0", "--z", "10:400", "--quantity", "spl"], cwd=centre).stdout.decode().splitlines()[1:]
    level = {float(z): float(db) for z, db in (row.split(",") for row in field)}
    assert safety["highest_on_axis_db_spl"] == pytest.approx(max(level.values()), abs=0.1)
    assert safety["at_300_mm_db_spl"] == pytest.approx(level[300.0], abs=0.1)
    assert safety["recommended_for_ears_db_spl"] == 110.0 and "certification" in safety["note"]


def test_the_workspace_of_the_tile(tmp_path):
    succeed(["analyze", "--array", "tile-10x10", "-o", "w.csv"], cwd=tmp_path)
    rows = np.loadtxt(tmp_path / "w.csv", delimiter=",", skiprows=1)
    assert np.isnan(rows[:, 2]).any()
    best = rows[np.nanargmax(rows[:, 2])]
    assert abs(best[0]) <= 2 and 36 <= best[1] <= 50  # the piston model peaks near 4 to 5 cm; the paper measured 14
    succeed(["analyze", "--array", "tile-10x10", "--step", 10, "-o", "w.png"], cwd=tmp_path)
    assert (tmp_path / "w.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("arguments", [[], ["image.hex", "--plane", "xy@z=100"],
                                                   ["image.hex", "-o", "x.csv"], ["image.hex", "--least-force", "0"]])  # fmt: skip
def test_what_makes_no_sense(arguments, centre):
    assert_one_message(run(["analyze", *arguments], cwd=centre), USAGE)


def test_forces_are_over_one_area_and_say_what_they_rest_on(centre, tmp_path):
    """The force of analyze is that of feel, on the same disc, at another level; and a measured force makes the level that gives it back."""
    found = json.loads(succeed(["analyze", "image.hex", "--json"], cwd=centre).stdout)
    felt = json.loads(succeed(["feel", "image.hex", "--json"], cwd=centre).stdout)
    assert found["contact_mm"] == felt["contact_mm"] == 20
    # One is at the nominal level, the other at the expected one.
    excess = (found["level"]["source_pa_m"] / felt["level"]["used_pa_m"]) ** 2
    assert found["points"][0]["force_mn"] == pytest.approx(felt["places"][0]["mean_mn"] * excess, rel=1e-3)
    assert not found["level"]["calibrated"] and f"{excess:.1f} times less force" in found["level"]["note"]
    assert found["level"]["expected_pa_m"] == felt["level"]["used_pa_m"]
    at = ["--focus", "0,0,150"]
    keys = succeed(["analyze", *at, "--measured-mn", "2.5"], cwd=tmp_path).stdout.decode()
    shipped = (ROOT / "host/arrays/tile-10x10.toml").read_text()
    (tmp_path / "mine.toml").write_text(shipped[: shipped.index("[transducer]")] + keys)
    mine = json.loads(succeed(["analyze", *at, "--array", "mine.toml", "--json"], cwd=tmp_path).stdout)
    assert mine["points"][0]["force_mn"] == pytest.approx(2.5, rel=1e-3)
    assert mine["level"]["calibrated"] and "2.5 mN on a disc of 20 mm" in mine["level"]["note"]
    succeed(["compile", "--shape", "point", "--array", "mine.toml", "-o", "mine.hex"], cwd=tmp_path)
    assert json.loads(succeed(["feel", "mine.hex", "--json"], cwd=tmp_path).stdout)["level"]["calibrated"]
    (tmp_path / "half.toml").write_text(shipped[: shipped.index("[transducer]")] + '[transducer]\nmeasured = "x"\n')
    refuse(tmp_path, ["analyze", *at, "--array", "half.toml"], BAD_INPUT, outputs=())


def test_a_manifest_that_is_not_there(small):
    small.manifest.unlink()
    refuse(small.folder, ["analyze", "image.hex"], BAD_INPUT, outputs=())


@pytest.mark.parametrize("height", [400, 3000, 999_999])
def test_a_focus_that_the_array_cannot_make_is_said_at_once(height, tmp_path):
    found = json.loads(succeed(["analyze", "--focus", f"0,0,{height}", "--json"], cwd=tmp_path, timeout=300).stdout)
    assert any(warning.startswith("1 of 1 points are no foci: beyond") for warning in found["warnings"])
    # A beam that spreads: as wide as a circle of the array's area would make it, to a factor of 2.
    assert found["points"][0]["width_mm"] == pytest.approx(height * 8.6 / 100, rel=0.5)


def test_a_focus_in_the_near_field_is_one(tmp_path):
    found = json.loads(succeed(["analyze", "--focus", "0,0,200", "--json"], cwd=tmp_path).stdout)
    assert not any("no foci" in warning for warning in found["warnings"])
