# SPDX-License-Identifier: Apache-2.0
"""Project files: every verb takes one, and it gives the bytes that the same options give."""

import json

import pytest

from messages import program_said
from support import BAD_INPUT, USAGE, refuse, run, succeed

OPTIONS = ["--shape", "circle", "--diameter", "40", "--center", "0,0,120", "--points", "12", "--rate", "50", "--loops", "2"]
PROJECT = """format = "haptogram-project-1"
points = 12
rate_hz = 50
loops = 2

[place]
center_mm = [0, 0, 120]

[[shape]]
kind = "circle"
diameter_mm = 40
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "ring.toml").write_text(PROJECT)
    succeed(["compile", *OPTIONS, "-o", "options.hex"], cwd=tmp_path)
    return tmp_path


def test_compile_gives_the_bytes_of_the_same_options(folder):
    succeed(["compile", "ring.toml", "-o", "project.hex"], cwd=folder)
    assert (folder / "project.hex").read_bytes() == (folder / "options.hex").read_bytes()
    assert (folder / "project.json").read_bytes() == (folder / "options.json").read_bytes()


def test_options_override_the_project(folder):
    succeed(["compile", "ring.toml", "--points", "7", "-o", "seven.hex"], cwd=folder)
    assert len(json.loads((folder / "seven.json").read_text())["records"]) == 7


@pytest.mark.parametrize("verb", [["field", "--plane", "xy@z=120", "--extent", "10", "--step", "5"], ["analyze", "--json"]], ids=lambda verb: verb[0])
def test_other_verbs_say_of_the_project_what_they_say_of_its_image(verb, folder):
    name, *options = verb
    assert succeed([name, "ring.toml", *options], cwd=folder).stdout == succeed([name, "options.hex", *options], cwd=folder).stdout


def test_simulate(folder):
    reports = [json.loads(succeed(["simulate", source, "--load", "direct", "--json"], cwd=folder).stdout) for source in ("ring.toml", "options.hex")]
    assert reports[0]["points_checked"] == 12 and reports[0]["contract_violations"] == 0
    assert reports[0]["records"] == reports[1]["records"]
    assert reports[0]["level"] == reports[1]["level"] and reports[0]["level"]["note"].startswith("nominal level: ")


def test_files_are_beside_the_project(folder, tmp_path):
    inner = folder / "inner"
    inner.mkdir()
    (inner / "points.xyz").write_text("0 0 110\n10 0 110\n0 10 110\n")
    (inner / "cloud.toml").write_text('format = "haptogram-project-1"\n[[shape]]\nfile = "points.xyz"\n')
    succeed(["compile", "inner/cloud.toml", "-o", "cloud.hex"], cwd=folder)
    assert len(json.loads((folder / "cloud.json").read_text())["records"]) == 3


def test_files_on_the_command_line_are_not_beside_the_project(folder):
    inner = folder / "inner"
    inner.mkdir()
    (inner / "ring.toml").write_bytes((folder / "ring.toml").read_bytes())
    (folder / "few.toml").write_text("[array]\nelements_mm = [[30, 0], [0, 30.5], [-30, 0]]\n[board]\nchannels = 16\n")
    (folder / "half.csv").write_text("time_s,amplitude\n0,0.5\n0.01,0.5\n")
    succeed(["compile", "inner/ring.toml", "--array", "few.toml", "--am", "csv:half.csv", "-o", "few.hex"], cwd=folder)
    assert len(json.loads((folder / "few.json").read_text())["array"]["elements_mm"]) == 3
    succeed(["compile", "inner/ring.toml", "--array", "few.toml", "-o", "all.hex"], cwd=folder)
    assert (folder / "few.hex").read_bytes() != (folder / "all.hex").read_bytes()


@pytest.mark.parametrize(
    "change",
    [
        ("points = 12", "points = 0"),
        ("rate_hz", "rate"),
        ('kind = "circle"', 'kind = "ring"'),
        ("diameter_mm = 40", "sides = 4"),
        ("diameter_mm = 40", "diameter_mm = -4"),
        ("haptogram-project-1", "haptogram-project-2"),
        ("[place]", "[place"),
        ("rate_hz = 50", "amplitude = 0"),
        ("rate_hz = 50", "amplitude = 1.01"),
    ],
    ids=lambda value: value[1] if isinstance(value, tuple) else None,
)
def test_mistakes_are_named(change, folder):
    (folder / "ring.toml").write_text(PROJECT.replace(*change))
    result = run(["compile", "ring.toml", "-o", "x.hex"], cwd=folder)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
    assert not (folder / "x.hex").exists()


def test_a_manifest_is_not_for_a_project(folder):
    refuse(folder, ["simulate", "ring.toml", "--manifest", "options.json"], USAGE)


def test_inspect_and_bitstream_take_it_too(folder):
    assert succeed(["inspect", "ring.toml", "--json"], cwd=folder).stdout == succeed(["inspect", "options.hex", "--json"], cwd=folder).stdout
    refuse(folder, ["bitstream", "--board", "ulx3s-85f", "--image", "ring.toml", "-o", "x.bit"], BAD_INPUT)
