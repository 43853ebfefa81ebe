"""Order of time, lag, silence and commands."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_sim.fusion.estimator import Control, Estimator
from arjuna_sim.fusion.filters import ExtendedFilter, Measurement, Noise
from arjuna_sim.fusion.kinematics import SIZE, Array


def _estimator(history: float = 0.0, now: bool = False) -> Estimator:
    return Estimator(
        ExtendedFilter, Noise(np.eye(SIZE) * 0.05), 0.1, history=history, predict_to_now=now
    )


def _speed(stamp: float, value: float) -> Measurement:
    values = np.zeros(SIZE)
    values[6] = value
    return Measurement(stamp, values, np.eye(SIZE) * 0.01, np.arange(SIZE) == 6)


def _run(estimator: Estimator, measured: list[Measurement], updates: list[float]) -> Array:
    arrivals = iter(measured)
    for now in updates:
        estimator.add(next(arrivals))
        estimator.update(now)
    return estimator.filter.state


def test_what_comes_late_counts_at_its_time_where_a_history_is_kept() -> None:
    ordered = [_speed(0.1 * k, 0.1 * k * k) for k in range(1, 7)]
    late = [*ordered[:2], *ordered[3:5], ordered[2], ordered[5]]
    at = [0.1, 0.2, 0.4, 0.5, 0.55, 0.6]
    expected = _run(_estimator(), ordered, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert _run(_estimator(1.0), late, at) == pytest.approx(expected, abs=1e-12)
    assert _run(_estimator(), late, at) != pytest.approx(expected, abs=1e-3)
    assert _run(_estimator(0.1), late, at) != pytest.approx(expected, abs=1e-3)


def test_measurements_wait_for_their_time_and_come_in_order() -> None:
    estimator = _estimator()
    for measured in (_speed(0.4, 1.0), _speed(0.2, 0.5)):
        estimator.add(measured)
    estimator.update(0.3)
    assert estimator.stamp == pytest.approx(0.2)
    assert estimator.filter.state[6] == pytest.approx(0.5)


@pytest.mark.parametrize(("now", "stamp"), [(False, 1.0), (True, 1.05)])
def test_in_silence_the_state_is_predicted_on(now: bool, stamp: float) -> None:
    estimator = _estimator(now=now)
    estimator.add(_speed(1.0, 2.0))
    estimator.update(1.0)
    estimator.update(1.05)
    assert estimator.stamp == pytest.approx(stamp)
    estimator.update(1.5)
    assert estimator.stamp == pytest.approx(1.5)
    assert estimator.filter.state[0] == pytest.approx(1.0)


def test_a_pose_is_set_at_rest_and_a_reset_forgets_it() -> None:
    estimator = _estimator()
    estimator.add(_speed(1.0, 2.0))
    estimator.update(1.0)
    estimator.set_pose(np.arange(6.0) / 10, np.eye(6) * 0.5, 2.0)
    assert estimator.filter.state == pytest.approx(np.array([*np.arange(6.0) / 10, *[0.0] * 9]))
    assert estimator.filter.covariance[0, 0] == 0.5
    assert estimator.filter.covariance[6, 6] == 1e-6
    estimator.reset()
    assert estimator.stamp is None
    assert not estimator.filter.state.any()


def test_a_command_accelerates_within_limits_until_it_is_old() -> None:
    limits, gains = np.array([[0.5] * 6, [0.2] * 6]), np.array([[1.0] * 6, [2.0] * 6])
    control = Control(np.arange(6) == 0, limits, gains, 0.3)
    standing, moving, command = np.zeros(6), np.full(6, 1.0), np.full(6, 1.3)
    assert control.accelerations(standing, command, 0.0)[0] == 0.5
    assert control.accelerations(moving, command, 0.0)[0] == pytest.approx(0.3)
    assert control.accelerations(moving, command, 0.3)[0] == -0.2
    assert np.isnan(control.accelerations(moving, command, 0.0)[1:]).all()
