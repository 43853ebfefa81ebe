"""Paths and polygons."""

from __future__ import annotations

from typing import Any

from arjuna_core.param import param
from bringup.viewing.displays.base import PIXELS, Display, settings
from bringup.viewing.drawing.values import Parts


class Path(Display):
    """A path; its width is of the screen, one pixel a centimetre."""

    types = ("nav_msgs/msg/Path",)
    topic = "plan"
    Config = settings(
        color=param((25, 255, 0), "Colour."),
        line_width=param(0.04, "Width.", unit="m", minimum=0.001, maximum=1.0),
    )

    def take(self, message: Any) -> Parts:
        return self.usual(message, width=max(PIXELS * self.config.line_width, 1.5))


class Polygon(Display):
    """A polygon's outline."""

    types = ("geometry_msgs/msg/PolygonStamped",)
    topic = "local_costmap/published_footprint"
    Config = settings(color=param((90, 90, 90), "Colour."))
