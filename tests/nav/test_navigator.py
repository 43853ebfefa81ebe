"""Arjuna's default tree, with scripted answers instead of servers."""

from __future__ import annotations

import itertools
import re
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.navigator import Ending, Finish, Navigator, NavigatorConfig
from arjuna_nav.planners.base import PlanStatus
from arjuna_nav.trees.exchange import Answer, TreeState, Withdraw
from arjuna_nav.trees.xml_file import build_tree
from tests.helpers.nav.navigator_script import (
    DETOUR,
    GOAL,
    STRAIGHT,
    Script,
    failed,
    planned,
)
from tests.nav.worlds import polyline

SUCCEEDED = Finish(Ending.SUCCEEDED)
STUCK = failed(ControlStatus.NO_VALID_CONTROL)
BLOCKED = Answer(False, 703, "collision ahead")
THROUGH = "navigate_through_poses.xml"


@pytest.fixture
def script() -> Script:
    return Script()


def test_plans_follows_and_succeeds(script: Script) -> None:
    script.follow()
    assert script.tick() == []
    script.tick(follow=True)
    assert script.end == SUCCEEDED


def test_asks_for_a_path_once_and_waits(script: Script) -> None:
    assert script.tick() == ["plan"]
    assert script.asked["plan"]["goal"] == GOAL
    assert all(script.tick() == [] for _ in range(50))


def test_replans_each_second_while_following(script: Script) -> None:
    script.follow()
    asked = []
    for _ in range(50):
        commands = script.tick()
        if commands:
            asked.append(script.now)
            assert commands == ["check", "plan"]
            script.tick(dt=0.0, plan=planned(), check=True)
    assert len(asked) >= 4
    assert np.diff(asked) == pytest.approx(1.0, abs=0.11)


def test_plans_by_the_rate_of_its_configuration() -> None:
    script = Script(config=NavigatorConfig(replanning_frequency=4.0)).follow()
    assert script.tick(0.15) == []  # planned 0.25 s ago, but for rounding
    assert script.tick(0.01) == ["check", "plan"]


NEAR = STRAIGHT + np.array([0.0, 0.1, 0.0])
MIRRORED = DETOUR * np.array([1.0, -1.0, -1.0])


@pytest.mark.parametrize(
    ("followed", "path", "given", "taken"),
    [
        (STRAIGHT, NEAR, {}, True),
        (STRAIGHT, DETOUR, {"free": False}, True),
        (STRAIGHT, DETOUR, {"pose": SE2(1.0, 0.8, 0.0)}, True),  # it is not on its path any more
        (DETOUR, STRAIGHT, {}, True),  # it is clearly shorter
        (DETOUR, MIRRORED, {}, False),
    ],
)
def test_a_free_path_is_kept_unless_another_clearly_beats_it(
    script: Script, followed: Any, path: Any, given: dict[str, Any], taken: bool
) -> None:
    assert script.follow(followed).replan(path, **given) is taken
    assert script.followed is (path if taken else followed)


def test_a_new_path_waits_until_the_old_one_is_checked(script: Script) -> None:
    script.follow()
    script.tick(1.0)
    assert script.tick(plan=planned(DETOUR)) == []
    assert script.tick(check=False) == ["follow"]


def test_a_path_that_comes_with_the_end_of_following_changes_nothing(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    script.tick(plan=planned(DETOUR), check=False, follow=True)
    assert script.end == SUCCEEDED


def test_a_path_that_comes_with_trouble_is_followed_once_cleared(script: Script) -> None:
    script.follow()
    script.tick(dt=1.0)
    assert script.tick(plan=planned(DETOUR), check=False, follow=STUCK) == ["clear_local"]
    assert script.tick(clear_local=True) == ["follow"]
    assert script.followed is DETOUR


def test_keeps_a_path_as_its_configuration_says() -> None:
    assert not Script(config=NavigatorConfig(same_way_deviation=0.05)).follow().replan(NEAR)
    ready = NavigatorConfig(same_way_deviation=0.05, shorter_ratio=1.0)
    assert Script(config=ready).follow(NEAR).replan(NEAR[2:])


def test_clears_the_local_costmap_and_follows_once_more(script: Script) -> None:
    script.follow()
    assert script.tick(follow=STUCK) == ["clear_local"]
    assert script.tick() == []
    assert script.tick(clear_local=True) == ["follow"]
    assert script.followed is STRAIGHT
    assert script.recoveries == 0
    assert script.tick(follow=STUCK) == ["clear_local"]
    assert script.recoveries == 1
    assert script.tick(clear_local=True) == ["clear_global"]


def test_after_trouble_the_next_path_is_taken_whatever_it_is(script: Script) -> None:
    script.follow()
    script.tick(follow=STUCK)
    script.tick(clear_local=True)
    assert script.replan(DETOUR)
    assert not script.replan(DETOUR * np.array([1.0, -1.0, -1.0]))


def test_recovers_in_turn_and_gives_up_after_six(script: Script) -> None:
    script.tick()
    done = []
    for _ in range(6):
        (asked,) = script.fail_to_plan()
        done.append(asked)
        assert script.tick() == []
        answer: dict[str, Any] = {asked: True}
        if asked == "clear_local":
            assert script.tick(**answer) == ["clear_global"]
            answer = {"clear_global": True}
        assert script.tick(**answer) == ["plan"]
    kinds = ["clear_local", "Spin", "Wait", "BackUp"]
    assert done == list(itertools.islice(itertools.cycle(kinds), 6))
    assert script.fail_to_plan() == []
    assert script.end == Finish(Ending.ABORTED, 208, "NO_VALID_PATH")
    assert script.recoveries == 6


def test_what_stays_on_a_goal_and_is_seen_after_each_clearing_ends_it(script: Script) -> None:
    script.follow()
    for _ in range(7):
        assert script.tick(1.0) == ["check", "plan"]
        assert script.tick(0.1, plan=failed(), check=True) == ["clear_global"]
        assert script.tick(clear_global=True) == ["check", "plan"]
        script.tick(0.1, plan=planned(), check=True)
    script.tick(1.0)
    assert "clear_local" in script.tick(0.1, plan=failed(), check=True)
    assert script.recoveries == 1


def test_the_configurations_defaults_are_the_numbers_of_nav2s_tree() -> None:
    tree = shipped_file("behavior_trees") / "navigate_to_pose_w_replanning_and_recovery.xml"
    text, config = tree.read_text(encoding="utf-8"), NavigatorConfig()
    names = {"hz": "replanning_frequency"}
    for port in ("number_of_retries", "hz", "spin_dist", "wait_duration", "backup_dist"):
        first = re.search(rf'{port}="([\d.]+)"', text)
        assert first is not None
        assert float(first[1]) == getattr(config, names.get(port, port)), port
    assert f'backup_speed="{config.backup_speed}"' in text
    assert config.outage_patience == 30.0


def test_the_tree_takes_its_numbers_from_the_configuration(script: Script) -> None:
    text = (shipped_file("behavior_trees") / "navigate_to_pose.xml").read_text(encoding="utf-8")
    ports = {"replanning_frequency": "hz", "outage_patience": "patience"}
    ports["passed_goal_radius"] = "radius"
    for field in fields(NavigatorConfig):
        assert f' {ports.get(field.name, field.name)}="{{{field.name}}}"' in text
        assert script.entry(field.name) == getattr(NavigatorConfig(), field.name)


def test_a_failing_recovery_is_followed_by_the_next_and_comes_round_to_clearing(
    script: Script,
) -> None:
    script.tick()
    script.fail_to_plan()
    script.tick(clear_local=True)
    script.tick(clear_global=True)
    assert script.fail_to_plan() == ["Spin"]
    assert script.tick(Spin=BLOCKED) == ["Wait"]
    assert script.recoveries == 2
    script.tick(Wait=Answer(False, 740, "no"))
    assert script.tick(BackUp=Answer(False, 714, "no")) == ["clear_local"]
    script.tick(clear_local=True)
    assert script.tick(clear_global=True) == ["plan"]


@pytest.mark.parametrize(
    "status",
    [
        PlanStatus.INVALID_PLANNER,
        PlanStatus.START_OUTSIDE_MAP,
        PlanStatus.GOAL_OUTSIDE_MAP,
        PlanStatus.GOAL_OCCUPIED,
        ControlStatus.INVALID_CONTROLLER,
        ControlStatus.INVALID_PATH,
    ],
)
def test_aborts_at_once_where_no_recovery_helps(
    script: Script, status: PlanStatus | ControlStatus
) -> None:
    if isinstance(status, ControlStatus):
        script.follow().tick(follow=failed(status))
    else:
        script.tick()
        script.tick(plan=failed(status))
    assert script.end == Finish(Ending.ABORTED, int(status), status.name)


def test_ends_with_the_error_that_ended_it_whatever_went_wrong_before(script: Script) -> None:
    script.follow()
    script.tick(follow=STUCK)
    script.tick(clear_local=True)
    script.tick(dt=1.0)
    script.tick(plan=failed(PlanStatus.GOAL_OCCUPIED))
    assert script.end == Finish(Ending.ABORTED, 206, "GOAL_OCCUPIED")


@pytest.mark.parametrize(
    ("phase", "withdrawn"),
    [("planning", "-plan"), ("following", "-follow"), ("recovering", "-clear_local")],
)
def test_cancel_stops_everything_at_once(script: Script, phase: str, withdrawn: str) -> None:
    script.tick()
    if phase == "following":
        script.tick(plan=planned())
    elif phase == "recovering":
        script.fail_to_plan()
    assert script.tick(cancel=True) == [withdrawn]
    assert script.end == Finish(Ending.CANCELED)


def test_a_new_goal_is_planned_to_at_once_while_the_old_path_is_followed(script: Script) -> None:
    other = SE2(0.0, 3.0, 1.0)
    script.follow()
    assert script.tick(goals=(other,)) == ["check", "plan"]
    assert script.asked["plan"]["goal"] == other
    path = polyline([(0.0, 0.0), (0.0, 3.0)], 1.0)
    assert script.tick(plan=planned(path), check=True) == ["follow"]
    assert script.followed is path
    script.tick(follow=True)
    assert script.end == SUCCEEDED


def test_the_end_of_the_old_path_is_no_success_for_a_new_goal(script: Script) -> None:
    script.follow()
    script.tick(goals=(SE2(0.0, 3.0, 1.0),))
    script.tick(follow=True)
    assert script.end is None
    assert script.tick() == ["plan"]
    script.tick(plan=planned(DETOUR))
    script.tick(follow=True)
    assert script.end == SUCCEEDED


def test_a_new_goal_ends_a_recovery(script: Script) -> None:
    other = SE2(0.0, 3.0, 1.0)
    script.tick()
    script.fail_to_plan()
    assert script.tick(goals=(other,)) == ["-clear_local", "plan"]
    assert script.asked["plan"]["goal"] == other


def test_poses_before_the_last_are_dropped_as_they_are_passed() -> None:
    goals = (SE2(1.0, 0.0), SE2(2.0, 0.0), GOAL)
    script = Script(goals, THROUGH).follow()
    assert script.asked["plan"]["goals"] == goals
    assert script.feedback()["number_of_poses_remaining"] == 3
    script.replan(STRAIGHT, pose=SE2(0.9, 0.0))
    assert script.asked["plan"]["goals"] == goals[1:]
    script.replan(STRAIGHT, pose=SE2(3.9, 0.0))
    assert script.asked["plan"]["goals"] == goals[1:], "far beyond is not passed"
    assert script.feedback()["number_of_poses_remaining"] == 2


@pytest.mark.parametrize(("code", "recovers"), [(308, True), (300, True), (306, False)])
def test_planning_through_poses_has_codes_of_its_own(code: int, recovers: bool) -> None:
    script = Script((SE2(1.0), GOAL), THROUGH)
    script.tick()
    asked = script.tick(plan=Answer(False, code, "no"))
    assert (asked == ["clear_global"]) is recovers
    assert recovers or script.end == Finish(Ending.ABORTED, code, "no")


def test_feedback_is_nav2s(script: Script) -> None:
    assert script.feedback(SE2(), speed=0.5)["distance_remaining"] == 4.0  # the straight one
    script.follow().tick(4.8)
    pose = SE2(1.0, 0.2, 0.0)
    progress = script.feedback(pose, speed=0.5)
    assert progress["navigation_time"] == 5.0
    assert progress["distance_remaining"] == pytest.approx(3.0)
    assert progress["estimated_time_remaining"] == pytest.approx(6.0)
    assert (progress["number_of_recoveries"], progress["number_of_poses_remaining"]) == (0, 1)
    assert script.feedback(pose, speed=0.005)["estimated_time_remaining"] == 0.0


def test_the_time_of_navigation_starts_again_with_a_new_goal(script: Script) -> None:
    script.follow().tick(4.8)
    script.tick(goals=(SE2(2.0),))
    assert script.feedback()["navigation_time"] == 0.0


@pytest.mark.parametrize("status", [ControlStatus.TF_ERROR, ControlStatus.CONTROLLER_TIMED_OUT])
def test_an_outage_is_stood_through(status: ControlStatus) -> None:
    script = Script()
    script.follow()
    for _ in range(5):
        assert script.tick(follow=failed(status)) == []
        assert status.name in script.navigator.trouble()
        assert script.tick(0.9) == []
        assert script.tick(0.2) == ["plan"]
        assert script.tick(plan=planned()) == ["follow"]
        assert script.followed is STRAIGHT
    script.tick(3.0)
    assert script.navigator.trouble() == ""
    assert script.recoveries == 0


@pytest.mark.parametrize(
    "status", [ControlStatus.TF_ERROR, PlanStatus.TF_ERROR, PlanStatus.START_OCCUPIED]
)
def test_a_long_outage_ends_the_goal_with_its_reason(status: ControlStatus | PlanStatus) -> None:
    script = Script(config=NavigatorConfig(outage_patience=4.0))
    script.tick()
    while script.now < 20.0 and script.end is None:
        if isinstance(status, PlanStatus):
            script.tick(0.05, plan=failed(status))
        else:
            script.tick(0.02, plan=planned())
            script.tick(0.03, follow=failed(status))
        if script.end is None:
            assert script.tick(1.05) == ["plan"]
    assert script.end == Finish(Ending.ABORTED, int(status), status.name)
    assert 4.0 < script.now < 8.0


def test_outages_with_a_drive_between_them_each_have_all_the_patience() -> None:
    script = Script(config=NavigatorConfig(outage_patience=4.0)).follow()
    for _ in range(5):
        assert script.tick(follow=failed(ControlStatus.TF_ERROR)) == []
        assert script.tick(1.1) == ["plan"]
        assert script.tick(plan=planned()) == ["follow"]
        assert script.replan(STRAIGHT.copy())
        assert script.replan(STRAIGHT.copy())
    assert script.end is None


def test_a_tree_that_lacks_an_entry_ends_the_goal_and_its_requests() -> None:
    tree = build_tree(
        '<root><BehaviorTree ID="T"><Parallel success_count="2"><Wait/>'
        '<ScriptCondition code="none &gt; 1"/></Parallel></BehaviorTree></root>',
        "mine.xml",
    )
    navigator = Navigator(tree, NavigatorConfig(), (), (GOAL,), 0.0)
    requests, end = navigator.tick(TreeState(0.1))
    assert requests == [Withdraw(1)]
    assert end is not None
    assert (end.ending, end.error_code) == (Ending.ABORTED, 0)
    assert "none is not on the blackboard" in end.error_msg


@pytest.mark.parametrize("named", [True, False])
def test_a_tree_without_ports_for_messages_ends_with_what_its_action_said(named: bool) -> None:
    port = ' error_code_id="{wait_error_code}"' if named else ""
    text = f'<root><BehaviorTree ID="T"><Spin{port}/></BehaviorTree></root>'
    tree = build_tree(text, "mine.xml")
    navigator = Navigator(tree, NavigatorConfig(), ("wait_error_code",), (GOAL,), 0.0)
    navigator.tick(TreeState(0.1))
    _, end = navigator.tick(TreeState(0.2, answers={1: BLOCKED}))
    reason = "" if named else "the behavior tree failed, without an error code: "
    assert end == Finish(Ending.ABORTED, 703 if named else 0, f"{reason}collision ahead")
