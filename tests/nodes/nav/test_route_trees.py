"""A behavior tree drives along a graph's route, if the battery lets it."""

from __future__ import annotations

from pathlib import Path

import pytest
from sensor_msgs.msg import BatteryState

from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import ABORTED, SUCCEEDED, PlayedRobot, started
from tests.helpers.nav.navigator_goals import TOLERANCE, go
from tests.helpers.nav.routes import written

TREE = """
<root BTCPP_format="4"><BehaviorTree ID="Route"><Sequence>
  <TransformAvailable parent="map" child="base_footprint"/>
  <Inverter><IsBatteryLow battery_topic="/battery" min_battery="0.2"/></Inverter>
  <Parallel success_count="2">
    <ComputeAndTrackRoute goal="{goal}" use_poses="true" next_node_id="{next}"/>
    <Sequence>
      <ComputeRoute goal="{goal}" use_poses="true" path="{path}" route="{route}"/>
      <GetPoseFromPath path="{path}" index="-1" pose="{end}"/>
      <FollowPath path="{path}"/>
    </Sequence>
  </Parallel>
</Sequence></BehaviorTree></root>
"""


@pytest.fixture
def robot(tmp_path: Path) -> PlayedRobot:
    (tmp_path / "route.xml").write_text(TREE, encoding="utf-8")
    tree = {"bt_folder": str(tmp_path)}
    route = {
        "graph_filepath": str(written(tmp_path)),
        "radius_to_achieve_node": 0.5,
        "edge_cost_functions": ["DistanceScorer", "CostmapScorer"],
        "operations": ["AdjustSpeedLimit", "ReroutingService", "CollisionMonitor"],
    }
    return started(*NAVIGATION_GROUP.nodes, bt_navigator=tree, route_server=route)


def test_it_drives_along_the_route_and_stays_with_an_empty_battery(robot: PlayedRobot) -> None:
    goal = go(robot, SE2(0.0, 4.1), "route.xml")
    robot.run_until_done(goal, 40.0)
    assert (goal.status, goal.result.error_msg) == (SUCCEEDED, "")
    assert robot.pose.distance(SE2(0.0, 4.0)) < TOLERANCE
    battery = robot.bench.node.create_publisher(BatteryState, "/battery", qos.DEFAULT)
    robot.run(0.2)
    battery.publish(BatteryState(percentage=0.1))
    robot.run(0.2)
    goal = go(robot, SE2(0.3, 0.1), "route.xml")
    robot.run_until_done(goal, 5.0)
    assert goal.status == ABORTED
    assert robot.pose.distance(SE2(0.0, 4.0)) < TOLERANCE
