# SPDX-License-Identifier: Apache-2.0
"""What people bring: forms of files that other programs write, each read as what it is, or refused in one sentence.

HAPTOGRAM_RECORD=1 writes the list of forms in docs/sources.md anew; otherwise it must be what comes out here.
"""
import json
import math
import os
import re
import struct

import numpy as np
import pytest
from brought_shapes import gltf, mesh_xml, model_xml, pcd, svg, three_mf
from messages import notice
from support import BAD_INPUT, OK, ROOT, USAGE, assert_one_message, foci_mm, read_json, refuse, run, succeed, text

PAGE = ROOT / "docs/sources.md"
RING = [(20 * math.cos(math.pi * k / 30), 20 * math.sin(math.pi * k / 30), 130.0) for k in range(60)]
BOM = "\ufeff"


def rows(points=RING, separator=" ", before=""):
    return "".join(before + separator.join(f"{number:.6f}" for number in point) + "\n" for point in points)


def numbered(points=RING):
    return "".join(f"{n} {x:.6f} {y:.6f} {z:.6f}\n" for n, (x, y, z) in enumerate(points, 1))


def vertices(points=RING):
    return rows(points, before="v ")


SQUARE = [(-20, -20, 130), (20, -20, 130), (20, 20, 130), (-20, 20, 130)]
OUTLINE = "l " + " ".join(map(str, [*range(1, 61), 1])) + "\n"
DOME = vertices([(0.04 * x / 20, 0.04 * y / 20, 0.13) for x, y, _ in RING])


def number(value, kind="f64"):
    return {"type": kind, "value": value}


def pattern(intensity=None, jumps=(), frames=2, radius=5.0):
    """A pattern of the AdapTics designer: a circle that goes 40 mm in half a second."""
    step = {"name": "linear", "params": {}}
    first = {
        "time": 0,
        "type": "standard",
        "coords": {"coords": {"x": -20, "y": 0, "z": 0}, "transition": step},
        "intensity": {"intensity": {"name": "constant", "params": {"value": intensity or number(0.8)}}, "transition": step},
        "brush": {"brush": {"name": "circle", "params": {"radius": number(radius), "am_freq": number(0)}}, "transition": step},
        "cjumps": [],
    }
    last = {"time": 500, "type": "standard", "coords": {"coords": {"x": 20, "y": 0, "z": 0}, "transition": step}, "cjumps": list(jumps)}
    axes = {axis: number(1) for axis in "xyz"}
    place = {"x": number(0), "y": number(0), "z": number(130)}
    whole = {
        "$DATA_FORMAT": "MidAirHapticsAnimationFileFormat",
        "$REVISION": "0.1.0-alpha.3",
        "name": "ours",
        "keyframes": [first, last][:frames],
        "pattern_transform": {"geometric_transforms": {"translate": place, "rotation": number(0), "scale": axes}, "intensity_factor": number(1), "playback_speed": number(1)},
        "user_parameter_definitions": {"push": {"default": 0.8, "min": 0, "max": 1, "step": 0.05}},
    }
    return json.dumps(whole)


PUSH = number("push", "param")
HALF = number({"type": "multiply", "value": [{"type": "parameter", "value": "push"}, {"type": "constant", "value": 0.5}]}, "formula")
JUMP = {"condition": {"parameter": "push", "value": 0.5, "operator": {"name": "gt", "params": {}}}, "jump_to": 0}

PART = f'<object id="1">{mesh_xml([(x / 10, y / 10, 0.0) for x, y, _ in SQUARE], [(0, 1, 2), (0, 2, 3)])}</object><object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 13"/></components></object>'
LYING = [(x * 1e-3, 0.13, -y * 1e-3) for x, y, _ in SQUARE]

# A form, the file that shows it, and what it is read as.
FORMS = {
    "unseen pixels of a depth camera: (0, 0, 0)": ("scan.xyz", "0 0 0\n" * 200 + rows(), "the ring"),
    "unseen pixels of a depth camera: NaN": ("scan.xyz", "nan nan nan\n" * 20 + rows(), "the ring"),
    "a first column that counts": ("cloud.xyz", numbered([(x, y + 130, 30.0) for x, y, _ in RING]), "points"),
    "named columns, the first of which counts": ("cloud.xyz", "n x y z\n" + numbered(), "the ring"),
    "a first line that counts the rows": ("cloud.xyz", "60\n" + rows(), "the ring"),
    "column names behind `//`": ("cloud.xyz", "//X Y Z\n" + rows(), "the ring"),
    "commas in .xyz": ("cloud.xyz", rows(separator=","), "the ring"),
    "a byte order mark": ("cloud.obj", BOM + vertices(), "the ring"),
    "decimal commas behind semicolons": ("cloud.csv", "x;y;z\n" + rows(separator=";").replace(".", ","), "the ring"),
    "a first line `sep=;`": ("cloud.csv", "sep=;\nx;y;z\n" + rows(separator=";"), "the ring"),
    "column names x_mm, y_mm, z_mm": ("cloud.csv", "x_mm,y_mm,z_mm\n" + rows(separator=","), "the ring"),
    "column names Points:0 to Points:2": ("cloud.csv", '"Points:0","Points:1","Points:2"\n' + rows(separator=","), "the ring"),
    "OBJ: statements that change nothing": ("cloud.obj", "lod 1\nbevel on\n" + vertices() + "p 1 2\nshadow_obj a\n", "the ring"),
    "OBJ: faces before vertices": ("square.obj", "f 1 2 3 4\n" + vertices(SQUARE), "points"),
    "OBJ: lines alone": ("outline.obj", vertices() + OUTLINE, "a curve"),
    "OBJ: lines beside faces": ("square.obj", vertices(SQUARE) + "f 1 2 3 4\nl 1 3\n", "points"),
    "a shape in metres": ("metres.obj", DOME, "points"),
    "a table of t, x, y, z": ("table.csv", "t,x,y,z\n0,0,0,130\n0.01,5,0,130\n", "nothing"),
    "milliseconds since 1970 as time_s": ("table.csv", "time_s,x_mm,y_mm,z_mm\n1700000000000,0,0,130\n1700000000010,5,0,130\n", "nothing"),
    "AdapTics: a parameter": ("pattern.adaptics", pattern(PUSH), "a path"),
    "AdapTics: a formula": ("pattern.adaptics", pattern(HALF), "a path"),
    "AdapTics: a jump to time 0": ("pattern.adaptics", pattern(jumps=[JUMP]), "a path"),
    "AdapTics: a jump elsewhere": ("pattern.adaptics", pattern(jumps=[{**JUMP, "jump_to": 100}]), "nothing"),
    "AdapTics: a template of one key frame": ("pattern.adaptics", pattern(frames=1), "a path"),
    "OFF": ("square.off", "OFF\n4 1 0\n" + rows(SQUARE) + "4 0 1 2 3\n", "points"),
    "PCD, ascii": ("scan.pcd", pcd(RING), "the ring"),
    "PCD, binary": ("scan.pcd", pcd(RING, "binary"), "the ring"),
    "PCD, binary_compressed": ("scan.pcd", pcd(RING, "binary_compressed"), "the ring"),
    "PCD, organised, with unseen pixels": ("scan.pcd", pcd([(math.nan,) * 3] * 20 + RING, "binary", width=40), "the ring"),
    "3MF: components, transforms, units": ("square.3mf", three_mf(model_xml(PART, '<item objectid="2"/>', "centimeter")), "points"),
    "glTF": ("square.gltf", gltf(LYING, [0, 1, 2, 0, 2, 3])[0], "points"),
    "GLB": ("square.glb", gltf(LYING, [0, 1, 2, 0, 2, 3], "glb")[0], "points"),
    "glTF without its buffer's file": ("square.gltf", gltf(LYING, [0, 1, 2, 0, 2, 3], "square.bin")[0], "nothing"),
    "SVG": ("ring.svg", svg('<g transform="scale(2)"><circle cx="25" cy="25" r="10"/></g>'), "a curve"),
    "SVG without a size in mm": ("ring.svg", svg('<path d="M30,50a20 20 0 1 1 40 0 20 20 0 1 1-40 0z"/>', 'viewBox="0 0 100 100"'), "points"),
    "SVG of text alone": ("ring.svg", svg("<text>words</text>"), "nothing"),
    "STEP, and all other formats": ("shape.step", "ISO-10303-21;", "nothing"),
}  # fmt: skip


def bring(folder, form, *options):
    name, content, _ = FORMS[form]
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    if FORMS[form][2] == "a curve" or name.endswith(".svg"):
        options = ("--frequency", 100, *options)
    if form == "a shape in metres":
        options = ("--center", "0,0,130", *options)
    return run(["compile", name, *options, "-o", "image.hex"], cwd=folder)


def said(done):
    told = " ".join(text(done.stderr).split())
    return re.sub(r"^haptogram: (compile: )?", "", told).replace("haptogram: ", "")


def table(cells):
    """The forms by what becomes of them, a line each."""
    told = {"Read": [], "Read, with a warning": [], "Refused, with a message that says what to do": []}
    for form, (kind, words) in cells.items():
        what = "Refused, with a message that says what to do" if kind == "nothing" else "Read, with a warning" if words else "Read"
        told[what].append(form)
    return "".join(f"- **{what}**: {'; '.join(forms)}\n" for what, forms in told.items())


def test_every_form_is_read_as_what_it_is_or_refused(tmp_path):
    cells = {}
    for form, (_, _, kind) in FORMS.items():
        done = bring(tmp_path, form)
        if kind == "nothing":
            assert_one_message(done, BAD_INPUT)
        else:
            assert done.returncode == OK, (form, text(done.stderr))
            foci = np.array(foci_mm(read_json(tmp_path / "image.json")))
            if kind == "the ring":
                assert len(foci) == 60 and np.allclose(np.sort(foci.T), np.sort(np.array(RING).T), atol=1e-5), form
            elif kind == "a curve":
                assert np.allclose(np.hypot(*foci.T[:2]), 20, atol=0.06) and np.allclose(foci.T[2], 130), form
        # A warning that other shapes get, too, says nothing of the form.
        cells[form] = kind, " ".join(line for line in said(done).split("warning: ") if "reach its full pressure" not in line).strip()
    begin, end = "<!-- forms -->\n", "<!-- end of forms -->\n"
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(begin)
    wanted = before + begin + table(cells) + end + rest.split(end)[1]
    if os.environ.get("HAPTOGRAM_RECORD"):
        PAGE.write_text(wanted, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == wanted, "HAPTOGRAM_RECORD=1 writes the list anew"


@pytest.mark.parametrize("form", [form for form in FORMS if form.startswith(("unseen", "a first column", "OBJ: lines beside", "a shape in"))])
def test_what_is_odd_about_a_form_is_told(form, tmp_path):
    done = bring(tmp_path, form)
    assert done.returncode == OK
    notice(done.stderr)


def test_a_speck_is_told_of_unless_its_size_is_given(tmp_path):
    (tmp_path / "dome.obj").write_text(DOME)
    centre = ["--center", "0,0,130"]
    for options, words in (([], b"--unit m?"), (["--unit", "inch"], None), (["--unit", "m"], None), (["--size", "40"], None), (["--scale", "900"], None)):
        done = succeed(["compile", "dome.obj", *centre, *options, "-o", "image.hex"], cwd=tmp_path)
        assert (b"mm wide" in done.stderr) == (words is not None) and (words is None or words in done.stderr), options
    (tmp_path / "inches.xyz").write_text(rows([(x / 25.4, y / 25.4, z / 25.4) for x, y, z in RING]))
    done = succeed(["compile", "inches.xyz", *centre, "-o", "image.hex"], cwd=tmp_path)
    assert b"--unit cm or --unit inch?" in done.stderr
    for unit in ("inch", "in"):
        succeed(["compile", "inches.xyz", "--unit", unit, "-o", "image.hex"], cwd=tmp_path)
    assert np.allclose(np.hypot(*np.array(foci_mm(read_json(tmp_path / "image.json"))).T[:2]), 20, atol=1e-4)
    assert b"circle: it is 0.04 mm wide" in succeed(["compile", "--shape", "circle", "--diameter", "0.04", "-o", "speck.hex"], cwd=tmp_path).stderr


def test_an_image_is_no_shape(tmp_path):
    succeed(["compile", "--shape", "point", "-o", "image.hex"], cwd=tmp_path)
    refuse(tmp_path, ["compile", "image.hex", "-o", "again.hex"], BAD_INPUT)
    assert b"is an image" in run(["compile", "image.hex", "-o", "again.hex"], cwd=tmp_path).stderr


def image_of(folder, *args):
    succeed(["compile", *args, "-o", "image.hex"], cwd=folder)
    return (folder / "image.hex").read_bytes()


def test_a_path_is_an_input_as_any_other(tmp_path):
    (tmp_path / "p.adaptics").write_text(pattern(PUSH))
    (tmp_path / "p.csv").write_text("time_ms,x_mm,y_mm,z_mm\n0,0,0,130\n5,10,0,130\n")
    image_of(tmp_path, "p.csv", "--save-path", "p.json")
    for name in ("p.adaptics", "p.csv", "p.json"):
        assert image_of(tmp_path, name) == image_of(tmp_path, "--path", name), name
    (tmp_path / "ring.xyz").write_text(rows())
    refuse(tmp_path, ["compile", "p.csv", "p.json", "-o", "no.hex"], USAGE, outputs=["no.hex"])
    refuse(tmp_path, ["compile", "p.csv", "--path", "p.json", "-o", "no.hex"], USAGE, outputs=["no.hex"])
    refuse(tmp_path, ["compile", "p.csv", "ring.xyz", "-o", "no.hex"], USAGE, outputs=["no.hex"])


def test_parameters_of_a_pattern_are_set(tmp_path):
    (tmp_path / "p.adaptics").write_text(pattern(PUSH))
    (tmp_path / "half.adaptics").write_text(pattern(HALF))
    (tmp_path / "weak.adaptics").write_text(pattern(number(0.4)))
    weak = image_of(tmp_path, "weak.adaptics")
    assert image_of(tmp_path, "half.adaptics") == weak
    assert image_of(tmp_path, "p.adaptics", "--set", "push=0.4") == weak
    assert image_of(tmp_path, "p.adaptics") == image_of(tmp_path, "p.adaptics", "--set", "push=0.8")
    (tmp_path / "p.toml").write_text('format = "haptogram-project-1"\npath = "p.adaptics"\nset = "push=0.4"\n')
    assert image_of(tmp_path, "p.toml") == weak
    for given, code in (("pull=0.4", BAD_INPUT), ("push=2", BAD_INPUT), ("push", USAGE), ("push=0.1,push=0.2", USAGE)):
        refuse(tmp_path, ["compile", "p.adaptics", "--set", given, "-o", "no.hex"], code, outputs=["no.hex"])
    (tmp_path / "ring.xyz").write_text(rows())
    refuse(tmp_path, ["compile", "ring.xyz", "--set", "push=1", "-o", "no.hex"], USAGE, outputs=["no.hex"])


def test_a_sound_that_is_too_long_says_how_long_it_may_be(tmp_path):
    data = struct.pack("<12000h", *[int(20000 * math.sin(0.1 * k)) for k in range(12000)])
    fmt = struct.pack("<4sIHHIIHH", b"fmt ", 16, 1, 1, 4000, 8000, 2, 16)

    def wav(part):
        return b"RIFF" + struct.pack("<I", 36 + len(part)) + b"WAVE" + fmt + b"data" + struct.pack("<I", len(part)) + part

    (tmp_path / "long.wav").write_bytes(wav(data))
    refuse(tmp_path, ["compile", "--shape", "point", "--am", "wav:long.wav", "--array", "tile-10x10", "--board", "tile-100-wide", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])
    # A board without a memory for modulation plays it as sequence entries.
    (tmp_path / "short.wav").write_bytes(wav(data[:2000]))
    image_of(tmp_path, "--shape", "point", "--am", "wav:short.wav")
    refuse(tmp_path, ["compile", "--shape", "point", "--am", "wav:long.wav", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])
