"""A parameter that a file leaves out has the default that Nav2 declares."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest
import yaml

from arjuna_core.config import flatten, load
from arjuna_core.plugins import PluginTypes
from arjuna_nav.controllers.mppi.config import MppiConfig
from arjuna_nav.controllers.plugins import CONTROLLERS, GOAL_CHECKERS, PROGRESS_CHECKERS
from arjuna_nav.controllers.rotation_shim import RotationShimConfig
from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.layers.observations import SourceConfig
from arjuna_nav.costmap.layers.plugins import LAYERS
from arjuna_nav.docking.dock_types import DOCK_TYPES
from arjuna_nav.nodes.safety.sources import SOURCES
from arjuna_nav.nodes.waypoints.tasks import TASKS
from arjuna_nav.planners.base import PLANNERS
from arjuna_nav.safety.zones import ZONES
from arjuna_nav.smoothers.smoothers import SMOOTHERS
from arjuna_slam.amcl.config import AmclNodeConfig

pytestmark = pytest.mark.ros
NAV2: dict[str, dict[str, Any]] = yaml.safe_load(
    (Path(__file__).parent / "nav2_defaults.yaml").read_text(encoding="utf-8")
)
REGISTRIES: tuple[PluginTypes, ...] = (
    *(CONTROLLERS, GOAL_CHECKERS, PROGRESS_CHECKERS, PLANNERS, SMOOTHERS, TASKS, SOURCES, ZONES),
    *(DOCK_TYPES, LAYERS),
)
NODES = {
    "behavior_server": "behavior_server:BehaviorServerConfig",
    "bt_navigator": "bt_navigator:BtNavigatorConfig",
    "collision_detector": "safety.detector:CollisionDetectorConfig",
    "collision_monitor": "collision_monitor:CollisionMonitorConfig",
    "controller_server": "controller_server:ControllerServerConfig",
    "planner_server": "planner_server:PlannerServerConfig",
    "smoother_server": "smoother_server:SmootherServerConfig",
    "velocity_smoother": "velocity_smoother:VelocitySmootherConfig",
    "waypoint_follower": "waypoint_follower:WaypointFollowerConfig",
}
PARTS: dict[str, type[Any]] = {
    "amcl": AmclNodeConfig,
    "costmap": CostmapConfig,
    "observation_source": SourceConfig,
}
STANDS = "Nav2's DWB stands where a file names no limits: it would be no default but a trap"
PATIENT = "servers in Python may take longer to answer"
AS_NAV2 = "--as-nav2 sets Nav2's"
SEARCH = "what our search finds is better or as soon; " + AS_NAV2
FRAME = "frames are the robot's own where a file names none"
DIFFERS = {
    **{f"dwb_core::DWBLocalPlanner.{key}": STANDS for key in
       ("max_vel_x", "max_speed_xy", "max_vel_theta", "acc_lim_x", "acc_lim_theta", "decel_lim_x",
        "decel_lim_theta")},
    **{f"behavior_server.{key}": FRAME for key in
       ("local_frame", "global_frame", "robot_base_frame")},
    **{f"bt_navigator.{key}": PATIENT for key in
       ("default_server_timeout", "default_cancel_timeout")},
    "bt_navigator.always_reload_bt_xml": "a tree that is being written is driven as it stands",
    "costmap.initial_transform_timeout": "the robot's pose may come any time; " + AS_NAV2,
    "amcl.transform_tolerance": "map -> odom is dated ahead by little; " + AS_NAV2,
    **{f"amcl.recovery_alpha_{name}": "a robot that is lost is found; " + AS_NAV2
       for name in ("fast", "slow")},
    **{f"{node}.{key}": FRAME for node in ("collision_monitor", "collision_detector")
       for key in ("base_frame_id", "odom_frame_id")},
    **{f"nav2_smac_planner::SmacPlanner{name}.{key}": SEARCH
       for name, keys in (
           ("2D", ("max_on_approach_iterations",)),
           ("Hybrid", ("downsample_obstacle_heuristic", "lookup_table_size",
                       "max_on_approach_iterations", "smooth_path")),
           ("Lattice", ("lookup_table_size", "max_on_approach_iterations", "smooth_path")))
       for key in keys},
}  # fmt: skip
"""Why a default of ours is another, by section and key."""


def ours(section: str) -> dict[str, Any]:
    """Return our defaults of a node or a class, by key."""
    if section in NODES:
        module, _, name = NODES[section].partition(":")
        config: Any = getattr(importlib.import_module(f"arjuna_nav.nodes.{module}"), name)
        return flatten(load(config, {}))
    if section in PARTS:
        return flatten(PARTS[section]())
    if section.startswith("nav2_mppi_controller::") and section.endswith("Critic"):
        return flatten(getattr(MppiConfig(), section.partition("::")[2]))
    if "RotationShim" in section:
        return flatten(RotationShimConfig())
    name = {"polygon_source": "polygon"}.get(section, section)
    registries = (SOURCES,) if section == "polygon_source" else REGISTRIES
    kind = next(each for each in (*registries, ZONES) if name in each.types)
    if section == "polygon":
        kind = ZONES
    return flatten(kind.config_of(name, {})())


def same(a: Any, b: Any) -> bool:
    if isinstance(a, bool) or isinstance(b, bool) or isinstance(a, str):
        return bool(a == b)
    return bool(a == pytest.approx(list(b) if isinstance(a, (list, tuple)) else b))


@pytest.mark.parametrize("section", NAV2)
def test_defaults_are_nav2s(section: str) -> None:
    mine = ours(section)
    shared = {key: value for key, value in NAV2[section].items() if key in mine}
    assert shared, "it has none of Nav2's parameters"
    differing = {k: (mine[k], v) for k, v in shared.items() if not same(v, mine[k])}
    differing = {k: v for k, v in differing.items() if f"{section}.{k}" not in DIFFERS}
    assert not differing, "ours, Nav2's"


def test_critics_that_a_file_lists_for_dwb_have_nav2s_defaults() -> None:
    # TrajectoryCritic::initialize, MapGridCritic, PathAlignCritic and GoalAlignCritic::onInit
    made = flatten(load(CONTROLLERS.config_of("dwb_core::DWBLocalPlanner", {"critics": []}), {}))
    assert {value for key, value in made.items() if key.endswith(".scale")} == {1.0}
    assert {v for k, v in made.items() if k.endswith(".forward_point_distance")} == {0.325}
    assert {v for k, v in made.items() if k.endswith(".aggregation_type")} == {"last"}


def test_what_differs_is_there_and_does() -> None:
    for entry in DIFFERS:
        section, _, key = entry.rpartition(".")
        assert not same(NAV2[section][key], ours(section)[key]), entry


TAKEN = {
    "nav2_mppi_controller::MPPIController": {
        "PathAngleCritic.mode": 2, "CostCritic.cost_power": 6, "ax_min": 3.0, "iteration_count": 30,
        "max_robot_pose_search_dist": -1.0, "CostCritic.near_collision_cost": 255,
    },
    "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController": {
        "cost_scaling_gain": 1.5, "cost_scaling_dist": 0.0, "inflation_cost_scaling_factor": 0.0,
        "lookahead_dist": 0.0, "max_robot_pose_search_dist": -1.0,
    },
    "nav2_smac_planner::SmacPlannerHybrid": {
        "cost_penalty": 5.0, "analytic_expansion_max_cost": 254.0, "minimum_turning_radius": 0.0,
    },
    "opennav_docking::SimpleChargingDock": {"filter_coef": 0.0, "docking_threshold": 0.0},
    "dwb_core::DWBLocalPlanner": {"decel_lim_x": 0.0, "acc_lim_theta": 0.0, "vx_samples": 400},
}  # fmt: skip


@pytest.mark.parametrize("name", TAKEN)
def test_values_that_nav2_takes_are_taken(name: str) -> None:
    registry = next(each for each in REGISTRIES if name in each.types)
    config: Any = registry.config_of(name, {})
    loaded = flatten(load(config, TAKEN[name]))
    assert {key: loaded[key] for key in TAKEN[name]} == TAKEN[name]
