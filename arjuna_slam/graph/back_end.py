"""The back end: when the graph is optimised, how much of it at a time, and what is taken back.

No scan waits for the optimiser to end: a call does a bounded number of steps and the next call goes
on from there, so that the same scans always give the same graph.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from arjuna_core.config import param
from arjuna_slam.graph.optimizer import OptimizerStatus, optimize
from arjuna_slam.graph.pose_graph import Edge, PoseGraph

_URGENT_POSITION, _URGENT_HEADING = 0.1, 0.03  # a loop edge this far off is optimised at once
_STEPS = 2  # in one call
_ONLINE_TOLERANCE, _FINAL_TOLERANCE = 1e-3, 1e-6
_DISBELIEVED = 0.01  # robust weight below which a loop edge is taken back: 30 deviations off
_MATURE = 40  # keyframes that a loop edge gets for others to bear it out


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
        0.04, "Share of all keyframes added to that, so that the cost stays in proportion.",
        minimum=0.0, maximum=10.0,
    )  # fmt: skip


class BackEnd:
    """Keeps a pose graph optimised.

    Args:
        config: The parameters.
        graph: The graph.
        undone: Loop edges taken back from a graph that this one is what is left of.

    Attributes:
        undone: Loop edges taken back because the rest of the graph disagreed.
    """

    def __init__(self, config: BackEndConfig, graph: PoseGraph, undone: int = 0) -> None:
        self._config = config
        self._graph = graph
        self._since = 0
        self._fresh = 0
        self._running = False
        self.undone = undone

    def add(self, edges: list[Edge]) -> None:
        """Add a keyframe's loop edges."""
        for edge in edges:
            self._graph.add_edge(edge)
            error = self._graph.residual(edge)
            far = math.hypot(error[0], error[1]) > _URGENT_POSITION
            self._running |= far or abs(error[2]) > _URGENT_HEADING
        self._fresh += len(edges)
        self._since += 1
        period = self._config.optimize_every + self._config.optimize_growth * len(self._graph)
        self._running |= self._fresh > 0 and self._since >= period

    def advance(self) -> None:
        """Do the next few steps of an optimisation that runs."""
        if not self._running:
            return
        self._since = self._fresh = 0
        self._running = not self._optimize(_STEPS, _ONLINE_TOLERANCE)

    def finish(self) -> None:
        """Optimise to the end."""
        self._since = self._fresh = 0
        self._running = False
        while not self._optimize(30, _FINAL_TOLERANCE):
            continue

    def _optimize(self, steps: int, tolerance: float) -> bool:
        """Return whether the optimisation is over; take back closures that disagree with it."""
        graph = self._graph
        result = optimize(
            graph.poses, graph.table, robust_scale=self._config.loop_robust_scale,
            iterations=steps, tolerance=tolerance,
        )  # fmt: skip
        graph.poses = result.poses
        if result.status is OptimizerStatus.MAX_ITERATIONS and steps == _STEPS:
            return False
        mature = graph.table.j < len(graph) - _MATURE
        wrong = graph.table.loop & mature & (result.weights < _DISBELIEVED)
        if not wrong.any():
            return True
        self.undone += int(wrong.sum())
        graph.remove_edges(wrong)
        return False
