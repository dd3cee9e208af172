# SPDX-License-Identifier: Apache-2.0
"""The commands of the pages for users, as they stand there: each page's blocks in its order, in one folder. Blocks that need hardware,
a person or an installation are marked `sh board`, and are not run."""
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = {"README.md": 3, "constraints/README.md": 3, "docs/README.md": 1, "docs/build-one.md": 3, "extras/calibration/README.md": 5, "docs/foci.md": 1, "extras/papers/README.md": 2, "extras/hands/README.md": 1,
         "docs/tiles.md": 2, "extras/hardware/README.md": 1, "host/arrays/README.md": 2, "extras/robot/README.md": 2}  # and how many blocks they have at least  # fmt: skip
OTHERS = {
    "CONTRIBUTING.md": "builds and tests the whole",
    "tests/README.md": "the same",
    "extras/scattering/README.md": "takes minutes; test_scatter.py has the commands",
    "python/README.md": "installs, and needs boards and cameras; tests/python has the commands",
    "extras/studies/README.md": "asks people; tests/python has the commands",
    "extras/sweep/README.md": "installs; docs/notebooks/sweep.ipynb is run",
}
BLOCK = re.compile(r"^```(sh|toml \S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_every_page_with_commands_is_run_or_said_why_not():
    names = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    assert {name for name in names if "sh" in dict(BLOCK.findall((ROOT / name).read_text(encoding="utf-8")))} == {*PAGES, *OTHERS}


@pytest.mark.parametrize("page", [pytest.param(page, marks=pytest.mark.deep) if page == "extras/robot/README.md" else page for page in PAGES])
def test_every_command_of_the_page_runs(page, program, tmp_path):
    folder = tmp_path / "bin"
    folder.mkdir()
    (folder / "haptogram").symlink_to(program)
    (folder / "python3").write_text(f"#!/bin/sh\nexec '{sys.executable}' \"$@\"\n")  # which has numpy
    (folder / "python3").chmod(0o755)
    for name in ("tools", "extras"):  # whose files a page names
        (tmp_path / name).symlink_to(ROOT / name)
    blocks = BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))
    assert len(blocks) >= PAGES[page]
    # Boards in the background end with the script. A port is there when its name is.
    script = ["set -eu", "trap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT"]
    for kind, text in blocks:
        if kind != "sh":
            file = tmp_path / kind.split()[1]
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
            continue
        for line in text.splitlines():
            script.append(line)
            if line.split(" #")[0].rstrip().endswith("&"):
                script.append("for _ in $(seq 3000); do [ -e board ] || [ -e board-4 ] && break; sleep 0.1; done")
    environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-c", "\n".join(script)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
