"""Arjuna's own nodes where the default tree, tested in test_navigator, does not come by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_core.se2 import SE2
from arjuna_nav.trees.exchange import Answer
from arjuna_nav.trees.node import Status
from tests.helpers.nav.tree_play import Play

RUNNING, SUCCESS, FAILURE = Status.RUNNING, Status.SUCCESS, Status.FAILURE
REPLAN = (
    '<PipelineSequence><ReplanningController hz="2"><Wait/></ReplanningController><Spin/>'
    "</PipelineSequence>"
)
OUTAGE = (
    '<WaitOutOutage error_code="{code}" error_msg="{why}" patience="3" problem="{p}">'
    '<Spin error_code_id="{code}" error_msg="{why}"/></WaitOutOutage>'
)
STRAIGHT = np.array([[0.1 * k, 0.0, 0.0] for k in range(41)])
DETOUR = np.array([[0.1 * k, 1.0, 0.0] for k in range(41)])


def test_a_period_counts_from_where_the_child_began() -> None:
    play = Play(REPLAN, goal=SE2(1.0))
    play.now = 50.0
    play.tick()
    play.tick(dt=0.4, Wait=True)
    play.tick(dt=0.09)
    assert set(play.open) == {"Spin"}
    play.tick(dt=0.02)
    assert set(play.open) == {"Spin", "Wait"}


def test_a_child_that_lasts_is_not_started_again() -> None:
    play = Play(REPLAN, goal=SE2(1.0))
    play.tick()
    first = play.open["Wait"]
    play.tick(dt=2.0)
    assert play.open["Wait"] == first
    play.tick(Wait=True)
    play.tick(dt=0.01)
    assert "Wait" in play.open, "its period was over long ago"


def test_a_goal_is_new_even_where_its_pose_is_the_old_one() -> None:
    play = Play(REPLAN, goal=SE2(1.0))
    play.tick()
    play.tick(Wait=True)
    play.tree.blackboard.set("goal", SE2(1.0))
    play.tick(dt=0.01)
    assert "Wait" in play.open


@pytest.mark.parametrize(
    ("pose", "newest", "preferred"),
    [
        (SE2(), "path", SUCCESS),
        (SE2(0.0, 0.4), "path", SUCCESS),
        (SE2(0.0, 0.6), "path", FAILURE),
        (None, "path", FAILURE),
        (SE2(), "goal", FAILURE),
    ],
)
def test_the_goals_path_is_kept_if_near(pose: SE2 | None, newest: str, preferred: Status) -> None:
    play = Play('<IsPathPreferred path="{path}" new_path="{new}"/>', new=DETOUR)
    older = "path" if newest == "goal" else "goal"
    for name in (older, newest):
        play.tree.blackboard.set(name, STRAIGHT if name == "path" else SE2(4.0))
    play.pose = pose
    assert play.tick() is preferred


@pytest.mark.parametrize(
    ("length", "preferred"), [(37, SUCCESS), (34, FAILURE)]
)  # of the 4.0 m that are left, 0.9 are clearly shorter
def test_a_path_is_left_for_one_that_is_clearly_shorter(length: int, preferred: Status) -> None:
    play = Play('<IsPathPreferred path="{path}" new_path="{new}"/>', new=DETOUR[: length + 1])
    play.tree.blackboard.set("path", STRAIGHT)
    assert play.tick() is preferred


@pytest.mark.parametrize(
    ("later", "aside", "poses", "preferred"),
    [
        (1.0, 0.1, 46, SUCCESS),
        (21.0, 0.1, 46, FAILURE),  # forgotten
        (1.0, 1.0, 46, FAILURE),  # another way
        (1.0, 0.1, 61, FAILURE),  # much shorter
    ],
)
def test_a_way_that_was_blocked_is_not_taken_again_at_once(
    later: float, aside: float, poses: int, preferred: Status
) -> None:
    play = Play('<IsPathPreferred path="{path}" new_path="{new}" free="{free}"/>', new=DETOUR)
    play.tree.blackboard.set("free", False)
    assert play.tick() is FAILURE  # there is no path that could be blocked
    play.tree.blackboard.set("path", STRAIGHT)
    assert play.tick() is FAILURE
    other = np.array([[0.1 * k, -1.0, 0.0] for k in range(poses)])
    beside = STRAIGHT + np.array([0.0, aside, 0.0])
    play.pose = SE2(0.0, -1.0)
    for name, value in (("free", True), ("path", other), ("new", beside)):
        play.tree.blackboard.set(name, value)
    assert play.tick(dt=later) is preferred


def test_a_path_is_kept_where_the_new_one_is_beside_it_but_driven_back() -> None:
    beside = STRAIGHT + np.array([0.0, 0.1, 0.0])
    for turned, preferred in ((0.0, FAILURE), (math.pi, SUCCESS)):
        new = beside + np.array([0.0, 0.0, turned])
        play = Play('<IsPathPreferred path="{path}" new_path="{new}"/>', new=new)
        play.tree.blackboard.set("path", STRAIGHT)
        assert play.tick() is preferred


@pytest.mark.parametrize(("code", "status"), [(102, RUNNING), (307, RUNNING), (106, FAILURE)])
def test_only_the_errors_of_an_outage_are_waited_out(code: int, status: Status) -> None:
    play = Play(OUTAGE)
    play.tick()
    assert play.tick(Spin=Answer(False, code, "no")) is status
    assert play.get("p") == ("no" if status is RUNNING else None)


def test_an_outage_ends_with_a_try_that_lasts() -> None:
    play = Play(OUTAGE)
    play.now = 50.0
    play.tick()
    play.tick(Spin=Answer(False, 102, "lost"))
    play.tick(dt=0.95)
    assert play.open == {}
    play.tick(dt=0.1)
    assert (set(play.open), play.get("p")) == ({"Spin"}, "lost")
    play.tick(dt=1.0)
    assert play.get("p") is None
    assert play.tick(Spin=True) is SUCCESS


def test_an_outage_is_waited_out_for_half_a_minute_where_nothing_is_said() -> None:
    play = Play(OUTAGE.replace('patience="3"', ""))
    play.now = 50.0
    play.tick()
    while play.tick(dt=0.01, Spin=Answer(False, 102, "lost")) is RUNNING:
        play.tick(dt=1.01)
    assert 30.0 < play.now - 50.0 < 32.0
