"""A whole robot in lock-step, as the tests of the system drive it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nav2_msgs.action import NavigateToPose

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.convert import pose_stamped
from arjuna_core.ros.local.actions import action_client
from arjuna_core.se2 import SE2

if TYPE_CHECKING:
    from bringup.lockstep import LockStep

Stack = Callable[..., "LockStep"]
"""The fixture `stack`."""
REACHED = 0.25  # nav2's xy_goal_tolerance [m]
ROOM = {"map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))}}
ON_MAP: dict[str, dict[str, Any]] = {**ROOM, "amcl": {"set_initial_pose": True}}
"""The parameters of a robot that knows its pose on the shipped map."""


def truth(robot: LockStep) -> SE2:
    """Return the true pose of the robot."""
    pose: SE2 = robot.sim.last.truth.pose
    return pose


def to_pose(goal: SE2, behavior_tree: str = "") -> Any:
    """Return the goal of navigate_to_pose for a pose on the map."""
    return NavigateToPose.Goal(pose=pose_stamped(goal, "map", 0.0), behavior_tree=behavior_tree)


def send(robot: LockStep, action: Any, name: str, goal: Any) -> Any:
    """Send a goal; return the handle of the goal that its server has accepted."""
    client = action_client(robot.client, action, name)
    robot.run_until(client.server_is_ready, 5.0, f"a server of {name}")
    handle = robot.send_goal(client, goal)
    assert handle.accepted
    return handle


def outcome(robot: LockStep, action: Any, name: str, goal: Any, timeout: float = 60.0) -> Any:
    """Send a goal and wait for its end [s]; return its status and result."""
    ended = send(robot, action, name, goal).get_result_async()
    return robot.result(ended, timeout, f"the end of {name}")


def owners(client: Any, topic: str) -> set[str]:
    """Return the first namespaces of the nodes that have an end of a topic."""
    ask: tuple[Callable[[str], Any], ...] = (
        client.get_publishers_info_by_topic,
        client.get_subscriptions_info_by_topic,
    )
    return {end.node_namespace.split("/")[1] for ends in ask for end in ends(topic)}
