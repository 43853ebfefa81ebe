"""What a robot's names reach, and which processes `robot` starts."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.config import flatten, load
from arjuna_core.files.shipped import shipped_file
from bringup.cli_parser import parse
from bringup.parameters.checking import over_shipped, problems_of
from bringup.parameters.files import for_node, merged, shipped_parameters
from bringup.parameters.inputs import gather, groups_of
from bringup.parameters.sources import ROBOT_NAMES, of_names
from bringup.stack import DEMO_GROUPS, REAL_STACKS, VELOCITY_CHAIN

pytestmark = pytest.mark.ros
OPTIONS = {name: f"--{name.replace('_', '-')}" for name in ROBOT_NAMES}


@pytest.mark.parametrize("where", [["--slam"], ["--map", "maps/office.yaml"]])
def test_every_option_is_a_parameter_of_the_nodes_that_run(where: list[str]) -> None:
    given = [word for option in OPTIONS.values() for word in (option, "other")]
    arguments = parse(["robot", *where, *given, "--robot", "urdf/arjuna.urdf"])
    groups = groups_of(arguments)
    shipped = shipped_parameters()
    found = of_names(vars(arguments), groups, shipped)
    specs = [spec for group in groups for spec in group.nodes]
    assert problems_of(merged(shipped, found), specs) == []
    assert set(found) <= {spec.name for group in groups for spec in group.nodes}
    assert found["collision_monitor"]["base_frame_id"] == "other"
    assert found["collision_monitor"]["cmd_vel_out_topic"] == "other"
    assert "cmd_vel_topic" not in found.get("controller_server", {})


@pytest.mark.parametrize("said", ["controller_server", "velocity_smoother", "/**"])
def test_a_chain_of_velocities_is_of_one_type(said: str, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text(f'"{said}": {{ros__parameters: {{enable_stamped_cmd_vel: true}}}}')
    parameters = over_shipped([file])
    for name in VELOCITY_CHAIN:
        assert parameters[name]["enable_stamped_cmd_vel"] is True
    plain = over_shipped([])
    assert not any("enable_stamped_cmd_vel" in plain.get(name, {}) for name in VELOCITY_CHAIN)


@pytest.mark.parametrize("command", [["slam"], ["nav", "--slam"], ["explore"], ["robot", "--slam"]])
def test_a_base_frame_reaches_every_node_that_a_command_runs(command: list[str]) -> None:
    arguments = parse([*command, "--base-frame", "chassis"])
    parameters = gather(arguments)
    for spec in (spec for group in groups_of(arguments) for spec in group.nodes):
        key = ROBOT_NAMES["base_frame"].get(spec.name)
        assert key is None or parameters[spec.name][key] == "chassis"
        config = flatten(load(spec.config, for_node(parameters, spec.name)))
        frames = {name for name, value in config.items() if value == "base_footprint"}
        assert frames == set(), spec.name


def test_time_is_the_system_s() -> None:
    parameters = gather(parse(["robot", "--slam"]))
    assert parameters["/**"]["use_sim_time"] is False


@pytest.mark.parametrize(
    ("given", "started"),
    [
        ([], set()),
        (["--robot", "urdf/arjuna.urdf"], {"description"}),
        (["--imu", "imu"], {"odometry"}),
    ],
)
def test_what_a_driver_brings_is_not_started(given: list[str], started: set[str]) -> None:
    names = {group.name for group in groups_of(parse(["robot", "--slam", *given]))}
    assert names == {"slam", "navigation"} | started
    assert names <= {group.name for group in REAL_STACKS["robot --slam"]}


def test_a_simulated_robot_s_own_names_and_outline_reach_the_demo(tmp_path: Path) -> None:
    robot = tmp_path / "other.urdf"
    text = shipped_file("urdf/arjuna.urdf").read_text(encoding="utf-8")
    robot.write_text(text.replace("base_footprint", "chassis"), encoding="utf-8")
    file = tmp_path / "other.yaml"
    file.write_text(
        "{amcl: {ros__parameters: {base_frame_id: lidar_link}},"
        " explorer: {ros__parameters: {costmap: {robot_radius: 0.4}}}}",
        encoding="utf-8",
    )
    parameters = gather(parse(["demo", "--robot", str(robot), "--params", str(file)]))
    assert parameters["slam_toolbox"]["base_frame"] == "chassis"
    assert parameters["explorer"]["robot_base_frame"] == "chassis"
    assert parameters["amcl"]["base_frame_id"] == "lidar_link"
    assert parameters["local_costmap/local_costmap"]["footprint"].startswith("[[0.225, -0.15]")
    assert "costmap.footprint" not in parameters["explorer"]


@pytest.mark.parametrize("command", [["slam"], ["nav", "--map", "maps/race_track.yaml"]])
def test_a_robot_s_file_tells_its_names_to_what_runs_beside_the_simulator(
    command: list[str],
) -> None:
    arguments = parse([*command, "--robot", "urdf/udacity_bot.xacro", "--odom-frame", "world"])
    parameters = gather(arguments)
    (node,) = {"slam_toolbox", "amcl"} & {s.name for g in groups_of(arguments) for s in g.nodes}
    assert parameters[node]["scan_topic"] == "/udacity_bot/laser/scan"
    assert "world" in parameters[node].values()


def test_the_shipped_robot_keeps_its_shipped_parameters() -> None:
    named, plain = gather(parse(["demo", "--robot", "urdf/arjuna.urdf"])), gather(parse(["demo"]))
    assert named["amcl"] == plain["amcl"]
    assert named["local_costmap/local_costmap"] == plain["local_costmap/local_costmap"]


def test_standard_topics_are_no_names_of_the_robot(tmp_path: Path) -> None:
    file = tmp_path / "plain.yaml"
    file.write_text("sim: {ros__parameters: {standard_topics: true}}", encoding="utf-8")
    given = ["demo", "--robot", "urdf/udacity_bot.xacro", "--params", str(file)]
    amcl = gather(parse(given))["amcl"]
    assert "scan_topic" not in amcl
    assert amcl["base_frame_id"] == "robot_footprint"


def test_the_demo_has_all_its_groups_with_slam_too() -> None:
    assert groups_of(Namespace(command="demo", slam=True)) == DEMO_GROUPS
