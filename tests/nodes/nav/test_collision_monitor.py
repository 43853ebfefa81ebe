"""collision_monitor: between the smoother and the wheels."""

from __future__ import annotations

import math
from typing import Any

import pytest
from nav2_msgs.msg import CollisionMonitorState
from nav2_msgs.srv import Toggle

from arjuna_core.ros import qos
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.parameters.files import shipped_parameters
from bringup.stack import COLLISION_MONITOR, LOCAL_COSTMAP
from tests.helpers.nav.monitored import drive
from tests.helpers.nav.navigation import PlayedRobot
from tests.nav.worlds import block

State = CollisionMonitorState


def made(body: str = "", **parameters: Any) -> PlayedRobot:
    early = {"FootprintApproach.time_before_collision": 1.2}
    monitor, costmap = COLLISION_MONITOR.name, LOCAL_COSTMAP.name
    robot = PlayedRobot({monitor: early | parameters, costmap: {"body": body}})
    block(robot.world, 6.7, 4.5, 0.1, 2.0)  # a wall at x = 1.2
    robot.bring_up(LOCAL_COSTMAP, COLLISION_MONITOR)
    robot.run(0.5)
    return robot


def states(robot: PlayedRobot) -> list[Any]:
    return robot.bench.collect(State, "/collision_monitor_state", qos.LATCHED)


def actions(messages: list[Any]) -> list[tuple[int, str]]:
    return [(each.action_type, each.polygon_name) for each in messages]


def test_the_robot_stops_before_a_wall_and_may_drive_back(robot: PlayedRobot) -> None:
    changes = states(robot)
    drive(robot, 0.4, 1.0)
    assert robot.command.x == pytest.approx(0.4)
    drive(robot, 0.4, 7.0)
    assert robot.pose.x < 1.2 - 0.25
    assert robot.command.x < 0.06
    assert actions(changes) == [(State.APPROACH, "FootprintApproach")]
    drive(robot, -0.2, 1.0)
    assert robot.command.x == pytest.approx(-0.2)
    assert actions(changes)[-1] == (State.DO_NOTHING, "")


CORNERS = "[[0.225, 0.15], [0.2, 0.19], [-0.2, 0.19], [-0.2, -0.19], [0.2, -0.19], [0.225, -0.15]]"


@pytest.mark.parametrize("body", ["", CORNERS])
def test_a_turn_keeps_the_corners_free_that_stand_out_of_the_costmap_s_circle(body: str) -> None:
    robot = made(body=body)
    robot.pose = SE2(1.2 - 0.24, 0.0)
    drive(robot, 0.0, 1.0, yaw_rate=0.8)
    assert (robot.command == STILL) is bool(body)
    drive(robot, -0.2, 0.2)
    assert robot.command.x == pytest.approx(-0.2)


def test_without_sight_the_robot_stands(robot: PlayedRobot) -> None:
    changes = states(robot)
    robot.sees = False
    drive(robot, 0.2, 0.16)
    assert robot.command.x == pytest.approx(0.2)
    drive(robot, 0.2, 0.08)
    assert 0.0 < robot.command.x < 0.17
    drive(robot, 0.2, 0.16)
    assert robot.command == STILL
    assert actions(changes) == [(State.SLOWDOWN, "invalid source"), (State.STOP, "invalid source")]
    robot.sees = True
    drive(robot, -0.2, 0.4)
    assert robot.command.x == pytest.approx(-0.2)


def test_it_can_be_switched_off_and_on(robot: PlayedRobot) -> None:
    def toggle(enable: bool) -> None:
        request = Toggle.Request(enable=enable)
        assert robot.bench.call(Toggle, "/collision_monitor/toggle", request).success

    robot.pose = SE2(0.85, 0.0)
    robot.run(0.2)
    drive(robot, 0.1, 0.2)
    assert robot.command.x < 0.1
    toggle(False)
    drive(robot, 0.1, 0.1)
    assert robot.command.x == pytest.approx(0.1)
    toggle(True)
    drive(robot, 0.1, 0.1)
    assert robot.command.x < 0.1


@pytest.mark.parametrize("timeout", [2.0, 0.3])
def test_zero_is_repeated_for_a_while_only(timeout: float) -> None:
    robot = made(stop_pub_timeout=timeout)
    drive(robot, 0.0, 1.0)
    robot.forget()
    drive(robot, 0.0, 0.5)
    assert bool(robot.commands) is (timeout == 2.0)
    drive(robot, 0.0, 1.5)
    robot.forget()
    drive(robot, 0.0, 0.5)
    assert not robot.commands
    drive(robot, 0.1, 0.1)
    assert robot.command.x == pytest.approx(0.1)


@pytest.mark.parametrize("brakes", [True, False])
def test_a_silent_scanner_slows_the_robot_before_the_timeout_or_not(brakes: bool) -> None:
    robot = made(source_timeout=2.0, brake_before_source_timeout=brakes)
    drive(robot, 0.1, 0.5)
    robot.sees = False
    drive(robot, 0.1, 1.6)
    assert (robot.command.x < 0.09) is brakes


def test_a_blind_robot_names_the_silent_topic(capfd: pytest.CaptureFixture[str]) -> None:
    robot = made(**{"scan.topic": "front/scan"})
    drive(robot, 0.2, 0.5)
    assert robot.command == STILL
    lines = [line for line in capfd.readouterr().err.splitlines() if "STOP invalid" in line]
    (line,) = lines
    assert "[WARN]" in line
    where = "no scan has come on /front/scan: nobody publishes it; scans are on /scan"
    assert line.endswith(f"STOP invalid source: {where}: set scan.topic")


@pytest.mark.parametrize(
    ("parameter", "warning"),
    [
        (
            "cmd_vel_in_topic",
            "no command comes on '/raw': nobody publishes it; commands are on /cmd_vel_smoothed:"
            " set cmd_vel_in_topic",
        ),
        (
            "cmd_vel_out_topic",
            "nobody takes the velocities on 'raw': set cmd_vel_out_topic;"
            " 'cmd_vel_smoothed' must not be the robot's own",
        ),
        ("state_topic", ""),
    ],
)
def test_a_chain_of_velocities_that_is_broken_is_reported_once(
    parameter: str, warning: str, capfd: pytest.CaptureFixture[str]
) -> None:
    robot = made(**{parameter: "raw"})
    for _ in range(2):
        drive(robot, 0.1, 5.0)
    lines = [line for line in capfd.readouterr().err.splitlines() if "set cmd_vel" in line]
    assert len(lines) == bool(warning)
    assert all(line.endswith(warning) for line in lines)


def test_nobody_behind_it_is_reported_by_a_monitor_that_only_stops_too(
    capfd: pytest.CaptureFixture[str],
) -> None:
    robot = made(**{"cmd_vel_out_topic": "raw", "scan.topic": "none"})
    drive(robot, 0.2, 1.0)
    assert "nobody takes the velocities on 'raw'" in capfd.readouterr().err


def test_commands_that_are_no_numbers_are_ignored(robot: PlayedRobot) -> None:
    drive(robot, math.nan, 0.2)
    assert not robot.commands


def test_a_slow_scanner_is_not_taken_for_a_dead_one(robot: PlayedRobot) -> None:
    robot.sees = False
    for _ in range(6):  # one scan a second
        robot.run(0.9)
        robot.sees = True
        robot.run(0.1)
        robot.sees = False
    drive(robot, 0.2, 1.2)
    assert robot.command.x == pytest.approx(0.2)
    drive(robot, 0.2, 1.6)
    assert robot.command == STILL


def test_a_scan_that_is_stamped_by_its_first_ray_slows_nothing(robot: PlayedRobot) -> None:
    robot.scan_age = 0.14  # its own period, and the delay to here
    drive(robot, 0.2, 1.0)
    robot.forget()
    drive(robot, 0.2, 1.0)
    assert min(command.x for command in robot.commands) == pytest.approx(0.2)


def test_a_robot_without_a_scanner_is_not_held() -> None:
    parameters, name = shipped_parameters(), "local_costmap/local_costmap"
    layers = ("obstacle_layer.", "voxel_layer.")
    near = {k: v for k, v in parameters[name].items() if not k.startswith(layers)}
    parameters[name] = {**near, "plugins": ["inflation_layer"]}
    robot = PlayedRobot(parameters, shipped=False)
    robot.bring_up(LOCAL_COSTMAP, COLLISION_MONITOR)
    robot.sees = False
    robot.run(0.5)
    drive(robot, 0.2, 0.2)
    assert robot.command.x == pytest.approx(0.2)
