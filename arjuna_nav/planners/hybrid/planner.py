"""Plans that a robot with a turning circle can drive, its outline checked."""

from __future__ import annotations

import abc
import math
import sys
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats, Singles
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap.costmap import INSCRIBED, Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.base import PlanResult, PlanStatus
from arjuna_nav.planners.escape import lead_out
from arjuna_nav.planners.guide import Guide, guide
from arjuna_nav.planners.hybrid.config import HybridConfig, PoseSearchConfig
from arjuna_nav.planners.hybrid.moves import Moves, arcs
from arjuna_nav.planners.hybrid.search import Rules, Terrain, cost_at, search
from arjuna_nav.planners.hybrid.shortcuts import driven
from arjuna_nav.planners.nearby import Plan, coarser, finer, nearby_first
from arjuna_nav.planners.pose_table import PoseTable
from arjuna_nav.planners.query import Cell, Query, ask
from arjuna_nav.planners.relaxation import smoothed_poses
from arjuna_nav.planners.waves.potential import NEUTRAL, closed

_LEAD = 0.5  # longest stretch off what the outline touches [m]
_FINEST = 4  # cells of the search along one of the costmap, for bends tighter than that
_COSTS = np.arange(256)
_SQUARES = (
    np.where(_COSTS < INSCRIBED, _COSTS**2 / (INSCRIBED - 1), _COSTS).round().astype(np.uint8)
)
"""Costs by their square: that of the costliest open cell stays."""


class PoseSearch(abc.ABC):
    """Plans over poses: pieces that the robot can drive, and a direct curve to the goal."""

    checks_outline = True

    def __init__(self, config: PoseSearchConfig, footprint: Footprint) -> None:
        self._config = config
        self._footprint = footprint
        self._kept: dict[tuple[SE2, GridFrame, float | None], Guide] = {}

    def plan(self, costmap: Costmap, start: SE2, goal: SE2) -> PlanResult:
        """Plan between two poses in the costmap's frame.

        Where the goal is blocked, for the outline too, or cannot be reached, the path ends at the
        reachable pose nearest to it within `tolerance`, with the goal's heading. A start whose
        outline touches something is led off it first as the robot can drive, or where that is not
        possible and its centre lies within the inscribed radius of an obstacle, in a straight line
        from cell to cell.
        """
        config = self._config
        radius, reach = config.minimum_turning_radius, min(_LEAD, config.escape_radius)
        lead = lead_out(start, costmap, self._footprint, radius, reach)
        begin, grid, costs = SE2.from_array(lead[-1]), self._grid(costmap), self._costs()
        found = nearby_first(lambda part: self._plan(part, begin, goal), grid, costs, begin, goal)
        if found.status is not PlanStatus.SUCCEEDED:
            return found
        smooth = config.smooth_path
        path = smoothed_poses(found.path, costmap, config.smoother) if smooth else found.path
        return replace(found, path=np.vstack((lead[:-1], path)))

    def _plan(self, costmap: Costmap, start: SE2, goal: SE2) -> Plan:
        config = self._config
        asked = ask(config, costmap, start, goal)
        if isinstance(asked, PlanResult):
            return Plan(asked)
        escape, first = _first(asked)
        rules, moves = self._rules(costmap), self._moves(costmap, first)
        terrain = self._terrain(costmap)
        query = replace(asked, fits=lambda cell: self._fits(asked, cell, moves, terrain))
        heading, first[2] = first[2], moves.angles[moves.start]
        looked = 0
        # On large maps only the best estimate is considered first: slack 0.
        for slack in (0.0, None):
            seeds = query.out.seeds(NEUTRAL)[:1]
            found = self._guide(query, seeds, slack, rules.radius)
            if isinstance(found, PlanResult):
                return Plan(found)
            ends, coarse = self._ends(query, found.end, moves)
            terrain = terrain._replace(remaining=found.remaining / np.float32(NEUTRAL))
            remaining = rules._replace(limit=rules.limit - looked, coarse=coarse)
            nodes, row, curve, more = search(first, ends, terrain, remaining, moves)
            looked += more
            if row >= 0:
                searched, cells = driven(nodes, row, curve, terrain, remaining, moves)
                poses = np.vstack((escape, searched))
                poses[0, 2] = heading
                path_cost = NEUTRAL * cells if found.end == query.goal_cell else math.inf
                path, expanded = _in_frame(poses, costmap, goal), self._expansions(nodes, costmap)
                result = PlanResult(PlanStatus.SUCCEEDED, path, expansions=expanded)
                return Plan(result, path_cost)
            if found.whole:
                break
        if looked >= rules.limit:
            message = f"no path within max_iterations = {rules.limit} poses"
            return Plan(PlanResult.failed(PlanStatus.TIMEOUT, message))
        message = (
            f"no path from ({start.x:.2f}, {start.y:.2f}) to ({goal.x:.2f}, {goal.y:.2f}) that "
            f"bends by {config.minimum_turning_radius:g} m at the least; {looked} poses tried"
        )
        return Plan(PlanResult.failed(PlanStatus.NO_VALID_PATH, message))

    def _guide(
        self, query: Query, seeds: Floats, slack: float | None, radius: float
    ) -> Guide | PlanResult:
        """Return the costs left to the goal, those of an earlier plan to it where they are kept."""
        key, first = (query.goal, query.costmap.frame, slack), tuple(seeds[0, :2].astype(int))
        kept = self._kept.get(key)
        if kept is not None and np.isfinite(kept.remaining[first]):
            return kept
        found = guide(query, self._costs(), seeds, slack, radius, self._coarseness)
        if isinstance(found, Guide) and self._config.cache_obstacle_heuristic:
            if any(goal != query.goal for goal, _, _ in self._kept):
                self._kept.clear()
            self._kept[key] = found
        return found

    def _ends(self, query: Query, cell: Cell, moves: Moves) -> tuple[Floats, int]:
        """Return the goal's pose with each heading that will do, `(K, 3)`; how many come first."""
        count = len(moves.angles)
        headings = {
            "DEFAULT": np.zeros(1),
            "BIDIRECTIONAL": np.array([0.0, math.pi]),
            "ALL_DIRECTION": np.arange(count) * (2.0 * math.pi / count),
        }[self._config.goal_heading_mode]
        coarse = np.arange(len(headings)) % max(self._config.coarse_search_resolution, 1) == 0
        ends = np.tile(_end(query, cell), (len(headings), 1))
        ends[:, 2] += headings[np.argsort(~coarse, kind="stable")]
        return ends, int(coarse.sum())

    def _expansions(self, nodes: PoseTable, costmap: Costmap) -> Floats | None:
        """Return the poses that were expanded, in the costmap's frame, where they are shown."""
        if not self._config.debug_visualizations:
            return None
        return _in_metres(nodes.poses[nodes.done], costmap)

    @property
    def _coarseness(self) -> int:
        """Cells along each side of one by which the costs left are estimated."""
        return 1

    def _costs(self) -> Singles:
        """Return the cost of a cell of a straight by its value, `(256,) float32`."""
        share = np.arange(256) / (INSCRIBED - 1)
        costs = NEUTRAL * (self._straight + self._config.cost_penalty * share)
        return closed(costs, self._config.allow_unknown)

    def _fits(self, query: Query, cell: Cell, moves: Moves, terrain: Terrain) -> bool:
        ends, _ = self._ends(query, cell, moves)
        return any(cost_at(x, y, theta, terrain) < math.inf for x, y, theta in ends)

    def _terrain(self, costmap: Costmap) -> Terrain:
        """Return where the robot drives; the cost left to the end from each cell is to be added."""
        return Terrain(
            costmap.data,
            np.empty((0, 0), np.float32),
            self._footprint.points / costmap.frame.resolution,
            self._footprint.circular,
            costmap.circumscribed_cost,
            self._config.allow_unknown,
        )

    @property
    def _straight(self) -> float:
        """Cost of a cell of a straight where nothing is near."""
        return 1.0 - self._config.retrospective_penalty

    def _grid(self, costmap: Costmap) -> Costmap:
        """Return the costs on the grid that is searched."""
        return costmap

    @abc.abstractmethod
    def _moves(self, costmap: Costmap, first: Floats) -> Moves:
        """Return the pieces that it drives, from its first pose [cells, rad]."""

    @property
    @abc.abstractmethod
    def _reverse(self) -> bool:
        """True where the motion model includes driving backwards."""

    def _radius(self, costmap: Costmap) -> float:
        """Return the radius of the tightest bend [cells]."""
        return max(self._config.minimum_turning_radius / costmap.frame.resolution, 1.0)

    def _rules(self, costmap: Costmap) -> Rules:
        config, resolution = self._config, costmap.frame.resolution
        radius, override = self._radius(costmap), config.analytic_expansion_max_cost_override
        one = config.goal_heading_mode == "DEFAULT"  # else their least costs more than it saves
        return Rules(
            radius,
            self._reverse,
            config.cost_penalty,
            self._straight,
            config.non_straight_penalty,
            config.analytic_expansion_ratio,
            config.analytic_expansion_max_length / resolution,
            config.analytic_expansion_max_cost,
            config.max_iterations if config.max_iterations > 0 else sys.maxsize,
            config.heuristic_weight,
            spins=False,
            turn=0.0,
            back=1.0,
            shortcuts=True,
            bends_within=0.5 * config.lookup_table_size / resolution / radius if one else -1.0,
            any_cost_within=2.0 * math.pi * radius if override else 0.0,
            tolerance=config.tolerance_on_approach(resolution),
            near_limit=config.max_on_approach_iterations,
            interval=config.terminal_checking_interval,
        )


def _in_frame(poses: Floats, costmap: Costmap, goal: SE2) -> Floats:
    """Return poses of the grid in the costmap's frame; one at the goal is the goal exactly."""
    path = _in_metres(poses, costmap)
    if np.hypot(*(path[-1, :2] - (goal.x, goal.y))) < 1e-6:
        same = abs(wrap(path[-1, 2] - goal.theta)) < 1e-6
        path[-1] = goal.x, goal.y, goal.theta if same else path[-1, 2]
    return path


def _in_metres(poses: Floats, costmap: Costmap) -> Floats:
    """Return poses of the grid `(N, 3)` [cells, rad] in the costmap's frame."""
    frame = costmap.frame
    points = frame.origin.apply(poses[:, :2] * frame.resolution)
    yaw = poses[:, 2] + frame.origin.theta
    return np.column_stack((points, np.arctan2(np.sin(yaw), np.cos(yaw))))


def _end(query: Query, cell: Cell) -> Floats:
    """Return the pose to reach [cells, rad], the goal or the middle of the cell nearest to it."""
    pose = _in_grid(query.costmap, query.goal)
    if cell != query.goal_cell:
        pose[:2] = cell[1] + 0.5, cell[0] + 0.5
    return pose


def _in_grid(costmap: Costmap, pose: SE2) -> Floats:
    """Return a pose in the grid [cells, rad]."""
    placed, resolution = costmap.frame.origin.inverse() @ pose, costmap.frame.resolution
    return np.array([placed.x / resolution, placed.y / resolution, placed.theta])


def _first(query: Query) -> tuple[Floats, Floats]:
    """Return the poses out of an inscribed zone, and the first pose of the search."""
    start = _in_grid(query.costmap, query.start)
    cells = query.out.to((int(query.out.exits[0, 0]), int(query.out.exits[0, 1])))
    points = np.vstack((start[:2], cells[:, ::-1] + 0.5))
    poses: Floats = np.column_stack((points, np.full(len(points), start[2])))
    return poses[:-1], poses[-1]


class Hybrid(PoseSearch):
    """Plans by hybrid A* with Dubins' or Reeds and Shepp's curves.

    Source: Dolgov, Thrun, Montemerlo and Diebel, Path planning for autonomous vehicles in unknown
        semi-structured environments, IJRR 2010; nav2_smac_planner, SmacPlannerHybrid.
    """

    Config: ClassVar[type[Any]] = HybridConfig

    def __init__(self, config: HybridConfig, footprint: Footprint) -> None:
        super().__init__(config, footprint)
        self.turning_radius = config.minimum_turning_radius
        self._hybrid = config

    def _grid(self, costmap: Costmap) -> Costmap:
        """Return the costs in cells no larger than the tightest bend, or it could not be driven."""
        costmap = coarser(costmap, self._hybrid.coarseness)
        if self._hybrid.use_quadratic_cost_penalty:
            squared = int(_SQUARES[costmap.circumscribed_cost])
            costmap = replace(costmap, data=_SQUARES[costmap.data], circumscribed_cost=squared)
        radius = self._config.minimum_turning_radius / costmap.frame.resolution
        needed = math.ceil(1.0 / max(radius, 1.0 / _FINEST) - 1e-9)
        # The finer grid has at most 4096 x 4096 cells.
        return finer(costmap, min(needed, math.isqrt(4096 * 4096 // costmap.data.size)))

    def _moves(self, costmap: Costmap, first: Floats) -> Moves:
        config, radius = self._config, self._radius(costmap)
        factors = config.reverse_penalty, config.non_straight_penalty, config.change_penalty
        every = self._hybrid.allow_primitive_interpolation
        bins = self._hybrid.angle_quantization_bins
        moves: Moves = arcs(first[2], bins, radius, self._reverse, factors, every)
        return moves

    def _rules(self, costmap: Costmap) -> Rules:
        rules = super()._rules(costmap)
        if not self._hybrid.use_quadratic_cost_penalty:
            return rules
        return rules._replace(direct_cost=float(_SQUARES[int(rules.direct_cost)]))

    @property
    def _coarseness(self) -> int:
        return 2 if self._hybrid.downsample_obstacle_heuristic else 1

    @property
    def _reverse(self) -> bool:
        return self._hybrid.motion_model_for_search == "REEDS_SHEPP"
