"""The notebook of the guide runs from its first cell to its last, and is stored without outputs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
NOTEBOOK = Path(__file__).resolve().parents[3] / "docs" / "guide" / "clangor.ipynb"
SECONDS = 600
RUN = """
import sys
import nbclient, nbformat
source, folder, output, seconds = sys.argv[1:]
book = nbformat.read(source, as_version=4)
resources = {"metadata": {"path": folder}}
nbclient.NotebookClient(book, timeout=int(seconds), resources=resources).execute()
nbformat.write(book, output)
"""


def test_it_is_stored_without_outputs() -> None:
    book = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(book)
    code = [cell for cell in book.cells if cell.cell_type == "code"]
    assert code and not any(cell.outputs or cell.execution_count for cell in code)


def test_it_runs(tmp_path_factory: pytest.TempPathFactory, tmp_path: Path) -> None:
    for partner in ("nbclient", "ipykernel", "matplotlib"):
        pytest.importorskip(partner)
    cache = tmp_path_factory.getbasetemp() / "cache"
    cache.mkdir(exist_ok=True)
    output = tmp_path / "run.ipynb"
    # In a process of its own: the event loops of other tests keep the client from closing its sockets.
    subprocess.run(
        [sys.executable, "-c", RUN, str(NOTEBOOK), str(NOTEBOOK.parent), str(output), str(SECONDS)],
        env={**os.environ, "CLANGOR_CACHE": str(cache)},
        timeout=SECONDS,
        check=True,
    )
    book = nbformat.read(output, as_version=4)
    outputs = [output.get("data", {}) for cell in book.cells for output in cell.get("outputs", [])]
    # Impacts, the sound of the scene, modes, three places and the data set; all but two can be heard.
    assert sum("image/png" in data for data in outputs) == 7
    assert sum("<audio" in data.get("text/html", "") for data in outputs) == 5
