"""`ros2 run PACKAGE EXECUTABLE` of nodes that stand alone: parameters reach the node's process."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.errors import ConfigError
from bringup.parameters.files import of_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs import node
from bringup.ros2.verbs.forward import ros_arguments
from bringup.stack import PROGRAMS
from tests.helpers.processes import given_parameters

TEXT = '<?xml version="1.0"?>\n<robot name="r"><link name="base_link"/></robot>'
RSP = "robot_state_publisher", "robot_state_publisher"


def _started(
    names: tuple[str, str], words: list[str], monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    started: list[list[str]] = []
    monkeypatch.setattr(os, "execv", lambda path, words: started.append(words))
    node.start(*names, ros_arguments(words))
    values = given_parameters(started[0])
    assert started[0][3] == "/".join(names)
    return values


def test_a_descriptions_text_is_a_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    description = ["-p", f"robot_description:={TEXT}", "-p", "frame_prefix:=a/"]
    others = ["-p", "use_sim_time:=true", "-p", "publish_frequency:=30.0", "-r", "tf:=other"]
    values = _started(RSP, ["--ros-args", *description, *others], monkeypatch)
    assert values == {
        "robot_state_publisher": {
            "robot_description": TEXT,
            "frame_prefix": "a/",
            "use_sim_time": True,
            "publish_frequency": 30.0,
        }
    }


def test_a_text_may_be_long(monkeypatch: pytest.MonkeyPatch) -> None:
    text = f"{TEXT}<!--{'x' * 200_000}-->"
    values = _started(RSP, ["--ros-args", "-p", f"robot_description:={text}"], monkeypatch)
    assert values["robot_state_publisher"]["robot_description"] == text


def test_a_file_is_taken_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = _started(RSP, [str(tmp_path / "a.urdf")], monkeypatch)
    robot = {"robot": str(tmp_path / "a.urdf"), "use_sim_time": False}
    assert values == {"robot_state_publisher": robot}


def test_no_description_is_refused() -> None:
    with pytest.raises(Ros2Error, match="no robot: -p robot_description:="):
        node.start(*RSP, ros_arguments([]))


FILES: dict[tuple[str, str], str] = {
    ("twist_mux", "twist_mux"): """
twist_mux:
  ros__parameters:
    topics:
      navigation: {topic: nav_vel, timeout: 0.5, priority: 10}
      joystick: {topic: joy_vel, timeout: 0.5, priority: 100}
    locks:
      pause: {topic: pause_navigation, timeout: 0.0, priority: 100}
""",
    ("teleop_twist_joy", "teleop_node"): """
teleop_twist_joy_node:
  ros__parameters:
    axis_linear:
      x: 1
    scale_linear:
      x: 0.7
    scale_linear_turbo:
      x: 1.5
    axis_angular:
      yaw: 0
    scale_angular:
      yaw: 0.4
    enable_button: 2
    enable_turbo_button: 5
""",
    ("laser_filters", "scan_to_scan_filter_chain"): """
scan_to_scan_filter_chain:
  ros__parameters:
    filter1:
      name: angle
      type: laser_filters/LaserScanAngularBoundsFilter
      params:
        lower_angle: -1.57
        upper_angle: 1.57
    filter2:
      name: range
      type: laser_filters/LaserScanRangeFilter
      params:
        use_message_range_limits: false
        lower_threshold: 0.3
        upper_threshold: 3.0
        lower_replacement_value: -.inf
        upper_replacement_value: .inf
    filter3:
      name: median
      type: laser_filters/LaserArrayFilter
      params:
        range_filter_chain:
          filter1:
            name: median_5
            type: filters/MultiChannelMedianFilterFloat
            params: {number_of_observations: 5}
""",
    ("diagnostic_aggregator", "aggregator_node"): """
analyzers:
  ros__parameters:
    path: Aggregation
    arms:
      type: diagnostic_aggregator/GenericAnalyzer
      path: Arms
      startswith: ['/arms']
    topology:
      type: 'diagnostic_aggregator/AnalyzerGroup'
      path: Topology
      analyzers:
        left:
          type: diagnostic_aggregator/GenericAnalyzer
          path: Left
          contains: '/left'
""",
    ("imu_filter_madgwick", "imu_filter_madgwick_node"): """
imu_filter_madgwick:
  ros__parameters:
    stateless: false
    use_mag: false
    publish_tf: false
    reverse_tf: false
    fixed_frame: "odom"
    constant_dt: 0.0
    publish_debug_topics: false
    world_frame: "enu"
    gain: 0.1
    zeta: 0.0
    mag_bias_x: 0.0
    orientation_stddev: 0.0
""",
    ("explore_lite", "explore"): """
/**:
  ros__parameters:
    robot_base_frame: base_link
    return_to_init: true
    costmap_topic: map
    costmap_updates_topic: map_updates
    visualize: true
    planner_frequency: 0.15
    progress_timeout: 30.0
    potential_scale: 3.0
    orientation_scale: 0.0
    gain_scale: 1.0
    transform_tolerance: 0.3
    min_frontier_size: 0.75
""",
    ("pointcloud_to_laserscan", "pointcloud_to_laserscan_node"): """
pointcloud_to_laserscan:
  ros__parameters:
    target_frame: base_link
    transform_tolerance: 0.01
    min_height: 0.0
    max_height: 1.0
    angle_min: -1.5708
    angle_max: 1.5708
    angle_increment: 0.0087
    scan_time: 0.3333
    range_min: 0.45
    range_max: 4.0
    use_inf: true
    inf_epsilon: 1.0
""",
    ("depthimage_to_laserscan", "depthimage_to_laserscan_node"): """
depthimage_to_laserscan:
  ros__parameters:
    scan_time: 0.033
    range_min: 0.45
    range_max: 10.0
    scan_height: 1
    output_frame: "camera_depth_frame"
""",
    ("nav2_map_server", "costmap_filter_info_server"): """
costmap_filter_info_server:
  ros__parameters:
    type: 0
    filter_info_topic: "/costmap_filter_info"
    mask_topic: "/keepout_filter_mask"
    base: 0.0
    multiplier: 1.0
""",
    ("joy", "joy_node"): """
joy_node:
  ros__parameters:
    device_id: 0
    deadzone: 0.5
    autorepeat_rate: 20.0
    sticky_buttons: false
""",
    ("joint_state_publisher", "joint_state_publisher"): """
joint_state_publisher:
  ros__parameters:
    rate: 30
    source_list: [arm/joint_states]
    zeros:
      shoulder: 1.5
    dependent_joints:
      finger: {parent: thumb, factor: -1.0}
""",
}


@pytest.mark.parametrize("names", FILES, ids="/".join)
def test_a_usual_file_is_taken_whole(
    names: tuple[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "usual.yaml"
    file.write_text(FILES[names], encoding="utf-8")
    values = _started(names, ["--ros-args", "--params-file", str(file)], monkeypatch)
    assert capfd.readouterr().err == ""
    (own,), (given,) = values.values(), of_file(file).values.values()
    assert own == {**given, "use_sim_time": False}


def test_a_class_of_filter_that_there_is_not_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["--ros-args", "-p", "filter1.type:=laser_filters/NoFilter"]
    with pytest.raises(ConfigError, match=r"'filter1\.type' is 'laser_filters/NoFilter'; valid"):
        _started(("laser_filters", "scan_to_scan_filter_chain"), words, monkeypatch)


def test_every_program_has_a_node() -> None:
    for spec in PROGRAMS.values():
        assert spec.config


@pytest.mark.parametrize(
    ("names", "words", "expected"),
    [
        (
            ("nav2_controller", "controller_server"),
            ["-p", "controller_frequency:=10.0", "--params-file", "FILE"],
            {
                "controller_server": {
                    "controller_frequency": 10.0,
                    "use_sim_time": True,
                    "cmd_vel_topic": "cmd_vel",
                },
                "local_costmap/local_costmap": {"width": 4, "use_sim_time": True},
            },
        ),
        (
            ("nav2_velocity_smoother", "velocity_smoother"),
            ["-p", "cmd_vel_out_topic:=smooth"],
            {"velocity_smoother": {"cmd_vel_in_topic": "cmd_vel", "cmd_vel_out_topic": "smooth"}},
        ),
        (
            ("nav2_lifecycle_manager", "lifecycle_manager"),
            ["-r", "__node:=manager", "-p", "node_names:=[planner_server]"],
            {
                "lifecycle_manager_navigation": {
                    "node_names": ["planner_server"],
                    "use_sim_time": False,
                }
            },
        ),
    ],
)
def test_a_server_of_nav2_brings_its_costmap(
    names: tuple[str, str],
    words: list[str],
    expected: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "nav2.yaml"
    path.write_text(
        "/**: {ros__parameters: {use_sim_time: true}}\n"
        "local_costmap: {local_costmap: {ros__parameters: {width: 4}}}\n"
    )
    given = [str(path) if word == "FILE" else word for word in words]
    values = _started(names, ["--ros-args", *given], monkeypatch)
    assert list(values) == list(expected)
    found = {node: {key: values[node][key] for key in own} for node, own in expected.items()}
    assert found == expected


@pytest.mark.parametrize(
    ("sections", "node_name", "said"),
    [
        ("ekf_filter_node", "ekf_filter", "'ekf_filter' and its section is 'ekf_filter_node'"),
        ("ekf_filter_node", "ekf_filter_node", ""),
        ("ekf_odom", "ekf_filter_node", "'ekf_filter_node' and its section is 'ekf_odom'"),
        ("amcl ekf_filter_node", "ekf_odom", "its section is 'ekf_filter_node'"),
        ("amcl map_server", "ekf_filter_node", ""),
        ("/**", "ekf_odom", ""),
    ],
)
def test_parameters_of_a_node_of_another_name_are_said_to_be_none_of_it(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    sections: str,
    node_name: str,
    said: str,
) -> None:
    path = tmp_path / "ekf.yaml"
    own = "{name}:\n  ros__parameters:\n    use_sim_time: true\n"
    path.write_text("".join(own.format(name=each) for each in sections.split()))
    words = ["--ros-args", "-r", f"__node:={node_name}", "--params-file", str(path)]
    _started(("robot_localization", "ekf_node"), words, monkeypatch)
    printed = capsys.readouterr().err
    assert ("nothing of it is taken" in printed) is bool(said)
    assert said in printed
