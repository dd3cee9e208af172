# SPDX-License-Identifier: Apache-2.0
"""`haptogram device self-test`: on a good board, with and without a person, and on boards that somebody between host and board makes bad."""
import binascii
import contextlib
import json
import os
import pty
import signal
import subprocess
import threading
import tty

import pytest
from cobs import cobs
from messages import program_said
from patience import also_in_time
from support import DEVICE, OK, PROGRAM, RUN_FAILED, USAGE, assert_one_message, open_raw, run, status, succeed, text, virtual_board

AUTOMATIC = "link,memories,clock,outputs,watchdog"
WRITE, SELECT, WATCHDOG, STATUS = 0x02, 0x06, 0x0A, 0x0B
REPLY_HEADER = 6


@contextlib.contextmanager
def reference_board(folder, *options):
    command = [str(PROGRAM), "board", "run", "--model", "reference", "--json", "--pty", "port", *options]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        json.loads(process.stdout.readline())
        yield process
    finally:
        process.kill()
        process.communicate()


def unchanged(frame):
    return frame


@contextlib.contextmanager
def between(folder, request=unchanged, reply=unchanged):
    """A second port, `folder`/bad, that leads to the first: all frames go through `request` or `reply` without their CRC.
    What those return is sent on; None is lost."""
    board = open_raw(folder / "port")
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    (folder / "bad").symlink_to(os.ttyname(theirs))

    def carry(source, target, alter):
        left = b""
        while True:
            try:
                left += os.read(source, 4096)
            except OSError:
                return
            *frames, left = left.split(b"\0")
            for code in frames:
                altered = alter(cobs.decode(code)[:-2]) if code else b""
                if altered:
                    crc = binascii.crc_hqx(altered, 0xFFFF).to_bytes(2, "big")
                    with contextlib.suppress(OSError):
                        os.write(target, cobs.encode(altered + crc) + b"\0")

    for arguments in ((ours, board, request), (board, ours, reply)):
        threading.Thread(target=carry, args=arguments, daemon=True).start()
    yield


def with_status(frame, alter):
    """A reply, with the first byte of the status block altered if it carries one."""
    if frame[1] != STATUS | 0x80:
        return frame
    return frame[:REPLY_HEADER] + bytes([alter(frame[REPLY_HEADER])]) + frame[REPLY_HEADER + 1 :]


def findings(folder, *options, port="port", code=OK):
    said = run(["device", "self-test", "--port", port, "--json", *options], cwd=folder, timeout=300)
    assert said.returncode in ((OK, RUN_FAILED) if code is None else (code,)), text(said.stderr) + text(said.stdout)
    return {finding["check"]: finding for finding in json.loads(said.stdout)}


def outcomes(found):
    return {name: finding["outcome"] for name, finding in found.items()}


def asked(folder, answers, *options):
    """Runs it with a person at a terminal who gives these answers and then no more."""
    ours, theirs = pty.openpty()
    command = [str(PROGRAM), "device", "self-test", "--port", "port", *options]
    process = subprocess.Popen(command, cwd=folder, stdin=theirs, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    os.close(theirs)
    for answer in answers:
        os.write(ours, answer.encode() + b"\n")
    os.write(ours, b"\x04")
    said, complaint = process.communicate(timeout=300)
    os.close(ours)
    return process.returncode, text(said), text(complaint)


@also_in_time
def test_a_good_board_passes_and_holds_what_it_held(tmp_path, image, in_time):
    """Its clock is compared with this machine's, which only an idle one lets it be."""
    with reference_board(tmp_path, "--image", image):
        succeed(["device", "enable", "--watchdog", "333", "--port", "port"], cwd=tmp_path)
        found = findings(tmp_path, "--channels", "7", "9", "--channel-seconds", "0.05", "--point-seconds", "0.05", code=OK if in_time else None)
        if not in_time:  # a machine that is held up is late, or not heard by a watchdog
            found |= {name: {"outcome": outcome} for name, outcome in (("clock", "passed"), ("channels", "unjudged"), ("point", "unjudged"))}
        assert outcomes(found) == dict.fromkeys(AUTOMATIC.split(","), "passed") | dict.fromkeys(("sync", "stop-switch", "channels", "point"), "unjudged")
        assert (status(tmp_path)["outputs"], status(tmp_path)["watchdog_ms"]) == ("off", 333)
        held = succeed(["upload", image, "--port", "port", "--json"], cwd=tmp_path)
        assert json.loads(held.stdout)["frames_written"] == 0


@also_in_time
def test_channels_play_one_after_the_other_and_then_all_at_once(tmp_path, in_time):
    with reference_board(tmp_path, "--pulses", "pulses.csv") as board:
        options = ("--check", "channels,point", "--channels", "7", "9", "--channel-seconds", "0.1", "--point-seconds", "0.1")
        found = findings(tmp_path, *options, code=OK if in_time else None)
        if any("its watchdog heard nothing" in finding["found"] for finding in found.values()):
            pytest.skip("this machine was held up for longer than the watchdog waits")
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=300)
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    order = []
    for channel, *_ in rows:
        if channel not in order:
            order.append(channel)
    assert order[:3] == [7, 8, 9] and sorted(order) == list(range(100))
    next_begins = min(rise for channel, rise, *_ in rows if channel == 9)
    rises = [rise for channel, rise, *_ in rows if channel == 8 and rise < next_begins]
    pauses = [after - before for before, after in zip(rises, rises[1:]) if after - before > 1250]
    assert pauses and set(pauses) == {101 * 1250}  # 200 Hz: 100 cycles on, 100 off


@pytest.mark.parametrize(
    "check, tamper, says",
    [
        ("memories", {"request": lambda f: f[:12] + bytes([f[12] | 4]) + f[13:] if f[1] == WRITE and len(f) > 20 else f}, "differ from the pattern"),
        ("clock", {"request": lambda f: f[:4] + (32768).to_bytes(2, "little") if f[1] == SELECT else f}, "MHz"),
        ("outputs", {"reply": lambda f: with_status(f, lambda word: word & ~1)}, "not on"),
        ("watchdog", {"request": lambda f: f[:2] + bytes(2) if f[1] == WATCHDOG else f}, "stay on"),
    ],
)
def test_a_board_that_is_bad_in_one_way(tmp_path, check, tamper, says):
    with reference_board(tmp_path), between(tmp_path, **tamper):
        found = findings(tmp_path, "--check", check, port="bad", code=RUN_FAILED)
        assert outcomes(found) == {check: "failed"} and says in found[check]["found"] and found[check]["advice"]


def test_a_link_that_loses_frames_is_named_and_the_rest_goes_on(tmp_path):
    count = 0

    def lose(frame):
        nonlocal count
        count += 1
        return None if count % 40 == 0 else frame

    with reference_board(tmp_path), between(tmp_path, request=lose):
        found = findings(tmp_path, "--check", "link,outputs", port="bad", code=RUN_FAILED)
        assert outcomes(found) == {"link": "failed", "outputs": "passed"} and "sent again" in found["link"]["found"]


def test_a_check_in_which_the_outputs_go_off_has_failed_and_the_rest_goes_on(tmp_path):
    tripped = 0
    trips = REPLY_HEADER + 2 * 7  # the status word watchdog_trips

    def goes_off_once(frame):
        nonlocal tripped
        if frame[1] != STATUS | 0x80:
            return frame
        first = frame[REPLY_HEADER] & 1 and not tripped
        tripped = tripped or frame[REPLY_HEADER] & 1
        counted = frame[:trips] + bytes([frame[trips] + tripped]) + frame[trips + 1 :]
        return with_status(counted, lambda word: word & ~1 if first else word)

    with reference_board(tmp_path), between(tmp_path, reply=goes_off_once):
        found = findings(tmp_path, "--check", "clock,outputs", port="bad", code=RUN_FAILED)
        assert outcomes(found) == {"clock": "failed", "outputs": "passed"} and found["clock"]["advice"]


def test_a_stop_switch_that_is_pressed_all_the_time(tmp_path):
    with reference_board(tmp_path), between(tmp_path, reply=lambda f: with_status(f, lambda word: word | 8)):
        found = findings(tmp_path, "--check", "link,clock,channels", port="bad", code=RUN_FAILED)
        assert outcomes(found) == {"link": "passed", "clock": "failed", "channels": "failed"}
        assert "stop input is active" in found["clock"]["found"]


def test_a_person_hears_and_feels(tmp_path):
    quick = ("--channels", "0", "4", "--channel-seconds", "0.02", "--point-seconds", "0.02")
    with reference_board(tmp_path):
        code, said, _ = asked(tmp_path, ["n", "", "", "", "a", "y"], "--check", "stop-switch,channels,point", *quick)
        assert code == OK
        assert [line.split()[:2] for line in said.splitlines() if not line.startswith(" ")] == [["stop-switch", "unjudged"], ["channels", "passed"], ["point", "passed"]]
        code, said, complaint = asked(tmp_path, ["", "seven", "3, 0-1", "", "n"], "--check", "channels,point", *quick)
        assert code == RUN_FAILED and "silent: 0, 1, 3" in said and "not felt" in said and "2 of 2 checks failed" in complaint
        code, said, _ = asked(tmp_path, ["", "", ""], "--check", "stop-switch")
        assert code == RUN_FAILED and "does not see it" in said
        assert asked(tmp_path, [""], "--check", "channels", *quick)[0] == RUN_FAILED  # no answer
        assert status(tmp_path)["outputs"] == "off"


def test_a_slave_that_hears_no_master(tmp_path):
    on = ("--board", "tile-100-wide", "--array", "tile-10x10")
    succeed(["compile", "--shape", "point", "--am", "sine:1000", *on, "-o", "wide.hex"], cwd=tmp_path)
    with virtual_board(tmp_path, "--image", "wide.hex"):
        assert "keeps its own time" in findings(tmp_path, "--check", "sync")["sync"]["found"]
        succeed(["device", "sync", "slave", "--port", "port"], cwd=tmp_path)
        assert "not in step" in findings(tmp_path, "--check", "sync", code=RUN_FAILED)["sync"]["found"]


def test_what_makes_no_sense_is_refused_before_anything_plays(tmp_path):
    with reference_board(tmp_path):
        for options in [
            ["--channels", "3", "100"],
            ["--channels", "5", "3"],
            ["--array", "tile-7x8"],
            ["--height", "1"],
            ["--check", "field"],
            ["--point-seconds", "0"],
        ]:
            assert_one_message(run(["device", "self-test", "--port", "port", *options], cwd=tmp_path), USAGE)


def test_an_unplugged_board_is_named(tmp_path):
    with reference_board(tmp_path) as board:
        timer = threading.Timer(0.5, board.kill)
        timer.start()
        said = run(["device", "self-test", "--port", "port", "--check", "clock"], cwd=tmp_path, timeout=300)
        assert said.returncode == DEVICE
        program_said(said.returncode, said.stderr.partition(b";")[0])  # what was on its way then is a matter of chance
        timer.join()
