"""The navigator, with scripted outcomes instead of servers."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.commands import (
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    CheckPath,
    Clear,
    ComputePath,
    Ending,
    Finish,
    NavigatorState,
    Outcome,
    Recover,
    Recovery,
    Stop,
)
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.navigator import Navigator, NavigatorConfig
from arjuna_nav.planners.base import PlanStatus
from tests.helpers.nav.navigator_script import (
    BOTH,
    CLEAR_BOTH,
    DETOUR,
    GOAL,
    STRAIGHT,
    Script,
    failed,
    followed,
    no_plan,
    planned,
)
from tests.nav.worlds import polyline


@pytest.fixture
def script() -> Script:
    return Script()


def test_plans_follows_and_succeeds(script: Script) -> None:
    script.follow()
    assert script.tick() == []
    assert script.tick(follow=Outcome()) == [Finish(Ending.SUCCEEDED)]


def test_asks_for_a_path_once_and_waits(script: Script) -> None:
    script.tick()
    assert all(script.tick() == [] for _ in range(50))


def test_replans_each_second_while_following(script: Script) -> None:
    script.follow()
    asked = []
    for _ in range(50):
        commands = script.tick()
        if commands:
            asked.append(script.now)
            assert [type(command) for command in commands] == [CheckPath, ComputePath]
            script.tick(dt=0.0, plan=planned(), path_valid=True)
    assert len(asked) >= 4
    assert np.diff(asked) == pytest.approx(1.0, abs=0.11)


def test_a_nearly_equal_path_is_taken(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    near = STRAIGHT + np.array([0.0, 0.1, 0.0])
    assert followed(script.tick(plan=planned(near), path_valid=True)) is near


def test_stays_on_a_free_path_that_another_does_not_clearly_beat(script: Script) -> None:
    script.tick()
    script.tick(plan=planned(DETOUR))
    other = DETOUR * np.array([1.0, -1.0, -1.0])
    script.tick(dt=1.0)
    assert followed(script.tick(plan=planned(other), path_valid=True)) is None


@pytest.mark.parametrize("path_valid", [False, None])
def test_leaves_a_path_that_is_blocked_or_unchecked(
    script: Script, path_valid: bool | None
) -> None:
    script.follow()
    script.tick(dt=1.0)
    assert followed(script.tick(plan=planned(DETOUR), path_valid=path_valid)) is DETOUR


def test_a_path_that_comes_with_the_end_of_following_changes_nothing(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    end = script.tick(plan=planned(DETOUR), follow=Outcome())
    assert end == [Finish(Ending.SUCCEEDED)]


def test_a_path_that_comes_with_trouble_is_followed_once_cleared(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    trouble = failed(ControlStatus.NO_VALID_CONTROL)
    assert script.tick(plan=planned(DETOUR), follow=trouble) == [Clear(LOCAL_COSTMAP)]
    assert followed(script.tick(cleared=frozenset({LOCAL_COSTMAP}))) is DETOUR


def test_leaves_a_free_path_for_a_clearly_shorter_one(script: Script) -> None:
    script.tick()
    script.tick(plan=planned(DETOUR))
    script.tick(dt=1.0)
    assert followed(script.tick(plan=planned(STRAIGHT), path_valid=True)) is STRAIGHT


def test_leaves_a_free_path_that_it_is_not_on_any_more(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    beside = SE2(1.0, 0.8, 0.0)
    commands = script.tick(plan=planned(DETOUR), path_valid=True, pose=beside)
    assert followed(commands) is DETOUR


def test_clears_the_local_costmap_and_follows_once_more(script: Script) -> None:
    script.follow()
    trouble = failed(ControlStatus.NO_VALID_CONTROL)
    assert script.tick(follow=trouble) == [Clear(LOCAL_COSTMAP)]
    assert script.tick() == []
    assert followed(script.tick(cleared=frozenset({LOCAL_COSTMAP}))) is STRAIGHT
    assert script.tick(follow=trouble) == CLEAR_BOTH
    assert script.navigator.recoveries == 1


def test_after_trouble_the_next_path_is_taken_whatever_it_is(script: Script) -> None:
    script.follow()
    script.tick(follow=failed(ControlStatus.NO_VALID_CONTROL))
    script.tick(cleared=frozenset({LOCAL_COSTMAP}))
    script.tick(dt=1.0)
    assert followed(script.tick(plan=planned(DETOUR), path_valid=True)) is DETOUR


def test_recovers_in_turn_and_gives_up_after_six(script: Script) -> None:
    done: list[Recovery] = []
    script.tick()
    for _ in range(6):
        commands = script.fail_to_plan()
        if commands == CLEAR_BOTH:
            done.append(Recovery.CLEAR)
            again = script.tick(cleared=BOTH)
        else:
            stop, recover = commands
            assert stop == Stop()
            assert isinstance(recover, Recover)
            done.append(recover.recovery)
            assert script.tick() == []
            again = script.tick(behavior=Outcome())
        assert again == [ComputePath((GOAL,))]
    kinds = [Recovery.CLEAR, Recovery.SPIN, Recovery.WAIT, Recovery.BACK_UP]
    assert done == list(itertools.islice(itertools.cycle(kinds), 6))
    assert script.fail_to_plan() == [Finish(Ending.ABORTED, 208, "NO_VALID_PATH")]
    assert script.navigator.recoveries == 6


def test_waits_for_both_costmaps_to_be_cleared(script: Script) -> None:
    script.tick()
    script.fail_to_plan()
    assert script.tick(cleared=frozenset({LOCAL_COSTMAP})) == []
    assert script.tick(cleared=frozenset({GLOBAL_COSTMAP})) == [ComputePath((GOAL,))]


def test_a_failing_recovery_gives_way_to_the_next(script: Script) -> None:
    script.tick()
    script.fail_to_plan()
    script.tick(cleared=BOTH)
    assert script.fail_to_plan() == [Stop(), Recover(Recovery.SPIN)]
    blocked = Outcome(703, "collision ahead")
    assert script.tick(behavior=blocked) == [Recover(Recovery.WAIT)]
    assert script.tick(behavior=Outcome()) == [ComputePath((GOAL,))]
    assert script.navigator.recoveries == 2


def test_where_every_motion_fails_it_comes_round_to_clearing(script: Script) -> None:
    script.tick()
    script.fail_to_plan()
    script.tick(cleared=BOTH)
    script.fail_to_plan()
    blocked = Outcome(703, "collision ahead")
    script.tick(behavior=blocked)
    script.tick(behavior=Outcome(740, "no"))
    assert script.tick(behavior=Outcome(714, "no")) == CLEAR_BOTH[1:]
    assert script.tick(cleared=BOTH) == [ComputePath((GOAL,))]


@pytest.mark.parametrize(
    "status",
    [
        PlanStatus.INVALID_PLANNER,
        PlanStatus.START_OUTSIDE_MAP,
        PlanStatus.GOAL_OUTSIDE_MAP,
        PlanStatus.START_OCCUPIED,
        PlanStatus.GOAL_OCCUPIED,
    ],
)
def test_aborts_at_once_where_no_recovery_helps(script: Script, status: PlanStatus) -> None:
    script.tick()
    end = script.tick(plan=no_plan(status))
    assert end == [Finish(Ending.ABORTED, int(status), status.name)]


@pytest.mark.parametrize(
    "status",
    [
        ControlStatus.INVALID_CONTROLLER,
        ControlStatus.INVALID_PATH,
    ],
)
def test_aborts_at_once_at_a_controllers_hopeless_error(
    script: Script, status: ControlStatus
) -> None:
    end = script.follow().tick(follow=failed(status))
    assert end == [Finish(Ending.ABORTED, int(status), status.name)]


@pytest.mark.parametrize("phase", ["planning", "following", "recovering"])
def test_cancel_stops_everything_at_once(script: Script, phase: str) -> None:
    script.tick()
    if phase == "following":
        script.tick(plan=planned())
    elif phase == "recovering":
        script.fail_to_plan()
    assert script.tick(cancel=True) == [Finish(Ending.CANCELED)]


def test_a_new_goal_is_planned_to_at_once_while_the_old_path_is_followed(script: Script) -> None:
    other = SE2(0.0, 3.0, 1.0)
    script.follow()
    commands = script.tick(goals=(other,))
    assert [type(command) for command in commands] == [CheckPath, ComputePath]
    assert commands[1] == ComputePath((other,))
    assert script.tick(follow=Outcome()) == [], "the old goal's end is no success"
    path = polyline([(0.0, 0.0), (0.0, 3.0)], 1.0)
    assert followed(script.tick(plan=planned(path), path_valid=True)) is path
    assert script.tick(follow=Outcome()) == [Finish(Ending.SUCCEEDED)]


def test_a_new_goal_ends_a_recovery(script: Script) -> None:
    other = SE2(0.0, 3.0, 1.0)
    script.tick()
    script.fail_to_plan()
    assert script.tick(goals=(other,)) == [Stop(), ComputePath((other,))]


def test_poses_on_the_way_are_dropped_as_they_are_passed() -> None:
    goals = (SE2(1.0, 0.0), SE2(2.0, 0.0), GOAL)
    script = Script(Navigator(NavigatorConfig(), goals, start=0.0))
    assert script.tick() == [ComputePath(goals)]
    script.tick(plan=planned())
    assert script.tick(dt=1.0, pose=SE2(0.9, 0.0))[-1] == ComputePath(goals[1:])
    script.tick(pose=SE2(0.9, 0.0), plan=planned(), path_valid=True)
    last = script.tick(dt=1.0, pose=SE2(3.9, 0.0))[-1]
    assert last == ComputePath(goals[1:]), "far beyond is not passed"


def test_feedback_is_nav2s(script: Script) -> None:
    script.follow()
    state = NavigatorState(now=5.0, T_map_base=SE2(1.0, 0.2, 0.0), speed=0.5)
    told = script.navigator.feedback(state)
    assert told.navigation_time == 5.0
    assert told.distance_remaining == pytest.approx(3.0)
    assert told.estimated_time_remaining == pytest.approx(6.0)
    assert (told.number_of_recoveries, told.number_of_poses_remaining) == (0, 1)
    standing = NavigatorState(now=5.0, T_map_base=SE2(1.0, 0.2, 0.0), speed=0.005)
    assert script.navigator.feedback(standing).estimated_time_remaining == 0.0
