"""Pages of the documentation: what they show runs."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_core.plugins import PluginTypes
from arjuna_nav.controllers.plugins import CONTROLLERS, GOAL_CHECKERS, PROGRESS_CHECKERS
from arjuna_nav.costmap.layers.plugins import LAYERS
from arjuna_nav.docking.dock_types import DOCK_TYPES
from arjuna_nav.nodes.behavior_actions import BEHAVIORS
from arjuna_nav.nodes.goals.admission import NAVIGATORS
from arjuna_nav.nodes.routes.plugins import OPERATIONS, SCORERS
from arjuna_nav.nodes.safety.sources import SOURCES
from arjuna_nav.nodes.waypoints.tasks import TASKS
from arjuna_nav.planners.base import PLANNERS
from arjuna_nav.safety.zones import ZONES
from arjuna_nav.smoothers.smoothers import SMOOTHERS
from arjuna_slam.amcl.config import MOTION_MODELS
from bringup.parameters import inputs
from bringup.parameters.checking import check_file
from bringup.parameters.files import merged
from bringup.parameters.inputs import gather
from tests.helpers.nav.plugins_page import PAGE, blocks, write_parameters

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

    few = {
        "explorer": {"exploration": {"min_frontier_size": 2.0}}
    }  # a corner that is left out costs no drive
    monkeypatch.setattr(inputs, "gather", lambda given: merged(gather(given), few))
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


LISTS = {
    "controller_plugins": CONTROLLERS,
    "goal_checker_plugins": GOAL_CHECKERS,
    "progress_checker_plugins": PROGRESS_CHECKERS,
    "planner_plugins": PLANNERS,
    "smoother_plugins": SMOOTHERS,
    "behavior_plugins": BEHAVIORS,
    "plugins": LAYERS,
    "waypoint_task_executor_plugin": TASKS,
    "edge_cost_functions": SCORERS,
    "operations": OPERATIONS,
    "navigators": NAVIGATORS,
    "dock_plugins": DOCK_TYPES,
    "robot_model_type": MOTION_MODELS,
    "polygons": ZONES,
    "observation_sources": SOURCES,
}


@pytest.mark.parametrize("name", LISTS)
def test_the_page_lists_every_class(name: str) -> None:
    types: PluginTypes = LISTS[name]
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{name}`"))
    listed = re.findall(r"`([^`]+)`", row.split("|")[2])
    assert sorted(listed) == sorted(types.types)
    assert all(types.resolve(cls) is not None for cls in listed)


@pytest.mark.parametrize("k", range(len(blocks("yaml"))))
def test_its_parameter_files_load(k: int, own_plugins: Path) -> None:
    assert check_file(write_parameters(own_plugins)[k]).refused_by(strict=True) == []
