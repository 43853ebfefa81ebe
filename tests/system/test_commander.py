"""Every method of nav2_simple_commander's BasicNavigator, served by the whole robot."""

from __future__ import annotations

import inspect
import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from geographic_msgs.msg import GeoPoint as GeoPointMsg
from geographic_msgs.msg import GeoPose
from geometry_msgs.msg import PoseStamped, Twist
from nav2_msgs.action import FollowPath, NavigateToPose
from nav2_simple_commander.robot_navigator import BasicNavigator, TaskResult
from rclpy.node import Node
from simulation_interfaces.srv import SetEntityState

from arjuna_core.files.shipped import shipped_file
from arjuna_core.geodesy import GeoPoint, MapOnEarth
from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, se2_from_pose
from arjuna_core.se2 import SE2
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.processes.lifecycle.manager import LifecycleManager, LifecycleManagerConfig
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.helpers.nav.commander import commander

pytestmark = [pytest.mark.ros, pytest.mark.system]
MAP = str(shipped_file("maps/arjuna_room.yaml"))
HERE = GeoPoint(48.1351, 11.5820)
REACHED = 0.25
PARAMETERS: dict[str, dict[str, Any]] = {
    "map_server": {"yaml_filename": MAP},
    "docking_server": {
        "docks": ["home"],
        "home.type": "simple_charging_dock",
        "home.pose": [1.0, 0.2, 0.0],
    },
    "waypoint_follower": {"gps.datum": [HERE.latitude_deg, HERE.longitude_deg, 0.0]},
}
SPOKEN = {"info", "warn", "error", "debug"}  # say something, ask nothing


def _graph() -> Iterator[dict[str, Any]]:
    """Yield the features of a graph of one edge."""
    points = [0.0, 0.0], [1.5, 1.0]
    for k, point in enumerate(points):
        geometry: dict[str, Any] = {"type": "Point", "coordinates": point}
        yield {"type": "Feature", "properties": {"id": k, "frame": "map"}, "geometry": geometry}
    geometry = {"type": "MultiLineString", "coordinates": [list(points)]}
    yield {
        "type": "Feature",
        "properties": {"id": 2, "startid": 0, "endid": 1},
        "geometry": geometry,
    }


class Bench:
    """A robot that knows the room, and a script's navigator."""

    def __init__(self, patch: pytest.MonkeyPatch, graph: Path) -> None:
        graph.write_text(json.dumps({"type": "FeatureCollection", "features": list(_graph())}))
        given = {**PARAMETERS, "route_server": {"graph_filepath": str(graph)}}
        self.robot = LockStep(merged(shipped_parameters(), given), strict=True, transport="dds")
        self.robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        self.robot.run(0.5)
        self.navigator = commander(self.robot, patch)

    def close(self) -> None:
        self.navigator.destroyNode()
        self.robot.close()

    def put_at_the_origin(self) -> None:
        """Put the robot there, and let it know."""
        request = SetEntityState.Request(entity="arjuna", set_pose=True)
        self.robot.call(SetEntityState, "set_entity_state", request)
        self.robot.run(0.5)
        self.navigator.setInitialPose(at(0.0, 0.0))
        self.navigator.waitUntilNav2Active()

    @property
    def pose(self) -> SE2:
        pose: SE2 = self.robot.sim.last.truth.pose
        return pose

    def result(self, during: Callable[[], None] = lambda: None) -> TaskResult:
        """Wait for the task's end as scripts do."""
        deadline = self.robot.now + 60.0
        while not self.navigator.isTaskComplete():
            during()
            assert self.robot.now < deadline, "the task has no end"
        return self.navigator.getResult()


@contextmanager
def opened() -> Iterator[Bench]:
    with (
        pytest.MonkeyPatch.context() as patch,
        tempfile.TemporaryDirectory() as folder,
        closing(Bench(patch, Path(folder) / "graph.geojson")) as bench,
    ):
        yield bench


@pytest.fixture(scope="module")
def shared() -> Iterator[Bench]:
    with opened() as bench:
        yield bench


@pytest.fixture
def bench(shared: Bench) -> Bench:
    shared.put_at_the_origin()
    return shared


def at(x: float, y: float, yaw: float = 0.0) -> PoseStamped:
    return pose_stamped(SE2(x, y, yaw), "map", 0.0)


def test_goals_are_reached_and_cancelled(bench: Bench) -> None:
    navigator = bench.navigator
    assert navigator.goToPose(at(0.6, 0.2))
    distances: list[float] = []
    end = bench.result(lambda: distances.append(navigator.getFeedback().distance_remaining))
    assert end is TaskResult.SUCCEEDED
    assert isinstance(navigator.getFeedback(), NavigateToPose.Feedback)
    assert distances[-1] < 0.3 < max(distances)
    assert bench.pose.distance(SE2(0.6, 0.2)) < REACHED
    assert navigator.goThroughPoses([at(0.3, 0.5), at(0.0, 0.0)])
    assert bench.result() is TaskResult.SUCCEEDED
    assert navigator.goToPose(at(1.5, 1.0))
    bench.robot.run(1.0)
    assert navigator.getResult() is TaskResult.UNKNOWN
    navigator.cancelTask()
    assert bench.result() is TaskResult.CANCELED
    assert navigator.goToPose(at(40.0, 0.0))
    assert bench.result() is TaskResult.FAILED
    code, message = navigator.getTaskError()
    assert (code, "outside the costmap" in message) == (204, True)


def test_waypoints_on_the_map_and_on_the_earth(bench: Bench) -> None:
    navigator = bench.navigator
    assert navigator.followWaypoints([at(0.5, 0.0), at(0.6, 0.4)])
    assert bench.result() is TaskResult.SUCCEEDED
    assert navigator.getFeedback().current_waypoint == 1
    point = MapOnEarth(HERE).to_earth(0.2, 0.1)
    position = GeoPointMsg(latitude=point.latitude_deg, longitude=point.longitude_deg)
    assert navigator.followGpsWaypoints([GeoPose(position=position)])
    assert bench.result() is TaskResult.SUCCEEDED
    assert bench.pose.distance(SE2(0.2, 0.1)) < REACHED


def test_behaviors_move_the_robot(bench: Bench) -> None:
    navigator, start = bench.navigator, bench.pose
    assert navigator.spin(spin_dist=0.8, time_allowance=10)
    assert bench.result() is TaskResult.SUCCEEDED
    assert bench.pose.theta - start.theta == pytest.approx(0.8, abs=0.15)
    before = bench.pose
    assert navigator.backup(backup_dist=0.15, backup_speed=0.1)
    assert bench.result() is TaskResult.SUCCEEDED
    assert (before.inverse() @ bench.pose).x == pytest.approx(-0.15, abs=0.06)
    assert navigator.driveOnHeading(dist=0.2, speed=0.1)
    assert bench.result() is TaskResult.SUCCEEDED
    before = bench.pose
    teleop = bench.robot.client.create_publisher(Twist, "cmd_vel_teleop", qos.LATEST)
    assert navigator.assistedTeleop(time_allowance=2)
    forward = Twist()
    forward.linear.x = 0.1
    bench.result(lambda: teleop.publish(forward))
    assert (before.inverse() @ bench.pose).x > 0.08


def test_the_robot_docks_and_undocks(bench: Bench) -> None:
    navigator = bench.navigator
    assert navigator.dockRobotByID("home")
    assert bench.result() is TaskResult.SUCCEEDED, navigator.getTaskError()
    assert bench.pose.distance(SE2(1.0, 0.2)) < 0.1  # by localization alone
    assert navigator.undockRobot()
    assert bench.result() is TaskResult.SUCCEEDED
    assert bench.pose.distance(SE2(0.3, 0.2)) < 0.1
    near = at(0.9, 0.2)
    assert navigator.dockRobotByPose(near, "simple_non_charging_dock", nav_to_dock=False)
    assert bench.result() is TaskResult.SUCCEEDED
    assert bench.pose.distance(SE2(0.9, 0.2)) < 0.1
    assert navigator.undockRobot("simple_non_charging_dock")
    assert bench.result() is TaskResult.SUCCEEDED


def test_paths_are_planned_smoothed_and_followed(bench: Bench) -> None:
    navigator = bench.navigator
    path = navigator.getPath(at(0.0, 0.0), at(1.0, 0.5), use_start=True)
    assert se2_from_pose(path.poses[-1].pose).distance(SE2(1.0, 0.5)) < 0.1
    assert navigator.getPath(at(0.0, 0.0), at(40.0, 0.0)) is None
    via = navigator.getPathThroughPoses(at(0.0, 0.0), [at(0.6, 0.0), at(0.6, 0.5)])
    assert len(via.poses) > 10
    smooth = navigator.smoothPath(path)
    assert len(smooth.poses) == len(path.poses)
    assert navigator.followPath(smooth)
    assert bench.result() is TaskResult.SUCCEEDED
    assert isinstance(navigator.getFeedback(), FollowPath.Feedback)
    assert bench.pose.distance(SE2(1.0, 0.5)) < REACHED


def test_a_route_is_tracked_while_its_path_is_followed(bench: Bench) -> None:
    navigator = bench.navigator
    bench.robot.run(1.5)  # until then AMCL's last transforms, dated ahead, say where it was
    found = navigator.getRoute(at(0.0, 0.0), at(1.5, 1.0), use_start=True)
    assert found is not None
    assert [node.nodeid for node in found[1].nodes] == [0, 1]
    tracking, ends = navigator.getAndTrackRoute(0, 1), bench.robot.now + 60.0
    followed = 0
    while not navigator.isTaskComplete(task=tracking):
        while (feedback := navigator.getFeedback(task=tracking)) is not None:
            if feedback.rerouted:
                followed += navigator.followPath(feedback.path)
        assert bench.robot.now < ends, "the route has no end"
    assert followed == 1
    assert bench.result() is TaskResult.SUCCEEDED
    assert bench.pose.distance(SE2(1.5, 1.0)) < REACHED


def test_maps_and_costmaps(bench: Bench) -> None:
    navigator = bench.navigator
    for costmap in (navigator.getGlobalCostmap(), navigator.getLocalCostmap()):
        assert len(costmap.data) == costmap.metadata.size_x * costmap.metadata.size_y > 0
    navigator.clearAllCostmaps()
    navigator.clearLocalCostmap()
    navigator.clearGlobalCostmap()
    navigator.clearCostmapExceptRegion(1.0)
    navigator.clearCostmapAroundRobot(1.0)
    navigator.clearLocalCostmapAroundPose(at(0.2, 0.0), 0.5)
    navigator.clearGlobalCostmapAroundPose(at(0.2, 0.0), 0.5)
    assert navigator.changeMap(MAP)
    assert not navigator.changeMap("/nowhere/map.yaml")


def test_the_lifecycle_is_commanded() -> None:
    """Of a robot of its own, whose nodes are no more at the end."""
    with opened() as bench:
        bench.put_at_the_origin()
        robot = bench.robot
        robot.stop(NAVIGATION_GROUP)
        nodes = [spec.name for spec in NAVIGATION_GROUP.nodes]
        config = LifecycleManagerConfig(autostart=False)
        LifecycleManager(robot.process, NAVIGATION_GROUP.manager, nodes, config)
        bench.navigator.lifecycleStartup()
        assert {robot.nodes[name].state_label for name in nodes} == {"active"}
        assert bench.navigator.goToPose(at(0.3, 0.0))
        assert bench.result() is TaskResult.SUCCEEDED
        bench.navigator.lifecycleShutdown()
        assert {robot.nodes[name].state_label for name in nodes} == {"finalized"}


def test_no_method_is_left_out() -> None:
    """Nothing of what a script may call is untested: each name is called above."""
    methods = {
        method.__name__  # of one that has two, the first
        for name, method in inspect.getmembers(BasicNavigator, inspect.isfunction)
        if not name.startswith("_") and not hasattr(Node, name)
    }
    text = Path(__file__).read_text(encoding="utf-8")
    assert {name for name in methods - SPOKEN if f"navigator.{name}(" not in text} == set()
