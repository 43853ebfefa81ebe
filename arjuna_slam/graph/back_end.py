"""The back end: when the graph is optimised, how much of it at a time, and what is taken back.

No scan waits for the optimiser to end: a call does a bounded number of steps and the next call
resumes there, so that the same scans always give the same graph. Where a closure is far off, the
robust kernel begins so wide that it is believed, and tightens from one optimisation to the next.

Source: Yang et al., Graduated non-convexity for robust spatial perception, 2020.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import angle_param, length_param, param, share_param
from arjuna_core.se2 import SE2
from arjuna_slam.graph.optimizer import DAMPING, OptimizerStatus, optimize
from arjuna_slam.graph.pose_graph import Edge, PoseGraph

_LOOSE_MAX, _TIGHTER = 1e3, 4.0  # how wide the robust kernel begins, and how it tightens
_STEPS = 2  # in one call, so that no scan waits
_ONLINE_TOLERANCE, _FINAL_TOLERANCE = 1e-3, 1e-6  # relative gain of chi2 below which it ends


@dataclass(frozen=True)
class BackEndConfig:
    """Parameters of the back end."""

    loop_robust_scale: float = param(
        3.0, "Deviations at which a loop edge starts to be doubted.", minimum=0.1, maximum=1e6
    )
    optimize_every: int = param(
        20, "Keyframes between optimisations while loop edges agree.", minimum=1, maximum=10000
    )
    optimize_growth: float = param(
        0.04, "Share of all keyframes added to that.", minimum=0.0, maximum=10.0
    )
    optimize_urgent_distance: float = length_param(
        0.1, "Error in position of a loop edge that is optimised at once."
    )
    optimize_urgent_angle: float = angle_param(
        0.03, "Error in heading of a loop edge that is optimised at once."
    )
    loop_minimum_weight: float = share_param(0.01, "Weight below which a loop edge is taken back.")
    loop_trial_keyframes: int = param(
        40, "Keyframes in which others may support a loop edge.", minimum=0, maximum=1000000
    )


class BackEnd:
    """Keeps a pose graph optimised.

    Args:
        undone: Loop edges taken back from a graph that this one is what is left of.

    Attributes:
        running: Whether an optimisation runs.
        undone: Loop edges taken back because the rest of the graph disagreed.
    """

    def __init__(self, config: BackEndConfig, graph: PoseGraph, undone: int = 0) -> None:
        self._config = config
        self._graph = graph
        self._since = 0
        self._fresh = 0
        self.running = False
        self._looseness = 1.0
        self._damping = DAMPING
        self._poses: Floats | None = None
        self.undone = undone

    def add(self, edges: list[Edge]) -> None:
        """Add a keyframe's loop edges."""
        urgent = False
        for edge in edges:
            self._graph.add_edge(edge)
            error = self._graph.residual(edge)
            far = math.hypot(error[0], error[1]) > self._config.optimize_urgent_distance
            far |= abs(error[2]) > self._config.optimize_urgent_angle
            urgent |= far
            if not far:
                continue  # near the optimum the kernel is convex as it is
            deviations = math.sqrt(max(0.0, float(error @ edge.information @ error)))
            loose = deviations / self._config.loop_robust_scale
            self._looseness = min(max(self._looseness, loose), _LOOSE_MAX)
        self._fresh += len(edges)
        self._since += 1
        period = self._config.optimize_every + self._config.optimize_growth * len(self._graph)
        self.running |= urgent or (self._fresh > 0 and self._since >= period)

    def advance(self) -> None:
        """Do the next few steps of an optimisation that runs."""
        if not self.running:
            return
        self._since = self._fresh = 0
        self.running = not self._optimize(_STEPS, _ONLINE_TOLERANCE)

    def finish(self) -> None:
        """Optimise to the end."""
        self._since = self._fresh = 0
        self.running = False
        while not self._optimize(30, _FINAL_TOLERANCE):
            continue

    def _optimize(self, steps: int, tolerance: float) -> bool:
        """Return whether the optimisation is over; take back closures that disagree with it."""
        graph = self._graph
        result = optimize(
            self._moved(), graph.table, iterations=steps, tolerance=tolerance,
            robust_scale=self._config.loop_robust_scale * self._looseness, damping=self._damping,
        )  # fmt: skip
        self._poses, self._damping = result.poses, result.damping
        if result.status is OptimizerStatus.MAX_ITERATIONS and steps == _STEPS:
            return False
        self._damping = DAMPING
        if self._looseness > 1.0:
            self._looseness = max(1.0, self._looseness / _TIGHTER)
            return False
        graph.poses, self._poses = result.poses, None
        tried = graph.table.j < len(graph) - self._config.loop_trial_keyframes
        wrong = graph.table.loop & tried & (result.weights < self._config.loop_minimum_weight)
        if not wrong.any():
            return True
        self.undone += int(wrong.sum())
        graph.remove_edges(wrong)
        return False

    def _moved(self) -> Floats:
        """Return the poses of the running optimisation; newer nodes move with its last one.

        The graph moves once, when the optimisation is over: before, a pose may lie anywhere.
        """
        graph = self._graph
        if self._poses is None:
            return graph.poses
        last = len(self._poses) - 1
        change = SE2.from_array(self._poses[last]) @ graph.pose(last).inverse()
        newer = [(change @ graph.pose(k)).array() for k in range(last + 1, len(graph))]
        return np.concatenate((self._poses, np.array(newer).reshape(-1, 3)))
