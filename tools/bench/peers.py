#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What else a careful user of Python would take, measured on one thread: numba for fields, AUTD3's Rust and tuned numpy for several
foci. Prints one JSON object of least times; a peer that is not installed is left out. `make bench` installs them into build/peers."""

import json
import os
import sys
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")
os.environ.setdefault("RAYON_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

import field_numpy  # noqa: E402


def numba_fields():
    """Loops over points and elements in float32 with fast arithmetic, which numba turns into vectors."""
    import numba

    @numba.njit(fastmath=True, error_model="numpy")
    def pistons(x, y, z, ex, ey, ez, amplitude, phase, k, c, re, im):
        c0, c1, c2, c3, c4, c5 = c[0], c[1], c[2], c[3], c[4], c[5]
        for m in range(ex.shape[0]):
            for i in range(x.shape[0]):
                dx, dy, dz = x[i] - ex[m], y[i] - ey[m], z[i] - ez[m]
                square = dx * dx + dy * dy + dz * dz
                r = np.sqrt(square)
                t = dz * dz / square
                size = amplitude[m] * (c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))) / r
                lag = phase[m] - k * r
                re[i] += size * np.cos(lag)
                im[i] += size * np.sin(lag)

    @numba.njit(fastmath=True, error_model="numpy")
    def measured(x, y, z, ex, ey, ez, amplitude, phase, k, table, re, im):
        per_radian = np.float32((table.shape[0] - 1) / (np.pi / 2))
        for m in range(ex.shape[0]):
            for i in range(x.shape[0]):
                dx, dy, dz = x[i] - ex[m], y[i] - ey[m], z[i] - ez[m]
                r = np.sqrt(dx * dx + dy * dy + dz * dz)
                place = np.arccos(dz / r) * per_radian
                low = min(int(place), table.shape[0] - 2)
                size = amplitude[m] * (table[low] + (place - low) * (table[low + 1] - table[low])) / r
                lag = phase[m] - k * r
                re[i] += size * np.cos(lag)
                im[i] += size * np.sin(lag)

    def columns(array):
        return [np.ascontiguousarray(array[:, axis], np.float32) for axis in range(3)]

    def field(loop, pattern, points, elements, drives):
        re, im = np.zeros(len(points), np.float32), np.zeros(len(points), np.float32)
        amplitude, phase = np.abs(drives).astype(np.float32), np.angle(drives).astype(np.float32)
        place, source = columns(points), columns(elements)

        def call():
            re[:] = 0.0
            im[:] = 0.0
            loop(*place, *source, amplitude, phase, np.float32(field_numpy.WAVE_NUMBER), pattern, re, im)

        return call, re, im

    tile, hoshi = field_numpy.square_array(10), field_numpy.square_array(18)
    focus = np.array([0.0, 0.0, 0.13])
    drives = field_numpy.focused(tile, focus)
    axis = -0.1 + 0.2 / 199 * np.arange(200)
    plane = field_numpy.points_of(axis, axis, [0.13])
    volume = field_numpy.points_of(field_numpy.axis(-0.05, 100), field_numpy.axis(-0.05, 100), field_numpy.axis(0.05, 100))
    coefficients = field_numpy.COEFFICIENTS.astype(np.float32)

    on_plane, re, im = field(pistons, coefficients, plane, tile, drives)
    on_plane()
    exact = field_numpy.propagation(plane, tile, np.float64) @ drives
    apart = np.abs(re + 1j * im - exact).max() / np.abs(exact).max()
    in_volume, *_ = field(pistons, coefficients, volume, tile, drives)
    by_table, *_ = field(measured, field_numpy.MEASURED, plane, hoshi, field_numpy.focused(hoshi, focus))
    return {"plane_ms": field_numpy.least_ms(9, on_plane), "plane_apart": float(apart), "volume_ms": field_numpy.least_ms(2, in_volume), "measured_ms": field_numpy.least_ms(5, by_table)}


def set_of_foci(random, count):
    """As solve.cpp has them: 150 mm away, at least 15 mm from each other, millimetres from the array's centre."""
    foci = []
    while len(foci) < count:
        at = np.array([*random.uniform(-60.0, 60.0, 2), 150.0])
        if all(np.linalg.norm(at - other) >= 15.0 for other in foci):
            foci.append(at)
    return np.array(foci)


def autd3_foci():
    """GS-PAT of AUTD3 for ten foci over its 249 transducers; how even the foci are, by a sum in double precision. Phases only, 8 bits."""
    import autd3_core as core
    import autd3_pattern_holo as holo

    geometry = core.Geometry([core.Autd3()])
    positions = np.asarray(geometry[0].positions(), dtype=float)  # millimetres
    centre, k = positions.mean(axis=0), field_numpy.WAVE_NUMBER * 1e-3
    wavelength = core.Length.from_mm(2.0 * np.pi / k)
    phases, intensities = geometry.phase_buffer(), geometry.intensity_buffer()
    option = holo.GspatOption(constraint=holo.IntensityConstraint.Uniform(255), parallel=False)
    random = np.random.default_rng(1)
    times, spreads = [], []
    for _ in range(100):
        foci = centre + set_of_foci(random, 10)
        targets = [holo.AmplitudeTarget(focus.tolist(), 1e3 * holo.Pa) for focus in foci]
        for _ in range(5):
            begun = time.perf_counter()
            holo.gspat(geometry, targets, wavelength, option, phases, intensities)
            times.append(1e6 * (time.perf_counter() - begun))
        turned = np.exp(2j * np.pi * phases.to_numpy()[0] / 256.0)
        distance = np.linalg.norm(foci[:, None, :] - positions[None, :, :], axis=2)
        # The sign of the phases is whichever makes foci.
        pressure = max((np.abs((np.exp(1j * k * distance) / distance) @ drive) for drive in (turned, turned.conj())), key=np.mean)
        spreads.append(pressure.std() / pressure.mean())
    return {"us": min(times), "spread": float(np.median(spreads)), "worst_spread": float(np.max(spreads))}


def grid_mm(columns, rows):
    x, y = np.meshgrid(10.16 * (np.arange(columns) - (columns - 1) / 2), 10.16 * (np.arange(rows) - (rows - 1) / 2))
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1).astype(np.float32)


def numpy_wgs(count, elements, rounds=200):
    """Weighted Gerchberg-Saxton as one writes it for speed: single precision, two products with a matrix a round, whose building counts."""
    k = np.float32(field_numpy.WAVE_NUMBER * 1e-3)
    random = np.random.default_rng(1)
    times, spreads = [], []
    for _ in range(20):
        foci = set_of_foci(random, count).astype(np.float32)
        begun = time.perf_counter()
        distance = np.sqrt(((foci[:, None, :] - elements[None, :, :]) ** 2).sum(axis=2))
        waves = np.exp(np.complex64(-1j) * k * distance) / distance
        back = np.ascontiguousarray(waves.conj().T)
        drive, weight = np.ones(len(elements), np.complex64), np.ones(count, np.float32)
        for _ in range(rounds):
            pressure = waves @ drive
            size = np.abs(pressure)
            weight *= size.mean() / size
            drive = back @ (weight / size * pressure)
            drive /= np.abs(drive)
        times.append(1e6 * (time.perf_counter() - begun))
        size = np.abs(waves.astype(complex) @ drive)
        spreads.append(size.std() / size.mean())
    return {"us": min(times), "spread": float(np.median(spreads)), "worst_spread": float(np.max(spreads))}


def main():
    autd, square = np.delete(grid_mm(18, 14), [18 + 1, 18 + 2, 18 + 16], axis=0), grid_mm(16, 16)
    found = {"numpy_wgs": {"10x249": numpy_wgs(10, autd), "16x256": numpy_wgs(16, square), "32x249": numpy_wgs(32, autd)}}
    for name, measure in (("numba", numba_fields), ("autd3", autd3_foci)):
        try:
            found[name] = measure()
        except ModuleNotFoundError as missing:
            found[name] = None
            print(f"peers: {name} is left out: {missing}", file=sys.stderr)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
