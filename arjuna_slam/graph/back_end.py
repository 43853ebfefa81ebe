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

_STEPS = 2  # in one call, so that no scan waits
_ONLINE_TOLERANCE, _FINAL_TOLERANCE = 1e-3, 1e-6


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
    optimize_urgent_distance: float = param(
        0.1, "Error in position of a loop edge that is optimised at once.", unit="m", minimum=0.0
    )
    optimize_urgent_angle: float = param(
        0.03, "Error in heading of a loop edge that is optimised at once.", unit="rad", minimum=0.0
    )
    loop_minimum_weight: float = param(
        0.01,
        "Robust weight below which a loop edge is taken back: 30 deviations at the default scale.",
        minimum=0.0,
        maximum=1.0,
    )
    loop_trial_keyframes: int = param(
        40, "Keyframes in which others may bear a loop edge out.", minimum=0, maximum=1000000
    )


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
            far = math.hypot(error[0], error[1]) > self._config.optimize_urgent_distance
            self._running |= far or abs(error[2]) > self._config.optimize_urgent_angle
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
        tried = graph.table.j < len(graph) - self._config.loop_trial_keyframes
        wrong = graph.table.loop & tried & (result.weights < self._config.loop_minimum_weight)
        if not wrong.any():
            return True
        self.undone += int(wrong.sum())
        graph.remove_edges(wrong)
        return False
