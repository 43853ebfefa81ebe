"""Rollers of mecanum and omni wheels: they let a wheel slip one way and grip the other.

What touches the ground is always the lowest roller, and its axis always has the same direction to
the robot. So a wheel with rollers is a round one that turns freely about that direction as well as
on its motor, with dry friction as any other has. It has turned back before that shows, after each
step of the physics: a round wheel that is turned about its middle is the same wheel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.wheels import center


def add_rollers(body: Any, robot: RobotModel, joint: str) -> None:
    """Add the freedom of a wheel's rollers to its body, where it has any, before its own joint.

    Args:
        body: The spec's body; its frame is the wheel's link's.
        robot: The robot.
        joint: The wheel's joint.
    """
    drive, urdf = robot.drive, robot.urdf
    if not drive.grips:
        return
    T_link_root = urdf.T_root(urdf.joints[joint].child).inverse()
    along = np.array([*drive.grips[drive.wheels.index(joint)], 0.0])
    place = T_link_root.apply(center(urdf, joint)[None])[0]
    body.add_joint(name=_name(joint), axis=T_link_root.rotation() @ along, pos=place)


def roller_addresses(model: Any, robot: RobotModel) -> NDArray[np.int64]:
    """Return the addresses in qpos of what rollers have turned, `(R,) int64`."""
    names = robot.wheel_joints if robot.drive.grips else ()
    return np.array([model.joint(_name(name)).qposadr[0] for name in names], np.int64)


def _name(joint: str) -> str:
    return f"{joint}//rollers"
