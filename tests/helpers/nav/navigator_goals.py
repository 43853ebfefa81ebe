"""Goals that tests send to bt_navigator, and the room in which the robot drives to them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import NavigateThroughPoses, NavigateToPose

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import Goal, PlayedRobot, started
from tests.nav.worlds import block, room

GOAL = SE2(1.0, 1.0, 0.5)
TOLERANCE = 0.16
IN_BOX = SE2(4.0, -4.0)
IN_RING = SE2(-3.8, 3.8)


def walled_room() -> OccupancyGrid:
    """Return the room with a big box round IN_BOX and walls that close off IN_RING's corner."""
    world = room()
    for part in ((8.5, 0.5, 2.0, 2.0), (0.5, 8.4, 2.2, 0.1), (2.6, 8.4, 0.1, 2.2)):
        block(world, *part)
    return world


def made(**parameters: Any) -> PlayedRobot:
    return started(*NAVIGATION_GROUP.nodes, world=walled_room(), bt_navigator=parameters)


def written_tree(folder: Path, inside: str, name: str = "mine.xml") -> str:
    """Write a behavior tree of some nodes; return its file's name."""
    text = f'<root BTCPP_format="4"><BehaviorTree ID="Mine">{inside}</BehaviorTree></root>'
    (folder / name).write_text(text, encoding="utf-8")
    return name


def stamped(pose: SE2, frame: str = "map") -> PoseStamped:
    return pose_stamped(pose, frame, 0.0)


def go(robot: PlayedRobot, pose: SE2 | PoseStamped, tree: str = "") -> Goal:
    message = stamped(pose) if isinstance(pose, SE2) else pose
    request = NavigateToPose.Goal(pose=message, behavior_tree=tree)
    return robot.send(NavigateToPose, "navigate_to_pose", request)


def through(robot: PlayedRobot, *poses: SE2, frame: str = "map") -> Goal:
    request = NavigateThroughPoses.Goal(poses=[stamped(pose, frame) for pose in poses])
    return robot.send(NavigateThroughPoses, "navigate_through_poses", request)


def drive(robot: PlayedRobot) -> None:
    """Let the robot drive until it has its speed."""
    robot.run(3.0)
    assert robot.command.x > 0.2


def assert_stopped_for_good(robot: PlayedRobot) -> None:
    """Check that the robot was stopped without time passing, and stays so."""
    assert robot.command == STILL
    robot.forget()
    robot.run(1.0)
    assert all(command == STILL for command in robot.commands)


def broken() -> PoseStamped:
    """Return a goal whose orientation is no rotation."""
    message = stamped(GOAL)
    message.pose.orientation.w = message.pose.orientation.z = 0.0
    return message
