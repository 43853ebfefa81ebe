"""The Python API, on a lock-step robot: what a script asks for comes, or an error says why not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from arjuna_core.files.maps import load_map
from arjuna_core.se2 import SE2
from bringup.client.robot import Robot
from bringup.client.session import ClientError
from bringup.stack import NAVIGATION_GROUP, SLAM_GROUP

if TYPE_CHECKING:
    from bringup.lockstep import LockStep


def test_a_script_drives_maps_and_saves(stack: Callable[..., LockStep], tmp_path: Path) -> None:
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


def test_a_goal_in_a_wall_says_why_it_fails(stack: Callable[..., LockStep]) -> None:
    with Robot(session=stack(SLAM_GROUP, NAVIGATION_GROUP)) as robot:
        robot.session.pause(2.0)
        end = robot.goto(40.0, 0.0, timeout=60.0)
    assert not end.succeeded
    assert "aborted: " in end.reason


def test_what_does_not_come_is_named(stack: Callable[..., LockStep]) -> None:
    with (
        Robot(timeout=0.5, session=stack()) as robot,
        pytest.raises(ClientError, match=r"on 'map' did not come within 0\.5 s: is .* slam'"),
    ):
        robot.map()


def test_what_is_waited_for_is_said_soon(
    stack: Callable[..., LockStep], capfd: pytest.CaptureFixture[str]
) -> None:
    with Robot(timeout=3.0, session=stack()) as robot, pytest.raises(ClientError, match="within 3"):
        robot.map()
    assert "waiting for a message on 'map': is 'python -m bringup slam'" in capfd.readouterr().err
