"""docs/plugins.md: its classes are those there are, and its parameter files load."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

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
from bringup.parameters.checking import check_file
from tests.helpers.nav.plugins_page import PAGE, blocks, write_parameters

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
