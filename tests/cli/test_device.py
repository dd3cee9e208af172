# SPDX-License-Identifier: Apache-2.0
"""A board behind a serial port: `haptogram board run` and the commands that speak to it, each a process of its own."""
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
import serial
from support import BAD_INPUT, DEVICE, PROGRAM, USAGE, ask, assert_one_message, run, status, succeed, text, virtual_board


STARTED = 3.0  # seconds in which a host has begun to play, also on a busy machine


def test_info_is_what_the_core_was_built_with(tmp_path):
    with virtual_board(tmp_path) as board:
        info = json.loads(ask(tmp_path, "device", "info", "--json").stdout)
        assert info["name"] == "Haptogram"
        assert {key: info[key] for key in ("channels", "records", "clock_hz")} == {key: board.says[key] for key in ("channels", "records", "clock_hz")}


def test_upload_play_and_the_files_of_the_board(tmp_path, image):
    with virtual_board(tmp_path, "--pulses", "pulses.csv", "--model", "rtl") as board:
        assert json.loads(ask(tmp_path, "upload", image, "--verify", "--json").stdout)["verified"]
        played = json.loads(ask(tmp_path, "play", "--loops", 2, "--json").stdout)
        assert played == {"underruns": 0, "refused_records": 0, "watchdog_trips": 0, "guard_trips": 0, "interrupted": False}
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        said = board.communicate(timeout=30)[0]
        assert board.returncode == 0
        assert json.loads(said)["enabled"] is False
    assert not (tmp_path / "port").is_symlink()
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    manifest = json.loads((tmp_path / "circle.json").read_text())
    timer = manifest["timer"]
    ours = [row for row in rows if row[3] > 0]
    assert {row[3] for row in ours} == {1, 2, 3, 4}
    assert {row[0] for row in ours} == set(range(100))
    whole = [row for row in ours if row[2] - row[1] == timer["pulse_ticks"] * timer["prescaler"]]
    assert len(whole) > 0.9 * len(ours)  # at a change of focus pulses may merge


def test_the_reference_board_is_a_board_in_real_time(tmp_path, image):
    command = [str(PROGRAM), "board", "run", "--model", "reference", "--json", "--pty", "port", "--pulses", "pulses.csv"]
    board = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        says = json.loads(board.stdout.readline())
        assert (says["model"], says["channels"]) == ("reference", 100)
        assert json.loads(ask(tmp_path, "upload", image, "--verify", "--json").stdout)["verified"]
        played = json.loads(ask(tmp_path, "play", "--loops", 2, "--json").stdout)
        assert played == {"underruns": 0, "refused_records": 0, "watchdog_trips": 0, "guard_trips": 0, "interrupted": False}
        board.send_signal(signal.SIGINT)
        said = json.loads(board.communicate(timeout=30)[0])
    finally:
        board.kill()
        board.communicate()
    assert said["simulated_s"] < 1.02 * said["wall_s"] + 0.01  # no faster than a real board
    assert said["playing_times_real_time"] > 0
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    assert {row[0] for row in rows} == set(range(100))
    assert {row[3] for row in rows if row[3] > 0} == {1, 2, 3, 4}


def test_a_reference_board_like_one_that_computes_foci(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 12, "--rate", 200, "--am", "sine:200", "--array", "tile-10x10", "--board", "tile-100-wide", "-o", "foci.hex"], cwd=tmp_path)  # fmt: skip
    command = [str(PROGRAM), "board", "run", "--model", "reference", "--board", "tile-100-wide", "--json", "--pty", "port"]
    board = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        assert json.loads(board.stdout.readline())["configuration"] == "tile-100-wide"
        assert json.loads(ask(tmp_path, "upload", "foci.hex", "--verify", "--json").stdout)["verified"]
        played = json.loads(ask(tmp_path, "play", "--loops", 20, "--json").stdout)
        assert played["underruns"] == played["refused_records"] == played["guard_trips"] == 0
        status = json.loads(ask(tmp_path, "device", "status", "--json").stdout)
        assert status["far_foci"] == status["bent_periods"] == 0
    finally:
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=30)


def test_a_board_that_nothing_can_stand_for(tmp_path):
    assert_one_message(run(["board", "run", "--board", "ice40-hx8k-breakout"], cwd=tmp_path), USAGE, "--board", "ice40-hx8k-breakout", "tile-100,", "--model reference")
    assert_one_message(run(["board", "run", "--board", "nothing"], cwd=tmp_path), BAD_INPUT, "nothing", "tile-100")
    assert_one_message(run(["board", "run", "--board", "tile-100", "--channels", 100], cwd=tmp_path), USAGE, "--channels", "--board")


def test_the_reference_board_has_no_signals_to_trace(tmp_path):
    said = run(["board", "run", "--model", "reference", "--trace", "t.fst"], cwd=tmp_path)
    assert_one_message(said, USAGE, "--trace", "--model rtl")
    assert not (tmp_path / "t.fst").exists()


def test_an_image_from_the_start_plays_without_an_upload(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        ask(tmp_path, "play", "--loops", 1)


def test_the_host_dies_and_the_watchdog_ends_it(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        command = [str(PROGRAM), "play", "--loops", "0", "--watchdog", "50", "--port", "port"]
        host = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE)
        time.sleep(STARTED)
        host.kill()
        host.communicate()
        for wait in (2, 10, 30):  # in real time: 50 ms on a slow simulation, in which nobody may speak
            time.sleep(wait)
            now = status(tmp_path)
            if now["outputs"] == "off":
                break
        assert (now["outputs"], now["watchdog_trips"], now["mode"]) == ("off", 1, "sequence")


def test_a_host_that_hangs_is_as_good_as_dead(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        command = [str(PROGRAM), "play", "--loops", "0", "--watchdog", "50", "--port", "port"]
        host = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(STARTED)
        host.send_signal(signal.SIGSTOP)
        time.sleep(10)  # in real time: 50 ms on a slow simulation
        host.send_signal(signal.SIGCONT)
        assert "turned its outputs off" in text(host.communicate(timeout=60)[1])
        assert host.returncode == DEVICE
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        assert json.loads(board.communicate(timeout=30)[0])["enabled"] is False


def test_ctrl_c_ends_playing_with_outputs_off(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--json", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        time.sleep(STARTED)
        host.send_signal(signal.SIGINT)
        assert json.loads(host.communicate(timeout=30)[0])["interrupted"] is True
        assert host.returncode == 0
        now = status(tmp_path)
        assert (now["outputs"], now["watchdog_trips"]) == ("off", 0)


def test_pyserial_sees_a_serial_port(tmp_path):
    with virtual_board(tmp_path):
        with serial.Serial(str(tmp_path / "port"), 1_000_000, timeout=10) as port:
            port.write(bytes(100) + b"no frame at all\0")
            time.sleep(0.5)  # until the board has heard it; what it hears after a change of the rate is noise
        assert status(tmp_path)["frames_damaged"] == 1


def test_a_port_has_one_user(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        time.sleep(STARTED)
        assert_one_message(run(["device", "disable", "--port", "port"], cwd=tmp_path), DEVICE, "port", "another program")
        host.send_signal(signal.SIGINT)
        assert host.wait(30) == 0


def test_a_stream_takes_as_long_as_its_dwells_and_is_never_late(tmp_path, image):
    (tmp_path / "lines").write_text("".join(f"{1 + i % 4}\n" for i in range(600)) + "2 7\r\n 3,8\n")
    # The Verilated board waits for a busy machine.
    with virtual_board(tmp_path, "--image", image, "--pulses", "pulses.csv", "--model", "rtl") as board:
        streamed = json.loads(ask(tmp_path, "stream", "lines", "--dwell", 2, "--json").stdout)
        assert streamed == {"sent": 602, "underruns": 0, "refused_records": 0, "interrupted": False}
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=30)
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    first = sorted(row for row in rows if row[0] == 0 and row[3] > 0)
    assert [row[3] for row in first][-15:] == [2] * 7 + [3] * 8  # one pulse a cycle on each channel
    assert len(first) >= 1200  # some merge at a change of focus


def test_a_stream_from_a_pipe_plays_what_is_there(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        command = [str(PROGRAM), "stream", "--port", "port", "--dwell", "0", "--json"]
        host = subprocess.Popen(command, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        host.stdin.write(b"3\n")
        host.stdin.flush()
        time.sleep(STARTED)
        host.stdin.close()
        assert json.loads(host.stdout.read()) == {"sent": 1, "underruns": 0, "refused_records": 0, "interrupted": False}
        assert host.wait(30) == 0


@pytest.mark.parametrize("line", ["x", "1 2 3", "5 y", "-1", "401", "1 65536", ""])
def test_a_bad_line_of_a_stream(line, tmp_path, image):
    (tmp_path / "lines").write_text(f"1\n{line}\n2\n")
    with virtual_board(tmp_path, "--image", image):
        assert_one_message(run(["stream", "lines", "--port", "port"], cwd=tmp_path), BAD_INPUT, "lines:2", f"'{line}'", "index dwell")
        assert status(tmp_path)["outputs"] == "off"


def test_what_a_stream_asks_for_and_does_not_get_is_told(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 4, "-o", "circle.hex"], cwd=tmp_path)
    (tmp_path / "lines").write_text("1 10\n300 10\n2 10\n")  # an index that the board has, and no record
    with virtual_board(tmp_path, "--image", "circle.hex"):
        assert json.loads(ask(tmp_path, "stream", "lines", "--json").stdout)["refused_records"] == 1
        assert b"3 indices, 0 underruns, 1 refused records" in ask(tmp_path, "stream", "lines").stdout


def test_a_part_of_the_sequence_ends_as_asked(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 8, "--rate", 100, "-o", "circle.hex"], cwd=tmp_path)
    with virtual_board(tmp_path, "--image", "circle.hex"):
        ask(tmp_path, "device", "enable", "--watchdog", 0)
        for part in (["--loops", 2], ["--first", 5, "--loops", 1], ["--first", 2, "--length", 3, "--loops", 1]):
            ask(tmp_path, "device", "start", *part)
            time.sleep(STARTED)
            assert status(tmp_path)["mode"] == "idle", part
        ask(tmp_path, "device", "start", "--first", 3)
        time.sleep(STARTED)
        assert status(tmp_path)["mode"] == "sequence"
        assert_one_message(run(["device", "start", "--first", 9, "--port", "port"], cwd=tmp_path), USAGE, "--first", "8 entries")


def test_an_image_for_another_board_is_refused_before_a_byte_is_written(tmp_path):
    succeed(["compile", "--shape", "point", "--board", "ice40-hx8k-breakout", "-o", "other.hex"], cwd=tmp_path)
    with virtual_board(tmp_path):
        before = status(tmp_path)["frames_good"]
        assert_one_message(run(["upload", "other.hex", "--port", "port"], cwd=tmp_path), BAD_INPUT, "other.hex", "48000000", "50000000")
        assert status(tmp_path)["frames_good"] == before + 5  # a question for the rate and identify; the same and status of this line


def test_the_ports_are_a_list():
    ports = json.loads(succeed(["device", "list", "--json"]).stdout)
    assert all(set(port) == {"port", "name"} and os.path.exists(port["port"]) for port in ports)
    assert len(succeed(["device", "list"]).stdout.splitlines()) == len(ports)


def test_nothing_to_play(tmp_path):
    with virtual_board(tmp_path):
        assert_one_message(run(["play", "--port", "port"], cwd=tmp_path), DEVICE, "no sequence", "upload")
        assert_one_message(run(["play", "--index", 401, "--port", "port"], cwd=tmp_path), DEVICE, "select", "bad_index")
        assert status(tmp_path)["outputs"] == "off"


def test_the_board_goes_while_playing(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--port", "port"], cwd=tmp_path, stderr=subprocess.PIPE)
        time.sleep(STARTED)
        board.kill()
        message = text(host.communicate(timeout=60)[1])
        assert host.returncode == DEVICE
        assert "the port is gone" in message


@pytest.mark.parametrize("command", [["device", "info"], ["play"]])
@pytest.mark.parametrize(("port", "needles"), [("nowhere", ["nowhere", "No such file"]), ("/dev/null", ["/dev/null", "shows the ports"])])
def test_what_is_no_port(command, port, needles, tmp_path):
    assert_one_message(run([*command, "--port", port], cwd=tmp_path), DEVICE, *needles)


def test_a_port_without_a_board(tmp_path):
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    assert_one_message(run(["device", "info", "--port", os.ttyname(theirs)], timeout=60), DEVICE, "no answer to identify", "baud")
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("args", [["device"], ["device", "info"], ["upload", "x.hex"], ["play", "--port", "p", "--index", "0"],
                                  ["device", "info", "--port", "p", "--baud", "12"], ["board", "run", "--channels", "7"]])  # fmt: skip
def test_wrong_usage(args):
    assert run(args).returncode == USAGE


def test_a_name_that_is_taken(tmp_path):
    (tmp_path / "port").write_text("mine")
    assert_one_message(run(["board", "run", "--pty", "port"], cwd=tmp_path), BAD_INPUT, "port", "name a place where nothing is")
    assert (tmp_path / "port").read_text() == "mine"


def test_a_board_for_so_much_simulated_time(tmp_path):
    said = succeed(["board", "run", "--seconds", "0.01", "--json"], cwd=tmp_path).stdout.splitlines()
    assert json.loads(said[1])["simulated_s"] == pytest.approx(0.01, abs=1e-4)


def test_pulses_are_written_as_they_come(tmp_path, image):
    with virtual_board(tmp_path, "--model", "reference", "--image", image, "--pulses", "pulses.csv") as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        sizes, held = [], []
        for _ in range(8):
            time.sleep(1)
            sizes.append(max((path.stat().st_size for path in tmp_path.glob("*pulses.csv*")), default=0))
            held.append(int(Path(f"/proc/{board.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE"))
        host.send_signal(signal.SIGINT)
        assert host.wait(30) == 0
        begun = time.monotonic()
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=30)
        assert time.monotonic() - begun < 2
    assert sizes[-1] > sizes[3] > 1 << 20
    assert held[-1] - held[3] < 1 << 23, f"{held} bytes in memory while {sizes} were written"
    rows = (tmp_path / "pulses.csv").read_text().splitlines()
    assert sum(row.startswith("channel") for row in rows) == 1 and len(rows) > 1 << 16
