"""Accelerations that a robot's contacts, grip and motors allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arjuna_sim.physics.wheels.traction import (
    LEAST,
    GroundContacts,
    Weight,
    climbed_sill,
    lifting_sill,
    sill_notes,
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


def sill_at(x: float, up: float, back: float, rear: float, wheel: float) -> float:
    """Return the sill on which a front foot rests, with a rear one, its wheels in the air.

    Both feet stand off by their gaps; between them the robot is straight.
    """
    height = 1.0  # of the front foot; what a sill adds at the wheel is in proportion
    line = np.polyfit([back, x], [-rear, height - up], 1)
    slope = np.polyfit([back, x], [0.0, 1.0], 1)
    return height - float(np.polyval(line, wheel) / np.polyval(slope, wheel))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_wheels_lift_off_on_the_lowest_sill_of_any_two_contacts(seed: int, sign: float) -> None:
    rng = np.random.default_rng(seed)
    ahead, behind = rng.uniform(0.2, 0.6, 2), -rng.uniform(0.2, 0.6, 2)
    x = sign * np.array([*ahead, *behind, -0.02, 0.05])
    gaps = np.array([*rng.uniform(0.0, 2.0, 4), 0.0, 0.0])
    robot = GroundContacts(np.column_stack((x, 0 * x)), gaps, np.ones(6), np.arange(6) > 3)
    sag, wheels = 0.01, (-0.02 * sign, 0.05 * sign)
    sills = [
        sill_at(
            direction * front,
            sag * up,
            direction * back,
            sag * rear,
            min(direction * w for w in wheels),
        )
        for direction, fronts, backs in ((sign, (0, 1), (2, 3)), (-sign, (2, 3), (0, 1)))
        for front, up in ((x[i], gaps[i]) for i in fronts)
        for back, rear in ((x[i], gaps[i]) for i in backs)
    ]
    assert lifting_sill(robot, sag) == pytest.approx(min(sills))


def test_only_contacts_on_both_sides_lift_wheels_off() -> None:
    def lifted(*x: float) -> float:
        points = np.array([[each, 0.0] for each in (0.0, *x)])
        drives = np.arange(len(points)) == 0
        return lifting_sill(
            GroundContacts(points, np.zeros(len(points)), np.ones(len(points)), drives), 0.01
        )

    assert lifted(0.3, -0.3) == 0.0
    assert lifted(0.3) == lifted(-0.3) == lifted(0.3, 0.4) == np.inf
    assert lifted(0.3, -0.0009) == np.inf  # beside the wheel, not behind it
    assert lifted(0.3, -0.0011) == 0.0
    assert lifting_sill(resting(driven=()), 0.01) == np.inf


def test_one_axle_climbs_by_its_least_friction() -> None:
    axle = np.array([[0.0, 0.2], [0.0009, -0.2], [-0.3, 0.0]])
    grips = GroundContacts(
        axle, np.zeros(3), np.array([0.9, 0.75, 0.1]), np.array([True, True, False])
    )
    assert climbed_sill(grips, 0.1) == pytest.approx(0.1 * (1.0 - 0.8))  # 0.75: 3 by 4 by 5
    apart = replace(grips, positions=axle * np.array([2.0, 1.0]))
    assert climbed_sill(apart, 0.1) == np.inf
    assert climbed_sill(resting(driven=()), 0.1) == np.inf


def test_notes_say_what_is_less_than_any_robot_needs() -> None:
    assert traction_notes(LEAST + 1e-9) == ()
    (note,) = traction_notes(LEAST)
    assert note.startswith("hardly drives: ")
    assert sill_notes(0.03, 0.03, 0.1) == ()  # 0.3 radii
    (lifted,) = sill_notes(0.0299, np.inf, 0.1)
    assert "a sill of more than 30 mm lifts those off" in lifted
    assert "more than 0 mm" in sill_notes(-0.01, np.inf, 0.1)[0]
    (climbs,) = sill_notes(np.inf, 0.0123, 0.1)
    assert climbs.startswith("climbs sills of 12 mm: one axle drives it")
    assert len(sill_notes(0.0, 0.0, 0.1)) == 2
