# SPDX-License-Identifier: Apache-2.0
"""Where things are, and fields as numpy sums them."""
import os
from pathlib import Path

import numpy as np
from scipy.special import j1

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HAPTOGRAM_PROGRAM", ROOT / "build/release/host/cli/haptogram")).resolve()
LIBRARY = Path(os.environ.get("HAPTOGRAM_LIBRARY", ROOT / "build/release/host/c/libhaptogram.so")).resolve()


def waves(array, points, radius_m=4.5e-3):
    """Points × elements: what each piston of 1 Pa m makes at each point."""
    k = 2.0 * np.pi / array.wavelength_m
    ray = np.asarray(points)[:, None, :] - array.positions_m[None, :, :]
    distance = np.linalg.norm(ray, axis=2)
    along = np.einsum("pme,me->pm", ray, array.normals)
    x = k * radius_m * np.sqrt(np.maximum(0.0, distance**2 - along**2)) / distance
    pattern = np.where(x < 1e-9, 1.0, 2.0 * j1(x) / np.maximum(x, 1e-9))
    return pattern / distance * np.exp(-1j * k * distance)
