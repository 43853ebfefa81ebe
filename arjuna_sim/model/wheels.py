"""Wheels as a robot's links and joints show them: where they stand and how large they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import RobotError
from arjuna_sim.model.geometry.shapes import Kind, points_of
from arjuna_sim.model.urdf import Joint, Mimic, Urdf

CASTER_GAP_MAX = 0.008
"""Greatest height of a caster above the ground that its robot stands on [m]."""
_ACROSS = 0.9  # least part across the robot of an axle on which a wheel rolls along
_UPRIGHT = 0.7  # least part along z of the axis of a joint that steers
_ROUNDS, _STICKS = 100, 1e-6  # of the search for how wheels slip, and what is no slip [m/s]


def axis(urdf: Urdf, joint: str) -> Floats:
    """Return a joint's axis in the root's frame, `(3,) float64`."""
    turned: Floats = urdf.T_root(urdf.joints[joint].child).rotation() @ np.array(
        urdf.joints[joint].axis
    )
    return turned


def is_upright(urdf: Urdf, joint: str) -> bool:
    """Return whether a joint turns about the vertical, or nearly."""
    return abs(float(axis(urdf, joint)[2])) > _UPRIGHT


def wheel_sign(urdf: Urdf, joint: str) -> float:
    """Return +1 where positive turning drives forward, -1 where it drives backward.

    Raises:
        RobotError: The joint's axis does not lie across the robot.
    """
    toward = axis(urdf, joint)
    # A wheel's axis is within 60 degrees of y.
    if abs(toward[1]) < 0.5:
        why = (
            " (a joint without <axis> has x)" if urdf.joints[joint].axis == (1.0, 0.0, 0.0) else ""
        )
        x, y, z = (toward.round(2) + 0.0).tolist()
        problem = f"a wheel's axis must lie across the robot (y){why}, and not along"
        problem += f" ({x:g}, {y:g}, {z:g}) as by its <origin> and <axis>"
        raise RobotError(urdf.path, problem, f"joint '{joint}'")
    return 1.0 if toward[1] > 0.0 else -1.0


def rolling_direction(urdf: Urdf, joint: str) -> Floats:
    """Return the unit vector along which positive turning rolls a wheel, `(2,) float64`."""
    x, y, _ = axis(urdf, joint).tolist()
    along = np.array([y, -x])
    unit: Floats = along / max(float(np.linalg.norm(along)), 1e-12)
    return unit


def with_followers(urdf: Urdf, joints: tuple[str, ...]) -> tuple[str, ...]:
    """Return joints and those that mimic them, which alone stand for one that moves nothing solid.

    Such as a virtual wheel in the middle of an axle, which the wheels at its ends mimic.
    """
    found: list[str] = []
    for name in joints:
        own = [
            joint.name
            for joint in urdf.joints.values()
            if joint.mimic and joint.mimic.joint == name and joint.mimic.multiplier > 0.0
        ]
        solid = any(_is_solid(urdf, follower) for follower in own)
        found += own if solid and not _is_solid(urdf, name) else [name, *own]
    return tuple(dict.fromkeys(found))


def _is_solid(urdf: Urdf, joint: str) -> bool:
    """Return whether a joint moves anything that has solid shapes."""
    link = urdf.joints[joint].child
    below = [joint.name for joint in urdf.joints.values() if joint.parent == link]
    return bool(urdf.links[link].collisions) or any(_is_solid(urdf, each) for each in below)


def idle_wheels(urdf: Urdf) -> tuple[str, ...]:
    """Return the joints of what is round and turns freely across the robot, driven or not."""
    return tuple(
        joint.name
        for joint in urdf.joints.values()
        if joint.kind == "continuous" and abs(axis(urdf, joint.name)[1]) > _ACROSS
        if radius_of(urdf, joint.name)
    )


def freed(urdf: Urdf, joints: tuple[str, ...]) -> Urdf:
    """Return a robot of whose joints some, which motors turn, mimic none: what led them follows.

    That resists nothing, so that motors of both sides start alike.
    """
    found = dict(urdf.joints)
    for name in joints:
        mimic = found[name].mimic
        if mimic is None:
            continue
        found[name] = replace(found[name], mimic=None)
        led = found[mimic.joint]
        if mimic.joint not in joints and led.mimic is None and mimic.multiplier:
            back = Mimic(name, 1.0 / mimic.multiplier, -mimic.offset / mimic.multiplier)
            found[mimic.joint] = replace(led, mimic=back, damping=0.0, friction=0.0)
    return replace(urdf, joints=found)


def unlimited(urdf: Urdf, joints: tuple[str, ...]) -> Urdf:
    """Return a robot of whose joints some turn at any speed."""
    found = {name: replace(urdf.joints[name], max_speed=0.0) for name in joints}
    return replace(urdf, joints={**urdf.joints, **found})


def steered_by(urdf: Urdf, joint: str, steering: tuple[str, ...]) -> int:
    """Return the index of the steering joint that carries a wheel's joint, -1 for none."""
    above = (each.name for each in urdf.above(urdf.joints[joint].parent))
    return next((steering.index(name) for name in above if name in steering), -1)


def center(urdf: Urdf, joint: str) -> Floats:
    """Return where a wheel's shapes are centred in the root's frame, `(3,) float64` [m]."""
    T_root_link, unit = urdf.T_root(urdf.joints[joint].child), np.array(urdf.joints[joint].axis)
    middle = _middle(urdf, joint)
    if is_round(urdf, joint):  # corners of a mesh are not quite on a circle
        middle = unit * float(middle @ unit)
    placed: Floats = T_root_link.apply(middle[None])[0]
    return placed


def eccentricity(urdf: Urdf, joint: str) -> float:
    """Return how far the middle of a wheel's shapes is from the axis on which it turns [m]."""
    middle, unit = _middle(urdf, joint), np.array(urdf.joints[joint].axis)
    return float(np.linalg.norm(middle - unit * float(middle @ unit)))


def _middle(urdf: Urdf, joint: str) -> Floats:
    points = _points(urdf, urdf.joints[joint])
    if len(points) == 0:
        return np.zeros(3)
    middle: Floats = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle


def is_round(urdf: Urdf, joint: str) -> bool:
    """Return whether a wheel turns about its middle."""
    # The middle of a wheel's shapes lies within 5 % of the radius of its axis.
    return eccentricity(urdf, joint) <= 0.05 * radius_of(urdf, joint)


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


def width_of(urdf: Urdf, joint: str) -> float:
    """Return how far a wheel's shapes reach along its axis, 0 where it has none [m]."""
    points, unit = _points(urdf, urdf.joints[joint]), np.array(urdf.joints[joint].axis)
    return float(np.ptp(points @ unit)) if len(points) > 0 else 0.0


def wheel_radius(urdf: Urdf, joints: tuple[str, ...]) -> float:
    """Return the largest radius of wheels, 0 where none has a shape [m]."""
    return max((radius_of(urdf, name) for name in joints), default=0.0)


def wheel_separation(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return the distance across between the mean left and the mean right wheel [m]."""
    y = {name: float(center(urdf, name)[1]) for name in left + right}
    return abs(sum(y[n] for n in left) / len(left) - sum(y[n] for n in right) / len(right))


def span(urdf: Urdf, joints: tuple[str, ...]) -> float:
    """Return the width of what wheels without sides stand on, at least their radius [m]."""
    points = np.array([center(urdf, name)[:2] for name in joints])
    return max(2.0 * float(np.linalg.norm(points, axis=1).max()), wheel_radius(urdf, joints))


def effective_track(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return the track of the two-wheeled robot that turns like this one on dry ground [m].

    Wheels off the axis of turning slip sideways. By Coulomb's law they slip so that friction takes
    the least power. Four wheels under the same load have track * (1 + (wheelbase / track)^2).

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007,
    for what is found; Goyal, Ruina and Papadopoulos, Planar sliding with dry friction, Wear 143,
    1991, for the principle.
    """
    if wheel_separation(urdf, left, right) == 0.0:
        return 0.0
    turning = _turned(urdf, left, right)[2]
    return 2.0 / turning if turning > 0.0 else wheel_separation(urdf, left, right)


def turning_point(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> float:
    """Return where along x of the root wheels of two sides turn a robot about [m].

    It is the line of two wheels; of more, which slip as for `effective_track`, it is nearer to
    those that carry more.
    """
    if not left or not right or wheel_separation(urdf, left, right) == 0.0:
        return float(np.mean([center(urdf, name)[0] for name in left + right] or [0.0]))
    _, side, turning = _turned(urdf, left, right)
    return -side / turning


def _turned(urdf: Urdf, left: tuple[str, ...], right: tuple[str, ...]) -> tuple[float, ...]:
    """Return how a robot moves whose sides' rims move apart at 1 m/s: vx, vy, w."""
    points = np.array([center(urdf, name)[:2] for name in left + right])
    rims = np.array([-1.0] * len(left) + [1.0] * len(right))
    return _turning(points, _loads(urdf, points), rims)


def _loads(urdf: Urdf, points: Floats) -> Floats:
    """Return the share of the weight that each wheel carries on equal tyres, `(W,) float64`."""
    masses = [(link.name, link.inertial) for link in urdf.links.values() if link.inertial]
    total = sum(inertial.mass for _, inertial in masses)
    if not total > 0.0:
        return np.full(len(points), 1.0 / len(points))
    middle = sum(
        (i.mass / total * urdf.T_root(n).apply(np.array([i.center]))[0] for n, i in masses),
        np.zeros(3),
    )
    levers = np.column_stack((np.ones(len(points)), points))
    loads = np.linalg.pinv(levers.T) @ np.array([1.0, middle[0], middle[1]])
    positive: Floats = np.maximum(loads, 0.0)
    return positive


def _turning(points: Floats, loads: Floats, rims: Floats) -> tuple[float, ...]:
    """Return the motion [m/s, m/s, rad/s] of a robot whose rims move at a speed each [m/s].

    Least squares, weighted by the slip, find the least sum of load times slip (Weiszfeld).
    """
    count = len(points)
    motion = np.zeros((2 * count, 3))  # slip of each wheel, along and across, by vx, vy and w
    motion[:count, 0], motion[:count, 2] = 1.0, -points[:, 1]
    motion[count:, 1], motion[count:, 2] = 1.0, points[:, 0]
    wanted = np.concatenate((rims, np.zeros(count)))
    slip = np.ones(count, np.float64)
    found = np.zeros(3, np.float64)
    for _ in range(_ROUNDS):
        weight = np.sqrt(np.tile(loads / slip, 2))
        found[:] = np.linalg.lstsq(motion * weight[:, None], wanted * weight, rcond=None)[0]
        rest = (motion @ found - wanted).reshape(2, count)
        slip[:] = np.maximum(np.hypot(rest[0], rest[1]), _STICKS)
    return tuple(found.tolist())


def _points(urdf: Urdf, joint: Joint) -> Floats:
    """Return the corners of a wheel's solid shapes, else of its drawn ones, in its link's frame."""
    link = urdf.links[joint.child]
    return points_of(link.collisions or link.visuals)
