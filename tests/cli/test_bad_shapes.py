# SPDX-License-Identifier: Apache-2.0
"""Shape files that cannot be used: one message that names the place, exit code 3, nothing written."""
import os
import struct

import pytest
from messages import program_said
from support import BAD_INPUT, refuse, run, succeed

CORNERS = [(0.0, 0.0, 100.0), (20.0, 0.0, 100.0), (0.0, 20.0, 100.0), (0.0, 0.0, 120.0)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def ply_text(corners=CORNERS, faces=FACES):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    body = "".join(f"{x} {y} {z}\n" for x, y, z in corners) + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    return (head + body).encode()


def ply_binary(order, corners=CORNERS, faces=FACES):
    name = {"<": "little", ">": "big"}[order]
    head = ply_text(corners, faces).split(b"end_header\n")[0].replace(b"ascii", f"binary_{name}_endian".encode())
    body = b"".join(struct.pack(order + "3f", *c) for c in corners) + b"".join(struct.pack(order + "B3i", 3, *f) for f in faces)
    return head + b"end_header\n" + body


def obj(corners=CORNERS, faces=FACES):
    rows = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    return ("\n".join(rows) + "\n").encode()


def stl_text(corners=CORNERS, faces=FACES):
    rows = ["solid shape"]
    for face in faces:
        rows += ["facet normal 0 0 1", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in (corners[i] for i in face)), "endloop", "endfacet"]
    return ("\n".join(rows) + "\nendsolid shape\n").encode()


def stl_binary(corners=CORNERS, faces=FACES):
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *corners[f[0]], *corners[f[1]], *corners[f[2]], 0) for f in faces)
    return b"made by a test".ljust(80) + struct.pack("<I", len(faces)) + body


def xyz(corners=CORNERS):
    return "".join(f"{x} {y} {z}\n" for x, y, z in corners).encode()


def csv(corners=CORNERS):
    return ("x,y,z\n" + "".join(f"{x},{y},{z}\n" for x, y, z in corners)).encode()


GOOD = {
    "text.ply": ply_text(),
    "little.ply": ply_binary("<"),
    "big.ply": ply_binary(">"),
    "shape.obj": obj(),
    "text.stl": stl_text(),
    "binary.stl": stl_binary(),
    "shape.xyz": xyz(),
    "shape.csv": csv(),
}


def refuse_file(folder, name, content):
    (folder / name).write_bytes(content)
    refuse(folder, ["compile", name, "--points", "4", "-o", "image.hex"], BAD_INPUT)


@pytest.mark.parametrize("name", GOOD)
def test_the_undamaged_file_compiles(name, tmp_path):
    (tmp_path / name).write_bytes(GOOD[name])
    succeed(["compile", name, "--points", 4, "-o", "image.hex"], cwd=tmp_path)
    assert (tmp_path / "image.hex").stat().st_size > 0


@pytest.mark.parametrize("name", GOOD)
def test_an_empty_file(name, tmp_path):
    refuse_file(tmp_path, name, b"")


CUT = {  # text, where it is cut
    "text.ply": b"0.0 20.0 10",
    "shape.obj": b"f 1 4 3",
    "text.stl": b"vertex 0.0 0.0 120.0",
    "shape.xyz": b"0.0 20.0 100.0",
    "shape.csv": b"0.0,20.0,100.0",
}


@pytest.mark.parametrize("name", GOOD)
def test_a_file_that_is_cut_short(name, tmp_path):
    content = GOOD[name]
    if name in ("text.ply", "text.stl"):
        at = content.index(CUT[name]) + 8
    elif name in ("little.ply", "big.ply", "binary.stl"):
        at = {"little.ply": len(content) - 20, "big.ply": len(content) - 50, "binary.stl": len(content) - 60}[name]
    else:
        at = content.index(CUT[name]) + 4
    refuse_file(tmp_path, name, content[:at])


@pytest.mark.parametrize("name", ["text.ply", "little.ply", "big.ply", "text.stl", "binary.stl"])
@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.7, 0.97])
def test_no_cut_passes_in_a_format_that_knows_its_length(name, share, tmp_path):
    refuse_file(tmp_path, name, GOOD[name][: int(len(GOOD[name]) * share)])


@pytest.mark.parametrize("name", GOOD)
def test_garbage(name, tmp_path):
    garbage = bytes((97 * i * i + 31 * i + 7) % 256 for i in range(1000))
    refuse_file(tmp_path, name, garbage)


GARBLED = {
    "text.ply": (b"20.0 0.0 100.0", b"20.0 0,0 100.0"),
    "shape.obj": (b"v 20.0 0.0", b"v 20.0 O.0"),
    "text.stl": (b"vertex 20.0 0.0 100.0", b"vertex 20.0 0.0 1o0.0"),
    "shape.xyz": (b"20.0 0.0 100.0", b"20.0 zero 100.0"),
    "shape.csv": (b"20.0,0.0,100.0", b"20.0,,100.0"),
}


@pytest.mark.parametrize("name", GARBLED)
def test_one_garbled_number(name, tmp_path):
    old, new = GARBLED[name]
    assert old in GOOD[name]
    refuse_file(tmp_path, name, GOOD[name].replace(old, new, 1))


@pytest.mark.parametrize("name", GOOD)
@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_a_coordinate_that_is_not_finite(name, value, tmp_path):
    corners = [CORNERS[0], (20.0, float(value), 100.0), *CORNERS[2:]]
    make = {
        "text.ply": ply_text,
        "little.ply": lambda c: ply_binary("<", c),
        "big.ply": lambda c: ply_binary(">", c),
        "shape.obj": obj,
        "text.stl": stl_text,
        "binary.stl": stl_binary,
        "shape.xyz": xyz,
        "shape.csv": csv,
    }[name]
    refuse_file(tmp_path, name, make(corners))


@pytest.mark.parametrize("number", ["1e400", "1e39", "0x10", "1,5", "--1", "1e"])
def test_a_number_that_no_double_or_no_shape_can_hold(number, tmp_path):
    refuse_file(tmp_path, "shape.xyz", f"0 0 100\n{number} 0 100\n0 9 100\n".encode())


ZERO_POINTS = {
    "text.ply": ply_text([], []),
    "little.ply": ply_binary("<", [], []),
    "shape.obj": b"# a comment\n",
    "text.stl": b"solid nothing\nendsolid nothing\n",
    "binary.stl": stl_binary([], []),
    "shape.xyz": b"# nothing\n\n",
    "shape.csv": b"x,y,z\n",
}


@pytest.mark.parametrize("name", ZERO_POINTS)
def test_zero_points(name, tmp_path):
    refuse_file(tmp_path, name, ZERO_POINTS[name])


def test_a_face_that_names_no_vertex(tmp_path):
    refuse_file(tmp_path, "text.ply", ply_text(faces=[(0, 1, 4)]))
    refuse_file(tmp_path, "shape.obj", obj(faces=[(0, 1, 4)]))


def test_more_data_than_the_header_promises(tmp_path):
    refuse_file(tmp_path, "little.ply", GOOD["little.ply"] + b"\0")
    refuse_file(tmp_path, "binary.stl", GOOD["binary.stl"] + b"\0")


def test_a_second_file_that_is_bad_spoils_the_first(tmp_path):
    (tmp_path / "good.xyz").write_bytes(xyz())
    (tmp_path / "bad.xyz").write_bytes(b"0 0 100\n0 0\n")
    refuse(tmp_path, ["compile", "good.xyz", "bad.xyz"], BAD_INPUT)


def test_a_missing_file(tmp_path):
    refuse(tmp_path, ["compile", "nowhere.ply"], BAD_INPUT)


def test_a_name_that_is_empty(tmp_path):
    refuse(tmp_path, ["compile", ""], BAD_INPUT)


def test_a_directory_as_input(tmp_path):
    (tmp_path / "folder.ply").mkdir()
    refuse(tmp_path, ["compile", "folder.ply"], BAD_INPUT)


@pytest.mark.deep
def test_a_named_pipe_into_which_nobody_writes(tmp_path):
    """It takes a minute, of which nothing is computed."""
    os.mkfifo(tmp_path / "shape.xyz")
    refuse(tmp_path, ["compile", "shape.xyz", "-o", "image.hex"], BAD_INPUT)


def test_an_unknown_extension(tmp_path):
    (tmp_path / "shape.step").write_bytes(xyz())
    refuse(tmp_path, ["compile", "shape.step"], BAD_INPUT)


def test_the_wrong_type_under_a_right_name(tmp_path):
    refuse_file(tmp_path, "shape.ply", GOOD["binary.stl"])
    refuse_file(tmp_path, "shape.stl", GOOD["text.ply"])
    refuse_file(tmp_path, "shape.obj", GOOD["text.ply"])


def test_an_unreadable_file(tmp_path):
    (tmp_path / "loop.ply").symlink_to("loop.ply")  # nobody, not even root, can open it
    result = run(["compile", "loop.ply"], cwd=tmp_path)
    assert result.returncode == BAD_INPUT
    program_said(result.returncode, result.stderr)
    assert [p.name for p in tmp_path.iterdir()] == ["loop.ply"]


@pytest.mark.parametrize("page", ["<!DOCTYPE html>\n<html></html>", "\n  <HTML lang=en>"])
@pytest.mark.parametrize("name", ["shape.stl", "shape.ply", "shape.obj"])
def test_a_web_page_under_a_shape_s_name(name, page, tmp_path):
    (tmp_path / name).write_text(page)
    refuse(tmp_path, ["compile", name, "-o", "image.hex"], BAD_INPUT)
