"""Frames of sensors, which the simulation adds where the robot's file has none.

Pictures are in optical frames (REP 103): z ahead, x to the right and y down.
"""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import dataclass

import numpy as np

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Joint, Urdf

T_BODY_OPTICAL = Pose3.from_rpy((0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2))
"""An optical frame in a frame with x ahead and z up."""
_SUFFIX = "_optical_frame"
_TOLERANCE = 1e-3
ABOVE = ("world", "map", "odom", "earth")
"""Frames that no robot carries."""


@dataclass(frozen=True)
class SensorFrame:
    """The frame that a sensor's messages name.

    Attributes:
        parent: The link that it is fixed to; None where it is a link of the robot itself.
        T_parent: Its pose in that link.
    """

    name: str
    parent: str | None = None
    T_parent: Pose3 = ORIGIN


def sensor_frame(urdf: Urdf, sensor: SensorSettings) -> SensorFrame:
    """Return the frame of a sensor: one that the robot has, or else one to be added.

    A sensor that its file puts off its link has a frame of its own, unless the file names a link
    that stands just there. One of the world is not taken for that of a sensor.
    """
    if sensor.frame in ABOVE and sensor.frame not in urdf.links:
        sensor = dataclasses.replace(sensor, frame=sensor.link)
    if sensor.IS_OPTICAL:
        return optical_frame(urdf, sensor)
    named = sensor.frame in urdf.links
    if named and (sensor.pose == ORIGIN or _is_at(urdf, sensor.frame, sensor, ORIGIN)):
        return SensorFrame(sensor.frame)
    name = f"{sensor.frame}_{_plain(sensor.name)}" if named else sensor.frame
    return SensorFrame(name, sensor.link, sensor.pose)


def optical_frame(urdf: Urdf, camera: SensorSettings) -> SensorFrame:
    """Return the optical frame of a camera, which looks along x of its link and its own pose.

    The frame that the robot's file names is as often as not no optical one.
    """
    frame, T_link = camera.frame, camera.pose @ T_BODY_OPTICAL
    if frame in urdf.links:
        if _is_at(urdf, frame, camera, T_BODY_OPTICAL, camera.pose != ORIGIN):
            return SensorFrame(frame)
        for joint in urdf.joints.values():
            if joint.parent == frame and _carries_optical(joint) and camera.pose == ORIGIN:
                return SensorFrame(joint.child)
        if camera.pose == ORIGIN:
            return SensorFrame(frame + _SUFFIX, frame, T_BODY_OPTICAL)
        return SensorFrame(f"{camera.link}_{_plain(camera.name)}{_SUFFIX}", camera.link, T_link)
    return SensorFrame(frame, camera.link, T_link)


def _is_at(
    urdf: Urdf, link: str, sensor: SensorSettings, T_own: Pose3, at_position: bool = True
) -> bool:
    """Return whether a link has a sensor's orientation and, with `at_position`, its position."""
    T = (urdf.T_root(sensor.link) @ sensor.pose @ T_own).inverse() @ urdf.T_root(link)
    turned = np.abs(T.rotation() - np.eye(3)).max() < _TOLERANCE
    return bool(turned and (not at_position or np.abs(T.position).max() < _TOLERANCE))


def _carries_optical(joint: Joint) -> bool:
    difference = joint.T_parent_child.rotation() - T_BODY_OPTICAL.rotation()
    return joint.kind == "fixed" and bool(np.abs(difference).max() < _TOLERANCE)


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name)
