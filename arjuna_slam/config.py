"""Parameters of SLAM: slam_toolbox's names where it has the parameter."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import SEED_MAX, info_of, param
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.graph.back_end import BackEndConfig
from arjuna_slam.mapping.keyframes import Mapper
from arjuna_slam.mapping.lifelong import LifelongConfig
from arjuna_slam.mapping.reference_map import ReferenceConfig
from arjuna_slam.matching.tracking import TrackerConfig

_LEAST_EDGE = 1e-3  # [m] of a map's cell: smaller ones fill the memory


@dataclass(frozen=True)
class SlamConfig(BackEndConfig, ReferenceConfig, TrackerConfig, LifelongConfig):
    """Parameters of SLAM, those of matching and of loop closure among them."""

    resolution: float = param(0.05, "Edge of a map cell.", unit="m", minimum=1e-3)
    minimum_travel_distance: float = param(
        0.2, "Travel from keyframe to keyframe; slam_toolbox's is 0.5.", unit="m", minimum=0.0
    )
    minimum_travel_heading: float = param(
        0.2, "Turn after which a scan is a keyframe.", unit="rad", minimum=0.0
    )
    odometry_deviation: float = param(
        0.2, "Deviation of odometry per metre and per radian.", minimum=1e-3, maximum=10.0
    )

    min_pass_through: int = param(2, "A cell of the map is known where more beams came.", minimum=0)
    occupancy_threshold: float = param(
        0.1, "Share of a cell's beams above which it is occupied.", minimum=0.0
    )

    clear_without_return: bool = param(
        True, "Whether beams without a return clear cells; slam_toolbox leaves them out."
    )

    def mapper(self) -> Mapper:
        """Return a mapper without scans."""
        return Mapper(
            self.resolution, self.max_laser_range, self.min_pass_through,
            self.occupancy_threshold, self.clear_without_return,
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
        heading = 0.005 + self.odometry_deviation * (turn + 0.5 * distance)
        return np.diag([position**2, position**2, heading**2])


MODES = ("mapping", "localization", "lifelong")
LEAST_INTERVAL = 0.02  # [s] between two maps: the mapper works at that pace


def _unused(description: str = "") -> Any:
    text = f"Accepted, does nothing here. {description}".strip()
    return param(None, text, minimum=-SEED_MAX, maximum=SEED_MAX)


@dataclass(frozen=True)
class UnusedParameters:
    """Parameters of slam_toolbox's solver and matcher that have no counterpart here."""

    solver_plugin: str | None = _unused("The solver is built in.")
    ceres_linear_solver: str | None = _unused()
    ceres_preconditioner: str | None = _unused()
    ceres_trust_strategy: str | None = _unused()
    ceres_dogleg_type: str | None = _unused()
    ceres_loss_function: str | None = _unused("See loop_robust_scale.")
    stack_size_to_use: int | None = _unused("Graphs are saved without recursion.")
    tf_buffer_duration: float | None = _unused("It is that of the process.")
    check_min_dist_and_heading_precisely: bool | None = _unused("It always does.")
    use_scan_barycenter: bool | None = _unused()
    scan_buffer_size: int | None = _unused("See submap_size.")
    scan_buffer_maximum_scan_distance: float | None = _unused("See submap_size.")
    link_match_minimum_response_fine: float | None = _unused("See match_minimum_response.")
    link_scan_maximum_distance: float | None = _unused()
    loop_match_minimum_chain_size: int | None = _unused("See submap_size.")
    loop_match_maximum_variance_coarse: float | None = _unused()
    loop_witness_distance: float | None = _unused("Closures are held until enough agree.")
    loop_agree_distance: float | None = _unused("See loop_witness_distance.")
    loop_agree_angle: float | None = _unused("See loop_witness_distance.")
    correlation_search_space_resolution: float | None = _unused("See field_resolution.")
    correlation_search_space_smear_deviation: float | None = _unused("See field_deviation.")
    loop_search_space_resolution: float | None = _unused("See field_resolution.")
    loop_search_space_smear_deviation: float | None = _unused("See field_deviation.")
    fine_search_angle_offset: float | None = _unused("The refinement is continuous.")
    coarse_angle_resolution: float | None = _unused("It follows from the reach of the scan.")
    use_response_expansion: bool | None = _unused()
    lifelong_search_use_tree: bool | None = _unused()
    lifelong_minimum_score: float | None = _unused()
    lifelong_iou_match: float | None = _unused()
    lifelong_node_removal_score: float | None = _unused()
    lifelong_overlap_score_scale: float | None = _unused()
    lifelong_constraint_multiplier: float | None = _unused()
    lifelong_nearby_penalty: float | None = _unused()
    lifelong_candidates_scale: float | None = _unused()

    @property
    def unused_values(self) -> list[str]:
        """Names of those that were given a value."""
        names = (item.name for item in dataclasses.fields(UnusedParameters))
        return [name for name in names if getattr(self, name) is not None]


def _as_there(name: str, default: Any, minimum: float | None = None) -> Any:
    """Declare a parameter of SLAM with slam_toolbox's default in place of the mapper's own."""
    info = info_of(SlamConfig.__dataclass_fields__[name])
    least = info.minimum if minimum is None else minimum
    return param(default, info.description, unit=info.unit, minimum=least, maximum=info.maximum)


@dataclass(frozen=True)
class SlamNodeConfig(UnusedParameters, SlamConfig):
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
    mode: str = param("mapping", "What the node does.", choices=MODES, read_only=True)
    synchronous: bool = param(
        False, "Whether every scan is processed, not only the newest.", read_only=True
    )
    odom_frame: str = param("odom", "Frame of the odometry.", read_only=True)
    map_frame: str = param("map", "Frame of the map.", read_only=True)
    base_frame: str = param("base_footprint", "Frame of the robot's base.", read_only=True)
    scan_topic: str = param("/scan", "Topic of the scans.", read_only=True)
    scan_queue_size: int = param(
        1, "Scans that may wait; 0: any.", minimum=0, maximum=100000, read_only=True
    )
    throttle_scans: int = param(1, "Every which scan is used.", minimum=0, maximum=1000000)
    minimum_time_interval: float = param(
        0.5, "Least time between two scans used; each makes the pose better.", unit="s", minimum=0.0
    )
    process_between_keyframes: bool = param(
        True, "Whether scans are matched before the robot has moved by minimum_travel_*."
    )
    min_laser_range: float = param(0.0, "Shortest range used.", unit="m", minimum=0.0)
    map_name: str = param("/map", "Topic of the map.", read_only=True)
    map_update_interval: float = param(
        10.0, "Time between two maps, 0.02 at least.", unit="s", minimum=0.0, read_only=True
    )
    transform_publish_period: float = param(
        0.05, "Time between two transforms; 0 for none.", unit="s", minimum=0.0, read_only=True
    )
    transform_timeout: float = param(
        0.5, "How far past its scan a transform is dated.", unit="s", minimum=0.0
    )
    restamp_tf: bool = param(False, "Whether transforms are dated past now instead.")
    position_covariance_scale: float = param(
        1.0, "Factor on the covariance of the position.", minimum=0.0
    )
    yaw_covariance_scale: float = param(1.0, "Factor on the covariance of the yaw.", minimum=0.0)
    map_file_name: str = param("", "Graph to go on from; empty for a new one.", path=True)
    map_start_pose: tuple[float, ...] = param(
        (), "Where the robot starts on it: x, y, theta.", read_only=True
    )
    map_start_at_dock: bool = param(
        False, "Whether it starts at the first keyframe.", read_only=True
    )
    resume_file: str = param(
        "", "Keeps the current map over a crash; before map_file_name.", path=True
    )
    maps_folder: str = param(
        ".", "Folder that relative paths of maps and graphs are of.", path=True
    )
    use_map_saver: bool = param(True, "Whether save_map is offered.", read_only=True)
    enable_interactive_mode: bool = param(
        False, "Whether toggle_interactive_mode lets keyframes be moved by hand.", read_only=True
    )
    debug_logging: bool = param(False, "Whether to log each keyframe.", read_only=True)

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
