# SPDX-License-Identifier: Apache-2.0
"""What is done: a journal beside the results while a sweep runs, to which each row is added as it comes, and one Parquet file at
its end. Rows have a key, so a sweep that is begun again, or whose plan has grown, computes only what is not there."""

import json
import os
import pathlib
from typing import Any

import pyarrow
import pyarrow.parquet

from .errors import SweepError, bad_input
from .plan import Plan

Row = dict[str, Any]  # the quantities; or only "error", the reason why there are none


class Store:
    """Opens the results of an earlier run, if there are any, and its journal."""

    def __init__(self, output: pathlib.Path):
        self.output = output
        self.journal = output.with_name(output.name + ".part")
        self.rows: dict[str, Row] = {}
        self.torn = 0
        if output.exists():
            self.rows.update(_read_parquet(output))
        if self.journal.exists():
            self._read_journal()
        try:
            self._file = self.journal.open("a", encoding="utf-8")
        except OSError as error:
            raise bad_input(str(self.journal), f"cannot be written: {error.strerror}") from None

    def _read_journal(self) -> None:
        """A run that was killed may have left half a line at the end, whose row is computed again."""
        content = self.journal.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        for number, line in enumerate(whole.decode("utf-8").splitlines(), 1):
            try:
                entry = json.loads(line)
                self.rows[entry["key"]] = entry["row"]
            except (ValueError, KeyError, TypeError):
                raise bad_input(f"{self.journal}:{number}", "is no row of a sweep; remove the file to begin anew") from None
        if len(whole) < len(content):
            self.torn = 1
            self.journal.write_bytes(whole)

    def add(self, rows: dict[str, Row]) -> None:
        for key, row in rows.items():
            self._file.write(json.dumps({"key": key, "row": row}) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self.rows.update(rows)

    def finish(self, plan: Plan) -> None:
        """Writes the plan's rows, in its order, and removes the journal."""
        keys = [plan.key_of(configuration) for configuration in plan.configurations]
        columns: dict[str, Any] = {}
        for name in plan.configurations[0]:
            values = [configuration[name] for configuration in plan.configurations]
            columns[name] = pyarrow.array(values, _type_of(values))
        for name in plan.quantities:
            columns[name] = pyarrow.array([self.rows[key].get(name) for key in keys], pyarrow.float64())
        columns["error"] = pyarrow.array([self.rows[key].get("error") for key in keys], pyarrow.string())
        columns["key"] = pyarrow.array(keys, pyarrow.string())
        table = pyarrow.table(columns).replace_schema_metadata({"haptogram-sweep": json.dumps({"quantities": plan.quantities, "varied": plan.varied})})
        beside = self.output.with_name(f".{self.output.name}.new")
        pyarrow.parquet.write_table(table, beside)
        os.replace(beside, self.output)
        self._file.close()
        self.journal.unlink()

    def close(self) -> None:
        """Ends before all is done. What is done stays in the journal."""
        self._file.close()
        if self.journal.stat().st_size == 0:
            self.journal.unlink()


def _type_of(values: list[Any]) -> Any:
    """Numbers of a column are all of one type, also if some were written without a point; so are points."""
    if all(isinstance(v, int) for v in values):
        return pyarrow.int64()
    if isinstance(values[0], list):
        point = pyarrow.list_(pyarrow.float64())
        return pyarrow.list_(point) if isinstance(values[0][0], list) else point
    return pyarrow.string() if isinstance(values[0], str) else pyarrow.float64()


def _read_parquet(path: pathlib.Path) -> dict[str, Row]:
    try:
        table = pyarrow.parquet.read_table(path)
        quantities = json.loads(table.schema.metadata[b"haptogram-sweep"])["quantities"]
    except (OSError, pyarrow.ArrowInvalid, KeyError, TypeError, ValueError):
        raise SweepError(3, str(path), "is there already, and is no result of a sweep; choose another output") from None
    return {
        row["key"]: {"error": row["error"]} if row["error"] is not None else {name: row[name] for name in quantities} for row in table.to_pylist()
    }
