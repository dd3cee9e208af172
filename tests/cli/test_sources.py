# SPDX-License-Identifier: Apache-2.0
"""Every source through every verb: what works, with the right numbers, and what is refused in one sentence.

HAPTOGRAM_RECORD=1 writes the table of docs/sources.md anew; otherwise it must be what comes out here.
"""
import json
import itertools
import math
import os
import re

import pytest
import support

# The waveform, the mean of its squares, and what the transducers' bandwidth leaves of that: a carrier follows its drive with a time
# constant of 1/(π·2 kHz), so that a square of 1.25 ms loses 0.159 ms of it, and a sine of 200 Hz a fiftieth of its amplitude.
MODULATIONS = {"none": (None, 1.0, 1.0), "sine": ("sine:200", 0.375, 0.987), "square": ("square:200:0.25", 0.25, 0.873)}
ONE, WALL = (5, -10, 150), (5, -10, 200)
PAGE = support.ROOT / "docs/sources.md"

# What is given, its arguments under a modulation, whether it can have one, where its focus is, and whether it is one focus.
FILES = {
    "shape": ("point.xyz", False),
    "path": ("path-{}.json", True),
    "project of shapes": ("shapes-{}.toml", True),
    "project of a path": ("of-path-{}.toml", True),
    "project of a hand": ("hand-{}.toml", True),
    "image of timings": ("timings-{}.hex", True),
    "image of amplitudes": ("amplitudes-{}.hex", True),
    "image of foci": ("foci-{}.hex", True),
    "rig": ("wall-{}.json", True),
    "manifest alone": ("foci-{}.json", True),
}
PULSES = {"pulses of timings": "timings", "pulses of amplitudes": "amplitudes", "pulses of foci": "foci", "pulses of a rig": "wall"}
VERBS = ["inspect", "field", "analyze", "feel", "report", "simulate", "solve"]


def path_json(focus, wave):
    """A focus that rests for 5 ms, with a waveform, as anyone could write it."""
    samples = {"sine": [0.5 + 0.5 * math.sin(2 * math.pi * (i + 0.5) / 200) for i in range(200)], "square": [1.0] * 50 + [0.0] * 150}
    path = {"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [{"periods": 200, "foci": [{"position_mm": focus}]}]}
    if wave != "none":
        path["modulation"] = {"periods_a_sample": 1, "samples": samples[wave]}
    return json.dumps(path)


MADE_ONCE = ["folder", "few"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Everything that plays one focus, once under each modulation, and the pulses of what boards play."""
    folder = tmp_path_factory.mktemp("sources")
    (folder / "point.xyz").write_text("{} {} {}\n".format(*ONE))
    head = 'format = "haptogram-project-1"\narray = "tile-10x10"\nboard = "tile-100-wide"\n'
    for wave, (am, _, _) in MODULATIONS.items():
        modulated = head if am is None else head + f'am = "{am}"\n'
        (folder / f"path-{wave}.json").write_text(path_json(ONE, wave))
        (folder / f"wall-path-{wave}.json").write_text(path_json(WALL, wave))
        (folder / f"shapes-{wave}.toml").write_text(modulated + 'rate_hz = 200\n[[shape]]\nfile = "point.xyz"\n')
        (folder / f"of-path-{wave}.toml").write_text(head + f'path = "path-{wave}.json"\n')
        hand = '[hand]\nrecording = "synthetic:press"\nobject = "sphere"\nframe = 150\n'
        (folder / f"hand-{wave}.toml").write_text(f"{modulated}points = 20\nfrequency_hz = 100\n{hand}")
        for name, *options in (("timings", "--board", "tile-100"), ("amplitudes", "--board", "tile-100-wide", "--records"), ("foci", "--board", "tile-100-wide")):
            support.succeed(["compile", "--path", f"path-{wave}.json", "--array", "tile-10x10", *options, "-o", f"{name}-{wave}.hex"], cwd=folder)
        support.succeed(["compile", "--rig", "2x2", "--path", f"wall-path-{wave}.json", "-o", f"wall-{wave}.json"], cwd=folder)
        for name, file in (("timings", "hex"), ("amplitudes", "hex"), ("foci", "hex"), ("wall", "json")):
            if (name, wave) == ("wall", "sine"):
                continue  # four boards take half a minute
            support.succeed(["simulate", f"{name}-{wave}.{file}", "--passes", 3, "--pulses", f"{name}-{wave}.csv"], cwd=folder, timeout=300)
    return folder


def ask(folder, verb, source, z):
    """What a verb says of a source; the radiation pressure at its one focus where it tells one, Pa."""
    more = {
        "inspect": ["--json"],
        "field": ["--line", "z@x=5,y=-10", "--z", f"{z}:{z + 1}", "--step", "1", "-o", "field.csv"],
        "analyze": ["--json"],
        "feel": ["--json", "--places", "1"],
        "report": ["--no-picture", "-o", "report.html"],
        "simulate": ["--json"],
        "solve": ["--json"],
    }[verb]
    done = support.run([verb, *source, *more], cwd=folder, timeout=300)
    if done.returncode != support.OK:
        return done, None
    if verb == "field":
        return done, float((folder / "field.csv").read_text().splitlines()[1].split(",")[-1])
    if verb == "report":
        table = (folder / "report.html").read_text().split('class="foci"')[1]
        return done, float(re.findall(r"<td>([^<]+)</td>", table)[4])
    if verb == "analyze":
        return done, json.loads(done.stdout)["points"][0]["radiation_pressure_pa"]
    if verb == "feel":
        told = json.loads(done.stdout)  # at the level that is expected; the others are at the nominal one
        return done, told["places"][0]["mean_pa"] * (told["level"]["source_pa_m"] / told["level"]["used_pa_m"]) ** 2
    json.loads(done.stdout)
    return done, None


def said(done):
    """The one sentence of a refusal, with names of files left out."""
    support.assert_one_message(done, done.returncode)
    text = " ".join(support.text(done.stderr).split())
    if any(word.startswith("--focus") for word in done.args) and done.args[1] in ("inspect", "simulate"):
        assert re.search("not expected: --focus|source is required", text), text
        return "[These have no option --focus; compile --shape point makes an image of one.]"
    text = re.sub(r"^haptogram: (--)?[\w-]+: ", "", text)
    return re.sub(r"[\w-]+\.(json|csv|toml|hex)", "FILE", text)


def rows():
    for name, (file, modulated) in FILES.items():
        yield name, lambda wave, file=file: [file.format(wave)], modulated, WALL if name == "rig" else ONE
    yield "focal point", lambda _: ["--focus=5,-10,150"], False, ONE
    for name, file in PULSES.items():
        given = (f"{file}-{{0}}.csv", f"{file}-{{0}}.json")
        yield name, lambda wave, g=given: ["--pulses", g[0].format(wave), "--manifest", g[1].format(wave)], True, WALL if file == "wall" else ONE


def waves_of(name, modulated):
    """What is compiled first is one image after that, so the square alone tells whether its modulation arrives."""
    compiled_first = name in ("path", "project of shapes", "project of a path", "project of a hand")
    return ["none"] if not modulated else ["none", "square"] if compiled_first or "rig" in name else list(MODULATIONS)


def source_for(verb, source):
    """Pulses are the output of simulate and nothing to inspect or solve, so they are named as the file there."""
    return [source[1]] if source[0] == "--pulses" and verb in ("inspect", "simulate", "solve") else source


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """A focus without a waveform: as a path, a project, an image of foci, and its pulses."""
    tmp_path = tmp_path_factory.mktemp("few")
    (tmp_path / "point.xyz").write_text("{} {} {}\n".format(*ONE))
    (tmp_path / "path-none.json").write_text(path_json(ONE, "none"))
    (tmp_path / "shapes-none.toml").write_text('format = "haptogram-project-1"\narray = "tile-10x10"\nboard = "tile-100-wide"\nrate_hz = 200\n[[shape]]\nfile = "point.xyz"\n')
    support.succeed(["compile", "--path", "path-none.json", "--array", "tile-10x10", "--board", "tile-100-wide", "-o", "foci-none.hex"], cwd=tmp_path)
    support.succeed(["simulate", "foci-none.hex", "--passes", 3, "--pulses", "foci-none.csv"], cwd=tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def matrix(folder):
    """A cell each: "yes", or what the refusal says; and all pressures beside what they should be."""
    cells, pressures = {}, []
    whole = {z: ask(folder, "field", ["--focus={},{},{}".format(*at), *more], z)[1] for at, more in ((ONE, []), (WALL, ["--rig", "2x2"])) for z in (at[2],)}
    for name, source, modulated, focus in rows():
        for wave in waves_of(name, modulated):
            for verb in VERBS:
                if verb == "simulate" and name in ("rig", "image of timings", "image of amplitudes", "image of foci"):
                    cells[name, verb] = "yes"  # that is where the pulses come from
                    continue
                done, pressure = ask(folder, verb, source_for(verb, source(wave)), focus[2])
                cell = "yes" if done.returncode == support.OK else said(done)
                assert cells.setdefault((name, verb), cell) == cell, f"{name}, {verb}, {wave}"
                if pressure is not None and name != "project of a hand":
                    _, mean, left = MODULATIONS[wave]
                    wanted = whole[focus[2]] * mean * (left if verb == "feel" else 1.0)
                    pressures.append((f"{name}, {wave}, {verb}", pressure, wanted))
    return cells, pressures


MEASURED = ["--pulses", "foci-none.csv", "--manifest", "foci-none.json"]


def test_verbs_tell_the_same_pressure_of_a_focus(few):
    """The row and column of each that are quick; all of them, under each waveform, are deep."""
    whole = ask(few, "field", ["--focus={},{},{}".format(*ONE)], ONE[2])[1]
    for source in (["path-none.json"], ["shapes-none.toml"], ["foci-none.hex"], MEASURED):
        for verb in ("field", "feel") if source is MEASURED else ("field", "analyze", "feel"):
            done, pressure = ask(few, verb, source, ONE[2])
            assert done.returncode == support.OK and math.isclose(pressure, whole, rel_tol=0.025), (source, verb, support.text(done.stderr))


@pytest.mark.deep
def test_every_verb_tells_the_same_pressure(matrix):
    """However a focus is given, and whoever is asked: 2.5 % for the rounding of pulse lengths, and for skin that sound reaches at an angle."""
    _, pressures = matrix
    assert len(pressures) > 100
    wrong = [f"{what}: {found:.2f} Pa, expected {wanted:.2f}" for what, found, wanted in pressures if not math.isclose(found, wanted, rel_tol=0.025)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.deep
def test_the_table_in_the_docs(matrix):
    cells, _ = matrix
    notes = sorted({cell for cell in cells.values() if cell != "yes"})
    lines = ["| | " + " | ".join(VERBS) + " |", "|---" * (len(VERBS) + 1) + "|"]
    for told, alike in itertools.groupby((name for name, *_ in rows()), key=lambda name: [cells[name, verb] for verb in VERBS]):
        lines.append(f"| {', '.join(alike)} | " + " | ".join("yes" if cell == "yes" else f"({notes.index(cell) + 1})" for cell in told) + " |")
    table = "\n".join([*lines, "", *(f"{i}. {note}" for i, note in enumerate(notes, 1))])
    page = PAGE.read_text()
    marks = r"(?s)(<!-- matrix -->\n).*(<!-- end of matrix -->)"
    assert re.search(marks, page), "the page has no place for the table"
    made = re.sub(marks, lambda found: found[1] + table + "\n" + found[2], page)
    if os.environ.get("HAPTOGRAM_RECORD"):
        PAGE.write_text(made)
    assert PAGE.read_text() == made, "docs/sources.md is out of date: HAPTOGRAM_RECORD=1 writes it"


def test_one_record_of_what_was_measured(few):
    """The pressure of pulses of record 1 is that of the image's record 1; a record too many, or of a focus, is refused."""
    line = ["--line", "z@x=5,y=-10", "--z", "150:151"]
    asked = (["foci-none.hex"], MEASURED)
    image, measured = (float(support.succeed(["field", *what, "--record", 1, *line], cwd=few).stdout.split(b",")[-1].split()[-1]) for what in asked)
    assert math.isclose(image, measured, rel_tol=1e-3)
    support.refuse(few, ["field", *MEASURED, "--record", 9, *line], support.USAGE, outputs=())
    support.refuse(few, ["field", "--focus=0,0,150", "--record", 1, *line], support.USAGE, outputs=())
