"""Correlative search: the best pose of a scan in a window, exact to a cell and an angle step.

Sources: Olson, Real-time correlative scan matching, 2009 (multi-resolution bounds); Hess et al.,
Real-time loop closure in 2D LIDAR SLAM, 2016, section V (branch and bound); penalties as Karto.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_core.se2 import SE2
from arjuna_slam.matching.branch_and_bound import descend, prepare
from arjuna_slam.matching.field import Field

_ANGLE_STEP_MIN = math.radians(0.25)
_WORK = 10000  # blocks of offsets looked at in a step of a search that waits between: some ms


@dataclass(frozen=True)
class Window:
    """Search window, and how much to trust the prior."""

    xy: float  # half the width of the window [m]
    theta: float  # half its angle [rad]
    depth: int  # levels of the pyramid
    distance_penalty: float = math.inf  # variance of the penalty on distance [m^2]; inf for none
    angle_penalty: float = math.inf  # variance of the penalty on angle [rad^2]; inf for none
    floor_xy: float = 0.5  # least the distance penalty may become
    floor_theta: float = 0.9  # least the angle penalty may become


def search(
    field: Field, points: Floats, prior: SE2, window: Window, least: float
) -> tuple[SE2, float] | None:
    """Return the pose of the greatest response and the response; None where none exceeds `least`.

    The response (0..1) is the mean likelihood of the points, in the robot's base frame, times the
    penalties; `prior` is the middle of the window.
    """
    whole = _Search(field, points, prior, window, least)
    all_work = 1 << 62  # blocks, more than any search has
    whole.go_on(all_work)
    return whole.found


def searching(
    field: Field,
    points: Floats,
    prior: SE2,
    window: Window,
    least: float,
    apart: tuple[Sequence[SE2], float] | None = None,
    work: int = _WORK,
) -> Generator[None, None, tuple[SE2, float] | None]:
    """Search as `search` does, in steps of a bounded time: `work` blocks of offsets each.

    With `apart`, poses and a distance in x or y from each [m], the question is whether there is any
    pose so far from all of them: the first one found is returned.
    """
    pieces = _Search(field, points, prior, window, least, apart)
    while not pieces.go_on(work):
        yield
    return pieces.found


class _Search:
    def __init__(
        self,
        field: Field,
        points: Floats,
        prior: SE2,
        window: Window,
        least: float,
        apart: tuple[Sequence[SE2], float] | None = None,
    ) -> None:
        self._prior, self._resolution = prior, field.resolution
        self._best, self._done = (-1, 0, 0, float(least)), 0
        self._task = None
        if len(points) == 0 or field.score.size == 0:
            return
        self._thetas = prior.theta + _turns(points, field.resolution, window.theta)
        self._tables = field.score, *field.pyramid(window.depth)
        xy = (np.array([prior.x, prior.y]) - field.origin) / field.resolution
        self._half = math.ceil(window.xy / field.resolution)
        self._penalty = np.array(
            [
                0.2 * field.resolution**2 / window.distance_penalty,
                0.2 / window.angle_penalty,
                window.floor_xy,
                window.floor_theta,
            ]
        )
        self._without = _left_out(apart, prior, field.resolution)
        self._task = prepare(
            self._tables, points / field.resolution, xy, self._thetas, self._half, self._penalty,
            least,
        )  # fmt: skip

    def go_on(self, work: int) -> bool:
        """Look at so many blocks of offsets more; return whether that was all."""
        if self._task is None:
            return True
        self._done, self._best = descend(
            self._tables, self._task, self._half, self._penalty, self._without,
            self._best, self._done, work,
        )  # fmt: skip
        return self._done == len(self._task[3])

    @property
    def found(self) -> tuple[SE2, float] | None:
        """The best pose so far and its response."""
        k, row, column, response = self._best
        if k < 0:
            return None
        x, y = (self._prior.x + column * self._resolution, self._prior.y + row * self._resolution)
        return SE2(x, y, float(self._thetas[k])), response


def _turns(points: Floats, resolution: float, theta: float) -> Floats:
    """Return turns up to theta in steps that move nine points of ten by a cell at most [rad]."""
    far = int(0.9 * (len(points) - 1))
    reach = float(np.partition(np.hypot(points[:, 0], points[:, 1]), far)[far])
    step = max(resolution / max(reach, resolution), _ANGLE_STEP_MIN)
    half_steps = math.ceil(theta / step)
    return step * np.arange(-half_steps, half_steps + 1, dtype=np.float64)


def _left_out(apart: tuple[Sequence[SE2], float] | None, prior: SE2, resolution: float) -> Ints:
    """Return first and last row and column of boxes of offsets left out, `(K, 4) int64`."""
    poses, far = apart or ((), 0.0)
    gaps = np.array([(pose.y - prior.y, pose.x - prior.x) for pose in poses]).reshape(-1, 2)
    boxes = np.round(gaps.repeat(2, axis=1) / resolution)
    boxes += round(far / resolution) * np.array([-1, 1, -1, 1])
    cells: Ints = boxes.astype(np.int64)
    return cells
