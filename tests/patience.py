# SPDX-License-Identifier: Apache-2.0
"""Waiting for what happens, and not for a time in which it should have. Limits are for hangs: a busy machine never reaches them."""
import json
import os
import re
import subprocess
import threading
import time
from pathlib import Path

import pytest

PATIENCE_S = 300

# A case in two sizes: what holds on any machine, and against the kernel's clock.
also_in_time = pytest.mark.parametrize("in_time", [pytest.param(False, id="order"), pytest.param(True, id="time", marks=pytest.mark.real_time)])


def until(condition, what="that", seconds=PATIENCE_S, every=0.005):
    """What `condition` returns once that is true."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, f"it never came to {what}"
        time.sleep(every)
    return found


def bytes_read(process):
    """Of all files and ports, since the process began."""
    return int(re.search(r"rchar: (\d+)", Path(f"/proc/{process.pid}/io").read_text())[1])


class Board:
    """`haptogram board run --json` as a process. Its messages go to a terminal, on which it tells all the time what it does."""

    LINE = re.compile(r"\r([0-9.]+) s simulated, \S+ of real time, record (\d+), outputs (on|off), (\d+) frames in")

    def __init__(self, command, folder):
        ours, theirs = os.openpty()
        self.process = subprocess.Popen([str(word) for word in command], cwd=folder, stdout=subprocess.PIPE, stderr=theirs)
        os.close(theirs)
        self._terminal, self._shown, self._lines = ours, b"", 0
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        first = self.process.stdout.readline()
        assert first, self.end()
        self.says = json.loads(first)

    def __getattr__(self, name):
        return getattr(self.process, name)

    def _read(self):
        try:
            while part := os.read(self._terminal, 65536):
                self._shown = (self._shown + part)[-4096:]
                self._lines += part.count(b"refused\x1b[K")
        except OSError:  # the terminal has gone with its last user
            pass

    def end(self):
        self.process.kill()
        self.process.communicate()
        self._reader.join()
        os.close(self._terminal)
        return self._shown.decode(errors="replace")

    def now(self):
        """Simulated seconds, the record that plays, whether outputs are on: by a line that was not there before the question."""
        before = self._lines
        until(lambda: self._lines > before or self.process.poll() is not None, "a new line of the board")
        assert self.process.poll() is None, f"the board has ended: {self._shown.decode('utf-8', 'replace')}"
        simulated_s, record, outputs, _ = self.LINE.findall(self._shown.decode(errors="replace"))[-1]
        return float(simulated_s), int(record), outputs == "on"

    def until(self, outputs, record=None):
        """Until outputs are on or off, and a record plays: this one, or with record=True any."""
        return until(lambda: (now := self.now())[2] == outputs and (record is None or (now[1] > 0 if record is True else now[1] == record)),
                     f"outputs {'on' if outputs else 'off'}, record {record}")  # fmt: skip

    def goes_on_for(self, seconds):
        """In the board's own time."""
        begun = self.now()[0]
        until(lambda: self.now()[0] >= begun + seconds, f"{seconds} s more")
