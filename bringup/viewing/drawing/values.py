"""Drawings as plain values, each in a frame, at a time or as the frame moves; and their layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.pose3 import ORIGIN, Pose3

Colour = tuple[int, int, int]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Layer:
    """A part of the picture that can be shown or hidden; `shown` is whether it is at first."""

    label: str
    shown: bool = True


LAYERS = {
    "robot": Layer("Robot"),
    "map": Layer("Map"),
    "scan": Layer("Laser scan"),
    "global_costmap": Layer("Global costmap", shown=False),
    "local_costmap": Layer("Local costmap"),
    "particles": Layer("Particles and covariance"),
    "global_path": Layer("Global path"),
    "local_path": Layer("Local path"),
    "trajectories": Layer("Trajectories weighed", shown=False),
    "goals": Layer("Goals"),
    "people": Layer("People and boxes", shown=False),
    "axes": Layer("TF axes", shown=False),
    "camera": Layer("Camera", shown=False),
}
"""The layers, in the order of the panel."""


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """Something to draw.

    Attributes:
        frame: The frame it is in.
        stamp: The time at which it was there [s]; None where it moves with the frame.
        pose: Its pose in the frame.
    """

    frame: str
    stamp: float | None = None
    pose: Pose3 = ORIGIN


@dataclass(frozen=True, kw_only=True)
class Grid(Drawing):
    """A map, or a see-through costmap; `pose` is that of its lower-left corner.

    Attributes:
        opacity: Of the costs, 0 to 1; None for a map.
    """

    grid: OccupancyGrid
    opacity: float | None = None

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        frame = self.grid.frame
        return frame.width * frame.resolution, frame.height * frame.resolution


@dataclass(frozen=True, kw_only=True)
class Points(Drawing):
    """A cloud of points `(N, 3) float32` [m], each of a size [m]."""

    points: Floats
    colour: Colour
    size: float = 0.05


@dataclass(frozen=True, kw_only=True)
class Line(Drawing):
    """A line from point to point, `(N, 3) float32` [m]; its width is of the screen [pixels]."""

    points: Floats
    colour: Colour
    width: float = 3.0

    @property
    def segments(self) -> Floats:
        """The pieces between neighbours, `(N - 1, 2, 3) float32`."""
        return np.stack([self.points[:-1], self.points[1:]], axis=1)


@dataclass(frozen=True, kw_only=True)
class Arrows(Drawing):
    """Arrows `(N, 2, 3) float32` from tail to tip [m]; their width is that of the shafts [m]."""

    segments: Floats
    colour: Colour
    width: float = 0.06


@dataclass(frozen=True)
class Body:
    """A person, drawn round, or a box.

    Attributes:
        pose: Pose of the middle of its bounding box in the drawing's frame.
        size: Edges of its bounding box [m].
        colour: Red, green and blue, 0 to 255.
        person: Whether it is a person.
    """

    name: str
    pose: Pose3
    size: tuple[float, float, float]
    colour: Colour
    person: bool = False


@dataclass(frozen=True, kw_only=True)
class Bodies(Drawing):
    """Whatever stands and walks around the robot."""

    bodies: tuple[Body, ...] = ()
