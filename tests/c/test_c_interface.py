# SPDX-License-Identifier: Apache-2.0
"""The C interface as another language meets it: through its header and its shared library, against the program's own answers."""
import ctypes
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from bindings import LIBRARY, PROGRAM, ROOT
from patience import Board, also_in_time, until

SYMBOLS = ROOT / "tests/c/symbols.txt"
DOME = '''format = "haptogram-project-1"
points = 30
[[shape]]
kind = "hemisphere"
diameter_mm = 60
center_mm = [0, 0, 150]
'''


def project(c, toml=DOME, **more):
    return c.struct("project", toml=toml.encode(), **more)


@pytest.fixture
def dome(c):
    image = c.made(c.compile, project(c))
    yield image
    c.free_image(image)


def path_of_foci(c, places, **more):
    return c.struct("path", foci=c.foci(*places), steps=len(places), **more)


@pytest.fixture
def live_image(c):
    image = c.made(c.compile_path, path_of_foci(c, [(0, 0, 0.15)], board=b"tile-100-wide", array=b"tile-10x10", board_computes=1))
    yield image
    c.free_image(image)


@pytest.fixture
def board(c, request):
    handle = c.made(c.open, c.struct("port", port=getattr(request, "param", b"reference:tile-100-wide")))
    yield handle
    c.close(handle)


def status_of(c, board):
    found = c.struct("status")
    c.ok(c.get_status(board, ctypes.byref(found)))
    return found


def test_the_library_shows_what_the_header_has_and_nothing_else(c):
    shown = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
    names = {line.split()[2].split("@")[0] for line in shown.splitlines() if line.split()[1] == "T"}
    assert names == set(c.header.functions)
    assert not [line for line in shown.splitlines() if line.split()[1] in "BDRW"], "something of ours can be seen"
    assert c.abi() == c.header.abi


def test_what_was_released_is_still_there(c):
    """symbols.txt has each struct's fields and each function's parameters of interface 1. What is there may not change; at the
    end of a struct, and beside the functions, more may come: then add it there."""
    def words(p):
        return f"{'const ' if p.const else ''}{p.type}{'*' * p.stars} {p.name}".strip()

    now = {name: "".join(f"{words(p)}; " for p in members) for name, members in c.header.structs.items()}
    now |= {name: f"{words(returns)}({', '.join(map(words, given))});" for name, (returns, given) in c.header.functions.items()}
    now |= {name: f"{value};" for name, value in c.header.codes.items()}
    now = {name: told.strip() for name, told in now.items()}
    recorded = dict(line.split(": ", 1) for line in SYMBOLS.read_text(encoding="utf-8").splitlines())
    changed = {name: now.get(name) for name, was in recorded.items() if not now.get(name, "").startswith(was)}
    assert not changed, "HAPTOGRAM_ABI has to go up"
    assert now == recorded, f"{SYMBOLS.name} needs: " + "\n".join(f"{n}: {w}" for n, w in now.items() if w != recorded.get(n))


def test_an_image_is_the_programs(c, dome, tmp_path):
    (tmp_path / "dome.toml").write_text(DOME, encoding="utf-8")
    subprocess.run([PROGRAM, "compile", "dome.toml", "-o", "dome.hex"], cwd=tmp_path, check=True, capture_output=True)
    assert c.text(c.image_hex, dome) == (tmp_path / "dome.hex").read_bytes()
    ours, theirs = (json.loads(text) for text in (c.text(c.image_manifest, dome), (tmp_path / "dome.json").read_bytes()))
    assert ours == theirs
    c.ok(c.save_image(dome, str(tmp_path / "saved.hex").encode()))
    assert (tmp_path / "saved.hex").read_bytes() == (tmp_path / "dome.hex").read_bytes()
    again = ctypes.c_void_p()
    c.ok(c.read_image(str(tmp_path / "saved.hex").encode(), ctypes.byref(again)))
    assert c.text(c.image_hex, again) == c.text(c.image_hex, dome)
    c.free_image(again)


def test_a_shape_from_memory(c, tmp_path):
    cloud = b"0 0 100\n20 0 100\n0 10 100\n0 0 104\n"
    image = c.made(c.compile, project(c, 'format = "haptogram-project-1"\n[[shape]]\nfile = "cloud.xyz"\n', shape_name=b"cloud.xyz", shape=ctypes.cast(cloud, ctypes.c_void_p), shape_bytes=len(cloud)))
    places = [record["focus_mm"] for record in json.loads(c.text(c.image_manifest, image))["records"]]
    assert sorted(map(tuple, np.round(places, 2))) == [(0, 0, 100), (0, 0, 104), (0, 10, 100), (20, 0, 100)]
    c.free_image(image)


def test_pressure_is_that_of_the_field(c, dome, tmp_path):
    c.ok(c.save_image(dome, str(tmp_path / "dome.hex").encode()))
    points = np.array([[0.01 * i, 0.0, 0.15] for i in range(-2, 3)])
    assert c.text(c.image_level, dome).startswith(b"nominal level: ")
    (tmp_path / "measured.toml").write_text(
        '[array]\nrows = 10\ncolumns = 10\npitch_mm = 10\n[transducer]\nsource_pa_m = 1.25\nmeasured = "by a balance"\n')
    measured = c.made(c.compile, project(c, DOME.replace("points", 'array = "measured.toml"\npoints', 1), folder=str(tmp_path).encode()))
    assert c.text(c.image_level, measured).decode() == "calibrated level: 1.25 Pa·m, by a balance"
    c.free_image(measured)
    for record in (0, 3):
        found = np.zeros(len(points))
        c.ok(c.pressure(dome, record, points.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), len(points), found.ctypes.data_as(ctypes.POINTER(ctypes.c_double))))
        subprocess.run([PROGRAM, "field", "dome.hex", "--line", "x@y=0,z=150", "--x=-20:20", "--step", "10", "--quantity", "rms",
                        *(["--record", str(record)] if record else []), "-o", "line.csv"], cwd=tmp_path, check=True, capture_output=True)
        rows = [line.split(",") for line in (tmp_path / "line.csv").read_text().splitlines() if line and (line[0] in "-0123456789")]
        assert np.allclose(found, np.sqrt(2) * np.array([float(row[-1]) for row in rows]), rtol=1e-4)


def test_drives_are_those_of_the_solver(c):
    room = ctypes.c_size_t(100)
    drives = np.zeros(200)
    c.ok(c.solve(b"tile-10x10", c.foci((0.01, 0, 0.15), (-0.01, 0, 0.15)), 2, None, drives.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), ctypes.byref(room)))
    assert room.value == 100 and np.allclose(np.abs(drives[::2] + 1j * drives[1::2]).max(), 1.0, atol=1e-6)
    few = ctypes.c_size_t(10)
    c.fails(c.solve(b"tile-10x10", c.foci((0, 0, 0.15)), 1, None, drives.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), ctypes.byref(few)),
            "BAD_ARGUMENT", "room for 10", "has 100")
    assert few.value == 100


def test_what_is_wrong_is_said(c, dome, tmp_path):
    handle = ctypes.c_void_p(1)
    c.fails(c.compile(None, ctypes.byref(handle)), "BAD_ARGUMENT", "project: is NULL")
    c.fails(c.compile(ctypes.byref(c.structs["haptogram_project"]()), ctypes.byref(handle)), "BAD_ARGUMENT", "its size is 0")
    c.fails(c.compile(ctypes.byref(c.struct("project")), ctypes.byref(handle)), "BAD_ARGUMENT", "toml: is NULL")
    assert handle.value is None, "a failure gives no handle"
    c.fails(c.compile(ctypes.byref(project(c, DOME.replace("points = 30", "points = 0"))), ctypes.byref(handle)), "BAD_INPUT", "points")
    c.fails(c.compile(ctypes.byref(project(c, DOME.replace("150", "-50"))), ctypes.byref(handle)), "BAD_INPUT", "point")
    assert b"center" in c.remedies()
    c.fails(c.read_image(str(tmp_path / "none.hex").encode(), ctypes.byref(handle)), "BAD_INPUT", "none.hex")
    c.fails(c.open(ctypes.byref(c.struct("port", port=b"reference:none")), ctypes.byref(handle)), "BAD_ARGUMENT", "none")
    c.fails(c.open(ctypes.byref(c.struct("port", port=b"/dev/null", patience_ms=300)), ctypes.byref(handle)), "DEVICE", "/dev/null")
    c.fails(c.pressure(dome, 31, (ctypes.c_double * 3)(), 1, (ctypes.c_double * 1)()), "BAD_ARGUMENT", "31")
    c.ok(c.save_image(dome, str(tmp_path / "dome.hex").encode()))
    assert c.error() == b"" and c.abi() == 1
    c.close(None)
    c.free_image(None)


def test_a_later_struct_is_cut_where_this_library_ends_and_an_earlier_one_is_filled_up(c, dome, board):
    early = (ctypes.c_uint32 * 4)(ctypes.sizeof(ctypes.c_uint32) * 3, 7, 7, 7)
    c.ok(c.identify(board, ctypes.cast(early, ctypes.POINTER(c.structs["haptogram_identity"]))))
    assert list(early)[1:] != [7, 7, 7] and early[3] == 7, "beyond its size nothing is written"
    longer = type("longer", (c.structs["haptogram_identity"],), {"_fields_": [("more", ctypes.c_uint32)]})()
    longer.size, longer.more = ctypes.sizeof(longer), 7
    c.ok(c.identify(board, ctypes.cast(ctypes.byref(longer), ctypes.POINTER(c.structs["haptogram_identity"]))))
    assert longer.channels == 100 and longer.more == 7


@pytest.mark.parametrize("board", [b"reference:tile-100"], indirect=True)
def test_a_sequence_plays_to_its_end(c, dome, board):
    c.ok(c.upload(board, dome))
    c.ok(c.play(board, ctypes.byref(c.struct("playing", loops=5))))
    c.fails(c.play(board, None), "BAD_ARGUMENT", "plays already")
    until(lambda: status_of(c, board).enabled)
    c.ok(c.set_intensity(board, 0.5))
    c.fails(c.set_intensity(board, 1.5), "BAD_ARGUMENT", "0 to 1")
    busy = ctypes.c_int32(7)
    c.ok(c.wait(board, 300000, ctypes.byref(busy)))
    assert busy.value == 0 and not status_of(c, board).enabled


@also_in_time
@pytest.mark.parametrize("board", [b"reference:colorlight-5a-75e-v7.1-net"], indirect=True)
def test_patterns(c, board, figure, in_time):
    """A pattern for each carrier period: what was put plays in order, and then the last one goes on."""
    words = (ctypes.c_uint16 * (100 * 5000))(*[k % 256 | 180 << 8 for k in range(5000) for _ in range(100)])
    taken = ctypes.c_size_t(7)
    c.ok(c.put_patterns(board, words, 5000, ctypes.byref(taken)))
    assert taken.value == 4096, "and the caller keeps the rest"
    c.fails(c.play_patterns(board, ctypes.byref(c.struct("playing", loops=2))), "BAD_ARGUMENT", "loops")
    c.fails(c.play_patterns(board, ctypes.byref(c.struct("playing", step_s=1e-3))), "BAD_ARGUMENT", "step_s")
    c.ok(c.play_patterns(board, ctypes.byref(c.struct("playing", am=b"sine:200"))))
    until(lambda: status_of(c, board).foci_sent > 5000)
    found = status_of(c, board)
    assert found.enabled and found.busy
    if in_time:
        assert found.lead_s > 0
        figure("C: patterns lead the pins by", found.lead_s, 0.01)
    c.ok(c.set_pattern(board, words))
    c.fails(c.put_patterns(board, None, 1, ctypes.byref(taken)), "BAD_ARGUMENT", "words: is NULL")
    c.fails(c.put_patterns(board, words, 1, None), "BAD_ARGUMENT", "taken: is NULL")
    c.ok(c.shut_off(board))
    assert not status_of(c, board).enabled
    c.ok(c.play_patterns(board, ctypes.byref(c.struct("playing", seconds=0.2))))  # and again
    until(lambda: not status_of(c, board).busy)
    c.ok(c.wait(board, 0, None))


@pytest.mark.parametrize("board", [b"reference:tile-100-wide"], indirect=True)
def test_a_board_without_streams_says_so(c, board):
    c.ok(c.play_patterns(board, None))
    c.fails(c.wait(board, 300000, None), "DEVICE", "STREAM")


@pytest.mark.parametrize("board", [b"reference:ulx3s-85f"], indirect=True)
def test_triggers(c, board):
    """A pulse at the trigger output for each 400th carrier period, counted by the board."""
    c.ok(c.set_trigger(board, ctypes.byref(c.struct("trigger", event=c.header.codes["HAPTOGRAM_EVENT_PERIOD"], every_periods=400, pulse_s=1e-4))))
    times = c.struct("trigger_times")
    c.ok(c.get_trigger_times(board, ctypes.byref(times)))
    count, clock = times.out_count, times.now_clock
    until(lambda: c.get_trigger_times(board, ctypes.byref(times)) == 0 and times.now_clock - clock > 25_000_000)
    assert abs(times.out_count - count - (times.now_clock - clock) / 500_000) <= 1.5  # 400 periods of 1250 clocks
    assert 0 <= times.now_clock - times.out_clock <= 500_000 and times.in_count == 0
    marked = path_of_foci(c, [(0, 0, 0.15), (0.01, 0, 0.15), (0.02, 0, 0.15)], periods=(ctypes.c_uint32 * 3)(40, 40, 40),
                          marks=(ctypes.c_uint8 * 3)(1, 0, 1), board=b"ulx3s-85f")  # fmt: skip
    image = c.made(c.compile_path, marked)
    c.ok(c.set_trigger(board, ctypes.byref(c.struct("trigger", event=c.header.codes["HAPTOGRAM_EVENT_MARK"], pulse_s=1e-5))))
    c.ok(c.upload(board, image))
    c.ok(c.get_trigger_times(board, ctypes.byref(times)))
    count = times.out_count
    c.ok(c.play(board, ctypes.byref(c.struct("playing", loops=50))))
    until(lambda: not status_of(c, board).busy)
    c.ok(c.get_trigger_times(board, ctypes.byref(times)))
    assert times.out_count - count == 2 * 50, "two of three steps are marked"
    c.free_image(image)
    c.fails(c.set_trigger(board, ctypes.byref(c.struct("trigger", event=9))), "BAD_ARGUMENT", "event: found 9")
    c.fails(c.set_trigger(board, ctypes.byref(c.struct("trigger", pulse_s=10))), "BAD_ARGUMENT", "pulse")


PAIR = """format = "haptogram-rig-1"
name = "pair"
[[unit]]
array = "tile-10x10"
board = "tile-100-wide"
origin_mm = [-50, 0, 0]
[[unit]]
array = "tile-10x10"
board = "tile-100-wide"
origin_mm = [50, 0, 0]
"""


def test_a_rig(c, tmp_path):
    """Two boards on one SYNC wire, from a project to silence."""
    (tmp_path / "pair.toml").write_text(PAIR, encoding="utf-8")
    manifest = str(tmp_path / "wall.json").encode()
    c.ok(c.compile_rig(ctypes.byref(project(c, DOME)), str(tmp_path / "pair.toml").encode(), manifest))
    command = [str(PROGRAM), "board", "run", "--tiles", "2", "--model", "reference", "--pty", "port", "--json"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE)
    try:
        json.loads(process.stdout.readline())
        ports = f"{tmp_path}/port-1 {tmp_path}/port-2"
        handle = ctypes.c_void_p()
        c.fails(c.open(ctypes.byref(c.struct("port", rig=manifest, port=ports.split()[0].encode() + b"x")), ctypes.byref(handle)), "DEVICE", "tile 1")
        rig = c.made(c.open, c.struct("port", rig=manifest, port=ports.encode()))
        found = c.struct("identity")
        c.ok(c.identify(rig, ctypes.byref(found)))
        assert found.channels == 200
        c.ok(c.upload(rig, None))
        c.ok(c.play(rig, ctypes.byref(c.struct("playing", loops=-1))))
        until(lambda: status_of(c, rig).enabled)
        c.fails(c.play(rig, None), "BAD_ARGUMENT", "plays already")
        c.fails(c.set_focus(rig, 0, 0, 0.15, 1), "BAD_ARGUMENT", "a rig")
        c.fails(c.play(rig, ctypes.byref(c.struct("playing", am=b"sine:200"))), "BAD_ARGUMENT", "am")
        c.ok(c.stop(rig))
        found = status_of(c, rig)
        assert not found.busy and not found.enabled and found.connected and found.underruns == found.refused_records == 0
        c.ok(c.play(rig, ctypes.byref(c.struct("playing", loops=-1))))
        until(lambda: status_of(c, rig).enabled)
        c.ok(c.shut_off(rig))
        c.ok(c.wait(rig, 0, None))
        assert not status_of(c, rig).enabled
        def device(*command):
            return subprocess.run([PROGRAM, "device", *command, "--port", ports.split()[1]], check=True, capture_output=True).stdout

        device("enable", "--watchdog", "0")
        assert json.loads(device("status", "--json"))["outputs"] == "on"
        os.rename(tmp_path / "port-1", tmp_path / "away")  # one tile cannot be reached, and the other is shut off all the same
        c.fails(c.shut_off(rig), "DEVICE", "tile 1")
        assert json.loads(device("status", "--json"))["outputs"] == "off"
        os.rename(tmp_path / "away", tmp_path / "port-1")
        c.close(rig)
    finally:
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=300)
    assert json.loads(said)["enabled"] == [False, False]


@also_in_time
@pytest.mark.parametrize("ends", ["stop", "shut_off"])
def test_a_live_focus(c, live_image, board, ends, figure, in_time):
    c.fails(c.play_live(board, None), "OK")  # it begins, and finds that there is no image of foci
    busy = ctypes.c_int32()
    c.fails(c.wait(board, 300000, ctypes.byref(busy)), "DEVICE", "foci")
    c.ok(c.upload(board, live_image))
    c.fails(c.play_live(board, ctypes.byref(c.struct("playing", loops=2))), "BAD_ARGUMENT", "loops")
    c.fails(c.play(board, ctypes.byref(c.struct("playing", step_s=1e-3))), "BAD_ARGUMENT", "step_s")
    c.fails(c.play(board, ctypes.byref(c.struct("playing", stale_ms=100))), "BAD_ARGUMENT", "stale_ms")
    c.fails(c.play_live(board, ctypes.byref(c.struct("playing", stale_ms=-2))), "BAD_ARGUMENT", "stale_ms: found -2")
    c.ok(c.play_live(board, ctypes.byref(c.struct("playing", am=b"sine:200"))))
    c.fails(c.set_focus(board, 0, 0, 0.15, 2.0), "BAD_INPUT", "amplitude")
    c.fails(c.set_focus(board, 5, 0, 0.15, 1.0), "BAD_INPUT", "5")
    for i in range(200):
        c.ok(c.set_focus(board, 1e-4 * i, 0, 0.15, 1.0))
        c.ok(c.wait(board, 2, ctypes.byref(busy)))
        assert busy.value == 1
    until(lambda: status_of(c, board).foci_sent > 400)
    found = status_of(c, board)
    assert found.connected and found.enabled
    if in_time:
        assert found.lead_s > 0.001
        figure(f"C: a live focus leads the pins by (then {ends})", found.lead_s, 0.05)
    c.ok(getattr(c, ends)(board))
    found = status_of(c, board)
    assert not found.enabled and not found.busy
    c.ok(c.wait(board, 0, None))
    c.ok(c.play_live(board, ctypes.byref(c.struct("playing", seconds=0.2))))  # and again
    until(lambda: not status_of(c, board).busy)
    c.ok(c.wait(board, 0, None))


@also_in_time
def test_setting_a_focus_costs_its_caller_nothing(c, tmp_path, figure, in_time):
    """A million calls while it plays. The target is 5 µs in the median; the longest is the scheduler's."""
    source = ROOT / "tests/c/set_focus_cost.c"
    subprocess.run(["cc", "-O2", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{ROOT}/host/c", source, "-o", "cost", LIBRARY], cwd=tmp_path, check=True)
    done = subprocess.run(["./cost"], cwd=tmp_path, capture_output=True, text=True, timeout=300, env={**os.environ, "LD_LIBRARY_PATH": str(LIBRARY.parent)})
    assert done.returncode == 0, done.stderr
    median_us, longest_us = map(float, done.stdout.split())
    print(f"set_focus: median {median_us} us, longest {longest_us} us")
    if in_time:
        figure("C: set_focus, median", median_us, 5.0, "us")


@pytest.mark.parametrize("ends", ["stop", "shut_off"])
def test_what_waits_for_a_board_does_not_begin_after_it_was_ended(c, tmp_path, ends):
    """The board is unplugged, one thread asks to play, another ends that, and the board comes back."""
    def plug_in():
        (tmp_path / "board").unlink(missing_ok=True)
        run = [PROGRAM, "board", "run", "--model", "reference", "--board", "tile-100-wide", "--pty", "board"]
        process = subprocess.Popen(run, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        until(lambda: (tmp_path / "board").exists())
        return process

    board = plug_in()
    handle = c.made(c.open, c.struct("port", port=str(tmp_path / "board").encode(), patience_ms=20000))
    board.send_signal(signal.SIGINT)
    board.wait()
    until(lambda: not status_of(c, handle).connected)
    codes = {}

    def call(name, *given):
        codes[name] = getattr(c, name)(handle, *given)

    plays = threading.Thread(target=call, args=("play", ctypes.byref(c.struct("playing", loops=-1))), daemon=True)
    plays.start()
    time.sleep(1)  # it waits, of which nothing can be seen
    off = threading.Thread(target=call, args=(ends,), daemon=True)
    off.start()
    time.sleep(1)
    board = plug_in()
    try:
        for thread in (plays, off):
            thread.join(timeout=300)
            assert not thread.is_alive(), f"{ends} never returns"
        assert codes["play"] == c.header.codes["HAPTOGRAM_CANCELLED"], codes
        until(lambda: status_of(c, handle).connected)
        time.sleep(0.5)
        found = status_of(c, handle)
        assert not found.enabled and not found.busy
        c.close(handle)
    finally:
        board.send_signal(signal.SIGINT)
        board.wait()


@pytest.mark.parametrize("example", sorted((ROOT / "host/c/examples").glob("*.c")), ids=lambda path: path.stem)
def test_the_examples_compile_and_run(example, tmp_path):
    assert len(example.read_text(encoding="utf-8").splitlines()) <= 30
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{ROOT}/host/c", *os.environ.get("HAPTOGRAM_CFLAGS", "").split()]
    subprocess.run(["cc", *flags, example, "-o", "example", LIBRARY, "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run(["./example"], cwd=tmp_path, capture_output=True, text=True, timeout=300, env={**os.environ, "LD_LIBRARY_PATH": str(LIBRARY.parent)})
    assert done.returncode == 0 and done.stdout, done.stderr


ENDING = r"""
#include <haptogram.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <sys/wait.h>
int main(int count, char** words) {
    const haptogram_focus focus = {0, 0, 0.15, 1.0};
    const haptogram_path path = {.size = sizeof path, .foci = &focus, .steps = 1, .board = "tile-100-wide", .array = "tile-10x10"};
    const haptogram_port port = {.size = sizeof port, .port = words[1]};
    const haptogram_playing playing = {.size = sizeof playing, .loops = -1, .watchdog_ms = 60000};
    haptogram_image* image;
    haptogram_board* board;
    haptogram_status status = {.size = sizeof status};
    if (count != 3 || haptogram_compile_path(&path, &image) || haptogram_open(&port, &board) || haptogram_upload(board, image) ||
        haptogram_play(board, &playing)) {
        puts(haptogram_error());
        return 1;
    }
    while (!status.enabled) haptogram_get_status(board, &status);
    if (strcmp(words[2], "fork") == 0) {
        if (fork() == 0) exit(0);
        wait(NULL);
        haptogram_get_status(board, &status);
        return status.enabled ? 0 : 2;
    }
    if (strcmp(words[2], "exit") == 0) exit(0);
    if (strcmp(words[2], "quick_exit") == 0) quick_exit(0);
    return 0;
}
"""


@pytest.mark.parametrize("how", ["return", "exit", "quick_exit", "fork"])
def test_the_end_of_a_program_turns_its_outputs_off(tmp_path, how):
    """The watchdog's minute is not over by then."""
    (tmp_path / "ending.c").write_text(ENDING)
    flags = ["-std=c11", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", f"-I{ROOT}/host/c", *os.environ.get("HAPTOGRAM_CFLAGS", "").split()]
    subprocess.run(["cc", *flags, "ending.c", "-o", "ending", LIBRARY], cwd=tmp_path, check=True)
    served = Board([PROGRAM, "board", "run", "--json", "--model", "reference", "--board", "tile-100-wide", "--pty", "board"], tmp_path)
    try:
        done = subprocess.run(["./ending", "board", how], cwd=tmp_path, capture_output=True, text=True, timeout=300,
                              env={**os.environ, "LD_LIBRARY_PATH": str(LIBRARY.parent)})  # fmt: skip
        assert done.returncode == 0, done.stdout
        asked = subprocess.run([PROGRAM, "device", "status", "--port", "board", "--json"], cwd=tmp_path, capture_output=True, check=True)
        found = json.loads(asked.stdout)
        assert found["outputs"] == "off" and found["watchdog_trips"] == 0, found
    finally:
        served.end()


def test_a_closed_board_is_known_as_that(c, live_image):
    port = c.struct("port", port=b"reference:tile-100-wide")
    handle = c.made(c.open, port)
    c.ok(c.upload(handle, live_image))
    c.ok(c.play(handle, ctypes.byref(c.struct("playing", loops=-1))))
    ended = []

    def wait():
        while (code := c.wait(handle, 300000, None)) == 0:
            pass
        ended.append((code, c.error()))

    waiters = [threading.Thread(target=wait, daemon=True) for _ in range(4)]
    for waiter in waiters:
        waiter.start()
    until(lambda: status_of(c, handle).enabled)
    closers = [threading.Thread(target=c.close, args=(handle,), daemon=True) for _ in range(3)]
    for thread in closers:
        thread.start()
    for thread in closers + waiters:
        thread.join(timeout=300)
        assert not thread.is_alive()
    assert len(ended) == 4
    c.close(handle)
    others = [c.made(c.open, port) for _ in range(3)]
    c.fails(c.stop(handle), "BAD_ARGUMENT", "board: is closed")
    c.fails(c.get_status(handle, ctypes.byref(c.struct("status"))), "BAD_ARGUMENT", "board: is closed")
    c.fails(c.set_focus(handle, 0, 0, 0.15, 1), "BAD_ARGUMENT", "board: is closed")
    c.fails(c.play(ctypes.c_void_p(4096), None), "BAD_ARGUMENT", "never opened")
    for other in others:
        c.close(other)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0])
def test_times_that_are_none_are_refused(c, board, value):
    for name in ("seconds", "step_s"):
        for call in (c.play, c.play_live, c.play_patterns):
            c.fails(call(board, ctypes.byref(c.struct("playing", **{name: value}))), "BAD_ARGUMENT", f"{name}: found")
    for name in ("pulse_s", "settle_s"):
        c.fails(c.set_trigger(board, ctypes.byref(c.struct("trigger", **{name: value}))), "BAD_ARGUMENT", f"{name}: found")


KILLED = """
import ctypes, sys, time
sys.path.insert(0, sys.argv[1])
from bindings import Haptogram
c = Haptogram()
image = c.made(c.compile_path, c.struct("path", foci=c.foci((0, 0, 0.15)), steps=1, board=b"tile-100-wide", array=b"tile-10x10", board_computes=1))
board = c.made(c.open, c.struct("port", port=sys.argv[2].encode()))
c.ok(c.upload(board, image))
c.ok(c.set_focus(board, 0, 0, 0.15, 1.0))
c.ok(c.play_live(board, ctypes.byref(c.struct("playing", watchdog_ms=3000))))
while True:
    c.ok(c.wait(board, 10, None))
    status = c.struct("status")
    c.ok(c.get_status(board, ctypes.byref(status)))
    if status.enabled and status.foci_sent > 100:
        print("playing", flush=True)
"""


def test_a_killed_program_leaves_the_board_to_its_watchdog(tmp_path):
    served = Board([PROGRAM, "board", "run", "--json", "--model", "reference", "--board", "tile-100-wide", "--pty", "board"], tmp_path)
    try:
        host = subprocess.Popen([sys.executable, "-c", KILLED, str(Path(__file__).parent), str(tmp_path / "board")], stdout=subprocess.PIPE)
        assert host.stdout.readline() == b"playing\n"
        host.send_signal(signal.SIGKILL)
        host.wait()
        served.until(outputs=False)
        said = json.loads(subprocess.run([PROGRAM, "device", "status", "--port", "board", "--json"], cwd=tmp_path, capture_output=True, check=True).stdout)
        assert said["outputs"] == "off" and said["watchdog_trips"] == 1
    finally:
        served.end()


def made_array(c, **source):
    return c.made(c.make_array, c.struct("array_source", **source))


def doubles(values):
    return np.ascontiguousarray(values, dtype=float).ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def test_a_field_of_an_array_that_focuses(c):
    array, drives = made_array(c, name=b"tile-10x10"), ctypes.c_void_p()
    also = ctypes.c_void_p()
    c.ok(c.drives(ctypes.byref(c.struct("source", array=array, focus_m=doubles([0, 0, 0.13]))), ctypes.byref(also), ctypes.byref(drives)))
    about = json.loads(c.text(c.result_json, drives))
    assert (about["type"], about["shape"], about["weights"]) == ("complex128", [1, 100], [1.0])
    played = {"array": array, "drives": ctypes.cast(c.result_numbers(drives), ctypes.POINTER(ctypes.c_double)), "sets": 1, "elements": 100}
    values = c.made(c.compute_field, c.struct("field", quantity=b"complex", points_m=doubles([[0, 0, 0.13]]), points=1, **played))
    real, imaginary = (ctypes.c_float * 2).from_address(c.result_numbers(values))
    analysis = ctypes.c_void_p()
    c.ok(c.analyze_focus(array, played["drives"], 100, doubles([0, 0, 0.13]), b"tile-100", ctypes.byref(analysis)))
    assert json.loads(c.text(c.result_json, analysis))["pressure_pa"] == pytest.approx(np.hypot(real, imaginary), rel=1e-4)
    cancel = ctypes.c_int32(1)
    axis = {f"{name}_m": doubles(np.linspace(0.1, 0.2, 100)) for name in "xyz"} | {f"{name}_count": 100 for name in "xyz"}
    asked = c.struct("field", quantity=b"mean_square", cancel=ctypes.pointer(cancel), **axis, **played)
    c.fails(c.compute_field(ctypes.byref(asked), ctypes.byref(also)), "CANCELLED")
    for result in (drives, values, analysis):
        c.free_result(result)
    c.free_array(array)


@pytest.mark.parametrize("wrong, place", [
    ({}, "quantity"),
    ({"quantity": b"complex"}, "array"),
    ({"quantity": b"warmth", "region": b"xy@z=130", "extent_m": 0.08, "step_m": 0.01}, "quantity"),
    ({"quantity": b"warmth", "points_m": doubles([0, 0, 0.1]), "points": 1}, "quantity"),
    ({"quantity": b"rms", "region": b"xy@z=130"}, "step"),
    ({"quantity": b"rms", "region": b"xy@z=130", "extent_m": 0.08, "step_m": 0.01, "x_m": doubles([0, 1, 2]), "x_count": 3}, "x_m"),
    ({"quantity": b"complex", "points_m": doubles([0, 0, 0.1]), "points": 1, "sets": 2}, "drives"),
    ({"quantity": b"workspace", "x_m": doubles([0]), "x_count": 1}, "y_m"),
])  # fmt: skip
def test_a_field_that_makes_no_sense_is_refused(c, wrong, place):
    array = made_array(c, name=b"tile-7x8")
    asked = c.struct("field", **{**({"array": array} if place != "array" else {}), **wrong})
    c.fails(c.compute_field(ctypes.byref(asked), ctypes.byref(ctypes.c_void_p())), "BAD_ARGUMENT", place)
    c.free_array(array)
