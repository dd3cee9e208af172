# SPDX-License-Identifier: Apache-2.0
"""Runs the notebooks of docs/notebooks, each in a folder of its own, with the program and the packages of a build, and makes pages of them."""
import base64
import json
import os
import sys
import tempfile
from pathlib import Path
from unittest import mock

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs/notebooks"
PACKAGES = f"{ROOT}/python:{ROOT}/extras/sweep"


def commands(folder: Path, program: Path) -> None:
    """What `pip install haptogram` puts beside each other."""
    (folder / "haptogram").symlink_to(program)
    (folder / "haptogram-sweep").write_text(f"#!/bin/sh\nexec {sys.executable} -m haptogram_sweep \"$@\"\n", encoding="utf-8")
    (folder / "haptogram-sweep").chmod(0o755)


def kernel(folder: Path) -> None:
    """Jupyter's description of this Python, whichever others it knows."""
    folder.mkdir(parents=True)
    command = [sys.executable, "-Xfrozen_modules=off", "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (folder / "kernel.json").write_text(json.dumps({"argv": command, "display_name": "Haptogram", "language": "python"}), encoding="utf-8")


def run(notebook: Path, program: Path, library: Path) -> nbformat.NotebookNode:
    """The notebook with its outputs; raises CellExecutionError with what a cell printed when it failed."""
    with tempfile.TemporaryDirectory() as place:
        bin_, work = Path(place, "bin"), Path(place, "work")
        bin_.mkdir()
        work.mkdir()
        commands(bin_, program)
        kernel(Path(place, "kernels/haptogram"))
        environment = {"PATH": f"{bin_}:{os.environ['PATH']}", "PYTHONPATH": PACKAGES, "HAPTOGRAM_LIBRARY": str(library), "JUPYTER_PATH": place}
        client = NotebookClient(nbformat.read(notebook, as_version=4), timeout=120, kernel_name="haptogram", resources={"metadata": {"path": str(work)}})
        with mock.patch.dict(os.environ, environment):
            return client.execute()


def all_notebooks() -> list[Path]:
    return sorted(FOLDER.glob("*.ipynb"))


def _outputs(cell: nbformat.NotebookNode, name: str, pictures: dict[str, bytes]) -> str:
    """What a cell printed, as one block of text, and after it what it drew."""
    text, drawn = "", ""
    for output in cell.outputs:
        data = output.get("data", {})
        if "image/png" in data:
            picture = f"{name}-{len(pictures) + 1}.png"
            pictures[picture] = base64.b64decode(data["image/png"])
            drawn += f"![what the cell draws]({picture})\n\n"
        else:
            text += output.get("text") or data["text/plain"] + "\n"
    return (f"```text\n{text.rstrip()}\n```\n\n" if text else "") + drawn


def page(notebook: nbformat.NotebookNode, name: str) -> tuple[str, dict[str, bytes]]:
    """A notebook that was run as Markdown, and its pictures by the names of their files beside it."""
    pictures: dict[str, bytes] = {}
    text = ""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            text += cell.source + "\n\n"
            continue
        language, source = ("sh", cell.source.removeprefix("%%sh\n")) if cell.source.startswith("%%sh") else ("python", cell.source)
        text += f"```{language}\n{source}\n```\n\n{_outputs(cell, name, pictures)}"
    return text + f"This page is [a notebook]({name}.ipynb), run as the site was built.\n", pictures
