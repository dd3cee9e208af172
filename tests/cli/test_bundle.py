# SPDX-License-Identifier: Apache-2.0
"""Bundles: a project and its files as one zip, made by Python's zipfile, wherever a project is taken. Nothing outside is read."""

import json
import struct
import zipfile

import pytest

from messages import program_said
from support import BAD_INPUT, refuse, run, snapshot, succeed

PROJECT = """format = "haptogram-project-1"
points = 12
rate_hz = 50
array = "my.toml"

[place]
center_mm = [0, 0, 120]

[[shape]]
file = "parts/cloud.xyz"
"""
ARRAY = """name = "mine"
[array]
columns = 6
rows = 6
pitch_mm = 10.5
carrier_hz = 40000
duty = 0.5
[transducer]
file = "loud.toml"
"""
TRANSDUCER = 'name = "loud"\nradius_mm = 4.5\nsource_pa_m = 0.9\ndirectivity = "table.csv"\n'
TABLE = "angle_deg,amplitude\n" + "".join(f"{angle},{1 - angle / 100:.2f}\n" for angle in range(0, 91, 10))
CLOUD = "".join(f"{10 * (i % 4) - 15} {10 * (i // 4) - 10} 0\n" for i in range(12))
FILES = {"project.toml": PROJECT, "parts/cloud.xyz": CLOUD, "my.toml": ARRAY, "loud.toml": TRANSDUCER, "table.csv": TABLE}


def write_bundle(path, files, method=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", method) as bundle:
        for name, content in files.items():
            bundle.writestr(name, content)


@pytest.fixture
def folder(tmp_path):
    for name, content in FILES.items():
        (tmp_path / "plain" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "plain" / name).write_text(content)
    write_bundle(tmp_path / "mine.haptogram", FILES)
    return tmp_path


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_a_bundle_makes_the_image_of_its_project(method, folder):
    write_bundle(folder / "mine.haptogram", FILES, method)
    succeed(["compile", "plain/project.toml", "-o", "plain.hex"], cwd=folder)
    succeed(["compile", "mine.haptogram", "-o", "mine.hex"], cwd=folder)
    assert (folder / "mine.hex").read_bytes() == (folder / "plain.hex").read_bytes()


@pytest.mark.parametrize("verb", [["field", "--plane", "xy@z=120", "--extent", "10", "--step", "5"], ["analyze", "--json"], ["inspect", "--json"]], ids=lambda verb: verb[0])
def test_verbs_take_a_bundle_and_leave_nothing_behind(verb, folder):
    name, *options = verb
    before = snapshot(folder)
    of_bundle, of_project = (succeed([name, source, *options], cwd=folder).stdout for source in ("mine.haptogram", "plain/project.toml"))
    assert of_bundle.replace(b"mine.haptogram", b"plain/project.toml") == of_project
    assert snapshot(folder) == before


def test_options_name_files_of_the_working_folder(folder):
    (folder / "other.toml").write_text(ARRAY.replace('file = "loud.toml"', "radius_mm = 4.5").replace('"mine"', '"other"'))
    succeed(["compile", "mine.haptogram", "--array", "other.toml", "-o", "other.hex"], cwd=folder)
    assert json.loads((folder / "other.json").read_text())["array"]["name"] == "other"


def test_waveforms_and_hands_are_in_the_bundle(folder):
    wave = "time_ms,amplitude\n0,0\n5,1\n10,0\n"
    project = 'format = "haptogram-project-1"\nam = "csv:wave.csv"\n[[shape]]\nkind = "point"\n'
    write_bundle(folder / "wave.haptogram", {"project.toml": project, "wave.csv": wave})
    (folder / "wave.csv").write_text(wave)
    (folder / "wave.toml").write_text(project)
    for source in ("wave.haptogram", "wave.toml"):
        succeed(["compile", source, "-o", f"{source}.hex"], cwd=folder)
    assert (folder / "wave.haptogram.hex").read_bytes() == (folder / "wave.toml.hex").read_bytes()
    write_bundle(folder / "hand.haptogram", {"project.toml": 'format = "haptogram-project-1"\npoints = 20\n[hand]\nrecording = "synthetic:press"\nframe = 120\n'})
    succeed(["render", "hand.haptogram", "-o", "path.json"], cwd=folder)


def changed(**files):
    return {**FILES, **{name.replace("__", "."): content for name, content in files.items()}}


@pytest.mark.parametrize(
    "files",
    [
        {name: FILES[name] for name in FILES if name != "project.toml"},
        {name: FILES[name] for name in FILES if name != "parts/cloud.xyz"},
        changed(project__toml=PROJECT.replace("parts/cloud.xyz", "/etc/hostname.xyz")),
        changed(project__toml=PROJECT.replace("parts/cloud.xyz", "../secret.xyz")),
        changed(project__toml=PROJECT.replace('"my.toml"', '"/etc/my.toml"')),
        changed(my__toml=ARRAY.replace("loud.toml", "../secret.toml")),
        changed(loud__toml=TRANSDUCER.replace("table.csv", "/etc/table.csv")),
        changed(project__toml='format = "haptogram-project-1"\nam = "wav:/etc/wave.wav"\n[[shape]]\nkind = "point"\n'),
        changed(project__toml='format = "haptogram-project-1"\npath = "../path.json"\n'),
    ],
)
def test_what_is_missing_or_outside_is_named(files, folder):
    (folder / "secret.xyz").write_text(CLOUD)
    (folder / "secret.toml").write_text(TRANSDUCER)
    write_bundle(folder / "bad.haptogram", files)
    result = run(["compile", "bad.haptogram", "-o", "bad.hex"], cwd=folder)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)


def test_names_that_lead_out_of_the_bundle_are_no_files_of_it(folder):
    """What a careless unpacker would write or read elsewhere is a name as any other here."""
    write_bundle(folder / "slip.haptogram", {**FILES, "../slipped.xyz": CLOUD, "/tmp/slipped.xyz": CLOUD})
    succeed(["compile", "slip.haptogram", "-o", "slip.hex"], cwd=folder)
    assert not (folder.parent / "slipped.xyz").exists()


def test_damage_is_told(folder):
    good = (folder / "mine.haptogram").read_bytes()
    at = good.index(b"parts/cloud.xyz") + 40
    (folder / "cut.haptogram").write_bytes(good[: len(good) // 2])
    (folder / "torn.haptogram").write_bytes(good[:at] + bytes(b ^ 0xFF for b in good[at : at + 8]) + good[at + 8 :])
    (folder / "none.haptogram").write_bytes(b"no zip at all")
    (folder / "empty.haptogram").write_bytes(b"")
    for name in ("cut", "torn", "none", "empty", "absent"):
        refuse(folder, ["compile", f"{name}.haptogram"], BAD_INPUT)


def test_sizes_are_bounded_and_not_believed(folder):
    write_bundle(folder / "large.haptogram", {**FILES, "parts/cloud.xyz": b"0" * (257 << 20)})
    result = run(["compile", "large.haptogram", "-o", "bad.hex"], cwd=folder)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
    # One that says that it is small.
    write_bundle(folder / "lie.haptogram", FILES)
    lie = bytearray((folder / "lie.haptogram").read_bytes())
    entry = lie.rindex(b"parts/cloud.xyz") - 46
    assert lie[entry : entry + 4] == b"PK\1\2"
    struct.pack_into("<I", lie, entry + 24, 5)  # in the directory, and in the file's own header
    struct.pack_into("<I", lie, lie.index(b"parts/cloud.xyz") - 30 + 22, 5)
    (folder / "lie.haptogram").write_bytes(lie)
    result = run(["compile", "lie.haptogram", "-o", "bad.hex"], cwd=folder)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
