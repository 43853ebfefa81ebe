"""What the options of `robot` reach, and which processes it starts."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from bringup.cli_parser import parse
from bringup.parameters.composition import check_parameters
from bringup.parameters.inputs import all_nodes, gather, groups_of
from bringup.parameters.real_robot import KEYS, real_robot
from bringup.stack import REAL_STACKS

pytestmark = pytest.mark.ros
OPTIONS = {name: f"--{name.replace('_', '-')}" for name in KEYS}


@pytest.mark.parametrize("where", [["--slam"], ["--map", "maps/office.yaml"]])
def test_every_option_is_a_parameter_of_the_nodes_that_run(where: list[str]) -> None:
    given = [word for option in OPTIONS.values() for word in (option, "other")]
    arguments = parse(["robot", *where, *given, "--robot", "urdf/arjuna.urdf"])
    groups = groups_of(arguments)
    found = real_robot(arguments, groups)
    known = [spec.name for spec in all_nodes()]
    check_parameters(found, groups, known)
    assert set(found) <= {spec.name for group in groups for spec in group.nodes}
    assert found["collision_monitor"]["base_frame_id"] == "other"


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
