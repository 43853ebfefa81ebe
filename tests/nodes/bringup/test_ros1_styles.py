"""ROS 1 files as people write them: by path, in namespaces, under names of their own, of others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from bringup.parameters.files import load_parameters
from bringup.parameters.foreign.conversion import Conversion, converted

pytestmark = pytest.mark.ros

LAYERS = """
obstacle_range: 4.5
static: {map_topic: /plan, subscribe_to_updates: true, enabled: false}
seen: {observation_sources: laser depth, combination_method: 1,
  laser: {data_type: LaserScan, topic: front, clearing: true, marking: true},
  depth: {data_type: PointCloud2, topic: points, min_obstacle_height: 0.1}}
grown: {inflation_radius: 1.0, inflate_unknown: true}
"""
RESETS = """
controller_frequency: 20.0
make_plan_clear_costmap: false
recovery_behaviors: [{name: far_reset, type: clear_costmap_recovery/ClearCostmapRecovery}]
far_reset: {reset_distance: 3.0, layer_names: [obstacle_layer]}
"""
GLOBAL = """
base_global_planner: global_planner/GlobalPlanner
GlobalPlanner: {use_dijkstra: false, neutral_cost: 50, default_tolerance: 0.3}
"""
DUMP = """
rosdistro: noetic
run_id: 4e1a
roslaunch: {uris: {host: "http://robot:11311/"}}
amcl: {force_update_after_initialpose: true, beam_skip_error_threshold: 0.8}
move_base: {DWAPlannerROS: {max_vel_x: 0.3, theta_stopped_vel: 0.1}}
"""
STYLES: dict[str, tuple[str, str, str, Any]] = {
    "a path": ("/slam_gmapping/delta: 0.1", "slam_toolbox", "resolution", 0.1),
    "paths that meet": (
        "{amcl: {min_particles: 9}, amcl/kld_err: 0.02}",
        "amcl",
        "pf_err",
        0.02,
    ),
    "a namespace": ("robot7: {amcl: {kld_err: 0.02}}", "amcl", "pf_err", 0.02),
    "a node by another name": (
        "our_mapper: {maxUrange: 4.0, delta: 0.1, particles: 30}",
        "slam_toolbox",
        "max_laser_range",
        4.0,
    ),
    "move_base by another name": (
        "mover: {controller_frequency: 8.0, NavfnROS: {allow_unknown: false}}",
        "controller_server",
        "controller_frequency",
        8.0,
    ),
    "a static layer": (LAYERS, "local_costmap/local_costmap", "static_layer.enabled", False),
    "its map": (LAYERS, "global_costmap/global_costmap", "map_topic", "/plan"),
    "heights of a cloud": (
        LAYERS,
        "local_costmap/local_costmap",
        "obstacle_layer.depth.min_obstacle_height",
        0.1,
    ),
    "a layer of inflation": (
        LAYERS,
        "global_costmap/global_costmap",
        "inflation_layer.inflate_unknown",
        True,
    ),
    "recoveries": (RESETS, "controller_server", "controller_frequency", 20.0),
    "A*": (GLOBAL, "planner_server", "GridBased.use_astar", True),
    "all of a robot": (DUMP, "controller_server", "FollowPath.max_vel_x", 0.3),
    "a path's threshold": (DUMP, "amcl", "beam_skip_error_threshold", 0.8),
}
STRANGERS = {
    "hector_mapping": "{map_frame: map, map_resolution: 0.05, map_size: 512}",
    "cartographer": "{map_builder: {}, map_frame: map, tracking_frame: imu, num_laser_scans: 1}",
    "robot_localization": "{frequency: 30, odom_frame: odom, imu0: imu, imu0_config: [true]}",
    "teb_local_planner": "{teb_autosize: true, max_vel_x: 0.4, dt_ref: 0.3, weight_obstacle: 50}",
}


def of(folder: Path, text: str) -> Conversion:
    path = folder / "theirs.yaml"
    path.write_text(text, encoding="utf-8")
    return converted(path)


@pytest.mark.parametrize("style", STYLES)
def test_a_style_is_understood(style: str, tmp_path: Path) -> None:
    text, node, name, value = STYLES[style]
    result = of(tmp_path, text)
    assert result.problems == []
    ours = tmp_path / "ours.yaml"
    ours.write_text(result.text, encoding="utf-8")
    assert load_parameters([ours])[node][name] == value


@pytest.mark.parametrize("name", STRANGERS)
def test_another_program_s_file_is_told_in_a_sentence(name: str, tmp_path: Path) -> None:
    result = of(tmp_path, STRANGERS[name])
    (problem,) = result.unknown
    assert problem.startswith(f"of {name}, which is not here: ")
    assert result.text.strip() == "{}"


def test_a_file_without_a_meaning_is_told(tmp_path: Path) -> None:
    result = of(tmp_path, "TebLocalPlannerROS: {max_vel_x: 0.4}")
    assert result.problems == ["nothing in it has a meaning here"]


def test_names_that_are_near_none_are_told_together(tmp_path: Path) -> None:
    result = of(tmp_path, "amcl: {min_particels: 9, zebra: 1, quokka: 2, kld_err: 0.1}")
    near, far = result.unknown
    assert near == "amcl: nobody knows 'min_particels'; did you mean 'min_particles'?"
    assert far.startswith("amcl: nobody knows 'zebra', 'quokka'; valid: min_particles, ")


@pytest.mark.parametrize(
    "text",
    [
        "move_base: {planner_frequency: often, recovery_behaviors: [reset]}",
        "DWAPlannerROS: {acc_lim_x: fast}",
        "local_costmap: {width: wide, plugins: [obstacle_layer, 3]}",
        "{1: 2, amcl: {kld_err: none}}",
    ],
)
def test_values_of_the_wrong_kind_are_told(text: str, tmp_path: Path) -> None:
    assert of(tmp_path, text).problems
