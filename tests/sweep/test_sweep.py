# SPDX-License-Identifier: Apache-2.0
"""Sweeps as a user runs them: the numbers against sums in numpy, and nothing lost by what dies."""
import json
import os
import signal
import subprocess

import dask
import distributed
import numpy as np
import pyarrow.parquet
import pytest
from haptogram_sweep import plan, run
from haptogram_sweep.errors import FAILED
from haptogram_sweep.store import Store
from messages import program_said
from patience import until
from scipy.special import j1
from sweeping import command

K = 2 * np.pi * 40e3 / 343.2


def rows_of(path):
    return pyarrow.parquet.read_table(path).to_pylist()


def reachable_pa(side, pitch_m, points, source_pa_m=4.0, radius_m=4.5e-3):
    """Pressure amplitude of a focus at each point, by pistons in numpy alone."""
    axis = (np.arange(side) - (side - 1) / 2) * pitch_m
    elements = np.array([(x, y, 0.0) for y in axis for x in axis])
    ray = points[:, None, :] - elements[None]
    distance = np.linalg.norm(ray, axis=2)
    x = K * radius_m * np.hypot(ray[..., 0], ray[..., 1]) / distance
    return source_pa_m * (np.where(x < 1e-9, 1.0, 2 * j1(x) / np.maximum(x, 1e-9)) / distance).sum(axis=1)


def test_numbers_files_plot_and_what_fails(sweep, tmp_path):
    (tmp_path / "plan.toml").write_text("""format = "haptogram-sweep-1"
quantities = ["pressure_pa", "workspace_cm3", "peak_rms_pa", "peak_x_mm"]
[vary]
side = [4, 7]
pitch_mm = [9, 10.5]
focus_mm = [[10, 0, 100], [0, 0, -5]]
[workspace]
least_pa = 500
step_mm = 20
x_mm = [-40, 40]
y_mm = [-40, 40]
z_mm = [60, 120]
[field]
plane = "xy@z=100"
extent_mm = 20
step_mm = 2
""")
    done = sweep("plan.toml", "--workers", 2, "--page", "", "--json", expected=1)  # half of the foci lie behind the array
    said = json.loads(done.stdout)
    assert said.pop("seconds") > 0 and said == {"configurations": 8, "computed": 8, "failed": 4, "output": "plan.parquet"}
    assert "focus_mm" in done.stderr
    rows = rows_of(tmp_path / "plan.parquet")
    assert [(r["side"], r["pitch_mm"], r["focus_mm"]) for r in rows] == [
        (s, p, f) for s in (4, 7) for p in (9.0, 10.5) for f in ([10.0, 0.0, 100.0], [0.0, 0.0, -5.0])
    ]
    axis = np.arange(-0.04, 0.041, 0.02)
    grid = np.stack(np.meshgrid(axis, axis, np.arange(0.06, 0.121, 0.02), indexing="ij"), axis=-1).reshape(-1, 3)
    within = np.hypot(grid[:, 0], grid[:, 1]) <= np.tan(1.0) * grid[:, 2]  # the array's reach; its nearest distance is less than 60 mm
    for row in rows[::2]:
        side, pitch = row["side"], 1e-3 * row["pitch_mm"]
        assert row["error"] is None
        assert np.isclose(row["pressure_pa"], reachable_pa(side, pitch, np.array([[0.01, 0, 0.1]]))[0], rtol=1e-3)
        assert np.isclose(row["workspace_cm3"], 8.0 * np.count_nonzero((reachable_pa(side, pitch, grid) >= 500) & within))
        assert row["peak_rms_pa"] >= 0.999 * row["pressure_pa"] / np.sqrt(2) and abs(row["peak_x_mm"] - 10) <= 4
    assert all(r["error"] and r["pressure_pa"] is None for r in rows[1::2])


def test_paths_several_foci_and_growing_plans(sweep, tmp_path):
    (tmp_path / "ring.toml").write_text('format = "haptogram-project-1"\npoints = 4\n[[shape]]\nkind = "circle"\ndiameter_mm = 30\n')
    plan = 'format = "haptogram-sweep-1"\nquantities = ["points", "force_mn"]\n[vary]\nproject = ["ring.toml"]\narray = {}\n'
    (tmp_path / "plan.toml").write_text(plan.format('["tile-10x10"]'))
    sweep("plan.toml", "--workers", 1, "--page", "")
    (first,) = rows_of(tmp_path / "plan.parquet")
    assert first["points"] == 4 and first["force_mn"] > 0.1
    (tmp_path / "plan.toml").write_text(plan.format('["tile-7x8", "tile-10x10"]'))
    program_said(3, sweep("plan.toml", "--plot", "p.png", expected=3).stderr)
    assert json.loads(sweep("plan.toml", "--workers", 1, "--page", "", "--json").stdout)["computed"] == 1
    rows = rows_of(tmp_path / "plan.parquet")
    assert rows[1] == first and rows[0]["force_mn"] < first["force_mn"]


SLOW = """format = "haptogram-sweep-1"
quantities = ["side_lobe", "workspace_cm3"]
[vary]
side = [10]
pitch_mm = {from = 8.6, to = 12, steps = 24}
focus_mm = [[0, 0, 130]]
[workspace]
least_pa = 1500
step_mm = 8
"""


def wait_for_lines(journal, count, running):
    def there():
        assert running.poll() is None, running.communicate()
        return journal.exists() and journal.read_text().count("\n") >= count

    until(there, f"{count} lines")


@pytest.mark.deep
def test_killed_workers_and_killed_sweeps_lose_nothing(sweep, tmp_path):
    (tmp_path / "plan.toml").write_text(SLOW)
    journal, output = tmp_path / "plan.parquet.part", tmp_path / "plan.parquet"
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50) as cluster:
        arguments = command("plan.toml", "--scheduler", cluster.scheduler_address)

        def begun():
            return subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

        # The sweep itself is killed, with the line that it was about to write.
        with begun() as first:
            wait_for_lines(journal, 3, first)
            first.send_signal(signal.SIGKILL)
        kept = journal.read_text().splitlines()
        with journal.open("a", encoding="utf-8") as torn:
            torn.write('{"key": "half a li')

        # It goes on, and a worker is killed while it computes.
        workers = list(cluster.workers.values())
        with begun() as second:
            wait_for_lines(journal, len(kept) + 2, second)
            os.kill(workers[0].pid, signal.SIGKILL)
            said, warned = second.communicate(timeout=300)
            assert second.returncode == 0, said + warned
        assert "not complete" in warned
        assert f"24 configurations, {24 - len(kept)} computed now, 0 failed" in said
    assert not journal.exists()
    rows = rows_of(output)
    assert [r["pitch_mm"] for r in rows] == [round(8.6 + 3.4 * i / 23, 9) for i in range(24)]
    assert all(r["error"] is None and 0 < r["side_lobe"] < 1 and r["workspace_cm3"] > 0 for r in rows)

    # The same as from a run that nothing disturbs.
    sweep("plan.toml", "-o", "calm.parquet", "--workers", 1, "--page", "")
    assert (tmp_path / "calm.parquet").read_bytes() == output.read_bytes()


def test_what_kills_its_workers_is_a_row_and_the_others_go_on(tmp_path, monkeypatch):
    (tmp_path / "plan.toml").write_text(SLOW.replace('"side_lobe", "workspace_cm3"', '"side_lobe"').split("[workspace]")[0])
    read, store = plan.read(tmp_path / "plan.toml"), Store(tmp_path / "out.parquet")
    deadly = read.configurations[5]["pitch_mm"]

    def measured(batch, *_):
        if any(configuration["pitch_mm"] == deadly for configuration, _ in batch):
            os._exit(1)
        return [{"side_lobe": 0.5} for _ in batch]

    monkeypatch.setattr(run, "measure_batch", measured)
    monkeypatch.setattr(run, "BATCHES_A_WORKER", 3)  # so that a batch has several
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), run.local_cluster(2, None) as client:
        assert run.compute(read, store, client, lambda done, total: None) == 24
    store.finish(read)
    rows = rows_of(tmp_path / "out.parquet")
    assert [r["error"] is None for r in rows] == [r["pitch_mm"] != deadly for r in rows]
    assert "died" in rows[5]["error"] and rows[5]["side_lobe"] is None and rows[6]["side_lobe"] == 0.5


def test_messages(sweep, tmp_path):
    program_said(3, sweep("none.toml", expected=3).stderr)
    program_said(2, sweep("plan.toml", "--workers", 0, expected=2).stderr)
    (tmp_path / "plan.toml").write_text(SLOW)
    program_said(1, sweep("plan.toml", "--scheduler", "tcp://127.0.0.1:9", expected=1).stderr)
    program_said(2, sweep("plan.toml", "--plot", "x.jpg", expected=2).stderr)
    (tmp_path / "plan.parquet").write_text("no table")
    program_said(3, sweep("plan.toml", expected=3).stderr)


def test_a_full_device():
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(command("--help"), stdout=full, stderr=subprocess.PIPE, text=True, timeout=300, check=False, env={**os.environ, "PYTHONUNBUFFERED": ""})
    assert done.returncode == 3 and done.stderr == "haptogram-sweep: standard output: No space left on device; what was printed is incomplete\n"
