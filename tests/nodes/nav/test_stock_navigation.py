"""Stock parameter files drive: a goal is reached with Jazzy's and with TurtleBot3's of Humble."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.se2 import SE2
from bringup.parameters.files import load_parameters, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.stack import NAVIGATION_GROUP, all_nodes
from tests.helpers.nav.navigation import SUCCEEDED, PlayedRobot
from tests.helpers.nav.navigator_goals import go
from tests.helpers.nav.stock_files import FILES


@pytest.mark.parametrize("name", ["Jazzy's nav2_params", "TurtleBot3 on Humble"])
def test_a_goal_is_reached(name: str, tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(FILES[name], encoding="utf-8")
    given = load_parameters([path])
    parameters = understand(given, shipped_parameters(), all_nodes()).parameters
    robot = PlayedRobot(parameters, shipped=False)
    robot.bring_up(*NAVIGATION_GROUP.nodes)
    robot.send_map()
    robot.run(1.0)
    goal = go(robot, SE2(1.5, 1.5, 0.5))
    robot.run_until_done(goal, 30.0)
    assert goal.status == SUCCEEDED, goal.result.error_msg
    assert robot.pose.distance(SE2(1.5, 1.5)) < 0.25
