# SPDX-License-Identifier: Apache-2.0
"""The JSON Schemas of docs/schemas, by Python's jsonschema: they take what is shipped and what the program writes; what they refuse, the
program refuses, too, and they know the keys that it knows."""
import copy
import json
import re
import tomllib

import pytest
from jsonschema import Draft202012Validator
from support import BAD_INPUT, ROOT, USAGE, assert_one_message, path_file, read_json, run, succeed, text

SCHEMAS = {file.name.split(".")[0]: read_json(file) for file in (ROOT / "docs/schemas").glob("*.schema.json")}
GALLERY = sorted((ROOT / "extras/studio/gallery").glob("*/project.toml"))
RIGS = sorted((ROOT / "host/arrays/rigs").glob("*.toml"))
PAIR = """format = "haptogram-rig-1"
[[unit]]
array = "tile-10x10"
origin_mm = [-50, 0, 0]
board = "tile-100-wide"
port = "left"
[[unit]]
array = "tile-10x10"
origin_mm = [50, 0, 0]
turn_deg = [0, -10, 0]
board = "tile-100-wide"
port = "right"
"""
PROJECT = {"format": "haptogram-project-1", "points": 8, "rate_hz": 100, "place": {"rotate_deg": [0, 0, 10]}, "shape": [{"kind": "circle", "diameter_mm": 50}]}


def wrong(name, document):
    """What a schema has against a document, in words."""
    return [f"{error.json_path}: {error.message}"[:200] for error in Draft202012Validator(SCHEMAS[name]).iter_errors(document)]


def toml(value):
    """A value of JSON as TOML has it; tables stand in braces."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def changed(document, change):
    """A copy, changed by a function."""
    copied = copy.deepcopy(document)
    change(copied)
    return copied


def without(*keys):
    """Takes a member away, at the end of these keys."""

    def change(document):
        for key in keys[:-1]:
            document = document[key]
        del document[keys[-1]]

    return change


def put(value, *keys):
    """Puts a value in the place of a member, at the end of these keys."""

    def change(document):
        for key in keys[:-1]:
            document = document[key]
        document[keys[-1]] = value

    return change


def also(change, *more):
    def changes(document):
        for one in (change, *more):
            one(document)

    return changes


def test_they_are_schemas_and_the_index_has_them():
    index = (ROOT / "docs/README.md").read_text(encoding="utf-8")
    assert set(SCHEMAS) == {"path", "manifest", "rig", "rig-manifest", "project", "scene", "simulation-report"}
    for name, schema in SCHEMAS.items():
        Draft202012Validator.check_schema(schema)
        assert schema["$id"].startswith(f"urn:haptogram:{name}") and f"(schemas/{name}.schema.json)" in index


@pytest.mark.parametrize("file", [*RIGS, *GALLERY], ids=lambda file: f"{file.parent.name}/{file.name}")
def test_what_is_shipped(file):
    assert wrong("rig" if file in RIGS else "project", tomllib.loads(file.read_text(encoding="utf-8"))) == []


def test_examples_of_the_pages():
    blocks = re.findall(r"^```(json|toml)\n(.*?)^```$", "".join((ROOT / page).read_text(encoding="utf-8") for page in ("host/haptogram/shape/README.md", "host/haptogram/verbs/README.md")), re.MULTILINE | re.DOTALL)
    documents = [json.loads(block) if kind == "json" else tomllib.loads(block) for kind, block in blocks]
    assert [document["format"] for document in documents] == ["haptogram-path-1", "haptogram-project-1"]
    assert wrong("path", documents[0]) == [] and wrong("project", documents[1]) == []


# Images of every kind, by the arguments of `compile`.
IMAGES = {
    "one focus": ["--shape", "circle", "--points", 4, "--rate", 500],
    "drawn": ["--shape", "plus", "--points", 40, "--speed", 5],
    "foci and modulation of the board": ["--shape", "circle", "--points", 4, "--am", "sine:200", "--array", "tile-10x10", "--board", "tile-100-wide"],
    "amplitudes": ["--shape", "circle", "--points", 4, "--records", "--am", "square:200", "--array", "tile-10x10", "--board", "tile-100-wide"],
    "several foci": ["--path", "path.json"],
    "a measured pattern": ["--shape", "point", "--center", "0,0,200", "--array", "hoshi", "--quantise", "hoshi"],
    "a calibration": ["--shape", "point", "--array", "./calibrated.toml"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("schemas")
    path_file(made, [([(-20, 0, 150, 1.0), (20, 0, 150, 0.5)], 40), ([], 40)], {"periods_a_sample": 20, "samples": [1.0, 0.25]})
    (made / "pair.toml").write_text(PAIR)
    elements = "".join("[[element]]\ndead = true\n" if n == 7 else f"[[element]]\ngain = {1 - n / 400}\nphase_deg = {n}\n" for n in range(100))
    (made / "calibrated.toml").write_text(f'format = "haptogram-calibration-1"\narray = "tile-10x10"\nsource_pa_m = 3.5\nmeasured = "by a balance"\n{elements}')
    return made


@pytest.mark.parametrize("kind", IMAGES)
def test_manifests_and_paths_that_the_program_writes(folder, kind):
    succeed(["compile", *IMAGES[kind], "-o", f"{kind}.hex", "--save-path", f"{kind}.path.json"], cwd=folder)
    manifest = read_json(folder / f"{kind}.json")
    assert wrong("manifest", manifest) == [] and ("responses" in manifest["array"]) == (kind == "a calibration")
    assert wrong("path", read_json(folder / f"{kind}.path.json")) == []


def test_the_manifests_of_a_rig(folder):
    assert wrong("rig", tomllib.loads(PAIR)) == []
    succeed(["compile", "--shape", "circle", "--points", 2, "--rate", 5000, "--center", "0,0,180", "--rig", "pair.toml", "-o", "wall.hex"], cwd=folder)
    assert wrong("rig-manifest", read_json(folder / "wall.json")) == []
    tile = read_json(folder / "wall.tile-2.json")
    assert wrong("manifest", tile) == [] and len(tile["array"]["elements_mm"][0]) == 6  # they face elsewhere


def test_reports_of_simulations(folder):
    succeed(["compile", "--shape", "circle", "--points", 2, "--rate", 5000, "-o", "two.hex"], cwd=folder)
    succeed(["simulate", "two.hex", "--load", "direct", "--report", "two.report.json"], cwd=folder, timeout=300)
    one = read_json(folder / "two.report.json")
    assert wrong("simulation-report", one) == [] and one["points"] == 2
    for change in (without("points"), put(-1, "pulses"), put("2", "points"), put(1, "pulse"), put(3, "tiles"), without("level", "note"), without("records", 0, "cycles"), put(0.5, "records_off")):
        assert wrong("simulation-report", changed(one, change))
    # Of a rig, by its members: two Verilated tiles take a minute.
    rig = {"rig": "pair", "tiles": 2, "crystals_ppm": [-3.0, 4.0], "period": 900, "attempts": 1, "start_spread_clocks": 0.4, "seconds": 8.1}
    shared = {key: one[key] for key in SCHEMAS["simulation-report"]["required"]}
    assert wrong("simulation-report", {**shared, **rig}) == []
    assert wrong("simulation-report", {**shared, **rig, "period": -1}) and wrong("simulation-report", {**shared, **rig, "records": []}) and wrong("simulation-report", shared)


@pytest.mark.parametrize("algorithm, members", [("A", ["contacts_mm"]), ("ring", ["sections"])])
def test_lines_of_live_sessions(tmp_path, algorithm, members):
    script = [{"time_s": 0.1, "name": "other", "object": "cone", "size_mm": 30, "height_mm": 20, "center_mm": [0, 40, 160]}]
    (tmp_path / "script").write_text("".join(json.dumps(line) + "\n" for line in script))
    words = ["live", "--from", "synthetic:press", "--object", "sphere", "--size", 80, "--center", "0,40,160", "--algorithm", algorithm]
    more = ["--scene-in", "script"] if algorithm == "A" else []
    succeed([*words, *more, "--port", "reference:tile-100-wide", "--seconds", 0.4, "--scene", "lines"], cwd=tmp_path, timeout=300)
    lines = [json.loads(line) for line in (tmp_path / "lines").read_text().splitlines()]
    assert [complaint for line in lines for complaint in wrong("scene", line)] == []
    full = next(line for line in lines if all(line[key] for key in ("hands", "foci", "objects", *members)))
    for change in (put(1, "scene"), put(2, "hand"), without("objects", 0, "name"), put([0, 0], "objects", 0, "center_mm"), without("hands", 0, "fingers_mm", 0, 0), put(1.5, "foci", 0, 3), put(None, "force_n")):
        assert wrong("scene", changed(full, change))


PATH = {"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [{"periods": 40, "foci": [{"position_mm": [0, 0, 130], "amplitude": 1}]}], "modulation": {"periods_a_sample": 1, "samples": [1, 0]}}
RIG = tomllib.loads(PAIR)
BROKEN_PATHS = {
    "another format": put("haptogram-path-2", "format"),
    "no carrier": without("carrier_hz"),
    "no steps": put([], "steps"),
    "an unknown member": put(1, "speed"),
    "periods that are not whole": put(1.5, "steps", 0, "periods"),
    "no periods": put(0, "steps", 0, "periods"),
    "an amplitude above 1": put(1.01, "steps", 0, "foci", 0, "amplitude"),
    "two coordinates": put([0, 130], "steps", 0, "foci", 0, "position_mm"),
    "a place in words": put("above", "steps", 0, "foci", 0, "position_mm"),
    "a mark that is a number": put(1, "steps", 0, "mark"),
    "samples below 0": put([-0.1], "modulation", "samples"),
    "no length of a sample": without("modulation", "periods_a_sample"),
}
BROKEN_RIGS = {
    "another format": put("haptogram-rig-2", "format"),
    "no units": put([], "unit"),
    "an unknown key": put(1, "unit", 0, "pitch_mm"),
    "no array": without("unit", 0, "array"),
    "no origin": without("unit", 1, "origin_mm"),
    "two coordinates": put([0, 0], "unit", 0, "origin_mm"),
    "a turn in words": put(["left", 0, 0], "unit", 0, "turn_deg"),
    "an empty port": put("", "unit", 0, "port"),
    "a board by number": put(8, "unit", 0, "board"),
}
HAND = {"recording": "synthetic:press", "algorithm": "A", "frame": 30}
BROKEN_PROJECTS = {
    "another format": put("haptogram-project-2", "format"),
    "nothing to play": without("shape"),
    "an unknown key": put(1, "speed"),
    "points that are not whole": put(8.5, "points"),
    "no points": put(0, "points"),
    "two paces": put(7, "speed_m_s"),
    "a jump of points": put("blank", "jump"),
    "another jump": also(without("rate_hz"), put(7, "speed_m_s"), put("skip", "jump")),
    "an amplitude above 1": put(1.5, "amplitude"),
    "another law": put("loudness", "am_law"),
    "a fade to no side": put("x:0.5", "fade"),
    "a fade with an exponent": put("left:9.9e-1", "fade"),
    "another image": put("pulses", "image"),
    "another grid": put("levels", "quantise"),
    "more loops than a board counts": put(65536, "loops"),
    "a place without a number": put(["x", 0, 0], "place", "center_mm"),
    "an unknown key of a place": put(1, "place", "turn"),
    "an unknown shape": put("torus", "shape", 0, "kind"),
    "a shape twice": put("heart.ply", "shape", 0, "file"),
    "no shape in a shape": without("shape", 0, "kind"),
    "a built-in shape with a unit": put("cm", "shape", 0, "unit"),
    "a file with a diameter": put({"file": "heart.ply", "diameter_mm": 3}, "shape", 0),
    "a polygon of two sides": put({"kind": "polygon", "sides": 2}, "shape", 0),
    "a path with a pace": also(without("shape"), without("place"), put("path.json", "path")),
    "a path with points": also(without("shape"), without("place"), without("rate_hz"), put("path.json", "path")),
    "a hand with a place": also(without("shape"), without("rate_hz"), put(HAND, "hand")),
    "a hand and a shape": also(without("place"), without("rate_hz"), put(HAND, "hand")),
    "a hand with an unknown algorithm": also(without("shape"), without("place"), without("rate_hz"), put({**HAND, "algorithm": "M"}, "hand")),
    "a hand without a recording": also(without("shape"), without("place"), without("rate_hz"), put({"algorithm": "A"}, "hand")),
    "a hand with a seed, whose lines are not at random": also(without("shape"), without("place"), without("rate_hz"), put(HAND, "hand"), put(3, "seed")),
    "an option of live in braces": put({"size": {"mm": 80}}, "live"),
    "an option of live without a value": put({"from": []}, "live"),
    "all frames of a hand with points": also(without("shape"), without("place"), without("rate_hz"), put({"recording": "synthetic:press"}, "hand")),
}


@pytest.mark.parametrize(
    "name, document, change",
    [
        *(pytest.param("path", PATH, change, id=f"path: {what}") for what, change in BROKEN_PATHS.items()),
        *(pytest.param("rig", RIG, change, id=f"rig: {what}") for what, change in BROKEN_RIGS.items()),
        *(pytest.param("project", PROJECT, change, id=f"project: {what}") for what, change in BROKEN_PROJECTS.items()),
    ],
)
def test_what_a_schema_refuses_the_program_refuses(tmp_path, name, document, change):
    assert wrong(name, document) == []
    broken = changed(document, change)
    assert wrong(name, broken), "the schema takes it"
    (tmp_path / "path.json").write_text(json.dumps(broken if name == "path" else PATH))
    file = "path.json" if name == "path" else f"{name}.toml"
    if name != "path":
        (tmp_path / file).write_text("".join(f"{key} = {toml(value)}\n" for key, value in broken.items()))
    what = {"path": ["--path", file], "rig": ["--shape", "circle", "--points", 2, "--center", "0,0,180", "--rig", file], "project": [file]}[name]
    result = run(["compile", *what, "-o", "image.hex"], cwd=tmp_path)
    assert_one_message(result, USAGE if result.returncode == USAGE else BAD_INPUT)


@pytest.mark.parametrize(
    "name, document, change",
    [
        ("path", PATH, without("modulation")),
        ("path", PATH, put([*PATH["steps"], {"periods": 3, "foci": []}], "steps")),
        ("project", PROJECT, put(0, "loops")),
        ("project", PROJECT, put({"from": ["leap-pipe:-", "depth:hand"], "center": [0, 40, 160.5], "json": True}, "live")),
        ("project", PROJECT, also(without("rate_hz"), put(7, "speed_m_s"), put("blank", "jump"), put(4, "seed"))),
        ("project", PROJECT, also(without("shape"), without("place"), without("rate_hz"), put({**HAND, "algorithm": "E"}, "hand"), put(3, "seed"))),
        ("project", PROJECT, also(without("shape"), without("place"), without("rate_hz"), without("points"), put("path.json", "path"))),
        *(("project", PROJECT, put({"kind": kind}, "shape", 0)) for kind in SCHEMAS["project"]["$defs"]["shape"]["properties"]["kind"]["enum"]),
    ],
)
def test_what_a_schema_takes_the_program_takes(tmp_path, name, document, change):
    right = changed(document, change)
    assert wrong(name, right) == []
    (tmp_path / "path.json").write_text(json.dumps(right if name == "path" else PATH))
    (tmp_path / "project.toml").write_text("".join(f"{key} = {toml(value)}\n" for key, value in right.items()))
    succeed(["compile", *(["--path", "path.json"] if name == "path" else ["project.toml"]), "-o", "image.hex"], cwd=tmp_path)


@pytest.mark.parametrize(
    "change",
    [
        put("haptogram-manifest-2", "format"),
        without("medium", "speed_m_s"),
        put(-1, "transducer", "source_pa_m"),
        put(0, "board", "channels"),
        put(1, "timer", "cycle_ticks"),
        put([1.0], "array", "elements_mm", 0),
        put(1.5, "records", 0, "amplitude"),
        put([0, 0], "records", 0, "focus_mm"),
        put("sines", "transducer", "directivity"),
        put("by hand", "solver"),
        put({"periods_a_sample": 1, "samples": [256]}, "modulation"),
    ],
)
def test_what_the_schema_of_manifests_refuses_the_program_refuses(small, change):
    manifest = read_json(small.manifest)
    assert wrong("manifest", manifest) == []
    broken = changed(manifest, change)
    assert wrong("manifest", broken)
    small.manifest.write_text(json.dumps(broken))
    assert_one_message(run(["analyze", "image.hex"], cwd=small.folder), BAD_INPUT)


@pytest.mark.parametrize(
    "change",
    [put("haptogram-manifest-1", "format"), put([], "tiles"), without("rig", "name"), put("0" * 63, "tiles", 0, "image_sha256"), put(7, "tiles", 1, "port"), without("tiles", 0, "image")],
)
def test_what_the_schema_of_rig_manifests_refuses_the_program_refuses(folder, tmp_path, change):
    succeed(["compile", "--shape", "point", "--center", "0,0,180", "--rig", folder / "pair.toml", "-o", "wall.hex"], cwd=tmp_path)
    manifest = read_json(tmp_path / "wall.json")
    assert wrong("rig-manifest", manifest) == []
    broken = changed(manifest, change)
    assert wrong("rig-manifest", broken)
    (tmp_path / "wall.json").write_text(json.dumps(broken))
    assert_one_message(run(["upload", "--rig", "wall.json", "--port", "a", "--port", "b"], cwd=tmp_path), BAD_INPUT)


def known(tmp_path, document, change):
    """The keys that the program lists when it finds one that it does not know."""
    broken = changed(document, change)
    if document is PATH:
        (tmp_path / "file.json").write_text(json.dumps(broken))
        what = ["--path", "file.json"]
    else:
        (tmp_path / "file.toml").write_text("".join(f"{key} = {toml(value)}\n" for key, value in broken.items()))
        what = ["--rig", "file.toml", "--shape", "point"] if document is RIG else ["file.toml"]
    message = " ".join(text(run(["compile", *what, "-o", "image.hex"], cwd=tmp_path).stderr).split())
    return set(re.search(r"known are ([\w, ]+)", message)[1].split(", "))


@pytest.mark.parametrize(
    "document, change, part",
    [
        (PATH, put(1, "nothing"), SCHEMAS["path"]),
        (PATH, put(1, "steps", 0, "nothing"), SCHEMAS["path"]["$defs"]["step"]),
        (PATH, put(1, "steps", 0, "foci", 0, "nothing"), SCHEMAS["path"]["$defs"]["focus"]),
        (PATH, put(1, "modulation", "nothing"), SCHEMAS["path"]["properties"]["modulation"]),
        (RIG, put(1, "nothing"), SCHEMAS["rig"]),
        (RIG, put(1, "unit", 0, "nothing"), SCHEMAS["rig"]["properties"]["unit"]["items"]),
        (PROJECT, put(1, "nothing"), SCHEMAS["project"]),
        (PROJECT, put(1, "place", "nothing"), SCHEMAS["project"]["properties"]["place"]),
        (PROJECT, put(1, "shape", 0, "nothing"), SCHEMAS["project"]["$defs"]["shape"]),
        (PROJECT, also(without("shape"), without("place"), without("rate_hz"), put({**HAND, "nothing": 1}, "hand")), SCHEMAS["project"]["$defs"]["hand"]),
    ],
)
def test_a_schema_knows_the_keys_that_the_program_knows(tmp_path, document, change, part):
    assert set(part["properties"]) == known(tmp_path, document, change)


def test_the_schema_knows_the_keys_of_live(tmp_path):
    """They are too many for a message to name, so each option that the help has is tried as a key."""
    known = set(SCHEMAS["project"]["$defs"]["live"]["properties"])
    options = re.findall(r"--([a-z][a-z0-9-]*)", text(run(["live", "--help"]).stdout))
    taken = set()
    for key in known | {option.replace("-", "_") for option in options} | {"nothing"}:
        (tmp_path / "file.toml").write_text(f"[live]\n{key} = 1\n")
        message = text(run(["live", "--settings", "file.toml"], cwd=tmp_path).stderr)
        if "unknown key" not in " ".join(message.split()):
            taken.add(key)
    assert taken == known
