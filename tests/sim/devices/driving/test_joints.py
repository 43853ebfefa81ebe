"""Which controller commands a joint, and what it makes of commands, without physics."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.devices.driving.joints import (
    ACTIVE,
    INACTIVE,
    UNCONFIGURED,
    ControllerError,
    JointControllers,
)
from arjuna_sim.devices.driving.trajectory import Trajectory
from arjuna_sim.devices.driving.wheel_commands import WheelCommands
from arjuna_sim.files.robots.robot_file import load_robot
from tests.sim.arms import CONTROLLERS, JOINTS, write_arm

START = [0.0, 0.25, 0.0, 0.0]  # of the joints and the finger
TICK = 0.02


@pytest.fixture
def arm(tmp_path: Path) -> JointControllers:
    more = {**CONTROLLERS["arm_controller"], "allow_partial_joints_goal": True}
    controllers = {**CONTROLLERS, "arm_controller": more}
    return JointControllers(load_robot(write_arm(tmp_path, controllers)))


def path(*positions: float) -> Trajectory:
    given, rest = np.array([positions]), np.full((1, len(positions)), np.nan)
    return Trajectory(np.array([1.0]), given, rest, rest)


def positions(arm: JointControllers, seconds: float, begin: float = 0.0) -> NDArray[np.float64]:
    """Return where the joints are wanted after a time in which they go where they should."""
    at = arm.update(begin, TICK, np.array(START)).position
    for k in range(1, round(seconds / TICK) + 1):
        at = arm.update(begin + k * TICK, TICK, at).position
    return at


def test_a_trajectory_may_leave_out_joints_and_name_them_in_any_order(
    arm: JointControllers,
) -> None:
    whole = arm.follow("arm_controller", ("wrist", "shoulder"), path(0.4, -0.2), 0.0)
    assert whole.positions.tolist() == [START[:3], [-0.2, 0.25, 0.4]]
    assert arm.path("arm_controller") is whole
    assert positions(arm, 0.5) == pytest.approx([-0.1, 0.25, 0.2, 0.0])
    arm.hold("arm_controller")
    assert arm.path("arm_controller") is None
    ahead = [-0.104, 0.25, 0.208, 0.0]  # where they were wanted at the tick's end
    assert positions(arm, 0.5) == pytest.approx(ahead)


@pytest.mark.parametrize(
    ("name", "joints", "problem"),
    [
        ("arm_controller", ("finger",), "joint 'finger' is none of shoulder, elbow, wrist"),
        ("gripper", (), "joint 'finger' is missing; all must be named"),
        ("speeds", JOINTS, "controller 'speeds' is inactive; activate it first"),
        ("speed", JOINTS, "controller 'speed' does not exist; .*'speeds'"),
    ],
)
def test_joints_that_cannot_be_led_are_refused(
    arm: JointControllers, name: str, joints: tuple[str, ...], problem: str
) -> None:
    with pytest.raises(ControllerError, match=problem):
        arm.check_joints(name, joints)


@pytest.mark.parametrize(
    ("values", "problem"),
    [((1.0, 2.0), "got 2 values; it has 3 joints"), ((0.0, np.nan, 0.0), "all must be finite")],
)
def test_commands_of_another_number_or_of_none_are_refused(
    arm: JointControllers, values: tuple[float, ...], problem: str
) -> None:
    arm.switch(["positions"], [], forced=True)
    with pytest.raises(ControllerError, match=problem):
        arm.command("positions", values)


def test_joints_go_to_positions_no_faster_than_they_may_and_not_past_their_limits(
    arm: JointControllers,
) -> None:
    arm.switch(["positions"], ["arm_controller"], forced=False)
    arm.command("positions", (0.5, 9.0, 0.25))
    arm.command("gripper", [0.001])
    assert positions(arm, 0.1) == pytest.approx([0.3, 0.55, 0.25, 0.001])  # at most 3 rad/s
    assert positions(arm, 5.0) == pytest.approx([0.5, 2.5, 0.25, 0.001])
    arm.rest(np.array(START))
    assert positions(arm, 0.1) == pytest.approx(START)
    arm.command("positions", [0.1])
    assert positions(arm, 0.1) == pytest.approx([0.1, 0.1, 0.1, 0.0])


def test_speeds_move_joints_on_from_where_they_are_held_fast(arm: JointControllers) -> None:
    arm.switch(["speeds"], ["arm_controller"], forced=False)
    arm.command("speeds", (0.5, -9.0, 0.0))
    first = arm.update(0.0, TICK, np.array(START))
    assert first.velocity == pytest.approx([0.5, -3.0, 0.0, 0.0])
    for k in range(50):
        held = arm.update(k * TICK, TICK, np.array(START))
    assert held.position == pytest.approx([0.1, 0.15, 0.0, 0.0])


def test_efforts_push_and_the_joint_is_wanted_where_it_is(arm: JointControllers) -> None:
    arm.switch(["efforts"], [], forced=True)
    at = np.array([0.0, 0.25, 0.3, 0.0])
    free = arm.update(0.0, TICK, at)
    assert (free.is_effort.tolist(), free.effort.tolist()) == ([False, False, True, False], [0] * 4)
    arm.command("efforts", [2.5])
    assert arm.update(TICK, TICK, at).effort.tolist() == [0.0, 0.0, 2.5, 0.0]
    arm.switch(["arm_controller"], [], forced=True)
    back = arm.update(TICK, TICK, at)
    assert not back.is_effort.any()
    assert back.position[2] == 0.3


def test_integral_gains_push_up_to_their_clamp(tmp_path: Path) -> None:
    tags = "<joint_name>elbow</joint_name><i_gain>10</i_gain><i_max>0.5</i_max><i_min>-0.5</i_min>"
    plugin = f"<plugin filename='gz-sim-joint-position-controller-system' name='p'>{tags}</plugin>"
    file = write_arm(tmp_path, extra=f"<gazebo>{plugin}</gazebo>")
    arm = JointControllers(load_robot(file))
    assert arm.names == ("elbow",)
    pushes = [arm.update(k * TICK, TICK, np.array([-1.0])).effort[0] for k in range(4)]
    assert pushes == pytest.approx([0.2, 0.4, 0.5, 0.5])


def test_a_switch_is_done_whole_or_not_at_all(arm: JointControllers) -> None:
    states = {settings.name: state for settings, state in arm.states}
    assert {n for n, state in states.items() if state == ACTIVE} == {
        *("arm_controller", "gripper", "broadcaster")
    }
    arm.switch(["positions"], [], forced=False)  # nobody has chosen the arm's controller
    assert {"shoulder/position", "finger/position"} <= arm.claimed
    before = arm.states
    with pytest.raises(ControllerError, match="'speeds' wants joints that 'positions' commands"):
        arm.switch(["speeds"], ["gripper"], forced=False)
    assert arm.states == before
    arm.switch(["speeds", "speeds"], ["gripper"], forced=True)
    assert not {"shoulder/position", "finger/position"} & arm.claimed
    with pytest.raises(ControllerError, match="'gripper' is inactive; valid: unconfigured"):
        arm.set_state("gripper", INACTIVE, (UNCONFIGURED,))


def test_wheels_are_a_controllers_from_its_first_command_on() -> None:
    def controller(name: str, joints: tuple[str, ...], steers: bool | None) -> Any:
        turns = lambda plugin, which: plugin == "p" and which is steers  # noqa: E731
        pushes = name == "push"
        return SimpleNamespace(name=name, joints=joints, turns_wheels=turns, is_push=pushes)

    controllers = [
        controller("right", ("arm", "c", "b"), False),
        controller("bow", ("s", "b"), True),
        controller("push", ("a", "c"), False),
        controller("none", ("a",), None),
    ]
    drive = SimpleNamespace(wheels=("a", "b", "c"), steering=("r", "s"), plugin="p")

    def commands(*those: Any) -> Any:
        settings = SimpleNamespace(controllers=those)
        robot: Any = SimpleNamespace(settings=settings, drive=drive)
        return WheelCommands(robot)

    speeds, angles, nan = np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2]), math.nan
    assert commands(*controllers)
    assert not commands(controllers[-1])
    over = commands(*controllers).over
    for values in ({}, {"right": np.array([5.0, nan, nan])}):
        turned, steered, pushed = over(values, speeds, angles)
        assert turned is speeds
        assert steered is angles
        assert pushed is None
    given = {"right": np.array([5.0, 6.0, nan]), "bow": np.array([0.7, 9.0]), "none": speeds}
    turned, steered, pushed = over(given | {"push": np.array([0.4, nan])}, speeds, angles)
    assert pushed is not None
    assert np.array_equal(pushed, [0.4, nan, nan], equal_nan=True)
    assert (turned.tolist(), steered.tolist()) == ([1.0, 2.0, 6.0], [0.1, 0.7])
    assert (speeds.tolist(), angles.tolist()) == ([1.0, 2.0, 3.0], [0.1, 0.2])
