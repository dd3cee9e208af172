#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A sweep of 1,000 configurations by one worker and by two, for tools/bench.py; prints one JSON object of seconds."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PLAN = """format = "haptogram-sweep-1"
quantities = ["pressure_pa", "side_lobe", "workspace_cm3"]
[vary]
side = [8, 9, 10, 11]
pitch_mm = { from = 8.6, to = 12, steps = 50 }
focus_mm = [[0, 0, 100], [0, 0, 130], [20, 0, 130], [0, 0, 160], [0, 20, 160]]
[workspace]
least_pa = 1500
step_mm = 20
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    build = parser.parse_args().build.resolve()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ROOT / "python", ROOT / "extras/sweep")))}
    seconds, whole, rows = {}, {}, []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
        for workers in (1, 2):
            begun = time.perf_counter()
            done = subprocess.run([sys.executable, "-m", "haptogram_sweep", "plan.toml", "-o", f"{workers}.parquet", "--workers", str(workers), "--page", "", "--json"],
                                  cwd=folder, env=environment, stdout=subprocess.PIPE, text=True, check=True)  # fmt: skip
            whole[workers] = time.perf_counter() - begun
            seconds[workers] = json.loads(done.stdout)["seconds"]
            rows.append((folder / f"{workers}.parquet").read_bytes())
    print(json.dumps({"seconds": seconds, "whole_seconds": whole, "same": rows[0] == rows[1]}))


if __name__ == "__main__":
    main()
