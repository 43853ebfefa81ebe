"""docs/plugins.md: its classes are those there are, its files and its planner load."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from arjuna_core.plugins import PluginTypes
from arjuna_nav.controllers.plugins import CONTROLLERS, GOAL_CHECKERS, PROGRESS_CHECKERS
from arjuna_nav.costmap.layers.plugins import LAYERS
from arjuna_nav.nodes.behavior_actions import BEHAVIORS
from arjuna_nav.nodes.safety.sources import SOURCES
from arjuna_nav.nodes.waypoints.tasks import TASKS
from arjuna_nav.planners.base import PLANNERS
from arjuna_nav.safety.zones import ZONES
from arjuna_nav.smoothers.base import SMOOTHERS
from bringup.parameters.checking import check_file

PAGE = (Path(__file__).parents[3] / "docs" / "plugins.md").read_text(encoding="utf-8")
LISTS = {
    "controller_plugins": CONTROLLERS,
    "goal_checker_plugins": GOAL_CHECKERS,
    "progress_checker_plugins": PROGRESS_CHECKERS,
    "planner_plugins": PLANNERS,
    "smoother_plugins": SMOOTHERS,
    "behavior_plugins": BEHAVIORS,
    "plugins": LAYERS,
    "waypoint_task_executor_plugin": TASKS,
    "polygons": ZONES,
    "observation_sources": SOURCES,
}


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("name", LISTS)
def test_the_page_lists_every_class(name: str) -> None:
    types: PluginTypes = LISTS[name]
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{name}`"))
    listed = re.findall(r"`([^`]+)`", row.split("|")[2])
    assert sorted(listed) == sorted(types.types)
    assert all(types.resolve(cls) is not None for cls in listed)


def test_its_files_load_and_its_planner_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in zip(("my_planners", "my_layers"), blocks("python"), strict=True):
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    for k, text in enumerate(blocks("yaml")):
        path = tmp_path / f"{k}.yaml"
        path.write_text(text, encoding="utf-8")
        assert check_file(path).refused_by(strict=True) == []
    sys.modules.pop("my_planners")
    sys.modules.pop("my_layers")
