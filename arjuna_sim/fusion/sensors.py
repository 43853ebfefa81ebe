"""The messages of sensors as measurements of the states: masks, frames, differences, gravity."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.fusion.filters import Measurement
from arjuna_sim.fusion.kinematics import (
    ANGLES,
    OUT_OF_PLANE,
    SIZE,
    TWIST,
    rotation,
    wrapped,
)

# robot_localization's: what a robot in the plane measures beside what its sensors do
_PLANE_VARIANCE = 1e-6
_TURNED = 1e-6  # a state is measured if a turned mask's row is at least so long


@dataclass(frozen=True)
class Part:
    """The use of one part of a sensor: its pose, its twist or its acceleration.

    Attributes:
        source: Its name.
        mask: Which of the 15 states it is to measure, `(15,) bool`.
        threshold: Mahalanobis distance of outliers.
        planar: Whether the robot stays in the plane.
    """

    source: str
    mask: Bools
    threshold: float = np.inf
    planar: bool = False

    def measured(
        self, stamp: float, values: Floats, covariance: Floats, first: int, turned: Floats
    ) -> Measurement:
        """Return a measurement of the states from an index on.

        Args:
            values: 3 or 6, turned already; the others are 0.
            covariance: Of them, before they were turned.
            turned: What turned them, `(3, 3) float64`; mask and covariance follow it.
        """
        size = len(values)
        states = slice(first, first + size)
        turn = np.kron(np.eye(size // 3), turned)
        mask, all_values, noise = np.zeros(SIZE, bool), np.zeros(SIZE), np.zeros((SIZE, SIZE))
        mask[states] = np.linalg.norm(turn * self.mask[states], axis=1) >= _TURNED
        all_values[states] = values
        noise[states, states] = turn @ covariance @ turn.T
        if self.planar:
            plane = list(OUT_OF_PLANE)
            mask[plane], all_values[plane] = True, 0.0
            noise[plane, plane] = _PLANE_VARIANCE
        return Measurement(stamp, all_values, noise, mask, self.threshold, self.source)


@dataclass
class PoseInput:
    """Poses of one sensor.

    Attributes:
        differential: Whether differences of two poses count, as velocities.
        relative: Whether poses count from the first one on.
    """

    part: Part
    differential: bool = False
    relative: bool = False
    _first: Pose3 | None = None
    _last: tuple[float, Pose3, Floats] | None = None

    def forget(self) -> None:
        """Forget the first and the last pose."""
        self._first = self._last = None

    def measured(
        self, stamp: float, pose: Pose3, covariance: Floats, T_world_frame: Pose3 = ORIGIN
    ) -> Measurement | None:
        """Return the measurement of a pose in a frame; None of the first of differences."""
        if self.differential:
            return self._velocity(stamp, pose, covariance, np.eye(3))
        pose, turned = T_world_frame @ self._from_first(pose), T_world_frame.rotation()
        values = np.array((*pose.position, *pose.rpy()))
        return self.part.measured(stamp, values, covariance, 0, turned)

    def of_imu(
        self, stamp: float, orientation: Pose3, covariance: Floats, T_base_imu: Pose3 = ORIGIN
    ) -> Measurement | None:
        """Return the measurement of an IMU's orientation in the world."""
        offset = T_base_imu.rpy()
        turned = rotation(0.0, 0.0, offset[2])
        angles = turned @ wrapped(np.array(orientation.rpy()) - np.array(offset))
        pose = Pose3.from_rpy((0.0, 0.0, 0.0), tuple(angles.tolist()))
        if self.differential:
            return self._velocity(stamp, pose, covariance, turned)
        values = np.array((0.0, 0.0, 0.0, *self._from_first(pose).rpy()))
        return self.part.measured(stamp, values, covariance, 0, turned)

    def _from_first(self, pose: Pose3) -> Pose3:
        if not self.relative:
            return pose
        self._first = self._first or pose
        return self._first.inverse() @ pose

    def _velocity(
        self, stamp: float, pose: Pose3, covariance: Floats, turned: Floats
    ) -> Measurement | None:
        before, self._last = self._last, (stamp, pose, covariance)
        if before is None or stamp <= before[0]:
            return None
        dt, moved = stamp - before[0], before[1].inverse() @ pose
        values = np.array((*moved.position, *moved.rpy())) / dt
        shifted = np.concatenate((np.zeros(6, bool), self.part.mask[:6], np.zeros(3, bool)))
        part = replace(self.part, mask=shifted)
        return part.measured(stamp, values, (covariance + before[2]) * dt, 6, turned)


def twist_measured(
    part: Part, stamp: float, twist: Floats, covariance: Floats, T_base_sensor: Pose3, state: Floats
) -> Measurement:
    """Return the measurement of a sensor's velocity and turn rates `(6,)` in its own frame.

    Args:
        state: The filter's, whose turn rates move a sensor that is off the base.
    """
    turned, turning = T_base_sensor.rotation(), state[TWIST][3:]
    lever = np.cross(np.array(T_base_sensor.position), turning)
    values = np.concatenate((turned @ twist[:3] + lever, turned @ twist[3:]))
    return part.measured(stamp, values, covariance, 6, turned)


def acceleration_measured(
    part: Part, stamp: float, felt: Floats, covariance: Floats, T_base_imu: Pose3
) -> Measurement:
    """Return the measurement of an IMU's acceleration `(3,)`, of which gravity is taken already."""
    turned = T_base_imu.rotation()
    return part.measured(stamp, turned @ felt, covariance, 12, turned)


def without_gravity(
    felt: Floats, gravity: float, orientation: Pose3 | None, T_base_imu: Pose3, state: Floats
) -> Floats:
    """Return an IMU's acceleration `(3,)` without that of rest.

    Args:
        gravity: Its acceleration [m/s^2].
        orientation: The IMU's in the world; None where it knows none, and the filter's holds.
    """
    if orientation is not None:
        turned = orientation.rotation()
    else:
        turned = rotation(*state[ANGLES].tolist()) @ T_base_imu.rotation()
    result: Floats = felt - gravity * turned[2]
    return result
