"""Wheels as a robot's links and joints show them: where they stand and how large they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import RobotError
from arjuna_sim.model.joints import Joint
from arjuna_sim.model.shapes import Kind, corners
from arjuna_sim.model.urdf import Urdf

_ACROSS = 0.5  # least part of a wheel's axis along y: within 60 degrees of it
_ABREAST = 0.01  # along the robot, between wheels on one axle [m]


def axis(urdf: Urdf, joint: str) -> NDArray[np.float64]:
    """Return a joint's axis in the root's frame, `(3,) float64`."""
    turned: NDArray[np.float64] = urdf.T_root(urdf.joints[joint].child).rotation() @ np.array(
        urdf.joints[joint].axis
    )
    return turned


def wheel_sign(urdf: Urdf, joint: str) -> float:
    """Return +1 where positive turning drives forward, -1 where it drives backward.

    Raises:
        RobotError: The joint's axis does not lie across the robot.
    """
    across = float(axis(urdf, joint)[1])
    if abs(across) < _ACROSS:
        raise RobotError(
            urdf.path, "a wheel's axis must lie across the robot (y)", f"joint '{joint}'"
        )
    return 1.0 if across > 0.0 else -1.0


def center(urdf: Urdf, joint: str) -> NDArray[np.float64]:
    """Return where a wheel's shapes are centred in the root's frame, `(3,) float64` [m]."""
    child = urdf.joints[joint].child
    T_root_link, points = urdf.T_root(child), _points(urdf, urdf.joints[joint])
    middle = np.zeros(3) if len(points) == 0 else (points.min(axis=0) + points.max(axis=0)) / 2
    placed: NDArray[np.float64] = T_root_link.apply(middle[None])[0]
    return placed


def radius_of(urdf: Urdf, joint: str) -> float:
    """Return how far a wheel's shapes reach from its axis, 0 where it has none [m]."""
    link = urdf.links[urdf.joints[joint].child]
    round_ones = [
        part.shape.size[0]
        for part in link.collisions
        if part.shape.kind in (Kind.CYLINDER, Kind.SPHERE)
    ]
    if round_ones:
        return max(round_ones)
    points, unit = _points(urdf, urdf.joints[joint]), np.array(urdf.joints[joint].axis)
    if len(points) == 0:
        return 0.0
    points = points - (points.min(axis=0) + points.max(axis=0)) / 2
    across = points - np.outer(points @ unit, unit)
    return float(np.linalg.norm(across, axis=1).max())


def wheel_radius(urdf: Urdf, joints: tuple[str, ...]) -> float:
    """Return the largest radius of wheels, 0 where none has a shape [m]."""
    return max((radius_of(urdf, name) for name in joints), default=0.0)


def wheel_separation(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return the distance across between the mean left and the mean right wheel [m]."""
    y = {name: float(center(urdf, name)[1]) for name in left + right}
    return abs(sum(y[n] for n in left) / len(left) - sum(y[n] for n in right) / len(right))


def effective_track(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return the track of the two-wheeled robot that turns like this one on dry ground [m].

    Wheels off the axis of turning slip sideways: track * (1 + (wheelbase / track)^2) for four.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007;
    the closed form assumes point contacts that carry the same load.
    """
    track = wheel_separation(urdf, left, right)
    along = np.array([center(urdf, name)[0] for name in left + right])
    return track + 4.0 * float(np.var(along)) / track if track > 0.0 else 0.0


def turns_by_sliding(urdf: Urdf, joints: tuple[str, ...]) -> bool:
    """Return whether driven wheels stand one behind the other, so that some slide in a turn."""
    along = [float(center(urdf, name)[0]) for name in joints]
    return max(along, default=0.0) - min(along, default=0.0) > _ABREAST


def _points(urdf: Urdf, joint: Joint) -> NDArray[np.float64]:
    """Return the corners of a wheel's solid shapes, else of its drawn ones, in its link's frame."""
    link = urdf.links[joint.child]
    parts = link.collisions or link.visuals
    return np.vstack([np.zeros((0, 3)), *(p.pose.apply(corners(p.shape)) for p in parts)])
