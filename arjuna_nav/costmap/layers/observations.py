"""Observations of scans, clouds and ranges with the robot's pose, and obstacle layers' sources."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import duration_param, fixed, length_param, param
from arjuna_core.plugins import NamedConfigs, names_in
from arjuna_core.pose3 import Pose3
from arjuna_core.scan import Cloud, RangeReading, Scan
from arjuna_core.se2 import SE2


@dataclass(frozen=True)
class SensorSource:
    """Parameters of one source of a layer, of whatever marks and clears."""

    topic: str = fixed(
        "", "Topic of the data; by default the source's name.", of_robot="scan_topic"
    )
    sensor_frame: str = fixed("", "Where its rays start; empty for the frame of its messages.")
    data_type: str = fixed("LaserScan", "Type of the data.", choices=("LaserScan", "PointCloud2"))
    marking: bool = param(True, "Whether returns mark obstacles.")
    clearing: bool = param(False, "Whether rays clear obstacles.")
    observation_persistence: float = duration_param(
        0.0, "How long what is seen counts again; 0 for the latest alone."
    )
    expected_update_rate: float = duration_param(
        0.0, "Longest silence allowed, as Nav2 names it; 0 allows any."
    )
    inf_is_valid: bool = param(False, "Whether a beam without return clears its ray.")
    inf_marks: bool = param(
        False,
        "Whether such a beam, as Nav2's, ends just before range_max and may mark there, and one"
        " whose range is finite and beyond counts not at all.",
        theirs=True,
    )
    min_obstacle_height: float = param(0.0, "Lowest point that is used.", unit="m")
    max_obstacle_height: float = param(0.0, "Highest point that is used.", unit="m")

    @property
    def heights(self) -> tuple[float, float]:
        """Lowest and highest point that is used [m]."""
        return self.min_obstacle_height, self.max_obstacle_height


@dataclass(frozen=True)
class SourceConfig(SensorSource):
    """Parameters of one source of an obstacle layer, whose rays clear."""

    obstacle_max_range: float = length_param(2.5, "Longest range that marks.")
    obstacle_min_range: float = length_param(0.0, "Shortest range that marks.")
    raytrace_max_range: float = length_param(3.0, "Longest range cleared.")
    raytrace_min_range: float = length_param(0.0, "Shortest range cleared.")

    @property
    def ranges(self) -> tuple[float, float, float, float]:
        """Shortest and longest range that is cleared, then that marks [m]."""
        traced = self.raytrace_min_range, self.raytrace_max_range
        return *traced, self.obstacle_min_range, self.obstacle_max_range

    @property
    def reach(self) -> float:
        """Distance from its sensor up to which it changes cells [m]."""
        return max(self.raytrace_max_range, self.obstacle_max_range)


SOURCES = NamedConfigs(SourceConfig, "topic")


def sources_of(layer: Any) -> dict[str, Any]:
    """Return the sources that a layer's parameters name; none where it has no such list."""
    names = names_in(getattr(layer, "observation_sources", ""), "")
    return {name: getattr(layer, name) for name in names}


T = TypeVar("T", Scan, Cloud, RangeReading)


@dataclass(frozen=True, eq=False)
class Placed(Generic[T]):
    """A sensor's reading and where the robot was when it was taken.

    Attributes:
        T_global_base: Pose of the base in the costmap's global frame at the reading's stamp.
    """

    reading: T
    T_global_base: SE2

    @property
    def stamp(self) -> float:
        """When it was taken [s]."""
        return self.reading.stamp


@dataclass(frozen=True, eq=False)
class PlacedScan(Placed[Scan]):
    """A scan.

    Attributes:
        height: Of the sensor above the global frame's ground [m].
        mount: Pose of a sensor that is not level, from the ground below the base; else None.
        start: Where the rays start that do not at the sensor, likewise [m]; else None.
    """

    height: float = 0.0
    mount: Pose3 | None = None
    start: tuple[float, float, float] | None = None

    @property
    def is_planar(self) -> bool:
        """True where its beams are rays at one height from the sensor."""
        return self.mount is None and self.start is None

    @property
    def T_global_sensor(self) -> SE2:
        """Pose of the sensor in the costmap's global frame."""
        return self.T_global_base @ self.reading.T_base_sensor

    def ends(self, ranges: Floats | None = None) -> Floats:
        """Return the ends of beams from the base, heights from the ground, `(M, 3)` [m].

        Args:
            ranges: Their lengths `(N,)` [m], of those without an end NaN; by default what they hit.
        """
        scan = self.reading
        ranges = np.where(scan.valid, scan.ranges, np.nan) if ranges is None else ranges
        used = np.isfinite(ranges)
        lengths, angles = ranges[used], scan.angles[used]
        flat = (lengths * np.cos(angles), lengths * np.sin(angles), np.zeros(len(lengths)))
        mount = self.mount or Pose3.from_se2(scan.T_base_sensor, self.height)
        return mount.apply(np.column_stack(flat))


@dataclass(frozen=True, eq=False)
class PlacedCloud(Placed[Cloud]):
    """A cloud.

    Attributes:
        mount: Pose of the sensor from the ground below the base; None where it is not known.
    """

    mount: Pose3 | None = None

    @property
    def T_global_sensor(self) -> SE2:
        """Pose of the sensor in the costmap's global frame; its heading is the base's."""
        return self.T_global_base @ SE2(*self.reading.sensor[:2].tolist())


class PlacedRange(Placed[RangeReading]):
    """A distance in a cone."""

    @property
    def T_global_sensor(self) -> SE2:
        """Pose of the sensor in the costmap's global frame, the cone about its x axis."""
        return self.T_global_base @ self.reading.T_base_sensor


Observation = PlacedScan | PlacedCloud


def with_ends(seen: Observation, source: SensorSource) -> Observation:
    """Return what is seen; beams without return end just before range_max where they may mark.

    Source: nav2_costmap_2d, ObstacleLayer::laserScanValidInfCallback.
    """
    if not (isinstance(seen, PlacedScan) and source.inf_is_valid and source.inf_marks):
        return seen
    scan = seen.reading
    known = np.where(scan.ranges < scan.range_max, scan.ranges, np.nan)
    ranges = np.where(np.isposinf(scan.ranges), scan.range_max - 1e-4, known)
    return replace(seen, reading=replace(scan, ranges=ranges))


def used_points(seen: PlacedCloud, source: SensorSource) -> Floats:
    """Return a cloud's points between the source's heights, from the base, `(N, 3)` [m]."""
    points, (low, high) = seen.reading.points, source.heights
    used: Floats = points[(points[:, 2] >= low) & (points[:, 2] <= high)]
    return used


def as_cloud(seen: Observation, source: SourceConfig, clearing: bool) -> PlacedCloud:
    """Return the ends of a scan's beams as points; of those without return only where they clear.

    Args:
        seen: The scan, or a cloud, which is returned as it is.
        clearing: Whether the points are for clearing.
    """
    if isinstance(seen, PlacedCloud):
        return seen
    scan = seen.reading
    ranges = np.where(scan.valid, scan.ranges, np.nan)
    if clearing and source.inf_is_valid:
        free = min(scan.range_max, source.raytrace_max_range + 1.0)
        ranges = np.where(scan.ranges >= scan.range_max, free, ranges)
    mount = seen.mount or Pose3.from_se2(scan.T_base_sensor, seen.height)
    start = np.array(seen.start or mount.position)
    return PlacedCloud(Cloud(seen.ends(ranges), start, scan.stamp), seen.T_global_base, mount)


def ranges_of(scan: Scan, source: SourceConfig) -> tuple[float, ...]:
    """Return the ranges [m] that bound a scan's validity, clearing and marking.

    They are range_min, range_max, raytrace_min, raytrace_max of beams without return (negative for
    none), raytrace_max, obstacle_min and obstacle_max.
    """
    free = min(source.raytrace_max_range, scan.range_max) if source.inf_is_valid else -1.0
    shortest, *others = source.ranges
    return scan.range_min, scan.range_max, shortest, free, *others
