"""Claims: nothing that a plain client once ended or blocked a robot with does so any more."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav2_msgs.action import FollowPath, SmoothPath
from nav2_msgs.srv import IsPathValid, LoadMap, SaveMap
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from simulation_interfaces.srv import GetEntities, LoadWorld, SpawnEntity

from arjuna_core.ros import qos
from arjuna_core.ros.health import rules
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SLAM_GROUP
from tests.helpers.robots import ON_MAP, Stack, outcome
from tests.helpers.ros import changed

pytestmark = [pytest.mark.ros, pytest.mark.system]
NO_NUMBERS = (math.nan, math.inf, 1e300)
NO_NAMES = ("x" * 300, "//[", "http://[", "../" * 50, "\u202e\U0001f4a5" * 200, "/dev/zero")
LONGEST = 2.0
"""How much of a core's time what follows a message may take [s]."""
TRANSITIONS = (0, 1, 2, 9, 42, 255)
PATH_TOO_LONG = Path(poses=[PoseStamped()] * (rules.POSES + 1))


class Client:
    """Sends what no robot can use, and sees to it that the robot takes no harm."""

    def __init__(self, robot: LockStep) -> None:
        self.robot = robot
        self._publishers: dict[str, Any] = {}

    def publish(self, topic: str, message: Any, profile: Any = qos.DEFAULT) -> None:
        if topic not in self._publishers:
            made = self.robot.client.create_publisher(type(message), topic, profile)
            self._publishers[topic] = made
            self.robot.step()
        self._publishers[topic].publish(message)
        self._step()

    def _step(self) -> None:
        start = time.process_time()
        self.robot.step()
        assert time.process_time() - start < LONGEST

    def call(self, kind: Any, name: str, request: Any) -> Any:
        start = time.process_time()
        answer = self.robot.call(kind, name, request)
        assert time.process_time() - start < LONGEST
        return answer

    def mend(self) -> None:
        """Go away, with what was latched."""
        for publisher in self._publishers.values():
            self.robot.client.destroy_publisher(publisher)


def transitions(client: Client) -> None:
    for name in client.robot.nodes:
        for number in TRANSITIONS:
            request = ChangeState.Request()
            request.transition.id = number
            answer = client.call(ChangeState, f"/{name}/change_state", request)
            assert answer.success is (number == Transition.TRANSITION_CONFIGURE)  # nothing to do


def sensors(client: Client) -> None:
    for value in NO_NUMBERS:
        client.publish("/imu/data", changed(Imu(), "angular_velocity.z", value))
        client.publish("/imu/data", changed(Imu(), "linear_acceleration.x", value))
        for path in ("pose.pose.position.x", "twist.twist.linear.x", "twist.twist.angular.z"):
            client.publish("/wheel_odom", changed(Odometry(), path, value))
            client.publish("/odom", changed(Odometry(), path, value))


def clock(client: Client) -> None:
    client.publish("/clock", Clock(clock=Time(sec=-1)), qos.LATEST)
    client.publish("/clock", Clock(clock=Time(sec=1, nanosec=2**32 - 1)), qos.LATEST)


def initial_poses(client: Client) -> None:
    for value in (1e300, math.nan, -1.0):
        message = PoseWithCovarianceStamped()
        message.header.frame_id = "map"
        message.pose.covariance[0] = value
        client.publish("/initialpose", message)


def paths(client: Client) -> None:
    far = Path(poses=[PoseStamped(), changed(PoseStamped(), "pose.position.x", 1e300)])
    for path in (far, PATH_TOO_LONG):
        for action, name in ((FollowPath, "follow_path"), (SmoothPath, "smooth_path")):
            result = outcome(client.robot, action, name, action.Goal(path=path)).result
            assert result.error_code == action.Result.INVALID_PATH
        request = IsPathValid.Request(path=path)
        assert not client.call(IsPathValid, "/is_path_valid", request).is_valid


def maps(client: Client) -> None:
    for resolution in (0.0, 1e-9, 1e-6, 1e-3, math.nan, 1e30):
        client.publish("/map", grid(resolution), qos.LATCHED)
    for origin in (1e300, math.nan):
        far = changed(grid(0.05), "info.origin.position.x", origin)
        client.publish("/map", far, qos.LATCHED)
    client.publish("/map", grid(0.05, 10_000, cells=1), qos.LATCHED)


def grid(resolution: float, size: int = 20, cells: int = 400) -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id = "map"
    message.info.resolution = resolution
    message.info.width = message.info.height = size
    message.data = [0] * cells
    return message


def names(client: Client) -> None:
    for name in NO_NAMES:
        for kind in (LoadMap, SaveMap):
            verb = "load_map" if kind is LoadMap else "save_map"
            server = "map_server" if kind is LoadMap else "map_saver"
            if server in client.robot.nodes:
                request = kind.Request(map_url=name)
                assert client.call(kind, f"/{server}/{verb}", request).result in (
                    False,
                    1,
                    2,
                    3,
                    255,
                )
        spawn = SpawnEntity.Request(name=name)
        spawn.entity_resource.uri = name
        assert client.call(SpawnEntity, "/spawn_entity", spawn).result.result != 1
        world = LoadWorld.Request()
        world.world_resource.uri = name
        assert client.call(LoadWorld, "/load_world", world).result.result != 1


def expressions(client: Client) -> None:
    spawn = SpawnEntity.Request(name="a" * 60 + "_")
    spawn.entity_resource.resource_string = (
        "<sdf version='1.6'><model name='m'><static>true</static><pose>3 0 0 0 0 0</pose>"
        "<link name='l'/></model></sdf>"
    )
    client.call(SpawnEntity, "/spawn_entity", spawn)
    for text in ("(a+)+$", "(a|a)*b", "(.*){50}x", "(" * 256, "[", r"(a)\1"):
        request = GetEntities.Request()
        request.filters.filter = text
        client.call(GetEntities, "/get_entities", request)


ATTACKS: tuple[Callable[[Client], None], ...] = (
    *(transitions, sensors, clock, initial_poses, paths, maps, names, expressions),
)


@pytest.mark.parametrize("mapping", [False, True], ids=["nav", "slam"])
def test_nothing_that_a_client_sends_ends_a_robot_or_its_next_goal(
    stack: Stack, mapping: bool, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    groups = (SLAM_GROUP, NAVIGATION_GROUP) if mapping else (LOCALIZATION_GROUP, NAVIGATION_GROUP)
    robot = stack(*groups, parameters=ON_MAP)
    robot.run(1.0)
    client = Client(robot)
    states = {name: node.state_label for name, node in robot.nodes.items()}
    for attack in ATTACKS:
        attack(client)
    client.mend()
    assert {name: node.state_label for name, node in robot.nodes.items()} == states
    assert not [t for t in robot.process.guard.tallies.values() if t.kind == "failed"]
    assert Goals(robot).navigate(SE2(1.5, 1.0, 0.5), 60.0).succeeded
