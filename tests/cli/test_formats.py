# SPDX-License-Identifier: Apache-2.0
"""PCD, 3MF, glTF and SVG files are read as what they are: the same foci as an OBJ file of the same shape, worked out here."""
import itertools
import json
import math
import struct

import numpy as np
import pytest
from brought_shapes import CORE, RELATIONS, gltf, mesh_xml, model_xml, pcd, svg, three_mf
from messages import notice
from support import BAD_INPUT, USAGE, foci_mm, read_json, refuse, run, succeed

RING = [(20 * math.cos(math.pi * k / 30), 20 * math.sin(math.pi * k / 30), 130.0) for k in range(60)]
# A roof with a front and a back that differ, so that no turn or mirror image of it is the same.
ROOF = np.array([(-20, -15, 120), (20, -15, 120), (25, 15, 120), (-20, 15, 120), (0, -5, 135)], dtype=float)
FACES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]


def foci(folder, name, *options):
    succeed(["compile", name, "-o", "image.hex", *options], cwd=folder)
    return np.array(foci_mm(read_json(folder / "image.json")))


def roof(folder, points=ROOF, faces=FACES):
    text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in np.asarray(points).tolist()) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
    (folder / "wanted.obj").write_text(text)
    return foci(folder, "wanted.obj")


def alike(folder, name, content, wanted, *options):
    (folder / name).write_bytes(content)
    found = foci(folder, name, *options)
    assert found.shape == wanted.shape and np.allclose(found, wanted, atol=1e-3), name


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("kind", ["f", "d"])
@pytest.mark.parametrize("extra", [False, True])
def test_pcd(tmp_path, data, kind, extra):
    (tmp_path / "ring.pcd").write_bytes(pcd(RING, data, extra=extra, kind=kind))
    assert np.allclose(np.sort(foci(tmp_path, "ring.pcd").T), np.sort(np.array(RING).T), atol=1e-5)


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("unseen", [math.nan, 0.0])
def test_pcd_of_a_depth_camera(tmp_path, data, unseen):
    (tmp_path / "scan.pcd").write_bytes(pcd([(unseen,) * 3] * 20 + RING, data, width=40))
    done = succeed(["compile", "scan.pcd", "-o", "image.hex"], cwd=tmp_path)
    notice(done.stderr)
    assert b"20 " in done.stderr and len(foci_mm(read_json(tmp_path / "image.json"))) == 60


def test_pcd_that_is_wrong(tmp_path):
    good = pcd(RING, "binary_compressed")
    text = pcd(RING).decode()
    wrong = [good[:-1], good[:40], good.replace(b"binary_compressed", b"zipped"), pcd(RING, "binary") + b"x", pcd(RING, "binary")[:-1], text[: text.rindex(" ")].encode(),
             text.replace("POINTS 60", "POINTS 61").encode(), text.replace("FIELDS x y", "FIELDS x w").encode(), text.replace("F F U F", "F F U Q").encode(), text.encode() + b"1 2 3 4\n",
             text.replace("SIZE 4 4 4 4", "SIZE 3 4 4 4").encode(), text.replace("130\n", "nan\n", 1).encode(), text.replace("130\n", "130 7\n", 1).encode(), b"# .PCD v0.7\n", b"",
             text.replace("WIDTH 60", "WIDTH 4294967295").replace("HEIGHT 1", "HEIGHT 4294967295").replace("POINTS 60\n", "").encode()]  # fmt: skip
    for content in wrong:
        (tmp_path / "cloud.pcd").write_bytes(content)
        refuse(tmp_path, ["compile", "cloud.pcd", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])


def turn_of(matrix):
    """A 4 x 3 matrix as 3MF writes it, for row vectors."""
    return " ".join(repr(float(number)) for number in np.asarray(matrix).T.reshape(-1))


def affine(turn_deg, scale, shift):
    angle = math.radians(turn_deg)
    return np.column_stack([np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]) * scale, shift])


def moved(matrix, points):
    return np.asarray(points) @ matrix[:, :3].T + matrix[:, 3]


@pytest.mark.parametrize("unit, mm", [("micron", 1e-3), ("millimeter", 1), ("centimeter", 10), ("inch", 25.4), ("foot", 304.8), ("meter", 1000)])
def test_3mf_parts_are_where_they_are_built(tmp_path, unit, mm):
    inner, outer, item = affine(90, 0.5, [3, 4, 0]), affine(-30, 1.5, [0, 5, -20]), affine(180, 1, [0, 0, 30])
    objects = (f'<object id="1" type="model">{mesh_xml((ROOF / mm).tolist(), FACES)}</object>'
               f'<object id="2"><components><component objectid="1" transform="{turn_of(in_unit(inner, mm))}"/><component objectid="1"/></components></object>'
               f'<object id="3"><components><component objectid="2" transform="{turn_of(in_unit(outer, mm))}"/></components></object>')  # fmt: skip
    model = model_xml(objects + '<object id="9"><mesh><vertices/><triangles/></mesh></object>', f'<item objectid="3" transform="{turn_of(in_unit(item, mm))}"/>', unit)
    wanted = [moved(item, moved(outer, part)) for part in (moved(inner, ROOF), ROOF)]
    alike(tmp_path, "roof.3mf", three_mf(model), roof(tmp_path, np.concatenate(wanted), FACES + [tuple(5 + k for k in face) for face in FACES]))


def in_unit(matrix, mm):
    return np.column_stack([matrix[:, :3], matrix[:, 3] / mm])


def test_3mf_of_several_files_and_a_mirror_image(tmp_path):
    mirror = np.array([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], dtype=float)
    production = 'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" requiredextensions="p"'
    part = model_xml(f'<object id="7">{mesh_xml(ROOF.tolist(), FACES)}</object>', "")
    model = model_xml('<object id="1"><components><component p:path="/3D/Objects/part.model" objectid="7"/></components></object>', f'<item objectid="1" transform="{turn_of(mirror)}"/>', more=production)
    wanted = roof(tmp_path, moved(mirror, ROOF), [(a, c, b) for a, b, c in FACES])
    for relations in (RELATIONS, None):  # which say where the model is; where all programs put it, it is found without
        alike(tmp_path, "roof.3mf", three_mf(model, [("3D/Objects/part.model", part)], relations), wanted)


def test_3mf_that_is_wrong(tmp_path):
    thing = f'<object id="1">{mesh_xml(ROOF.tolist(), FACES)}</object>'
    item = '<item objectid="1"/>'
    good = three_mf(model_xml(thing, item))
    bomb = "".join(f'<object id="{k}"><components>{f"""<component objectid="{k + 1}"/>""" * 10}</components></object>' for k in range(1, 9)) + thing.replace('"1"', '"9"', 1)
    loop = '<object id="1"><components><component objectid="1"/></components></object>'
    more = 'xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" requiredextensions="b"'
    models = [model_xml(thing, '<item objectid="2"/>'), model_xml(thing, ""), model_xml(thing, item, "parsec"), model_xml(loop, item), model_xml(bomb, item), model_xml(thing, item, more=more),
              model_xml(thing.replace('v1="0"', 'v1="5"', 1), item), model_xml(thing.replace('x="-20.0"', 'x="nan"', 1), item), model_xml(thing, '<item objectid="1" transform="1 0 0"/>'),
              model_xml(thing, '<item objectid="1" transform="1e9 0 0 0 1e9 0 0 0 1e9 1e12 0 0"/>'), "<a><b></a>", "<svg/>", "", None, f"<model {CORE}>" + "<a>" * 100 + "</a>" * 100 + "</model>"]  # fmt: skip
    contents = [three_mf(model) for model in models] + [good[:-30], good[:30], b"PK", three_mf(None, relations=None), three_mf(model_xml(thing, item), relations="<a/>"),
                                                        three_mf(model_xml(thing, item + " " * 60_000_000))]  # fmt: skip
    for content in contents:
        (tmp_path / "part.3mf").write_bytes(content)
        refuse(tmp_path, ["compile", "part.3mf", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])
    (tmp_path / "part.3mf").write_bytes(good)
    refuse(tmp_path, ["compile", "part.3mf", "--unit", "m", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])


def y_up(points):
    """Of our mm the coordinates of glTF: metres, y up."""
    x, y, z = np.asarray(points, dtype=float).T * 1e-3
    return np.column_stack([x, z, -y])


CORNERS = list(itertools.chain(*FACES))


@pytest.mark.parametrize("buffer", ["embedded", "glb", "roof.bin"])
@pytest.mark.parametrize("kind", ["B", "H", "I"])
def test_gltf(tmp_path, buffer, kind):
    content, beside = gltf(y_up(ROOF).tolist(), CORNERS, buffer, kind=kind)
    if buffer == "roof.bin":
        (tmp_path / buffer).write_bytes(beside)
    name = "roof.glb" if buffer == "glb" else "roof.gltf"
    alike(tmp_path, name, content, roof(tmp_path), "--up", "y")
    notice(succeed(["compile", name, "-o", "image.hex"], cwd=tmp_path).stderr)
    refuse(tmp_path, ["compile", name, "--up", "z", "-o", "no.hex"], USAGE, outputs=["no.hex"])


@pytest.mark.parametrize("mode, corners", [(4, CORNERS), (5, [0, 1, 4, 2, 3]), (6, [4, 0, 1, 2, 3, 0])])
def test_gltf_of_strips_and_fans(tmp_path, mode, corners):
    faces = {4: FACES, 5: [(0, 1, 4), (1, 2, 4), (4, 2, 3)], 6: [(4, 0, 1), (4, 1, 2), (4, 2, 3), (4, 3, 0)]}[mode]
    alike(tmp_path, "roof.glb", gltf(y_up(ROOF).tolist(), corners, "glb", mode)[0], roof(tmp_path, faces=faces))


def test_gltf_nodes_turn_scale_and_shift(tmp_path):
    half = math.sqrt(0.5)
    nodes = [{"children": [1], "translation": [0.005, 0.02, 0], "rotation": [0, half, 0, half], "scale": [0.5, 0.5, 0.5]},
             {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, -2, 0, 0, -0.13, 0.01, 1]}]  # fmt: skip
    points = y_up(ROOF) * [2, 2, -2] + [0, -0.13, 0.01]
    points = 0.5 * points @ np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], dtype=float).T + [0.005, 0.02, 0]  # a quarter turn about y
    x, y, z = 1e3 * points.T
    alike(tmp_path, "roof.gltf", gltf(y_up(ROOF).tolist(), CORNERS, nodes=nodes)[0], roof(tmp_path, np.column_stack([x, -z, y]), [(a, c, b) for a, b, c in FACES]))


@pytest.mark.parametrize("mode, closed", [(2, True), (3, False), (1, True)])
def test_gltf_of_lines_is_curves(tmp_path, mode, closed):
    corners = [0, 1, 1, 2, 2, 0] if mode == 1 else None
    (tmp_path / "lines.glb").write_bytes(gltf(y_up([(-20, 0, 130), (20, 0, 130), (0, 20, 130)]).tolist(), corners, "glb", mode)[0])
    (tmp_path / "wanted.obj").write_text("v -20 0 130\nv 20 0 130\nv 0 20 130\n" + ("l 1 2 3 1\n" if closed else "l 1 2 3\n"))
    pace = ["--frequency", "100"]
    assert np.allclose(foci(tmp_path, "lines.glb", *pace), foci(tmp_path, "wanted.obj", *pace), atol=1e-4)


def test_gltf_that_is_wrong(tmp_path):
    good = json.loads(gltf(y_up(ROOF).tolist(), CORNERS)[0])

    def changed(**members):
        return json.dumps({**good, **members}).encode()

    def deeper(path, value):
        document = json.loads(json.dumps(good))
        at = document
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = value
        return json.dumps(document).encode()

    bare = {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}
    glb = gltf(y_up(ROOF).tolist(), CORNERS, "glb")[0]
    deep = [{"children": [k + 1]} for k in range(500)] + [{"mesh": 0}]
    wrong = [changed(asset={"version": "1.0"}), changed(extensionsRequired=["KHR_draco_mesh_compression"]), changed(extensionsUsed=["EXT_mesh_gpu_instancing"]), changed(scene=1), changed(nodes=[{}]),
             changed(nodes=[{"children": [0]}]), changed(nodes=[{"children": [1, 1]}, {"mesh": 0}]), changed(nodes=deep), changed(nodes=[{"mesh": 0, "rotation": [0, 0, 0, 0]}]),
             changed(nodes=[{"mesh": 0, "scale": [1, 2]}]), changed(nodes=[{"mesh": 0, "matrix": [1] * 16}]), changed(nodes=[{"mesh": 0, "translation": [1e12, 0, 0], "scale": [1e12, 1, 1]}]),
             deeper(["accessors", 0, "count"], 6), deeper(["accessors", 0, "componentType"], 5124), deeper(["accessors", 0, "sparse"], {}), deeper(["accessors", 1, "count"], 11),
             deeper(["accessors", 0, "type"], "VEC4"), deeper(["bufferViews", 0, "byteStride"], 4), deeper(["bufferViews", 1, "byteOffset"], 2**31), deeper(["bufferViews", 1, "byteOffset"], 0),
             deeper(["buffers", 0, "byteLength"], 2**31), deeper(["buffers", 0, "uri"], "data:;base64,####"), deeper(["buffers", 0, "uri"], "../roof.bin"), deeper(["buffers", 0, "uri"], "/etc/passwd"),
             deeper(["buffers", 0, "uri"], "none.bin"), deeper(["buffers", 0, "uri"], "%2e%2e/roof.bin"), deeper(["meshes", 0, "primitives", 0, "mode"], 7), deeper(["meshes", 0, "primitives", 0, "indices"], 7),
             glb[:-1], glb[:30], glb[:4] + struct.pack("<I", 1) + glb[8:], json.dumps(bare).encode(), b"{}", b"glTF", b"[]", b"{"]  # fmt: skip
    for content in wrong:
        (tmp_path / "part.gltf").write_bytes(content)
        refuse(tmp_path, ["compile", "part.gltf", "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])
    done = through(run, tmp_path, deeper(["buffers", 0, "uri"], "roof.bin"), "-o", "none.hex")
    assert done.returncode == BAD_INPUT and not (tmp_path / "none.hex").exists()


PACE = ["--frequency", "100"]


def drawn(folder, content, *options, size='width="100mm" height="100mm" viewBox="0 0 100 100"'):
    """The foci of a drawing, whose middle is at (0, 0, 130) mm."""
    (folder / "drawing.svg").write_bytes(svg(content, size))
    return foci(folder, "drawing.svg", *PACE, *options)


CIRCLES = {
    "a circle": '<circle cx="50" cy="50" r="20"/>',
    "an ellipse": '<ellipse cx="50" cy="50" rx="20" ry="20"/>',
    "arcs": '<path d="M30,50a20 20 0 1 1 40 0a20 20 0 1140-0z"/>'.replace("1140-0", "1 1-40 0"),
    "arcs whose flags stand together": '<path d="M30,50a20 20 0 1140 0 20 20 0 11-40 0z"/>',
    "a turned and stretched circle": '<g transform="translate(50 50) rotate(30)"><circle r="10" transform="scale(2)"/></g>',
    "a matrix": '<circle r="1" transform="matrix(0 20 -20 0 50 50)"/>',
    "a rectangle of round corners": '<rect x="30" y="30" width="40" height="40" rx="20"/>',
    "one that is used": '<defs><circle id="c" r="20"/></defs><use href="#c" x="50" y="50"/>',
    "one that is used by its old name": '<defs><circle id="c" r="20"/></defs><use xlink:href="#c" transform="translate(50,50)"/>',
    "a symbol": '<symbol id="c" viewBox="-1 -1 2 2"><circle r="1"/></symbol><use href="#c" x="30" y="30" width="40" height="40"/>',
    "a drawing within": '<svg x="30" y="30" width="40" height="40" viewBox="0 0 2 2"><circle cx="1" cy="1" r="1"/></svg>',
    "units": '<circle cx="50" cy="50" r="20" style="fill:none;stroke:#000"/>',
    "skewed back and forth": '<g transform="skewX(20) skewX(-20) skewY(10) skewY(-10)"><circle r="20"/></g>',
}


@pytest.mark.parametrize("content", CIRCLES.values(), ids=CIRCLES)
def test_svg_circles_are_drawn_as_our_own(tmp_path, content):
    found = drawn(tmp_path, content)
    assert np.abs(np.hypot(*found.T[:2]) - 20).max() < 2e-3 and np.all(found[:, 2] == 130)
    (tmp_path / "ours").mkdir()
    succeed(["compile", "--shape", "circle", "--diameter", "40", *PACE, "-o", "image.hex"], cwd=tmp_path / "ours")
    ours = np.array(foci_mm(read_json(tmp_path / "ours/image.json")))
    step = np.linalg.norm(np.diff(ours, axis=0), axis=1)
    assert len(found) == len(ours) and np.allclose(np.linalg.norm(np.diff(found, axis=0), axis=1), step.mean(), atol=2e-3)


@pytest.mark.parametrize("size, mm", [('width="100mm" height="100mm" viewBox="0 0 100 100"', 1), ('width="10cm" height="100mm" viewBox="0 0 50 50"', 2), ('width="4in" viewBox="0 0 101.6 101.6"', 1),
                                      ('width="100" height="100"', 25.4 / 96), ('viewBox="0 0 100 100"', 25.4 / 96), ('width="72pt" height="72pt" viewBox="0 0 254 254"', 0.1),
                                      ('width="100mm" height="200mm" viewBox="0 0 100 100" preserveAspectRatio="xMinYMax slice"', 2)])  # fmt: skip
def test_svg_units(tmp_path, size, mm):
    found = drawn(tmp_path, '<circle cx="50" cy="50" r="20"/>', size=size)
    assert np.abs(np.hypot(*found.T[:2]) - 20 * mm).max() < 2e-3 * mm


def bezier(*points):
    points, t = [np.array(p, dtype=float) for p in points], np.linspace(0, 1, 4001)[:, None]
    while len(points) > 1:
        points = [(1 - t) * a + t * b for a, b in itertools.pairwise(points)]
    return points[0]


def polyline(*points):
    t = np.linspace(0, 1, 4001)[:, None]
    return np.concatenate([(1 - t) * np.array(a, dtype=float) + t * np.array(b, dtype=float) for a, b in itertools.pairwise(points)])


PATHS = {
    "C": ('M10 40C20 0 60 0 70 60', bezier((10, 40), (20, 0), (60, 0), (70, 60))),
    "c and s": ('m10 40c10 -40 30 -40 40 0s30 40 40 0', np.concatenate([bezier((10, 40), (20, 0), (40, 0), (50, 40)), bezier((50, 40), (60, 80), (80, 80), (90, 40))])),
    "S alone": ('M10 40S40 0 50 40', bezier((10, 40), (10, 40), (40, 0), (50, 40))),
    "Q and T": ('M10,40Q30,0,50,40T90,40', np.concatenate([bezier((10, 40), (30, 0), (50, 40)), bezier((50, 40), (70, 80), (90, 40))])),
    "q and t": ('M10-.0q20 40 40 0t40,0', np.concatenate([bezier((10, 0), (30, 40), (50, 0)), bezier((50, 0), (70, -40), (90, 0))])),
    "H V h v l": ('M10 10H50V40h-20v10l-10-5', polyline((10, 10), (50, 10), (50, 40), (30, 40), (30, 50), (20, 45))),
    "pairs behind M": ('M10 10 50 10 50 50', polyline((10, 10), (50, 10), (50, 50))),
    "pairs behind m": ('m10 10 40 0 0 40', polyline((10, 10), (50, 10), (50, 50))),
    "numbers that touch": ('M1.5.5L20.5.5.5-20e0', polyline((1.5, 0.5), (20.5, 0.5), (0.5, -20))),
    "after z": ('M10 10h20v20zm40 0h20', None),
}  # fmt: skip


@pytest.mark.parametrize("name", PATHS)
def test_svg_paths(tmp_path, name):
    data, wanted = PATHS[name]
    found = drawn(tmp_path, f'<path d="{data}"/>')
    if wanted is None:
        wanted = np.concatenate([polyline((10, 10), (30, 10), (30, 30), (10, 10)), polyline((50, 10), (70, 10))])
    wanted = np.column_stack([wanted[:, 0], -wanted[:, 1]])
    wanted -= (wanted.min(axis=0) + wanted.max(axis=0)) / 2
    apart = np.linalg.norm(found[:, None, :2] - wanted[None], axis=2)
    assert apart.min(axis=1).max() < 0.05  # each focus is on the curve, whose samples here are so far apart
    assert apart.min(axis=0).max() < 2.0  # and no stretch of it is left out


@pytest.mark.parametrize("content, sides", [('<rect x="10" y="10" width="40" height="20"/>', (40, 20)), ('<polygon points="10,10 50,10 50,30 10,30"/>', (40, 20)),
                                            ('<polyline points="10 10 50 10 50 30"/>', (40, 20)), ('<line x1="10" y1="10" x2="50" y2="30"/>', (40, 20))])  # fmt: skip
def test_svg_basic_shapes(tmp_path, content, sides):
    found = drawn(tmp_path, content)
    assert np.allclose(np.ptp(found[:, :2], axis=0), sides, atol=0.5)


HIDDEN = ['<g display="none"><rect width="90" height="90"/></g>', '<rect width="90" height="90" style="display: none"/>', '<rect width="90" height="90" visibility="hidden"/>',
          '<rect width="90" height="90" fill="none"/>', '<defs><rect width="90" height="90"/></defs>', '<clipPath><rect width="90" height="90"/></clipPath>', '<path d="M1 1"/>',
          '<path d=""/>', '<circle r="0"/>', '<text>words</text>', '<g clip-path="url(#a)"/>', '<metadata><rect width="90" height="90"/></metadata>']  # fmt: skip


@pytest.mark.parametrize("content", HIDDEN)
def test_svg_shows_what_is_seen(tmp_path, content):
    found = drawn(tmp_path, content + '<circle cx="50" cy="50" r="20"/>')
    assert np.abs(np.hypot(*found.T[:2]) - 20).max() < 2e-3
    done = succeed(["compile", "drawing.svg", *PACE, "-o", "image.hex"], cwd=tmp_path)
    told = any(word in content for word in ("visibility", 'fill="none"', "text", "clip-path="))
    assert (b"drawing.svg: " in done.stderr) == told


def test_svg_that_is_wrong(tmp_path):
    laughs = "".join(f'<g id="g{k}">{f"""<use href="#g{k + 1}"/>""" * 10}</g>' for k in range(9)) + '<g id="g9"><circle r="1"/></g>'
    contents = [*(f'<path d="{data}"/>' for data in ("L1 1", "M1", "M1 1L2", "M1 1X2 2", "M1 1A1 1 0 2 0 3 3", "M1 1Lnan 3", "M1 1L1e99 3", "M1 1z 3 4", "1 1", "M1 1LInfinity 0", "M1 1L--3 4")),
                '<circle r="-1"/>', '<circle r="5%"/>', '<circle r="5em"/>', '<circle r="x"/>', '<rect width="-1" height="1"/>', '<circle r="1" transform="turn(3)"/>', '<circle r="1" transform="rotate(1,2)"/>',
                '<circle r="1" transform="scale"/>', '<circle r="1" style="transform:scale(2)"/>', "<style>.a{display : none}</style><circle r='1'/>", '<use href="#gone"/>', '<g id="a"><use href="#a"/></g>',
                '<symbol id="s" viewBox="0 0 1 1"><circle r="1"/></symbol><use href="#s"/>', laughs, "<text>words</text>", "", "<a>" * 100 + "</a>" * 100, '<polygon points="1 2 3"/>',
                '<circle r="1e9" transform="scale(1e9)"/>']  # fmt: skip
    drawings = [svg(content) for content in contents] + [b"<svg", b"<html/>", b"", svg('<circle r="1"/>', 'viewBox="0 0 0 1"'), svg('<circle r="1"/>', 'viewBox="0 0 1"'), svg('<circle r="1"/>')[:-9]]
    for content in drawings:
        (tmp_path / "drawing.svg").write_bytes(content)
        refuse(tmp_path, ["compile", "drawing.svg", *PACE, "-o", "no.hex"], BAD_INPUT, outputs=["no.hex"])


def through(calls, folder, content, *options):
    """compile of standard input."""
    (folder / "piped").write_bytes(content)
    with (folder / "piped").open("rb") as piped:
        return calls(["compile", "-", *options], stdin=piped, cwd=folder)


def test_formats_are_known_by_their_content_too(tmp_path):
    model = three_mf(model_xml(f'<object id="1">{mesh_xml(ROOF.tolist(), FACES)}</object>', '<item objectid="1"/>'))
    for content in (pcd(RING, "binary"), model, gltf(y_up(ROOF).tolist(), CORNERS)[0], gltf(y_up(ROOF).tolist(), CORNERS, "glb")[0]):
        through(succeed, tmp_path, content, "-o", "image.hex")
    through(succeed, tmp_path, svg('<circle r="20"/>'), *PACE, "--center", "0,0,130", "-o", "image.hex")


def test_bodies_and_objects_are_read_too(tmp_path):
    """A closed box of three different sides that a hand touches."""
    corners = [(x, y, z) for z in (0, 40) for y in (-10, 10) for x in (-20, 20)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)
    (tmp_path / "box.obj").write_text(text)
    (tmp_path / "box.3mf").write_bytes(three_mf(model_xml(f'<object id="1">{mesh_xml([tuple(map(float, p)) for p in corners], faces)}</object>', '<item objectid="1"/>')))
    (tmp_path / "box.glb").write_bytes(gltf(y_up(corners).tolist(), list(itertools.chain(*faces)), "glb")[0])
    for name in ("box.obj", "box.3mf", "box.glb"):
        succeed(["render", name, "--hand", "synthetic:press", "--frame", "30", "--center", "0,0,200", "-o", "path.json"], cwd=tmp_path)
        x, y, z = np.abs([focus["position_mm"] for step in read_json(tmp_path / "path.json")["steps"] for focus in step["foci"]]).T
        assert np.allclose(np.maximum(x, 2 * y), 20, atol=0.5) and np.allclose(z, z[0], atol=1e-3), name
