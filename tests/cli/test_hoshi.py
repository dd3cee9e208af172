# SPDX-License-Identifier: Apache-2.0
"""Hoshi's device from the command line: --quantise hoshi, its movements and its interaction demo, worked out again with numpy."""

import json

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, Image, read_json, refuse, succeed, text

DEVICE = ["--array", "hoshi", "--quantise", "hoshi"]
CARRIER_HZ = 40_000
GRID = (np.arange(18) - 8.5) * 10.0
ELEMENTS = np.array([(x, y, 0.0) for y in GRID for x in GRID])


def ranges_mm(focus):
    return np.linalg.norm(ELEMENTS - focus, axis=1)


def played(path):
    """Where the focus is in each carrier period; NaN in silence."""
    where = [(step["foci"][0]["position_mm"] if step["foci"] else [np.nan] * 3, step["periods"]) for step in path["steps"]]
    return np.concatenate([np.tile(p, (periods, 1)) for p, periods in where])


def test_records_lie_on_sixteen_segments(tmp_path):
    succeed(["compile", "--shape", "point", "--center", "30,-10,200", *DEVICE, "-o", "p.hex"], cwd=tmp_path)
    manifest = read_json(tmp_path / "p.json")
    assert manifest["quantise"] == "hoshi" and manifest["board"]["clock_hz"] == 25_600_000
    (record,) = Image(tmp_path / "p.hex").records()
    assert record["cycle_length"] * record["prescaler"] == 640
    segments = np.array(record["timings"]) * 16 / record["cycle_length"]
    assert np.all(segments % 1 == 0) and np.all(segments < 16) and record["pulse_length"] * 2 == record["cycle_length"]
    # All waves arrive together, half a segment off at most, and half a tick for the rounding before.
    turns = segments / 16 + ranges_mm((30, -10, 200)) / 8.5
    middle = np.angle(np.exp(2j * np.pi * turns).mean()) / (2 * np.pi)
    off = (turns - middle + 0.5) % 1 - 0.5
    assert np.abs(off).max() < 0.5 / 16 + 0.5 / record["cycle_length"] + 0.01


def test_amplitudes_are_whole_segments(tmp_path):
    common = ["compile", "--shape", "point", "--center", "0,0,200", "--am", "triangle:50", "--array", "hoshi"]
    succeed([*common, "--quantise", "hoshi", "-o", "a.hex"], cwd=tmp_path)
    records = Image(tmp_path / "a.hex").records()
    lengths = sorted(16 * r["pulse_length"] // r["cycle_length"] for r in records)
    assert lengths == list(range(1, 9)) and all(16 * r["pulse_length"] % r["cycle_length"] == 0 for r in records)
    succeed([*common, "-o", "b.hex"], cwd=tmp_path)
    assert len(Image(tmp_path / "b.hex").records()) > 8
    # At 50 MHz a segment is 15.625 ticks: the nearest tick stands for a border.
    succeed(["compile", "--shape", "point", "--quantise", "hoshi", "-o", "c.hex"], cwd=tmp_path)
    (record,) = Image(tmp_path / "c.hex").records()
    borders = np.floor(np.arange(16) * record["cycle_length"] / 16 + 0.5)
    assert set(record["timings"]) <= set(borders.astype(int))


def test_a_project_names_the_device(tmp_path):
    (tmp_path / "p.toml").write_text('format = "haptogram-project-1"\narray = "hoshi"\nquantise = "hoshi"\n[[shape]]\nkind = "point"\n')
    succeed(["compile", "p.toml", "-o", "p.hex"], cwd=tmp_path)
    succeed(["compile", "--shape", "point", *DEVICE, "-o", "q.hex"], cwd=tmp_path)
    assert (tmp_path / "p.hex").read_bytes() == (tmp_path / "q.hex").read_bytes()
    succeed(["compile", "--shape", "point", "--array", "hoshi", "-o", "r.hex"], cwd=tmp_path)
    assert read_json(tmp_path / "q.json")["inputs_sha256"] != read_json(tmp_path / "r.json")["inputs_sha256"]
    (tmp_path / "p.toml").write_text('format = "haptogram-project-1"\nquantise = "16"\n[[shape]]\nkind = "point"\n')
    refuse(tmp_path, ["compile", "p.toml"], BAD_INPUT)
    refuse(tmp_path, ["compile", "--shape", "point", "--quantise", "16"], USAGE)


def test_solve_gives_every_channel_a_pulse_of_its_own(tmp_path):
    (tmp_path / "points.toml").write_text(
        "[array]\nrows = 18\ncolumns = 18\npitch_mm = 10.0\n[medium]\nspeed_m_s = 340.0\n[transducer]\nfile = \"point\"\n[board]\nconfiguration = \"hoshi-324\"\n"
    )
    arguments = ["solve", "--focus=-20,0,200", "--focus=20,0,200", "--solver", "inverse-transform", "--amplitudes", "--array", "./points.toml", "--json"]
    found = json.loads(text(succeed([*arguments, "--quantise", "hoshi"], cwd=tmp_path).stdout))
    assert found["quantise"] == "hoshi"
    (step,) = found["steps"]
    drives = np.array([d["amplitude"] * np.exp(1j * d["phase_rad"]) for d in step["drives"]])
    lengths = np.round(16 / np.pi * np.arcsin(np.minimum(1, np.abs(drives))))
    assert set(lengths) >= {1, 4, 8}
    # The pulse's middle, in segments after that of a pulse of full strength and phase 0.
    start = np.floor(-np.angle(drives) / (2 * np.pi) * 16 + 4 - lengths / 2 + 0.5)
    made = np.sin(np.pi * lengths / 16) * np.exp(-2j * np.pi * (start + lengths / 2 - 4) / 16)
    for focus, pressure in zip(((-20, 0, 200), (20, 0, 200)), step["quality"]["quantised"]["pressure_pa"]):
        r = ranges_mm(focus)
        assert pressure == pytest.approx(np.abs((made * np.exp(-2j * np.pi * r / 8.5) / (r * 1e-3)).sum()), rel=1e-3)
    assert step["quality"]["quantised"]["pressure_pa"] != pytest.approx(step["quality"]["exact"]["pressure_pa"], rel=1e-4)


def test_the_field_of_sixteen_phases(tmp_path):
    (tmp_path / "points.toml").write_text(
        "[array]\nrows = 18\ncolumns = 18\npitch_mm = 10.0\n[medium]\nspeed_m_s = 340.0\n[transducer]\nfile = \"point\"\n[board]\nconfiguration = \"hoshi-324\"\n"
    )
    line = ["field", "--focus", "0,0,200", "--array", "./points.toml", "--line", "x@y=0,z=200", "--extent", "10", "--step", "10", "--quantity", "rms"]

    def middle(*more):
        rows = text(succeed([*line, *more], cwd=tmp_path).stdout).splitlines()[1:]
        return {float(r.split(",")[0]): float(r.split(",")[1]) for r in rows}[0.0]

    r = ranges_mm((0, 0, 200))
    phase = np.round(r / 8.5 * 16) / 16 - r / 8.5
    kept = np.abs((np.exp(2j * np.pi * phase) / r).sum()) / (1 / r).sum()
    assert middle("--quantise", "hoshi") / middle() == pytest.approx(kept, rel=1e-4) and kept < 0.999
    refuse(tmp_path, ["field", "x.hex", "--quantise", "hoshi"], USAGE, outputs=())


@pytest.mark.parametrize("movement", ["line", "circle", "spiral", "random"])
def test_movements_on_the_device(movement, tmp_path):
    arguments = [movement, "--grid", "--size", 60, "--array", "hoshi", "-o", "path.json", *(["--seconds", 0.5] if movement == "random" else [])]
    report = json.loads(text(succeed(["movement", *arguments, "--json"], cwd=tmp_path).stdout))
    path = read_json(tmp_path / "path.json")
    where = played(path)
    assert len(where) / CARRIER_HZ == pytest.approx(report["seconds"])
    number = where[:, :2] / 10 - 0.5
    assert np.allclose(number, np.round(number), atol=1e-6)
    assert np.abs(where[:, :2]).max() <= 35 + 1e-9 and np.allclose(where[:, 2], 200)
    samples = np.repeat(path["modulation"]["samples"], path["modulation"]["periods_a_sample"])
    assert len(samples) == 200 and samples.mean() == 0.5 and len(where) % 200 == 0  # 200 Hz, half of the time
    assert report["places"] == len(np.unique(np.round(where, 6), axis=0))


def test_a_movement_is_compiled(tmp_path):
    succeed(["movement", "line", "--grid", "--speed", 0.1, "--array", "hoshi", "-o", "path.json"], cwd=tmp_path)
    succeed(["compile", "--path", "path.json", *DEVICE, "-o", "line.hex"], cwd=tmp_path)
    records = Image(tmp_path / "line.hex").records()
    assert len(records) == len(np.unique(played(read_json(tmp_path / "path.json")), axis=0))
    refuse(tmp_path, ["movement", "square", "-o", "x.json"], USAGE, outputs=("x.json",))
    refuse(tmp_path, ["movement", "line", "--size", 900, "--array", "hoshi", "-o", "x.json"], BAD_INPUT, outputs=("x.json",))


@pytest.mark.parametrize("content", ["ball", "rain", "creature"])
def test_what_meets_a_hand(content, tmp_path):
    arguments = [content, "--hand", "synthetic:slide:220", "--array", "hoshi", "--grid", "-o", "path.json", "--scene", "scene.jsonl"]
    report = json.loads(text(succeed(["interact", *arguments, "--json"], cwd=tmp_path).stdout))
    where = played(read_json(tmp_path / "path.json"))
    felt = where[~np.isnan(where[:, 0])]
    assert len(felt) / CARRIER_HZ == pytest.approx(report["felt_s"], abs=1e-6) and report["touches"] >= 1
    assert len(where) / CARRIER_HZ == pytest.approx(2.99, abs=2e-3)  # one slide, to its last frame
    assert np.all(np.abs(felt[:, 2] - 220) <= 10)  # the height of the palm, on the grid, and the noise of the cameras
    scene = [json.loads(line) for line in (tmp_path / "scene.jsonl").read_text().splitlines()]
    assert len(scene) == 299
    for moment in scene:
        if "focus_mm" in moment:  # on the palm
            assert np.hypot(*(np.array(moment["focus_mm"]) - moment["palm_mm"])[:2]) <= 40 + 5 * np.sqrt(2)
    moved = np.array([m["palm_mm"] for m in scene])
    assert np.ptp(moved[:, 0]) == pytest.approx(60, abs=4)


def test_a_recorded_marker(tmp_path):
    rows = "".join(f"{10 * i},0,45,{200 - i / 10}\n" for i in range(101))
    (tmp_path / "marker.csv").write_text("time_ms,x_mm,y_mm,z_mm\n" + rows)
    report = json.loads(text(succeed(["interact", "creature", "--hand", "marker.csv", "--array", "hoshi", "-o", "p.json", "--json"], cwd=tmp_path).stdout))
    where = played(read_json(tmp_path / "p.json"))
    assert report["samples"] == 101 and where[:, 2] == pytest.approx(np.linspace(200, 190, len(where)), abs=0.6)
    (tmp_path / "marker.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,0,45,100\n90,0,45,100\n180,0,45,100\n")
    refuse(tmp_path, ["interact", "creature", "--hand", "marker.csv", "-o", "q.json"], BAD_INPUT, outputs=("q.json",))
    refuse(tmp_path, ["interact", "snow", "-o", "q.json"], USAGE, outputs=("q.json",))
