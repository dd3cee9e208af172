#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the two shapes of the demo: heart.ply, a point cloud as a depth camera might see it, and vase.obj, a mesh.

Coordinates are millimetres in the array frame: z away from the array."""

import pathlib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent


def heart_cloud(points=6000, width_mm=80.0, z_mm=130.0, noise_mm=0.4, seed=7):
    """A heart's outline with a sensor's noise, in no order."""
    rng = np.random.default_rng(seed)
    t = rng.uniform(0.0, 2.0 * np.pi, points)
    x = 16.0 * np.sin(t) ** 3
    y = 13.0 * np.cos(t) - 5.0 * np.cos(2 * t) - 2.0 * np.cos(3 * t) - np.cos(4 * t)
    cloud = np.stack([x, y, np.zeros_like(x)], axis=1) * (width_mm / 32.0)
    cloud[:, 1] += 6.0
    cloud += rng.normal(0.0, noise_mm, cloud.shape)
    cloud[:, 2] += z_mm
    return cloud.astype("<f4")


def vase_mesh(rings=48, sides=64, bottom_mm=100.0, height_mm=70.0):
    """A surface of revolution: vertices and quadrilaterals."""
    u = np.linspace(0.0, 1.0, rings)
    radius = 24.0 + 9.0 * np.sin(2.0 * np.pi * u - 0.6) + 4.0 * u
    angle = np.arange(sides) * 2.0 * np.pi / sides
    vertices = np.empty((rings, sides, 3))
    vertices[:, :, 0] = radius[:, None] * np.cos(angle)
    vertices[:, :, 1] = radius[:, None] * np.sin(angle)
    vertices[:, :, 2] = (bottom_mm + height_mm * u)[:, None]
    faces = [
        (r * sides + s, r * sides + (s + 1) % sides, (r + 1) * sides + (s + 1) % sides, (r + 1) * sides + s)
        for r in range(rings - 1)
        for s in range(sides)
    ]
    return vertices.reshape(-1, 3), faces


def main():
    cloud = heart_cloud()
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment heart outline with sensor noise, mm\n"
        f"element vertex {len(cloud)}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    (HERE / "heart.ply").write_bytes(header.encode("ascii") + cloud.tobytes())
    vertices, faces = vase_mesh()
    lines = ["# vase, a surface of revolution, mm"]
    lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in vertices]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    (HERE / "vase.obj").write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
