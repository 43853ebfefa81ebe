"""Entities of worlds, actors and robots: their parts and poses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.model.entities import (
    Category,
    Entity,
    bounds,
    entity_of_actor,
    entity_of_model,
    entity_of_robot,
    moving_entities,
)
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.urdf import Hinge
from arjuna_sim.model.world import (
    PERSON,
    Actor,
    Body,
    Movable,
    Trajectory,
    World,
    ground_bodies,
    is_ground,
    person,
)
from tests.sim.wheeled import weight, wheeled

BOX = Shape(Kind.BOX, (2.0, 4.0, 6.0))
AT = Pose3.from_rpy((1.0, 2.0, 3.0), (0.0, 0.0, math.pi / 2))
PATH = SE2(), SE2(2.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0), SE2(2.0, 2.0, 1.0)
WALK = Trajectory((0.0, 2.0, 2.0, 4.0), PATH, delay=1.0)
ACTOR = Actor("bob", person(), SE2(3.0, 4.0, 0.5), WALK)
DOOR = Hinge(False, (0.0, 0.0, 1.0))


def world() -> World:
    """Return a world with a crate that can be pushed, a door, a wall, a ground and a person."""
    part = Part(BOX, AT @ Pose3((0.5, 0.0, 0.0)), (1.0, 0.0, 0.0, 1.0))
    bodies = [Body(name, part, True, AT) for name in ("crate", "door", "wall")]
    drawn = Body("crate", Part(BOX, AT), False, AT)
    return World(
        Path("w.world"),
        "yard",
        (*ground_bodies(), *bodies, drawn),
        (),
        (ACTOR,),
        {"crate": Movable(5.0, None, False), "door": Movable(2.0, DOOR, True)},
    )


def test_a_model_stands_where_its_world_has_it() -> None:
    found = entity_of_model(world(), "crate")
    assert (found.name, found.start) == ("crate", AT)
    assert found.description == "a model of the world 'yard'"
    ((solid,), (drawn,)) = found.solid, found.drawn
    assert solid.pose.position == pytest.approx((0.5, 0.0, 0.0))
    assert solid.rgba == (1.0, 0.0, 0.0, 1.0)
    assert drawn.pose.position == pytest.approx((0.0, 0.0, 0.0))
    assert (found.mass, found.category, found.hinge) == (0.0, Category.STATIC_OBJECT, None)
    low, high = found.bounds()
    assert low == pytest.approx((-0.5, -2.0, -3.0))
    assert high == pytest.approx((1.5, 2.0, 3.0))


def test_what_moves_are_the_actors_and_what_can_be_pushed() -> None:
    moving = moving_entities(world())
    assert list(moving) == ["bob", "crate", "door"]
    crate, door, bob = moving["crate"], moving["door"], moving["bob"]
    assert (crate.mass, crate.category, crate.hinge, crate.floats) == (
        *(5.0, Category.DYNAMIC_OBJECT, None, False),
    )
    assert (door.mass, door.hinge, door.floats) == (2.0, DOOR, True)
    assert (bob.category, bob.description, bob.trajectory) == (Category.HUMAN, "an actor", WALK)
    assert bob == entity_of_actor(ACTOR)
    assert bob.start == Pose3.from_se2(SE2(3.0, 4.0, 0.5))
    assert world().model_names == ("crate", "door", "wall")
    assert is_ground("any", Part(Shape(Kind.PLANE)))
    assert not is_ground("any", Part(BOX))


def test_a_person_is_a_cylinder_that_stands_on_the_ground() -> None:
    low, high = bounds(person())
    assert (low[2], high[2]) == pytest.approx((0.0, PERSON[1]))
    assert high[:2] == pytest.approx((PERSON[0], PERSON[0]))


def test_a_robot_is_one_rigid_entity_of_all_its_parts() -> None:
    urdf = wheeled([(0.3, 0.2, 0.1), (0.3, -0.2, 0.1)], base=weight(4.0), wheel=weight(0.5))
    found = entity_of_robot(urdf)
    assert (found.name, found.mass, found.category) == ("r", 5.0, Category.ROBOT)
    assert found.description == "the robot of r.urdf"
    assert found.drawn == ()
    low, high = found.bounds()
    assert low == pytest.approx((0.2, -0.22, 0.0))
    assert high == pytest.approx((0.4, 0.22, 0.2))


def test_corners_are_those_of_its_box_where_it_stands() -> None:
    crate = Entity("crate", (Part(BOX),), mass=1.0)
    corners = crate.corners(AT)
    expected = {(1.0 + y, 2.0 + x, 3.0 + z) for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)}
    assert {tuple(np.round(corner, 9).tolist()) for corner in corners} == expected
    assert crate.lifted(AT) is AT  # it touches height 0
    sunk = Pose3((0.0, 0.0, 2.0))
    assert crate.lifted(sunk).position == pytest.approx((0.0, 0.0, 3.0))
    assert crate.body == "entity:crate"
    np.testing.assert_array_equal(bounds(()), np.zeros((2, 3)))
    assert Entity("sign", (), (Part(BOX),)).bounds()[1] == pytest.approx((1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("elapsed", "expected"),
    [
        (0.0, (0.0, 0.0, 0.0)),
        (1.0, (0.0, 0.0, 0.0)),  # it waits before each round
        (2.0, (1.0, 0.0, 0.0)),
        (3.0, (2.0, 0.0, 0.0)),
        (4.0, (2.0, 1.0, 0.5)),
        (4.999, (2.0, 1.999, 0.9995)),
        (5.0, (0.0, 0.0, 0.0)),  # it begins anew
        (7.0, (1.0, 0.0, 0.0)),
        (12.0, (1.0, 0.0, 0.0)),
    ],
)
def test_a_round_restarts_delayed(elapsed: float, expected: tuple[float, float, float]) -> None:
    assert WALK.pose(elapsed).array() == pytest.approx(expected)


def test_without_a_loop_it_stays_and_a_moment_is_no_round() -> None:
    once = Trajectory(WALK.times, WALK.poses, loop=False, delay=1.0)
    assert once.pose(0.5).array() == pytest.approx((0.0, 0.0, 0.0))
    assert once.pose(5.0).array() == pytest.approx((2.0, 2.0, 1.0))
    assert once.pose(99.0).array() == pytest.approx((2.0, 2.0, 1.0))
    assert once.velocity(2.0) == pytest.approx((1.0, 0.0, 0.0))
    assert once.velocity(4.0) == pytest.approx((0.0, 1.0, 0.5))
    assert once.velocity(99.0) == (0.0, 0.0, 0.0)
    still = Trajectory((0.0,), (SE2(1.0, 2.0, 3.0),))
    assert still.pose(7.0) == SE2(1.0, 2.0, 3.0)
    path = Trajectory.along(np.array([[0.0, 0.0], [3.0, 4.0]]), 2.0, loop=False)
    assert path.times == (0.0, 2.5)
    assert path.pose(9.0).array() == pytest.approx((3.0, 4.0, math.atan2(4.0, 3.0)))
    there_and_back = Trajectory.along(np.array([[0.0, 0.0], [3.0, 4.0]]), 2.0)
    assert there_and_back.times == (0.0, 2.5, 2.5, 5.0)
