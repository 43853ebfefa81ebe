"""People about a robot: who touches whom, and how a played robot yields to them and to walls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_sim.model.entities import Entity
from bringup.scenarios.drive import Meetings, OwnMotion
from bringup.scenarios.people import boxes_in, settle, with_boxes
from tests.helpers.nav.layers import Body
from tests.helpers.nav.people import Pushes
from tests.nav.worlds import block, grid_of

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


PUSHED = Velocity(0.5, yaw_rate=-1.0)
SLOW = Velocity(0.04, yaw_rate=0.02)


@pytest.mark.parametrize(
    "ticks",
    [
        [  # it stops, and is pushed back
            (0.00, FORWARD, FORWARD, FORWARD),
            (0.02, STILL, Velocity(0.2), Velocity(0.2)),  # it brakes
            (0.04, STILL, Velocity(0.01), STILL),  # it stands
            (0.06, STILL, BACK, STILL),
            (0.08, BACK, BACK, BACK),
            (0.30, STILL, BACK, STILL),  # longer than it brakes
        ],
        [  # it is pushed ahead, wherever it drives
            (0.00, STILL, PUSHED, STILL),
            (0.02, SLOW, PUSHED, Velocity(0.04)),
            (0.04, BACK, PUSHED, STILL),
            (0.06, STILL, PUSHED, STILL),
        ],
        [  # a push turns the wheels of one that has just braked from a crawl
            (0.00, SLOW, SLOW, SLOW),
            (0.02, STILL, Velocity(0.03), STILL),
            (0.08, STILL, Velocity(0.03), STILL),
        ],
        [  # a fast turn ends late
            (0.00, Velocity(yaw_rate=1.9), Velocity(yaw_rate=1.9), Velocity(yaw_rate=1.9)),
            (0.10, STILL, Velocity(yaw_rate=1.0), Velocity(yaw_rate=1.0)),
            (0.22, STILL, Velocity(yaw_rate=0.1), Velocity(yaw_rate=0.1)),
            (0.30, STILL, Velocity(yaw_rate=0.1), STILL),
        ],
    ],
)
def test_a_robot_moves_itself_no_faster_than_it_was_commanded_to(
    ticks: list[tuple[float, Velocity, Velocity, Velocity]],
) -> None:
    motion = OwnMotion()
    for now, command, wheels, own in ticks:
        found = motion.update(now, command, wheels)
        assert (found.x, found.yaw_rate) == pytest.approx((own.x, own.yaw_rate)), now


class Stage:
    """Takes what is spawned."""

    def __init__(self) -> None:
        self.spawned: list[Entity] = []

    def spawn(self, entity: Entity, walked: float = 0.0) -> None:
        self.spawned.append(entity)


def test_people_walk_where_there_is_room_between_boxes_off_the_walls() -> None:
    grid = grid_of(9.0, 7.0, (4.4, 0.0, 0.2, 4.0))
    walls = ((0.0, 0.0, 9.0, 0.1), (0.0, 6.9, 9.0, 0.1), (0.0, 0.0, 0.1, 7.0), (8.9, 0.0, 0.1, 7.0))
    for wall in walls:
        block(grid, *wall)
    start, rng, stage = SE2(1.0, 1.0), np.random.default_rng(1), Stage()
    boxes = boxes_in(grid, 3, start, rng)
    whole = with_boxes(grid, boxes)
    settle(stage, whole, boxes, 4, start, rng, {})
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


NO_WALLS = np.zeros((0, 4))


def walked_over(offset: float, walls: NDArray[np.float64] = NO_WALLS, start: SE2 = IDENTITY) -> SE2:
    """Return where a robot is when somebody has walked by along x."""
    pushes, pose = Pushes(CORNERS, walls), start
    for x in np.arange(-1.0, 1.5, 0.04):
        pose = pushes.yield_to(pose, np.array([(x, offset, 0.25)]))
    return pose


def test_who_meets_nobody_stays() -> None:
    assert walked_over(0.5) is IDENTITY


def test_who_is_met_square_is_carried_along() -> None:
    pose = walked_over(0.0)
    assert (pose.x, pose.y, pose.theta) == pytest.approx((1.48 + 0.25 + 0.2, 0.0, 0.0), abs=2e-3)


@pytest.mark.parametrize("turn", [0.0, 2.2])
def test_who_is_met_beside_its_middle_turns_and_slips_off(turn: float) -> None:
    start = SE2(0.0, 0.0, turn)
    above, below = walked_over(0.15, start=start), walked_over(-0.15, start=SE2(0.0, 0.0, -turn))
    assert 0.05 < above.x < 1.0
    assert above.y < -0.1
    assert 0.2 < abs(above.theta - turn) < math.pi / 2
    mirrored = SE2(below.x, -below.y, -below.theta)
    assert mirrored.array() == pytest.approx(above.array(), abs=1e-6)


@pytest.mark.parametrize("face", [0.2, 0.3])
def test_walls_hold_who_is_pressed_and_people_step_over(face: float) -> None:
    wall = np.array([(face, -2.0, face, 2.0)])
    pose = walked_over(0.0, wall)
    assert face - 0.2 - 0.01 < pose.x <= face - 0.2
    assert pose.theta == pytest.approx(0.0, abs=0.03)


def test_the_end_of_a_wall_turns_who_is_pressed_against_it() -> None:
    wall = np.array([(0.21, 0.1, 2.0, 0.1), (2.0, 0.1, 0.21, 0.1)])
    pushes = Pushes(CORNERS, wall)
    pose = pushes.yield_to(IDENTITY, np.array([(-0.42, 0.0, 0.25)]))
    assert pushes.pinned
    assert pose.theta > 0.01
    assert pose.x < 0.025  # of 0.03
    pushes.yield_to(SE2(-1.0), np.zeros((0, 3)))
    assert not pushes.pinned
