# SPDX-License-Identifier: Apache-2.0
"""The package as users import it: `import haptogram`. Its numbers are the program's, its lengths are metres, its results are arrays with coordinates."""
import ast
import contextlib
import csv
import json
import pickle
import pydoc
import subprocess
import sys

import haptogram_native as native
import matplotlib
import numpy as np
import pytest
from messages import refusal
from pistons import PROGRAM, ROOT

matplotlib.use("Agg")
import haptogram  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from haptogram import HaptogramError  # noqa: E402

MADE_ONCE = ("ring",)
RING = ("--shape", "circle", "--diameter", "40", "--points", "12", "--rate", "50")


@pytest.fixture(autouse=True)
def by_the_program(monkeypatch):
    monkeypatch.setenv("HAPTOGRAM_PROGRAM", str(PROGRAM))
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def ring():
    return haptogram.compile(shape="circle", diameter_m=0.04, points=12, rate_hz=50)


@pytest.fixture
def theirs(program):
    """The program's image of the ring, ring.hex in its folder."""
    program("compile", *RING, "-o", "ring.hex")
    return program


@contextlib.contextmanager
def refused():
    """A HaptogramError whose message is one short line, with a place."""
    with refusal(HaptogramError) as caught:
        yield caught
    said = str(caught.value)
    assert "\n" not in said and len(said) < 400 and said.startswith(caught.value.where + ": "), said


def same(compiled, folder, name, *, without="nothing"):
    """Byte by byte what the program wrote, without one member of the manifest."""
    ours, theirs = json.loads(compiled.manifest), json.loads((folder / f"{name}.json").read_text())
    assert compiled.manifest == (folder / f"{name}.json").read_text() or without in theirs
    return compiled.hex == (folder / f"{name}.hex").read_bytes() and {**ours, without: ""} == {**theirs, without: ""}


OTHER_TEXT = "inputs_sha256"  # of a file with the same numbers


def test_a_shape_is_compiled_as_by_the_program(ring, theirs, tmp_path):
    assert same(ring, tmp_path, "ring")
    assert same(haptogram.compile(shape={"kind": "circle", "diameter_m": 0.04}, points=12, rate_hz=50), tmp_path, "ring")
    assert np.asarray(ring) is ring.foci_m and ring.foci_m.shape == (12, 3)
    ring.save(tmp_path / "again.hex")
    assert same(ring, tmp_path, "again")
    theirs("compile", "--shape", "square", "--shape", "plus", "--length", "30", "--center", "5,-5,140", "--size", "35", "--rotate", "0,0,45", "--am", "square:200", "--points", "9", "--rate", "50", "-o", "two.hex")
    two = haptogram.compile(shape=["square", "plus"], length_m=0.03, center_m=(0.005, -0.005, 0.14), size_m=0.035, rotate_deg=(0, 0, 45), am="square:200", points=9, rate_hz=50)
    assert same(two, tmp_path, "two")


def test_points_are_a_shape_or_with_times_a_path(program, tmp_path):
    points = np.array([[0.01, 0, 0.13], [-0.01, 0.0123, 0.13], [0, 0.01, 0.14]])
    (tmp_path / "points.csv").write_text("".join(f"{x},{y},{z}\n" for x, y, z in points.tolist()))
    program("compile", "points.csv", "--unit", "m", "--points", "3", "--rate", "20", "-o", "shape.hex")
    assert same(haptogram.compile(points_m=points, rate_hz=20), tmp_path, "shape")
    with open(tmp_path / "path.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "x_mm", "y_mm", "z_mm", "intensity"])
        rows.writerows([[0, 10, 0, 130, 1], [0.01, -10, 12.3, 130, 0.5], [0.02, 0, 10, 140, 1]])
    program("compile", "--path", "path.csv", "-o", "path.hex")
    assert same(haptogram.compile(points_m=points, times_s=[0, 0.01, 0.02], intensity=[1, 0.5, 1]), tmp_path, "path", without=OTHER_TEXT)
    assert same(haptogram.compile(path=tmp_path / "path.csv"), tmp_path, "path")


def test_projects_and_paths_are_files_or_dicts(program, tmp_path):
    project = {"points": 9, "rate_hz": 20, "shape": [{"kind": "cone", "diameter_m": 0.03, "height_m": 0.02, "center_m": [0, 0, 0.12]}]}
    (tmp_path / "cone.toml").write_text('format = "haptogram-project-1"\npoints = 9\nrate_hz = 20\n[[shape]]\nkind = "cone"\ndiameter_mm = 30\nheight_mm = 20\ncenter_mm = [0, 0, 120]\n')
    program("compile", "cone.toml", "-o", "cone.hex")
    program("compile", "cone.toml", "--points", "5", "-o", "five.hex")
    assert same(haptogram.compile(project=tmp_path / "cone.toml"), tmp_path, "cone")
    assert same(haptogram.compile(project=project), tmp_path, "cone")
    assert same(haptogram.compile(project=tmp_path / "cone.toml", points=5), tmp_path, "five")
    step = {"periods": 400, "foci": [{"position_mm": [-10, 0, 130]}, {"position_mm": [10, 0, 130], "amplitude": 0.5}]}
    path = {"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [step]}
    (tmp_path / "steps.json").write_text(json.dumps(path))
    program("compile", "--path", "steps.json", "-o", "path.hex")
    step["foci"] = [{"position_m": (-0.01, 0, 0.13)}, {"position_m": np.array([0.01, 0, 0.13]), "amplitude": 0.5}]
    assert same(haptogram.compile(path=path), tmp_path, "path", without=OTHER_TEXT)
    assert len(haptogram.solve(haptogram.compile(path=path)).foci.foci_m) == 2


@pytest.mark.parametrize("options, keywords, names", [
    (["--plane", "xy@z=130", "--step", "2"], {"z_m": 0.13, "step_m": 0.002}, ["y_m", "x_m"]),
    (["--plane", "xz@y=0", "--step", "4", "--z", "100:160", "--quantity", "spl"], {"y_m": 0, "z_m": (0.1, 0.16), "step_m": 0.004, "quantity": "spl"}, ["z_m", "x_m"]),
    (["--line", "z@x=0,y=12.3", "--extent", "90"], {"x_m": 0, "y_m": 0.0123, "extent_m": 0.09}, ["z_m"]),
    (["--plane", "uv@x=1,y=0,z=130,rx=30,ry=0,rz=5", "--step", "4"], {"center_m": (0.001, 0, 0.13), "rotate_deg": (30, 0, 5), "step_m": 0.004}, ["y_m", "x_m"]),
    (["--plane", "uv@x=0,y=0,z=130,nx=0,ny=-1,nz=2", "--step", "4"], {"center_m": (0, 0, 0.13), "normal": (0, -1, 2), "step_m": 0.004}, ["y_m", "x_m"]),
    (["--volume", "--step", "8", "--z", "100:160"], {"volume": True, "step_m": 0.008, "z_m": (0.1, 0.16)}, ["z_m", "y_m", "x_m"]),
    (["--plane", "xy@z=130", "--step", "4", "--record", "3"], {"z_m": 0.13, "step_m": 0.004, "record": 3}, ["y_m", "x_m"]),
], ids=["plane", "upright", "line", "turned", "normal", "volume", "record"])  # fmt: skip
def test_fields_are_the_program_s(ring, theirs, tmp_path, options, keywords, names):
    for suffix in ("npy", "csv"):
        said = json.loads(theirs("field", "ring.hex", *options, "--json", "-o", f"field.{suffix}"))
    field = haptogram.field(ring, **keywords)
    assert np.array_equal(field, np.load(tmp_path / "field.npy"))
    assert (field.quantity, field.method, field.error, field.level) == (said["quantity"], said["method"], said["error"], said["level"]["note"])
    assert list(field.coordinates) == names and np.shape(field) == tuple(map(len, field.coordinates.values()))
    rows = np.genfromtxt(tmp_path / "field.csv", delimiter=",", names=True)
    places = np.stack([rows[f"{axis}_mm"] for axis in "xyz" if f"{axis}_mm" in rows.dtype.names], axis=-1)
    ours = field.points_m.reshape(-1, 3)[:, ["xyz".index(axis) for axis in "xyz" if f"{axis}_mm" in rows.dtype.names]]
    assert places.shape[1] > 0 and np.allclose(1000 * ours, places, rtol=0, atol=1e-4)
    assert np.array_equal(haptogram.field(tmp_path / "ring.hex", **keywords), field)


def test_an_array_focuses_and_complex_values_are_pa(program, tmp_path):
    program("field", "--focus", "0,10,120", "--plane", "xy@z=120", "--step", "5", "--quantity", "complex", "-o", "field.npy")
    array = haptogram.Array("tile-10x10")
    field = haptogram.field(array, focus_m=(0, 0.01, 0.12), z_m=0.12, step_m=0.005, quantity="complex")
    assert np.array_equal(field, np.load(tmp_path / "field.npy")) and np.iscomplexobj(field)
    at_points = haptogram.pressure(array, field.points_m.reshape(-1, 3), focus_m=(0, 0.01, 0.12))
    assert at_points.shape == (field.values.size,) and np.allclose(at_points, field.values.ravel(), atol=1e-3 * abs(at_points).max())
    own = haptogram.Drives(array, native.ideal_drives(array.native, (0, 0.01, 0.12)))
    assert np.array_equal(haptogram.field(own, z_m=0.12, step_m=0.005, quantity="complex"), field)


def test_analyses_are_the_program_s(ring, theirs, program):
    said = json.loads(theirs("analyze", "ring.hex", "--json"))
    alone = json.loads(program("analyze", "--focus", "10,0,130", "--json"))
    focused = haptogram.analyze(haptogram.Array("tile-10x10"), focus_m=(0.01, 0, 0.13))
    for table, points in ((haptogram.analyze(ring), said["points"]), (focused, alone["points"])):
        columns = {"pressure_pa": 1, "radiation_pa": 1, "side_lobe": 1, "width_m": 1e3, "depth_m": 1e3, "force_n": 1e3, "formation_s": 1e6}
        names = {"radiation_pa": "radiation_pressure_pa", "width_m": "width_mm", "depth_m": "depth_mm", "force_n": "force_mn", "formation_s": "formation_us"}
        for name, factor in columns.items():  # which the program rounds to four decimals
            assert np.allclose(factor * getattr(table, name), [point[names.get(name, name)] for point in points], rtol=0, atol=0.51e-4), name
        assert np.allclose(1000 * table.foci_m, [point["focus_mm"] for point in points], rtol=0, atol=0.51e-4)
    ours = haptogram.analyze(ring)
    assert (ours.warnings, ours.level, len(ours)) == (said["warnings"], said["level"]["note"], 12)
    assert ours.pressure_left_least == said["pressure_left_least"] and round(ours.highest_db, 1) == said["safety"]["highest_on_axis_db_spl"]
    assert ours.dwell_cycles.tolist() == [point["dwell_cycles"] for point in said["points"]]


def test_what_is_felt_is_the_program_s(ring, theirs):
    for options, keywords in (([], {}), (["--at", "10,0,130", "--at", "0,10,130", "--ear", "0,-300,200", "--contact", "15", "--region", "finger", "--grip", "2", "--normal", "0,0.5,-1"],
                                         {"at_m": [(0.01, 0, 0.13), (0, 0.01, 0.13)], "ears_m": (0, -0.3, 0.2), "contact_m": 0.015, "region": "finger", "grip_n": 2, "normal": (0, 0.5, -1)})):  # fmt: skip
        said, felt = json.loads(theirs("feel", "ring.hex", "--json", *options)), haptogram.feel(ring, **keywords)
        assert felt.at_m.tolist() == [(np.array(place["at_mm"]) / 1000).tolist() for place in said["places"]]
        for name in ("mean_pa", "most_pa", "modulation_depth"):
            assert felt.columns[name].tolist() == [place[name] for place in said["places"]], name
        assert felt.mean_n.tolist() == [place["mean_mn"] / 1000 for place in said["places"]]
        assert [line["force_n"] for line in felt.lines[0]] == [line["force_mn"] / 1000 for line in said["places"][0]["lines"]]
        assert felt.answer == said["answer"] and felt.contact_m == said["contact_mm"] / 1000
        assert felt.ears[0]["mean_db_spl"] == said["ears"][0]["mean_db_spl"]
    alone = haptogram.feel(haptogram.Array("tile-7x8"), focus_m=(0, 0, 0.13))
    assert alone.mean_n[0] == json.loads(theirs("feel", "--focus", "0,0,130", "--array", "tile-7x8", "--json"))["places"][0]["mean_mn"] / 1000


def test_a_simulation_is_the_program_s(ring, theirs):
    said, pins = json.loads(theirs("simulate", "ring.hex", "--json", "--load", "direct")), haptogram.simulate(ring, load="direct")
    for name in ("pulses", "pulses_equal_to_image", "contract_violations", "simulated_s"):
        assert getattr(pins, name) == said[name], name
    assert pins.pulses > 0 and len(pins) == 12
    assert pins.pressure_pa.tolist() == [record["pressure_pa"] for record in said["records"]]
    assert pins.focus_error_m.tolist() == [record["focus_error_mm"] / 1000 for record in said["records"]]
    assert haptogram.simulate(ring, load="direct", duration_s=0.005).pulses < pins.pulses


def drives_of(step):
    return np.array([one["amplitude"] * np.exp(1j * one["phase_rad"]) for one in step["drives"]])


def test_solved_drives_are_the_program_s_in_pa_m(ring, theirs):
    array, foci = haptogram.Array("tile-10x10"), [[-0.02, 0, 0.12], [0.02, 0.01, 0.13]]
    (step,) = json.loads(theirs("solve", "--focus", "-20,0,120,1", "--focus", "20,10,130,0.5", "--solver", "weighted-gs", "--json"))["steps"]
    drives = haptogram.solve(array, foci, [1, 0.5], method="weighted-gs")
    assert array.full_pa_m == 4.0 and np.allclose(drives, 4.0 * drives_of(step), rtol=0, atol=1e-12)
    exact = step["quality"]["exact"]
    assert np.allclose(drives.foci.pressure_pa, exact["pressure_pa"], rtol=1e-12)
    assert (drives.foci.spread, drives.foci.efficiency) == pytest.approx((exact["spread"], exact["efficiency"]), rel=1e-9)
    assert np.allclose(abs(haptogram.pressure(drives, foci)), drives.foci.pressure_pa, rtol=1e-5)
    assert haptogram.analyze(drives).pressure_pa == pytest.approx(drives.foci.pressure_pa, rel=1e-9)
    steps = json.loads(theirs("solve", "ring.hex", "--json"))["steps"]
    played = haptogram.solve(ring)
    assert np.allclose(played, [4.0 * drives_of(step) for step in steps], rtol=0, atol=1e-12) and played.weights.shape == (12,)
    two = haptogram.solve(array, [foci, foci[::-1]])
    assert two.values_pa_m.shape == (2, 100) and two.foci.set.tolist() == [0, 0, 1, 1] and len(two.foci.spread) == 2


def test_an_own_array_is_the_same_as_its_file(program, tmp_path):
    places = np.column_stack([0.011 * np.arange(30) - 0.16, 0.004 * np.cos(np.arange(30)), 0 * np.arange(30)])
    normals = np.tile([0, 0.6, 0.8], (30, 1))
    array = haptogram.Array(positions_m=places, normals=normals, name="row", medium={"temperature_c": 30})
    assert np.allclose(array.positions_m, places, rtol=0, atol=1e-15) and np.allclose(array.normals, normals)
    array.save(tmp_path / "row.toml")
    program("compile", "--shape", "circle", "--points", "8", "--array", "row.toml", "-o", "circle.hex")
    assert same(haptogram.compile(shape="circle", points=8, array=array), tmp_path, "circle")
    assert same(haptogram.compile(shape="circle", points=8, array=tmp_path / "row.toml"), tmp_path, "circle")
    shipped = haptogram.Array("tile-7x8")
    assert "tile-7x8" in haptogram.array_names() and len(shipped) == 56
    program("analyze", "--array", "tile-7x8", "--plane", "xz@y=0", "--extent", "40", "--step", "10", "-o", "map.npy")
    axis = np.arange(-4, 5) / 100
    assert np.array_equal(haptogram.workspace(shipped, x_m=axis, y_m=0, z_m=np.arange(1, 9) / 100), np.load(tmp_path / "map.npy"), equal_nan=True)


@pytest.mark.parametrize("wrong", [
    lambda ring, array: haptogram.solve(array, [[0, 0, 0.13], [0, 0, 130]]),
    lambda ring, array: haptogram.solve(array, [[0.02, 0, 0.13], [0, 0, -0.13]]),
    lambda ring, array: haptogram.field(array, focus_m=(0, 0, 130), z_m=0.13),
    lambda ring, array: haptogram.analyze(array, focus_m=(0.3, 0, 0.05)),
    lambda ring, array: haptogram.feel(ring, at_m=(10, 0, 130)),
    lambda ring, array: haptogram.pressure(array, [[0, 0, 130]], focus_m=(0, 0, 0.13)),
    lambda ring, array: haptogram.field(ring, z_m=130),
    lambda ring, array: haptogram.field(ring, z_m=0.13, extent_m=80),
    lambda ring, array: haptogram.workspace(array, x_m=0, y_m=0, z_m=[100, 200]),
    lambda ring, array: haptogram.compile(shape="circle", diameter_m=40),
    lambda ring, array: haptogram.compile(shape="circle", diameter_mm=40),
    lambda ring, array: haptogram.compile(shape="circle", center_m=(0, 0, 130)),
    lambda ring, array: haptogram.compile(points_m=np.full((1000, 3), 130.0)),
    lambda ring, array: haptogram.compile(points_m=np.full((1000, 3), (0.3, 0.05, 0.05))),
    lambda ring, array: haptogram.Array(positions_m=[[0, 0], [10, 0]]),
], ids=["solve", "behind", "focus", "aside", "skin", "pressure", "plane", "extent", "workspace", "diameter", "millimetres", "center", "points", "reach", "elements"])  # fmt: skip
def test_millimetres_and_places_out_of_reach_are_refused(ring, wrong):
    with refused():
        wrong(ring, haptogram.Array("tile-10x10"))


def test_a_place_that_is_far_is_named_with_what_was_meant():
    with refused() as caught:
        haptogram.solve("tile-10x10", [[0, 0, 0.13], [0, 0, 130]])
    assert caught.value.where == "foci_m[1]"
    assert all(part in caught.value.message for part in ("(0, 0, 130) m is 130 m away", "metres", "(0, 0, 0.13)"))


LARGE = np.zeros((300, 30))


@pytest.mark.parametrize("wrong", [
    lambda ring: haptogram.compile(),
    lambda ring: haptogram.compile(shape="circle", path="path.csv"),
    lambda ring: haptogram.compile(points_m=LARGE),
    lambda ring: haptogram.compile(shape=LARGE),
    lambda ring: haptogram.compile(shape="circle", points=LARGE),
    lambda ring: haptogram.compile(shape="circle", colour=LARGE),
    lambda ring: haptogram.compile(points_m=[[0, 0, 0.13]] * 2, times_s=[0, 0.1, 0.2]),
    lambda ring: haptogram.compile(project="nowhere.toml"),
    lambda ring: haptogram.compile(shape="circle", array=LARGE),
    lambda ring: haptogram.field(LARGE, z_m=0.13),
    lambda ring: haptogram.field("nowhere.hex", z_m=0.13),
    lambda ring: haptogram.field(ring),
    lambda ring: haptogram.field(ring, z_m=LARGE),
    lambda ring: haptogram.field(ring, z_m=0.13, quantity="warmth"),
    lambda ring: haptogram.field(ring, z_m=0.13, focus_m=(0, 0, 0.13)),
    lambda ring: haptogram.field(haptogram.Array("tile-10x10"), z_m=0.13),
    lambda ring: haptogram.feel("nowhere.hex"),
    lambda ring: haptogram.simulate(LARGE),
    lambda ring: haptogram.Drives(haptogram.Array("tile-10x10"), LARGE),
    lambda ring: haptogram.Drives(LARGE, LARGE),
    lambda ring: haptogram.solve("tile-10x10", LARGE),
    lambda ring: haptogram.solve("tile-10x10", [[0, 0, float("nan")]]),
    lambda ring: haptogram.pressure(ring, [[0, 0, 0.13]]),
    lambda ring: haptogram.compare([haptogram.field(ring, z_m=0.13), haptogram.field(ring, z_m=0.13, quantity="spl")]),
], ids=["nothing", "both", "points", "shape", "count", "setting", "times", "project", "array", "source", "image", "no-plane", "plane", "quantity", "no-array", "no-focus",
        "felt", "simulated", "drives", "of-array", "foci", "nan", "pressure", "compare"])  # fmt: skip
def test_errors_are_one_line_without_the_argument(ring, wrong):
    with refused():
        wrong(ring)


def test_results_come_back_from_pickle(ring):
    array = haptogram.Array(positions_m=[[0, 0], [0.01, 0], [0, 0.01]], name="three")
    drives = haptogram.solve(array, [[0, 0, 0.13]])
    again, known, played, table, field = pickle.loads(pickle.dumps((ring, array, drives, haptogram.analyze(ring), haptogram.field(ring, z_m=0.13))))
    assert (again.hex, again.manifest) == (ring.hex, ring.manifest) and np.array_equal(again.foci_m, ring.foci_m)
    assert np.array_equal(haptogram.field(again, z_m=0.13), field) and field.unit == "Pa"
    assert np.array_equal(known.positions_m, array.positions_m) and known.name == "three"
    assert np.array_equal(played, drives) and np.array_equal(haptogram.pressure(played, [[0, 0, 0.13]]), haptogram.pressure(drives, [[0, 0, 0.13]]))
    assert np.array_equal(np.asarray(table), np.asarray(haptogram.analyze(ring))) and np.asarray(table)["foci_m"].shape == (12, 3)
    with pytest.raises(AttributeError):
        table.colour  # noqa: B018


def test_tables_of_pandas(ring):
    field, table = haptogram.field(ring, y_m=0, z_m=0.13), haptogram.analyze(ring)
    rows = field.to_pandas()
    assert list(rows) == ["x_m", "y_m", "z_m", "radiation_pressure_pa"] and set(rows["z_m"]) == {0.13}
    assert np.array_equal(rows["radiation_pressure_pa"], field) and np.array_equal(rows["x_m"], field.x_m)
    foci = table.to_pandas()
    assert np.allclose(foci[["x_m", "y_m", "z_m"]], ring.foci_m, rtol=0, atol=1e-8)
    assert np.array_equal(foci["force_n"], table.force_n) and foci.attrs["level"] == table.level


def test_grids_of_xarray(ring):
    pytest.importorskip("xarray")
    field, table = haptogram.field(ring, z_m=0.13), haptogram.analyze(ring)
    grid = field.to_xarray()
    assert grid.dims == ("y_m", "x_m") and grid.attrs["units"] == "Pa" and float(grid.z_m) == 0.13
    assert np.array_equal(grid, field) and np.array_equal(grid.x_m, field.x_m)
    assert float(grid.sel(x_m=0.02, y_m=0, method="nearest")) == field.values[80, 100]
    foci = table.to_xarray()
    assert dict(foci.sizes) == {"focus": 12} and np.array_equal(foci.force_n, table.force_n) and "x_m" in foci.coords


def test_plots_take_what_matplotlib_takes(ring):
    _, ax = plt.subplots()
    field = haptogram.field(ring, z_m=0.13)
    assert field.plot(ax, vmin=1, vmax=3, cmap="viridis", title="ring") is ax
    (drawn,) = ax.collections
    assert (drawn.get_clim(), drawn.get_cmap().name, ax.get_title()) == ((1, 3), "viridis", "ring")
    assert np.array_equal(drawn.get_array().reshape(field.values.shape), field)
    (curve,) = haptogram.field(ring, x_m=0, y_m=0).plot(color="red", vmin=0).lines
    assert curve.get_color() == "red" and curve.axes.get_ylim()[0] == 0
    (elements,) = haptogram.Array("tile-7x8").plot(color="green").lines
    assert elements.get_color() == "green" and len(elements.get_xdata()) == 56
    assert ring.plot(cmap="twilight").collections[0].get_cmap().name == "twilight"


def test_fields_are_compared_on_one_scale(ring):
    fields = [haptogram.field(ring, z_m=z) for z in (0.1, 0.13, 0.16)]
    panels = haptogram.compare(fields, titles=["near", "there", "far"])
    limits = {panel.collections[0].get_clim() for panel in panels}
    assert limits == {(min(np.min(field) for field in fields), max(np.max(field) for field in fields))}
    assert [panel.get_title() for panel in panels] == ["near", "there", "far"] and len(panels[0].figure.axes) == 4
    curves = haptogram.compare([haptogram.field(ring, y_m=0, z_m=z) for z in (0.1, 0.13)], titles=["near", "there"])
    assert len(curves.lines) == 2 and [text.get_text() for text in curves.get_legend().get_texts()] == ["near", "there"]


def test_a_board_takes_what_compile_gives(ring):
    with haptogram.simulated_board("tile-100") as port, haptogram.Board.open(port) as board:
        assert board.upload(ring) > 0 and board.upload(ring.image) == 0
        outcome = haptogram.play(board, loops=1, watchdog_ms=60000)
        assert (outcome.refused_records, board.status().enabled) == (0, False)
    assert haptogram.Client is haptogram.Board
    assert haptogram.Focus.at((0.02, 0, 0.13), 0.5) == haptogram.Focus(20, 0, 130, 0.5)
    with refused():
        haptogram.Focus.at((20, 0, 130))
    with refused(), haptogram.simulated_board("nowhere"):
        pass


def test_help_names_all_that_there_is():
    text = pydoc.render_doc(haptogram, renderer=pydoc.plaintext)
    for name in haptogram.__all__:
        assert name in text, name
    computed = ast.parse((ROOT / "python/haptogram/computing.py").read_text(encoding="utf-8"))
    public = {node.name for node in computed.body if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_")}
    assert all(ast.get_docstring(node) for node in computed.body if getattr(node, "name", "") in public)
    assert public <= set(haptogram.__all__) and set(haptogram.__all__) <= set(dir(haptogram))
    with pytest.raises(AttributeError):
        haptogram.colour  # noqa: B018


def test_without_the_computing_half_the_client_works(tmp_path):
    code = """
import sys
sys.modules["numpy"] = None
import haptogram
haptogram.Board, haptogram.Image, haptogram.play
try:
    haptogram.compile(shape="circle")
except haptogram.HaptogramError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": str(ROOT / "python")}, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.startswith("numpy: ") and "pip install" in done.stdout and done.stdout.count("\n") == 1


@pytest.mark.parametrize("module", ["pandas", "xarray"])
def test_what_is_optional_is_named_when_it_is_missing(ring, monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)
    with refused() as caught:
        getattr(haptogram.analyze(ring), f"to_{module}")()
    assert caught.value.where == module and f"pip install {module}" in caught.value.message
