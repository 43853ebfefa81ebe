"""How far dead reckoning has come between two keyframes: what bounds a search for a loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_CLOSURES_MAX = 2000  # the newest that are looked at


class Drift:
    """The distance travelled at each keyframe, and the short cuts that closed loops are."""

    def __init__(self) -> None:
        self.travel: list[float] = []
        self._closures = np.empty((0, 2))

    def resume(self, travel: NDArray[np.float64]) -> None:
        """Take over the keyframes of another session, which ended where this one begins.

        Args:
            travel: Distance travelled when each was taken, `(N,) float64` [m].
        """
        self.travel = travel.tolist()
        self._closures = np.column_stack((np.full(len(travel), travel[-1]), travel))

    def close(self, node: int, past: int) -> None:
        """Note a loop edge between the newest keyframe and a past one."""
        entry = self.travel[node], self.travel[past]
        self._closures = np.vstack((self._closures[-_CLOSURES_MAX:], entry))

    def between(self, node: int, past: int) -> float:
        """Return the way from a past keyframe to a newer one, over one short cut at most [m]."""
        here, there = self.travel[node], self.travel[past]
        over = (here - self._closures[:, 0]) + np.abs(self._closures[:, 1] - there)
        return float(over.min(initial=here - there))
