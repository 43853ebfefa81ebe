"""A wheel that is steered turns about its pivot, to the left for a positive angle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_sim.devices.driving.steered import SteeredWheel

WHEEL = SteeredWheel(np.array([1.0, 0.5]), np.array([1.0, 0.0]), 0.1, 0, np.array([1.0, 0.3]))


@pytest.mark.parametrize(
    ("angle", "place", "direction"),
    [
        (0.0, (1.0, 0.5), (1.0, 0.0)),
        (math.pi / 2, (0.8, 0.3), (0.0, 1.0)),
        (-math.pi / 2, (1.2, 0.3), (0.0, -1.0)),
    ],
)
def test_a_wheel_turns_about_its_pivot(
    angle: float, place: tuple[float, float], direction: tuple[float, float]
) -> None:
    found = WHEEL.turned(angle)
    assert found[0] == pytest.approx(place)
    assert found[1] == pytest.approx(direction, abs=1e-12)
