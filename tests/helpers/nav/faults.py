"""Faults that a robot meets on its path, and the outcome of each."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from arjuna_core.ros.convert import seconds, time_msg
from tests.helpers.faults import Fault

DEAD = Fault(drop=1.0)
_BACK = 5.0  # [s]
_SLIP = 0.7  # of what the wheels report


def _mirrored(scan: Any) -> Any:
    scan.ranges = scan.ranges[::-1]
    return scan


def _half_blind(scan: Any) -> Any:
    half = len(scan.ranges) // 2
    scan.ranges = [math.inf] * half + list(scan.ranges[half:])
    return scan


def _slipping(odometry: Any) -> Any:
    odometry.twist.twist.linear.x *= _SLIP
    odometry.twist.twist.angular.z *= _SLIP
    return odometry


def _set_back(clock: Any) -> Any:
    clock.clock = time_msg(max(seconds(clock.clock) - _BACK, 0.0))
    return clock


class Trial(NamedTuple):
    """A fault of a topic.

    Attributes:
        fault: The treatment of its messages.
        stands_within: From the fault to the last motion, braking included [s]; None where the robot
            continues.
    """

    topic: str
    fault: Fault
    stands_within: float | None = None


BLIND = {
    "a dead lidar": Trial("/scan", DEAD, 0.5),
    "a frozen lidar": Trial("/scan", Fault(frozen=True), 0.5),
    "no transforms": Trial("/tf", DEAD, 0.5),
    "no commands": Trial("/cmd_vel", DEAD, 0.5),
}
"""The robot stands, and drives on when it is over."""

TOLERATED = {
    "half the scans": Trial("/scan", Fault(drop=0.5)),
    "half the transforms": Trial("/tf", Fault(drop=0.5)),
    "half the commands": Trial("/cmd_vel", Fault(drop=0.5)),
    "late scans out of order": Trial("/scan", Fault(delay=0.05, jitter=0.15)),
    "all odometry twice": Trial("/odom", Fault(duplicate=1.0)),
    "no odometry": Trial("/odom", DEAD),
    "late commands": Trial("/cmd_vel", Fault(delay=0.1)),
}
"""The robot receives enough to continue."""

SURVIVED = {
    "a half blind lidar": Trial("/scan", Fault(change=_half_blind)),
    "a mirrored lidar": Trial("/scan", Fault(change=_mirrored)),
    "slipping wheels": Trial("/odom", Fault(change=_slipping)),
    "frozen odometry": Trial("/odom", Fault(frozen=True)),
    "a clock that stops": Trial("/clock", DEAD),
    "a clock set back": Trial("/clock", Fault(change=_set_back)),
    "late transforms": Trial("/tf", Fault(delay=0.2, jitter=0.3)),
}
"""The mission ends right, or with the reason."""
