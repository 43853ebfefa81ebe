"""Robots that are wheels on a base, made without a file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.geometry.shapes import Inertial, Kind, Part, Shape
from arjuna_sim.model.urdf import Joint, Link, Urdf

ALONG_Y = Pose3.from_rpy((0.0, 0.0, 0.0), (-math.pi / 2, 0.0, 0.0))  # of what lies along z
TYRE = Part(Shape(Kind.CYLINDER, (0.1, 0.04)), ALONG_Y)
ACROSS = (0.0, 1.0, 0.0)
NAMES = ("a", "b", "c", "d", "e", "f")


def weight(mass: float, center: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Inertial:
    """Return mass properties whose inertia does not matter."""
    return Inertial(mass, center, np.eye(3))


def wheeled(
    positions: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0),),
    parts: tuple[Part, ...] = (TYRE,),
    along: tuple[float, float, float] = ACROSS,
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0),
    base: Inertial | None = None,
    wheel: Inertial | None = None,
    names: Sequence[str] = NAMES,
) -> Urdf:
    """Return a robot with wheels `a`, `b`, ... at positions on its link `base`."""
    names = names[: len(positions)]
    links = {"base": Link("base", base, (), ())}
    links |= {name: Link(name, wheel, parts, ()) for name in names}
    poses = [Pose3.from_rpy((x, y, z), rpy) for x, y, z in positions]
    joints = {
        name: Joint(name, "continuous", "base", name, T, along)
        for name, T in zip(names, poses, strict=True)
    }
    return Urdf(Path("r.urdf"), "r", "", "base", links, joints)
