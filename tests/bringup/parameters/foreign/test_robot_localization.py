"""Files of robot_localization: sections of any name, `/**`, and where their nodes run."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.errors import ConfigError
from bringup.parameters.checking import check_file
from bringup.parameters.remarks import Checked, Kind
from bringup.ros2.programs import node
from bringup.ros2.verbs.forward import ros_arguments
from bringup.stack import (
    EKF,
    NAVIGATION_GROUP,
    ODOMETRY_GROUP,
    SIM_GROUP,
    fusion_nodes,
    with_further,
)
from tests.helpers.files import written
from tests.helpers.processes import given_parameters

MASK = [True, *[False] * 14]
ONE: dict[str, Any] = {
    "frequency": 30.0,
    "sensor_timeout": 0.1,
    "print_diagnostics": True,
    "odom0": "example/odom",
    "odom0_config": MASK,
    "odom0_nodelay": True,
    "pose0": "example/pose",
    "pose0_config": MASK,
    "pose0_rejection_threshold": 2.0,
    "imu12": "example/imu",
    "imu12_config": MASK,
    "imu12_remove_gravitational_acceleration": True,
    "process_noise_covariance": [0.1] * 225,
}


def _checked(tmp_path: Path, sections: dict[str, Any], text: str = "") -> Checked:
    found = {name: {"ros__parameters": values} for name, values in sections.items()}
    return check_file(written(tmp_path, json.dumps(found) if sections else text))


@pytest.mark.parametrize(
    "section", ["ekf_filter_node", "**/ekf_filter_node", "ekf_localization", "/**", "robot/ukf_se"]
)
def test_a_section_of_any_name_is_a_filter(tmp_path: Path, section: str) -> None:
    read = _checked(tmp_path, {section: ONE})
    assert not read.problems
    assert {remark.kind for remark in read.remarks} == {Kind.NOT_NEEDED}
    (spec,) = fusion_nodes(read.parameters)
    assert spec.cls == ("UkfFilterNode" if "ukf" in section else "EkfFilterNode")
    kept = read.parameters[spec.name]
    assert kept["odom0_config"] == MASK
    assert kept["imu12"] == "example/imu"
    assert not {"print_diagnostics", "odom0_nodelay"} & kept.keys()


def test_numbers_with_an_exponent_are_numbers(tmp_path: Path) -> None:
    numbers = ", ".join(["1e-9"] * 15)
    text = (
        f"e:\n  ros__parameters: {{odom0_config: {MASK}, initial_estimate_covariance: [{numbers}]}}"
    )
    read = _checked(tmp_path, {}, text.replace("True", "true").replace("False", "false"))
    assert not read.problems
    assert read.parameters["e"]["initial_estimate_covariance"][0] == 1e-9


def test_a_mask_of_another_length_and_misspelt_names_are_named(tmp_path: Path) -> None:
    read = _checked(tmp_path, {"ekf": {"odom0_config": [True] * 3, "two_d_mod": True}})
    assert len(read.problems) == 1
    assert "'odom0_config' has 3 values; valid: 15" in read.problems[0]
    assert [r.where for r in read.remarks if r.kind is Kind.UNKNOWN] == ["ekf: two_d_mod"]


def test_our_own_fusion_stays_until_a_filter_estimates_in_odom() -> None:
    ours = {"ekf_filter_node": {"odom0": "wheel_odom", "imu0": "imu/data"}}
    for group in (SIM_GROUP, ODOMETRY_GROUP):
        assert with_further(group, ours) == group
        both = {"global": {**ONE, "world_frame": "map"}, **ours}
        assert {EKF.name, "global"} <= {spec.name for spec in with_further(group, both).nodes}
        dual = {"global": {**ONE, "world_frame": "map"}, "local": ONE}
        names = {spec.name for spec in with_further(group, dual).nodes}
        assert {"global", "local"} <= names
        assert EKF.name not in names
    assert with_further(NAVIGATION_GROUP, {"local": ONE}) == NAVIGATION_GROUP


def test_gps_is_converted_under_any_name_that_begins_so(tmp_path: Path) -> None:
    values = {"yaw_offset": 1.57, "broadcast_utm_transform": True, "transform_timeout": 0.1}
    read = _checked(tmp_path, {"navsat_transform": values})
    assert not read.problems
    assert {remark.kind for remark in read.remarks} == {Kind.NOT_NEEDED}
    found = with_further(SIM_GROUP, read.parameters).nodes
    assert {EKF.name, "navsat_transform"} <= {spec.name for spec in found}


def _started(words: list[str], monkeypatch: pytest.MonkeyPatch, program: str) -> list[str]:
    started: list[list[str]] = []
    monkeypatch.setattr(os, "execv", lambda path, words: started.append(words))
    node.start("robot_localization", program, ros_arguments(["--ros-args", *words]))
    return started[0]


@pytest.mark.parametrize("program", ["ekf_node", "ukf_node"])
def test_ros2_run_takes_files_names_and_remappings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str
) -> None:
    file = written(tmp_path, json.dumps({"mine": {"ros__parameters": ONE}}), "ekf.yaml")
    words = ["--params-file", str(file), "-p", "frequency:=10.0", "-r", "__node:=mine"]
    got = _started([*words, "-r", "odometry/filtered:=odom"], monkeypatch, program)
    values = given_parameters(got)
    assert values["mine"]["frequency"] == 10.0
    assert values["mine"]["odom0_config"] == MASK
    assert not values["mine"]["use_sim_time"]
    assert got[3] == f"robot_localization/{program}"
    assert got[-3:] == ["--ros-args", "-r", "odometry/filtered:=odom"]


def test_ros2_run_refuses_what_is_not_valid(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["-p", "odom0_config:=[true]"]
    with pytest.raises(ConfigError, match="'odom0_config' has 1 values; valid: 15"):
        _started(words, monkeypatch, "ekf_node")


@pytest.mark.parametrize("name", ["ekf_filter_node", "ukf_filter_node", "ukf_node", "ekf_map"])
def test_a_filter_is_checked_once_under_any_name(name: str, tmp_path: Path) -> None:
    mask = f"[{'false, ' * 14}1]"
    text = f"{name}: {{ros__parameters: {{odom0: odom, nobodys: 1, odom0_config: {mask}}}}}"
    found = check_file(written(tmp_path, text))
    assert [one.where for one in found.remarks] == [f"{name}: nobodys"]
    assert len(found.problems) == 1
