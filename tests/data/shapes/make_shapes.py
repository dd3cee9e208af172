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
    write_with_meshio()
    write_with_numpy()
