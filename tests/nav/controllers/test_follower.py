"""Following with a scripted controller: its end, and the failures that are tolerated."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar
from unittest.mock import Mock

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.config import load, param
from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity
from arjuna_nav.controllers import ControlResult, ControlStatus
from arjuna_nav.controllers.escape import Escape
from arjuna_nav.controllers.follower import FollowerConfig, FollowResult, FollowState, PathFollower
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from tests.nav.worlds import Unicycle, block, costmap_of, empty_grid, grid_of, polyline

ROBOT = Footprint.circle(0.25)
FREE = costmap_of(empty_grid(8.0, 4.0))
START, ON = SE2(1.0, 2.0), Velocity(0.2, yaw_rate=0.1)
PATH = polyline([(1.0, 2.0), (5.0, 2.0)], 0.0)
DRIVES = ControlResult(ControlStatus.SUCCEEDED, ON)
BLOCKED = ControlResult(ControlStatus.NO_VALID_CONTROL, message="blocked ahead")


@dataclass(frozen=True)
class ScriptConfig:
    speed: float = param(0.4, "Speed.", unit="m/s")


class Scripted:
    """A controller that answers what the test says."""

    Config: ClassVar[type[Any]] = ScriptConfig
    made: ClassVar[list[Scripted]] = []

    def __init__(
        self, config: ScriptConfig, footprint: Footprint, xy: float, period: float
    ) -> None:
        self.desired_speed, self.speed_limit = config.speed, math.inf
        self.xy, self.period = xy, period
        self.path: NDArray[np.float64] = np.empty((0, 3))
        self.carrot: SE2 | None = None
        self.answer = DRIVES
        self.made.append(self)

    def set_path(self, path: NDArray[np.float64]) -> None:
        self.path = path

    def compute(self, pose: SE2, velocity: Velocity, costmap: Costmap, now: float) -> ControlResult:
        return self.answer


class Steered(Scripted):
    """A controller of a robot that cannot turn on the spot, whose radius it does not know."""

    turning_radius = math.inf


class Car(Scripted):
    """A controller of a robot whose radius it knows."""

    turning_radius = 0.6


class Followed:
    """A path that is followed by the script."""

    def __init__(
        self, path: NDArray[np.float64] = PATH, outline: Footprint = ROBOT, /, **values: Any
    ) -> None:
        own = {
            "FollowPath.plugin": f"{__name__}:Scripted",
            "escape.enabled": False,
            "arrival.enabled": False,
        }
        self.follower = PathFollower(load(FollowerConfig, {**own, **values}), outline)
        self.follower.start(path, 0.0)

    @property
    def script(self) -> Scripted:
        return Scripted.made[-1]

    def tick(
        self, now: float, pose: SE2 = START, velocity: Velocity = STILL, costmap: Costmap = FREE
    ) -> FollowResult:
        return self.follower.tick(pose, velocity, costmap, now)


def test_drives_what_the_controller_says_and_how_much_is_left() -> None:
    followed = Followed(controller_frequency=8.0)
    result = followed.tick(0.0)
    assert result.distance == pytest.approx(4.0)
    assert replace(result, distance=0.0) == FollowResult(FollowState.RUNNING, ON)
    assert (followed.script.period, followed.script.xy) == (0.125, 0.25)
    assert followed.follower.controller.desired_speed == 0.4
    followed.script.carrot = SE2(0.5)
    assert followed.follower.controller.carrot == SE2(0.5)


@pytest.mark.parametrize(
    ("tolerance", "now", "error", "message"),
    [
        (0.3, 0.29, None, "blocked ahead"),
        (0.25, 0.25, ControlStatus.PATIENCE_EXCEEDED, "blocked ahead; for over 0.25 s"),
        (0.0, 0.0, ControlStatus.NO_VALID_CONTROL, "blocked ahead"),
        (-0.1, 0.0, ControlStatus.NO_VALID_CONTROL, "blocked ahead"),
        (-1.0, 9.0, None, "blocked ahead"),
    ],
)
def test_a_failing_controller_is_tolerated_for_a_time(
    tolerance: float, now: float, error: ControlStatus | None, message: str
) -> None:
    followed = Followed(failure_tolerance=tolerance)
    followed.script.answer = BLOCKED
    if now > 0.0:
        first = followed.tick(0.0)
        assert (first.state, first.velocity) == (FollowState.RUNNING, STILL)
        assert first.distance == pytest.approx(4.0)
    result = followed.tick(now)
    assert result.message == message
    assert result.error is (error or ControlStatus.SUCCEEDED)
    assert (result.state is FollowState.FAILED) is (error is not None)


@pytest.mark.parametrize(("x", "is_told"), [(4.6, True), (2.0, False)])
@pytest.mark.parametrize("blocked", [True, False])
def test_a_failure_near_an_end_where_the_outline_does_not_fit_says_so(
    x: float, is_told: bool, blocked: bool
) -> None:
    followed = Followed(failure_tolerance=0.0)
    followed.script.answer = BLOCKED
    wall = (4.9, 1.5, 0.1, 1.0) if blocked else (0.0, 0.0, 0.1, 0.1)
    result = followed.tick(0.0, SE2(x, 2.0), costmap=costmap_of(grid_of(8.0, 4.0, wall)))
    told = "; with the heading of the path's end at (5.00, 2.00) the outline touches something"
    assert result.message == "blocked ahead" + told * (is_told and blocked)


@pytest.mark.parametrize("code", range(ControlStatus.UNKNOWN, ControlStatus.NO_VALID_CONTROL + 1))
@pytest.mark.parametrize("start", [START, SE2(4.4, 2.0)])
def test_a_controller_that_always_fails_has_the_last_word(code: int, start: SE2) -> None:
    own: dict[str, Any] = {"arrival.enabled": True, "failure_tolerance": 0.3}
    followed = Followed(polyline([(start.x, 2.0), (5.0, 2.0)], 0.0), **own)
    followed.script.answer = ControlResult(ControlStatus(code), message="it is broken")
    result = followed.tick(0.0, start)
    blocked = code == ControlStatus.NO_VALID_CONTROL
    if blocked:
        assert result.state is FollowState.RUNNING
        result = followed.tick(0.3, start)
    assert result.state is FollowState.FAILED
    assert result.error == (ControlStatus.PATIENCE_EXCEEDED if blocked else code)
    assert result.message.startswith("it is broken")


@pytest.mark.parametrize("between", ["it drives", "it brakes", "a new task"])
def test_failures_are_counted_again_after(between: str) -> None:
    followed = Followed(failure_tolerance=0.3)
    followed.script.answer = BLOCKED
    followed.tick(0.0)
    if between == "it drives":
        followed.script.answer = DRIVES
        followed.tick(0.2)
        followed.script.answer = BLOCKED
    elif between == "it brakes":
        followed.tick(0.2, velocity=Velocity(-0.11))
    else:
        followed.follower.start(PATH, 0.2)
        followed.script.answer = BLOCKED
    followed.tick(0.25, velocity=Velocity(0.3))
    assert followed.tick(0.45).state is FollowState.RUNNING
    assert followed.tick(0.56).state is FollowState.FAILED


@pytest.mark.parametrize(("gap", "waits"), [(0.49, True), (0.51, False)])
def test_what_moves_so_near_is_waited_for(gap: float, waits: bool) -> None:
    followed = Followed(failure_tolerance=0.0)
    followed.script.answer = BLOCKED
    moving = np.array([[1.0, 2.0 + 0.25 + gap + 0.2, 0.2]])
    result = followed.tick(0.0, costmap=replace(FREE, moving=moving))
    assert (result.state is FollowState.RUNNING) is waits
    assert not waits or (result.velocity, result.message) == (STILL, "blocked ahead")


@pytest.mark.parametrize(
    ("config_limit", "limit", "given"), [(0.4, math.inf, 0.4), (0.4, 0.2, 0.2), (2.0, 1.5, 1.5)]
)
def test_the_lowest_speed_limit_holds(config_limit: float, limit: float, given: float) -> None:
    followed = Followed(PATH, **{"FollowPath.speed": config_limit})
    followed.follower.speed_limit = limit
    followed.tick(0.0)
    assert followed.script.speed_limit == given


@pytest.mark.parametrize(
    ("plugin", "most", "key"),
    [
        ("dwb_core::DWBLocalPlanner", 1.0, "max_vel_theta"),
        ("nav2_mppi_controller::MPPIController", 1.0, "wz_max"),
    ],
)
def test_a_speed_zone_slows_turns_too(plugin: str, most: float, key: str) -> None:
    """As Nav2's, whose bends stay the same; the robot turned at its full rate in each zone."""
    fastest = []
    for limit in (math.inf, 0.1):
        followed = Followed(
            polyline([(5.0, 2.0), (2.0, 2.0)], math.pi),
            **{"FollowPath.plugin": plugin, f"FollowPath.{key}": most, "foresight.enabled": False},
        )
        speed = followed.follower.controller.desired_speed
        followed.follower.speed_limit = limit
        robot = Unicycle(SE2(5.0, 2.0, 0.5))
        rates = []
        for k in range(40):
            answer = followed.tick(0.05 * k, robot.pose, robot.velocity, FREE)
            robot.drive(answer.velocity)
            rates.append(abs(answer.velocity.yaw_rate))
        fastest.append(max(rates))
    assert fastest[0] > 0.8 * most
    assert fastest[1] == pytest.approx(most * 0.1 / speed, rel=0.05)


def test_who_does_not_get_on_fails_with_the_reason() -> None:
    followed = Followed(PATH, **{"progress_checker.movement_time_allowance": 5.0})
    followed.tick(0.0)
    assert followed.tick(5.0).state is FollowState.RUNNING
    stuck = followed.tick(5.1)
    assert stuck == FollowResult.failed(
        ControlStatus.FAILED_TO_MAKE_PROGRESS, "moved less than 0.5 m in 5 s"
    )
    followed.follower.start(PATH, 5.2)
    assert followed.tick(5.2).state is FollowState.RUNNING


@pytest.mark.parametrize(("moved", "fails"), [(0.04, True), (0.06, False)])
def test_who_squeezes_through_a_gap_may_be_slow_but_not_stand(
    moved: float, fails: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Escape, "in_gap", True)
    followed = Followed(PATH, **{"progress_checker.movement_time_allowance": 5.0})
    followed.tick(0.0)
    followed.tick(4.0, SE2(1.0 + moved, 2.0))
    assert (followed.tick(5.1, SE2(1.0 + moved, 2.0)).state is FollowState.FAILED) is fails


END = PATH[60:]  # its last metre
LOOP = polyline([(5.0, 2.0), (1.0, 2.0), (1.0, 3.0), (5.0, 2.1)], 0.0)


@pytest.mark.parametrize(
    ("path", "pose", "ends"),
    [
        (END, SE2(4.8, 2.0, 0.1), True),
        (END, SE2(4.7, 2.0, 0.1), False),
        (END, SE2(4.8, 2.0, 0.3), False),
        (LOOP, SE2(5.0, 2.0, 0.0), False),  # the end is near, but the path is long
    ],
)
def test_it_ends_at_the_end_of_the_path(path: NDArray[np.float64], pose: SE2, ends: bool) -> None:
    followed = Followed(path)
    expected = FollowState.SUCCEEDED if ends else FollowState.RUNNING
    assert followed.tick(0.0, pose).state is expected


@pytest.mark.parametrize(
    ("change", "still_there"),
    [(lambda f: f.change(END), True), (lambda f: f.change(END[:-2]), False)],
)
def test_a_position_once_reached_is_left_for_another_goal(
    change: Callable[[PathFollower], None], still_there: bool
) -> None:
    followed = Followed(END)
    assert followed.tick(0.0, SE2(4.8, 2.0, 1.0)).state is FollowState.RUNNING, "not its heading"
    change(followed.follower)
    pushed = SE2(4.66 if still_there else 4.56, 2.0)  # beyond the tolerance, yet not far
    assert (followed.tick(0.1, pushed).state is FollowState.SUCCEEDED) is still_there


def test_the_goal_is_driven_into_if_that_is_wanted() -> None:
    followed = Followed(END, **{"arrival.enabled": True})
    result = followed.tick(0.0, SE2(4.8, 2.0))
    assert result.state is FollowState.RUNNING
    assert result.velocity != ON
    assert result.distance == pytest.approx(0.2)
    assert followed.tick(0.0, SE2(4.995, 2.0)).state is FollowState.SUCCEEDED


@pytest.mark.parametrize(
    ("kind", "radius", "takes_over"),
    [("Scripted", 0.0, True), ("Steered", 0.0, False), ("Steered", 0.6, True), ("Car", 0.0, True)],
)
def test_unknown_radii_leave_the_controller_in(kind: str, radius: float, takes_over: bool) -> None:
    own: dict[str, Any] = {"arrival.enabled": True, "escape.enabled": True}
    own |= {"FollowPath.plugin": f"{__name__}:{kind}", "min_turning_radius": radius}
    followed = Followed(END, **own)
    assert (followed.tick(0.0, SE2(4.0, 2.0)).velocity != ON) is takes_over
    followed = Followed(**own)
    followed.script.answer = BLOCKED
    assert (followed.tick(0.0).velocity != STILL) is takes_over


@pytest.mark.parametrize(
    ("kind", "radius", "drives", "warns"),
    [
        ("Car", 0.5, 0.6, ""),
        ("Car", 0.8, 0.8, "controller FollowPath bends by 0.6 m, but the robot's tightest bend is"),
        ("Scripted", 0.5, 0.5, "controller FollowPath turns on the spot, but the robot's"),
        ("Steered", 0.5, 0.5, ""),
    ],
)
def test_no_controller_bends_tighter_than_the_robot_can(
    kind: str, radius: float, drives: float, warns: str
) -> None:
    own: dict[str, Any] = {"FollowPath.plugin": f"{__name__}:{kind}"}
    followed = Followed(**own, min_turning_radius=radius)
    assert followed.follower.warning.startswith(warns)
    assert bool(followed.follower.warning) is bool(warns)
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, Velocity(-0.3, yaw_rate=2.0))
    assert followed.tick(0.0).velocity == Velocity(-0.3, yaw_rate=0.3 / drives)
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, Velocity(yaw_rate=2.0))
    result = followed.tick(0.1)
    assert (result.error, result.velocity) == (ControlStatus.NO_VALID_CONTROL, STILL)
    assert "a turn on the spot is commanded" in result.message


def test_a_turn_on_the_spot_of_a_steered_robot_is_driven_in_bends() -> None:
    own: dict[str, Any] = {"escape.enabled": True, "min_turning_radius": 0.5}
    followed = Followed(np.array([[4.0, 2.0, math.pi], [1.0, 2.0, math.pi]]), **own)
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, Velocity(yaw_rate=2.0))
    velocity = followed.tick(0.0, SE2(4.0, 2.0)).velocity
    assert abs(velocity.x) > 0.0
    assert abs(velocity.yaw_rate) * 0.5 <= abs(velocity.x) * 1.001


def test_an_arc_that_was_widened_into_an_obstacle_is_not_driven() -> None:
    grid = empty_grid(8.0, 4.0)
    block(grid, 1.35, 1.0, 0.3, 2.0)
    own: dict[str, Any] = {"FollowPath.plugin": f"{__name__}:Car"}
    followed = Followed(**own)
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, Velocity(0.5, yaw_rate=3.0))
    assert "on the tightest bend" in followed.tick(0.0, costmap=costmap_of(grid)).message


def test_an_escape_begins_once_the_robot_has_braked() -> None:
    own: dict[str, Any] = {"escape.enabled": True}
    followed = Followed(**own)
    followed.script.answer = BLOCKED
    braking = followed.tick(0.0, velocity=Velocity(0.3))
    assert (braking.state, braking.velocity) == (FollowState.RUNNING, STILL)
    assert followed.tick(0.1).velocity != STILL


def test_a_robot_that_brakes_for_an_escape_goes_on_but_does_not_turn_meanwhile() -> None:
    own: dict[str, Any] = {"escape.enabled": True}
    followed, turn = Followed(**own), Velocity(yaw_rate=0.4)
    followed.script.answer = BLOCKED
    followed.tick(0.0, velocity=Velocity(0.3))
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, turn)
    assert followed.tick(0.1, velocity=Velocity(0.3)).velocity == STILL
    assert followed.tick(0.2).velocity not in (STILL, turn)
    followed = Followed(**own)
    followed.script.answer = BLOCKED
    followed.tick(0.0, velocity=Velocity(0.3))
    followed.script.answer = DRIVES
    assert followed.tick(0.1, velocity=Velocity(0.3)).velocity == ON
    followed.script.answer = ControlResult(ControlStatus.SUCCEEDED, turn)
    assert followed.tick(0.2, velocity=Velocity(0.3)).velocity == turn


@pytest.mark.parametrize("axle", [-0.4, 0.2])
def test_a_base_off_its_axle_is_driven_as_the_axle_would_be(axle: float) -> None:
    base, outline = SE2(-axle), ROBOT.driven_at(axle)
    poses = [(SE2.from_array(row) @ base).array() for row in PATH]
    followed = Followed(np.array(poses), outline)
    assert followed.script.path == pytest.approx(PATH)
    followed.script.compute = Mock(return_value=DRIVES)  # type: ignore[method-assign]
    followed.tick(0.0, SE2(1.2, 2.1, 0.3) @ base, Velocity(0.2, y=0.1, yaw_rate=0.4))
    pose, velocity = followed.script.compute.call_args.args[:2]
    assert pose.array() == pytest.approx((1.2, 2.1, 0.3))
    assert velocity == Velocity(0.2, yaw_rate=0.4)
    end = SE2.from_array(PATH[-1])
    followed.script.path = PATH[-1:]
    assert followed.tick(0.1, end @ base).state is FollowState.SUCCEEDED
