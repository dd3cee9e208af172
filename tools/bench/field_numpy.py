#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tasks of field.cpp with numpy's whole-array operations, as a user would write them; prints one JSON object of median milliseconds.

The volumes are measured on a part of their planes and scaled.
"""

import json
import time

import numpy as np

WAVE_NUMBER = 2.0 * np.pi * 40e3 / 343.2
RADIUS = 4.5e-3


def directivity_in_cosine_squared():
    """2·J1(x)/x as a polynomial in cos²θ, lowest power first; J1 by its integral, as numpy has no Bessel functions."""
    cosine_squared = (1.0 - np.cos(np.pi * (np.arange(40) + 0.5) / 40)) / 2.0
    x = WAVE_NUMBER * RADIUS * np.sqrt(1.0 - cosine_squared)
    angle = np.pi * (np.arange(400) + 0.5) / 400
    bessel = np.cos(angle - x[:, None] * np.sin(angle)).mean(axis=1)
    return np.polynomial.Polynomial.fit(cosine_squared, 2.0 * bessel / x, 5, domain=(0, 1)).convert().coef


COEFFICIENTS = directivity_in_cosine_squared()


def square_array(side):
    centred = (np.arange(side) - (side - 1) / 2.0) * 0.01
    return np.array([(x, y, 0.0) for y in centred for x in centred])


def focused(elements, focus):
    return 4.0 * np.exp(1j * WAVE_NUMBER * np.linalg.norm(elements - focus, axis=1))


def axis(begin, count):
    return begin + 1e-3 * np.arange(count)


def points_of(x, y, z):
    z, y, x = np.meshgrid(z, y, x, indexing="ij")
    return np.stack((x.ravel(), y.ravel(), z.ravel()), axis=1)


def propagation(points, elements, real):
    """Points × elements, complex64 or complex128 as `real` is."""
    ray = points[:, None, :].astype(real) - elements[None, :, :].astype(real)
    square = np.einsum("ijk,ijk->ij", ray, ray)
    distance = np.sqrt(square)
    cosine_squared = ray[:, :, 2] ** 2 / square
    pattern = np.full_like(square, COEFFICIENTS[-1])
    for c in COEFFICIENTS[-2::-1]:
        pattern = pattern * cosine_squared + real(c)
    return pattern / distance * np.exp(real(-WAVE_NUMBER) * distance * np.array(1j, np.result_type(real, np.complex64)))


MEASURED = np.array([1, 1, 1, 0.891, 0.708, 0.501, 0.355, 0.251, 0.200, 0.178], np.float32)  # T4010A1, every 10°


def measured_propagation(points, elements):
    """Points × elements, complex64, with a measured pattern: straight lines between its angles."""
    ray = points[:, None, :].astype(np.float32) - elements[None, :, :].astype(np.float32)
    distance = np.sqrt(np.einsum("ijk,ijk->ij", ray, ray))
    angle = np.degrees(np.arccos(ray[:, :, 2] / distance))
    pattern = np.interp(angle, np.arange(0, 91, 10), MEASURED).astype(np.float32)
    return pattern / distance * np.exp(np.complex64(-1j * WAVE_NUMBER) * distance)


def shifted(side, x, y, z):
    """The sum of one element's field, shifted: what a careful user would write for a grid."""
    step = 10
    elements = square_array(side)
    drives = focused(elements, np.array([0.0, 0.0, 0.13])).astype(np.complex64).reshape(side, side)
    first = elements[0]
    before = (side - 1) * step
    wide_x = x[0] - first[0] + 1e-3 * np.arange(-before, len(x))
    wide_y = y[0] - first[1] + 1e-3 * np.arange(-before, len(y))
    out = np.zeros((len(z), len(y), len(x)), np.complex64)
    for plane, height in enumerate(z):
        one = propagation(points_of(wide_x, wide_y, [height]), np.zeros((1, 3)), np.float32).reshape(len(wide_y), len(wide_x))
        for row in range(side):
            for column in range(side):
                j, i = before - row * step, before - column * step
                out[plane] += drives[row, column] * one[j : j + len(y), i : i + len(x)]
    return out


def least_ms(repeats, call):
    """The least time of several runs, as other programs only add to it; the first run, which may compile, counts, too."""
    times = []
    for _ in range(repeats + 1):
        begun = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - begun))
    return min(times)


def main():
    elements = square_array(10)
    drives = focused(elements, np.array([0.0, 0.0, 0.13]))
    plane = points_of(axis(-0.1, 200), axis(-0.1, 200), [0.13])
    part = points_of(axis(-0.05, 100), axis(-0.05, 100), axis(0.05, 5))
    average = points_of(axis(-0.05, 100), axis(-0.05, 100), [0.13])
    angles = 0.0314159 * np.arange(200)
    records = np.array([focused(elements, np.array([0.035 * np.cos(a), 0.035 * np.sin(a), 0.13])) for a in angles]).astype(np.complex64)
    single = drives.astype(np.complex64)
    hoshi = square_array(18)
    hoshi_drives = focused(hoshi, np.array([0.0, 0.0, 0.13])).astype(np.complex64)
    found = {
        "plane_float32_ms": least_ms(3, lambda: propagation(plane, elements, np.float32) @ single),
        "measured_float32_ms": least_ms(1, lambda: measured_propagation(plane, hoshi) @ hoshi_drives),
        "volume_float32_ms": 20.0 * least_ms(1, lambda: propagation(part, elements, np.float32) @ single),
        "volume_shifted_ms": 20.0 * least_ms(1, lambda: shifted(10, axis(-0.05, 100), axis(-0.05, 100), axis(0.05, 5))),
        "large_shifted_ms": 200.0 * least_ms(1, lambda: shifted(32, axis(-0.0995, 200), axis(-0.0995, 200), axis(0.1, 1))),
        "mean_square_ms": least_ms(3, lambda: (np.abs(propagation(average, elements, np.float32) @ records.T) ** 2).mean(axis=1) / 2.0),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main()
