# SPDX-License-Identifier: Apache-2.0
"""The configurations that are not done yet, computed by the workers of a Dask cluster.

What dies with a worker is computed again by others, which Dask sees to; what came back from it is in the journal. A configuration
that ends every worker that computes it becomes a row with an error, and the others go on."""

import contextlib
import logging
from collections.abc import Callable, Iterator
from typing import Any

import dask
import distributed

from .errors import FAILED, SweepError
from .measure import measure_batch
from .plan import Configuration, Plan, library_digest
from .store import Row, Store

LARGEST_BATCH = 16  # configurations that one message carries
BATCHES_A_WORKER = 16  # at least so many, so that all workers end at about the same time
WAIT_S = 60.0  # for the first worker of a scheduler


@contextlib.contextmanager
def local_cluster(workers: int, page: str | None) -> Iterator[distributed.Client]:
    """Workers of one thread each on this machine. `page` is where Dask shows its progress, such as "127.0.0.1:8787"."""
    options: dict[str, Any] = {"n_workers": workers, "threads_per_worker": 1, "processes": True, "host": "127.0.0.1"}
    # A worker has no task but the one that it computes, so what is computed when it dies is known.
    with (
        dask.config.set({"distributed.scheduler.worker-saturation": 1.0}),
        distributed.LocalCluster(**options, dashboard_address=page, silence_logs=logging.CRITICAL) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextlib.contextmanager
def connected(address: str) -> Iterator[distributed.Client]:
    """A cluster that is there already.
    @raises SweepError when it does not answer, or has no workers"""
    try:
        client = distributed.Client(address, timeout=10)
    except (OSError, ValueError, TimeoutError) as error:
        raise SweepError(FAILED, "--scheduler", f"{address} does not answer: {error}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WAIT_S)
        except TimeoutError:
            raise SweepError(FAILED, "--scheduler", f"{address} has had no workers for {WAIT_S:.0f} s; start some: dask worker {address}") from None
        yield client


def compute(plan: Plan, store: Store, client: distributed.Client, told: Callable[[int, int], None]) -> int:
    """Adds all of the plan's rows that the store lacks. Returns how many these are.
    @param told  is called with how many are done, and of how many"""
    missing = {plan.key_of(c): c for c in plan.configurations}
    total = len(missing)
    for key in [key for key in missing if key in store.rows and "error" not in store.rows[key]]:
        del missing[key]
    count, workers = len(missing), max(1, sum(client.ncores().values()))
    told(total - count, total)
    size = max(1, min(LARGEST_BATCH, count // (BATCHES_A_WORKER * workers)))
    keys = list(missing)
    library, done = library_digest(), total - count

    def submit(batch: list[str]) -> Any:
        work: list[tuple[Configuration, Any]] = [(missing[key], plan.files_of(missing[key])) for key in batch]
        return client.submit(measure_batch, work, plan.quantities, plan.tables, library, pure=False)

    batches = {submit(keys[i : i + size]): keys[i : i + size] for i in range(0, count, size)}
    waiting = distributed.as_completed(list(batches))
    for future in waiting:
        batch = batches.pop(future)
        try:
            found = future.result()
        except distributed.KilledWorker:
            if len(batch) > 1:  # one of them does it: each alone
                for key in batch:
                    again = submit([key])
                    batches[again] = [key]
                    waiting.add(again)
                continue
            found = ["the workers that computed it died, one after the other"]
        except Exception as error:  # what no configuration is to blame for, such as a worker without the package
            raise SweepError(FAILED, "a worker", f"{type(error).__name__}: {error}") from error
        rows: dict[str, Row] = {key: {"error": row} if isinstance(row, str) else row for key, row in zip(batch, found)}
        store.add(rows)
        done += len(rows)
        told(done, total)
    return count
