"""Who walked or drove into the other where a robot and people meet, as benchmarks count it."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_sim.model.entities import Entity
from tests.helpers.nav.inhabited import boxes_in, settle, with_boxes
from tests.helpers.nav.layers import Body
from tests.helpers.nav.people import Meetings
from tests.nav.worlds import block, empty_grid

CORNERS = Body.box(0.4, 0.4).corners
STILL, FORWARD, BACK = Velocity(), Velocity(0.3), Velocity(-0.3)
AHEAD, BESIDE = (0.44, 0.0, 0.25), (0.15, 0.44, 0.25)


def meet(velocity: Velocity, person: tuple[float, float, float], pose: SE2 = IDENTITY) -> Meetings:
    meetings = Meetings(CORNERS)
    middle = pose.apply(np.array([person[:2]]))[0]
    meetings.update(pose, velocity, np.array([(*middle, person[2])]))
    return meetings


@pytest.mark.parametrize("pose", [SE2(), SE2(3.0, -1.0, 2.2)])
@pytest.mark.parametrize(
    ("velocity", "person", "bumps"),
    [
        (STILL, AHEAD, 0),
        (FORWARD, AHEAD, 1),
        (BACK, AHEAD, 0),
        (FORWARD, BESIDE, 0),
        (Velocity(yaw_rate=1.0), BESIDE, 1),
        (Velocity(yaw_rate=-1.0), BESIDE, 0),
    ],
)
def test_a_touch_is_the_robots_where_its_side_moves_towards_the_person(
    velocity: Velocity, person: tuple[float, float, float], bumps: int, pose: SE2
) -> None:
    meetings = meet(velocity, person, pose)
    assert (meetings.hits, meetings.bumped) == (1, bumps)


def test_one_touch_counts_once_and_as_the_robots_where_it_presses_on() -> None:
    meetings, person = Meetings(CORNERS), np.array([AHEAD])
    for velocity, bumped in ((STILL, 0), (Velocity(0.05), 0), (FORWARD, 1), (FORWARD, 1)):
        meetings.update(SE2(), velocity, person)
        assert (meetings.hits, meetings.bumped) == (1, bumped)
    meetings.update(SE2(), STILL, np.array([(1.0, 0.0, 0.25)]))
    meetings.update(SE2(), STILL, person)
    assert (meetings.hits, meetings.bumped) == (2, 1)


class Stage:
    """Takes what is spawned."""

    def __init__(self) -> None:
        self.spawned: list[Entity] = []

    def spawn(self, entity: Entity) -> None:
        self.spawned.append(entity)


def test_people_walk_where_there_is_room_between_boxes_off_the_walls() -> None:
    grid = empty_grid(9.0, 7.0)
    block(grid, 4.4, 0.0, 0.2, 4.0)
    walls = ((0.0, 0.0, 9.0, 0.1), (0.0, 6.9, 9.0, 0.1), (0.0, 0.0, 0.1, 7.0), (8.9, 0.0, 0.1, 7.0))
    for wall in walls:
        block(grid, *wall)
    start, rng, stage = SE2(1.0, 1.0), np.random.default_rng(1), Stage()
    boxes = boxes_in(grid, 3, start, rng)
    whole = with_boxes(grid, boxes)
    settle(stage, whole, boxes, 4, start, rng)
    names = [entity.name for entity in stage.spawned]
    assert names == ["box_0", "box_1", "box_2", "person_0", "person_1", "person_2", "person_3"]
    assert min(np.hypot(*(boxes - (start.x, start.y)).T)) > 1.4
    for entity in stage.spawned[3:]:
        walk = entity.trajectory
        assert walk is not None
        assert start.distance(walk.pose(0.0)) > 1.4
        for time in np.arange(0.0, walk.times[-1], 0.1):
            at = walk.pose(float(time))
            row, column = whole.frame.to_cell(at.x, at.y)
            about = whole.data[row - 4 : row + 5, column - 4 : column + 5]
            assert not (about > 0).any()
