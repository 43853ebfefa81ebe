"""Poses at which a robot can stand: on the ground, clear of models and other robots."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_sim.physics.ground import RISE_MAX, Ground, Survey
from arjuna_sim.physics.stage import Stage

_NEAR, _EVEN = 0.1, 0.002  # how far off a slope is measured, and how straight it is [m]
_ROUGH = 0.05  # how far wheels may stand from one plane on uneven ground [m]
_RADIUS_MAX, _RING = 3.0, 0.1  # how far, and in which steps, a free pose is looked for [m]
_BESIDE = 0.5  # how far from the origin a robot starts that could not turn there [m]
_ROOM = 0.05  # how far ahead and back a robot with room to drive away stands free, too [m]
EDGE = "the edge of the ground"
"""What is in the way where a wheel would stand on nothing."""


class Placer:
    """Finds free poses for a robot of a stage."""

    def __init__(self, stage: Stage, robot: str) -> None:
        self._stage = stage
        self._robot = robot
        self._ground = Ground(stage.scene.model, stage.data)

    def _look(self) -> None:
        """Take note of the ground as all stands now."""
        self._ground = Ground(self._stage.scene.model, self._stage.data, before=self._ground)

    def root_pose(self, pose: SE2) -> Pose3:
        """Return where the robot's root is when it stands at a pose, blocked or not."""
        self._look()
        tries = list(self._tries(pose))
        return next((placed for placed, touched in tries if not touched), tries[0][0])

    def touched(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of what the robot would touch at a pose; none where it can stand."""
        self._look()
        tries = list(self._tries(pose))
        return () if any(not touched for _, touched in tries) else tries[0][1]

    def nearest_free(self, asked: SE2 | None) -> SE2:
        """Return the free pose nearest to one that may be blocked, of the same heading.

        Any but the pose itself has room to turn and drive away. The origin, where a robot starts
        if nobody asks for a pose, gives way to one that has such room beside it.

        Raises:
            WorldError: No pose within 3 m is free.
        """
        pose = asked or IDENTITY
        touched = self.touched(pose)
        if not touched and (asked or self._has_room(pose)):
            return pose
        survey = self._ground.survey(pose.x, pose.y)  # takes a tenth of a second
        if not touched:
            return self._nearest(pose, survey, True, _BESIDE) or pose
        if touched == (EDGE,) and not len(survey.points):  # a world without ground
            return pose
        for is_ground in (True, False):  # a raised floor only where the ground is nowhere free
            found = self._nearest(pose, survey, is_ground)
            if found is not None:
                return found
        problem = f"no pose within {_RADIUS_MAX:g} m of ({pose.x:g}, {pose.y:g}) is free"
        raise WorldError(self._stage.world.path, f"{problem} for the robot")

    def _nearest(
        self, pose: SE2, survey: Survey, is_ground: bool, reach: float = _RADIUS_MAX
    ) -> SE2 | None:
        for ring in range(1, round(reach / _RING) + 1):
            for step in range(16):
                angle = pose.theta + 2.0 * math.pi * step / 16
                x = pose.x + ring * _RING * math.cos(angle)
                y = pose.y + ring * _RING * math.sin(angle)
                if self._has_room(SE2(x, y, pose.theta), survey, is_ground):
                    return SE2(x, y, pose.theta)
        return None

    def _has_room(self, pose: SE2, survey: Survey | None = None, is_ground: bool = False) -> bool:
        """Return whether the robot can turn at a pose, and drive away to any side."""
        turns = (SE2(pose.x, pose.y, pose.theta + math.pi * step / 6) for step in range(12))
        ends = (turn @ SE2(ahead, 0.0) for turn in turns for ahead in (_ROOM, -_ROOM))
        return all(self._is_free(end, survey, is_ground) for end in ends)

    def _is_free(self, pose: SE2, survey: Survey | None, is_ground: bool) -> bool:
        tries = self._tries(pose, survey)
        return not next(tries)[1] or (not is_ground and any(not names for _, names in tries))

    def _tries(
        self, pose: SE2, survey: Survey | None = None
    ) -> Iterator[tuple[Pose3, tuple[str, ...]]]:
        """Yield the robot's root pose on each floor at a pose, and what it touches there."""
        for level in self._ground.levels(pose.x, pose.y, survey):
            placed, is_supported = self._pose_on_floor(pose, level)
            touched = self._contacts_at(placed)
            yield placed, touched if touched or is_supported else (EDGE,)

    def _pose_on_floor(self, pose: SE2, level: float) -> tuple[Pose3, bool]:
        """Return the root's pose on a floor and whether all wheels stand there."""
        support = self._stage.scene.robots[self._robot].support
        along, across = (self._rise(pose, level, turn) for turn in (0.0, math.pi / 2))
        points, column = support.contacts, self._ground.column
        heights = level + points @ (along, across)
        nearby = zip(pose.apply(points).tolist(), heights.tolist(), strict=True)
        found = np.array([column(x, y).nearest(height) for (x, y), height in nearby])
        off = found - heights
        # A wheel that stands higher or lower than the others by more stands on something else.
        is_supported = bool((np.abs(off) < _ROUGH + RISE_MAX * np.hypot(*points.T)).all())
        if is_supported and len(off) > 2 and np.abs(off).max() > _EVEN:  # as the wheels lie
            plane = np.column_stack((points, np.ones(len(points))))
            slope = np.linalg.lstsq(plane, found, rcond=None)[0]
            off = np.append(found - plane @ slope, level - slope[2])
            if is_supported := bool((np.abs(off) < _ROUGH).all()):
                along, across, middle = slope.tolist()
                level = middle + float(off.max())
        pitch = -math.atan(along)
        roll = math.atan(across * math.cos(pitch))
        height = support.ride_height / (math.cos(pitch) * math.cos(roll))
        root = Pose3.from_rpy((pose.x, pose.y, level + height), (roll, pitch, pose.theta))
        return root, is_supported

    def _rise(self, pose: SE2, level: float, turn: float) -> float:
        """Return the slope of a floor, to a side of the robot; 0 where it is uneven."""
        dx, dy = _NEAR * math.cos(pose.theta + turn), _NEAR * math.sin(pose.theta + turn)
        ahead, behind = (
            self._ground.column(pose.x + sign * dx, pose.y + sign * dy).nearest(level)
            for sign in (1.0, -1.0)
        )
        is_straight = abs(ahead + behind - 2.0 * level) < _EVEN
        rise = (ahead - behind) / (2.0 * _NEAR) if is_straight else 0.0
        return rise if abs(rise) < RISE_MAX else 0.0

    def _contacts_at(self, placed: Pose3) -> tuple[str, ...]:
        model, data = self._stage.scene.model, self._stage.data
        positions, (at, _) = data.qpos.copy(), self._stage.scene.robots[self._robot].base
        data.qpos[at : at + 7] = (*placed.position, *placed.quaternion)
        mujoco.mj_fwdPosition(model, data)
        touched = self._stage.contacts(self._robot)
        data.qpos[:] = positions
        mujoco.mj_fwdPosition(model, data)
        return touched
