"""The Python API, on a lock-step robot: what a script asks for comes, or an error says why not."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist

from arjuna import simulate
from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import load_map
from arjuna_core.se2 import SE2
from bringup.client.robot import Robot
from bringup.client.session import ClientError
from bringup.stack import NAVIGATION_GROUP, SLAM_GROUP
from tests.helpers.robots import Stack, truth

SHIPPED = ("urdf/arjuna.urdf", "urdf/burger.urdf", "urdf/fusion_description/urdf/fusion.xacro")
PNG = b"\x89PNG\r\n"


def test_a_script_drives_maps_and_saves(stack: Stack, tmp_path: Path) -> None:
    session = stack(SLAM_GROUP, NAVIGATION_GROUP)
    with Robot(session=session) as robot:
        assert robot.scan().valid.sum() > 100
        robot.drive(0.3, 0.0, 2.0)
        moved = robot.pose("odom").x
        assert 0.4 < moved < 0.7
        session.run(1.0)
        assert robot.pose("odom").x == pytest.approx(moved, abs=0.05)
        (end,) = robot.tour([(1.0, 0.5, 0.0)])
        assert end.succeeded, end.reason
        assert robot.pose().distance(SE2(1.0, 0.5, 0.0)) < 0.3
        saved = load_map(robot.save_map(tmp_path / "room"))
        costs = robot.save_map(tmp_path / "costs", "global_costmap/costmap", "png")
    assert (load_map(costs).data == 100).any()
    assert (saved.data == 100).sum() > 100


def test_a_goal_in_a_wall_says_why_it_fails(stack: Stack) -> None:
    with Robot(session=stack(SLAM_GROUP, NAVIGATION_GROUP)) as robot:
        robot.session.pause(2.0)
        end = robot.goto(40.0, 0.0, timeout=60.0)
    assert not end.succeeded
    assert "aborted: " in end.reason


def test_what_does_not_come_is_waited_for_and_named(
    stack: Stack, capfd: pytest.CaptureFixture[str]
) -> None:
    missing = r"on 'map' did not come within 3 s: is .* slam'"
    with Robot(timeout=3.0, session=stack()) as robot, pytest.raises(ClientError, match=missing):
        robot.map()
    assert "waiting for a message on 'map': is 'python -m bringup slam'" in capfd.readouterr().err


@pytest.mark.parametrize("robot", SHIPPED)
def test_a_square_closes_within_two_centimetres(robot: str) -> None:
    with simulate(robot, at=(0.3, -0.2, 0.4), seed=3) as driver:
        start = truth(driver.session)
        for _ in range(4):
            assert driver.forward(0.5) == pytest.approx(0.5, abs=0.01)
            assert driver.turn(math.pi / 2) == pytest.approx(math.pi / 2, abs=0.01)
        end = start.inverse() @ truth(driver.session)
        assert math.hypot(end.x, end.y) < 0.02
        assert abs(end.theta) < 0.03
        assert driver.path.length == pytest.approx(2.0, abs=0.05)


def test_a_turn_may_be_longer_than_half_a_circle_and_a_drive_go_back() -> None:
    with simulate() as robot:
        assert robot.turn(-3.0 * math.pi) == pytest.approx(-3.0 * math.pi, abs=0.01)
        assert robot.turn(2.0 * math.pi) == pytest.approx(2.0 * math.pi, abs=0.01)
        assert robot.forward(-0.5) == pytest.approx(-0.5, abs=0.01)
        assert robot.forward(0.0) == pytest.approx(0.0, abs=0.01)
        pose = robot.pose("odom")
        assert (pose.x, abs(pose.theta)) == pytest.approx((0.5, math.pi), abs=0.02)
        robot.drive(0.3, 0.0, math.pi / 3.0)  # no whole number of ticks
        stood = robot.pose("odom")
        robot.forward(0.5)  # where `drive` led, not where the motion before ended
        assert robot.pose("odom").distance(stood) == pytest.approx(0.5, abs=0.02)


def test_weak_motors_do_not_overshoot(tmp_path: Path) -> None:
    limits = "{max_linear_acceleration: 0.2, max_angular_acceleration: 0.5}"
    file = tmp_path / "weak.yaml"
    file.write_text(f"sim: {{ros__parameters: {{drive: {limits}}}}}")
    with simulate("urdf/burger.urdf", params=file) as robot:
        start = robot.session.now
        assert robot.turn(math.pi / 2) == pytest.approx(math.pi / 2, abs=0.01)
        assert robot.forward(0.5) == pytest.approx(0.5, abs=0.01)
        assert robot.session.now - start < 9.0


def test_it_stops_before_what_the_lidar_sees() -> None:
    with simulate(at=(3.5, 0.0, 0.0)) as robot:
        with pytest.raises(ClientError, match=r"in the way, 0\.\d+ m off, after 1\.\d+ of 5 m"):
            robot.forward(5.0)
        assert robot.nearest(0.0, 0.5) > 0.2
        x = robot.pose("odom").x
        robot.wait(1.0)
        assert robot.pose("odom").x == pytest.approx(x, abs=0.01)
        assert robot.forward(-0.5) == pytest.approx(-0.5, abs=0.01)


def test_a_robot_that_does_not_move_is_reported(stack: Stack) -> None:
    session = stack()
    session.client.create_subscription(Twist, "unheeded", lambda message: None, 1)
    with (
        Robot(1.0, session=session, cmd_vel_topic="unheeded") as robot,
        pytest.raises(ClientError, match=r"^0\.00 of 0\.5 m after 4 s: does something hold"),
    ):
        robot.forward(0.5, speed=0.5)


def test_values_that_make_no_sense_are_refused(stack: Stack) -> None:
    calls: list[tuple[Callable[[Robot], Any], str]] = [
        (lambda robot: robot.turn(90), r"radians = 90 .* radians \(math\.radians\(90\)"),
        (lambda robot: robot.turn(math.nan), "radians = nan is not valid"),
        (lambda robot: robot.turn(1.0, rate=0.0), "rate = 0 is not valid; valid: above 0"),
        (lambda robot: robot.forward(math.inf), "metres = inf is not valid; valid: a finite"),
        (lambda robot: robot.forward(1.0, speed=-0.2), "speed = -0.2 is not valid; valid: above 0"),
    ]
    with Robot(session=stack()) as robot:
        for call, problem in calls:
            with pytest.raises(ArjunaError, match=problem):
                call(robot)


def test_functions_see_each_scan_and_can_stop_the_robot() -> None:
    with simulate() as robot:
        ahead: list[float] = []

        def watch(scan: Any) -> None:
            ahead.append(robot.nearest(0.0, 0.5))
            assert ahead[-1] == scan.nearest(0.0, 0.5)
            if ahead[-1] < 1.8:
                robot.stop()

        end = robot.on_scan(watch)
        assert 0.2 < robot.forward(2.0) < 0.8
        robot.drive(0.3, 0.0, 5.0)
        assert robot.pose("odom").x < 1.0
        robot.wait(1.0)
        end()
        seen = len(ahead)
        robot.wait(1.0)
        assert len(ahead) == seen
        robot.on_scan(lambda scan: robot.command(0.0, 0.5))  # drives by itself
        robot.wait(2.0)
        assert robot.pose("odom").theta > 0.5


def test_a_function_that_waits_or_raises_is_reported_and_called_no_more() -> None:
    with simulate() as robot:
        robot.on_scan(lambda scan: robot.turn(1.0) and None)
        with pytest.raises(ClientError, match="cannot wait, it holds up the scans; valid in it"):
            robot.wait(1.0)
        robot.on_scan(lambda scan: 1 // 0)
        with pytest.raises(ZeroDivisionError, match="division"):
            robot.forward(1.0)
        robot.wait(1.0)
        assert robot.pose("odom").x < 0.2


def test_scans_maps_and_paths_are_pictures() -> None:
    with simulate(slam=True) as robot:
        robot.forward(0.5)
        robot.wait(1.0)
        grid, path = robot.map(), robot.path
        assert path.frame == "map"
        assert path.grid is grid
        assert SE2.from_array(path.poses[-1]).distance(robot.pose()) < 0.01
        for picture in (robot.scan(), grid, path):
            assert picture._repr_png_().startswith(PNG)


def test_a_simulated_robot_explores_and_ends_once() -> None:
    robot = simulate(slam=True)
    assert not robot.explore(timeout=5.0)
    robot.close()
    robot.close()


def test_what_cannot_be_simulated_is_refused() -> None:
    with pytest.raises(ArjunaError, match="map and slam exclude each other"):
        simulate(map="maps/arjuna_room.yaml", slam=True)
    with pytest.raises(ArjunaError, match="missing"):
        simulate(robot="missing.urdf")
