"""docking_server: orders by name and by pose, refusals, cancellation, docks of a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import DockRobot, UndockRobot
from nav2_msgs.srv import ReloadDockDatabase
from sensor_msgs.msg import BatteryState
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    header,
    pose3_msg,
    pose_stamped,
    se2_from_pose,
    transform3_msg,
)
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL
from bringup.stack import NAVIGATION_GROUP
from tests.helpers.nav.navigation import (
    CANCELED,
    SUCCEEDED,
    Goal,
    PlayedRobot,
    assert_failed,
    started,
)
from tests.helpers.nav.navigator_goals import assert_stopped_for_good

HOME = SE2(1.2, 0.4, 0.3)
DOCKS: dict[str, Any] = {
    "docks": ["home"],
    "home.type": "simple_charging_dock",
    "home.pose": [HOME.x, HOME.y, HOME.theta],
}


def made(folder: Path, **parameters: Any) -> PlayedRobot:
    values = {**DOCKS, "dock_folder": str(folder), **parameters}
    return started(*NAVIGATION_GROUP.nodes, docking_server=values)


@pytest.fixture
def robot(tmp_path: Path) -> PlayedRobot:
    return made(tmp_path)


def dock(robot: PlayedRobot, name: str = "home", **fields: Any) -> Goal:
    return robot.send(DockRobot, "dock_robot", DockRobot.Goal(dock_id=name, **fields))


def dock_at(robot: PlayedRobot, pose: PoseStamped, kind: str, **fields: Any) -> Goal:
    goal = DockRobot.Goal(use_dock_id=False, dock_pose=pose, dock_type=kind, **fields)
    return robot.send(DockRobot, "dock_robot", goal)


def undock(robot: PlayedRobot, **fields: Any) -> Goal:
    return robot.send(UndockRobot, "undock_robot", UndockRobot.Goal(**fields))


def test_it_docks_by_name_and_undocks(robot: PlayedRobot) -> None:
    goal = dock(robot)
    robot.run_until_done(goal, 60.0)
    assert (goal.status, goal.result.success, goal.result.error_code) == (SUCCEEDED, True, 0)
    assert robot.pose.distance(HOME) < 0.02
    states = [each.state for each in goal.feedback]
    assert sorted(set(states)) == [1, 2, 3, 4]
    assert states == sorted(states)
    away = undock(robot)
    robot.run_until_done(away, 30.0)
    assert (away.status, away.result.success) == (SUCCEEDED, True)
    assert robot.pose.distance(HOME @ SE2(-0.7, 0.0, 0.0)) < 0.03
    assert robot.command == STILL


@pytest.mark.parametrize(("away", "docked"), [(0.05, True), (0.15, False)])
def test_a_robot_that_was_moved_off_its_dock_is_in_none(
    robot: PlayedRobot, away: float, docked: bool
) -> None:
    robot.run_until_done(dock(robot), 60.0)
    robot.pose = robot.pose @ SE2(-away)
    robot.run(0.2)
    leaving = undock(robot)
    robot.run(0.5)
    assert leaving.done is not docked


def test_it_docks_by_pose_where_the_robot_stands_near(robot: PlayedRobot) -> None:
    pose = pose_stamped(SE2(0.7, 0.05, 0.0), "map", 0.0)
    goal = dock_at(robot, pose, "simple_non_charging_dock", navigate_to_staging_pose=False)
    robot.succeed(goal, 60.0)
    assert robot.pose.distance(SE2(0.7, 0.05)) < 0.02
    assert {each.state for each in goal.feedback} == {2, 3}


def test_the_battery_shows_charging(tmp_path: Path) -> None:
    robot = made(tmp_path, **{"simple_charging_dock.use_battery_status": True})
    goal = dock(robot)
    while robot.pose.distance(HOME) > 0.012:
        robot.run(0.1)
        assert robot.now < 60.0
    robot.run(1.0)
    assert goal.feedback[-1].state == DockRobot.Feedback.WAIT_FOR_CHARGE
    robot.bench.publish(BatteryState, "battery_state", BatteryState(current=2.0), qos.DEFAULT)
    robot.run(0.1)
    assert goal.status == SUCCEEDED


def broken() -> PoseStamped:
    pose = pose_stamped(HOME, "map", 0.0)
    pose.pose.orientation.w = pose.pose.orientation.z = 0.0
    return pose


def test_orders_that_cannot_be_carried_out_end_with_their_codes(robot: PlayedRobot) -> None:
    here = pose_stamped(HOME, "map", 0.0)
    for goal, code, says in (
        (dock(robot, "attic"), 901, "there is no dock 'attic'; valid: home"),
        (dock_at(robot, here, "hook"), 902, "no dock type 'hook'; valid: simple_"),
        (dock_at(robot, broken(), "simple_charging_dock"), 999, "is no rotation"),
    ):
        assert_failed(goal, code, says)
        assert not goal.result.success
    pose = pose_stamped(SE2(20.0, 0.0, 0.0), "map", 0.0)
    goal = dock_at(robot, pose, "simple_charging_dock")
    robot.run_until_done(goal, 60.0)
    assert goal.result.error_code == DockRobot.Result.FAILED_TO_STAGE
    assert "staging pose" in goal.result.error_msg
    goal = dock(robot)
    robot.run(1.0)
    assert robot.command != STILL
    goal.cancel()  # on the path to the staging pose
    assert goal.status == CANCELED
    assert_stopped_for_good(robot)


def test_a_newer_order_ends_the_older(robot: PlayedRobot) -> None:
    assert_failed(undock(robot), 902)  # of which kind, nobody said
    docking = dock(robot)
    robot.run(1.0)
    leaving = undock(robot)
    assert_failed(docking, DockRobot.Result.UNKNOWN, "replaced by undock_robot")
    robot.run_until_done(leaving, 1.0)
    assert leaving.status == SUCCEEDED  # it is in none


def test_docks_are_read_again(robot: PlayedRobot, tmp_path: Path) -> None:
    file = tmp_path / "docks.yaml"
    file.write_text("docks: {attic: {type: simple_charging_dock, pose: [1, 0, 0]}}")
    assert reload(robot, "docks.yaml")
    fresh = made(tmp_path, dock_database=str(file))  # it starts with them, too
    assert not dock(fresh, "attic").done
    assert dock(robot, "attic").accepted
    file.write_text("docks: {attic: {type: hook, pose: [1, 0, 0]}}")
    assert not reload(robot, "docks.yaml")
    assert not reload(robot, "../docks.yaml")
    running = dock(robot, "attic")
    assert not running.done


def reload(robot: PlayedRobot, path: str) -> bool:
    request = ReloadDockDatabase.Request(filepath=path)
    name = "docking_server/reload_database"
    return bool(robot.bench.call(ReloadDockDatabase, name, request).success)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"home.pose": [1.0]}, "has 1 numbers"),
        ({"dock_plugins": ["own"], "own.plugin": "no::Such"}, "no dock type 'no::Such'"),
    ],
)
def test_invalid_values_are_refused(tmp_path: Path, parameters: dict[str, Any], says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        made(tmp_path, **parameters)


def test_a_dock_of_no_kind_fails_its_goals(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    robot = made(tmp_path, **{"home.type": "hook"})
    robot.fail(dock(robot), 5.0, DockRobot.Result.DOCK_NOT_VALID)
    assert "dock 'home' is of type 'hook'; valid: simple_charging_dock" in capfd.readouterr().err


@pytest.mark.parametrize("seed", range(2))
def test_a_dock_is_seen_by_a_camera_however_it_is_mounted(tmp_path: Path, seed: int) -> None:
    """A camera's own z axis looks ahead: poses of its frame are no poses seen from above."""
    kind = {"use_external_detection_pose": True, "external_detection_translation_x": 0.0}
    level = {f"external_detection_rotation_{axis}": 0.0 for axis in ("roll", "pitch", "yaw")}
    values = {f"simple_charging_dock.{name}": value for name, value in {**kind, **level}.items()}
    robot, rng = made(tmp_path, **values), np.random.default_rng(seed)
    mounted = Pose3.from_rpy(tuple(rng.uniform(-0.3, 0.3, 3)), tuple(rng.uniform(-3.0, 3.0, 3)))
    optical = TFMessage(transforms=[transform3_msg(mounted, "base_link", "optical", 0.0)])
    robot.bench.publish(TFMessage, "/tf_static", optical, qos.TF_STATIC)
    docks = robot.bench.collect(PoseStamped, "dock_pose", qos.LATEST)
    dock(robot, navigate_to_staging_pose=False)
    robot.run(0.1)
    seen = PoseStamped(header=header("optical", robot.now))
    tag = Pose3.from_se2(robot.pose.inverse() @ HOME, 0.4)
    seen.pose = pose3_msg(mounted.inverse() @ tag)
    robot.bench.publish(PoseStamped, "detected_dock_pose", seen, qos.DEFAULT)
    robot.run(0.1)
    found = se2_from_pose(docks[-1].pose)
    assert found.array() == pytest.approx(HOME.array(), abs=1e-3)
