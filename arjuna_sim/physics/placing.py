"""Poses at which a robot can stand: on the ground, clear of models and other robots."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.physics.stage import Stage

_TOP, _BOTTOM = 3.0, -5.0  # between which floors are looked for [m]
_BELOW = 1e-4  # a ray continues so far below what it hit [m]
_WIDE, _LEVEL = 1.0, 0.05  # a floor is as high in most directions this far away [m]
_NEAR, _EVEN = 0.1, 0.002  # how far off a slope is measured, and how straight it is [m]
_RADIUS_MAX, _RING = 3.0, 0.1  # how far, and in which steps, a free pose is looked for [m]
_HIT = np.array([group == Group.WORLD_COLLISION.value for group in range(6)], np.uint8)


class Placer:
    """Finds free poses for a robot of a stage."""

    def __init__(self, stage: Stage, robot: str) -> None:
        self._stage = stage
        self._robot = robot

    def root_pose(self, pose: SE2) -> Pose3:
        """Return where the robot's root is when it stands at a pose, blocked or not."""
        return next((placed for placed, touched in self._tries(pose) if not touched), None) or next(
            placed for placed, _ in self._tries(pose)
        )

    def touched(self, pose: SE2) -> tuple[str, ...]:
        """Return the names of what the robot would touch at a pose; none where it can stand."""
        tries = list(self._tries(pose))
        return () if any(not touched for _, touched in tries) else tries[0][1]

    def nearest_free(self, pose: SE2) -> SE2:
        """Return the free pose nearest to one that may be blocked, of the same heading.

        Any but the pose itself is free at any heading of the robot.

        Raises:
            WorldError: No pose within 3 m is free.
        """
        if not self.touched(pose):
            return pose
        for is_ground in (True, False):  # a raised floor only where the ground is nowhere free
            found = self._nearest(pose, is_ground)
            if found is not None:
                return found
        problem = f"no pose within {_RADIUS_MAX:g} m of ({pose.x:g}, {pose.y:g}) is free"
        raise WorldError(self._stage.world.path, f"{problem} for the robot")

    def _nearest(self, pose: SE2, is_ground: bool) -> SE2 | None:
        for ring in range(1, round(_RADIUS_MAX / _RING) + 1):
            for step in range(16):  # directions of a ring, with 8 headings at each position
                angle = pose.theta + 2.0 * math.pi * step / 16
                x = pose.x + ring * _RING * math.cos(angle)
                y = pose.y + ring * _RING * math.sin(angle)
                turns = [pose.theta + 2.0 * math.pi * i / 8 for i in range(8)]
                if all(self._is_free(SE2(x, y, turn), is_ground) for turn in turns):
                    return SE2(x, y, pose.theta)
        return None

    def _is_free(self, pose: SE2, is_ground: bool) -> bool:
        tries = self._tries(pose)
        return not next(tries)[1] or (not is_ground and any(not names for _, names in tries))

    def _tries(self, pose: SE2) -> Iterator[tuple[Pose3, tuple[str, ...]]]:
        """Yield the robot's root pose on each floor at a pose, and what it touches there."""
        mujoco.mj_kinematics(self._stage.scene.model, self._stage.data)
        lowest, *higher = self._levels(pose.x, pose.y) or [0.0]
        # [m] A level more than 0.25 m above the lowest is a roof.
        steps = [level for level in higher if level < lowest + 0.25]
        floors = [lowest, *(level for level in steps if self._is_floor(pose, level))]
        for level in floors:
            placed = self._pose_on_floor(pose, level)
            yield placed, self._contacts_at(placed)

    def _pose_on_floor(self, pose: SE2, level: float) -> Pose3:
        """Return the pose of the root of a robot that stands on a floor, level or sloped."""
        along, across = (self._rise(pose, level, turn) for turn in (0.0, math.pi / 2))
        pitch = -math.atan(along)
        roll = math.atan(across * math.cos(pitch))
        upright = self._stage.scene.robots[self._robot].support.ride_height
        height = upright / (math.cos(pitch) * math.cos(roll))
        return Pose3.from_rpy((pose.x, pose.y, level + height), (roll, pitch, pose.theta))

    def _rise(self, pose: SE2, level: float, turn: float) -> float:
        """Return the slope of a floor, to a side of the robot; 0 where it is uneven."""
        ends = []
        for offset in (_NEAR, -_NEAR):
            x = pose.x + offset * math.cos(pose.theta + turn)
            y = pose.y + offset * math.sin(pose.theta + turn)
            ends.append(min(self._levels(x, y), key=lambda z: abs(z - level), default=math.inf))
        ahead, behind = ends
        is_straight = abs(ahead + behind - 2.0 * level) < _EVEN
        rise = (ahead - behind) / (2.0 * _NEAR) if is_straight else 0.0
        # A robot is put on slopes of up to 0.7 (35 degrees).
        return rise if abs(rise) < 0.7 else 0.0

    def _levels(self, x: float, y: float) -> list[float]:
        """Return the heights of all surfaces above the highest plane at a point, rising [m]."""
        model, data = self._stage.scene.model, self._stage.data
        is_plane = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        is_solid = model.geom_group == Group.WORLD_COLLISION.value
        planes = data.geom_xpos[is_plane & is_solid, 2].tolist()
        ground = max((height for height in planes if height < _TOP), default=_BOTTOM)
        found = {round(ground, 6)} if planes else set()
        inside: set[int] = set()
        height, geom = _TOP, np.zeros(1, np.int32)
        # Up to 40 floors above one another are searched.
        for _ in range(40):
            start, down = np.array([x, y, height]), np.array([0.0, 0.0, -1.0])
            distance = mujoco.mj_ray(model, data, start, down, _HIT, 1, -1, geom)
            if distance < 0.0 or height - distance < ground + _BELOW:
                break
            height -= float(distance)
            if int(geom[0]) not in inside:  # else it is the underside
                found.add(round(height, 6))
            if model.geom_type[geom[0]] == mujoco.mjtGeom.mjGEOM_HFIELD:
                break  # nothing is below a terrain
            inside ^= {int(geom[0])}
            height -= _BELOW
        return sorted(found)

    def _is_floor(self, pose: SE2, level: float) -> bool:
        """Return whether a surface extends around the robot, rather than tops a box."""
        around = [
            self._levels(pose.x + _WIDE * math.cos(angle), pose.y + _WIDE * math.sin(angle))
            for angle in np.arange(8) * math.pi / 4
        ]
        near = [any(abs(other - level) < _LEVEL for other in levels) for levels in around]
        return sum(near) >= len(near) // 2

    def _contacts_at(self, placed: Pose3) -> tuple[str, ...]:
        model, data = self._stage.scene.model, self._stage.data
        positions, (at, _) = data.qpos.copy(), self._stage.scene.robots[self._robot].base
        data.qpos[at : at + 7] = (*placed.position, *placed.quaternion)
        mujoco.mj_fwdPosition(model, data)
        touched = self._stage.contacts(self._robot)
        data.qpos[:] = positions
        mujoco.mj_fwdPosition(model, data)
        return touched
