"""Paths, polygons and poses: one, many, with a covariance, and odometry's trail of them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from arjuna_core.param import angle_param, length_param, param
from arjuna_core.readings import se2_from_pose
from bringup.viewing.displays.base import PIXELS, Display
from bringup.viewing.drawing.messages import DRAWN, arrow_segments, frame_of
from bringup.viewing.drawing.values import Arrows, Colour, Line, Parts


class Path(Display):
    """A path; its width is of the screen, one pixel a centimetre."""

    types = ("nav_msgs/msg/Path",)
    topic = "plan"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((25, 255, 0), "Colour.")
        line_width: float = length_param(0.04, "Width.", minimum=0.001, maximum=1.0)

    def take(self, message: Any) -> Parts:
        return self.usual(message, width=max(PIXELS * self.config.line_width, 1.5))


class Polygon(Display):
    """A polygon's outline."""

    types = ("geometry_msgs/msg/PolygonStamped",)
    topic = "local_costmap/published_footprint"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((90, 90, 90), "Colour.")


_WITH_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"


class Pose(Display):
    """A pose as an arrow."""

    types = ("geometry_msgs/msg/PoseStamped",)
    topic = "goal_pose"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((220, 40, 180), "Colour.")
        shaft_length: float = length_param(0.5, "Length.", minimum=0.01, maximum=10.0)

    def take(self, message: Any) -> Parts:
        row = se2_from_pose(message.pose).array()[None]
        segments = arrow_segments(row, self.config.shaft_length, 0.06)
        return {"": Arrows(frame=frame_of(message), segments=segments, colour=self.config.color)}


class PoseArray(Display):
    """Poses as arrows."""

    types = ("geometry_msgs/msg/PoseArray",)
    topic = "poses"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((150, 60, 200), "Colour.")
        arrow_length: float = length_param(0.2, "Length.", minimum=0.01, maximum=10.0)

    def take(self, message: Any) -> Parts:
        rows = np.array([se2_from_pose(each).array() for each in message.poses]).reshape(-1, 3)
        length = self.config.arrow_length
        segments = arrow_segments(rows, length, 0.03)
        style: dict[str, Any] = {"colour": self.config.color, "width": length / 8.0}
        return {"": Arrows(frame=frame_of(message), segments=segments, **style)}


class ParticleCloud(Display):
    """AMCL's particles."""

    types = ("nav2_msgs/msg/ParticleCloud",)
    topic, raw = "particle_cloud", True

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((70, 170, 60), "Colour.")


class PoseWithCovariance(Display):
    """A pose with the ellipse of two sigmas around it."""

    types = (_WITH_COVARIANCE,)
    topic, latched = "amcl_pose", True
    Config = PoseArray.Config


class Odometry(Display):
    """Odometry's last poses as arrows."""

    types = ("nav_msgs/msg/Odometry",)
    topic = "odom"

    @dataclass(frozen=True)
    class Config:
        keep: int = param(100, "Arrows that stay.", minimum=1, maximum=1000)
        position_tolerance: float = length_param(0.1, "Way to the next one.")
        angle_tolerance: float = angle_param(0.1, "Turn to the next one.")
        color: Colour = param((255, 25, 0), "Colour.")
        covariance: bool = param(False, "Draw the ellipse of two sigmas.")

    def __init__(self, config: Any, topic: str) -> None:
        super().__init__(config, topic)
        self._kept: deque[Any] = deque(maxlen=config.keep)

    def take(self, message: Any) -> Parts:
        pose, config, frame = se2_from_pose(message.pose.pose), self.config, frame_of(message)
        last = self._kept[-1] if self._kept else None
        if (
            last is None
            or last.distance(pose) > config.position_tolerance
            or abs((last.inverse() @ pose).theta) > config.angle_tolerance
        ):
            self._kept.append(pose)
        rows = np.array([each.array() for each in (*self._kept, pose)])
        segments = arrow_segments(rows, 0.3, 0.04)
        parts: dict[str, Any] = {
            "": Arrows(frame=frame, segments=segments, colour=config.color, width=0.03)
        }
        if config.covariance:
            stamped = SimpleNamespace(header=message.header, pose=message.pose)
            ellipse = DRAWN[_WITH_COVARIANCE](self.name, stamped)
            assert isinstance(ellipse, Line)
            parts["covariance"] = replace(ellipse, colour=config.color)
        return parts
