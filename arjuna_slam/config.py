"""Parameters of SLAM: slam_toolbox's names where it has the parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, duration_param, fixed, info_of, length_param, param
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.graph.back_end import BackEndConfig
from arjuna_slam.mapping.keyframes import Keyframes, LifelongConfig
from arjuna_slam.mapping.reference_map import ReferenceConfig
from arjuna_slam.matching.tracking import TrackerConfig

_LEAST_EDGE = 1e-3  # [m] of a map's cell: smaller ones fill the memory


@dataclass(frozen=True)
class SlamConfig(BackEndConfig, ReferenceConfig, TrackerConfig, LifelongConfig):
    """Parameters of SLAM, those of matching and of loop closure among them."""

    resolution: float = length_param(0.05, "Edge of a map cell.", minimum=1e-3)
    minimum_travel_distance: float = length_param(0.2, "Travel from keyframe to keyframe.")
    minimum_travel_heading: float = angle_param(0.2, "Turn after which a scan is a keyframe.")
    odometry_deviation: float = param(
        0.2, "Deviation of odometry per metre and per radian.", minimum=1e-3, maximum=10.0
    )
    odometry_heading_deviation: float = param(
        0.2,
        "Deviation of its heading per radian, and per 2 m; a gyro's 0.02.",
        minimum=1e-4,
        maximum=10.0,
    )

    min_pass_through: int = param(2, "A cell of the map is known where more beams came.", minimum=0)
    occupancy_threshold: float = param(
        0.1, "Share of a cell's beams above which it is occupied.", minimum=0.0
    )

    clear_without_return: bool = param(
        True, "Whether beams without a return clear cells.", theirs=False
    )
    thin_walls: bool = param(
        True,
        "Whether a cell is free where clearly more beams ended in the line of cells beside it.",
        theirs=False,
    )
    scan_buffer_size: int = param(
        0,
        "Keyframes seen while localizing that are kept, to be matched with and in the map.",
        minimum=0,
        maximum=10000,
    )

    def keyframes(self) -> Keyframes:
        """Return a mapping session's keyframes, none as yet."""
        return Keyframes(
            self.resolution, self.max_laser_range, self.min_pass_through,
            self.occupancy_threshold, self.clear_without_return, self.thin_walls,
        )  # fmt: skip

    def keyframe_due(self, delta: SE2) -> bool:
        """Return whether the robot has moved enough since the last keyframe for another."""
        return (
            math.hypot(delta.x, delta.y) >= self.minimum_travel_distance
            or abs(wrap(delta.theta)) >= self.minimum_travel_heading
        )

    def odometry_covariance(self, delta: SE2) -> Floats:
        """Return the covariance of an odometry step, `(3, 3) float64` [m^2, m rad, rad^2]."""
        distance, turn = math.hypot(delta.x, delta.y), abs(delta.theta)
        position = 0.01 + self.odometry_deviation * (distance + 0.2 * turn)
        heading = self.odometry_heading_deviation * (0.025 + turn + 0.5 * distance)
        return np.diag([position**2, position**2, heading**2])


MODES = ("mapping", "localization", "lifelong")
LEAST_INTERVAL = 0.02  # [s] between two maps: the mapper works at that pace


def _as_there(name: str, default: Any, minimum: float | None = None) -> Any:
    """Declare a parameter of SLAM with slam_toolbox's default in place of the mapper's own."""
    info = info_of(SlamConfig.__dataclass_fields__[name])
    least = info.minimum if minimum is None else minimum
    return param(
        default,
        info.description,
        unit=info.unit,
        minimum=least,
        maximum=info.maximum,
        theirs=default,
    )


@dataclass(frozen=True)
class SlamNodeConfig(SlamConfig):
    """Parameters of the node; slam_toolbox's names, defaults and bounds.

    The mapper's own defaults, those of `SlamConfig`, are in `params/arjuna_slam.yaml`.
    Source: slam_toolbox 2.7, src/slam_mapper.cpp, slam_toolbox_common.cpp and laser_utils.cpp.
    """

    resolution: float = _as_there("resolution", 0.05, minimum=0.0)
    minimum_travel_distance: float = _as_there("minimum_travel_distance", 0.5)
    minimum_travel_heading: float = _as_there("minimum_travel_heading", 0.5)
    max_laser_range: float = _as_there("max_laser_range", 25.0, minimum=0.0)
    correlation_search_space_dimension: float = _as_there("correlation_search_space_dimension", 0.5)
    loop_search_space_dimension: float = _as_there("loop_search_space_dimension", 8.0)
    minimum_distance_penalty: float = _as_there("minimum_distance_penalty", 0.05)
    scan_buffer_size: int = _as_there("scan_buffer_size", 10)
    mode: str = fixed("mapping", "What the node does.", choices=MODES)
    synchronous: bool = fixed(False, "Whether every scan is processed, not only the newest.")
    odom_frame: str = fixed("odom", "Frame of the odometry.")
    map_frame: str = fixed("map", "Frame of the map.")
    base_frame: str = fixed("base_footprint", "Frame of the robot's base.")
    scan_topic: str = fixed("/scan", "Topic of the scans.")
    scan_queue_size: int = fixed(
        1, "Scans that may wait; 0: any.", minimum=0, maximum=100000, theirs=1
    )
    throttle_scans: int = param(1, "Every which scan is used.", minimum=0, maximum=1000000)
    minimum_time_interval: float = duration_param(
        0.5, "Least time between two scans used; each makes the pose better.", theirs=0.5
    )
    process_between_keyframes: bool = param(
        True,
        "Whether scans are matched before the robot has moved by minimum_travel_*.",
        theirs=False,
    )
    min_laser_range: float = length_param(0.0, "Shortest range used.")
    map_name: str = fixed("/map", "Topic of the map.")
    map_update_interval: float = duration_param(
        10.0, "Time between two maps, 0.02 at least.", read_only=True, theirs=10.0
    )
    publish_unchanged_map: bool = param(
        False,
        "Whether the map is published each time, not only where it has changed or somebody "
        "listens to it who asks for none of before.",
        theirs=True,
    )
    transform_publish_period: float = duration_param(
        0.05, "Time between two transforms; 0 for none.", read_only=True
    )
    transform_timeout: float = duration_param(
        0.5, "How far past its scan a transform is dated.", theirs=0.5
    )
    restamp_tf: bool = param(False, "Whether transforms are dated past now instead.")
    position_covariance_scale: float = param(
        1.0, "Factor on the covariance of the position.", minimum=0.0
    )
    yaw_covariance_scale: float = param(1.0, "Factor on the covariance of the yaw.", minimum=0.0)
    map_file_name: str = param("", "Graph to go on from; empty for a new one.", path=True)
    map_start_pose: tuple[float, ...] = fixed((), "Where the robot starts on it: x, y, theta.")
    map_start_at_dock: bool = fixed(False, "Whether it starts at the first keyframe.")
    start_anywhere: bool = fixed(
        True,
        "Whether a robot without a start is searched on the whole map; else it is at the origin.",
        theirs=False,
    )
    resume_file: str = param(
        "", "Keeps the current map over a crash; before map_file_name.", path=True
    )
    maps_folder: str = param(
        ".", "Folder that relative paths of maps and graphs are of.", path=True
    )
    use_map_saver: bool = fixed(True, "Whether save_map is offered.")
    enable_interactive_mode: bool = fixed(
        False, "Whether toggle_interactive_mode lets keyframes be moved by hand.", theirs=False
    )
    debug_logging: bool = fixed(False, "Whether to log each keyframe.")

    @property
    def core(self) -> SlamConfig:
        """The parameters of SLAM itself; of no resolution and no range, slam_toolbox's."""
        no_limit = 1e6  # [m] of a lidar's range: that of the scan counts
        return replace(
            self,
            lifelong=self.lifelong or self.mode == "lifelong",
            resolution=max(self.resolution, _LEAST_EDGE) if self.resolution else 0.05,
            max_laser_range=self.max_laser_range or no_limit,
        )

    @property
    def corrections(self) -> list[str]:
        """Values that slam_toolbox takes for others, a sentence each."""
        found = []
        if not self.resolution:
            found.append("resolution is 0: 0.05 m is used")
        elif self.resolution < _LEAST_EDGE:
            found.append(f"resolution is {self.resolution:g} m: {_LEAST_EDGE:g} m is used")
        if not self.max_laser_range:
            found.append("max_laser_range is 0: the range of the scans is used")
        if not self.throttle_scans:
            found.append("throttle_scans is 0: every scan is used")
        if self.map_update_interval < LEAST_INTERVAL:
            found.append(
                f"map_update_interval is {self.map_update_interval:g} s: a map comes each "
                f"{LEAST_INTERVAL:g} s at most"
            )
        return found
