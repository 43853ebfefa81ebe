"""What can be drawn, as plain values: each is placed in a frame, at a time or as it moves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3

Colour = tuple[int, int, int]


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """Something to draw.

    Attributes:
        frame: The frame it is in.
        stamp: The time [s] at which it was there; None where it moves with the frame.
        pose: Its pose in the frame.
    """

    frame: str
    stamp: float | None = None
    pose: Pose3 = ORIGIN


@dataclass(frozen=True, kw_only=True)
class Picture(Drawing):
    """A picture of the ground, below all else.

    Attributes:
        glb: A textured rectangle as binary glTF, from the origin on.
        size: Its width and height [m].
    """

    glb: bytes
    size: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Overlay(Drawing):
    """A see-through picture that lies over the ground, in the middle of its place.

    Attributes:
        pixels: `(rows, columns, 4) uint8`, red, green, blue and opacity, the lowest row first.
        size: Its width and height [m].
    """

    pixels: NDArray[np.uint8]
    size: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Points(Drawing):
    """A cloud of points.

    Attributes:
        points: `(N, 3) float32` [m].
        colour: Red, green and blue, 0 to 255.
        size: Their size [m].
    """

    points: NDArray[np.float32]
    colour: Colour
    size: float


@dataclass(frozen=True, kw_only=True)
class Lines(Drawing):
    """Line segments.

    Attributes:
        segments: `(N, 2, 3) float32`, start and end [m].
        colour: Red, green and blue, 0 to 255.
        width: Their width on the screen [pixels].
    """

    segments: NDArray[np.float32]
    colour: Colour
    width: float = 3.0


@dataclass(frozen=True, kw_only=True)
class Arrows(Drawing):
    """Arrows.

    Attributes:
        segments: `(N, 2, 3) float32`, tail and tip [m].
        colour: Red, green and blue, 0 to 255.
        width: Diameter of their shafts [m].
    """

    segments: NDArray[np.float32]
    colour: Colour
    width: float = 0.06


@dataclass(frozen=True)
class Body:
    """A person or a box.

    Attributes:
        name: Its name.
        pose: Where the middle of its bounding box is, in the drawing's frame.
        size: Edges of its bounding box [m].
        colour: Red, green and blue, 0 to 255.
        person: Whether it is drawn round.
    """

    name: str
    pose: Pose3
    size: tuple[float, float, float]
    colour: Colour
    person: bool = False


@dataclass(frozen=True, kw_only=True)
class Bodies(Drawing):
    """What stands and walks around the robot."""

    bodies: tuple[Body, ...] = field(default_factory=tuple)
