"""explorer: drives to what is unknown until nothing is; and under the name of explore_lite."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from map_msgs.msg import OccupancyGridUpdate
from nav2_msgs.action import BackUp, NavigateToPose, Spin
from std_msgs.msg import Bool, String
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import se2_from_pose
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from bringup.stack import EXPLORER, PROGRAMS, NodeSpec
from tests.helpers.nav.navigation import PlayedRobot
from tests.nav.worlds import room

BLACKLIST_RADIUS = 0.5
PATIENCE = 3.0


class FakeNavigator(ManagedNode):
    """Takes goals and ends them as the test says."""

    DEFAULT_NAME = "bt_navigator"
    refuses = False

    def configure(self) -> None:
        """Offer the action."""
        self.goals: list[SE2] = []
        self.turns: list[float] = []
        self.server = self.keep(
            GoalServer(self, NavigateToPose, "navigate_to_pose", self._on_goal, self._admit)
        )
        self.spinner = self.keep(GoalServer(self, Spin, "spin", self._on_spin))
        self.backer = self.keep(GoalServer(self, BackUp, "backup", self._on_backup))
        self.backed_up: list[float] = []

    def _admit(self, goal: Any) -> str | None:
        return "by order" if self.refuses else None

    def _on_goal(self) -> None:
        self.goals.append(se2_from_pose(self.server.take_newest().pose.pose))

    def _on_spin(self) -> None:
        self.turns.append(self.spinner.goal.target_yaw)

    def _on_backup(self) -> None:
        self.backed_up.append(self.backer.goal.target.x)

    def end(self, *, reached: bool) -> None:
        """End the running goal."""
        (self.server.succeed if reached else self.server.abort)(NavigateToPose.Result())


class Exploration:
    """A robot that explores, with a navigator that the test plays."""

    def __init__(self, explorer: NodeSpec = EXPLORER, **values: Any) -> None:
        self.robot = PlayedRobot({explorer.name: values} if values else None)
        self.map = room()
        self.statuses = self.robot.bench.collect(String, "/explorer/status", qos.LATCHED)
        self.markers = self.robot.bench.collect(MarkerArray, "explore/frontiers")
        self.navigator = self.make_navigator()
        self.robot.bring_up(explorer)
        self.robot.run(0.1)

    def make_navigator(self) -> FakeNavigator:
        navigator: FakeNavigator = self.robot.bench.activated(FakeNavigator)
        return navigator

    def hide(self, *xs: tuple[float, float]) -> None:
        """Make the map unknown between pairs of x and send it."""
        self.map = room()
        for low, high in xs:
            self.map.data[:, round((low + 5.5) / 0.05) : round((high + 5.5) / 0.05)] = -1
        self.robot.send_map(self.map)

    def look_for(self, *xs: tuple[float, float]) -> None:
        """Hide a part of the map and let the explorer look at it once."""
        self.hide(*xs)
        self.robot.run(1.2)

    @property
    def said(self) -> str:
        return str(self.statuses[-1].data) if self.statuses else ""


@pytest.fixture
def exploration() -> Exploration:
    return Exploration()


def test_a_frontier_is_driven_to_until_it_is_seen(exploration: Exploration) -> None:
    exploration.look_for((2.0, 5.5))
    (goal,) = exploration.navigator.goals
    assert 1.0 <= goal.x < 2.0
    row, column = exploration.map.frame.to_cell(goal.x, goal.y)
    assert exploration.map.data[row, column] == 0
    assert abs(goal.theta) < np.pi / 2  # it looks at what is unknown
    assert exploration.said.startswith("exploring: to (")
    exploration.robot.run(4.0)
    assert len(exploration.navigator.goals) == 1
    exploration.look_for((-5.5, -2.0))  # the first was seen in passing
    assert exploration.navigator.goals[1].x < 0.0


def test_it_is_done_once_nothing_is_unknown(exploration: Exploration) -> None:
    exploration.look_for((2.0, 5.5))
    exploration.hide()
    exploration.navigator.end(reached=True)
    exploration.robot.run(PATIENCE - 0.5)
    assert not exploration.said.startswith("done")
    exploration.robot.run(2.0)
    assert exploration.said == "done: looked from 1 places"
    exploration.hide((2.0, 5.5))
    exploration.robot.run(3.0)
    assert len(exploration.navigator.goals) == 1  # done is done


def test_a_goal_that_cannot_be_reached_is_not_tried_again(exploration: Exploration) -> None:
    exploration.hide((2.0, 5.5))
    for _ in range(40):
        exploration.robot.run(1.0)
        if exploration.said.startswith("done"):
            break
        exploration.navigator.end(reached=False)
    goals = exploration.navigator.goals
    assert exploration.said == f"done: looked from {len(goals)} places"
    gaps = [a.distance(b) for i, a in enumerate(goals) for b in goals[:i]]
    assert min(gaps, default=BLACKLIST_RADIUS) > BLACKLIST_RADIUS - 0.06
    assert len(goals) > 2


def test_a_refused_goal_is_asked_again(exploration: Exploration) -> None:
    exploration.navigator.refuses = True
    exploration.hide((2.0, 5.5))
    exploration.robot.run(PATIENCE + 3.0)
    assert not exploration.said.startswith("done")
    exploration.navigator.refuses = False
    exploration.robot.run(1.2)
    assert len(exploration.navigator.goals) == 1


def test_deactivation_cancels_the_goal_and_activation_continues(exploration: Exploration) -> None:
    exploration.look_for((2.0, 5.5))
    exploration.robot.transition("explorer", "deactivate")
    assert exploration.navigator.server.cancel_requested
    exploration.navigator.server.cancel(NavigateToPose.Result())
    exploration.robot.run(3.0)
    assert len(exploration.navigator.goals) == 1
    exploration.robot.transition("explorer", "activate")
    exploration.robot.run(1.2)
    assert len(exploration.navigator.goals) == 2


def test_activation_after_the_end_begins_again(exploration: Exploration) -> None:
    exploration.hide()
    exploration.robot.run(PATIENCE + 2.0)
    assert exploration.said.startswith("done")
    exploration.robot.transition("explorer", "deactivate")
    exploration.robot.transition("explorer", "activate")
    exploration.look_for((2.0, 5.5))
    assert len(exploration.navigator.goals) == 1


def test_a_navigator_that_dies_and_comes_back_is_asked_again(exploration: Exploration) -> None:
    exploration.look_for((2.0, 5.5))
    exploration.navigator.trigger_shutdown()  # without a word on its goal
    exploration.robot.run(2.0)
    navigator = exploration.make_navigator()
    exploration.robot.run(1.2)
    assert len(navigator.goals) == 1


def test_time_set_back_restarts_patience(exploration: Exploration) -> None:
    exploration.robot.run(50.0)
    exploration.hide()
    exploration.robot.run(PATIENCE - 0.5)
    exploration.robot.bench.set_back()
    exploration.robot.run(PATIENCE - 0.5)
    assert not exploration.said.startswith("done")
    exploration.robot.run(2.5)
    assert exploration.said.startswith("done")


def test_a_robot_that_sees_only_ahead_turns_round_at_the_end(exploration: Exploration) -> None:
    exploration.hide((-5.5, 1.0))  # it stands at 0, in what is unknown
    exploration.robot.run(2.0)
    assert exploration.navigator.turns == pytest.approx([2.0 * np.pi])
    assert exploration.said == "exploring: looking round"
    exploration.robot.run(PATIENCE + 2.0)
    assert not exploration.said.startswith("done")  # while it turns
    exploration.hide((2.0, 5.5))
    exploration.navigator.spinner.succeed(Spin.Result())
    exploration.robot.run(2.0)
    assert len(exploration.navigator.goals) == 1
    assert len(exploration.navigator.turns) == 1


def test_a_robot_before_a_wall_backs_up_once_to_turn_round(exploration: Exploration) -> None:
    exploration.hide((-5.5, 1.0))
    navigator = exploration.navigator
    exploration.robot.run(2.0)
    navigator.spinner.abort(Spin.Result())
    exploration.robot.run(PATIENCE + 2.0)
    assert navigator.backed_up == [0.3]
    assert exploration.said == "exploring: backing up"
    navigator.backer.succeed(BackUp.Result())
    exploration.robot.run(2.0)
    assert len(navigator.turns) == 2
    navigator.spinner.abort(Spin.Result())
    exploration.robot.run(PATIENCE + 2.0)
    assert len(navigator.backed_up) == 1
    assert exploration.said == "done: looked from 0 places"


def test_what_it_waits_for_is_said_with_its_remedy(exploration: Exploration) -> None:
    explorer = exploration.robot.nodes["explorer"]
    assert "no map has come on 'map': is" in explorer.waits_for
    exploration.hide((2.0, 5.5))
    exploration.robot.run(0.2)
    assert explorer.waits_for == ""
    exploration.navigator.trigger_deactivate()
    exploration.navigator.trigger_cleanup()
    exploration.robot.run(1.2)
    assert "nobody serves 'navigate_to_pose': is" in explorer.waits_for


def test_a_wrong_base_frame_is_said_with_its_remedy() -> None:
    robot = PlayedRobot({"explorer": {"robot_base_frame": "chassis"}})
    FakeNavigator(robot.bench.process).trigger_configure()
    robot.bring_up(EXPLORER)
    robot.send_map(room())
    robot.run(0.2)
    assert robot.nodes["explorer"].waits_for == (
        "robot_base_frame is 'chassis', a frame that does not exist:"
        " 'map' carries 'base_footprint'; set robot_base_frame: base_footprint,"
        " or start it with --base-frame base_footprint"
    )


VALUES = {"costmap_topic": "map", "costmap_updates_topic": "map_updates", "visualize": True}


@pytest.fixture
def started() -> Exploration:
    values = {**VALUES, "return_to_init": True, "progress_timeout": 4.0}
    return Exploration(PROGRAMS["explore_lite", "explore"], **values)


def test_it_explores_shows_frontiers_and_returns(started: Exploration) -> None:
    started.look_for((2.0, 5.5))
    (goal,) = started.navigator.goals
    assert 1.0 <= goal.x < 2.0
    shown = started.markers[-1].markers
    assert {round(point.x, 3) for marker in shown for point in marker.points} == {1.975}
    started.look_for()
    started.navigator.end(reached=True)
    started.robot.run(3.0)
    assert len(started.navigator.goals) == 2
    assert started.navigator.goals[1].distance(started.robot.pose) < 0.1
    last = next(one.markers for one in reversed(started.markers) if one.markers)
    assert {marker.action for marker in last} == {Marker.DELETE}


def test_a_goal_without_progress_is_given_up(started: Exploration) -> None:
    started.look_for((2.0, 5.5))
    started.robot.run(6.0)
    first, second = started.navigator.goals[:2]
    assert first.distance(second) > 0.4


def test_it_stops_and_resumes_by_its_topic(started: Exploration) -> None:
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=False))
    started.look_for((2.0, 5.5))
    assert not started.navigator.goals
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=True))
    started.robot.run(1.2)
    assert len(started.navigator.goals) == 1
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=False))
    started.robot.run(0.2)
    assert started.navigator.server.cancel_requested


def test_changes_of_the_map_count(started: Exploration) -> None:
    started.look_for()
    started.navigator.goals.clear()
    unknown = OccupancyGridUpdate(x=150, y=0, width=70, height=220)
    unknown.data = np.full(70 * 220, -1, np.int8)
    started.robot.bench.publish(OccupancyGridUpdate, "map_updates", unknown)
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=True))
    started.robot.run(1.2)
    assert any(goal.x > 1.0 for goal in started.navigator.goals)
