"""What a demo run saw: poses over time, contacts, goals; and the figures that follow."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import SE2
from bringup.demo.measures import rmse

_ROW = 7
_SAME = 1e-6  # times so close are one [s]


@dataclass
class RunLog:
    """Samples of truth and estimate, a row a tick.

    Attributes:
        rows: `time, true x, y, theta, estimated x, y, theta`; NaN where there is no estimate.
        judged: For each row whether the estimate counts as localization (after mapping and not
            between a kidnap and the recovery from it).
        stamps: For each row of when the estimate is [s]: as late as the robot's odometry comes.
        collisions: How often a contact with the world began.
        goals: `(x, y, yaw, reached)` in order.
    """

    rows: list[tuple[float, ...]] = field(default_factory=list)
    judged: list[bool] = field(default_factory=list)
    stamps: list[float] = field(default_factory=list)
    collisions: int = 0
    goals: list[tuple[float, float, float, bool]] = field(default_factory=list)
    _touching: bool = False

    def add(
        self,
        now: float,
        truth: SE2,
        estimate: SE2 | None,
        contacts: Any,
        judge: bool,
        stamp: float | None = None,
    ) -> None:
        """Add one tick's sample.

        Args:
            now: [s].
            truth: Where the robot is.
            estimate: Where it believes it was.
            contacts: The things it touches.
            judge: Whether the estimate counts.
            stamp: Of when the estimate is [s]; now if None.
        """
        self.stamps.append(now if stamp is None else stamp)
        guess = (np.nan,) * 3 if estimate is None else (estimate.x, estimate.y, estimate.theta)
        self.rows.append((now, truth.x, truth.y, truth.theta, *guess))
        self.judged.append(judge and estimate is not None)
        touching = len(contacts) > 0
        self.collisions += touching and not self._touching
        self._touching = touching

    @property
    def table(self) -> NDArray[np.float64]:
        """The rows as `(N, 7) float64`."""
        return np.array(self.rows, dtype=np.float64).reshape(-1, _ROW)

    def sha256(self) -> str:
        """Return a digest of every sample's bytes."""
        return hashlib.sha256(self.table.tobytes()).hexdigest()

    def path_length(self) -> float:
        """Return the length of the true path [m], leaps of a kidnap left out."""
        steps = np.linalg.norm(np.diff(self.table[:, 1:3], axis=0), axis=1)
        return float(steps[steps < 0.1].sum())

    def localization_rmse(self) -> tuple[float, float]:
        """Return the root mean square errors [m], [rad] of the judged samples.

        Each is compared with where the robot was at the estimate's stamp: odometry of 10 Hz is up
        to 0.1 s old, in which a robot turns by degrees.
        """
        table, judged = self.table, np.array(self.judged, dtype=bool)
        dated = np.searchsorted(table[:, 0], np.array(self.stamps)[judged] - _SAME)
        return rmse(table[judged, 4:7], table[np.minimum(dated, len(table) - 1), 1:4])
