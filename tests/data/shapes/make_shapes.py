#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the shape files beside it, with programs that share no code with the reader under test.

Run with trimesh 5.2.0, plyfile 1.1.5, meshio 5.3.5 and numpy from PyPI. All hold the same tetrahedron, in millimetres:
corners (0 0 0) (10 0 0) (0 20 0) (0 0 40.5); faces, where there are any, 0 2 1, 0 1 3, 0 3 2, 1 2 3.
The files in by_hand/ are not written by it; cases of damage are made by the tests from these files.
"""
from pathlib import Path

import meshio
import numpy as np
import trimesh
from plyfile import PlyData, PlyElement

HERE = Path(__file__).parent
CORNERS = np.array([[0, 0, 0], [10, 0, 0], [0, 20, 0], [0, 0, 40.5]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def write_with_trimesh():
    mesh = trimesh.Trimesh(CORNERS, FACES, process=False)
    for name, options in {
        "trimesh_binary.stl": {},
        "trimesh_ascii.stl": {"file_type": "stl_ascii"},
        "trimesh.obj": {},
        "trimesh_ascii.ply": {"encoding": "ascii"},
        "trimesh_little.ply": {"encoding": "binary"},
    }.items():
        mesh.export(HERE / name, **options)
    trimesh.PointCloud(CORNERS).export(HERE / "trimesh_cloud.xyz")
    trimesh.PointCloud(CORNERS).export(HERE / "trimesh_cloud.ply")


def write_with_plyfile():
    vertices = np.array(
        [(1.0, *corner, 255) for corner in CORNERS],
        dtype=[("quality", "f4"), ("x", "f8"), ("y", "f8"), ("z", "f8"), ("red", "u1")],
    )
    faces = np.empty(len(FACES), dtype=[("flags", "u2"), ("vertex_indices", "O")])
    faces["flags"] = 7
    for i, face in enumerate(FACES):
        faces["vertex_indices"][i] = face.astype("u4")
    cloud = PlyElement.describe(vertices, "vertex", comments=["a cloud with more properties than asked"])
    mesh = PlyElement.describe(faces, "face", val_types={"vertex_indices": "u4"}, len_types={"vertex_indices": "u1"})
    for order, name in {"=": "ascii", "<": "little", ">": "big"}.items():
        text = name == "ascii"
        PlyData([cloud], text=text, byte_order=order).write(HERE / f"plyfile_cloud_{name}.ply")
        PlyData([cloud, mesh], text=text, byte_order=order).write(HERE / f"plyfile_{name}.ply")


def lists(name, rows, of, counts="u1"):
    """One element that has one list property, vertex_indices, of `rows`."""
    table = np.empty(len(rows), dtype=[("vertex_indices", "O")])
    for i, row in enumerate(rows):
        table["vertex_indices"][i] = np.array(row, dtype=of)
    return PlyElement.describe(table, name, val_types={"vertex_indices": of}, len_types={"vertex_indices": counts})


def odd_forms(order):
    """What the format allows and few programs write. plyfile 1.1.5 does not swap the bytes of numbers that stand beside lists, so that is
    done here."""
    plain = np.array([tuple(corner) for corner in CORNERS], dtype=[("x", "f8"), ("y", "f4"), ("z", "f8")])
    halves = np.array([tuple(corner) for corner in 2 * CORNERS], dtype=[("x", "u1"), ("y", "i2"), ("z", "u4")])
    tails = np.empty(len(CORNERS), dtype=[("neighbours", "O"), ("z", "f4"), ("y", "f4"), ("more", "O"), ("x", "f4")])
    for i, corner in enumerate(CORNERS.astype("f4")):
        x, y, z = corner.byteswap() if order == ">" else corner
        tails[i] = (np.arange(i, dtype="i2"), z, y, np.full(3, 0.5, dtype="f8"), x)
    camera = PlyElement.describe(np.array([(1.5, 7)], dtype=[("view_x", "f4"), ("x", "i1")]), "camera")
    groups = lists("group", [[], [0, 3], [1]], "i2", "u2")
    edges = PlyElement.describe(np.array([(0, 1), (2, 3)], dtype=[("vertex1", "i4"), ("vertex2", "i4")]), "edge")
    tailed = PlyElement.describe(tails, "vertex", val_types={"neighbours": "i2", "more": "f8"}, len_types={"neighbours": "u1", "more": "i4"})
    strips = lists("tristrips", [[0, 1, 2, 3], [], [2, 3, 0, 0, 1]], "i4", "i4")
    one_strip = lists("tristrips", [[0, 1, 2, 3, -1, 2, 3, 0, 1]], "i4", "i4")
    return {
        "faces_first": [lists("face", FACES, "i1"), PlyElement.describe(plain, "vertex")],
        "integers": [PlyElement.describe(halves, "vertex"), lists("face", FACES, "u2", "u4")],
        "float_corners": [PlyElement.describe(plain, "vertex"), lists("face", FACES, "f4", "i2")],
        "more_elements": [camera, groups, lists("face", FACES, "u4"), edges, tailed],
        "strips": [PlyElement.describe(plain, "vertex"), one_strip],
        "many_strips": [strips, PlyElement.describe(plain, "vertex")],
    }


def write_odd_forms_with_plyfile():
    for order, name in {"=": "ascii", "<": "little", ">": "big"}.items():
        for form, elements in odd_forms(order).items():
            PlyData(elements, text=name == "ascii", byte_order=order, obj_info=["as few programs write it"]).write(HERE / f"odd_{form}_{name}.ply")


def write_with_meshio():
    mesh = meshio.Mesh(CORNERS, [("triangle", FACES)])
    mesh.write(HERE / "meshio.obj")
    mesh.write(HERE / "meshio_binary.stl", binary=True)
    mesh.write(HERE / "meshio_ascii.stl", binary=False)
    mesh.write(HERE / "meshio_little.ply", binary=True)


def write_with_numpy():
    np.savetxt(HERE / "numpy_header.csv", CORNERS[:, ::-1], delimiter=",", header="Z,Y,X", comments="")
    np.savetxt(HERE / "numpy_semicolon.csv", np.c_[CORNERS, np.ones(4)], delimiter=";", fmt="%.3f")
    np.savetxt(HERE / "numpy_colours.xyz", np.c_[CORNERS, np.full((4, 3), 0.5)], header="x y z r g b", fmt="%g")


if __name__ == "__main__":
    write_with_trimesh()
    write_with_plyfile()
    write_odd_forms_with_plyfile()
    write_with_meshio()
    write_with_numpy()
