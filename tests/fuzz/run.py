#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the fuzzers with clang, runs each from small sound files on, and prints what it did. Ends with 1 when one found
something; what it found stays in build/fuzz/findings. A failure other than an Error is a finding, whose fix gets a case in tests/unit.
FUZZ_RUNS is how often each runs: 20,000 in `make deep`, 10,000,000 in `make soak`."""

import argparse
import concurrent.futures
import io
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path

from intelhex import IntelHex

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
import brought_shapes  # noqa: E402

TARGETS = ("frame", "intel_hex", "pulses", "manifest", "ply", "obj", "stl", "off", "pcd", "gltf", "svg", "three_mf", "three_mf_model", "xyz", "csv", "array", "board", "project",
           "path", "path_csv", "adaptics", "wav", "leap", "leap_message", "joints", "depth_png", "cameras", "depth_pipe", "message")  # fmt: skip
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SOUND_CAMERAS = b"""format = "haptogram-depth-1"
rate_hz = 30
[[camera]]
folder = "camera1"
width = 640
height = 480
focal_px = [476.007, 476.007]
centre_px = [313.683, 242.755]
unit_mm = 0.125
baseline_mm = 50
position_mm = [0, 1.5, -300]
right = [1, 0, 0]
forward = [0, 0.6, 0.8]
"""
SMALL_CAMERAS = SOUND_CAMERAS.replace(b"640", b"4").replace(b"480", b"3")
JOINTS = ("wrist", "palm", "index_proximal", "middle_proximal", "little_proximal", "index_intermediate", "index_distal", "index_tip",
          *(f"thumb_{bone}" for bone in ("metacarpal", "proximal", "distal", "tip")), *(f"{finger}_{bone}" for finger in ("middle", "little") for bone in ("intermediate", "distal", "tip")))  # fmt: skip
SOUND_HANDS = {
    "timestamp": 5,
    "hands": [{"id": 7, "type": "left", "palmPosition": [1, 200, 30], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [9, 0, 0]}],
    "pointables": [{"id": 71, "handId": 7, "mcpPosition": [0, 200, 0], "pipPosition": [0, 200, -40], "dipPosition": [0, 200, -65], "tipPosition": [0, 200, -85]}],
}


def sound_hex():
    """Two records of two channels, by rtl/INTERFACE.md."""
    image = IntelHex()
    image.puts(0, struct.pack("<12H", 250, 125 << 8, 5, 0, 1, 2, 250, 125 << 8, 5, 0, 3, 4))
    image.puts(0x10000000, struct.pack("<6H", 2, 0, 1, 4, 2, 4))
    image.puts(0x40000000, struct.pack("<8H", 0x4748, 1, 2, 2, 3, 8 << 8 | 16, 50_000_000 & 0xFFFF, 50_000_000 >> 16))
    text = io.StringIO()
    image.write_hex_file(text, write_start_addr=False)
    return text.getvalue().encode()


def sound_foci_hex():
    """A record of amplitudes, two focus records of two foci, and two samples of modulation, for two channels."""
    image = IntelHex()
    amplitudes = struct.pack("<6H", 1250, 0, 1, 1 << 8, 0xFF40, 0x80C0)
    foci = struct.pack("<16H", 128, 256, 12800, 0xFF00, 0xFF80, 0, 12800, 0x800C, *[0, 0, 12800, 0x4000] * 2)
    image.puts(0, amplitudes + bytes(4) + foci)
    image.puts(0x10000000, struct.pack("<8H", 3, 0, 1, 4, 257, 2, 258, 1))
    image.puts(0x40000000, struct.pack("<11H", 0x4748, 2, 2, 1, 4, 8 << 8 | 11, 50_000_000 & 0xFFFF, 50_000_000 >> 16, 256, 2, 40))
    image.puts(0x50000000, struct.pack("<11H", 2, 2, 1, 1250, 0xDF4B, 1, 38000, 0, 65535, 65535, 1))
    image.puts(0x60000000, struct.pack("<8H", 0xFD80, 0, 0, 0, 640, 0, 0, 0))
    image.puts(0x70000000, b"\x00\xff")
    text = io.StringIO()
    image.write_hex_file(text, write_start_addr=False)
    return text.getvalue().encode()


def sound_pattern():
    """A pattern of the AdapTics designer: two key frames and a stop."""

    def number(value):
        return {"type": "f64", "value": value}

    def frame(time, x):
        linear = {"name": "linear", "params": {}}
        return {
            "type": "standard", "time": time, "cjumps": [], "coords": {"coords": {"x": x, "y": 0, "z": 0}, "transition": linear},
            "brush": {"brush": {"name": "circle", "params": {"radius": number(5), "am_freq": number(50)}}, "transition": linear},
            "intensity": {"intensity": {"name": "constant", "params": {"value": number(1)}}, "transition": linear},
        }  # fmt: skip

    xyz = {axis: number(1) for axis in "xyz"}
    return {
        "$DATA_FORMAT": "MidAirHapticsAnimationFileFormat", "$REVISION": "0.1.0-alpha.2", "name": "two places", "user_parameter_definitions": {},
        "keyframes": [frame(0, -10), frame(20, 10), {"type": "stop", "time": 30}],
        "pattern_transform": {"geometric_transforms": {"translate": xyz, "rotation": number(0), "scale": xyz}, "intensity_factor": number(1), "playback_speed": number(1)},
    }  # fmt: skip


def sound_depth(colour=0, bits=16, interlaced=0, level=0):
    """A depth picture of 4 x 3 counts; with level 0 its counts stand in it as they are."""
    counts = [[0, 1, 3000 + row, 65535] for row in range(3)]
    if interlaced:  # the passes that a picture of this size has
        counts = [counts[0][:1], counts[0][2:3], counts[2][::2], counts[0][1::2], counts[2][1::2], counts[1]]
    rows = b"".join(b"\0" + struct.pack(f">{len(row)}H", *row) for row in counts)
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))  # noqa: E731
    header = struct.pack(">2I5B", 4, 3, bits, colour, 0, 0, interlaced)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"gAMA", struct.pack(">I", 45455)) + chunk(b"IDAT", zlib.compress(rows, level)) + chunk(b"IEND", b"")


def sound_messages():
    """A message of each kind that the studio's page may send, by extras/studio/engine/messages.hpp."""
    shapes = [{"kind": "circle", "diameter_mm": 30, "center_mm": [0, 0, 120]}, {"file": "a.ply", "unit": "cm", "rotate_deg": [0, 90, 0]}]
    document = {"format": "haptogram-project-1", "points": 9, "rate_hz": 7.5, "am": "sine:200", "place": {"size_mm": 40, "center_mm": [0, 1.5, 130]}, "shape": shapes}
    path = {"format": "haptogram-project-1", "path": "a.json", "array": "hoshi-18x18"}
    of_scene = {
        "slice": {"origin": [-80, -80, 130], "u": [160, 0, 0], "v": [0, 1.6e2, 0], "width": 200, "height": 100, "record": 0, "view": 1},
        "reach": {"origin": [-80, -80, 130], "u": [160, 0, 0], "v": [0, 0, 60], "width": 48, "height": 48, "view": 0},
        "drives": {"record": 7}, "analyze": {}, "simulate": {}, "connect": {"port": "virtual"}, "upload": {}, "play": {}, "modulate": {}, "stream": {"index": 7},
    }  # fmt: skip
    others = {
        "cancel": {"what": "analyze"}, "pulses": {"index": 7, "periods": 2}, "disconnect": {}, "studies": {}, "intensity": {"value": 0.5},
        "study": {"protocol": "haptogram_shapes", "participant": 3, "seed": 7, "results": "p3.jsonl", "port": "studio"},
        "answer": {"number": 5, "text": "soft\n\u00fc"}, "leave": {}, "stop": {},
    }  # fmt: skip
    found = [{"t": "scene", "n": 1, "document": document}, {"t": "scene", "n": 2, "document": path}, {"t": "beat", "hidden": False}]
    found += [{"t": kind, "n": 3, "scene": "abc", **members} for kind, members in of_scene.items()]
    return found + [{"t": kind, "n": 4, **members} for kind, members in others.items()]


def brought():
    """Clouds of cameras, a model of two parts, scenes, and a drawing of every command."""
    points = [tuple(map(float, p)) for p in CUBE]
    faces, corners = [(0, 1, 2), (1, 2, 3)], [0, 1, 2, 1, 2, 3]
    parts = (f'<object id="1">{brought_shapes.mesh_xml(points, faces)}</object><object id="2"><components><component objectid="1" transform="0 1 0 -1 0 0 0 0 2 1 2 3"/>'
             '<component objectid="1"/></components></object>')  # fmt: skip
    model = brought_shapes.model_xml(parts, '<item objectid="2"/>', "inch")
    nodes = [{"children": [1], "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8]}, {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}]
    drawing = ('<g transform="translate(1 2) scale(2) rotate(30 1 1) skewX(5) matrix(1 0 0 1 2 3)" fill="none" stroke="#000"><path id="p" d="M1 2h3v4l5-6C1 2 3 4 5 6s1 2 3 4Q1 2 3 4t5 6A3 2 30 0 1 8 9z"/></g>'
               '<rect width="9" height="8" rx="2"/><circle r="3"/><ellipse rx="3" ry="2"/><line x1="1"/><polyline points="1 2 3 4"/><polygon points="1,2 3,4 5,6"/><use href="#p" x="3"/>')  # fmt: skip
    return {
        "pcd": [brought_shapes.pcd(points, data, extra=extra) for data in ("ascii", "binary", "binary_compressed") for extra in (False, True)],
        "three_mf": [brought_shapes.three_mf(model)], "three_mf_model": [model.encode()],
        "gltf": [brought_shapes.gltf(points, corners, buffer, mode, nodes)[0] for buffer in ("embedded", "glb") for mode in (1, 4, 5)],
        "svg": [brought_shapes.svg(drawing), brought_shapes.svg('<path d="M0 0a1 1 0 0 1 2 2"/>', 'width="3in" viewBox="0 0 9 9"')],
    }  # fmt: skip


def seeds(program):
    """Small sound files, each of another kind."""
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE)
    binary = b"".join(struct.pack("<3f", *point) for point in CUBE)
    header = "ply\nformat {} 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n{}end_header\n"
    face = "element face 1\nproperty list uchar int vertex_indices\n"
    facet = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    found = {
        "frame": [b"\x06\x01\x82\x02\x08\x2c\x01\x00", bytes(range(1, 255)), b"\x01\x01\x00"],
        "intel_hex": [sound_hex(), sound_foci_hex()],
        "pulses": [b"channel,rise_clk,fall_clk,index\n0,10,20,1\n3,11,25,2\n"],
        "ply": [(header.format("ascii", "") + rows).encode(), header.format("binary_little_endian", "").encode() + binary,
                (header.format("ascii", face) + rows + "3 0 1 2\n").encode(), header.format("binary_little_endian", face).encode() + binary + struct.pack("<B3i", 3, 0, 1, 2),
                (header.format("ascii", face.replace("face", "tristrips")) + rows.replace("\n", " ") + "\n9 0 1 2\n3 -1\n4 5\n6 7\n").encode(),
                header.format("ascii", "").replace("element", face + "comment faces first\nelement", 1).replace("end_header\n", "end_header\n4 0 1 3 2\n").encode() + rows.encode()],
        "obj": [("".join(f"v {x} {y} {z}\n" for x, y, z in CUBE) + "f 1 2 3\nf 1/1 2//3 -1 4\n").encode(),
                b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 \\\n0\nf 1 2 \\\n3 4\n"],
        "stl": [b"\0" * 80 + struct.pack("<I", 1) + facet,
                b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"],
        "off": [b"OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", b"COFF 1 0 0\n# a point\n1 2 3 255 0 0 255\n"],
        **brought(),
        "xyz": [rows.encode(), b"# points\n1.5e1 -2 .3 7\n"],
        "csv": [b"x,y,z\n1,2,3\n", b"a;z;y;x\n0;1;2;3\n"],
        "array": [path.read_bytes() for path in sorted((ROOT / "host/arrays").glob("*.toml"))],
        "board": [path.read_bytes() for path in sorted((ROOT / "constraints").glob("*.toml"))],
        "project": [b'format = "haptogram-project-1"\npoints = 12\nrate_hz = 50.5\nclip = true\n[place]\ncenter_mm = [0, 1.5, 120]\nsize_mm = 40\n'
                    b'[[shape]]\nkind = "circle"\ndiameter_mm = 40\n[[shape]]\nfile = "a b.ply"\nunit = "cm"\n',
                    b'format = "haptogram-project-1"\nspeed_m_s = 7\njump = "blank"\neven = true\nam = "sine:200"\nam_law = "radiation"\namplitude = 0.5\n[[shape]]\nkind = "plus"\n',
                    b'format = "haptogram-project-1"\npath = "a.json"\n'],
        "path": [b'{"format": "haptogram-path-1", "carrier_hz": 40000, "steps": [{"periods": 6, "foci": [{"position_mm": [1, 2.5, 130], "amplitude": 0.5}]},'
                 b' {"periods": 4, "foci": []}], "modulation": {"periods_a_sample": 2, "samples": [0, 0.5, 1]}}'],
        "path_csv": [b"time_ms,x_mm,y_mm,z_mm,intensity\n0,1,2,130,1\n1,2,2,130,0.5\n", b"z_mm;x_mm;y_mm;time_s\n130;0;0;0\n130;1;0;0.001\n"],
        "adaptics": [json.dumps(sound_pattern()).encode()],
        "wav": [b"RIFF" + struct.pack("<I", 44) + b"WAVEfmt " + struct.pack("<IHHIIHH", 16, 1, 1, 8000, 16000, 2, 16) + b"data" + struct.pack("<I4h", 8, 0, 99, -99, 0)],
        "depth_png": [sound_depth(), sound_depth(level=9), sound_depth(interlaced=1), sound_depth(bits=8), sound_depth(colour=2)],
        "cameras": [SOUND_CAMERAS, SOUND_CAMERAS + SOUND_CAMERAS[SOUND_CAMERAS.index(b"[[") :].replace(b"camera1", b"b")],
        "leap": [b'{"frames": [["timestamp", {"hands": [["type", "id", "palmVelocity", "palmPosition", "palmNormal", "direction"]]}, {"pointables": [["handId", "id",'
                 b' "tipPosition", "dipPosition", "pipPosition", "mcpPosition"]]}], [5, [["left", 7, [10, 0, 0], [1, 200, 30], [0, -1, 0], [0, 0, -1]]],'
                 b' [[7, 71, [0, 200, -85], [0, 200, -65], [0, 200, -40], [0, 200, 0]]]]]}', b"BYUwNmD2A0AECWsCGBbZtDUzkAA="],
        "joints": [json.dumps({"time_s": 0.5, "hands": [{"side": side, "joints_m": {name: [0.01 * k, 0.2, 0.1 - 0.01 * k * k] for k, name in enumerate(JOINTS)}, **more}]}).encode()
                   for side, more in (("right", {"id": 3}), ("left", {"normal": [0, -1, 0], "direction": [0, 0, -1], "velocity_m_s": [1, 2, 3], "widths_m": [0.01] * 5, "grab": 1}))],
        "leap_message": [json.dumps(SOUND_HANDS).encode(), b'{"serviceVersion": "5.0", "version": 6}'],
        "depth_pipe": [SMALL_CAMERAS + b"\0" + struct.pack("<4sIQd12H", b"SHOT", 1, 3, 0.1, *range(12)) + struct.pack("<4sIQd", b"SHOT", 0, 4, 0.2)],
        "message": [json.dumps(each).encode() for each in sound_messages()],
    }  # fmt: skip
    subprocess.run([program, "compile", "--shape", "line", "--points", "2", "--array", "tile-7x8", "-o", "seed.hex"],
                   cwd=ROOT / "build/fuzz", stdout=subprocess.DEVNULL, check=True)  # fmt: skip
    found["manifest"] = [(ROOT / "build/fuzz/seed.json").read_bytes()]
    return found


def build(folder):
    configure = ["cmake", "-S", ROOT / "tests/fuzz", "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DCMAKE_C_COMPILER=clang", "-DCMAKE_CXX_COMPILER=clang++"]  # fmt: skip
    for command in (configure, ["cmake", "--build", folder, "--target", "haptogram_fuzz"]):
        result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode != 0:
            sys.exit(f"fuzz: {result.stdout}")


def fuzz(folder, target, sound, runs, seconds, seed):
    """With a seed the same runs every time: from the sound files alone, without what libFuzzer learns from addresses or by the clock."""
    corpus, findings = folder / ("corpus" if seed is None else f"corpus-{seed}") / target, folder / "findings"
    if seed is not None:
        shutil.rmtree(corpus, ignore_errors=True)
    corpus.mkdir(parents=True, exist_ok=True)
    findings.mkdir(exist_ok=True)
    for number, content in enumerate(sound):
        (corpus / f"seed-{number}").write_bytes(content)
    limits = [f"-runs={runs}"] + ([f"-max_total_time={seconds}"] if seconds else [])
    limits += [] if seed is None else [f"-seed={seed}", "-use_cmp=0", "-reload=0"]
    command = [folder / "haptogram_fuzz", *limits, "-timeout=10", "-rss_limit_mb=2048", "-max_len=4096", "-print_final_stats=1",
               f"-artifact_prefix={findings}/{target}-", corpus]  # fmt: skip
    result = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                            env={**os.environ, "HAPTOGRAM_FUZZ": target})  # fmt: skip
    number = lambda pattern: int((re.findall(pattern, result.stdout) or [0])[-1])  # noqa: E731
    done, speed, reached = number(r"number_of_executed_units: +(\d+)"), number(r"average_exec_per_sec: +(\d+)"), number(r"cov: (\d+)")
    good = result.returncode == 0 and done > 100
    line = f"fuzz: {target:10} {done:>10,} runs, {speed:>7,} a second, {reached:>5,} edges: {'nothing found' if good else 'FOUND SOMETHING'}"
    return good, line if good else line + "\n" + result.stdout[-6000:]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", type=Path, required=True, help="the built haptogram")
    parser.add_argument("--build", type=Path, default=ROOT / "build/fuzz")
    parser.add_argument("--runs", type=int, default=10_000_000, help="of each target, at most")
    parser.add_argument("--seconds", type=int, default=0, help="for each target, at most; 0: no limit")
    parser.add_argument("--seed", type=int, help="the same runs every time")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", action="append", choices=TARGETS)
    options = parser.parse_args()
    build(options.build)
    sound = seeds(options.program.resolve())
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = [pool.submit(fuzz, options.build, target, sound[target], options.runs, options.seconds, options.seed) for target in options.only or TARGETS]
        good = True
        for job in jobs:
            fine, line = job.result()
            print(line, flush=True)
            good = good and fine
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
