"""Optical frames (REP 103): z ahead, x to the right and y down, in which pictures are told."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.joints import Joint
from arjuna_sim.model.urdf import Urdf

T_BODY_OPTICAL = Pose3.from_rpy((0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2))
"""An optical frame in a frame with x ahead and z up."""
_SUFFIX = "_optical_frame"
_ROTATION_TOLERANCE = 1e-3


@dataclass(frozen=True)
class OpticalFrame:
    """A camera's optical frame.

    Attributes:
        name: Its name.
        parent: The link that it is fixed to; None where it is a link of the robot itself.
    """

    name: str
    parent: str | None


def optical_frame(urdf: Urdf, link: str, frame: str) -> OpticalFrame:
    """Return the optical frame of a camera: one that the robot has, or else one to be added.

    Args:
        urdf: The robot.
        link: The link that the camera looks ahead from, along x.
        frame: The frame that the robot's file names; not optical as often as not.
    """
    if frame not in urdf.links:
        return OpticalFrame(frame if "optical" in frame else link + _SUFFIX, link)
    if _is_optical(urdf.T_root(link).inverse() @ urdf.T_root(frame)):
        return OpticalFrame(frame, None)
    for joint in urdf.joints.values():
        if _carries_optical(joint, frame):
            return OpticalFrame(joint.child, None)
    return OpticalFrame(frame + _SUFFIX, frame)


def _carries_optical(joint: Joint, frame: str) -> bool:
    return joint.kind == "fixed" and joint.parent == frame and _is_optical(joint.T_parent_child)


def _is_optical(T_body_frame: Pose3) -> bool:
    difference = T_body_frame.rotation() - T_BODY_OPTICAL.rotation()
    return bool(np.abs(difference).max() < _ROTATION_TOLERANCE)
