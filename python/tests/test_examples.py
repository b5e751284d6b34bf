"""Every example runs to its end, the notebook too."""

import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize("script", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_a_script_runs(script: str, tmp_path) -> None:
    arguments = [str(tmp_path / "figure.png")] if script == "stability_region.py" else []
    subprocess.run(
        [sys.executable, EXAMPLES / script, *arguments],
        check=True,
        cwd=tmp_path,
        timeout=600,
        env={**os.environ, "MPLBACKEND": "Agg", "TMPDIR": str(tmp_path)},
    )
    assert not arguments or Path(arguments[0]).stat().st_size > 10_000


def executed(notebook: nbformat.NotebookNode, folder: str) -> nbformat.NotebookNode:
    return NotebookClient(notebook, timeout=600, resources={"metadata": {"path": folder}}).execute()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_notebook_runs(tmp_path) -> None:
    notebook = nbformat.read(EXAMPLES / "tour.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "commit it without its outputs"
    # The client takes the handler of SIGTERM away when it is done, and a process in which that was done drives no device.
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as alone:
        notebook = alone.submit(executed, notebook, str(tmp_path)).result()
    pictures = [
        output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})
    ]
    assert len(pictures) == 3
