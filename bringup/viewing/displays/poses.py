"""Paths, polygons and poses: one, many, with a covariance, and odometry's trail of them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from arjuna_core.param import angle_param, length_param, param
from arjuna_core.readings import se2_from_pose
from bringup.viewing.displays.base import PIXELS, Display
from bringup.viewing.drawing.messages import (
    arrows,
    belief,
    flat_points,
    frame_of,
    particles_from_cdr,
)
from bringup.viewing.drawing.values import Colour, Line, Parts


class Path(Display):
    """A path; its width is of the screen, one pixel a centimetre."""

    types = ("nav_msgs/msg/Path",)
    topic = "plan"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((25, 255, 0), "Colour.")
        line_width: float = length_param(0.04, "Width.", minimum=0.001, maximum=1.0)

    def take(self, message: Any) -> Parts:
        at = [each.pose.position for each in message.poses]
        points = flat_points(((p.x, p.y) for p in at), 0.05 if "local" in self.name else 0.03)
        style: dict[str, Any] = {"colour": self.config.color}
        style["width"] = max(PIXELS * self.config.line_width, 1.5)
        return {"": Line(frame=frame_of(message), points=points, **style)}


class Polygon(Display):
    """A polygon's outline."""

    types = ("geometry_msgs/msg/PolygonStamped",)
    topic = "local_costmap/published_footprint"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((90, 90, 90), "Colour.")

    def take(self, message: Any) -> Parts:
        points = flat_points(((p.x, p.y) for p in message.polygon.points), 0.05)
        closed = np.concatenate([points, points[:1]])
        colour = self.config.color
        return {"": Line(frame=frame_of(message), points=closed, colour=colour, width=2.0)}


class Pose(Display):
    """A pose as an arrow."""

    types = ("geometry_msgs/msg/PoseStamped",)
    topic = "goal_pose"

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((220, 40, 180), "Colour.")
        shaft_length: float = length_param(0.5, "Length.", minimum=0.01, maximum=10.0)

    def take(self, message: Any) -> Parts:
        row, config = se2_from_pose(message.pose).array()[None], self.config
        return {"": arrows(frame_of(message), row, config.color, config.shaft_length, 0.06, 0.06)}


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
        color, length = self.config.color, self.config.arrow_length
        return {"": arrows(frame_of(message), rows, color, length, 0.03, length / 8.0)}


class ParticleCloud(Display):
    """AMCL's particles."""

    types = ("nav2_msgs/msg/ParticleCloud",)
    topic, raw = "particle_cloud", True

    @dataclass(frozen=True)
    class Config:
        color: Colour = param((70, 170, 60), "Colour.")

    def take(self, message: Any) -> Parts:
        frame, rows = particles_from_cdr(message)
        return {"": arrows(frame.lstrip("/"), rows, self.config.color, 0.12, 0.03, 0.015)}


class PoseWithCovariance(Display):
    """A pose with the ellipse of two sigmas around it."""

    types = ("geometry_msgs/msg/PoseWithCovarianceStamped",)
    topic, latched = "amcl_pose", True
    Config = PoseArray.Config

    def take(self, message: Any) -> Parts:
        return {"": belief(frame_of(message), message.pose, self.config.color)}


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
        parts: dict[str, Any] = {"": arrows(frame, rows, config.color, 0.3, 0.04, 0.03)}
        if config.covariance:
            parts["covariance"] = belief(frame, message.pose, config.color)
        return parts
