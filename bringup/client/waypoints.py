"""Waypoints: read from a file, driven one after the other, summed up."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.se2 import yaw_of

if TYPE_CHECKING:
    from bringup.client.goals import GoalEnd
    from bringup.client.robot import Robot

Waypoint = tuple[float, float, float]
_RULE = "_" * 40
_VALID = "valid: 'waypoints: [[x, y, yaw], ...]' or '- {x: 1.0, y: 2.0, yaw: 0.0}'"


def load_waypoints(path: Path) -> list[Waypoint]:
    """Return a file's waypoints [m, m, rad].

    Raises:
        InputFileError: It cannot be read, or holds something else.
    """
    document = read_yaml(path)
    rows = document.get("waypoints") if isinstance(document, dict) else document
    if not isinstance(rows, list) or not rows:
        raise InputFileError(path, f"holds no waypoints; {_VALID}")
    return [_waypoint(path, row, number) for number, row in enumerate(rows, 1)]


def _waypoint(path: Path, row: Any, number: int) -> Waypoint:
    if isinstance(row, dict) and set(row) <= {"x", "y", "yaw"} and {"x", "y"} <= set(row):
        row = [row["x"], row["y"], row.get("yaw", 0.0)]
    if isinstance(row, list) and len(row) in (2, 3):
        numbers = [v for v in row if isinstance(v, int | float) and not isinstance(v, bool)]
        if len(numbers) == len(row) and all(map(math.isfinite, numbers)):
            x, y, yaw = (*map(float, numbers), 0.0)[:3]
            return x, y, yaw
    raise InputFileError(path, f"is no pose: {row!r}; {_VALID}", f"waypoint {number}")


class Progress:
    """Writes the distance left at each step [m]; takes the feedback of navigate_to_pose."""

    def __init__(self, write: Callable[[str], None], step: float = 0.5) -> None:
        self._write, self._step = write, step
        self._said = math.inf
        self._latest: Any = None

    @property
    def arrival(self) -> str:
        """The last pose of the robot, as text; empty where none has come."""
        if self._latest is None:
            return ""
        position, q = self._pose.position, self._pose.orientation
        yaw = yaw_of(q.x, q.y, q.z, q.w)
        return f" - arrived at ({position.x:.2f}, {position.y:.2f}), yaw {yaw:.2f}"

    @property
    def _pose(self) -> Any:
        return self._latest.current_pose.pose

    def judged(self, end: GoalEnd, x: float, y: float, tolerance: float) -> GoalEnd:
        """Return how a goal at x, y [m] ended: failed where the robot is off by more [m].

        A reason says so of a goal that was moved within the tolerance, too.
        """
        if not end.succeeded or self._latest is None:
            return end
        reached = self._pose.position
        off = math.hypot(reached.x - x, reached.y - y)
        if off <= 0.1:  # [m] arrivals of the shipped parameters are nearer
            return end
        asked, where = f"({x:.2f}, {y:.2f})", f"({reached.x:.2f}, {reached.y:.2f})"
        reason = f"asked for {asked}, reached {where}, {off:.2f} m off: "
        if off <= tolerance:
            reason += "as the planner's tolerance or the goal checker's lets it"
            return replace(end, reason=reason)
        reason += "the planner took a free position near it, as its tolerance lets it"
        reason += f" ('--tolerance {off + 0.01:.2f}' takes that)"
        return replace(end, succeeded=False, reason=reason)

    def __call__(self, feedback: Any) -> None:
        """Take a feedback message."""
        self._latest = feedback
        remaining = feedback.distance_remaining
        if remaining > 0.0 and abs(self._said - remaining) >= self._step:
            self._said = remaining
            self._write(f"  Distance remaining: {remaining:.2f}m")


class Tour:
    """Drives to waypoints and writes how each ended."""

    def __init__(self, robot: Robot, write: Callable[[str], None]) -> None:
        self._robot = robot
        self._write = write

    def drive(
        self, waypoints: Sequence[Waypoint], timeout: float, pause: float, tolerance: float
    ) -> int:
        """Drive to poses in the map, skipping those that fail; return how many were reached.

        Each may take a timeout [s], and the robot may end up within a tolerance [m] of it.
        """
        count = len(waypoints)
        self._write(f"Starting waypoint navigation - {count} waypoints")
        reached = 0
        for number, pose in enumerate(waypoints, 1):
            self._write(_RULE)
            x, y, yaw = pose
            self._write(f"Waypoint {number} / {count} → X: {x:.2f} Y: {y:.2f} Yaw: {yaw:.2f}")
            reached += self._go(number, pose, timeout, tolerance)
            if number < count:
                self._robot.session.pause(pause)
        self._write("\n".join([_RULE, "NAVIGATION COMPLETE", f"Waypoints reached : {reached}"]))
        self._write(f"Waypoints failed : {count - reached}\nTotal waypoints : {count}")
        return reached

    def _go(self, number: int, pose: Waypoint, timeout: float, tolerance: float) -> bool:
        progress = Progress(self._write)
        end = self._robot.goto(*pose, timeout=timeout, progress=progress)
        end = progress.judged(end, *pose[:2], tolerance)
        if end.succeeded:
            self._write(f"✓ Waypoint {number} REACHED{end.reason and f': {end.reason}'}")
        else:
            self._write(f"✗ Waypoint {number} FAILED: {end.reason}")
        return end.succeeded
