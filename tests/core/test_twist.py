"""Claims: velocities measured within a duration have a mean; a time before begins another."""

from __future__ import annotations

import pytest

from arjuna_core.twist import STILL, RecentVelocities, Velocity


@pytest.mark.parametrize(("duration", "mean"), [(0.0, 0.4), (0.125, 0.3), (0.25, 0.2), (9.0, 0.15)])
def test_the_mean_is_of_what_was_measured_within_the_duration(duration: float, mean: float) -> None:
    recent = RecentVelocities(duration)
    assert recent.mean() == STILL
    for k, x in enumerate((0.0, 0.0, 0.2, 0.4)):
        recent.add(Velocity(x, y=-x, yaw_rate=2.0 * x), 0.125 * k)
    velocity = recent.mean()
    parts = velocity.x, velocity.y, velocity.yaw_rate
    assert parts == pytest.approx((mean, -mean, 2.0 * mean))


def test_a_time_before_is_another_run() -> None:
    recent = RecentVelocities(1.0)
    recent.add(Velocity(0.4), 5.0)
    recent.add(Velocity(0.1), 0.0)
    assert recent.mean() == Velocity(0.1)
