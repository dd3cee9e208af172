# SPDX-License-Identifier: Apache-2.0
"""haptogram-sweep: a plan in, one Parquet file of results out."""

import argparse
import json
import os
import pathlib
import sys
import time
from typing import NoReturn

from haptogram.program import exit_code_of

from . import plan as plans
from . import plot
from .errors import FAILED, USAGE, SweepError
from .run import compute, connected, local_cluster
from .store import Store

PAGE = "127.0.0.1:8787"


class Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        print(f"haptogram-sweep: {message}; see haptogram-sweep --help", file=sys.stderr)
        sys.exit(USAGE)


def _at_least_one(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected 1 or more, found {value}")
    return value


def _parser() -> Parser:
    parser = Parser(prog="haptogram-sweep", description="Computes every configuration of a plan, and writes a row for each.")
    parser.add_argument("plan", type=pathlib.Path, help="what varies, and which quantities are wanted (TOML; see the README)")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="results, Parquet; by default the plan's name with .parquet. Rows that it has already are kept")
    parser.add_argument("--workers", type=_at_least_one, default=os.cpu_count(), help="processes on this machine (%(default)s)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler instead, such as tcp://10.0.0.5:8786")
    parser.add_argument("--page", metavar="HOST:PORT", default=PAGE, help="where Dask shows what its workers do, if bokeh is installed (%(default)s); '' for nowhere")
    parser.add_argument("--plot", type=pathlib.Path, help="draw the quantities, too: a .png, .pdf or .svg file")
    parser.add_argument("--json", action="store_true", help="say at the end what was done as JSON")
    return parser


class Teller:
    """How far the work is: one line on a terminal, and nothing elsewhere."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()

    def __call__(self, done: int, total: int) -> None:
        if self._terminal:
            print(f"\r\033[Ksweep {done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)


def run(options: argparse.Namespace) -> int:
    plan = plans.read(options.plan)
    output = options.output or options.plan.with_suffix(".parquet")
    if options.plot:
        if options.plot.suffix not in (".png", ".pdf", ".svg"):
            raise SweepError(USAGE, "--plot", f"'{options.plot.suffix}' is no ending that is known; .png, .pdf and .svg are")
        plot.check(plan)
    store = Store(output)
    if store.torn:
        print(f"haptogram-sweep: {store.journal}: its last line was not complete; its row is computed again", file=sys.stderr)
    try:
        cluster = connected(options.scheduler) if options.scheduler else local_cluster(options.workers, options.page or None)
        with cluster as client:
            if client.dashboard_link and options.page and sys.stderr.isatty():
                print(f"progress: {client.dashboard_link}", file=sys.stderr)
            begun = time.monotonic()
            computed = compute(plan, store, client, Teller())
            seconds = time.monotonic() - begun
    except BaseException:
        store.close()
        raise
    store.finish(plan)
    rows = [store.rows[plan.key_of(c)] for c in plan.configurations]
    failed = [(c, row["error"]) for c, row in zip(plan.configurations, rows) if "error" in row]
    if options.plot:
        plot.draw(plan, store.rows, options.plot)
    if options.json:
        print(json.dumps({"configurations": len(rows), "computed": computed, "failed": len(failed), "seconds": round(seconds, 3), "output": str(output)}))
    else:
        print(f"{len(rows)} configurations, {computed} computed now, {len(failed)} failed: {output}")
    for configuration, why in failed[:5]:
        print(f"haptogram-sweep: {json.dumps(configuration)}: {why}", file=sys.stderr)
    if len(failed) > 5:
        print(f"haptogram-sweep: and {len(failed) - 5} more; the column 'error' has all", file=sys.stderr)
    return FAILED if failed else 0


def main(arguments: list[str] | None = None) -> int:
    def work() -> int:
        try:
            return run(_parser().parse_args(arguments))
        except SweepError as error:
            print(f"haptogram-sweep: {error}", file=sys.stderr)
            return error.code
        except KeyboardInterrupt:
            print("haptogram-sweep: ended; what is done is kept, and the same command goes on from there", file=sys.stderr)
            return FAILED

    return exit_code_of("haptogram-sweep", work)
