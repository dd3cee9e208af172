# SPDX-License-Identifier: Apache-2.0
"""`haptogram solve`: several foci at the same time; pressures are checked by sums in numpy."""
import json

import numpy as np
import pytest
from support import BAD_INPUT, USAGE, refuse, run, succeed, text

POINTS = "[array]\nrows = 10\ncolumns = 10\npitch_mm = 10.0\n[transducer]\nradius_mm = 0.1\nsource_pa_m = 4.0\n"
FOCI = [(-30, 5, 140), (25, -20, 150), (10, 30, 130), (-5, -35, 145)]
SOLVERS = ["gauss-newton", "weighted-gs", "gs", "gs-pat", "superposition", "distance-weighted", "inverse-transform"]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "points.toml").write_text(POINTS)
    (tmp_path / "foci.csv").write_text("# a set\n" + "".join(f"{x},{y},{z}\n" for x, y, z in FOCI))
    return tmp_path


def solve(folder, *arguments):
    return json.loads(text(succeed(["solve", *arguments, "--json"], cwd=folder).stdout))


def pressures(drives, foci_mm, source_pa_m=4.0, speed=343.2):
    """|p| of 10 × 10 point sources, 10 mm apart."""
    grid = (np.arange(10) - 4.5) * 10.0
    elements = np.array([(x, y, 0.0) for y in grid for x in grid]) * 1e-3
    ranges = np.linalg.norm(np.array(foci_mm)[:, None] * 1e-3 - elements[None], axis=2)
    return np.abs((drives * np.exp(-2j * np.pi * 40e3 / speed * ranges) / ranges).sum(axis=1)) * source_pa_m


def drives_of(step):
    return np.array([d["amplitude"] * np.exp(1j * d["phase_rad"]) for d in step["drives"]])


def test_pressures_of_drives_and_of_ticks_are_what_numpy_sums(folder):
    found = solve(folder, "foci.csv", "--array", "./points.toml")
    (step,) = found["steps"]
    assert [tuple(f["position_mm"]) for f in step["foci"]] == [pytest.approx(f) for f in FOCI]
    drives = drives_of(step)
    assert np.allclose(np.abs(drives), 1.0)
    exact = pressures(drives, FOCI)
    assert step["quality"]["exact"]["pressure_pa"] == pytest.approx(exact, rel=1e-3)  # pistons of 0.1 mm are all but points
    record = step["record"]
    ticks = np.array(record["timings"][:100])
    turns = np.angle(drives * np.exp(2j * np.pi * ticks / record["cycle_length"])) / (2 * np.pi)
    assert np.abs(turns).max() * record["cycle_length"] <= 0.5 + 1e-9  # the nearest tick
    quantised = pressures(np.exp(-2j * np.pi * ticks / record["cycle_length"]), FOCI)
    assert step["quality"]["quantised"]["pressure_pa"] == pytest.approx(quantised, rel=1e-3)
    alone = np.array([pressures(np.exp(2j * np.pi * 40e3 / 343.2 * distances), [focus])[0] for focus, distances in zip(FOCI, ranges_to(FOCI))])
    shares = quantised / alone
    assert step["quality"]["quantised"]["spread"] == pytest.approx(shares.std() / shares.mean(), abs=2e-4)
    assert step["quality"]["quantised"]["least_over_mean"] == pytest.approx(shares.min() / shares.mean(), abs=5e-4)
    assert step["quality"]["quantised"]["efficiency"] == pytest.approx(np.sqrt((shares**2).sum()), rel=1e-3)
    assert step["quality"]["exact"]["spread"] < 0.002 and step["quality"]["quantised"]["spread"] < 0.005


def ranges_to(foci_mm):
    grid = (np.arange(10) - 4.5) * 10.0
    elements = np.array([(x, y, 0.0) for y in grid for x in grid])
    return np.linalg.norm(np.array(foci_mm)[:, None] - elements[None], axis=2) * 1e-3


def test_every_solver_and_the_default_is_the_most_even(folder):
    spreads = {name: solve(folder, "foci.csv", "--solver", name)["steps"][0]["quality"]["exact"]["spread"] for name in SOLVERS}
    assert spreads["gauss-newton"] < 1e-3
    assert all(spreads[name] > 10 * spreads["gauss-newton"] for name in SOLVERS[2:]), spreads
    assert solve(folder, "foci.csv") == solve(folder, "foci.csv", "--solver", "gauss-newton")
    with_amplitudes = solve(folder, "foci.csv", "--amplitudes")["steps"][0]
    sizes = [d["amplitude"] for d in with_amplitudes["drives"]]
    assert max(sizes) == pytest.approx(1.0) and min(sizes) < 0.9 and with_amplitudes["quality"]["exact"]["spread"] < 1e-3


def test_amplitudes_by_level(folder):
    foci = ["--focus", "-25,0,120,1", "--focus", "25,0,160,0.5", "--array", "./points.toml"]
    one = solve(folder, *foci, "--level", "pressure")["steps"][0]
    strong, weak = pressures(drives_of(one), [(-25, 0, 120), (25, 0, 160)])
    assert weak / strong == pytest.approx(0.5, abs=0.002)
    other = solve(folder, *foci)["steps"][0]
    strong, weak = pressures(drives_of(other), [(-25, 0, 120), (25, 0, 160)])
    assert weak / strong < 0.45  # farther away, the most that can be made is less


def test_one_focus_has_the_ticks_that_compile_gives_it(folder):
    (step,) = solve(folder, "--focus", "12,-7,125")["steps"]
    (folder / "one.xyz").write_text("12 -7 125\n")
    succeed(["compile", "one.xyz", "-o", "one.hex"], cwd=folder)
    compiled = json.loads(text(succeed(["inspect", "one.hex", "--json"], cwd=folder).stdout))["records"][0]["timings"]
    mine, cycle = step["record"]["timings"], step["record"]["cycle_length"]
    apart = (np.array(mine[:100]) - np.array(compiled[:100])) % cycle
    common = np.bincount(apart).argmax()  # all elements together may be earlier or later
    assert (np.abs((apart - common + cycle // 2) % cycle - cycle // 2) <= 1).all()
    assert step["quality"]["exact"]["efficiency"] == pytest.approx(1.0)


def test_sets_of_foci_and_the_table(folder):
    lines = []
    for step in range(5):
        lines += [f"{x + 0.2 * step},{y},{z}, 0.8 # moves" for x, y, z in FOCI] + ["", ""]
    (folder / "moving.csv").write_text("\r\n".join(lines))
    found = solve(folder, "moving.csv", "--follow", "--rounds", "1")
    assert len(found["steps"]) == 5 and all(len(s["foci"]) == 4 for s in found["steps"])
    assert all(s["quality"]["exact"]["spread"] < 0.002 for s in found["steps"])
    assert all(abs(d["amplitude"] - 0.8) < 1e-9 for d in found["steps"][4]["drives"])
    table = text(succeed(["solve", "moving.csv"], cwd=folder).stdout)
    assert table.count("efficiency") == 10 and "set 5, 4 foci by gauss-newton" in table
    piped = run(["solve", "-", "-o", "-"], cwd=folder, stdin=open(folder / "foci.csv", "rb"))
    header, *rows = text(piped.stdout).splitlines()
    assert header == "step,element,amplitude,phase_rad,tick" and len(rows) == 100


def test_an_image_plays_the_sets(folder):
    (folder / "two.csv").write_text("-20,0,130\n20,0,130\n\n0,-25,140\n0,25,140\n15,0,150,0.5\n")
    succeed(["solve", "two.csv", "--solver", "weighted-gs", "--rate", "100", "-o", "two.hex"], cwd=folder)
    asked = [step["record"] for step in solve(folder, "two.csv", "--solver", "weighted-gs")["steps"]]
    image = json.loads(text(succeed(["inspect", "two.hex", "--json"], cwd=folder).stdout))
    assert [r["timings"] for r in image["records"]] == [r["timings"] for r in asked]
    assert [r["pulse_length"] for r in image["records"]] == [r["pulse_length"] for r in asked]
    assert [e["dwell_cycles"] for e in image["sequence"]] == [200, 200]
    manifest = json.loads((folder / "two.json").read_text())
    assert manifest["solver"] == "weighted-gs" and len(manifest["records"][1]["foci"]) == 3
    succeed(["field", "two.hex", "--plane", "xy@z=130", "--step", 5, "-o", "two.csv.csv"], cwd=folder)
    refuse(folder, ["solve", "two.csv", "--follow", "-o", "x.hex"], USAGE, outputs=("x.hex", "x.json"))
    refuse(folder, ["solve", "two.csv", "--rate", "1e6", "-o", "x.hex"], BAD_INPUT, outputs=("x.hex", "x.json"))


def test_files(folder):
    for name in ("drives.csv", "all.json", "picture.png"):
        succeed(["solve", "foci.csv", "-o", name], cwd=folder)
    rows = np.loadtxt(folder / "drives.csv", delimiter=",", skiprows=1)
    (step,) = json.loads((folder / "all.json").read_text())["steps"]
    assert rows[:, 4].tolist() == step["record"]["timings"][:100]
    assert np.allclose(rows[:, 2] * np.exp(1j * rows[:, 3]), drives_of(step))
    assert (folder / "picture.png").read_bytes().startswith(b"\x89PNG")
    before = (folder / "all.json").read_bytes()
    succeed(["solve", "foci.csv", "-o", "all.json"], cwd=folder)
    assert (folder / "all.json").read_bytes() == before


@pytest.mark.parametrize(
    "arguments, code",
    [
        ([], USAGE),
        (["--focus", "1,2"], USAGE),
        (["--focus", "0,0,nan"], USAGE),
        (["--focus", "0,0,130,2"], BAD_INPUT),
        (["--focus", "0,0,130", "--focus", "0,0,130"], BAD_INPUT),
        (["--focus", "0,0,130", "--focus", "200,0,20"], BAD_INPUT),
        (["--focus", "5,5,0"], BAD_INPUT),
        (["--focus", "0,0,130,0"], USAGE),
        (["--focus", "0,0,130", "--solver", "magic"], USAGE),
        (["--focus", "0,0,130", "-o", "x.doc"], USAGE),
        (["missing.csv"], BAD_INPUT),
        (["bad.csv"], BAD_INPUT),
        (["empty.csv"], BAD_INPUT),
        (["sets.csv"], BAD_INPUT),
        (["bad.csv", "--focus", "0,0,130"], USAGE),
        (["--focus", "0,0,130", "--rate", 20], USAGE),
        (["--focus", "0,0,130", "--solver", "superposition", "--rounds", 5], USAGE),
    ],
)
def test_what_cannot_be_solved_is_told(folder, arguments, code):
    (folder / "bad.csv").write_text("0,0,130\n0,0\n")
    (folder / "empty.csv").write_text("# nothing\n\n")
    (folder / "sets.csv").write_text("0,0,130\n\n0,0,130\n0,0,130\n")
    refuse(folder, ["solve", *arguments], code, outputs=("x.doc",))
