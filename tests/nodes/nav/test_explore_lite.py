"""explore: the explorer with explore_lite's parameters, topics and ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from map_msgs.msg import OccupancyGridUpdate
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker, MarkerArray

from bringup.stack import PROGRAMS
from tests.helpers.nav.navigation import PlayedRobot
from tests.nav.worlds import room
from tests.nodes.nav.test_explorer import FakeNavigator

VALUES = {"costmap_topic": "map", "costmap_updates_topic": "map_updates", "visualize": True}


class Started:
    """An explorer at work, with a navigator that the test plays."""

    def __init__(self, **values: Any) -> None:
        self.robot = PlayedRobot({"explore_node": {**VALUES, **values}})
        self.markers = self.robot.bench.collect(MarkerArray, "explore/frontiers")
        self.navigator: FakeNavigator = self.robot.bench.activated(FakeNavigator)
        self.robot.bring_up(PROGRAMS["explore_lite", "explore"])

    def hide(self, low: float = 5.5) -> None:
        """Send the room of which nothing is known from an x on."""
        grid = room()
        grid.data[:, round((low + 5.5) / 0.05) :] = -1
        self.robot.send_map(grid)
        self.robot.run(1.2)


@pytest.fixture
def started() -> Started:
    return Started(return_to_init=True, progress_timeout=4.0)


def test_it_explores_shows_frontiers_and_returns(started: Started) -> None:
    started.hide(2.0)
    (goal,) = started.navigator.goals
    assert 1.0 <= goal.x < 2.0
    (marker,) = started.markers[-1].markers
    assert {round(point.x, 3) for point in marker.points} == {1.975}
    started.hide()
    started.navigator.end(reached=True)
    started.robot.run(3.0)
    assert len(started.navigator.goals) == 2
    assert started.navigator.goals[1].distance(started.robot.pose) < 0.1
    (marker,) = next(one.markers for one in reversed(started.markers) if one.markers)
    assert marker.action == Marker.DELETE


def test_a_goal_without_progress_is_given_up(started: Started) -> None:
    started.hide(2.0)
    started.robot.run(6.0)
    first, second = started.navigator.goals[:2]
    assert first.distance(second) > 0.4


def test_it_stops_and_resumes_by_its_topic(started: Started) -> None:
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=False))
    started.hide(2.0)
    assert not started.navigator.goals
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=True))
    started.robot.run(1.2)
    assert len(started.navigator.goals) == 1
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=False))
    started.robot.run(0.2)
    assert started.navigator.server.cancel_requested


def test_changes_of_the_map_count(started: Started) -> None:
    started.hide()
    started.navigator.goals.clear()
    unknown = OccupancyGridUpdate(x=150, y=0, width=70, height=220)
    unknown.data = np.full(70 * 220, -1, np.int8)
    started.robot.bench.publish(OccupancyGridUpdate, "map_updates", unknown)
    started.robot.bench.publish(Bool, "explore/resume", Bool(data=True))
    started.robot.run(1.2)
    assert any(goal.x > 1.0 for goal in started.navigator.goals)
