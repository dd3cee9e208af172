#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The project's numbers beside their targets: measured now, on this machine, printed as a table and written as JSON."""

import argparse
import json
import math
import os
import pathlib
import platform
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import boards
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
BOARDS = ROOT / "build/boards"


LONGEST_S = 600  # that any one measurement may take


class Kernel:
    """A fixed piece of work, of what ours is made of: a copy of memory, roots, products and sums. A time's target holds for a machine on which
    this takes USUAL_MS. On another machine, or in another hour, the target grows with what it takes there and then."""

    USUAL_MS = 1.8

    def __init__(self):
        self.from_, self.to = np.linspace(1.0, 2.0, 1_000_000), np.empty(1_000_000)
        self.slowness = self.ms = math.nan

    def measure(self):
        def once():
            begun = time.perf_counter()
            np.copyto(self.to, self.from_)
            np.sqrt(self.to, out=self.to)
            np.multiply(self.to, self.from_, out=self.to)
            np.add(self.to, self.from_, out=self.to)
            return 1e3 * (time.perf_counter() - begun)

        self.ms = min(once() for _ in range(100))
        self.slowness = self.ms / self.USUAL_MS

    def in_time(self, value, most):
        return value <= most * self.slowness

    def as_quick(self, value, least):
        return value >= least / self.slowness


KERNEL = Kernel()


def run(*arguments, **environment):
    try:
        result = subprocess.run([str(a) for a in arguments], stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}, timeout=LONGEST_S)
    except subprocess.TimeoutExpired:
        sys.exit(f"bench: {' '.join(map(str, arguments))} took more than {LONGEST_S} s")
    if result.returncode != 0:
        sys.exit(f"bench: {' '.join(map(str, arguments))} ended with exit code {result.returncode}")
    return result.stdout


def numpy_focal_law_ms():
    """The same law in float64 with numpy's whole-array operations, as a user would write it."""
    rng = np.random.default_rng(1)
    foci = rng.uniform(-0.05, 0.05, (100_000, 3)) + np.array([0.0, 0.0, 0.13])
    grid = (np.arange(10) - 4.5) * 0.01
    elements = np.array([(x, y, 0.0) for y in grid for x in grid])
    times = []
    for _ in range(3):
        begun = time.perf_counter()
        flight = np.sqrt(((foci[:, None, :] - elements[None, :, :]) ** 2).sum(axis=2)) / 343.2
        delay = flight.max(axis=1, keepdims=True) - flight
        ticks = np.rint(np.mod(delay, 25e-6) / 100e-9).astype(np.uint16)
        ticks[ticks == 250] = 0
        times.append(1e3 * (time.perf_counter() - begun))
    return statistics.median(times)


PEERS = ROOT / "build/peers/bin/python3"  # a virtual environment of its own, which `make bench` makes


def peers():
    """What other libraries take, by name; a peer that is not installed is None. numpy is the set-up's, if there is no other."""
    found = json.loads(run(PEERS if PEERS.exists() else sys.executable, ROOT / "tools/bench/peers.py"))
    found["focal_law_ms"] = float(run(PEERS, ROOT / "tools/bench/focal_law_numba.py")) if found["numba"] else None
    return found


def beside(name, theirs, ours):
    """How many times as long a peer took; one that is faster is called so."""
    if theirs is None:
        return f"; {name} is not there"
    faster = "" if theirs >= ours else f": {name} is FASTER"
    times = theirs / ours
    return f"; {name} ×{times:{',.0f' if times >= 100 else '.3g'}}{faster}"


def solve_rows(build, others):
    """The focal law and several foci, on one thread, by the two best instruction sets of the processor."""
    measured = json.loads(run(build / "tools/bench/haptogram_measure_solve"))
    numpy_ms, autd3 = numpy_focal_law_ms(), others["autd3"]
    for place, ours in enumerate(measured):
        best, name = place == 0, ours["target"]
        for ticks, most in ((250, 2.0 if best else 5.0), (1250, 2.6 if best else 5.0)):
            ms = ours[f"focal_law_{ticks}_ms"]
            said = f"{ms:.2f} ms" + beside("numpy float64", numpy_ms, ms) + beside("numba float32 phases", others["focal_law_ms"], ms)
            yield (f"focal law, 100 × 100,000, exact, {ticks} ticks, {name}", f"≤ {most} ms", KERNEL.in_time(ms, most), said)
        for what, most in (("10x249", 8 if best else 15), ("16x256", 12 if best else 24), ("32x249", 30 if best else 60)):
            one = ours[what]
            good = KERNEL.in_time(one["us"], most) and one["spread"] <= 0.002 and one["efficiency"] >= 0.93
            said = f"{one['us']:.1f} µs, CV {one['spread']:.4f} (median of 100 sets; worst {one['worst_spread']:.4f}), efficiency {one['efficiency']:.3f}"
            wgs = others["numpy_wgs"][what]
            said += beside("numpy complex64, 200 rounds of WGS", wgs["us"], one["us"]) + f", its CV {wgs['spread']:.1g}"
            if what == "10x249":
                said += beside("AUTD3's GS-PAT", autd3 and autd3["us"], one["us"]) + (f", its CV {autd3['spread']:.3f}" if autd3 else "")
            yield (f"{what.replace('x', ' foci × ')} elements, rounded to 250 ticks, {name}", f"≤ {most} µs, CV ≤ 0.002, efficiency ≥ 0.93", good, said)
        one, most = ours["10x249_warm"], 4 if best else 8
        good = KERNEL.in_time(one["us"], most) and one["worst_spread"] <= 0.002 and one["efficiency_over_solved"] >= 0.99
        yield (f"the same ten foci, moved by 0.2 mm, begun from the last, {name}", f"≤ {most} µs, CV ≤ 0.002", good,
               f"{one['us']:.1f} µs, CV {one['spread']:.5f} (worst of 1,000 frames {one['worst_spread']:.4f}), "
               f"efficiency {one['efficiency_over_solved']:.3f} of that from nothing")  # fmt: skip


def scatter_rows(build):
    """Boundary elements on a finger, on one thread."""
    ours = json.loads(run(build / "tools/bench/haptogram_measure_scatter"))
    yield (f"rigid finger, {ours['triangles']} triangles × 10 foci, with its matrix", "≤ 0.8 s", KERNEL.in_time(ours["cold_s"], 0.8), f"{ours['cold_s']:.2f} s")
    yield ("each ten foci more, once the matrix is factorised", "≤ 50 ms", KERNEL.in_time(ours["further_s"], 0.05),
           f"{ours['further_s'] * 1e3:.0f} ms; factorising takes {ours['factorise_s']:.2f} s")  # fmt: skip


def live_rows(build):
    """Depth pictures of a hand with two fingers on a cube to the paths of their rings, on one thread."""
    ours = json.loads(run(build / "tools/bench/haptogram_measure_live"))
    for name, what, most in (("one_640", "depth picture of 640 × 480 → rings", 5), ("four_848", "four depth pictures of 848 × 480 → rings", 15)):
        one = ours[name]
        yield (what, f"≤ {most} ms", KERNEL.in_time(one["ms"], most) and one["rings"] > 0, f"{one['ms']:.1f} ms; {one['points']:,} points, {one['rings']} rings")
    for name, what in (("weigh_tile", "tile-10x10"), ("weigh_cube", "cube-300")):
        yield (f"ring of ten foci weighed, {what}", "≤ 0.1 ms", KERNEL.in_time(ours[name], 0.1), f"{ours[name]:.3f} ms")


FRAME_HZ, FRAMES = 110, 10_000


def tracked_frame(number):
    """A Leap's message: an open right hand that rocks on the upper face of the cube of TOUCH."""
    joints = ("mcpPosition", "pipPosition", "dipPosition", "tipPosition")
    height = 191.0 + 5.0 * math.sin(2 * math.pi * 0.7 * number / FRAME_HZ)
    fingers = [{"id": 10 + k, "handId": 1, "type": k, "width": 16.0, **{name: [20.0 * (k - 2), height, -10.0 - 25.0 * i] for i, name in enumerate(joints)}} for k in range(5)]
    palm = {"id": 1, "type": "right", "palmPosition": [0.0, height + 20.0, 60.0], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [0, 0, 0]}
    return json.dumps({"id": number, "timestamp": 1_000_000 + round(1e6 * number / FRAME_HZ), "hands": [palm], "pointables": fingers}) + "\n"


TOUCH = ("--object", "cube", "--size", 80, "--center", "0,40,160")


def touched(program, *words):
    """What `live` reports; whatever it says meanwhile is of no interest here."""
    result = subprocess.run([str(word) for word in (program, "live", *words, "--json")], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=LONGEST_S)
    if result.returncode != 0:
        sys.exit(f"bench: live {' '.join(map(str, words))} ended with exit code {result.returncode}")
    return json.loads(result.stdout)


def touch_rows(program, folder):
    """Frames to first pulses. In the board's time nothing is computed; what a frame takes of the processor stands beside it. On a virtual
    board, in real time, all of it counts."""
    file = folder / "hand.jsonl"
    file.write_text("".join(map(tracked_frame, range(FRAMES))))

    def in_its_time(what, median, most, *words):
        told = touched(program, *words)
        found, computed = told["latency_ms"], told["compute_ms"]
        return (f"{what}, the board's time", f"median ≤ {median} ms, most ≤ {most} ms", found["median"] <= median and found["most"] <= most,
                f"{found['median']:.1f} ms, most {found['most']:.1f} ms of {found['rings']:,} paths of {told['shots'] + told['skipped']:,} frames; "
                f"{computed['median']:.2f} ms, most {computed['most']:.2f} ms of the processor")  # fmt: skip

    for board, about in (("tile-100-3m", "records at 3 Mbaud"), ("tile-100-wide", "foci at 1 Mbaud")):
        for algorithm in "AH":
            yield in_its_time(f"skeleton → path of {algorithm} → first pulse, {about}", 12, 20,
                              "--from", f"leap-pipe:{file}", "--algorithm", algorithm, *TOUCH, "--port", f"reference:{board}")  # fmt: skip
        yield in_its_time(f"depth picture of 640 × 480 → ring → first pulse, {about}", 15, 25,
                          "--from", "fingers:press", "--cameras", 1, "--seconds", 10, "--size", 60, "--center", "0,0,170", "--port", f"reference:{board}")  # fmt: skip
    told = touched_in_real_time(program, folder)
    found, lost = told.get("stamped_latency_ms"), told["lost"] + told["skipped"]
    begins = f"a path of A begins after {found['median']:.1f} ms, most {found['most']:.1f} ms, ± {found['uncertain']:.1f}" if found else "no path's beginning was told"
    yield (f"frames at {FRAME_HZ} Hz lost from a pipe, one core busy beside, board run --model reference", "0", lost == 0,
           f"{lost} of {told['shots'] + lost:,}, {told['missed']} paths too late, {told['underruns']} underruns; {begins}")


def touched_in_real_time(program, folder):
    """Frames at their pace to a virtual board that computes foci and counts carrier periods, while another process computes."""
    port = folder / "touched"
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    board = subprocess.Popen([program, "board", "run", "--model", "reference", "--board", "tile-100-wide", "--pty", port], stdout=subprocess.PIPE)
    try:
        board.stdout.readline()
        command = [program, "live", "--from", "leap-pipe:-", "--algorithm", "A", *map(str, TOUCH), "--port", port, "--watchdog", "5000", "--json"]
        host = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        begun = time.perf_counter()
        for number in range(FRAMES):
            time.sleep(max(0.0, begun + number / FRAME_HZ - time.perf_counter()))
            host.stdin.write(tracked_frame(number).encode())
            host.stdin.flush()
        said, trouble = host.communicate(timeout=60)
        if host.returncode != 0:
            sys.exit(f"bench: live ended with exit code {host.returncode}: {trouble.decode().splitlines()[-1]}")
    finally:
        busy.kill()
        board.send_signal(signal.SIGINT)
        board.communicate()
    return json.loads(said)


def robot_rows(build):
    """The cable robot, on one thread."""
    ours = json.loads(run(build / "tools/bench/haptogram_measure_robot"))
    times = {name: ours[f"tension_{name}_us"] for name in ("norm", "sum", "centroid", "paper")}
    yield ("cable robot: tensions of a wrench, by any choice", "≤ 20 µs", KERNEL.in_time(max(times.values()), 20),
           ", ".join(f"{name} {us:.1f} µs" for name, us in times.items()))  # fmt: skip
    good = ours["forward_steps"] <= 5 and max(ours["forward_error_m"], ours["forward_error_rad"]) < 1e-12
    yield ("cable robot: forward kinematics from the centre", "≤ 5 steps, pose error < 1e-12", good,
           f"{ours['forward_steps']} steps at most of {ours['forward_poses']} poses within 60 mm and 15°, {ours['forward_error_m']:.1e} m, {ours['forward_error_rad']:.1e} rad")
    yield ("cable robot: workspace, 30 mm grid, 27 orientations", "≤ 1 s", KERNEL.in_time(ours["workspace_s"], 1.0),
           f"{ours['workspace_s']:.2f} s for {ours['workspace_cubes']} useful cubes")  # fmt: skip


def bumpy_ball(path):
    """A closed mesh of 100,800 triangles, 100 mm large, with hollows, as a binary PLY."""
    rows, columns = 226, 225  # the first and the last row are the poles
    u, v = np.linspace(0.0, np.pi, rows)[:, None], np.arange(columns)[None, :] * 2 * np.pi / columns
    r = 50.0 * (1.0 + 0.2 * np.sin(5 * v) * np.sin(u) ** 2 * np.cos(3 * u))
    points = np.stack([r * np.sin(u) * np.cos(v), r * np.sin(u) * np.sin(v), r * np.cos(u)], axis=2).reshape(-1, 3)
    number = np.arange(rows * columns).reshape(rows, columns)
    number[0], number[-1] = number[0, 0], number[-1, 0]
    a, c = number[:-1], number[1:]
    b, d = np.roll(a, -1, axis=1), np.roll(c, -1, axis=1)
    corners = np.concatenate([np.stack([a, c, d], 2)[:-1], np.stack([a, d, b], 2)[1:]]).reshape(-1, 3)
    triangles = corners.astype("<i4")
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(header.encode("ascii") + points.astype("<f4").tobytes() + faces.tobytes())
    return len(faces)


def render_rows(program, folder):
    """Frames of a hand that presses on an object to paths, on one thread: the slowest frame, each at its best of five runs. The
    first of a process is told apart: it also pays for pages of memory and code that are touched for the first time."""
    mesh = folder / "ball.ply"
    triangles = bumpy_ball(mesh)
    for name, most, objects in (("analytic objects", 1, ("sphere", "cube", "cone", "pyramid", "cylinder")), (f"a mesh of {triangles:,} triangles", 5, (mesh,))):
        worst, first = {}, 0.0
        for algorithm in "AH":
            for thing in objects:
                runs = [json.loads(run(program, "render", thing, "--hand", "synthetic:press", "--algorithm", algorithm, "-o", folder / "touch.json", "--report", "--json"))
                        for _ in range(5)]  # fmt: skip
                cold, *warm = (min(times) for times in zip(*([f["compute_ms"] for f in r["frames"] if f["lines"]] for r in runs)))
                first, worst[algorithm] = max(first, cold), max(worst.get(algorithm, 0.0), *warm)
        said = ", ".join(f"{algorithm} {ms:.2f} ms" for algorithm, ms in worst.items())
        yield (f"a hand's frame → path by A or H, {name}", f"≤ {most} ms", KERNEL.in_time(max(worst.values()), most), f"{said} for the slowest frame; {first:.2f} ms for the first of a process")


def compile_million_s(program, folder):
    """A cloud of 10^6 points (binary PLY) to 200 points: whole program, median of three."""
    rng = np.random.default_rng(3)
    direction = rng.normal(size=(1_000_000, 3))
    cloud = (40.0 * direction / np.linalg.norm(direction, axis=1, keepdims=True) + [0.0, 0.0, 150.0]).astype("<f4")
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(cloud)}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    path = folder / "million.ply"
    path.write_bytes(header.encode("ascii") + cloud.tobytes())
    times = []
    for _ in range(3):
        begun = time.perf_counter()
        run(program, "compile", path, "--points", 200, "-o", folder / "million.hex")
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def simulate(program, folder, rate):
    image = folder / "circle.hex"
    run(program, "compile", "--shape", "circle", "--diameter", 70, "--points", 200, "--rate", rate, "-o", image)
    report = json.loads(run(program, "simulate", image, "--pulses", folder / "pulses.csv", "--json"))
    return report


def board_run_mclk_per_s(program, folder):
    """`board run --speed max` with a host that plays 200 points on it."""
    port = folder / "port"
    board = subprocess.Popen([str(program), "board", "run", "--json", "--speed", "max", "--image", str(folder / "circle.hex"), "--pty", str(port)],
                             stdout=subprocess.PIPE, text=True)  # fmt: skip
    board.stdout.readline()
    host = subprocess.Popen([str(program), "play", "--port", str(port), "--loops", "0"], stdout=subprocess.PIPE)
    time.sleep(8)
    host.send_signal(signal.SIGINT)
    host.communicate()
    board.send_signal(signal.SIGINT)
    return json.loads(board.communicate()[0])["playing_mclk_per_s"]


def reference_times_real_time(program, folder, image, board=None, tiles=1):
    """`board run --model reference --speed max` with a host that plays an image on it; on several tiles with everything, a rig's."""
    ports = [folder / f"reference-{i}" for i in range(1, tiles + 1)]
    which = ["--tiles", tiles, "--pty", folder / "reference"] if tiles > 1 else ["--board", board, "--pty", ports[0]]
    command = [program, "board", "run", "--model", "reference", "--json", "--speed", "max", *which]
    board = subprocess.Popen([str(c) for c in command], stdout=subprocess.PIPE, text=True)
    board.stdout.readline()
    port_options = [word for port in ports for word in ("--port", port)]
    rig = ["--rig", folder / image] if tiles > 1 else []
    run(program, "upload", *(rig or [folder / image]), *port_options)
    play = [program, "play", *rig, *port_options, "--loops", 0, "--watchdog", 0]
    host = subprocess.Popen([str(c) for c in play], stdout=subprocess.PIPE)
    time.sleep(8)
    host.send_signal(signal.SIGINT)
    host.communicate()
    board.send_signal(signal.SIGINT)
    said = json.loads(board.communicate()[0])
    return said["times_real_time" if tiles > 1 else "playing_times_real_time"]


def link_rows(build):
    """What a host gets through the link, in the simulated board's time."""
    found = json.loads(run(build / "tools/bench/haptogram_measure_link"))
    uploads, stream, select = found["upload"], found["stream"], found["select"]
    spread = ", ".join(f"{percent} %: {clocks}" for percent, clocks in select["percentiles"].items())
    whole = ", ".join(f"{100 * u['with_digests']:.1f} %" for u in uploads)
    return [
        ("upload payload over what 8N1 allows, 1 and 3 Mbaud, window open", "≥ 95 %", all(u["writing"] >= 0.95 for u in uploads),
         ", ".join(f"{100 * u['writing']:.1f} %" for u in uploads) + f" while writing; with the digests before and after {whole}"),
        ("indices streamed at 1 Mbaud", "≥ 40,000 /s, no underrun",
         stream["per_second"] >= 39_999.9 and stream["underruns"] == 0 and stream["cycles"] == stream["cycles_in_order"] == stream["indices"],
         f"{stream['per_second']:,.0f} /s, {stream['underruns']} underruns in {stream['indices']:,}, each in its own carrier period"),
        ("end of a SELECT frame → first pulse of the new focus", f"≤ {select['bound']:,} clocks", select["percentiles"]["100"] <= select["bound"],
         f"clocks not exceeded by {spread} of {select['selects']:,} random phases"),
    ]  # fmt: skip


def field_rows(build, others):
    """Fields, in single precision on one thread unless said, each beside numpy and numba on one thread."""
    ours = json.loads(run(build / "tools/bench/haptogram_measure_field"))
    theirs = json.loads(run(sys.executable, ROOT / "tools/bench/field_numpy.py", OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1"))
    numba = others["numba"] or {}

    def row(what, most, name, numpy_name, numpy_what, numba_name=None, scaled="", also=True, said=""):
        ms = ours[f"{name}_ms"]
        measured = f"{ms:.2f} ms ({ours['target']}){said}" + beside(f"numpy {numpy_what}", theirs[f"{numpy_name}_ms"], ms) + scaled
        if numba_name:
            measured += beside("numba float32", numba.get(f"{numba_name}_ms"), ms)
        return (what, f"≤ {most:,} ms", KERNEL.in_time(ms, most) and also, measured)

    def on_grid(what, most, name, *numpy_and_numba, scaled=""):
        """A field on a grid, whose error is measured against the sums at the same points."""
        apart, stated = ours[f"{name}_apart"], ours[f"{name}_error"]
        allowed = 1e-4 if stated < 1e-3 else 0.015  # the latter by a polynomial in place of a measured pattern
        said = f", error {apart:.0e} ({stated:.0e} stated)"
        return row(what, most, name, *numpy_and_numba, scaled=scaled, also=apart <= allowed, said=said)

    plane, measured = ("plane_float32", "float32", "plane"), ("measured_float32", "float32", "measured")
    volume, planes = ("volume_float32", "float32", "volume"), " (5 planes, scaled)"
    memory = ours["large_memory_over_output"]
    return [
        row("piston field, 100 elements × 200×200 points, any points", 4, "points", *plane),
        on_grid("the same on an axis-aligned plane, 130 mm away", 0.15, "plane", *plane),
        on_grid("the same three wavelengths away", 0.15, "near_plane", *plane),
        on_grid("the same on an oblique plane", 1.6, "oblique_plane", *plane),
        on_grid("324 elements with a measured pattern, axis-aligned plane", 5, "measured", *measured),
        on_grid("the same on an oblique plane", 5, "measured_oblique", *measured),
        on_grid("the same by a polynomial in place of the table", 5, "fitted_oblique", *measured),
        row("piston field, 100 elements × 100³ points, any points", 40, "volume_points", *volume, scaled=planes),
        on_grid("the same on an axis-aligned grid, elements in any order", 40, "volume_listed", *volume, scaled=planes),
        on_grid("the same on the array's own grid", 8, "volume", "volume_shifted", "complex64 by shifts", scaled=planes),
        row("32×32 elements × 200³ points on the array's grid, 2 threads", 3000, "large_shifted_2_threads", "large_shifted", "complex64 by shifts",
            scaled=" (1 thread, 1 plane, scaled)", also=memory <= 1.1, said=f", {memory:.2f} of the output's memory with it"),
        row("mean square of a sequence of 200 points, 100×100 points", 100, "mean_square", "mean_square", "complex64"),
    ]  # fmt: skip


def sweep_rows(build):
    """A sweep of 1,000 configurations of some 15 ms each, by one worker and by two. Starting the workers is not counted."""
    found = json.loads(run(sys.executable, ROOT / "tools/bench/sweep.py", "--build", build))
    one, two = found["seconds"]["1"], found["seconds"]["2"]
    whole = f"{found['whole_seconds']['1'] / found['whole_seconds']['2']:.2f} with the start of the workers"
    yield ("sweep of 1,000 configurations, 2 workers over one", "≥ 1.8", one / two >= 1.8 and found["same"],
           f"{one / two:.2f}: {one:.1f} s and {two:.1f} s, the same rows; {whole}")  # fmt: skip


def patch_s(program, folder, board):
    """A compiled image into a bitstream that is already placed: whole program, median of five after one."""
    image = folder / f"{board}.hex"
    run(program, "compile", "--shape", "circle", "--diameter", 50, "--points", 40, "--board", board, "-o", image)
    times = []
    for _ in range(6):
        begun = time.perf_counter()
        run(program, "bitstream", "--board", board, "--image", image, "--placed", BOARDS, "-o", folder / "patched")
        times.append(time.perf_counter() - begun)
    return statistics.median(times[1:])


def board_rows(program, folder):
    """What was built into build/boards. The numbers of cells and of Fmax are those of that build."""
    for report in sorted(BOARDS.glob("*/report.json")):
        built = json.loads(report.read_text(encoding="utf-8"))
        if built["core_alone"]:
            continue
        board, used, fmax = built["board"], built["cells"], built["fmax_mhz"]
        most = boards.load(board)["budget"]["cells"]
        yield (f"{board}: cells", f"≤ {most:,}", used <= most, f"{used:,} of {built['cells_available']:,}")
        yield (f"{board}: lowest Fmax", f"≥ {fmax['goal']:.1f} MHz", fmax["lowest"] >= fmax["goal"], f"{fmax['lowest']:.1f} MHz over {fmax['seeds']} seeds")
        seconds = patch_s(program, folder, board)
        yield (f"{board}: image → patched bitstream", "≤ 1 s", KERNEL.in_time(seconds, 1.0), f"{seconds:.2f} s")


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def core_rows(build, program, folder):
    """The core as it is simulated, and the virtual board at its fastest."""
    own = json.loads(run(build / "tools/bench/haptogram_measure"))
    slow = [simulate(program, folder, 10) for _ in range(3)]
    fast = simulate(program, folder, 200)
    every_cycle = fast["contract_violations"] == 0 and fast["board"]["underruns"] == 0
    yield ("index known → record loaded, 100 channels", "≤ 108 clocks", own["load_clocks"] <= 108,
           f"{own['load_clocks']} clocks: the shortest cycle in which every record is in time, less the pulse's after its first")  # fmt: skip
    yield ("focus changes from memory", "40,000 /s, zero dead time", every_cycle,
           "40,000 /s: a new record in each of 200 successive cycles of 1,250 clocks" if every_cycle else "; ".join(fast["violations"]))  # fmt: skip
    yield ("pulses of 200 points × 100 channels equal to the image", "all", all(r["contract_violations"] == 0 and r["pulses_equal_to_image"] > 390_000 for r in slow),
           f"{slow[0]['pulses_equal_to_image']} of {slow[0]['pulses']} measured, {slow[0]['contract_violations']} violations")  # fmt: skip
    yield ("pressure at the asked point over ideal", "≥ 99.9 %", slow[0]["points_checked"] == 200 and slow[0]["least_pressure_kept"] >= 0.999,
           f"{100 * slow[0]['least_pressure_kept']:.4f} % for the worst point")  # fmt: skip
    yield ("lateral peak from the ideal one", "≤ 0.2 mm", slow[0]["points_checked"] == 200 and slow[0]["worst_focus_error_mm"] <= 0.2,
           f"{slow[0]['worst_focus_error_mm']:.4f} mm for the worst point")  # fmt: skip
    speed = statistics.median(r["playing_mclk_per_s"] for r in slow)
    yield ("co-simulation, 100 channels, pulses recorded, one thread", "≥ 5 Mclk/s", KERNEL.as_quick(speed, 5.0),
           f"{speed:.2f} Mclk/s, {speed / 50.0:.3f} of real time (three runs: " + ", ".join(f"{r['playing_mclk_per_s']:.2f}" for r in slow) + ")")  # fmt: skip
    virtual = board_run_mclk_per_s(program, folder)
    yield ("board run --speed max, 100 channels playing", "≥ 5 Mclk/s", KERNEL.as_quick(virtual, 5.0), f"{virtual:.2f} Mclk/s")
    wide = ("--shape", "circle", "--points", 200, "--rate", 100, "--am", "sine:200")
    run(program, "compile", *wide, "--array", "tile-10x10", "--board", "tile-100-wide", "-o", folder / "foci.hex")
    run(program, "compile", *wide, "--rig", "2x2", "-o", folder / "wall.hex")
    for image, board, tiles, most, what in (
        ("circle.hex", "tile-100", 1, 1.0, "board run --model reference, 100 channels playing"),
        ("foci.hex", "tile-100-wide", 1, 1.0, "the same with foci and modulation"),
        ("wall.json", None, 4, 0.5, "the same with four tiles in step"),
    ):
        times = reference_times_real_time(program, folder, image, board, tiles)
        yield (what, f"≥ {most} of real time", KERNEL.as_quick(times, most), f"{times:.2f} of real time")


def compile_rows(program, folder):
    seconds = compile_million_s(program, folder)
    yield ("compile of 10^6 points to 200", "≤ 2 s", KERNEL.in_time(seconds, 2.0), f"{seconds:.2f} s")


# What can be measured by itself, in the order of the table, and what is said meanwhile.
PARTS = {
    "core": ("the simulated core, and the virtual board", lambda at: core_rows(at.build, at.program, at.folder)),
    "solve": ("focal law and several foci, and the law in numpy", lambda at: solve_rows(at.build, at.peers())),
    "field": ("fields, and fields in numpy", lambda at: field_rows(at.build, at.peers())),
    "link": ("upload, stream and select over the link", lambda at: link_rows(at.build)),
    "robot": ("the cable robot", lambda at: robot_rows(at.build)),
    "live": ("depth to rings", lambda at: live_rows(at.build)),
    "touch": ("frames to first pulses, six minutes", lambda at: touch_rows(at.program, at.folder)),
    "render": ("hands on objects to paths", lambda at: render_rows(at.program, at.folder)),
    "sweep": ("a sweep", lambda at: sweep_rows(at.build)),
    "scatter": ("boundary elements", lambda at: scatter_rows(at.build)),
    "compile": ("compile of a million points", lambda at: compile_rows(at.program, at.folder)),
    "boards": ("images into bitstreams", lambda at: board_rows(at.program, at.folder)),
}


def say(what):
    print(f"bench: {what}", file=sys.stderr)


class Place:
    """Where the programs are, and a folder to work in. Peers are measured once, when the first part asks for them."""

    def __init__(self, build, folder):
        self.build, self.program, self.folder, self.found = build, build / "host/cli/haptogram", folder, None

    def peers(self):
        if self.found is None:
            say("peers")
            self.found = peers()
        return self.found


def measure(build, only):
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        place = Place(build, pathlib.Path(folder))
        for name, (what, part) in PARTS.items():
            if not only or name in only:
                KERNEL.measure()
                say(f"{what}; the reference kernel takes {KERNEL.ms:.2f} ms, ×{KERNEL.slowness:.2f} of the targets' machine")
                rows += [(*row, KERNEL.slowness) for row in part(place)]
    return {"processor": processor(), "rows": [dict(zip(("what", "target", "reached", "measured", "slowness"), row)) for row in rows]}


def table(result):
    """The rows as docs/measurements.md has them."""
    lines = ["| what | target | measured |", "|---|---|---|"]
    for row in result["rows"]:
        lines.append(f"| {row['what']} | {row['target']} | {'' if row['reached'] else '**missed**: '}{row['measured']} |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    parser.add_argument("--only", nargs="*", choices=list(PARTS), metavar="PART", help=f"only these parts: {', '.join(PARTS)}")
    arguments = parser.parse_args()
    result = measure(arguments.build, arguments.only)
    arguments.output.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    slowness = [row["slowness"] for row in result["rows"]]
    told = f"the reference kernel took ×{min(slowness):.2f} to ×{max(slowness):.2f} of the targets' machine, and times are judged by that"
    print(f"on {result['processor']}; {told}\n\n{table(result)}\n\nwritten to {arguments.output}")


if __name__ == "__main__":
    main()
