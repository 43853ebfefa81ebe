"""Hinges and slides on which a part of the world swings, such as a door."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Hinge:
    """One degree of freedom between an entity and the world.

    Attributes:
        slides: Whether it slides along the axis rather than turns about it.
        axis: In the entity's frame, a unit vector.
        anchor: A point of the axis in the entity's frame [m].
        limits: Least and greatest position [rad or m], None where unlimited.
        damping: Per speed [N m s/rad or N s/m].
        friction: Dry friction [N m or N].
    """

    slides: bool
    axis: tuple[float, float, float]
    anchor: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None
    damping: float = 0.0
    friction: float = 0.0
