# SPDX-License-Identifier: Apache-2.0
"""Images over a link: what is written, what is read back, and what an unplug, a bad line and another rate make of it."""
import contextlib
import json
import os
import pty
import random
import re
import select
import subprocess
import threading
import time
import tty

import pytest
from patience import also_in_time
from support import BAD_INPUT, DEVICE, PROGRAM, USAGE, Image, ask, assert_one_message, open_raw, run, status, succeed, text, virtual_board


class Cable:
    """A line between `folder`/port and a board's own port, which can be pulled, is pulled once it has carried `most` bytes to the board,
    and spoils what `spoil` says."""

    def __init__(self, folder, board, spoil=lambda data: data, most=1 << 60):
        self.path, self.spoil, self.most = folder / "cable", spoil, most
        self.far = open_raw(folder / board)
        self.near = self.held = None
        self.carried = 0
        self.lock = threading.RLock()
        self.ended = False
        self.plug()
        os.set_blocking(self.far, False)
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    def plug(self):
        with self.lock:
            self.near, self.held = pty.openpty()
            tty.setraw(self.held)
            os.set_blocking(self.near, False)
            self.path.symlink_to(os.ttyname(self.held))

    def pull(self):
        with self.lock:
            self.path.unlink()
            os.close(self.near)
            os.close(self.held)
            self.near = None

    def carry(self):
        while not self.ended:
            with self.lock:
                ends = [end for end in (self.near, self.far) if end is not None]
                for end in select.select(ends, [], [], 0.0)[0]:
                    other = self.far if end == self.near else self.near
                    with contextlib.suppress(BlockingIOError):  # when nobody listens it is lost, as on a line
                        data = self.spoil(os.read(end, 256))
                        if data and other is not None:
                            os.write(other, data)
                            self.carried += len(data) if other == self.far else 0
                    if self.carried >= self.most and self.near is not None:
                        self.most = 1 << 60
                        self.pull()
                        break
            time.sleep(0.0005)

    def close(self):
        self.ended = True
        self.thread.join(10)
        if self.near is not None:
            self.pull()
        os.close(self.far)


@contextlib.contextmanager
def cable(folder, board, **more):
    line = Cable(folder, board, **more)
    try:
        yield line
    finally:
        line.close()


def upload(folder, *args, port="port"):
    result = succeed(["upload", *args, "--json", "--port", port], cwd=folder, timeout=300)
    return json.loads(result.stdout)


@pytest.mark.check
def test_only_what_differs_is_written(tmp_path, image):
    other = Image(tmp_path / image)
    other.put16(other.record_word(2, 10), 7)
    other.save(tmp_path / "other.hex")
    with virtual_board(tmp_path):
        first = upload(tmp_path, image)
        assert (first["frames"], first["frames_written"]) == (5, 5)
        assert upload(tmp_path, image, "--verify")["frames_written"] == 0
        assert upload(tmp_path, "other.hex")["frames_written"] == 1
        assert upload(tmp_path, image, "--verify")["frames_written"] == 1


@pytest.mark.check
def test_a_download_is_what_was_uploaded(tmp_path, image):
    with virtual_board(tmp_path):
        upload(tmp_path, image)
        told = json.loads(ask(tmp_path, "download", "-o", "back.hex", "--json").stdout)
        assert told == {"records": 4, "sequence_entries": 4, "problems": []}
        ask(tmp_path, "download", "-o", "more.hex", "--records", 6)
    there, back, more = (Image(tmp_path / name) for name in (image, "back.hex", "more.hex"))
    assert back.records() == there.records()
    assert list(back.sequence()) == list(there.sequence())
    assert more.count == 6 and more.records()[:4] == there.records()
    succeed(["inspect", "back.hex"], cwd=tmp_path)


def test_what_cannot_be_downloaded(tmp_path):
    with virtual_board(tmp_path):
        assert_one_message(run(["download", "-o", "x.hex", "--port", "port"], cwd=tmp_path), DEVICE)
        assert_one_message(run(["download", "-o", "x.hex", "--records", "401", "--port", "port"], cwd=tmp_path), USAGE)
        assert not (tmp_path / "x.hex").exists()


def test_a_full_disk_leaves_the_old_file(tmp_path, image, full_device):
    with virtual_board(tmp_path):
        upload(tmp_path, image)
        assert_one_message(run(["download", "-o", str(full_device), "--port", "port"], cwd=tmp_path), BAD_INPUT)


def test_an_upload_goes_on_after_an_unplug(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 150, "--rate", 10, "-o", "big.hex"], cwd=tmp_path)
    with virtual_board(tmp_path) as board:
        with cable(tmp_path, board.says["port"], most=15_000) as line:
            command = [str(PROGRAM), "upload", "big.hex", "--json", "--verify", "--wait", "290", "--port", "cable"]
            host = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            complaint = ""
            while "waiting" not in complaint:
                complaint += text(host.stderr.readline())
                assert host.poll() is None, complaint
            line.plug()
            said, rest = host.communicate(timeout=300)
            assert host.returncode == 0, text(rest)
            said = json.loads(said)
            assert (said["link_losses"], said["verified"]) == (1, True)
            assert re.search("cable.*waiting (290|28[0-9]) s", complaint, re.DOTALL), complaint
            assert line.carried < 60_000  # the image has 32,000 bytes: it was not begun anew
        # The cable is gone: as long as it is there it takes replies away from whoever else opens the board's port.
        assert status(tmp_path)["outputs"] == "off"


def test_an_upload_that_was_cut_off_goes_on_in_the_next(tmp_path):
    succeed(["compile", "--shape", "circle", "--points", 150, "--rate", 10, "-o", "big.hex"], cwd=tmp_path)
    with virtual_board(tmp_path) as board, cable(tmp_path, board.says["port"], most=15_000) as line:
        stopped = run(["upload", "big.hex", "--wait", "0", "--port", "cable"], cwd=tmp_path)
        assert stopped.returncode == DEVICE and "goes on where this one stopped" in text(stopped.stderr)
        line.plug()
        again = upload(tmp_path, "big.hex", "--verify", port="cable")
        assert 20 < again["frames_written"] < 130


def test_a_line_that_spoils_bytes(tmp_path):
    rng = random.Random(7)

    def spoil(data):
        out = bytearray()
        for byte in data:
            chance = rng.random()
            if chance < 0.0008:
                byte ^= 1 << rng.randrange(8)
            if chance < 0.0004:
                continue
            out += bytes([byte] * (2 if 0.0008 < chance < 0.0012 else 1))
        return bytes(out)

    succeed(["compile", "--shape", "circle", "--points", 60, "--rate", 10, "-o", "big.hex"], cwd=tmp_path)
    with virtual_board(tmp_path) as board:
        with cable(tmp_path, board.says["port"], spoil=spoil):
            said = upload(tmp_path, "big.hex", port="cable")
        assert said["frames_written"] >= 60 and said["retransmissions"] > 0
        assert upload(tmp_path, "big.hex", "--verify")["frames_written"] == 0


@also_in_time
def test_play_at_another_rate(tmp_path, image, in_time):
    with virtual_board(tmp_path, "--image", image, "--pulses", "pulses.csv") as board:
        played = json.loads(ask(tmp_path, "play", "--rate", 500, "--loops", 3, "--json").stdout)
        assert played == {"sent": 12, "underruns": 0 if in_time else played["underruns"], "refused_records": 0, "interrupted": False}
        ask(tmp_path, "play", "--sequence", "--loops", 1)  # the memory is as it was
        board.send_signal(2)
        board.communicate(timeout=300)
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    first = [row[3] for row in sorted(row for row in rows if row[0] == 0 and row[3] > 0)]
    runs = [index for i, index in enumerate(first) if i == 0 or first[i - 1] != index]
    assert runs == [1, 2, 3, 4] * 4
    if not played["underruns"]:
        assert abs(len(first) - (3 * 80 + 40)) <= 16  # 40 kHz: 80 cycles a pass at 500 Hz, 40 at 1000; some merge at a change


@pytest.mark.parametrize("args", [["play", "--rate", 20000],
                                              ["stream", "lines", "--rate", 30000]])  # fmt: skip
def test_a_rate_that_cannot_be_made(args, tmp_path, image):
    (tmp_path / "lines").write_text("1\n")
    with virtual_board(tmp_path, "--image", image):
        assert_one_message(run([*args, "--port", "port"], cwd=tmp_path), USAGE)
        assert status(tmp_path)["outputs"] == "off"


@pytest.mark.check
def test_a_stream_at_a_rate(tmp_path, image):
    (tmp_path / "lines").write_text("1\n2\n3\n4\n")
    with virtual_board(tmp_path, "--image", image, "--pulses", "pulses.csv") as board:
        ask(tmp_path, "stream", "lines", "--rate", 2000)
        board.send_signal(2)
        board.communicate(timeout=300)
    rows = [[int(n) for n in line.split(",")] for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]]
    assert abs(sum(row[0] == 0 and row[3] > 0 for row in rows) - 4 * 20) <= 4


def test_the_example_of_the_client_plays_an_image(tmp_path, image):
    example = PROGRAM.parents[1] / "haptogram_example"
    with virtual_board(tmp_path, "--pulses", "pulses.csv") as board:
        done = subprocess.run([str(example), "port", image], cwd=tmp_path, capture_output=True, timeout=300, check=False)
        assert (done.returncode, done.stderr) == (0, b"")
        assert status(tmp_path)["outputs"] == "off"
        board.send_signal(2)
        said = json.loads(board.communicate(timeout=300)[0])
        assert said["frames_in"] == said["frames_applied"] + said["frames_repeated"] and said["frames_applied"] > 10 and said["frames_refused"] == 0
    assert {int(line.split(",")[3]) for line in (tmp_path / "pulses.csv").read_text().splitlines()[1:]} >= {1, 2, 3, 4}
    assert subprocess.run([str(example), "nowhere", image], cwd=tmp_path, capture_output=True, check=False).returncode == DEVICE
