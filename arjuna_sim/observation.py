"""What a tick of the simulation brings."""

from __future__ import annotations

from typing import NamedTuple

from arjuna_core.scan import Scan
from arjuna_sim.devices.imu import ImuReading
from arjuna_sim.devices.odometry import OdometryEstimate
from arjuna_sim.physics.robot_motion import JointStates, Truth


class Observation(NamedTuple):
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
