# SPDX-License-Identifier: Apache-2.0
"""The program haptogram-py as a user meets it: processes, exit codes, messages."""
import json
import os
import signal
import subprocess

import processes
import pytest
from processes import BAD_INPUT, DEVICE, USAGE, ask, assert_refused, haptogram, python_command, run, virtual_board
from haptogram import Image
from patience import also_in_time

def status(folder):
    return json.loads(ask(folder, "device", "status", "--json"))


def start(folder, *args, **more):
    return subprocess.Popen(python_command(*args, "--port", "port"), cwd=folder, env=processes.ENVIRONMENT, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, **more)  # fmt: skip


def test_both_programs_say_the_same_of_a_board(folder):
    with virtual_board(folder):
        ask(folder, "device", "enable", "--watchdog", 60000)
        for command in ("info", "status"):
            theirs = json.loads(haptogram(folder, "device", command, "--json", "--port", "port"))
            ours = json.loads(ask(folder, "device", command, "--json"))
            counters = {"frames_good", "frames_repeated"}  # of frames between the two
            assert {k: ours[k] for k in theirs.keys() - counters} == {k: theirs[k] for k in theirs.keys() - counters}
        assert (ours["outputs"], ours["watchdog_ms"]) == ("on", 60000)
        ask(folder, "device", "disable")
        assert "outputs          off" in ask(folder, "device", "status").splitlines()
        ask(folder, "device", "stop")


def test_what_one_program_uploads_the_other_finds(folder, image):
    with virtual_board(folder):
        said = json.loads(ask(folder, "upload", "image.hex", "--verify", "--json"))
        assert (said["records"], said["sequence_entries"], said["frames_written"], said["verified"]) == (8, 8, 9, True)
        assert "8 records and 8 sequence entries" in ask(folder, "download", "-o", "back.hex")
        assert Image.load(str(folder / "back.hex")) == image
        haptogram(folder, "compile", "--shape", "circle", "--points", 4, "--rate", 1000, "-o", "other.hex")
        haptogram(folder, "upload", "other.hex", "--port", "port")
        (folder / "stdout.hex").write_text(ask(folder, "download", "-o", "-"))
        assert Image.load(str(folder / "stdout.hex")) == Image.load(str(folder / "other.hex"))


def test_play_ends_with_outputs_off(folder):
    with virtual_board(folder, "--image", "image.hex") as board:
        whole = {"underruns": 0, "refused_records": 0, "watchdog_trips": 0, "guard_trips": 0, "interrupted": False}
        assert json.loads(ask(folder, "play", "--loops", 1, "--json")) == whole
        assert json.loads(ask(folder, "play", "--index", 3, "--seconds", 0.3, "--json")) == whole
        host = start(folder, "play", "--watchdog", "60000", "--json")  # for ever, as the image says
        board.until(outputs=True, record=True)
        host.send_signal(signal.SIGINT)
        assert json.loads(host.communicate(timeout=300)[0])["interrupted"] is True
        assert host.returncode == 0
        now = status(folder)
        assert (now["outputs"], now["index"], now["watchdog_trips"]) == ("off", 0, 0)


@also_in_time
def test_a_stream_is_played_in_order(folder, in_time):
    """What the board holds lasts 13 ms, so that only on an idle machine it is never late. The order is the same on any."""
    (folder / "lines").write_text("".join(f"{1 + i % 4}\n" for i in range(300)) + "5 7\r\n 6,8")
    with virtual_board(folder, "--image", "image.hex", "--pulses", "pulses.csv") as board:
        said = json.loads(ask(folder, "stream", "lines", "--dwell", 2, "--json"))
        assert said == {"sent": 302, "underruns": 0 if in_time else said["underruns"], "refused_records": 0, "interrupted": False}
        assert status(folder)["outputs"] == "off"
        board.send_signal(signal.SIGINT)
        board.communicate(timeout=300)
    rows = [[int(n) for n in line.split(",")] for line in (folder / "pulses.csv").read_text().splitlines()[1:]]
    played = [row[3] for row in sorted(rows) if row[0] == 0 and row[3] > 0]
    if in_time:
        assert played[-15:] == [5] * 7 + [6] * 8  # one pulse a cycle
    changes = [a for a, b in zip(played, played[1:], strict=False) if a != b]
    assert changes == [1 + i % 4 for i in range(300)] + [5]


def test_a_pipe_is_played_as_it_comes_and_silence_between_is_no_failure(folder):
    with virtual_board(folder, "--image", "image.hex") as board:
        host = start(folder, "stream", "--dwell", "0", "--watchdog", "60000", "--json", stdin=subprocess.PIPE)
        for record in (3, 4):
            host.stdin.write(f"{record}\n")
            host.stdin.flush()
            board.until(outputs=True, record=record)
            board.goes_on_for(0.3)
        assert json.loads(host.communicate(timeout=300)[0]) == {"sent": 2, "underruns": 0, "refused_records": 0, "interrupted": False}


def test_what_cannot_be_played_or_read(folder):
    (folder / "lines").write_text("1\n401\n2\n")
    (folder / "bad.hex").write_text((folder / "image.hex").read_text()[:500])
    with virtual_board(folder):
        for args, code in (
            (["play"], DEVICE),
            (["play", "--index", 401], DEVICE),
            (["download", "-o", "no.hex"], DEVICE),
            (["upload", "bad.hex"], BAD_INPUT),
            (["upload", "missing.hex"], BAD_INPUT),
            (["stream", "lines"], BAD_INPUT),
            (["stream", "missing"], BAD_INPUT),
        ):
            assert_refused(run(python_command(*args, "--port", "port"), folder), code)
        assert status(folder)["outputs"] == "off"
        assert not (folder / "no.hex").exists()


def test_the_board_goes_while_playing(folder):
    with virtual_board(folder, "--image", "image.hex") as board:
        host = start(folder, "play", "--watchdog", "60000")
        board.until(outputs=True, record=True)
        board.kill()
        message = host.communicate(timeout=300)[1]
    assert host.returncode == DEVICE
    assert "the port is gone" in message and "its watchdog turns them off 60000 ms after" in message and "Traceback" not in message


@pytest.mark.parametrize("port", ["nowhere", "/dev/null"])
def test_what_is_no_port(port, tmp_path):
    assert_refused(run(python_command("device", "info", "--port", port), tmp_path), DEVICE)


def test_a_port_without_a_board(tmp_path):
    ours, theirs = os.openpty()
    result = run(python_command("device", "info", "--port", os.ttyname(theirs)), tmp_path)
    assert_refused(result, DEVICE)
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("args", [[], ["device"], ["device", "info"], ["upload", "--port", "p"], ["play", "--port", "p", "--index", "0"],
                                  ["play", "--port", "p", "--index", "1", "--loops", "1"], ["play", "--port", "p", "--seconds", "nan"],
                                  ["device", "info", "--port", "p", "--baud", "12"], ["nothing"]])  # fmt: skip
def test_wrong_usage(args, tmp_path):
    assert_refused(run(python_command(*args), tmp_path), USAGE)


@pytest.mark.parametrize("args", [["device", "list", "--json"], ["--help"]], ids=["list", "help"])
def test_no_room_for_what_is_printed(args, tmp_path):
    with open("/dev/full", "w") as full:
        result = run(python_command(*args), tmp_path, stdout=full)
    assert result.returncode == BAD_INPUT
    assert result.stderr == "haptogram-py: standard output: No space left on device; what was printed is incomplete\n"


def test_the_ports_are_a_list(tmp_path):
    ports = json.loads(run(python_command("device", "list", "--json"), tmp_path).stdout)
    assert all(set(port) == {"port", "name"} and os.path.exists(port["port"]) for port in ports)
