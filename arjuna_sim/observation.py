"""What a tick of the simulation brings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import OdometryEstimate


@dataclass(frozen=True)
class JointStates:
    """Positions [rad or m] and velocities of the moving joints, in the URDF's order."""

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """Where the robot really is: what no robot knows.

    Attributes:
        pose: Of the robot's root in the world, seen from above.
        v: Speed along the robot's x axis [m/s].
        w: Turn rate [rad/s].
        z: Height of the robot's root [m].
        roll: [rad].
        pitch: [rad].
    """

    pose: SE2
    v: float
    w: float
    z: float
    roll: float
    pitch: float


@dataclass(frozen=True)
class Observation:
    """What one tick brought.

    Attributes:
        time: At the tick's end [s].
        odometry: Dead reckoning.
        joints: All joints that move.
        imu: The last reading, where one was due.
        imu_before: The readings before it, where the IMU is faster than the tick.
        scan: A sweep, where one was due.
        truth: Where the robot really is.
        contacts: Names of the world's models that the robot touches, sorted; never the ground.
    """

    time: float
    odometry: OdometryEstimate
    joints: JointStates
    imu: ImuReading | None
    scan: Scan | None
    truth: Truth
    contacts: tuple[str, ...]
    imu_before: tuple[ImuReading, ...] = ()
