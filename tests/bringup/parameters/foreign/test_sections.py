"""The sections of a file by our nodes: those of several robots, and what launch files fill."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bringup.parameters.checking import check_file
from bringup.parameters.files import Parameters, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.remarks import Checked, Kind
from bringup.stack import all_nodes
from tests.helpers.files import written

pytestmark = pytest.mark.ros


def understood(given: Parameters, namespace: str = "") -> Checked:
    return understand(given, shipped_parameters(), all_nodes(), namespace)


def only(found: Checked, kind: Kind) -> str:
    (remark,) = found.remarks
    assert remark.kind is kind
    return str(remark)


def test_of_two_robots_sections_those_of_one_hold() -> None:
    given = {"robot1/amcl": {"max_beams": 30}, "robot2/amcl": {"max_beams": 31}}
    found = understood(given)
    assert "robot2/amcl: of a robot beside 'robot1', whose" in only(found, Kind.UNKNOWN)
    assert found.parameters["amcl"]["max_beams"] == 30
    assert understood(given, "robot2").parameters["amcl"]["max_beams"] == 31


@pytest.mark.parametrize("section", ["<robot_namespace>/amcl", "<NAMESPACE_>amcl"])
@pytest.mark.parametrize(("namespace", "topic"), [("", "/scan"), ("robot1", "/robot1/scan")])
def test_the_robot_s_namespace_fills_its_placeholder(
    namespace: str, topic: str, section: str
) -> None:
    given = {section: {"scan_topic": "<robot_namespace>/scan"}}
    assert understood(given, namespace).parameters["amcl"]["scan_topic"] == topic


@pytest.mark.parametrize(
    ("key", "text"), [("scan_topic", "<robot_name>/scan"), ("do_beamskip", "BEAM_SKIP_ENABLED")]
)
def test_what_a_launch_file_fills_keeps_its_default(key: str, text: str) -> None:
    found = understood({"amcl": {key: text}})
    assert f"amcl: {key}: a launch file fills '{text}'" in only(found, Kind.NO_EFFECT)
    assert key not in found.parameters["amcl"]


def test_another_robot_s_section_is_not_needed() -> None:
    found = understood({"robot2/amcl": {"max_beams": 30}}, "robot1")
    assert "'amcl' of another namespace" in only(found, Kind.NOT_NEEDED)


def test_a_node_of_nav2_under_a_name_of_its_own_is_run_beside_the_others() -> None:
    found = understood({"teleop_velocity_smoother": {"max_velocity": [0.3, 0.0, 0.5]}})
    command = "ros2 run nav2_velocity_smoother velocity_smoother --ros-args -r __node:=teleop_vel"
    assert command in only(found, Kind.UNKNOWN)


def test_shapes_as_zones_are_a_line_of_safety() -> None:
    remark = only(understood({"vector_object_server": {"shapes": ["a"]}}), Kind.NO_EFFECT)
    assert remark.startswith("no effect yet (SAFETY): vector_object_server: ")


@pytest.mark.parametrize(
    ("values", "program"),
    [
        (
            {"filter1.type": "laser_filters/InterpolationFilter", "filter1.name": "a"},
            "laser_filters scan_to_scan_filter_chain",
        ),
        (
            {"topics.nav.topic": "cmd_vel_nav", "topics.nav.priority": 10},
            "twist_mux twist_mux",
        ),
        ({"axis_linear.x": 1, "enable_button": 4}, "teleop_twist_joy teleop_node"),
        ({"gain": 0.1, "zeta": 0.0}, "imu_filter_madgwick imu_filter_madgwick_node"),
    ],
)
def test_a_program_s_section_is_known_under_any_name(
    values: dict[str, Any], program: str, tmp_path: Path
) -> None:
    section = json.dumps({"robot/my_node": {"ros__parameters": values}})
    read = check_file(written(tmp_path, section))
    (remark,) = read.remarks
    assert remark.kind is Kind.NOT_NEEDED
    assert f"'ros2 run {program} --ros-args -r __node:=my_node" in str(remark)
    section = json.dumps({"my_node": {"ros__parameters": {**values, "misspelt": 1}}})
    read = check_file(written(tmp_path, section))
    assert any("my_node: misspelt: no such parameter" in str(one) for one in read.remarks)
