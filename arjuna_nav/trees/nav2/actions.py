"""Nav2's actions: to plan, follow, smooth, dock, and the behaviors.

Source: nav2_behavior_tree, plugins/action.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from arjuna_nav.trees.asking import SERVER_PORTS, Asking
from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Status
from arjuna_nav.trees.ports import NUMBER, PATH, POSE, POSES, TEXT, TRUTH, WHOLE, Port


class ComputePathToPose(Asking):
    """Plans to a pose."""

    KIND, SERVER = "ComputePathToPose", "compute_path_to_pose"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "goal": Port(POSE),
        "start": Port(POSE, None),
        "use_start": Port(TRUTH, True),
        "planner_id": Port(TEXT, ""),
        "path": Port(PATH, None, output=True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "goal": "goal",
        "start": "start",
        "planner_id": "planner_id",
    }
    _goals: Any = None

    def tick(self) -> Status:
        """Ask anew where another goal has come: a path to the older one would pass for its own."""
        asks = self._key is not None and not self._cancelled
        if asks and self._goals != self._newest():
            self.ask()
            return Status.RUNNING
        return super().tick()

    def ask(self) -> None:
        """Ask the server, and keep for which goals."""
        self._goals = self._newest()
        super().ask()

    def _newest(self) -> Any:
        board = self.running.root
        return board.get("goal"), board.get("goals")

    def request(self) -> dict[str, Any]:
        """Plan from a start where one is given, else from where the robot is."""
        fields = super().request()
        if not self.get("use_start"):
            fields.pop("start", None)
        return {**fields, "use_start": "start" in fields}


class ComputePathThroughPoses(ComputePathToPose):
    """Plans through poses."""

    KIND, SERVER = "ComputePathThroughPoses", "compute_path_through_poses"
    PORTS: ClassVar[dict[str, Port]] = {
        **{name: port for name, port in ComputePathToPose.PORTS.items() if name != "goal"},
        "goals": Port(POSES),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "goals": "goals",
        "start": "start",
        "planner_id": "planner_id",
    }


class FollowPath(Asking):
    """Follows a path; a new path, controller or checker on the blackboard is taken on the way."""

    KIND, SERVER = "FollowPath", "follow_path"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "path": Port(PATH),
        "controller_id": Port(TEXT, ""),
        "goal_checker_id": Port(TEXT, ""),
        "progress_checker_id": Port(TEXT, ""),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "path": "path",
        "controller_id": "controller_id",
        "goal_checker_id": "goal_checker_id",
        "progress_checker_id": "progress_checker_id",
    }

    def while_running(self) -> None:
        """Ask anew where something has changed."""
        now = self.request()
        path = now.pop("path")
        before = {name: value for name, value in self._asked.items() if name != "path"}
        if path is not self._asked["path"] or now != before:
            self.ask()


class SmoothPath(Asking):
    """Smooths a path."""

    KIND, SERVER = "SmoothPath", "smooth_path"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "unsmoothed_path": Port(PATH),
        "max_smoothing_duration": Port(NUMBER, 3.0),
        "check_for_collisions": Port(TRUTH, False),
        "smoother_id": Port(TEXT, ""),
        "smoothed_path": Port(PATH, None, output=True),
        "smoothing_duration": Port(NUMBER, 0.0, output=True),
        "was_completed": Port(TRUTH, False, output=True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "unsmoothed_path": "path",
        "max_smoothing_duration": "max_smoothing_duration",
        "check_for_collisions": "check_for_collisions",
        "smoother_id": "smoother_id",
    }

    def take(self, answer: Answer) -> Status:
        """Write the smoothed path."""
        if answer.succeeded:
            self.put("smoothed_path", answer.values.get("path"))
        return super().take(answer)


class _Behavior(Asking):
    """A behavior of the behavior server."""

    IS_RECOVERY = True


class Spin(_Behavior):
    """Turns on the spot."""

    KIND, SERVER = "Spin", "spin"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "spin_dist": Port(NUMBER, 1.57),
        "time_allowance": Port(NUMBER, 10.0),
        "is_recovery": Port(TRUTH, True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "spin_dist": "target_yaw",
        "time_allowance": "time_allowance",
    }


class Wait(_Behavior):
    """Waits."""

    KIND, SERVER = "Wait", "wait"
    PORTS: ClassVar[dict[str, Port]] = {**SERVER_PORTS, "wait_duration": Port(NUMBER, 1.0)}
    FIELDS: ClassVar[Mapping[str, str]] = {"wait_duration": "time"}


class BackUp(_Behavior):
    """Drives straight back."""

    KIND, SERVER = "BackUp", "backup"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "backup_dist": Port(NUMBER, 0.15),
        "backup_speed": Port(NUMBER, 0.025),
        "time_allowance": Port(NUMBER, 10.0),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "backup_dist": "target",
        "backup_speed": "speed",
        "time_allowance": "time_allowance",
    }


class DriveOnHeading(Asking):
    """Drives straight ahead."""

    KIND, SERVER = "DriveOnHeading", "drive_on_heading"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "dist_to_travel": Port(NUMBER, 0.15),
        "speed": Port(NUMBER, 0.025),
        "time_allowance": Port(NUMBER, 10.0),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "dist_to_travel": "target",
        "speed": "speed",
        "time_allowance": "time_allowance",
    }


class AssistedTeleop(_Behavior):
    """Lets a person drive, and stops before obstacles."""

    KIND, SERVER = "AssistedTeleop", "assisted_teleop"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "time_allowance": Port(NUMBER, 10.0),
        "is_recovery": Port(TRUTH, False),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {"time_allowance": "time_allowance"}


class DockRobot(Asking):
    """Docks."""

    KIND, SERVER = "DockRobot", "dock_robot"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "use_dock_id": Port(TRUTH, True),
        "dock_id": Port(TEXT, ""),
        "dock_pose": Port(POSE, None),
        "dock_type": Port(TEXT, ""),
        "max_staging_time": Port(NUMBER, 1000.0),
        "navigate_to_staging_pose": Port(TRUTH, True),
        "num_retries": Port(WHOLE, 0, output=True),
        "success": Port(TRUTH, False, output=True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        name: name
        for name in (
            *("use_dock_id", "dock_id", "dock_pose", "dock_type"),
            *("max_staging_time", "navigate_to_staging_pose"),
        )
    }


class UndockRobot(Asking):
    """Leaves the dock."""

    KIND, SERVER = "UndockRobot", "undock_robot"
    PORTS: ClassVar[dict[str, Port]] = {
        **SERVER_PORTS,
        "dock_type": Port(TEXT, ""),
        "max_undocking_time": Port(NUMBER, 30.0),
        "success": Port(TRUTH, False, output=True),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {
        "dock_type": "dock_type",
        "max_undocking_time": "max_undocking_time",
    }
