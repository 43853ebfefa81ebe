"""Nav2's actions that ask a server and wait for its answer.

Source: nav2_behavior_tree, plugins/action.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from arjuna_nav.trees.exchange import Answer, Withdraw
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import (
    NUMBER,
    PATH,
    POSE,
    POSES,
    REQUIRED,
    TEXT,
    TRUTH,
    WHOLE,
    Port,
)

RECOVERIES = "number_recoveries"
"""Entry of the blackboard that counts recoveries, as Nav2's."""
SERVER_PORTS = {
    "server_name": Port(TEXT, ""),
    "server_timeout": Port(NUMBER, 0.0),
    "error_code_id": Port(WHOLE, 0, output=True),
    "error_msg": Port(TEXT, "", output=True),
}


class Asking(TreeNode):
    """Asks a server once, and ends as its answer says; a halt withdraws what was asked."""

    KIND: ClassVar[str]
    SERVER: ClassVar[str] = ""
    FIELDS: ClassVar[Mapping[str, str]] = {}
    """Field of the request by port."""
    IS_RECOVERY: ClassVar[bool] = False
    _key: int | None = None

    def tick(self) -> Status:
        """Ask, or look for the answer."""
        if self._key is None:
            self.set_status(Status.RUNNING)
            if self.counts_as_recovery():
                board = self.running.root
                board.set(RECOVERIES, (board.get(RECOVERIES) or 0) + 1)
            self.ask()
            return Status.RUNNING
        answer = self.running.state.answers.get(self._key)
        if answer is None:
            self.while_running()
            return Status.RUNNING
        self._key = None
        return self.take(answer)

    def ask(self) -> None:
        """Ask the server, in place of what was asked before."""
        self._key = self.running.ask(self.KIND, self.server(), self.request())

    def server(self) -> str:
        """Return the server's name."""
        return self.get("server_name") or self.SERVER

    def request(self) -> dict[str, Any]:
        """Return what is asked, by the names of the message's fields."""
        values = {field: self.get(port) for port, field in self.FIELDS.items()}
        return {field: value for field, value in values.items() if value is not None}

    def while_running(self) -> None:
        """Look whether something else is to be asked."""

    def counts_as_recovery(self) -> bool:
        """Tell whether this is one of the recoveries that feedback counts."""
        return self.IS_RECOVERY

    def take(self, answer: Answer) -> Status:
        """Write what was found, and end."""
        if "error_code_id" in self.PORTS:
            self.put("error_code_id", 0 if answer.succeeded else answer.code)
            self.put("error_msg", "" if answer.succeeded else answer.message)
        for name, value in answer.values.items():
            if name in self.PORTS:
                self.put(name, value)
        return Status.SUCCESS if answer.succeeded else Status.FAILURE

    def on_halt(self) -> None:
        """Withdraw what was asked."""
        if self._key is not None:
            self.running.commands.append(Withdraw(self._key))
            self._key = None


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
    _asked: Mapping[str, Any] = {}

    def request(self) -> dict[str, Any]:
        """Return what is to be followed, and how."""
        fields = super().request()
        self._asked = fields
        return fields

    def while_running(self) -> None:
        """Ask anew where something has changed."""
        now = super().request()
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

    def counts_as_recovery(self) -> bool:
        """Count it, unless the XML says that it is none."""
        return bool(self.get("is_recovery")) if "is_recovery" in self.PORTS else True


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


SERVICE_PORTS = {"service_name": Port(TEXT, REQUIRED), "server_timeout": Port(NUMBER, 0.0)}


class ClearEntireCostmap(Asking):
    """Clears a costmap."""

    KIND = "ClearEntireCostmap"
    PORTS: ClassVar[dict[str, Port]] = dict(SERVICE_PORTS)
    IS_RECOVERY = True

    def server(self) -> str:
        """Return the service's name."""
        return str(self.get("service_name"))


class ClearCostmapExceptRegion(ClearEntireCostmap):
    """Clears a costmap but for what is near the robot."""

    KIND = "ClearCostmapExceptRegion"
    PORTS: ClassVar[dict[str, Port]] = {**SERVICE_PORTS, "reset_distance": Port(NUMBER, 1.0)}
    FIELDS: ClassVar[Mapping[str, str]] = {"reset_distance": "reset_distance"}


class ClearCostmapAroundRobot(ClearCostmapExceptRegion):
    """Clears a costmap near the robot."""

    KIND = "ClearCostmapAroundRobot"


class ClearCostmapAroundPose(ClearCostmapExceptRegion):
    """Clears a costmap near a pose."""

    KIND = "ClearCostmapAroundPose"
    PORTS: ClassVar[dict[str, Port]] = {**ClearCostmapExceptRegion.PORTS, "pose": Port(POSE)}
    FIELDS: ClassVar[Mapping[str, str]] = {"reset_distance": "reset_distance", "pose": "pose"}


class IsPathValid(Asking):
    """Whether a path is free."""

    KIND, SERVER = "IsPathValid", "is_path_valid"
    PORTS: ClassVar[dict[str, Port]] = {"path": Port(PATH), "server_timeout": Port(NUMBER, 0.0)}
    FIELDS: ClassVar[Mapping[str, str]] = {"path": "path"}

    def server(self) -> str:
        """Return the service's name."""
        return self.SERVER
