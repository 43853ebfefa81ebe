"""The choice of DWB: every trajectory with each critic's score, as Nav2's DWB publishes it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from arjuna_core.arrays import Floats, Singles
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2
from arjuna_nav.controllers.display import Cloud, Critic, Evaluation, Judged, Plan, Shape, Shapes
from arjuna_nav.controllers.dwb.config import DwbConfig
from arjuna_nav.controllers.dwb.distances import UNREACHED
from arjuna_nav.controllers.dwb.trajectories import Scoring, raw_scores, trajectory
from arjuna_nav.costmap.costmap import Costmap

_PARTS = {
    "BaseObstacle": ("obstacle", 0),
    "ObstacleFootprint": ("outline", 1),
    "PathDist": ("path_dist", 2),
    "GoalDist": ("goal_dist", 3),
    "PathAlign": ("path_align", 4),
    "GoalAlign": ("goal_align", 5),
    "RotateToGoal": ("heading", 6),
}
"""Of each critic that judges a trajectory, its field of `Weights` and place in `raw_scores`."""


class Trials(NamedTuple):
    """The velocities that are tried, and where they lead, seen in the costmap's frame.

    Attributes:
        velocities: `(N, 3) float64`: forward, to the left [m/s], turning [rad/s].
        trajectory: Returns the poses `(K, 3)` [m, m, rad] that a velocity of an index leads to.
        path: The part of the path that counts, `(M, 3) float64`.
    """

    velocities: Floats
    trajectory: Callable[[int], Floats]
    pose: SE2
    path: Floats
    costmap: Costmap


class DwbCritic(Protocol):
    """A critic of one's own; made of `(config)`, which has a `scale`, its weight."""

    def scores(self, trials: Trials) -> Floats:
        """Return a score of each velocity, `(N,) float64`: less is better, inf forbids it."""
        ...


def simulated(scoring: Scoring, frame: GridFrame) -> Callable[[int], Floats]:
    """Return a function of the poses `(K, 3)` that the sample of an index leads to."""

    def poses(index: int) -> Floats:
        return _placed(trajectory(scoring, index)[0], frame)

    return poses


class Evaluated:
    """The samples of one command and how they were scored; it works when it is asked.

    Args:
        velocity_scores: The scores that depend on the velocity alone, by critic.
        best: Index of the sample that was chosen, -1 for none.

    Source: nav2 dwb_core, DWBLocalPlanner::coreScoringAlgorithm and DWBPublisher.
    """

    def __init__(
        self, config: DwbConfig, scoring: Scoring, velocity_scores: Mapping[str, Floats], best: int
    ) -> None:
        self._config, self._scoring, self._best = config, scoring, best
        self._velocity_scores = velocity_scores
        uses_base = "BaseObstacle" in config.critics
        self._obstacle = "BaseObstacle" if uses_base else "ObstacleFootprint"

    def first_velocity(self) -> Floats:
        """Return the velocity after the best trajectory's first step, `(3,)`."""
        return self._driven(self._best)[0][1, 3:]

    def details(self) -> str:
        """Return which critics forbid how much, as words."""
        judged = self._judged
        by = Counter(one.scores[-1].name for one in judged if one.total < 0.0)
        shares = (f"{100.0 * n / len(judged):.0f} % by {name}" for name, n in by.most_common())
        return f"; forbidden {', '.join(shares)}" if by else ""

    def shown(self, wanted: frozenset[str], near: Floats, frame: GridFrame) -> dict[str, Any]:
        """Return what is wanted and published, by topic; `near` is the part of the path."""
        config = self._config
        makers: dict[str, tuple[bool, Callable[[], Any]]] = {
            "evaluation": (config.publish_evaluation, lambda: self._evaluation(frame)),
            "marker": (config.publish_trajectories, lambda: self._shapes(frame)),
            "cost_cloud": (config.publish_cost_grid_pc, lambda: self._cloud(frame)),
            "transformed_global_plan": (config.publish_transformed_plan, lambda: Plan(near)),
            "local_plan": (config.publish_local_plan, lambda: self._local_plan(frame)),
        }
        return {topic: make() for topic, (on, make) in makers.items() if on and topic in wanted}

    def _driven(self, index: int) -> tuple[Floats, float]:
        """Return a trajectory's states and the time between two; see `trajectory`."""
        states, dt = trajectory(self._scoring, index)
        if self._config.include_last_point:
            states = states[[*range(len(states)), -1]]
        return states, dt

    def _local_plan(self, frame: GridFrame) -> Plan:
        if self._best < 0:
            return Plan(np.empty((0, 3)))
        return Plan(_placed(self._driven(self._best)[0], frame))

    @cached_property
    def _judged(self) -> tuple[Judged, ...]:
        """The trajectories in the grid, in cells."""
        judged: list[Judged] = []
        least = np.inf
        for index, sample in enumerate(self._scoring.samples):
            states, dt = self._driven(index)
            scores, total = self._scores(index, least)
            least = total if 0.0 <= total < least else least
            velocity = (float(sample[0]), float(sample[1]), float(sample[2]))
            if self._config.limit_vel_cmd_in_traj:
                velocity = (float(states[1, 3]), float(states[1, 4]), float(states[1, 5]))
            times = dt * np.arange(len(states) - 1, dtype=np.float64)
            judged.append(Judged(velocity, states[:, :3], times, scores, total))
        return tuple(judged)

    def _scores(self, index: int, least: float) -> tuple[tuple[Critic, ...], float]:
        """Return each critic's score of a trajectory and their sum, -1 where one forbids it."""
        scores, total, parts = list[Critic](), 0.0, raw_scores(self._scoring, index)
        for name in self._config.critics:
            scale, raw = getattr(self._config, name).scale, 0.0
            if name in self._velocity_scores:
                raw += float(self._velocity_scores[name][index])
            if name in _PARTS:
                weight, column = _PARTS[name]
                raw += float(parts[column])
                scale = getattr(self._scoring.weights, weight) if name != "RotateToGoal" else scale
            if raw == np.inf:
                return (Critic(name, -1.0, 0.0),), -1.0
            scores.append(Critic(name, raw, scale))
            total += scale * raw
            if self._config.short_circuit_trajectory_evaluation and total > least:
                return tuple(scores), total
        if parts[0] == np.inf:  # what collides is forbidden, whatever the critics
            return (Critic(self._obstacle, -1.0, 0.0),), -1.0
        return tuple(scores), total

    @property
    def _worst(self) -> int:
        return max(range(len(self._judged)), key=lambda i: self._judged[i].total, default=0)

    def _evaluation(self, frame: GridFrame) -> Evaluation:
        placed = tuple(
            Judged(one.velocity, _placed(one.poses, frame), one.times, one.scores, one.total)
            for one in self._judged
        )
        return Evaluation(placed, max(self._best, 0), self._worst)

    def _shapes(self, frame: GridFrame) -> Shapes:
        """Return the trajectories as lines, from green for the best to red, forbidden ones blue."""
        judged = self._judged
        totals = [one.total for one in judged if one.total >= 0.0] or [0.0]
        low, span = min(totals), max(totals) - min(totals)
        shapes = []
        for one in judged:
            level = (one.total - low) / (span if span > 1e-9 else 1.0)
            valid = one.total >= 0.0
            colour = np.array([level, 1.0 - level, 0.0] if valid else [0.0, 0.0, 1.0])
            name = "ValidTrajectories" if valid else "InvalidTrajectories"
            points = _placed(one.poses, frame)[:, :2]
            shapes.append(Shape(name, points, colour, 0.002, True, self._config.marker_lifetime))
        return Shapes(shapes)

    def _cloud(self, frame: GridFrame) -> Cloud:
        """Return the cells' scores by each critic that has a grid of them, and their sum."""
        of = self._scoring
        rows, columns = np.indices(frame.shape)
        middles = np.column_stack((columns.ravel() + 0.5, rows.ravel() + 0.5)).astype(np.float64)
        channels: dict[str, Singles] = {}
        total = np.zeros(of.data.size, np.float32)
        for name in self._config.critics:
            if name not in _PARTS or name == "RotateToGoal":
                continue
            grid: NDArray[Any] = of.to_path if name.startswith("Path") else of.to_goal
            grid = of.data if "Obstacle" in name else grid
            values = np.where(grid == UNREACHED, grid.size + 1, grid).astype(np.float32).ravel()
            channels[name] = values
            total += np.float32(getattr(of.weights, _PARTS[name][0])) * values
        points = frame.origin.apply(middles * frame.resolution)
        return Cloud(points, {**channels, "total_cost": total})


def _placed(cells: Floats, frame: GridFrame) -> Floats:
    """Return poses in the grid [cells, cells, rad] as poses of its frame `(N, 3)`."""
    points = frame.origin.apply(cells[:, :2] * frame.resolution)
    return np.column_stack((points, cells[:, 2] + frame.origin.theta))
