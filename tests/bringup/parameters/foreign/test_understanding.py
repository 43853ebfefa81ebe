"""The rule of files: what starts, what is remarked on, what refuses a file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import flatten, load
from arjuna_core.errors import ConfigError
from bringup.cli import parse
from bringup.parameters.checking import check_file
from bringup.parameters.files import Parameters, for_node, shipped_parameters
from bringup.parameters.foreign.plugins import plugin_lists
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.inputs import gather
from bringup.parameters.remarks import Checked, Kind
from bringup.stack import all_nodes
from tests.helpers.files import written

pytestmark = pytest.mark.ros
NODES = {spec.name: spec for spec in all_nodes()}
LOCAL = "local_costmap/local_costmap"
ZONE = {
    "polygons": ["Near"],
    "observation_sources": ["scan"],
    "Near.type": "velocity_polygon",
    "Near.velocity_polygons": ["v"],
}
CLOUD, DOCK = "voxel_layer.cloud", "simple_charging_dock"
RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"


def understood(given: Parameters) -> Checked:
    return understand(given, shipped_parameters(), NODES.values())


def only(found: Checked, kind: Kind) -> str:
    (remark,) = found.remarks
    assert remark.kind is kind
    return str(remark)


def value(found: Checked, node: str, key: str) -> Any:
    config = load(NODES[node].config, for_node(found.parameters, node))
    return flatten(config)[key]


@pytest.mark.parametrize("node", NODES)
def test_a_misspelt_name_is_a_remark_that_names_the_right_one(node: str) -> None:
    rng = np.random.default_rng([11, len(node)])
    shipped = for_node(shipped_parameters(), node)
    keys = sorted(flatten(load(NODES[node].config, shipped)))
    plain = [key for key in keys if "." not in key and len(key) > 5]
    for key in rng.choice(plain, 3, replace=len(plain) < 3) if plain else []:
        at = int(rng.integers(1, len(key) - 1))
        wrong = key[:at] + key[at + 1] + key[at] + key[at + 2 :]
        if wrong in keys:
            continue
        found = understood({node: {wrong: 1}})
        assert found.problems == []
        assert found.parameters.get(node, {}) == shipped_parameters().get(node, {})
        if not (remark := str(found.remarks[0])).startswith("no"):
            assert remark.startswith(
                f"unknown: {node}: {wrong}: no such parameter; the nearest is '"
            )


def test_a_section_that_names_a_class_is_whole() -> None:
    section = {"plugins": ["inflation_layer"], "inflation_layer.inflation_radius": 0.4}
    whole = {**section, "inflation_layer.plugin": "nav2_costmap_2d::InflationLayer"}
    node, key = "global_costmap/global_costmap", "inflation_layer.cost_scaling_factor"
    shipped = shipped_parameters()[node]
    assert value(understood({node: section}), node, key) == shipped[key] != 10.0
    found = understood({node: whole})
    assert value(found, node, key) == 10.0
    assert value(found, node, "robot_radius") == shipped["robot_radius"]
    assert value(found, node, "footprint_padding") == shipped["footprint_padding"]
    other = understood({node: {**whole, "robot_radius": 0.22}})
    assert value(other, node, "footprint_padding") != shipped["footprint_padding"]


@pytest.mark.parametrize(
    ("node", "given", "left_out", "default"),
    [
        ("velocity_smoother", {"max_velocity": [0.3, 0.0, 1.0]}, "max_accel", (2.5, 0.0, 3.2)),
        ("collision_monitor", {"polygons": [], "observation_sources": []}, "source_timeout", 2.0),
    ],
)
def test_what_a_node_without_classes_is_made_of_makes_its_section_whole(
    node: str, given: dict[str, Any], left_out: str, default: Any
) -> None:
    assert shipped_parameters()[node][left_out] != default
    assert value(understood({node: given}), node, left_out) == default


def test_a_section_of_one_s_own_class_changes_what_is_below() -> None:
    mine = {"FollowPath.plugin": "docs.tutorial.none:Mine", "controller_frequency": 10.0}
    found = understood({"controller_server": mine}).parameters["controller_server"]
    kept = "general_goal_checker.xy_goal_tolerance"
    assert found[kept] == shipped_parameters()["controller_server"][kept]


@pytest.mark.parametrize(
    ("node", "given", "kind", "reason"),
    [
        (
            "controller_server",
            {"FollowPath.plugin": RPP, "FollowPath.max_vel_theta": 1.0},
            Kind.NOT_NEEDED,
            "FollowPath.max_vel_theta: a parameter of dwb_core::DWBLocalPlanner",
        ),
        ("behavior_server", {"transform_timeout": 1}, Kind.NOT_NEEDED, "no behavior of Nav2's"),
        ("amcl", {"service_introspection_mode": 1}, Kind.NOT_NEEDED, "of Nav2 after Jazzy"),
        ("amcl", {"random_seed": 1}, Kind.NOT_NEEDED, "the option --seed"),
        ("amcl", {"initial_cov_xx": 1}, Kind.NOT_NEEDED, "of ROS 1"),
        ("map_server", {"save_map_timeout": 1}, Kind.NOT_NEEDED, "of map_saver"),
        ("bt_navigator", {"bt_xml_filename": 1}, Kind.NOT_NEEDED, "of Nav2 before Humble"),
        ("planner_server", {"allow_partial_planning": 1}, Kind.NOT_NEEDED, "of other versions"),
        ("planner_server", {"Straight.step": 0.1}, Kind.NOT_NEEDED, "'Straight' is in no list of"),
        (LOCAL, {"inscribed_obstacle_cost_value": 1}, Kind.NOT_NEEDED, "of Nav2 after Jazzy"),
        (LOCAL, {f"{CLOUD}.transport_type": "raw"}, Kind.NOT_NEEDED, "are taken uncompressed"),
        (LOCAL, {f"{CLOUD}.transport_type": "zstd"}, Kind.NO_EFFECT, "SAFETY.*uncompressed"),
        (LOCAL, {"plugin_types": []}, Kind.NO_EFFECT, "before Foxy, without as many names as"),
        (LOCAL, {"footprint": "[[front_left], [rear]]"}, Kind.NO_EFFECT, "a launch file fills"),
        ("planner_server", {"planner_plugin_ids": []}, Kind.NO_EFFECT, "of Nav2 before Foxy"),
        ("docking_server", {f"{DOCK}.rotate_to_dock": True}, Kind.NO_EFFECT, "Nav2 docks so"),
        (
            "collision_monitor",
            {**ZONE, "Near.v.steering_angle_min": 0.1},
            Kind.NO_EFFECT,
            "SAFETY.*after Jazzy",
        ),
        (
            "/**",  # what is below a class in C++ is not unknown below every node
            {
                "dock_plugins": ["mine", "plain"],
                "mine.plugin": "our_docks::Dock",
                "mine.distance": 0.1,
                "plain.plugin": "opennav_docking::SimpleChargingDock",
            },
            Kind.NO_EFFECT,
            r"someone's C\+\+",
        ),
        ("amcl", {"odom_alpha1": 0.2}, Kind.UNKNOWN, "odom_alpha1: ROS 1's name of 'alpha1'"),
        (
            "planner_server",
            {"planner_plugins": ["GridBased", "Lattice"], "Lattice.tolerance": 0.2},
            Kind.UNKNOWN,
            "planner_server: Lattice: nav2_navfn_planner",
        ),
    ],
)
def test_what_has_no_effect_has_its_own_reason(
    node: str, given: dict[str, Any], kind: Kind, reason: str
) -> None:
    remark = only(understood({node: given}), kind)
    assert re.search(reason, remark)
    assert ("SAFETY" in remark) == ("SAFETY" in reason)


def test_a_listed_plug_in_without_parameters_may_have_them_in_an_earlier_file() -> None:
    listed: Parameters = {"planner_server": {"planner_plugins": ["GridBased", "Lattice"]}}
    assert not understood(listed).remarks


@pytest.mark.parametrize("key", ["zebra", "static_layer.zebra_width", "stitic_lyer_in_the_map"])
def test_no_name_is_the_nearest_to_one_that_is_far_from_all(key: str) -> None:
    remark = only(understood({"global_costmap/global_costmap": {key: 1}}), Kind.UNKNOWN)
    assert remark.endswith(f"{key}: no such parameter")


def test_a_layer_without_sources_sees_nothing() -> None:
    given = {
        "plugins": ["obstacle_layer", "inflation_layer"],
        "obstacle_layer.plugin": "nav2_costmap_2d::ObstacleLayer",
        "obstacle_layer.front.topic": "/scan",
    }
    unlisted, blind = understood({LOCAL: given}).remarks
    assert "'front' is not in 'obstacle_layer.observation_sources'" in str(unlisted)
    assert "obstacle_layer: without observation_sources it sees no obstacles" in str(blind)
    assert (unlisted.safety, blind.safety) == (False, True)
    listed = {**given, "obstacle_layer.observation_sources": "front"}
    assert understood({LOCAL: listed}).remarks == []


def test_a_listed_layer_without_a_section_sees_nothing() -> None:
    """A shortened file: Nav2 has its class by default, and no sources for it."""
    listed = {
        "plugins": ["static_layer", "obstacle_layer", "inflation_layer"],
        "inflation_layer.plugin": "nav2_costmap_2d::InflationLayer",
    }
    (blind,) = understood({"global_costmap/global_costmap": listed}).remarks
    assert "obstacle_layer: without observation_sources it sees no obstacles" in str(blind)
    assert blind.safety


def test_zones_without_sources_see_nothing() -> None:
    given = {"polygons": ["Near"], "Near.type": "circle", "Near.radius": 0.3}
    (blind,) = understood({"collision_monitor": given}).remarks
    assert "collision_monitor: polygons: without observation_sources its zones see" in str(blind)
    assert blind.safety
    assert (
        understood({"collision_monitor": {**given, "observation_sources": ["scan"]}}).remarks == []
    )


@pytest.mark.parametrize(
    ("node", "listed", "cls"),
    [
        (LOCAL, "filters", "nav2_costmap_2d::ZoneParameterFilter"),
        ("controller_server", "goal_checker_plugins", "nav2_controller::PathCompleteGoalChecker"),
    ],
)
def test_a_class_of_a_later_nav2_is_said_to_be_one(node: str, listed: str, cls: str) -> None:
    found = understood({node: {listed: ["one"], "one.plugin": cls, "one.states": ["a"]}})
    assert found.problems == []
    assert f"'{cls}' is of Nav2 after Jazzy" in only(found, Kind.NO_EFFECT)


THEIRS = "theirs::Own"
MPPI = {"FollowPath.plugin": "nav2_mppi_controller::MPPIController"}
SHIM = {"FollowPath.plugin": "nav2_rotation_shim_controller::RotationShimController"}
DWB = {"FollowPath.plugin": "dwb_core::DWBLocalPlanner", "FollowPath.Own.class": THEIRS}
CONTAINER = "nav2_costmap_2d::PluginContainerLayer"


@pytest.mark.parametrize(
    ("node", "listed", "given", "key", "expected"),
    [
        ("controller_server", "controller_plugins", ["FollowPath", "Own"], "Own.plugin", RPP),
        ("controller_server", "controller_plugins", ["Own"], "controller_plugins", ("Own",)),
        ("planner_server", "planner_plugins", ["Own"], "Own.plugin", "nav2_navfn_planner::"),
        ("smoother_server", "smoother_plugins", ["Own"], "Own.plugin", "nav2_smoother::Simple"),
        ("controller_server", "goal_checker_plugins", ["Own"], "Own.plugin", "nav2_controller::"),
        ("waypoint_follower", "waypoint_task_executor_plugin", "Own", "Own.plugin", "nav2_way"),
        ("behavior_server", "behavior_plugins", ["spin", "Own"], "behavior_plugins", ("spin",)),
        ("behavior_server", "behavior_plugins", ["Own"], "behavior_plugins", ("spin", "backup")),
        (LOCAL, "plugins", ["Own"], "plugins", ("static_layer", "obstacle_layer")),
        (LOCAL, "filters", ["Own"], "filters", ()),
        ("route_server", "operations", ["Own"], "operations", ("AdjustSpeedLimit",)),
        ("docking_server", "dock_plugins", ["Own"], "dock_plugins", ("simple_charging_dock",)),
    ],
)
def test_a_class_of_someone_s_c_is_left_out_or_one_of_ours_stands_in_for_it(
    node: str, listed: str, given: Any, key: str, expected: Any
) -> None:
    values = {listed: given, "Own.plugin": THEIRS, "Own.k": 5.0, "Own.lookahead_dist": "auto"}
    found = understood({node: values})
    assert found.problems == []
    assert f"{node}: Own: '{THEIRS}' is someone's C++" in str(found.remarks[0])
    assert all("Own." not in str(remark) for remark in found.remarks)
    held = value(found, node, key)
    assert held.startswith(expected) if isinstance(held, str) else held[: len(expected)] == expected


def test_a_robot_s_controllers_are_those_that_its_manager_has() -> None:
    manager = {"update_rate": 100, "left_fin.type": "forward_command_controller/X"}
    joints: dict[str, Any] = {"joints": ["fin"]}
    given = {"controller_manager": manager, "left_fin": joints, "fins": joints}
    kinds = {one.where: one.kind for one in understood(given).remarks}
    assert kinds["left_fin"] == kinds["controller_manager"] == Kind.NO_EFFECT
    assert kinds["fins"] == Kind.UNKNOWN


@pytest.mark.parametrize("shim", [False, True])
def test_what_stands_in_for_a_controller_keeps_the_limits_of_its_file(shim: bool) -> None:
    own = {"FollowPath.plugin": "ours::Bands", "FollowPath.max_vel_x": 0.2}
    if shim:
        own |= {**SHIM, "FollowPath.primary_controller": "ours::Bands"}
    given = {**own, "FollowPath.max_speed_xy": 3, "FollowPath.acc_lim_theta": 0.0}
    found = understood({"controller_server": given})
    assert "desired_linear_vel 0.2;" in str(found.remarks[0])
    held = {"desired_linear_vel": 0.2, "max_angular_accel": 3.2}
    assert all(value(found, "controller_server", f"FollowPath.{k}") == v for k, v in held.items())
    grouped = {"FollowPath.plugin": "ours::Bands", "FollowPath.Constraints.max_vx": 0.4}
    other = understood({"controller_server": {**grouped, "FollowPath.Limits.max_wz": 0.5}})
    assert "desired_linear_vel 0.4, rotate_to_heading_angular_vel 0.5;" in str(other.remarks[0])
    said = {"controller_server": {**given, "FollowPath.desired_linear_vel": 0.3}}
    assert value(understood(said), "controller_server", "FollowPath.desired_linear_vel") == 0.3


@pytest.mark.parametrize(
    ("node", "given", "key", "expected"),
    [
        ("controller_server", {**MPPI, "FollowPath.critics": ["CostCritic", "Own"]}, "", "Cost"),
        ("controller_server", {**MPPI, "FollowPath.critics": ["Own"]}, "", "ConstraintCritic"),
        ("controller_server", {**DWB, "FollowPath.critics": ["PathDist", "Own"]}, "", "PathDist"),
        (
            "controller_server",
            {**SHIM, "FollowPath.primary_controller": THEIRS},
            "FollowPath.primary_controller",
            RPP,
        ),
        (
            "controller_server",
            {**DWB, "FollowPath.trajectory_generator_name": "theirs::Arcs"},
            "FollowPath.trajectory_generator_name",
            "dwb_plugins::StandardTrajectoryGenerator",
        ),
        (
            "amcl",
            {"robot_model_type": "theirs/Ackermann"},
            "robot_model_type",
            "nav2_amcl::DifferentialMotionModel",
        ),
        (
            LOCAL,
            {"plugins": ["voxel_layer"], "voxel_layer.plugin": THEIRS, "voxel_layer.z_voxels": 9},
            "voxel_layer.z_voxels",
            9,
        ),
        (
            LOCAL,
            {"plugins": ["c"], "c.plugin": CONTAINER, "c.plugins": ["a"], "c.a.plugin": THEIRS},
            "c.plugins",
            (),
        ),
    ],
)
def test_plug_ins_of_plug_ins_are_no_other(
    node: str, given: dict[str, Any], key: str, expected: Any
) -> None:
    found = understood({node: given})
    assert found.problems == []
    assert "is someone's C++" in str(found.remarks[0])
    held = value(found, node, key or "FollowPath.critics")
    assert held[0].startswith(expected) if not key else held == expected


@pytest.mark.parametrize("node", NODES)
def test_someone_s_copy_of_a_class_has_ours_with_its_parameters(node: str) -> None:
    for listed in plugin_lists(NODES[node].config, {}):
        for cls in [cls for cls in listed.kind.types if "::" in cls and not listed.is_class]:
            copy = f"my_{cls}" if len(cls) % 2 else cls.replace("::", "_of_mine::")
            one: Any = "Own" if isinstance(listed.default, str) else ["Own"]
            given = {listed.key: one, f"Own.{listed.kind.key}": copy}
            if cls == SHIM["FollowPath.plugin"]:
                given["Own.primary_controller"] = RPP
            found = understood({node: given})
            assert found.problems == []
            said = f"{node}: Own: '{copy}' is someone's C++: {cls} stands in"
            assert any(said in str(remark) for remark in found.remarks)
            assert found.parameters[node][f"Own.{listed.kind.key}"] == cls


@pytest.mark.parametrize("node", [LOCAL, "global_costmap/global_costmap"])
@pytest.mark.parametrize("name", ["obstacle_range", "raytrace_range"])
def test_ranges_of_before_humble_have_today_s_names(node: str, name: str) -> None:
    layer = {"plugins": ["seen"], "seen.observation_sources": "scan"}
    ours = {**layer, "seen.plugin": "nav2_costmap_2d::VoxelLayer", f"seen.scan.{name}": 7.0}
    today = f"seen.scan.{name.replace('_range', '_max_range')}"
    assert value(understood({node: ours}), node, today) == 7.0
    assert understood({node: ours}).remarks == []
    assert value(understood({node: {**ours, today: 6.0}}), node, today) == 6.0


def test_a_fading_layer_s_range_is_its_own() -> None:
    fading = {
        "plugins": ["seen"],
        "seen.plugin": "spatio_temporal_voxel_layer/SpatioTemporalVoxelLayer",
        "seen.observation_sources": "cloud",
        "seen.cloud.obstacle_range": 7.0,
    }
    assert value(understood({LOCAL: fading}), LOCAL, "seen.cloud.obstacle_range") == 7.0


def test_a_name_that_is_too_deep_in_a_file_is_told_so() -> None:
    key = "navigate_to_pose.default_nav_to_pose_bt_xml"
    (remark,) = understood({"bt_navigator": {key: "mine.xml"}}).remarks
    said = "no such parameter; 'default_nav_to_pose_bt_xml' stands higher up"
    assert (remark.kind, remark.reason) == (Kind.UNKNOWN, said)


@pytest.mark.parametrize("axis", ["x", "y", "theta"])
def test_a_deceleration_of_the_wrong_sign_is_turned(axis: str) -> None:
    key = f"FollowPath.decel_lim_{axis}"
    found = understood({"controller_server": {**DWB, key: 2.5}})
    assert value(found, "controller_server", key) == -2.5
    assert f"{key}: 2.5 would slow nothing down: -2.5 holds" in str(found.remarks[-1])


@pytest.mark.parametrize(
    ("given", "holds", "told"),
    [
        ({"max_accel": [3.0, 2.0, 3.0]}, (-2.5, -2.0, -3.2), 1),  # Nav2's default has 0 for y
        ({"max_accel": [3.0, 2.0, 3.0], "max_decel": [0.0, -1.0, -3.0]}, (-3.0, -1.0, -3.0), 1),
        ({"max_accel": [2.5, 0.0, 3.2]}, (-2.5, 0.0, -3.2), 0),
    ],
)
def test_a_smoother_brakes_what_it_accelerates(
    given: dict[str, Any], holds: tuple[float, ...], told: int
) -> None:
    found = understood({"velocity_smoother": given})
    assert tuple(value(found, "velocity_smoother", "max_decel")) == holds
    assert str(found.remarks).count("would let what max_accel sets moving never stop") == told
    assert [one.safety for one in found.remarks] == [True] * told


def test_the_constrained_smoother_takes_its_own_weights_and_tolerances() -> None:
    own: dict[str, Any] = {"w_smooth": 5e6, "cost_check_points": (-0.2, 0.0, 1.0)}
    own |= {"optimizer.max_iterations": 70, "optimizer.gradient_tol": 5e3}
    unused = {"optimizer.debug_optimizer": True, "optimizer.linear_solver_type": "DENSE_QR"}
    given = {"plugin": "nav2_constrained_smoother/ConstrainedSmoother", **own, **unused}
    values = {"smoother_plugins": ["Bent"], **{f"Bent.{key}": v for key, v in given.items()}}
    found = understood({"smoother_server": values})
    assert {remark.kind for remark in found.remarks} == {Kind.NOT_NEEDED}
    assert len(found.remarks) == len(unused)
    assert {key: value(found, "smoother_server", f"Bent.{key}") for key in own} == own


def test_a_class_of_nav2_that_is_misspelt_refuses_the_file(tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    text = "planner_server: {ros__parameters: {GridBased: {plugin: nav2_navfn_planner::Navfn}}}"
    path.write_text(text)
    (problem,) = check_file(path).problems
    assert "did you mean 'nav2_navfn_planner::NavfnPlanner'" in problem


def test_a_robot_s_description_in_one_line_is_no_placeholder() -> None:
    text = '<?xml version="1.0" ?><robot name="r"><link name="l"><visual></visual></link></robot>'
    found = understood({"robot_state_publisher": {"robot_description": text}})
    assert value(found, "robot_state_publisher", "robot_description") == text


def test_an_outline_of_corners_names_leaves_the_radius() -> None:
    found = understood({LOCAL: {"footprint": "[[front_left], [front_right], [rear]]"}})
    assert value(found, LOCAL, "robot_radius") == shipped_parameters()[LOCAL]["robot_radius"]


def test_a_word_in_capitals_is_a_value_where_texts_are() -> None:
    assert understood({"velocity_smoother": {"feedback": "OPEN_LOOP"}}).remarks == []


def test_a_zone_that_is_not_kept_is_a_line_of_its_own(tmp_path: Path) -> None:
    path = written(tmp_path, "filter_mask_server: {ros__parameters: {yaml_filename: a.yaml}}")
    (remark,) = check_file(path).remarks
    assert str(remark).startswith(f"{path}:1: no effect yet (SAFETY): filter_mask_server: ")


def test_what_is_below_another_node_s_parameters_is_read_by_none() -> None:
    found = understood({"/**": {f"{LOCAL.partition('/')[0]}.ros__parameters.width": 5}})
    assert "its section starts a line of its own" in only(found, Kind.UNKNOWN)


def test_what_stands_twice_is_told(tmp_path: Path) -> None:
    path = written(tmp_path, "amcl: {ros__parameters: {alpha1: 0.1, alpha1: 0.3}}")
    (remark,) = check_file(path).remarks
    assert (remark.kind, remark.where) == (Kind.UNKNOWN, "amcl: alpha1")


def test_a_strict_command_refuses_what_is_unknown(tmp_path: Path) -> None:
    path = written(tmp_path, "amcl: {ros__parameters: {alpah2: 0.2}}")
    words = ["nav", "--slam", "--params", str(path)]
    assert gather(parse(words))
    with pytest.raises(ConfigError, match="alpah2: no such parameter; the nearest is 'alpha2'"):
        gather(parse([*words, "--strict"]))


def test_a_node_s_word_on_its_clock_is_kept() -> None:
    found = understood({"slam_toolbox": {"use_sim_time": False}})
    assert (found.remarks, found.parameters["slam_toolbox"]["use_sim_time"]) == ([], False)


@pytest.mark.parametrize(
    ("values", "program"),
    [
        ("use_stamped: false, topics: {joy: {topic: joy_vel, priority: 9}}", "twist_mux twist_mux"),
        ("delay: 3.0, yaw_offset: 0.1", "robot_localization navsat_transform_node"),
        ("axis_linear: {x: 1}, enable_button: 4", "teleop_twist_joy teleop_node"),
        (
            "filter1: {type: laser_filters/LaserScanBoxFilter, params: {box_frame: a}}",
            "laser_filters scan_to_scan_filter_chain",
        ),
    ],
)
def test_names_for_every_node_are_those_of_a_node_that_runs_alone(
    values: str, program: str, tmp_path: Path
) -> None:
    file = written(tmp_path, f"/**: {{ros__parameters: {{{values}, nobodys: 1}}}}", "alone.yaml")
    found = check_file(file)
    *known, unknown = found.remarks
    assert found.problems == []
    assert {(one.kind, f"'ros2 run {program}" in one.reason) for one in known} == {
        (Kind.NOT_NEEDED, True)
    }
    assert (unknown.kind, unknown.where) == (Kind.UNKNOWN, "/**: nobodys")
