"""Walkers: all that follows a trajectory, moved at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from arjuna_sim.model.actors import Trajectory


class Walkers:
    """Puts mocap bodies where their trajectories say, as `Trajectory.pose` does one by one.

    Args:
        bodies: Index of each one's mocap body.
        trajectories: How each moves.
    """

    def __init__(self, bodies: list[int], trajectories: list[Trajectory]) -> None:
        longest = max((len(each.times) for each in trajectories), default=0)
        self._bodies = np.array(bodies, np.int64)
        self._rows = np.arange(len(bodies))
        self._delay = np.array([each.delay for each in trajectories])
        self._round = np.array([_round(each) for each in trajectories])
        self._times = np.array([_filled(each.times, longest, np.inf) for each in trajectories])
        self._poses = np.array(
            [_filled([_row(pose) for pose in each.poses], longest) for each in trajectories]
        )

    def __len__(self) -> int:
        return len(self._bodies)

    def put(self, data: Any, elapsed: NDArray[np.float64]) -> None:
        """Put each where it is.

        Args:
            data: The `mujoco.MjData`, which is changed.
            elapsed: How long each has been on the way, `(N,) float64` [s].
        """
        now = np.fmod(elapsed, self._round) - self._delay
        after = (self._times <= now[:, None]).sum(axis=1)
        before = np.maximum(after - 1, 0)
        after = np.minimum(after, self._times.shape[1] - 1)
        start, end = self._times[self._rows, before], self._times[self._rows, after]
        length = np.where(np.isfinite(end - start) & (end > start), end - start, np.inf)
        ratio = np.maximum(now - start, 0.0) / length
        a, b = self._poses[self._rows, before], self._poses[self._rows, after]
        step = b - a
        step[:, 2] = np.arctan2(np.sin(step[:, 2]), np.cos(step[:, 2]))
        x, y, theta = (a + ratio[:, None] * step).T
        data.mocap_pos[self._bodies] = np.column_stack((x, y, np.zeros(len(x))))
        zero = np.zeros(len(x))
        data.mocap_quat[self._bodies] = np.column_stack(
            (np.cos(theta / 2), zero, zero, np.sin(theta / 2))
        )


def _round(trajectory: Trajectory) -> float:
    """Return after how long a trajectory starts anew, infinity for one that does not [s]."""
    whole = trajectory.delay + trajectory.times[-1]
    return whole if trajectory.loop and whole > 0.0 else np.inf


def _row(pose: SE2) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.theta


def _filled(values: Any, count: int, last: float | None = None) -> NDArray[np.float64]:
    """Return values and, up to a count of them, the last one or another again."""
    found = np.array(values, np.float64)
    rest = np.repeat(found[-1:] if last is None else [last], count - len(found), axis=0)
    return np.concatenate((found, rest))
