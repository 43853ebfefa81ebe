"""The filters of laser_filters, each a dataclass of its parameters that makes a sweep of a sweep.

Source: the package laser_filters, branch ros2, whose parameters and results these are.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from arjuna_core.arrays import Bools, Floats
from arjuna_core.config import fixed, length_param, param
from arjuna_core.errors import ConfigError
from arjuna_sim.processing.sweep import ArrayFilter, Mounted, ScanFilter, Sweep


@dataclass(frozen=True)
class RangeFilter:
    """Replaces ranges outside of two limits."""

    lower_threshold: float = param(0.0, "Ranges up to it are replaced.", unit="m")
    upper_threshold: float = param(100000.0, "Ranges from it on are replaced.", unit="m")
    use_message_range_limits: bool = param(False, "Whether the scan's own limits hold.")
    lower_replacement_value: float | None = param(
        None, "In place of too short ones; NaN if none.", minimum=-math.inf, maximum=math.inf
    )
    upper_replacement_value: float | None = param(
        None, "In place of too long ones; NaN if none.", minimum=-math.inf, maximum=math.inf
    )

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep with what is too short or too long replaced."""
        low, high = self.lower_threshold, self.upper_threshold
        if self.use_message_range_limits:
            low, high = sweep.range_min, sweep.range_max
        short, long = sweep.ranges <= low, sweep.ranges >= high
        sweep = sweep.replaced(short, _or_nan(self.lower_replacement_value))
        return sweep.replaced(long & ~short, _or_nan(self.upper_replacement_value))


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


@dataclass(frozen=True)
class AngularBounds:
    """Keeps the beams between two bearings; the scan becomes shorter."""

    lower_angle: float = param(-math.pi, "Least bearing that is kept.", unit="rad")
    upper_angle: float = param(math.pi, "Greatest bearing that is kept.", unit="rad")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the beams within."""
        kept = (sweep.angles >= self.lower_angle) & (sweep.angles <= self.upper_angle)
        found = np.flatnonzero(kept)
        return sweep.cut(found[0], found[-1] + 1) if len(found) else sweep.cut(0, 0)


@dataclass(frozen=True)
class AngularGap:
    """Puts the beams between two bearings beyond the greatest range, or to NaN."""

    lower_angle: float = param(0.0, "Bearing after which beams are removed.", unit="rad")
    upper_angle: float = param(0.0, "Bearing before which they are removed.", unit="rad")
    replace_with_nan: bool = param(False, "Whether they become NaN instead.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the beams within."""
        within = (sweep.angles > self.lower_angle) & (sweep.angles < self.upper_angle)
        sweep = replace(sweep, intensities=sweep.intensities * ~within[: len(sweep.intensities)])
        return sweep.replaced(within, math.nan if self.replace_with_nan else sweep.range_max + 1.0)


@dataclass(frozen=True)
class Box:
    """Removes points in a box."""

    box_frame: str = fixed("base_link", "Frame of the box.")
    min_x: float = param(0.0, "Its least x.", unit="m")
    max_x: float = param(0.0, "Its greatest x.", unit="m")
    min_y: float = param(0.0, "Its least y.", unit="m")
    max_y: float = param(0.0, "Its greatest y.", unit="m")
    min_z: float = param(-1e3, "Its least z.", unit="m")
    max_z: float = param(1e3, "Its greatest z.", unit="m")
    invert: bool = param(False, "Whether points outside are removed instead.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the points in the box."""
        low = np.array((self.min_x, self.min_y, self.min_z))
        high = np.array((self.max_x, self.max_y, self.max_z))
        points = sweep.points(mounted(self.box_frame))
        within = ((points >= low) & (points <= high)).all(axis=1)
        return sweep.replaced(within != self.invert)


@dataclass(frozen=True)
class PolygonOutline:
    """Removes points in a polygon."""

    polygon: str = fixed("[]", "Its corners, as [[x, y], [x, y], ...] [m].")
    polygon_frame: str = fixed("base_link", "Frame of the polygon.")
    polygon_padding: float = param(0.0, "What a corner is moved away from both axes.", unit="m")
    invert: bool = param(False, "Whether points outside are removed instead.")

    def __post_init__(self) -> None:
        self.corners()

    def corners(self) -> Floats:
        """Return the corners, `(N, 2)` [m].

        Raises:
            ConfigError: The text has another form.
        """
        try:
            found = np.array(json.loads(self.polygon), dtype=np.float64).reshape(-1, 2)
        except (ValueError, TypeError, RecursionError) as error:
            problem = f"'polygon' is {self.polygon!r}; valid: [[x, y], [x, y], [x, y], ...]"
            raise ConfigError(problem) from error
        return found + np.sign(found) * self.polygon_padding

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the points in the polygon."""
        points = sweep.points(mounted(self.polygon_frame))[:, :2]
        return sweep.replaced(_inside(points, self.corners()) != self.invert)


def _inside(points: Floats, corners: Floats) -> Bools:
    """Return which points an odd number of edges is to the right of."""
    within = np.zeros(len(points), bool)
    x, y = points.T
    for (x1, y1), (x2, y2) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y1 != y2:
            crossing = x1 + (y - y1) * (x2 - x1) / (y2 - y1)
            within ^= ((y1 > y) != (y2 > y)) & (x < crossing)
    return within


@dataclass(frozen=True)
class Footprint:
    """Puts points within a square about the robot beyond the greatest range."""

    inscribed_radius: float = length_param(0.0, "Half the edge of the square.")
    base_frame: str = fixed("base_link", "Frame of the robot.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the robot's own points."""
        points = sweep.points(mounted(self.base_frame))[:, :2]
        within: Bools = np.all(np.abs(points) <= self.inscribed_radius, axis=1)
        return sweep.replaced(within, sweep.range_max + 1.0)


@dataclass(frozen=True)
class Sector:
    """Puts the returns of a sector beyond the greatest range."""

    angle_min: float = param(0.0, "Bearing at which it begins.", unit="rad")
    angle_max: float = param(0.0, "Bearing at which it ends.", unit="rad")
    range_min: float = param(0.0, "Distance at which it begins.", unit="m")
    range_max: float = param(0.0, "Distance at which it ends.", unit="m")
    clear_inside: bool = param(True, "Whether returns inside are removed, else those outside.")
    invert: bool = param(False, "Whether those outside are, whatever that says.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the returns of the sector."""
        turned, width = sweep.angles - self.angle_min, self.angle_max - self.angle_min
        if width < 0.0:  # over the back
            turned, width = np.where(turned < 0.0, turned + math.tau, turned), width + math.tau
        within = (turned > 0.0) & (turned < width)
        within &= (sweep.ranges > self.range_min) & (sweep.ranges < self.range_max)
        removed = within == (self.clear_inside and not self.invert)
        sweep = replace(sweep, intensities=sweep.intensities * ~removed[: len(sweep.intensities)])
        return sweep.replaced(removed, sweep.range_max + 1.0)


@dataclass(frozen=True)
class Shadows:
    """Removes the points between an edge and what is behind it, by the angle of neighbours."""

    min_angle: float = param(10.0, "Least angle between neighbours and the ray.", unit="degree")
    max_angle: float = param(170.0, "Greatest angle between them.", unit="degree")
    window: int = param(1, "Beams to each side that are compared.", minimum=0, maximum=1000)
    neighbors: int = param(0, "Beams about one that are removed with it.", minimum=0, maximum=1000)
    remove_shadow_start_point: bool = param(False, "Whether the nearer point goes, too.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the points that a shadow's edge tears apart."""
        count, ranges = len(sweep.ranges), sweep.ranges
        edges = np.zeros(count, bool)
        for step in [step for step in range(-self.window, self.window + 1) if step]:
            near, far = _pairs(count, step)
            turn = step * sweep.angle_increment
            r1, r2 = ranges[near], ranges[far]
            angle = np.degrees(np.abs(np.arctan2(r2 * np.sin(turn), r1 - r2 * np.cos(turn))))
            edges[near] |= (angle < self.min_angle) | (angle > self.max_angle)
        removed = edges & self.remove_shadow_start_point
        for step in range(-self.neighbors, self.neighbors + 1):
            near, far = _pairs(count, step)
            removed[far] |= edges[near] & (ranges[near] < ranges[far])
        return sweep.replaced(removed)


def _pairs(count: int, step: int) -> tuple[slice, slice]:
    """Return the beams that have a beam a step behind them, and those beams."""
    shift = min(abs(step), count)
    first, second = slice(0, count - shift), slice(shift, count)
    return (first, second) if step >= 0 else (second, first)


@dataclass(frozen=True)
class Speckle:
    """Removes returns within a distance that have too few neighbours."""

    filter_type: int = param(0, "0 compares ranges, 1 distances of points.", choices=(0, 1))
    max_range: float = param(2.0, "Ranges beyond are kept.", unit="m")
    max_range_difference: float = param(0.1, "Greatest difference of neighbours.", unit="m")
    filter_window: int = param(2, "Beams that belong together.", minimum=1, maximum=1000)

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without speckles."""
        window, count = self.filter_window, len(sweep.ranges)
        valid = sweep.ranges > self.max_range
        if count >= window:
            alike = self._alike_ranges(sweep) if self.filter_type == 0 else self._near(sweep)
            for step in range(window):
                valid[step : step + len(alike)] |= alike
        return sweep.replaced(~valid)

    def _alike_ranges(self, sweep: Sweep) -> Bools:
        """Return for each beam that starts a window whether the others are as far as it."""
        views = sliding_window_view(sweep.ranges, self.filter_window)
        alike: Bools = np.all(np.abs(views - views[:, :1]) <= self.max_range_difference, axis=1)
        return alike

    def _near(self, sweep: Sweep) -> Bools:
        """Return for each such beam whether as many points about it as the window are near it."""
        count, ranges = len(sweep.ranges), sweep.ranges
        found = np.zeros(count, np.int64)
        window = self.filter_window
        for step in [step for step in range(-window, window + 1) if step]:
            near, far = _pairs(count, step)
            r1, r2 = ranges[near], ranges[far]
            square = r1**2 + r2**2 - 2.0 * r1 * r2 * np.cos(step * sweep.angle_increment)
            found[near] += np.sqrt(np.maximum(square, 0.0)) <= self.max_range_difference
        return found[: count - window + 1] >= window


@dataclass(frozen=True)
class Interpolation:
    """Puts the mean of the valid returns on both sides in place of invalid ones."""

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without gaps."""
        ranges = sweep.ranges
        bad = (ranges <= sweep.range_min) | (ranges >= sweep.range_max)
        indices, edge = np.arange(len(ranges)), sweep.range_max - 0.01
        before = np.maximum.accumulate(np.where(bad, -1, indices))
        after = np.minimum.accumulate(np.where(bad, len(ranges), indices)[::-1])[::-1]
        padded = np.concatenate((ranges, (edge, edge)))  # index -1 and index N lie outside
        return replace(sweep, ranges=np.where(bad, (padded[before] + padded[after]) / 2.0, ranges))


@dataclass(frozen=True)
class Intensity:
    """Removes beams whose intensity is outside of two limits."""

    lower_threshold: float = param(8000.0, "Least intensity.")
    upper_threshold: float = param(100000.0, "Greatest intensity.")
    disp_histogram: int = param(0, "Has no effect.")
    invert: bool = param(False, "Whether beams within the limits are removed instead.")
    filter_override_range: bool = param(True, "Whether the range becomes NaN.")
    filter_override_intensity: bool = param(False, "Whether the intensity becomes 0.")

    def apply(self, sweep: Sweep, mounted: Mounted, memory: dict[str, Any]) -> Sweep:
        """Return the sweep without the beams of other intensities."""
        if not len(sweep.intensities):
            return sweep
        strength = sweep.intensities
        within = (strength >= self.lower_threshold) & (strength <= self.upper_threshold)
        removed = within == self.invert
        if self.filter_override_intensity:
            sweep = replace(sweep, intensities=np.where(removed, 0.0, strength))
        return sweep.replaced(removed) if self.filter_override_range else sweep


FILTERS: dict[str, type[ScanFilter]] = {
    "laser_filters/LaserScanRangeFilter": RangeFilter,
    "laser_filters/LaserScanAngularBoundsFilter": AngularBounds,
    "laser_filters/LaserScanAngularBoundsFilterInPlace": AngularGap,
    "laser_filters/LaserScanBoxFilter": Box,
    "laser_filters/LaserScanPolygonFilter": PolygonOutline,
    "laser_filters/StaticLaserScanPolygonFilter": PolygonOutline,
    "laser_filters/LaserScanFootprintFilter": Footprint,
    "laser_filters/LaserScanSectorFilter": Sector,
    "laser_filters/ScanShadowsFilter": Shadows,
    "laser_filters/LaserScanSpeckleFilter": Speckle,
    "laser_filters/InterpolationFilter": Interpolation,
    "laser_filters/LaserScanIntensityFilter": Intensity,
    "laser_filters/LaserArrayFilter": ArrayFilter,
}
"""The filters by the names of their classes."""
