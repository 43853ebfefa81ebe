"""The robot's outline on the ground."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numba import njit

from arjuna_core.arrays import Bools, Floats
from arjuna_core.errors import ConfigError
from arjuna_core.ros.health.rules import OUTLINE
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity

_CIRCLE_CORNERS = 16  # what Nav2 publishes for a radius
_POINT = 1e-3  # a robot without size [m]
_OUTER = re.compile(r"\s*(?:\[((?:[\s,]*\[[^\[\]]*\])*)[\s,]*\])?\s*")
_INNER, _SPACE = re.compile(r"\[([^\[\]]*)\]"), re.compile(r"[\s,]+")


@dataclass(frozen=True, eq=False)
class Footprint:
    """A circle or a polygon round the base frame's origin, padding included.

    Attributes:
        points: Corners in the base frame, `(N, 2) float64` [m], in order.
        inscribed_radius: Distance from the origin to the nearest edge [m].
        circumscribed_radius: Distance from the origin to the farthest corner [m].
        circular: Whether the outline is a circle, so that its heading does not matter.
        axle: Where along x the point is that moves along the heading [m]; the radii hold for both
            points.
    """

    points: Floats
    inscribed_radius: float
    circumscribed_radius: float
    circular: bool
    axle: float = 0.0

    @staticmethod
    def circle(radius: float, padding: float = 0.0) -> Footprint:
        """Return a circle of `radius + padding` [m]."""
        total = radius + padding
        if not total > 0.0:
            raise ConfigError(f"robot_radius + footprint_padding must be positive, got {total}")
        angles = np.arange(_CIRCLE_CORNERS) * (2.0 * math.pi / _CIRCLE_CORNERS)
        points = total * np.column_stack((np.cos(angles), np.sin(angles)))
        return Footprint(points, total, total, circular=True)

    @staticmethod
    def polygon(corners: Floats, padding: float = 0.0) -> Footprint:
        """Return a polygon whose corners are moved outwards by `padding` in x and in y [m].

        Raises:
            ConfigError: There are fewer than three corners, or one lies too far away.
        """
        corners = np.asarray(corners, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
            raise ConfigError("a footprint needs at least three corners [x, y]")
        if not np.isfinite(corners).all():
            raise ConfigError(f"a footprint's corners must be finite, got {corners.tolist()}")
        points = corners + padding * np.sign(corners)
        farthest = float(np.hypot(*points.T).max())
        if farthest > OUTLINE:
            raise ConfigError(f"a footprint reaches {farthest:.4g} m; valid: up to {OUTLINE:g} m")
        return Footprint(points, _inscribed(points), farthest, circular=False)

    @staticmethod
    def parse(text: str, robot_radius: float, padding: float, axle: float = 0.0) -> Footprint:
        """Return what the parameters `footprint`, `robot_radius`, `footprint_padding` describe.

        Args:
            text: `"[[x, y], ...]"` [m], or `"[]"` for a circle; commas may be left out, as in Nav2.
            robot_radius: Radius of the circle [m].
            padding: What to add outwards [m].
            axle: As the attribute.

        Raises:
            ConfigError: The text is no list of three or more corners.
        """
        outer = _OUTER.fullmatch(text)
        try:
            if outer is None:
                raise ValueError(text)
            inner = _INNER.findall(outer[1] or "")
            array = np.array([_SPACE.split(each.strip(" \t\n,")) for each in inner], np.float64)
        except ValueError as error:
            problem = f"footprint {text!r} is invalid; valid: '[[x, y], [x, y], [x, y], ...]'"
            raise ConfigError(problem) from error
        if array.size == 0:
            return Footprint.circle(max(robot_radius + padding, _POINT)).driven_at(axle)
        return Footprint.polygon(array, padding).driven_at(axle)

    def driven_at(self, axle: float) -> Footprint:
        """Return the outline of a robot that moves along its heading at another point."""
        if not axle:
            return self
        seen = Footprint.polygon(self.points - (axle, 0.0))
        inner = min(self.inscribed_radius, seen.inscribed_radius)
        outer = max(self.circumscribed_radius, seen.circumscribed_radius)
        return Footprint(self.points, inner, outer, circular=False, axle=axle)

    @property
    def of_axle(self) -> Footprint:
        """The outline seen from the point that moves along the heading."""
        return replace(self, points=self.points - (self.axle, 0.0), axle=0.0)

    def base_velocity(self, velocity: Velocity) -> Velocity:
        """Return how the base moves where a velocity is commanded that is the axle's."""
        side = velocity.y - self.axle * velocity.yaw_rate
        return replace(velocity, y=side) if self.axle else velocity

    def without(self, padding: float) -> Footprint:
        """Return the outline with its padding taken off again [m]."""
        if self.circular:
            return Footprint.circle(max(self.inscribed_radius - padding, _POINT))
        return Footprint.polygon(self.points, -padding).driven_at(self.axle)

    def scaled(self, scale: float) -> Footprint:
        """Return the outline larger or smaller by a factor."""
        inscribed, circumscribed = self.inscribed_radius * scale, self.circumscribed_radius * scale
        return replace(
            self,
            points=self.points * scale,
            inscribed_radius=inscribed,
            circumscribed_radius=circumscribed,
        )

    def widened(self, margin: float, least: float = 0.0) -> Footprint:
        """Return the outline wider by a margin, by more where it is long; narrower below 0 [m].

        It grows about its own middle, for the base may be at its edge.

        Args:
            least: The part of its size that is left.
        """
        return _widened(self, margin, least)

    def holds(self, points: Floats) -> Bools:
        """Return which points `(N, 2) float64` of the base frame [m] lie within the outline."""
        if self.circular:
            near: Bools = np.hypot(*points.T) <= self.circumscribed_radius
            return near
        inside: Bools = _inside(self.points, points)
        return inside

    def outreach(self, body: Footprint, rounding: float = 1e-3) -> float:
        """Return how far the corners of a body stand out of the outline [m], 0 for none."""
        farthest = float(self.gaps(body.points)[0].max())
        return farthest if farthest > rounding else 0.0

    def gaps(self, points: Floats) -> tuple[Floats, Floats]:
        """Return how far points `(N, 2) float64` of the base frame lie outside the outline [m].

        Returns:
            The distances `(N,)`, below 0 within, and the directions away from it, `(N, 2)`.
        """
        if self.circular:
            distances = np.hypot(*points.T)
            away = points / np.maximum(distances, 1e-9)[:, None]
            return distances - self.circumscribed_radius, away
        off = _off(self.points, points)
        distances = np.hypot(*off.T)
        signs = np.where(self.holds(points), -1.0, 1.0)
        return signs * distances, off * (signs / np.maximum(distances, 1e-9))[:, None]

    def at(self, T_frame_base: SE2) -> Floats:
        """Return the corners with the robot at a pose, `(N, 2) float64` in the pose's frame [m]."""
        return T_frame_base.apply(self.points)


@lru_cache(maxsize=64)
def _widened(outline: Footprint, margin: float, least: float) -> Footprint:
    if outline.circular:
        return outline.scaled(max(1.0 + margin / outline.inscribed_radius, least))
    middle = (outline.points.min(axis=0) + outline.points.max(axis=0)) / 2.0
    own = outline.points - middle
    scale = max(1.0 + margin / _inscribed(own), least)
    return Footprint.polygon(middle + own * scale).driven_at(outline.axle)


def _inscribed(corners: Floats) -> float:
    return float(np.hypot(*_off(corners, np.zeros((1, 2)))[0]))


@njit(cache=True)
def _off(corners: Floats, points: Floats) -> Floats:
    """Return the way to each point from the point of the outline nearest to it, `(N, 2)`."""
    off = np.empty(points.shape)
    for i in range(len(points)):
        least = np.inf
        for k in range(len(corners)):
            (x0, y0), (x1, y1) = corners[k - 1], corners[k]
            along = (points[i, 0] - x0) * (x1 - x0) + (points[i, 1] - y0) * (y1 - y0)
            along /= max((x1 - x0) ** 2 + (y1 - y0) ** 2, 1e-12)
            along = min(max(along, 0.0), 1.0)
            x = points[i, 0] - (x0 + along * (x1 - x0))
            y = points[i, 1] - (y0 + along * (y1 - y0))
            if x * x + y * y < least:
                least = x * x + y * y
                off[i, 0], off[i, 1] = x, y
    return off


@njit(cache=True)
def _inside(corners: Floats, points: Floats) -> Bools:
    """Return from which points a ray crosses the outline an odd number of times."""
    odd = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        for k in range(len(corners)):
            (x0, y0), (x1, y1) = corners[k - 1], corners[k]
            if (y0 <= points[i, 1]) != (y1 <= points[i, 1]):
                odd[i] ^= points[i, 0] < x0 + (points[i, 1] - y0) * ((x1 - x0) / (y1 - y0))
    return odd
