"""Accelerations that a robot's contacts, grip and motors allow."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from arjuna_sim.physics.wheels.traction import (
    LEAST,
    GroundContacts,
    Weight,
    carrier,
    steady_acceleration,
    traction_notes,
)

G = 9.81
FOUR = np.array([[0.3, 0.2], [0.3, -0.2], [-0.3, 0.2], [-0.3, -0.2]])


def resting(
    points: np.ndarray = FOUR, friction: float = 1.0, driven: tuple[int, ...] = (0, 1, 2, 3)
) -> GroundContacts:
    drives = np.isin(np.arange(len(points)), driven)
    return GroundContacts(points, np.zeros(len(points)), np.full(len(points), friction), drives)


def weight(
    height: float = 0.1, x: float = 0.0, force: float = 1e6, spin: float = 0.0, rolling: float = 0.0
) -> Weight:
    return Weight(10.0, np.array([x, 0.0, height]), spin, force, rolling)


def test_it_pulls_with_most_of_what_its_wheels_grip() -> None:
    assert steady_acceleration(resting(friction=0.5), weight()) == pytest.approx(0.8 * 0.5 * G)
    front = resting(friction=0.5, driven=(0, 1))  # the others rub as they are dragged
    assert steady_acceleration(front, weight(x=0.1)) == pytest.approx(
        max(LEAST, 0.8 * 0.5 * G * (2.0 / 3.0 - 1.0 / 3.0))
    )


@pytest.mark.parametrize("rolling", [0.0, 6.0])
def test_it_pulls_with_most_of_what_its_motors_give(rolling: float) -> None:
    found = steady_acceleration(resting(), weight(force=20.0, rolling=rolling))
    assert found == pytest.approx(0.8 * 20.0 / (10.0 + rolling))


@pytest.mark.parametrize(("x", "spin"), [(0.0, 0.0), (0.1, 0.0), (-0.1, 0.0), (0.0, 3.0)])
def test_it_keeps_all_contacts_on_the_ground(x: float, spin: float) -> None:
    height = 1.2
    near = 0.3 - abs(x)  # from the weight to the feet that lift first when it starts or brakes
    lifts = 10.0 * G * near / (10.0 * height + spin)
    assert steady_acceleration(resting(), weight(height, x, spin=spin)) == pytest.approx(lifts)


def test_what_cannot_be_asked_for_less_or_is_not_held_upright() -> None:
    assert steady_acceleration(resting(friction=0.01), weight()) == LEAST
    assert steady_acceleration(resting(driven=()), weight()) == np.inf
    balances = resting(np.array([[0.0, 0.2], [0.0, -0.2]]), driven=(0, 1))
    assert steady_acceleration(balances, weight()) == np.inf
    lifted = GroundContacts(
        FOUR, np.array([0.0, 0.0, 0.0, 9.0]), np.ones(4), np.array([False] * 3 + [True])
    )
    assert steady_acceleration(lifted, weight()) == LEAST


def test_notes_say_what_is_less_than_any_robot_needs() -> None:
    assert traction_notes(LEAST + 1e-9, "") == traction_notes(LEAST + 1e-9, "base") == ()
    (note,) = traction_notes(LEAST, "")
    assert note.startswith("hardly drives: its wheels grip, or its motors pull, little more")
    (note,) = traction_notes(LEAST, "base")
    assert note.endswith("its driven wheels carry next to nothing, it stands on 'base'")


@pytest.mark.parametrize(("low", "driven", "found"), [(0, 4, -1), (-9, 4, 4), (-9, 0, -1)])
def test_what_a_robot_stands_on_in_place_of_its_wheels(low: int, driven: int, found: int) -> None:
    """The last of its contacts is its belly, in the middle."""
    points = np.vstack((FOUR, [(0.0, 0.0)]))
    four = resting(points, driven=tuple(range(driven)))
    belly = dataclasses.replace(four, gaps=np.array([0.0, 0.0, 0.0, 0.0, low]))
    assert carrier(belly, weight()) == found
    assert carrier(belly, weight(x=0.02)) == found
