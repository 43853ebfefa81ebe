"""Claims: slam_toolbox's own parameter files map and localize on the shipped robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid
from slam_toolbox.srv import SaveMap, SerializePoseGraph
from std_msgs.msg import String

from arjuna_core.files.maps import load_map
from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from arjuna_slam.localization import Localizer
from bringup.lockstep import LockStep
from bringup.parameters.checking import over_shipped
from bringup.parameters.files import merged
from bringup.stack import SLAM_GROUP
from tests.helpers.robots import Stack

pytestmark = pytest.mark.ros
FILES = sorted((Path(__file__).parent / "slam_toolbox").glob("*.yaml"), key=str)
ASYNC, LOCALIZATION = (
    next(path for path in FILES if name in path.name) for name in ("online_async", "localization")
)
PATIENCE = 5.0  # [s] for the first map


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's home."""
    monkeypatch.setenv("HOME", str(tmp_path))
    return tmp_path


def mapping(stack: Stack, path: Path, **values: Any) -> tuple[LockStep, list[OccupancyGrid]]:
    """Return the robot with a file's mapper, once its first map has come, and its maps."""
    parameters = merged(over_shipped([path]), {"slam_toolbox": values})
    robot = stack(SLAM_GROUP, parameters=parameters)
    maps: list[OccupancyGrid] = []
    robot.client.create_subscription(OccupancyGrid, "/map", maps.append, qos.LATCHED)
    robot.run_until(lambda: bool(maps), PATIENCE, f"a map of {path.name}")
    return robot, maps


def drive(robot: LockStep, speed: float, turn: float, seconds: float) -> None:
    """Drive an arc of some speed [m/s] and turn rate [rad/s], then stop."""
    commands = robot.client.create_publisher(Twist, "/cmd_vel", qos.DEFAULT)
    command = Twist()
    command.linear.x, command.angular.z = speed, turn
    for _ in range(round(seconds / 0.1)):
        commands.publish(command)
        robot.run(0.1)
    commands.publish(Twist())
    robot.run(1.0)


def error(robot: LockStep, origin: SE2) -> float:
    """Return how far off the robot takes itself to be [m]."""
    estimate = robot.process.transforms.lookup("map", "base_footprint")
    return estimate.distance(origin.inverse() @ robot.sim.last.truth.pose)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_stock_file_maps_and_localizes(stack: Stack, path: Path) -> None:
    robot, maps = mapping(stack, path)
    origin = robot.sim.last.truth.pose
    drive(robot, 0.3, 0.4, 18.0)
    assert len(maps) > 1
    assert maps[0].data.count(0) > 100  # of one scan: free about the robot, its walls by few beams
    assert maps[-1].data.count(100) > 200
    assert error(robot, origin) < 0.03


def test_a_stock_file_localizes_on_a_graph(stack: Stack, home: Path) -> None:
    robot, _ = mapping(stack, ASYNC)
    origin = robot.sim.last.truth.pose
    drive(robot, 0.3, 0.4, 16.0)
    request = SerializePoseGraph.Request(filename=str(home / "maps/room"))
    answer = robot.call(SerializePoseGraph, "/slam_toolbox/serialize_map", request)
    assert answer.result == SerializePoseGraph.Response.RESULT_SUCCESS
    saved = SaveMap.Request(name=String(data="~/maps/room"))
    answer = robot.call(SaveMap, "/slam_toolbox/save_map", saved)
    assert answer.result == SaveMap.Response.RESULT_SUCCESS
    assert (load_map(home / "maps/room.yaml").data == 100).sum() > 100
    graph = {"map_file_name": str(home / "maps/room"), "map_start_pose": [0.0, 0.0, 0.0]}
    graph["mode"] = "localization"  # the node itself, there
    robot, maps = mapping(stack, LOCALIZATION, **graph)
    assert isinstance(robot.nodes["slam_toolbox"].slam, Localizer)
    assert maps[0].data.count(100) > 100
    drive(robot, 0.3, -0.4, 10.0)
    assert error(robot, origin) < 0.03
