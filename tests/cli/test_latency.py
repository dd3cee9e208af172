# SPDX-License-Identifier: Apache-2.0
"""How long a USB adapter keeps what a board answers, by the kernel's files, which umockdev makes the program find in a folder of the test's."""
import json
import shutil

import pytest
from messages import notice
from support import ROOT, ask, succeed, virtual_board

pytestmark = pytest.mark.skipif(shutil.which("umockdev-wrapper") is None, reason="umockdev is not installed")


def timer_of(folder):
    """The file in which the kernel has the latency timer of the board's port."""
    place = folder / "bed/sys/class/tty" / (folder / "port").resolve().name / "device"
    place.mkdir(parents=True)
    return place / "latency_timer"


def asked(folder, *args):
    """A command to which the folder is the kernel's."""
    told = {"UMOCKDEV_DIR": str(folder / "bed"), "LD_PRELOAD": "libumockdev-preload.so.0"}
    return succeed([*args, "--port", "port"], cwd=folder, env=told)


def test_a_timer_of_16_ms_is_set_to_1(tmp_path):
    with virtual_board(tmp_path):
        timer = timer_of(tmp_path)
        timer.write_text("16\n")
        info = json.loads(asked(tmp_path, "device", "info", "--json").stdout)
        assert timer.read_text().startswith("1") and int(timer.read_text()) == 1 == info["latency_timer_ms"]
        assert b"1" in asked(tmp_path, "device", "info").stdout


def test_a_timer_that_stays_is_told_of(tmp_path, image):
    with virtual_board(tmp_path):
        ask(tmp_path, "upload", image)
        fixed = "/proc/sys/kernel/cap_last_cap"  # a number above 1 that nobody can write
        timer_of(tmp_path).symlink_to(fixed)
        with open(fixed, encoding="ascii") as file:
            number = int(file.read())
        assert json.loads(asked(tmp_path, "device", "info", "--json").stdout)["latency_timer_ms"] == number
        (tmp_path / "lines").write_text("1\n2\n")
        done = asked(tmp_path, "stream", "lines", "--dwell", "40", "--watchdog", "60000")
        notice(done.stderr)
        assert done.stderr.count(b"latency timer") == 1
        done = asked(tmp_path, "live", "--from", "synthetic:press:200", "--seconds", "0.2", "--object", "sphere", "--size", "80", "--center", "0,40,180", "--algorithm", "A", "--watchdog", "60000")
        assert done.stderr.count(b"latency timer") == 1


def test_a_port_without_a_timer_has_none(tmp_path):
    with virtual_board(tmp_path):
        assert "latency_timer_ms" not in json.loads(ask(tmp_path, "device", "info", "--json").stdout)


def test_the_rule_of_the_package_sets_it():
    rule = (ROOT / "host/cli/60-haptogram.rules").read_text(encoding="utf-8").splitlines()[-1]
    assert 'DRIVERS=="ftdi_sio"' in rule and 'ATTR{latency_timer}="1"' in rule
