"""ROS 1's parameter files by our names: what comes out loads, what has no meaning is listed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from bringup import cli
from bringup.cli_parser import parse
from bringup.parameters.checking import check_file
from bringup.parameters.files import load_parameters, merged, shipped_parameters
from bringup.parameters.foreign.conversion import Conversion, converted
from bringup.parameters.foreign.ros1_names import TABLES, targets
from bringup.parameters.sources import ROBOT_NAMES
from tests.helpers.nav.stock_files import FILES

pytestmark = pytest.mark.ros

GMAPPING = """
base_frame: base_link
odom_frame: odom
map_frame: map
maxUrange: 10.0
maxRange: 12.0
minimumScore: 50
map_update_interval: 1.0
linearUpdate: 0.2
angularUpdate: 0.3
temporalUpdate: -1.0
delta: 0.05
particles: 50
xmin: -10.0
"""
AMCL = """
amcl: {min_particles: 10, max_particles: 80, kld_err: 0.001, odom_model_type: diff-corrected,
  odom_alpha1: 0.02, laser_max_beams: 50, laser_z_hit: 0.8, initial_pose_a: 1.5,
  gui_publish_rate: 50.0, odom_frame_id: /odom}
"""
MOVE_BASE = """
base_global_planner: navfn/NavfnROS
base_local_planner: dwa_local_planner/DWAPlannerROS
planner_frequency: 1.0
controller_frequency: 5.0
planner_patience: 5.0
controller_patience: 15.0
oscillation_timeout: 10.0
oscillation_distance: 0.2
"""
DWA = """
DWAPlannerROS: {max_vel_x: 0.4, max_vel_trans: 0.4, max_vel_theta: 0.8, min_vel_theta: 0.3,
  acc_lim_x: 1.0, acc_lim_theta: 1.5, xy_goal_tolerance: 0.2, sim_time: 1.5, vth_samples: 20,
  path_distance_bias: 32.0, goal_distance_bias: 20.0, occdist_scale: 0.02}
"""
TRAJECTORY = """
TrajectoryPlannerROS: {holonomic_robot: true, max_vel_x: 0.45, meter_scoring: true,
  pdist_scale: 0.6, sim_time: 2.0, yaw_goal_tolerance: 0.05}
"""
COSTMAPS = """
obstacle_range: 2.5
raytrace_range: 3.0
robot_radius: 0.25
inflation_radius: 0.35
cost_scaling_factor: 5.0
observation_sources: laser_scan_sensor
laser_scan_sensor: {sensor_frame: hokuyo, data_type: LaserScan, topic: /laser/scan, marking: true,
  clearing: true}
"""
KARTO = """
minimum_travel_distance: 0.12
scan_buffer_size: 70
loop_search_maximum_distance: 3.5
do_loop_closing: true
"""
OTHERS = """
move_base: {controller_frequency: 5.0, TebLocalPlannerROS: {max_vel_x: 0.4}}
DWAPlannerROS: {controller_frequency: 10.0}
"""
LOCAL = """
local_costmap: {global_frame: /odom, rolling_window: true, static_map: false, width: 4.0,
  height: 3.5, footprint: [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2]],
  plugins: [{name: seen, type: "costmap_2d::VoxelLayer"},
    {name: grown, type: "costmap_2d::InflationLayer"}],
  grown: {inflation_radius: 0.5}}
"""
CASES = {
    "gmapping": (GMAPPING, "slam_toolbox", "max_laser_range", 10.0, "gmapping: maxRange"),
    "karto": (KARTO, "slam_toolbox", "minimum_travel_distance", 0.12, ""),
    "a planner that is not here": (
        OTHERS,
        "controller_server",
        "controller_frequency",
        5.0,
        "move_base: TebLocalPlannerROS",
    ),
    "a name of another section": (
        OTHERS,
        "controller_server",
        "controller_frequency",
        5.0,
        "DWAPlannerROS: controller_frequency",
    ),
    "amcl": (AMCL, "amcl", "pf_err", 0.001, "amcl: gui_publish_rate"),
    "a model": (AMCL, "amcl", "robot_model_type", "nav2_amcl::DifferentialMotionModel", ""),
    "a pose": (AMCL, "amcl", "set_initial_pose", True, ""),
    "a frame": (AMCL, "amcl", "odom_frame_id", "odom", ""),
    "move_base": (
        MOVE_BASE,
        "controller_server",
        "FollowPath.plugin",
        "dwb_core::DWBLocalPlanner",
        "move_base: planner_patience",
    ),
    "DWA": (DWA, "controller_server", "FollowPath.decel_lim_x", -1.0, ""),
    "a least turn": (DWA, "behavior_server", "min_rotational_vel", 0.3, ""),
    "a patience": (MOVE_BASE, "bt_navigator", "replanning_frequency", 1.0, "tried once more"),
    "no recoveries": (
        "{recovery_behavior_enabled: false, max_planning_retries: 9,"
        " clearing_rotation_allowed: true}",
        "bt_navigator",
        "number_of_retries",
        0,
        "clearing_rotation_allowed: true (a recovery spins here in any case",
    ),
    "no spin": ("{clearing_rotation_allowed: false}", "bt_navigator", "spin_dist", 0.0, ""),
    "a range alone": ("{maxRange: 12.0, delta: 0.1}", "slam_toolbox", "max_laser_range", 12.0, ""),
    "a way out": (
        "TrajectoryPlannerROS: {escape_vel: -0.2, meter_scoring: false}",
        "bt_navigator",
        "backup_speed",
        0.2,
        "weights are of metres here",
    ),
    "a way out that is none": (
        "TrajectoryPlannerROS: {escape_vel: 0.2, sim_time: 2.0}",
        "controller_server",
        "FollowPath.sim_time",
        2.0,
        "escape_vel: 0.2 (the way out is backwards here",
    ),
    "a look ahead": (
        "TrajectoryPlannerROS: {heading_lookahead: 0.5}",
        "controller_server",
        "FollowPath.GoalAlign.forward_point_distance",
        0.5,
        "",
    ),
    "a weight of metres": (
        TRAJECTORY,
        "controller_server",
        "FollowPath.PathDist.scale",
        1.2,
        "",
    ),
    "a weight of cells": (
        "TrajectoryPlannerROS: {pdist_scale: 0.6}",
        "controller_server",
        "FollowPath.PathDist.scale",
        24.0,
        "",
    ),
    "a weight": (DWA, "controller_server", "FollowPath.PathAlign.scale", 32.0, ""),
    "TrajectoryPlanner": (
        TRAJECTORY,
        "controller_server",
        "FollowPath.max_vel_x",
        0.45,
        "TrajectoryPlannerROS: meter_scoring",
    ),
    "both costmaps": (
        COSTMAPS,
        "global_costmap/global_costmap",
        "obstacle_layer.laser_scan_sensor.topic",
        "/laser/scan",
        "",
    ),
    "one costmap": (LOCAL, "local_costmap/local_costmap", "height", 4, "static_map"),
    "layers": (
        LOCAL,
        "local_costmap/local_costmap",
        "plugins",
        ["obstacle_layer", "inflation_layer"],
        "",
    ),
}


def written(folder: Path, text: str) -> Path:
    path = folder / "theirs.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def checked(folder: Path, text: str) -> Conversion:
    result = converted(written(folder, text))
    assert (result.unknown, result.problems) == ([], [])
    return result


@pytest.mark.parametrize("case", CASES)
def test_a_ros1_file_becomes_one_that_loads(case: str, tmp_path: Path) -> None:
    text, node, name, value, without = CASES[case]
    result = checked(tmp_path, text)
    ours = tmp_path / "ours.yaml"
    ours.write_text(result.text, encoding="utf-8")
    assert load_parameters([ours])[node][name] == value
    assert any(without in note for note in result.notes) or not without
    assert check_file(ours).refused_by(strict=True) == []


def _base_frames(text: str, folder: Path) -> set[str]:
    """Return the base frames that a file leads to, over the shipped parameters."""
    loaded = load_parameters([written(folder, checked(folder, text).text)])
    whole = merged(shipped_parameters(), loaded)
    return {f for n, k in ROBOT_NAMES["base_frame"].items() if (f := whole.get(n, {}).get(k))}


@pytest.mark.parametrize(
    "text",
    [
        "amcl: {base_frame_id: robot_footprint}",
        "{amcl: {base_frame_id: /robot_footprint},"
        " local_costmap: {robot_base_frame: robot_footprint}}",
        "bt_navigator: {ros__parameters: {robot_base_frame: robot_footprint}}",
        "{base_frame: robot_footprint, delta: 0.1}",
    ],
)
def test_a_robot_has_one_base_frame(text: str, tmp_path: Path) -> None:
    assert _base_frames(text, tmp_path) == {"robot_footprint"}


def test_two_base_frames_stay_two(tmp_path: Path) -> None:
    text = "{amcl: {base_frame_id: foot}, global_costmap: {robot_base_frame: body}}"
    assert {"foot", "body"} <= _base_frames(text, tmp_path)


def test_a_controller_s_accelerations_are_the_velocity_smoother_s(tmp_path: Path) -> None:
    def smoother(text: str) -> dict[str, Any]:
        ours = written(tmp_path, checked(tmp_path, text).text)
        return load_parameters([ours])["velocity_smoother"]

    limits = "FollowPath: {max_linear_accel: 1.5, max_linear_decel: 2.0}"
    text = f"controller_server: {{ros__parameters: {{controller_plugins: [FollowPath], {limits}}}}}"
    found = smoother(text)
    assert (found["max_accel"][0], found["max_decel"][0]) == (1.5, -2.0)
    own = "velocity_smoother: {ros__parameters: {max_accel: [0.7, 0.0, 1.0]}}"
    assert smoother(f"{text}\n{own}")["max_accel"] == [0.7, 0.0, 1.0]


@pytest.mark.parametrize("name", FILES)
def test_a_nav2_file_keeps_only_what_is_used(name: str, tmp_path: Path) -> None:
    ours = tmp_path / "ours.yaml"
    ours.write_text(checked(tmp_path, FILES[name]).text, encoding="utf-8")
    assert checked(tmp_path, ours.read_text()).notes == []


def test_all_that_nobody_knows_is_told_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, "amcl: {kid_err: 0.1, max_particles: 800, laser_z_hti: 0.3}")
    assert cli.run(parse(["params", "convert", str(path)])) == 0  # it wrote what it knows
    told = capsys.readouterr()
    assert "amcl: nobody knows 'kid_err'; did you mean 'kld_err'?" in told.err
    assert "'laser_z_hti'; did you mean 'laser_z_hit'?" in told.err
    assert "max_particles: 800" in told.out


def test_a_file_of_no_known_node_is_told_once(tmp_path: Path) -> None:
    result = converted(written(tmp_path, "{speed_lim_v: 0.8, accel_lim_w: 2.0}"))
    assert len(result.unknown) == 1
    assert (
        "of no node that is known: 'speed_lim_v', 'accel_lim_w'; valid: amcl, gmapping"
        in (result.unknown[0])
    )
    assert result.problems == ["nothing in it has a meaning here"]


def test_the_page_has_every_name() -> None:
    page = (Path(__file__).parents[3] / "docs" / "coming-from-ros1.md").read_text(encoding="utf-8")
    for section in (name for name in TABLES if name not in ("local_costmap", "slam_toolbox")):
        for old, ours in targets(section).items():
            row = ", ".join(f"`{node}` `{name}`" for node, name in ours) or "-"
            assert f"| `{old}` | {row} |\n" in page, f"{section}: {old}"


def test_a_launch_file_becomes_one_that_loads(tmp_path: Path) -> None:
    path = tmp_path / "amcl.launch"
    path.write_text(
        """<launch><node pkg="amcl" type="amcl" name="amcl">
          <remap from="scan" to="robot/laser/scan"/><remap from="map" to="plan"/>
          <param name="odom_alpha1" value="0.02"/><param name="gui_publish_rate" value="10"/>
        </node><node pkg="move_base" type="move_base" name="move_base">
          <remap from="cmd_vel" to="robot/cmd_vel"/>
          <rosparam>TrajectoryPlannerROS: {max_vel_x: 0.45}</rosparam>
        </node></launch>""",
        encoding="utf-8",
    )
    result = converted(path)
    assert (result.unknown, result.problems) == ([], [])
    assert result.notes == ["amcl: gui_publish_rate", "amcl: remap from map to plan"]
    ours = tmp_path / "ours.yaml"
    ours.write_text(result.text, encoding="utf-8")
    assert check_file(ours).refused_by(strict=True) == []
    loaded = load_parameters([ours])
    assert loaded["amcl"] == {"alpha1": 0.02, "scan_topic": "robot/laser/scan"}
    assert loaded["collision_monitor"] == {"cmd_vel_out_topic": "robot/cmd_vel"}
    assert loaded["controller_server"]["FollowPath.max_vel_x"] == 0.45
