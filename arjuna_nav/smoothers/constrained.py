"""The smoother that bends a path as its robot can, and off of costs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

from arjuna_core.arrays import Floats, Ints
from arjuna_core.config import length_param, param
from arjuna_core.errors import ConfigError
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.relaxation import touches
from arjuna_nav.smoothers.smoothers import (
    SmoothResult,
    SmoothStatus,
    between_turns,
    problem_of,
)

_BEZIER = 0.4  # of a segment's length: where Nav2's curve between two poses has its control points


@dataclass(frozen=True)
class OptimizerConfig:
    """When the optimization ends, by Ceres' names."""

    max_iterations: int = param(100, "Most iterations.", minimum=1)
    param_tol: float = param(1e-15, "Relative change of the points at its end.", minimum=0.0)
    fn_tol: float = param(1e-7, "Relative change of the cost at its end.", minimum=0.0)
    gradient_tol: float = param(1e-10, "Slope of the cost at its end.", minimum=0.0)


@dataclass(frozen=True)
class ConstrainedSmootherConfig:
    """Parameters of the constrained smoother, by Nav2's names.

    Raises:
        ConfigError: The cost check points are no triples.
    """

    minimum_turning_radius: float = length_param(0.4, "Tightest bend that is free; 0 for any.")
    w_curve: float = param(30.0, "Weight of tighter bends.", minimum=0.0, maximum=1e12)
    w_cost: float = param(0.015, "Weight of the costmap's costs.", minimum=0.0, maximum=1e12)
    w_cost_cusp_multiplier: float = param(
        3.0, "By how much these weigh more where the direction changes.", minimum=0.0
    )
    cusp_zone_length: float = length_param(2.5, "Length about such a cusp in which they do.")
    w_dist: float = param(0.0, "Weight of the given path.", minimum=0.0, maximum=1e12)
    w_smooth: float = param(2e6, "Weight of smoothness.", minimum=0.0, maximum=1e12)
    cost_check_points: tuple[float, ...] = param(
        (), "Points of the robot whose costs count, x, y, weight each; empty for its middle."
    )
    path_downsampling_factor: int = param(1, "Every so many-th pose is moved.", minimum=1)
    path_upsampling_factor: int = param(
        1, "Poses of the result per pose given; 0 leaves those that were moved.", minimum=0
    )
    reversing_enabled: bool = param(True, "Whether poses say where a path is driven in reverse.")
    keep_goal_orientation: bool = param(True, "Whether the last heading stays.")
    keep_start_orientation: bool = param(True, "Whether the first heading stays.")
    optimizer: OptimizerConfig = field(default_factory=OptimizerConfig)

    def __post_init__(self) -> None:
        given = self.cost_check_points
        if len(given) % 3 or (given and sum(given[2::3]) <= 0.0):
            valid = "valid: x, y, weight of each, with weights above 0"
            raise ConfigError(f"'cost_check_points' is {list(given)}; {valid}")


class ConstrainedSmoother:
    """Moves all points but the ends' at once, for the least sum of weighted squares.

    They are of the points' second differences, of curvature beyond what the robot can turn, of
    distances from the given points and of costs.

    Source: nav2_constrained_smoother, as its weights are meant: each that of a square; Dolgov et
    al., Path planning for autonomous vehicles in unknown semi-structured environments, 2010.
    """

    Config: ClassVar[type[Any]] = ConstrainedSmootherConfig

    def __init__(self, config: ConstrainedSmootherConfig) -> None:
        self._config = config

    def smooth(self, path: Floats, costmap: Costmap) -> SmoothResult:
        if problem := problem_of(path):
            return SmoothResult(SmoothStatus.INVALID_PATH, path, problem)
        pieces, config, done = between_turns(path), self._config, []
        for i, piece in enumerate(pieces):
            start = config.keep_start_orientation or i > 0
            goal = config.keep_goal_orientation or i < len(pieces) - 1
            kept = replace(config, keep_start_orientation=start, keep_goal_orientation=goal)
            done.append(ConstrainedSmoother(kept)._smoothed(piece, costmap))
        smoothed, problem = np.vstack(done), ""
        if touches(smoothed[:, :2], costmap) and not touches(path[:, :2], costmap):
            problem = "touch an obstacle"
        elif len(paths.directions(smoothed)) > len(paths.directions(path)):
            problem = "drive it to and fro"
        if problem:
            message = f"smoothing would {problem}; the path is as it was before"
            return SmoothResult(SmoothStatus.FAILED_TO_SMOOTH_PATH, path, message)
        return SmoothResult(SmoothStatus.SUCCEEDED, smoothed)

    def _smoothed(self, path: Floats, costmap: Costmap) -> Floats:
        if len(path) < 3:
            return path
        directions = self._directions(path)
        moved, first, last = self._moved(directions)
        points = path[moved, :2]
        if first < last:
            points = _Problem(self._config, points, directions[moved], costmap).solved(first, last)
        return self._with_headings(path, moved, points, directions[moved])

    def _directions(self, path: Floats) -> Floats:
        """Return how the path is driven from each pose on: 1 ahead, -1 in reverse."""
        steps = np.diff(path[:, :2], axis=0)
        ahead = steps[:, 0] * np.cos(path[:-1, 2]) + steps[:, 1] * np.sin(path[:-1, 2])
        directions = np.where((ahead < 0.0) & self._config.reversing_enabled, -1.0, 1.0)
        if not self._config.keep_start_orientation:
            directions[0] = directions[1]
        return np.append(directions, directions[-1:])

    def _moved(self, directions: Floats) -> tuple[Ints, int, int]:
        """Return the poses that are optimized, and the first and the end of those that may move."""
        config, count = self._config, len(directions)
        start, goal = config.keep_start_orientation, config.keep_goal_orientation
        used = np.zeros(count, bool)
        used[:: config.path_downsampling_factor] = used[-1] = True
        used[1:-1] |= directions[1:-1] != directions[:-2]
        used[:2] |= start
        used[-2:] |= goal
        chosen = np.flatnonzero(used)
        return chosen, 1 + start, len(chosen) - 1 - goal

    def _with_headings(
        self, path: Floats, moved: Ints, points: Floats, directions: Floats
    ) -> Floats:
        """Return the poses of the result: those optimized, and what is between them."""
        config, steps = self._config, np.diff(points, axis=0)
        inner = steps[:-1] + steps[1:] * (directions[1:-1] * directions[:-2])[:, None]
        tangents = np.vstack((steps[:1], inner, steps[-1:]))
        tangents *= np.append(directions[:1], directions[:-1])[:, None]
        yaws = np.arctan2(tangents[:, 1], tangents[:, 0])
        yaws[0] = path[0, 2] if config.keep_start_orientation else yaws[0]
        yaws[-1] = path[-1, 2] if config.keep_goal_orientation else yaws[-1]
        counts = np.maximum(np.diff(moved) * config.path_upsampling_factor, 1)
        of = np.repeat(np.arange(len(steps)), counts)  # the segment of each pose
        at = ((np.arange(len(of)) - (np.cumsum(counts) - counts)[of] + 1) / counts[of])[:, None]
        arms = (np.hypot(*steps.T) * _BEZIER * directions[:-1])[:, None]
        heads = np.column_stack((np.cos(yaws), np.sin(yaws)))
        corners = points[:-1], points[:-1] + arms * heads[:-1], points[1:] - arms * heads[1:]
        (a, b, c), d, left = (corner[of] for corner in corners), points[1:][of], 1.0 - at
        between = left**3 * a + 3 * left**2 * at * b + 3 * left * at**2 * c + at**3 * d
        along = left**2 * (b - a) + 2 * left * at * (c - b) + at**2 * (d - c)
        x, y = (along * directions[of, None]).T
        headings = np.where(at[:, 0] == 1.0, yaws[1:][of], np.arctan2(y, x))
        return np.vstack(([*points[0], yaws[0]], np.column_stack((between, headings))))


class _Problem:
    """The least squares of one path: residuals of each inner point and both its neighbours."""

    def __init__(
        self,
        config: ConstrainedSmootherConfig,
        points: Floats,
        directions: Floats,
        costmap: Costmap,
    ) -> None:
        self._config, self._given, self._costmap = config, points, costmap
        lengths = np.hypot(*np.diff(points, axis=0).T)
        self._turn = directions[1:-1] * directions[:-2]  # -1 at a cusp
        self._ratio = (self._turn * lengths[:-1] / lengths[1:])[:, None]
        self._direction = directions[:-2, None]
        along, half = np.cumsum(lengths[:-1]), config.cusp_zone_length / 2.0
        gaps = np.abs(along[:, None] - along[self._turn < 0.0]).min(axis=1, initial=np.inf)
        nearness = np.maximum(1.0 - gaps / half, 0.0) if half else gaps == 0.0
        self._w_cost = config.w_cost * (1.0 + (config.w_cost_cusp_multiplier - 1.0) * nearness)
        checks = np.reshape(config.cost_check_points or (0.0, 0.0, 1.0), (-1, 3))
        self._checks = [(x, y, weight / checks[:, 2].sum()) for x, y, weight in checks.tolist()]

    def solved(self, first: int, last: int) -> Floats:
        """Return the points; those before `first` and from `last` on stay.

        Source: Levenberg and Marquardt on the banded normal equations.
        """
        limits, points, damping = self._config.optimizer, self._given, 1e-4
        bands, slope, cost = self._normal(points)
        free, cell = slice(2 * first, 2 * last), self._costmap.frame.resolution
        for _ in range(limits.max_iterations):
            if np.abs(slope[free]).max() <= limits.gradient_tol:
                break
            damped = bands[:, free].copy()
            damped[0] += damping * damped[0] + 1e-9
            try:
                step = solveh_banded(damped, -slope[free], lower=True, check_finite=False)
            except LinAlgError:  # it is not definite any more
                break
            other, longest = points.copy(), float(np.abs(step).max())
            other[first:last] += step.reshape(-1, 2)
            new = self._normal(other)
            gain = (cost - new[2]) / max(cost, 1e-12)
            # What moves no point by a tenth of a cell and gains little is the costs' coarseness.
            ends = longest <= limits.param_tol * np.abs(points).max() or abs(gain) <= limits.fn_tol
            ends |= longest <= 0.1 * cell and abs(gain) <= 1e-3
            if gain > 0.0:
                points, (bands, slope, cost) = other, new
            damping = max(damping / 5.0, 1e-9) if gain > 0.0 else damping * 5.0
            if ends or damping > 1e8:
                break
        return points

    def _normal(self, points: Floats) -> tuple[Floats, Floats, float]:
        """Return the normal matrix's lower bands `(6, 2 N)`, the slope `(2 N,)` and the cost."""
        residuals, jacobians = self._terms(points)
        blocks = np.matmul(jacobians.transpose(0, 2, 1), jacobians)
        slopes = np.einsum("nki,nk->ni", jacobians, residuals)
        count = len(points)
        bands, slope = np.zeros((6, 2 * count)), np.zeros(2 * count)
        for i in range(6):
            slope[i : i + 2 * (count - 2) : 2] += slopes[:, i]
            for j in range(i, 6):
                bands[j - i, i : i + 2 * (count - 2) : 2] += blocks[:, i, j]
        return bands, slope, float(np.square(residuals).sum())

    def _terms(self, points: Floats) -> tuple[Floats, Floats]:
        """Return residuals `(N - 2, K)` and derivatives by three points' x, y `(N - 2, K, 6)`."""
        config, turn = self._config, self._turn[:, None]
        before, at, after = points[:-2], points[1:-1], points[2:]
        a, b = at - before, after - at
        count, checks = len(at), len(self._checks)
        values = np.zeros((count, 5 + checks))
        # by the step to the point, by the step from it, and by the point itself where both stay
        by_a, by_b, by_at = (np.zeros((count, 5 + checks, 2)) for _ in range(3))
        weight, axes = math.sqrt(config.w_smooth), np.arange(2)
        values[:, :2] = weight * (self._ratio * b - a)
        by_a[:, axes, axes], by_b[:, axes, axes] = -weight, weight * self._ratio
        most, weight = 1.0 / max(config.minimum_turning_radius, 1e-9), math.sqrt(config.w_curve)
        curvature, d_a, d_b = _curvature(a, turn * b)
        values[:, 2] = weight * np.maximum(curvature - most, 0.0)
        over = weight * (curvature > most)[:, None]
        by_a[:, 2], by_b[:, 2] = over * d_a, over * turn * d_b
        weight = math.sqrt(config.w_dist)
        values[:, 3:5], by_at[:, 3 + axes, axes] = weight * (at - self._given[1:-1]), weight
        chord = a + turn * b  # along the tangent
        squares = np.maximum((chord**2).sum(axis=1, keepdims=True), 1e-12)
        head = self._direction * chord / np.sqrt(squares)
        for k, (x, y, share) in enumerate(self._checks, start=5):
            offset = x * head + y * _left(head)
            costs, slopes = costs_at(at + offset, self._costmap)
            weights = np.sqrt(self._w_cost * share)
            values[:, k], by_at[:, k] = weights * costs, weights[:, None] * slopes
            by_turn = (by_at[:, k] * _left(offset)).sum(axis=1, keepdims=True)
            by_a[:, k] = by_turn * _left(chord) / squares
            by_b[:, k] = turn * by_a[:, k]
        return values, np.concatenate((-by_a, by_a - by_b + by_at, by_b), axis=2)


def _left(vectors: Floats) -> Floats:
    """Return vectors `(N, 2)` turned by a quarter to the left."""
    return np.column_stack((-vectors[:, 1], vectors[:, 0]))


def _curvature(a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the curvature of the arc through two steps `(N, 2)`, and its slopes by either."""
    c = a + b
    aa, bb, cc = ((v**2).sum(axis=1, keepdims=True) + 1e-12 for v in (a, b, c))
    cross = (a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]) * 2.0
    product = np.sqrt(aa * bb * cc)
    curvature, sign = np.abs(cross) / product, np.sign(cross)
    d_a = sign * -2.0 * _left(b) / product - curvature * (a / aa + c / cc)
    d_b = sign * 2.0 * _left(a) / product - curvature * (b / bb + c / cc)
    return curvature[:, 0], d_a, d_b


def costs_at(points: Floats, costmap: Costmap) -> tuple[Floats, Floats]:
    """Return costs between cells' middles `(N,)` and their slopes `(N, 2)` [1/m]."""
    frame, (height, width) = costmap.frame, costmap.data.shape
    local = frame.origin.inverse().apply(points) / frame.resolution - 0.5
    local = np.clip(local, 0.0, np.array([width, height]) - 1.001)
    (x, y), (u, v) = np.floor(local).astype(np.int64).T, np.modf(local)[0].T
    corners = (costmap.data[y + i, x + k].astype(float) for i in (0, 1) for k in (0, 1))
    low, right, up, far = corners
    below, above = low + u * (right - low), up + u * (far - up)
    along = (right - low) * (1.0 - v) + (far - up) * v
    slopes = np.column_stack((along, above - below)) / frame.resolution
    c, s = math.cos(frame.origin.theta), math.sin(frame.origin.theta)
    return below + v * (above - below), slopes @ np.array([[c, s], [-s, c]])
