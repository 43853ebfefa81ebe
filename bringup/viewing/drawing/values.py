"""Drawings as plain values, each in a frame, at a time or as the frame moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.pose3 import ORIGIN, Pose3

Colour = tuple[int, int, int]
Floats = NDArray[np.float32]
Colours = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """Something to draw.

    Attributes:
        frame: The frame it is in; empty for the one that everything is drawn in.
        stamp: The time at which it was there [s]; None where it moves with the frame.
        pose: Its pose in the frame.
    """

    frame: str = ""
    stamp: float | None = None
    pose: Pose3 = ORIGIN


Parts = Mapping[str, Drawing]
"""The drawings of one display by their names."""


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
    """A cloud of points `(N, 3) float32` [m], each of a size [m], of one colour or `(N, 3)`.

    Attributes:
        floor: Whether it is drawn on the floor, at the height of the fixed frame's plane.
    """

    points: Floats
    colour: Colour | Colours
    size: float = 0.05
    floor: bool = False


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
class Segments(Drawing):
    """Lines from point to point, `(N, 2, 3) float32` [m], with colours `(N, 2, 3)`; width [m]."""

    segments: Floats
    colours: Colours
    width: float


@dataclass(frozen=True, kw_only=True)
class Arrows(Drawing):
    """Arrows `(N, 2, 3) float32` from tail to tip [m]; their width is that of the shafts [m]."""

    segments: Floats
    colour: Colour
    width: float = 0.06


@dataclass(frozen=True, kw_only=True)
class Solids(Drawing):
    """Bodies of one shape, "box", "sphere", "cylinder", "cone" or "arrow".

    A shape fills a box with edges of 1 m; arrows and cones point along x, cylinders along z.

    Attributes:
        positions: `(N, 3)` [m].
        wxyzs: `(N, 4)`.
        sizes: Edges of the box around each, `(N, 3)` [m].
        colours: `(N, 3)`.
        opacities: `(N,)`, 0 to 1.
    """

    shape: str
    positions: Floats
    wxyzs: Floats
    sizes: Floats
    colours: Colours
    opacities: Floats


@dataclass(frozen=True, kw_only=True)
class Model(Drawing):
    """A body of triangles as binary glTF."""

    glb: bytes
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Label(Drawing):
    """Words that face the viewer, of a height [m], or of the screen's usual size for None."""

    text: str
    height: float | None = None


@dataclass(frozen=True, kw_only=True)
class Axes(Drawing):
    """Frames: positions `(N, 3)` [m], quaternions `(N, 4)` and the axes' length [m]."""

    positions: Floats
    wxyzs: Floats
    length: float = 0.25


@dataclass(frozen=True, kw_only=True)
class Picture(Drawing):
    """A camera's picture `(rows, columns, 3) uint8`, shown beside the room."""

    pixels: NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Values(Drawing):
    """Numbers of this moment, drawn as curves over time beside the room."""

    values: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Words(Drawing):
    """A text in Markdown, shown beside the room."""

    text: str
