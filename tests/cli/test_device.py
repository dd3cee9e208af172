# SPDX-License-Identifier: Apache-2.0
"""A board behind a serial port: `haptogram board run` and the commands that speak to it, each a process of its own."""
import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
import serial
from patience import also_in_time, bytes_read, until
from support import BAD_INPUT, DEVICE, PROGRAM, USAGE, ask, assert_one_message, run, status, succeed, text, virtual_board


@pytest.mark.check
def test_info_is_what_the_core_was_built_with(tmp_path):
    with virtual_board(tmp_path) as board:
        info = json.loads(ask(tmp_path, "device", "info", "--json").stdout)
        assert info["name"] == "Haptogram"
        assert {key: info[key] for key in ("channels", "records", "clock_hz")} == {key: board.says[key] for key in ("channels", "records", "clock_hz")}


@pytest.mark.check
def test_upload_play_and_the_files_of_the_board(tmp_path, image):
    with virtual_board(tmp_path, "--pulses", "pulses.csv", "--model", "rtl") as board:
        assert json.loads(ask(tmp_path, "upload", image, "--verify", "--json").stdout)["verified"]
        played = json.loads(ask(tmp_path, "play", "--loops", 2, "--json").stdout)
        assert played == {"underruns": 0, "refused_records": 0, "watchdog_trips": 0, "guard_trips": 0, "interrupted": False}
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        said = board.communicate(timeout=300)[0]
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
        said = json.loads(board.communicate(timeout=300)[0])
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
        board.communicate(timeout=300)


def test_a_board_that_nothing_can_stand_for(tmp_path):
    assert_one_message(run(["board", "run", "--board", "ice40-hx8k-breakout"], cwd=tmp_path), USAGE)
    assert_one_message(run(["board", "run", "--board", "nothing"], cwd=tmp_path), BAD_INPUT)
    assert_one_message(run(["board", "run", "--board", "tile-100", "--channels", 100], cwd=tmp_path), USAGE)


def test_the_reference_board_has_no_signals_to_trace(tmp_path):
    said = run(["board", "run", "--model", "reference", "--trace", "t.fst"], cwd=tmp_path)
    assert_one_message(said, USAGE)
    assert not (tmp_path / "t.fst").exists()


def test_an_image_from_the_start_plays_without_an_upload(tmp_path, image):
    with virtual_board(tmp_path, "--image", image):
        ask(tmp_path, "play", "--loops", 1)


def test_the_host_dies_and_the_watchdog_ends_it(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        command = [str(PROGRAM), "play", "--loops", "0", "--watchdog", "1500", "--port", "port"]
        host = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE)
        board.until(outputs=True, record=True)
        host.kill()
        host.communicate()
        board.until(outputs=False)
        now = status(tmp_path)
        assert (now["outputs"], now["watchdog_trips"], now["mode"]) == ("off", 1, "sequence")


@pytest.mark.real_time
def test_the_watchdog_is_as_quick_as_it_is_set(tmp_path, image, figure):
    """In the board's own time, to which its line is told on the terminal five times a second."""
    with virtual_board(tmp_path, "--image", image) as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--watchdog", "50", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        playing_s = board.until(outputs=True, record=True)[0]
        board.goes_on_for(2)
        assert board.now()[2], "a host keeps a watchdog of 50 ms away"
        host.kill()
        host.communicate()
        begun = time.monotonic()
        board.until(outputs=False)
        figure("serial line: outputs off after the host was killed, its watchdog being 50 ms", time.monotonic() - begun, 0.3)
        assert playing_s < board.now()[0]


def test_a_host_that_hangs_is_as_good_as_dead(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        command = [str(PROGRAM), "play", "--loops", "0", "--watchdog", "1500", "--port", "port"]
        host = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        board.until(outputs=True, record=True)
        host.send_signal(signal.SIGSTOP)
        board.until(outputs=False)
        host.send_signal(signal.SIGCONT)
        assert "turned its outputs off" in text(host.communicate(timeout=300)[1])
        assert host.returncode == DEVICE
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        assert json.loads(board.communicate(timeout=300)[0])["enabled"] is False


def test_ctrl_c_ends_playing_with_outputs_off(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--watchdog", "60000", "--json", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        board.until(outputs=True, record=True)
        host.send_signal(signal.SIGINT)
        assert json.loads(host.communicate(timeout=300)[0])["interrupted"] is True
        assert host.returncode == 0
        now = status(tmp_path)
        assert (now["outputs"], now["watchdog_trips"]) == ("off", 0)


def test_pyserial_sees_a_serial_port(tmp_path):
    with virtual_board(tmp_path) as board:
        heard = bytes_read(board)
        with serial.Serial(str(tmp_path / "port"), 1_000_000, timeout=300) as port:
            port.write(bytes(100) + b"no frame at all\0")
            until(lambda: bytes_read(board) >= heard + 116, "the board having read them")  # what it hears after a change of the rate is noise
        assert status(tmp_path)["frames_damaged"] == 1


def test_a_port_has_one_user(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--watchdog", "60000", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        board.until(outputs=True, record=True)
        assert_one_message(run(["device", "disable", "--port", "port"], cwd=tmp_path), DEVICE)
        host.send_signal(signal.SIGINT)
        assert host.wait(300) == 0


@also_in_time
def test_a_stream_takes_as_long_as_its_dwells_and_is_never_late(tmp_path, image, in_time):
    """What the board holds lasts 13 ms, so that only on an idle machine it is never late. The order is the same on any."""
    (tmp_path / "lines").write_text("".join(f"{1 + i % 4}\n" for i in range(600)) + "2 7\r\n 3,8\n")
    with virtual_board(tmp_path, "--image", image, "--pulses", "pulses.csv", "--model", "rtl") as board:
        streamed = json.loads(ask(tmp_path, "stream", "lines", "--dwell", 2, "--json").stdout)
        assert streamed == {"sent": 602, "underruns": 0 if in_time else streamed["underruns"], "refused_records": 0, "interrupted": False}
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=300)
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    first = sorted(row for row in rows if row[0] == 0 and row[3] > 0)
    played = [row[3] for row in first]
    assert [a for a, b in zip(played, [*played[1:], 0]) if a != b] == [1, 2, 3, 4] * 150 + [2, 3]
    if in_time:
        assert played[-15:] == [2] * 7 + [3] * 8  # one pulse a cycle on each channel
        assert len(first) >= 1200  # some merge at a change of focus


def test_a_stream_from_a_pipe_plays_what_is_there(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        command = [str(PROGRAM), "stream", "--port", "port", "--dwell", "0", "--watchdog", "60000", "--json"]
        host = subprocess.Popen(command, cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        host.stdin.write(b"3\n")
        host.stdin.flush()
        board.until(outputs=True, record=3)
        host.stdin.close()
        assert json.loads(host.stdout.read()) == {"sent": 1, "underruns": 0, "refused_records": 0, "interrupted": False}
        assert host.wait(300) == 0


@pytest.mark.parametrize("line", ["x", "1 2 3", "5 y", "-1", "401", "1 65536", ""])
def test_a_bad_line_of_a_stream(line, tmp_path, image):
    (tmp_path / "lines").write_text(f"1\n{line}\n2\n")
    with virtual_board(tmp_path, "--image", image):
        assert_one_message(run(["stream", "lines", "--port", "port"], cwd=tmp_path), BAD_INPUT)
        assert status(tmp_path)["outputs"] == "off"


@also_in_time
def test_what_a_stream_asks_for_and_does_not_get_is_told(tmp_path, in_time):
    succeed(["compile", "--shape", "circle", "--points", 4, "-o", "circle.hex"], cwd=tmp_path)
    (tmp_path / "lines").write_text("1 10\n300 10\n2 10\n")  # an index that the board has, and no record
    with virtual_board(tmp_path, "--image", "circle.hex"):
        assert json.loads(ask(tmp_path, "stream", "lines", "--json").stdout)["refused_records"] == 1
        late = rb"0" if in_time else rb"\d+"
        assert re.search(rb"3 indices, " + late + rb" underruns, 1 refused records", ask(tmp_path, "stream", "lines").stdout)


def test_a_part_of_the_sequence_ends_as_asked(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 8, "--rate", 100, "-o", "circle.hex"], cwd=tmp_path)
    with virtual_board(tmp_path, "--image", "circle.hex") as board:
        ask(tmp_path, "device", "enable", "--watchdog", 0)
        for part in (["--loops", 2], ["--first", 5, "--loops", 1], ["--first", 2, "--length", 3, "--loops", 1]):
            ask(tmp_path, "device", "start", *part)
            until(lambda: status(tmp_path)["mode"] == "idle", f"the end of {part}")
        ask(tmp_path, "device", "start", "--first", 3)
        board.goes_on_for(0.1)  # ten passes
        assert status(tmp_path)["mode"] == "sequence"
        assert_one_message(run(["device", "start", "--first", 9, "--port", "port"], cwd=tmp_path), USAGE)


def test_an_image_for_another_board_is_refused_before_a_byte_is_written(tmp_path):
    succeed(["compile", "--shape", "point", "--board", "ice40-hx8k-breakout", "-o", "other.hex"], cwd=tmp_path)
    with virtual_board(tmp_path):
        before = status(tmp_path)["frames_good"]
        assert_one_message(run(["upload", "other.hex", "--port", "port"], cwd=tmp_path), BAD_INPUT)
        assert status(tmp_path)["frames_good"] == before + 5  # a question for the rate and identify; the same and status of this line


def test_the_ports_are_a_list():
    ports = json.loads(succeed(["device", "list", "--json"]).stdout)
    assert all(set(port) == {"port", "name"} and os.path.exists(port["port"]) for port in ports)
    assert len(succeed(["device", "list"]).stdout.splitlines()) == len(ports)


@pytest.mark.check
def test_nothing_to_play(tmp_path):
    with virtual_board(tmp_path):
        assert_one_message(run(["play", "--port", "port"], cwd=tmp_path), DEVICE)
        assert_one_message(run(["play", "--index", 401, "--port", "port"], cwd=tmp_path), DEVICE)
        assert status(tmp_path)["outputs"] == "off"


def test_the_board_goes_while_playing(tmp_path, image):
    with virtual_board(tmp_path, "--image", image) as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--watchdog", "60000", "--port", "port"], cwd=tmp_path, stderr=subprocess.PIPE)
        board.until(outputs=True, record=True)
        board.kill()
        message = text(host.communicate(timeout=300)[1])
        assert host.returncode == DEVICE
        assert "the port is gone" in message


@pytest.mark.parametrize("command", [["device", "info"], ["play"]])
@pytest.mark.parametrize("port", ["nowhere", "/dev/null"])
def test_what_is_no_port(command, port, tmp_path):
    assert_one_message(run([*command, "--port", port], cwd=tmp_path), DEVICE)


def test_a_port_without_a_board(tmp_path):
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    assert_one_message(run(["device", "info", "--port", os.ttyname(theirs)], timeout=300), DEVICE)
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("args", [["device"], ["device", "info"], ["upload", "x.hex"], ["play", "--port", "p", "--index", "0"],
                                  ["device", "info", "--port", "p", "--baud", "12"], ["board", "run", "--channels", "7"]])  # fmt: skip
def test_wrong_usage(args):
    assert run(args).returncode == USAGE


def test_a_name_that_is_taken(tmp_path):
    (tmp_path / "port").write_text("mine")
    assert_one_message(run(["board", "run", "--pty", "port"], cwd=tmp_path), BAD_INPUT)
    assert (tmp_path / "port").read_text() == "mine"


def test_a_board_for_so_much_simulated_time(tmp_path):
    said = succeed(["board", "run", "--seconds", "0.01", "--json"], cwd=tmp_path).stdout.splitlines()
    assert json.loads(said[1])["simulated_s"] == pytest.approx(0.01, abs=1e-4)


@also_in_time
def test_pulses_are_written_as_they_come(tmp_path, image, figure, in_time):
    def written():
        return max((path.stat().st_size for path in tmp_path.glob("*pulses.csv*")), default=0)

    def held():
        return int(Path(f"/proc/{board.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    with virtual_board(tmp_path, "--model", "reference", "--image", image, "--pulses", "pulses.csv") as board:
        host = subprocess.Popen([str(PROGRAM), "play", "--loops", "0", "--watchdog", "60000", "--port", "port"], cwd=tmp_path, stdout=subprocess.PIPE)
        until(lambda: written() > 4 << 20, "4 MiB in the file")
        before = held()
        until(lambda: written() > 20 << 20, "20 MiB in the file")
        after = held()
        host.send_signal(signal.SIGINT)
        assert host.wait(300) == 0
        begun = time.monotonic()
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=300)
        if in_time:
            figure("the end of a board that has written 20 MiB of pulses", time.monotonic() - begun, 0.7)
    assert after - before < 1 << 23, f"{before} bytes in memory, and {after} when 16 MiB more were written"
    rows = (tmp_path / "pulses.csv").read_text().splitlines()
    assert sum(row.startswith("channel") for row in rows) == 1 and len(rows) > 1 << 16
