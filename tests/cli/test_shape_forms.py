# SPDX-License-Identifier: Apache-2.0
"""Forms of shape files that the formats allow and few programs write: each gives the same image as the plain form."""
import struct

import numpy as np
import pytest
from messages import notice
from support import BAD_INPUT, ROOT, foci_mm, read_json, refuse, succeed
from test_bad_shapes import CORNERS, obj, ply_text, xyz

SHAPES = ROOT / "tests/data/shapes"


def header(*lines, form="ascii"):
    return "\n".join(["ply", f"format {form} 1.0", *lines, "end_header", ""]).encode()


VERTICES = ["element vertex 4", "property float x", "property float y", "property float z"]
FACES = ["element face 4", "property list uchar int vertex_indices"]
NUMBERS = [str(number) for corner in CORNERS for number in corner]
LINES = [" ".join(str(number) for number in corner) for corner in CORNERS]

CLOUDS = {
    "one_number_a_line": header(*VERTICES) + "\n".join(NUMBERS).encode(),
    "all_in_one_line": header(*VERTICES) + " ".join(NUMBERS).encode() + b"\n",
    "two_vertices_a_line": header(*VERTICES) + f"{LINES[0]} {LINES[1]}\n{LINES[2]}  {LINES[3]}\n".encode(),
    "crlf": (header(*VERTICES) + "\n".join(LINES).encode()).replace(b"\n", b"\r\n"),
    "cr": (header(*VERTICES) + "\n".join(LINES).encode()).replace(b"\n", b"\r"),
    "comments": header("comment a", "obj_info b", VERTICES[0], "comment c", *VERTICES[1:], "obj_info d") + "\n".join(LINES).encode(),
    "uchar_and_int": header("element vertex 4", "property int x", "property ushort y", "property uchar z", form="binary_big_endian")
    + b"".join(struct.pack(">iHB", *map(int, corner)) for corner in CORNERS),
    "double": header("element vertex 4", "property double z", "property double y", "property double x", form="binary_little_endian")
    + b"".join(struct.pack("<3d", *corner[::-1]) for corner in CORNERS),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("plain"), "plain.xyz", xyz())


def compiled(folder, name, content, *options):
    (folder / name).write_bytes(content)
    succeed(["compile", name, "-o", "image.hex", *options], cwd=folder)
    return (folder / "image.hex").read_bytes()


@pytest.mark.parametrize("form", CLOUDS)
def test_a_cloud_in_an_odd_form_is_the_same_cloud(form, plain, tmp_path):
    assert compiled(tmp_path, "shape.ply", CLOUDS[form]) == plain


def test_a_mesh_in_an_odd_form_is_the_same_mesh(tmp_path):
    options = ["--points", 30]
    usual = compiled(tmp_path, "usual.ply", ply_text(), *options)
    faces = b"3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
    assert compiled(tmp_path, "faces_first.ply", header(*FACES, *VERTICES) + faces + "\n".join(LINES).encode(), *options) == usual
    more = header("element camera 1", "property list int float view", *VERTICES, "element edge 2", "property int a", *FACES)
    assert compiled(tmp_path, "more.ply", more + b"2 0.5 nan\n" + "\n".join(LINES).encode() + b"\n1\n2\n" + faces, *options) == usual
    continued = obj().replace(b"f 1 3 2", b"f 1 \\\n3 \\\n2").replace(b"v 20.0 0.0", b"v 20.0\\\r\n 0.0")
    assert b"\\" in continued and compiled(tmp_path, "continued.obj", continued, *options) == usual


@pytest.mark.parametrize("path", sorted(SHAPES.glob("odd_*.ply")), ids=lambda path: path.stem)
def test_an_odd_form_that_another_program_wrote(path, tmp_path):
    unit = 0.5 if "integers" in path.stem else 1.0
    succeed(["compile", path, "--points", 60, "--scale", unit, "--center", "0,0,120", "-o", "image.hex"], cwd=tmp_path)
    points = foci_mm(read_json(tmp_path / "image.json")) - [0, 0, 120] + [5, 10, 20.25]
    assert len(points) == 60
    x, y, z = points.T
    # The planes that the tetrahedron's faces lie in; every point lies on one, and each face has its share.
    on = np.abs(np.array([x, y, z, (x / 10 + y / 20 + z / 40.5 - 1) * 8.78])) < 2e-3
    assert on.any(axis=0).all()
    wanted = [True, "many_strips" not in path.stem, True, True]
    assert [bool(row.sum() >= 5) for row in on] == wanted


REFUSED = {
    "a lost number": header(*VERTICES) + f"{LINES[0]}\n20.0 0.0\n100.0 {LINES[2]}\n{LINES[3]}\n".encode(),
    "a strip of two corners": header(*VERTICES, "element tristrips 1", "property list int int vertex_indices") + "\n".join(LINES).encode() + b"\n6 0 1 2 -1 2 3\n",
    "faces without corners": header(*VERTICES, "element face 1", "property uchar red") + "\n".join([*LINES, "7"]).encode(),
    "a vertex named twice": header(*VERTICES, *VERTICES) + "\n".join(LINES * 2).encode(),
    "a corner that is no vertex, faces first": header("element face 1", FACES[1], *VERTICES) + b"3 0 1 4\n" + "\n".join(LINES).encode(),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_an_odd_form_that_is_wrong(case, tmp_path):
    content = REFUSED[case]
    (tmp_path / "shape.ply").write_bytes(content)
    refuse(tmp_path, ["compile", "shape.ply", "-o", "image.hex"], BAD_INPUT)


def test_an_obj_line_that_goes_on_wrongly(tmp_path):
    (tmp_path / "shape.obj").write_bytes(b"mtllib C:\\\n" + obj())
    refuse(tmp_path, ["compile", "shape.obj", "-o", "image.hex"], BAD_INPUT)
    (tmp_path / "shape.obj").write_bytes(obj() + b"f 1 2 3 \\")
    refuse(tmp_path, ["compile", "shape.obj", "-o", "image.hex"], BAD_INPUT)


def test_a_polygon_that_crosses_itself(tmp_path):
    (tmp_path / "shape.obj").write_bytes(b"v 0 0 100\nv 20 0 100\nv 20 20 100\nv 0 20 100\nf 1 2 3 4\nf 1 3 2 4\n")
    told = succeed(["compile", "shape.obj", "--points", "30", "-o", "image.hex"], cwd=tmp_path)
    notice(told.stderr)
