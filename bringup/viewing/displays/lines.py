"""Paths and polygons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arjuna_core.param import param
from bringup.viewing.displays.base import Display
from bringup.viewing.drawing.values import Parts


@dataclass(frozen=True)
class PathConfig:
    """Settings of a path."""

    color: tuple[int, int, int] = param((25, 255, 0), "Colour.")
    line_width: float = param(0.04, "Width.", unit="m", minimum=0.001, maximum=1.0)


class Path(Display):
    """A path; its width is of the screen, one pixel a centimetre."""

    types = ("nav_msgs/msg/Path",)
    topic = "plan"
    Config = PathConfig

    def take(self, message: Any) -> Parts:
        width = max(100.0 * self.config.line_width, 1.5)
        return self.usual(message, colour=self.config.color, width=width)


@dataclass(frozen=True)
class PolygonConfig:
    """Settings of a polygon."""

    color: tuple[int, int, int] = param((90, 90, 90), "Colour.")


class Polygon(Display):
    """A polygon's outline."""

    types = ("geometry_msgs/msg/PolygonStamped",)
    topic = "local_costmap/published_footprint"
    Config = PolygonConfig

    def take(self, message: Any) -> Parts:
        return self.usual(message, colour=self.config.color)
