"""Up, as an IMU feels it while the robot brakes, bumps, climbs and falls."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arjuna_nav.safety.posture import Posture

G = 9.81


def felt(posture: Posture, force: tuple[float, float, float], seconds: float, now: float) -> float:
    """Let a posture feel a force for a time from now on, at 50 Hz; return when it ends."""
    for i in range(round(50 * seconds)):
        posture.feel(np.array(force), now + 0.02 * (i + 1))
    return now + seconds


@pytest.mark.parametrize(
    ("force", "tilt"),
    [
        ((0.0, 0.0, G), 0.0),
        ((0.0, 0.0, -G), math.pi),
        ((G, 0.0, 0.0), math.pi / 2),
        ((0.0, -G * math.sin(0.5), G * math.cos(0.5)), 0.5),
    ],
)
def test_up_is_where_the_force_of_rest_points(
    force: tuple[float, float, float], tilt: float
) -> None:
    posture = Posture()
    now = felt(posture, force, 0.1, 0.0)
    assert posture.tilt(now) is None
    now = felt(posture, force, 1.0, now)
    assert posture.tilt(now) == pytest.approx(tilt)
    posture.take_as_upright()
    assert posture.tilt(now) == pytest.approx(0.0, abs=1e-6)


def test_bumps_and_braking_tilt_nothing_and_a_fall_is_felt_within_two_seconds() -> None:
    posture = Posture()
    assert posture.tilt(0.0) is None
    now = felt(posture, (0.0, 0.0, G), 2.0, 0.0)
    now = felt(posture, (-5.0, 0.0, G), 0.5, now)
    now = felt(posture, (80.0, 0.0, -20.0), 0.04, now)
    assert posture.tilt(now) < 0.6  # type: ignore[operator]
    now = felt(posture, (0.0, G, 0.0), 2.0, now)
    assert posture.tilt(now) > 1.2  # type: ignore[operator]
    now = felt(posture, (0.0, 0.0, G), 2.0, now)
    assert posture.tilt(now) < 0.3  # type: ignore[operator]


def test_an_imu_that_is_silent_or_feels_no_gravity_says_nothing() -> None:
    posture = Posture()
    now = felt(posture, (0.0, 0.0, -G), 1.0, 0.0)
    assert posture.tilt(now + 1.9) is not None
    assert posture.tilt(now + 2.1) is None
    felt(posture, (0.0, 0.0, 0.4), 5.0, now)
    assert posture.tilt(now + 5.0) is None
