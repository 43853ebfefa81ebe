"""People and boxes around the robot, from what a simulator says of its world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from arjuna_core.pose3 import Pose3
from bringup.viewing.drawing.values import Body, Colour

ROBOT, HUMAN = 1, 2
"""Categories of simulation_interfaces/EntityCategory."""
_COLOURS: dict[int, Colour] = {HUMAN: (235, 140, 60), 5: (150, 150, 160)}
_OTHER: Colour = (180, 140, 90)

Corner = tuple[float, float, float]


@dataclass(frozen=True)
class Kind:
    """What does not change of an entity.

    Attributes:
        category: One of simulation_interfaces/EntityCategory.
        low: Least corner of its bounding box, in its own frame [m].
        high: Greatest corner.
    """

    category: int
    low: Corner
    high: Corner


def bodies(
    kinds: Mapping[str, Kind], poses: Iterable[tuple[str, Pose3]]
) -> tuple[Body, ...] | None:
    """Return what stands around the robot, as seen from it.

    A simulator's world and a map need not have the same origin; the robot is in both.

    Args:
        kinds: What is known of the entities.
        poses: All entities' poses in the world.

    Returns:
        The bodies in the robot's frame; None where there is no robot.
    """
    placed = [(name, kinds[name], pose) for name, pose in poses if name in kinds]
    robots = [pose for _, kind, pose in placed if kind.category == ROBOT]
    if not robots:
        return None
    T_robot_world = robots[0].inverse()
    return tuple(
        _body(name, kind, T_robot_world @ pose)
        for name, kind, pose in placed
        if kind.category != ROBOT and kind.low != kind.high
    )


def _body(name: str, kind: Kind, pose: Pose3) -> Body:
    pairs = list(zip(kind.low, kind.high, strict=True))
    x, y, z = ((low + high) / 2.0 for low, high in pairs)
    dx, dy, dz = (high - low for low, high in pairs)
    middle = pose @ Pose3((x, y, z))
    colour = _COLOURS.get(kind.category, _OTHER)
    return Body(name, middle, (dx, dy, dz), colour, kind.category == HUMAN)
