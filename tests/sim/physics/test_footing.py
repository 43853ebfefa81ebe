"""How hard a robot may pull away: by what it leans on, what it grips and what its motors give."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_sim.physics.wheels.footing import LEAST, Feet, Weight, steady_acceleration

G = 9.81
FOUR = np.array([[0.3, 0.2], [0.3, -0.2], [-0.3, 0.2], [-0.3, -0.2]])


def feet(
    places: np.ndarray = FOUR, friction: float = 1.0, driven: tuple[int, ...] = (0, 1, 2, 3)
) -> Feet:
    drives = np.isin(np.arange(len(places)), driven)
    return Feet(places, np.zeros(len(places)), np.full(len(places), friction), drives)


def weight(
    height: float = 0.1, x: float = 0.0, force: float = 1e6, spin: float = 0.0, rolling: float = 0.0
) -> Weight:
    return Weight(10.0, np.array([x, 0.0, height]), spin, force, rolling)


def test_it_pulls_with_most_of_what_its_wheels_grip() -> None:
    assert steady_acceleration(feet(friction=0.5), weight()) == pytest.approx(0.8 * 0.5 * G)
    front = feet(friction=0.5, driven=(0, 1))  # the others rub as they are dragged
    assert steady_acceleration(front, weight(x=0.1)) == pytest.approx(
        max(LEAST, 0.8 * 0.5 * G * (2.0 / 3.0 - 1.0 / 3.0))
    )


@pytest.mark.parametrize("rolling", [0.0, 6.0])
def test_it_pulls_with_most_of_what_its_motors_give(rolling: float) -> None:
    found = steady_acceleration(feet(), weight(force=20.0, rolling=rolling))
    assert found == pytest.approx(0.8 * 20.0 / (10.0 + rolling))


@pytest.mark.parametrize(("x", "spin"), [(0.0, 0.0), (0.1, 0.0), (-0.1, 0.0), (0.0, 3.0)])
def test_it_keeps_all_feet_on_the_ground(x: float, spin: float) -> None:
    height = 1.2
    near = 0.3 - abs(x)  # from the weight to the feet that lift first when it starts or brakes
    lifts = 10.0 * G * near / (10.0 * height + spin)
    assert steady_acceleration(feet(), weight(height, x, spin=spin)) == pytest.approx(lifts)


def test_what_cannot_be_asked_for_less_or_is_not_held_upright() -> None:
    assert steady_acceleration(feet(friction=0.01), weight()) == LEAST
    assert steady_acceleration(feet(driven=()), weight()) == np.inf
    balances = feet(np.array([[0.0, 0.2], [0.0, -0.2]]), driven=(0, 1))
    assert steady_acceleration(balances, weight()) == np.inf
    lifted = Feet(FOUR, np.array([0.0, 0.0, 0.0, 9.0]), np.ones(4), np.array([False] * 3 + [True]))
    assert steady_acceleration(lifted, weight()) == LEAST
