"""The robot's outline on the ground."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np

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
        inscribed = float(_edge_distances(points).min())
        return Footprint(points, inscribed, farthest, circular=False)

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
        if self.circular:
            return self.scaled(max(1.0 + margin / self.inscribed_radius, least))
        middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2.0
        own = self.points - middle
        scale = max(1.0 + margin / float(_edge_distances(own).min()), least)
        return Footprint.polygon(middle + own * scale).driven_at(self.axle)

    def holds(self, points: Floats) -> Bools:
        """Return which points `(N, 2) float64` of the base frame [m] lie within the outline."""
        if self.circular:
            near: Bools = np.hypot(*points.T) <= self.circumscribed_radius
            return near
        return _inside(points, self.points)

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
        off = points - _closest(self.points, points)
        distances = np.hypot(*off.T)
        signs = np.where(self.holds(points), -1.0, 1.0)
        return signs * distances, off * (signs / np.maximum(distances, 1e-9))[:, None]

    def at(self, T_frame_base: SE2) -> Floats:
        """Return the corners with the robot at a pose, `(N, 2) float64` in the pose's frame [m]."""
        return T_frame_base.apply(self.points)


def _edge_distances(points: Floats) -> Floats:
    """Return the distance from the origin to each edge."""
    distances: Floats = np.hypot(*_on_edges(points, np.zeros((1, 2)))[0].T)
    return distances


def _closest(corners: Floats, points: Floats) -> Floats:
    """Return the point of the outline that is nearest to each point, `(N, 2)`."""
    on_edges = _on_edges(corners, points)
    nearest = np.hypot(*np.moveaxis(on_edges - points[:, None], -1, 0)).argmin(axis=1)
    closest: Floats = on_edges[np.arange(len(points)), nearest]
    return closest


def _on_edges(corners: Floats, points: Floats) -> Floats:
    """Return the point of each edge that is nearest to each point, `(N, edges, 2)`."""
    edges = np.roll(corners, -1, axis=0) - corners
    along = ((points[:, None] - corners) * edges).sum(axis=2)
    along = along / np.maximum(np.square(edges).sum(axis=1), 1e-12)
    on_edges: Floats = corners + np.clip(along, 0.0, 1.0)[..., None] * edges
    return on_edges


def _inside(points: Floats, corners: Floats) -> Bools:
    """Return from which points a ray crosses the outline an odd number of times."""
    x, y = points[:, :1], points[:, 1:]
    x0, y0 = corners.T
    x1, y1 = np.roll(corners, -1, axis=0).T
    spans = (y0 <= y) != (y1 <= y)
    slope = np.divide(x1 - x0, y1 - y0, out=np.zeros_like(x0), where=y1 != y0)
    crossed = spans & (x < x0 + (y - y0) * slope)
    odd: Bools = crossed.sum(axis=1) % 2 == 1
    return odd
