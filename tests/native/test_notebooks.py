# SPDX-License-Identifier: Apache-2.0
"""The notebooks of docs/notebooks: each runs from its first cell to its last, and is kept without what it printed."""
import json
import sys
from pathlib import Path

import nbclient
import nbformat
import pytest
from pistons import LIBRARY, PROGRAM, ROOT

sys.path.insert(0, str(ROOT / "tools/docs"))
import notebooks  # noqa: E402

LONG = "sweep"  # starts a cluster


def test_there_are_six():
    assert len(notebooks.all_notebooks()) == 6


@pytest.mark.parametrize("path", [pytest.param(path, marks=pytest.mark.deep) if path.stem == LONG else path for path in notebooks.all_notebooks()], ids=lambda path: path.stem)
def test_a_notebook_runs_and_every_picture_is_drawn(path):
    ran = notebooks.run(path, PROGRAM, LIBRARY)
    code = [cell for cell in ran.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert not any("!haptogram" in cell.source for cell in code)  # of which Jupyter does not say that it failed; %%sh does
    for cell in code:
        drawn = any("image/png" in output.get("data", {}) for output in cell.outputs)
        assert drawn == ("plot(" in cell.source or "compare(" in cell.source), cell.source


@pytest.mark.parametrize("path", notebooks.all_notebooks(), ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path):
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        assert cell["cell_type"] == "markdown" or (cell["outputs"], cell["execution_count"]) == ([], None), cell["source"]


def test_a_cell_that_fails_is_an_error(tmp_path):
    made = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("1 / 0")])
    nbformat.write(made, tmp_path / "made.ipynb")
    with pytest.raises(nbclient.exceptions.CellExecutionError, match="ZeroDivisionError"):
        notebooks.run(tmp_path / "made.ipynb", PROGRAM, LIBRARY)
