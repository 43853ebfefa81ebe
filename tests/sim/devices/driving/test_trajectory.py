"""Trajectories of joints pass their points smoothly, and refuse those that cannot be followed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.devices.driving.trajectory import Trajectory, TrajectoryError

NONE = np.full((3, 1), np.nan)
TIMES = np.array([1.0, 2.0, 4.0])
POINTS = np.array([[1.0], [-1.0], [0.5]])
SPEEDS = np.array([[0.5], [0.2], [0.0]])
PUSHES = np.array([[0.3], [-0.4], [0.0]])


def made(speeds: NDArray[np.float64] = NONE, pushes: NDArray[np.float64] = NONE) -> Trajectory:
    return Trajectory(TIMES, POINTS, speeds, pushes)


@pytest.mark.parametrize(("speeds", "pushes"), [(NONE, NONE), (SPEEDS, NONE), (SPEEDS, PUSHES)])
def test_it_passes_its_points_with_their_velocities_and_accelerations(
    speeds: NDArray[np.float64], pushes: NDArray[np.float64]
) -> None:
    path, h = made(speeds, pushes).starting_at(np.zeros(1), np.zeros(1)), 1e-4
    for i, time in enumerate(TIMES):
        before, here, after = (float(path.at(time + step)[0]) for step in (-h, 0.0, h))
        assert here == pytest.approx(POINTS[i, 0])
        if time < TIMES[-1] and np.isfinite(speeds).all():
            assert (after - before) / (2 * h) == pytest.approx(speeds[i, 0], abs=1e-3)
        if time < TIMES[-1] and np.isfinite(pushes).all():
            assert (after - 2 * here + before) / h**2 == pytest.approx(pushes[i, 0], abs=0.05)
    assert path.at(0.0) == pytest.approx([0.0])
    assert path.at(-1.0) == pytest.approx([0.0])
    assert path.at(9.0) == pytest.approx([0.5])


def test_points_alone_are_joined_by_straight_lines() -> None:
    assert made().at(1.25) == pytest.approx([0.5])


@pytest.mark.parametrize(
    ("times", "points", "speeds", "problem"),
    [
        (TIMES[:0], POINTS[:0], NONE[:0], "no points"),
        (TIMES, POINTS * np.nan, NONE, "finite position"),
        (TIMES[::-1], POINTS, NONE, "must rise"),
        (-TIMES[::-1], POINTS, NONE, "must rise"),
        (TIMES, POINTS, SPEEDS + 0.1, "must be 0"),
    ],
)
def test_what_cannot_be_followed_is_refused(
    times: NDArray[np.float64],
    points: NDArray[np.float64],
    speeds: NDArray[np.float64],
    problem: str,
) -> None:
    with pytest.raises(TrajectoryError, match=problem):
        Trajectory(times, points, speeds, speeds * np.nan)
