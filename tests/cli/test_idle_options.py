# SPDX-License-Identifier: Apache-2.0
"""Each option of a command, with each thing that the command takes: it changes what comes out, or it is refused by its name."""
import json
import re

import pytest
import support

# An option's values, other than the default, in a form that every subject could have.
COMPILE = {
    "--diameter": ["33"], "--length": ["33"], "--height": ["33"], "--sides": ["7"], "--turns": ["5"], "--unit": ["cm"],
    "--points": ["23"], "--seed": ["5"], "--rate": ["31"], "--speed": ["3"], "--frequency": ["31"], "--jump": ["blank"],
    "--even": [], "--am": ["square:200"], "--amplitude": ["0.5"], "--magnitude": ["2", "--am", "square:200"], "--fade": ["left:0.5"],
    "--quantise": ["hoshi"], "--foci": [], "--loops": ["3"], "--center": ["0,1,140"], "--size": ["37"],
    "--rotate": ["10,20,30"], "--scale": ["0.9"], "--array": ["tile-7x8"],
}  # fmt: skip
CLOUD = "".join(f"{5 * (i % 7)},{7 * (i % 5)},{100 + i}\n" for i in range(35))
SUBJECTS = {
    "file": ["cloud.csv", "--points", "20"],
    "curves": ["--shape", "plus", "--points", "24"],
    "drawn": ["--shape", "plus", "--points", "24", "--speed", "2"],
    "surface": ["--shape", "sphere", "--points", "24"],
    "cone": ["--shape", "cone", "--points", "24"],
    "polygon": ["--shape", "polygon", "--points", "24"],
    "helix": ["--shape", "helix", "--points", "24"],
    "line": ["--shape", "line", "--points", "24"],
    "path": ["--path", "path.json"],
    "project": ["shapes.toml"],
    "project of a path": ["path.toml"],
    "project of a hand": ["hand.toml"],
    "project of grains": ["grains.toml"],
}
# What an option cannot change for a reason that only the points themselves tell: a surface is drawn along one tour without jumps, and
# curves are cut by their lengths, without chance.
BY_ITS_POINTS = {("--jump", "surface"), *(("--seed", name) for name in ("curves", "drawn", "polygon", "helix", "line", "project"))}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("idle")
    (folder / "cloud.csv").write_text(CLOUD)
    (folder / "shapes.toml").write_text('format = "haptogram-project-1"\npoints = 24\n[[shape]]\nkind = "circle"\n')
    hand = 'format = "haptogram-project-1"\npoints = 20\n{}[hand]\nrecording = "synthetic:press"\nobject = "sphere"\nframe = 150\nalgorithm = "{}"\n'
    (folder / "hand.toml").write_text(hand.format("", "A"))
    (folder / "grains.toml").write_text(hand.format("frequency_hz = 40\n", "E"))
    (folder / "path.toml").write_text('format = "haptogram-project-1"\npath = "path.json"\n')
    support.succeed(["compile", "--shape", "circle", "--points", 8, "--save-path", "path.json", "-o", "of-path.hex", "--records"], cwd=folder)
    return folder


def names(option, said):
    """Whether a message has the option's name as a word of its own, such as "--am" or "am", and not "amplitude"."""
    return re.search(rf"(?<![\w-])(--)?{option.lstrip('-')}(?![\w-])", said)


def compiled(folder, arguments):
    """What is written, but for the hash of all settings."""
    done = support.run(["compile", *arguments, "-o", "out.hex"], cwd=folder)
    if done.returncode:
        return None, support.text(done.stderr)
    manifest = json.loads((folder / "out.json").read_text())
    manifest.pop("inputs_sha256")
    return ((folder / "out.hex").read_bytes(), json.dumps(manifest)), ""


@pytest.mark.parametrize("subject", [subject if subject in ("file", "surface", "path", "project", "project of a hand") else pytest.param(subject, marks=pytest.mark.deep) for subject in SUBJECTS])
def test_compile(inputs, subject):
    plain, said = compiled(inputs, SUBJECTS[subject])
    assert plain, said
    for option, values in COMPILE.items():
        if option in SUBJECTS[subject]:
            continue
        base = plain
        if "--am" in values:  # it has an effect of its own
            base, _ = compiled(inputs, [*SUBJECTS[subject], "--am", "square:200"])
            if not base:
                continue
        found, said = compiled(inputs, [*SUBJECTS[subject], option, *values])
        if found:
            assert found != base or (option, subject) in BY_ITS_POINTS, f"{subject}: {option} changes nothing, and nothing is said"
        else:
            assert names(option, said), f"{subject}: {option} is refused by another name: {said}"


# Of each command: what it is given, and options that this has none of.
IDLE = {
    "render": [
        (["sphere", "--hand", "synthetic:press", "--algorithm", "A"],
         {"--corner": ["circle"], "--corner-radius": ["3"], "--corner-line": ["3"], "--corner-triangle": ["3"], "--off-skin": [], "--gap": ["5"],
          "--priority": ["finger"], "--solid-level": ["0.5"], "--two-foci": [], "--grain-spacing": ["5"], "--grain-length": ["5"],
          "--blob-finger": ["5"], "--blob-palm": ["5"], "--am-frequency": ["100"], "--wait": ["1"], "--press-radius": ["2"], "--press-foci": ["3"],
          "--seed": ["3"], "--hand-model": ["bones.json"], "--hand-rate": ["30"], "--height": ["50"], "--unit": ["cm"], "--points": ["30"]}),
        (["cube", "--hand", "synthetic:press", "--algorithm", "B"],
         {"--corner-radius": ["3"], "--corner-triangle": ["3"], "--seed": ["3"], "--gap": ["5"]}),
        (["cube", "--hand", "synthetic:press", "--algorithm", "H", "--priority", "finger"], {"--gap": ["5"]}),
    ],
    "movement": [
        (["line"], {"--turns": ["3"], "--hop": ["5"], "--seconds": ["2"], "--seed": ["3"]}),
        (["random"], {"--direction": ["3"], "--turns": ["3"], "--speed": ["0.2"], "--spacing": ["1"]}),
    ],
    "interact": [
        (["ball"], {"--rain": ["3"], "--drop": ["20"], "--creature": ["20"]}),
        (["rain"], {"--ball-height": ["50"], "--ball-contact": ["20"], "--creature": ["20"]}),
        (["ball", "--hand", "marker.csv"], {"--noise": ["1"], "--seed": ["3"]}),
    ],
}  # fmt: skip


@pytest.mark.parametrize("command", IDLE)
def test_what_has_no_effect_is_named(tmp_path, command):
    for given, options in IDLE[command]:
        for option, values in options.items():
            done = support.run([command, *given, option, *values, "-o", "out.json"], cwd=tmp_path)
            assert done.returncode == support.USAGE and names(option, support.text(done.stderr)), f"{command} {given} {option}: {done.stderr}"
            assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize(
    "command",
    [
        ["live", "--from", "fingers:press", "--port", "none", "--algorithm", "still", "--press-radius", "3"],
        ["live", "--from", "fingers:press", "--port", "none", "--predict", "none", "--latency", "20"],
        ["field", "--focus", "0,0,150", "--below", "3", "-o", "f.csv"],
        ["analyze", "--array", "tile-10x10", "--json"],
        ["analyze", "--focus", "0,0,150", "--measured-mn", "2", "--json"],
        ["simulate", "of-path.hex", "--drift-ppm", "3"],
    ],
)
def test_what_has_no_effect_elsewhere(inputs, command):
    support.refuse(inputs, command, support.USAGE, outputs=())
