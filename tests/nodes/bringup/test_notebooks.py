"""The notebooks of docs/notebooks, executed cell by cell: they end as their text says."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.files.shipped import shipped_file

FOLDER = shipped_file("docs/notebooks")
Names = dict[str, Any]
CLAIMS: dict[str, tuple[int, Callable[[Names], bool]]] = {
    "1-arjuna": (
        5,
        lambda n: n["explored"] and len(n["ends"]) == 3 and all(e.succeeded for e in n["ends"]),
    ),
    "2-fusion": (
        2,
        lambda n: (
            n["gaps"][0] > 0.1 > 0.01 > n["gaps"][1] and n["off"][1] > 0.1 > 0.01 > n["off"][0]
        ),
    ),
    "3-ros2": (
        2,
        lambda n: 0.2 < n["stopped_at"][0] < 0.6 and abs(n["rates"]["odom"] - 50.0) < 1.0,
    ),
    "4-turtlebot3": (
        2,
        lambda n: (
            all(e.succeeded for e in n["ends"])
            and n["errors"][1] < 0.05 < n["errors"][0]
            and max(n["final"].values()) < 0.03
        ),
    ),
    "5-where-am-i": (
        4,
        lambda n: (
            n["right"] < 0.1 < 0.3 < n["wrong"]
            and n["end"].succeeded
            and "aborted" in n["refused"].reason
        ),
    ),
}
"""For each the least number of pictures, and what must hold of its names at its end."""


def cells(name: str) -> list[dict[str, Any]]:
    document = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = document["cells"]
    return found


def run_cell(source: str, names: Names) -> Any:
    """Run a cell; return the value of its last line, if that is an expression, as a notebook."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is None:
        return None
    assert isinstance(last, ast.Expr)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def test_every_notebook_is_claimed_and_stands_on_the_page() -> None:
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == set(CLAIMS)
    page = shipped_file("docs/python.md").read_text(encoding="utf-8")
    assert all(f"(notebooks/{name}.ipynb)" in page for name in CLAIMS)


@pytest.mark.parametrize("name", CLAIMS)
def test_it_keeps_no_output(name: str) -> None:
    code = [cell for cell in cells(name) if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] or cell["execution_count"] for cell in code)


@pytest.mark.parametrize("name", CLAIMS)
def test_it_runs_and_ends_as_it_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    names: Names = {}
    pictures = 0
    shown: list[bool] = []
    monkeypatch.setattr(plt, "show", lambda: shown.append(bool(plt.get_fignums())))
    try:
        for cell in cells(name):
            if cell["cell_type"] == "code":
                value = run_cell("".join(cell["source"]), names)
                if hasattr(value, "_repr_png_"):
                    pictures += value._repr_png_().startswith(b"\x89PNG")
    finally:
        plt.close("all")
        if "robot" in names:
            names["robot"].close()
    least, holds = CLAIMS[name]
    assert pictures + sum(shown) >= least
    assert holds(names), {
        key: names.get(key) for key in ("gaps", "final", "errors", "right", "wrong")
    }


@pytest.mark.parametrize("name", CLAIMS)
def test_jupyter_itself_runs_it(name: str, tmp_path: Path) -> None:
    reason = "no Jupyter here"
    nbclient = pytest.importorskip("nbclient", reason=reason)
    nbformat = pytest.importorskip("nbformat", reason=reason)
    pytest.importorskip("ipykernel", reason=reason)
    book = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", ())]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= CLAIMS[name][0]
