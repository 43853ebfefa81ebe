"""Smac lattice: plans of a differential drive that also turns on the spot, its outline checked."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_json
from arjuna_core.se2 import wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.hybrid.config import SmacLatticeConfig
from arjuna_nav.planners.hybrid.moves import STEP, Moves
from arjuna_nav.planners.hybrid.planner import PoseSearch
from arjuna_nav.planners.hybrid.search import Rules, can_turn

_DIRECTIONS = ((1, 0), (2, 1), (1, 1), (1, 2))  # and as many in each other quadrant
_FARTHEST = 100.0  # that a piece of a file may lead [m]
_LONGEST = 1000  # poses
_LEAST = math.sqrt(2.0)  # so that a piece leaves its cell [cells]
_MODELS = ("diff", "omni", "ackermann")


@dataclass(frozen=True, eq=False)
class Primitive:
    """A piece between two headings.

    Attributes:
        first: Number of the heading it starts from.
        last: Number of the heading it ends at.
        side: 1 where it bends left, -1 right, 0 where it does not.
        poses: `(N, 3) float64` from its start, which is left out; the heading is absolute.
    """

    first: int
    last: int
    side: int
    poses: Floats

    @property
    def length(self) -> float:
        """Length of its arc or straight; 0 for a turn on the spot."""
        steps = np.diff(self.poses[:, :2], axis=0, prepend=0.0)
        return float(np.hypot(*steps.T).sum())


@dataclass(frozen=True, eq=False)
class Lattice:
    """Headings and the pieces between them.

    Attributes:
        angles: `(H,) float64` [rad].
        primitives: The pieces; lengths in cells, or metres where they come from a file.
        spins: Whether the robot turns on the spot.
        radius: Of the tightest bend, in the pieces' unit.
    """

    angles: Floats
    primitives: tuple[Primitive, ...]
    spins: bool
    radius: float

    def scaled(self, factor: float) -> Lattice:
        """Return it in another unit of length."""
        by = np.array([factor, factor, 1.0])
        pieces = tuple(
            Primitive(one.first, one.last, one.side, one.poses * by) for one in self.primitives
        )
        return Lattice(self.angles, pieces, self.spins, self.radius * factor)


def generated(radius: float) -> Lattice:
    """Return the lattice of a differential drive whose bends are no tighter than a radius [cells].

    From each of 16 headings the shortest straight, the shortest bends to the next headings that end
    in a cell's middle, and turns on the spot to these.
    """
    quadrant = [np.array(one) for one in _DIRECTIONS]
    turned = np.array([[0, -1], [1, 0]])
    directions = [np.linalg.matrix_power(turned, k) @ one for k in range(4) for one in quadrant]
    angles = np.array([math.atan2(y, x) for x, y in directions])
    pieces = []
    for first, direction in enumerate(directions):
        count = math.ceil(_LEAST / float(np.hypot(*direction)))
        pieces.append(Primitive(first, first, 0, _straight(direction * count, angles[first])))
        for side in (1, -1):
            last = (first + side) % len(directions)
            turn = float(wrap(angles[last] - angles[first]))
            pieces.append(Primitive(first, last, side, _bend(angles[first], turn, radius)))
            # A turn is checked for collisions every 0.1 rad.
            steps = math.ceil(abs(turn) / 0.1)
            there = angles[first] + turn * np.arange(1, steps + 1) / steps
            pieces.append(Primitive(first, last, 0, np.pad(there[:, None], ((0, 0), (2, 0)))))
    return Lattice(angles, tuple(pieces), True, radius)


def _straight(end: Ints, angle: float) -> Floats:
    steps = math.ceil(float(np.hypot(*end)) / STEP)
    points = end * np.arange(1, steps + 1)[:, None] / steps
    return np.column_stack((points, np.full(steps, angle)))


def _bend(angle: float, turn: float, radius: float) -> Floats:
    """Return the shortest bend by a turn [rad] that ends in a cell's middle, with straight ends."""
    before = np.array([math.cos(angle), math.sin(angle)])
    after = np.array([math.cos(angle + turn), math.sin(angle + turn)])
    tangent = radius * math.tan(abs(turn) / 2.0)
    reach = math.ceil(4.0 * tangent) + 4  # where a bend always fits
    ends = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
    along = np.linalg.solve(np.column_stack((before, after)), ends)  # each direction
    fits = along.min(axis=0) >= tangent - 1e-9
    there, here = along[:, np.argmin(np.where(fits, along.sum(axis=0), np.inf))].tolist()
    tight = min(there, here)
    bent = tight / math.tan(abs(turn) / 2.0)
    parts = ((there - tight, 0.0), (bent * abs(turn), turn), (here - tight, 0.0))
    return _driven(angle, parts)


def _driven(angle: float, parts: tuple[tuple[float, float], ...]) -> Floats:
    """Return the poses along stretches, each a length and by how much it turns."""
    poses, at = [], np.array([0.0, 0.0, angle])
    for length, turn in parts:
        steps = math.ceil(length / STEP - 1e-9)
        for _ in range(steps):
            middle, by = at[2] + 0.5 * turn / steps, abs(turn) / steps
            chord = length / steps * (math.sin(by / 2.0) / (by / 2.0) if by else 1.0)
            at = at + np.array([chord * math.cos(middle), chord * math.sin(middle), turn / steps])
            poses.append(at)
    return np.array(poses)


def read(path: Path) -> Lattice:
    """Return the lattice of a file of Nav2's lattice_primitives, in metres.

    Raises:
        InputFileError: It cannot be read, or is no such file.
    """
    if not os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises where a name is too long
        own = "without lattice_filepath, pieces bend by minimum_turning_radius"
        own += ", and it turns on the spot (SmacPlannerHybrid plans for cars)"
        raise InputFileError(path, f"there is no such file of lattice primitives; {own}")
    try:
        content = read_json(path)
        about = content["lattice_metadata"]
        angles = np.array(about["heading_angles"], np.float64)
        pieces = tuple(_primitive(one, len(angles)) for one in content["primitives"])
        model, radius = str(about["motion_model"]), float(about["turning_radius"])
    except (ValueError, OverflowError, KeyError, TypeError, IndexError) as error:
        raise InputFileError(path, f"is no file of lattice primitives: {error!r}") from error
    if model not in _MODELS or not 0.0 < radius < _FARTHEST:
        valid = f"{', '.join(_MODELS)}; over 0, below {_FARTHEST:g} m"
        problem = f"motion_model '{model}' with turning_radius {radius:g} m; valid: {valid}"
        raise InputFileError(path, problem)
    return Lattice(angles, pieces, model != "ackermann", radius)


def _primitive(one: dict[str, Any], headings: int) -> Primitive:
    first, last = int(one["start_angle_index"]), int(one["end_angle_index"])
    if not (0 <= first < headings and 0 <= last < headings):
        raise ValueError(f"an angle index of {first} or {last} with {headings} headings")
    poses = np.array(one["poses"], np.float64).reshape(-1, 3)
    if not (np.abs(poses) < _FARTHEST).all() or len(poses) > _LONGEST:
        raise ValueError(f"a piece over {_FARTHEST:g} m or {_LONGEST} poses long")
    bends = float(one["trajectory_radius"]) > 0.0
    side = (1 if one["left_turn"] else -1) if bends else 0
    return Primitive(first, last, side, poses[1:] if len(poses) > 1 else poses)


def laid_out(
    lattice: Lattice, heading: float, reverse: bool, factors: tuple[float, float, float, float]
) -> Moves:
    """Return a lattice as a table for a search, from the heading nearest to one.

    Args:
        heading: Of the robot [rad].
        reverse: Whether the pieces are driven back, too.
        factors: On the cost of what is driven back, of bends, added to that where the side
            changes; and the cost of a turn on the spot [cells].
    """
    angles, pieces = lattice.angles, [(one, False) for one in lattice.primitives]
    if reverse:
        pieces += [(_backwards(one, angles), True) for one in lattice.primitives if one.length > 0]
    pieces.sort(key=lambda pair: pair[0].first)
    starts = np.array([one.first for one, _ in pieces])
    lengths = np.array([one.length for one, _ in pieces])
    driven = np.where([back for _, back in pieces], factors[0], 1.0) * lengths
    sides = np.array([one.side for one, _ in pieces])
    costs = driven * np.where(sides == 0, 1.0, factors[1])
    poses = [one.poses - np.array([0.0, 0.0, angles[one.first]]) for one, _ in pieces]
    for part in poses:
        part[:, 2] = wrap(part[:, 2])
    return Moves(
        angles,
        int(np.argmin(np.abs(wrap(angles - heading)))),
        np.searchsorted(starts, np.arange(len(angles) + 1)),
        np.array([one.last for one, _ in pieces]),
        sides,
        np.where(lengths > 0.0, costs, factors[3]),
        driven * factors[2],
        np.cumsum([0, *map(len, poses)]),
        np.vstack(poses),
    )


def _backwards(one: Primitive, angles: Floats) -> Primitive:
    """Return a piece driven with the robot's back ahead."""
    first, last = (
        int(np.argmin(np.abs(wrap(angles - angles[k] - math.pi)))) for k in (one.first, one.last)
    )
    return Primitive(first, last, -one.side, one.poses + np.array([0.0, 0.0, math.pi]))


class SmacLattice(PoseSearch):
    """Plans by hybrid A*'s search over the pieces of a lattice.

    Raises:
        InputFileError: `lattice_filepath` cannot be read.

    Source: nav2_smac_planner, SmacPlannerLattice.
    """

    Config: ClassVar[type[Any]] = SmacLatticeConfig

    def __init__(self, config: SmacLatticeConfig, footprint: Footprint) -> None:
        super().__init__(config, footprint)
        self._lattice_config = config
        self._file = read(Path(config.lattice_filepath)) if config.lattice_filepath else None
        self._in_cells: tuple[float, Lattice] | None = None

    def _lattice(self, costmap: Costmap) -> Lattice:
        resolution = costmap.frame.resolution
        if self._in_cells is None or self._in_cells[0] != resolution:
            cells = 1.0 / resolution
            radius = self._config.minimum_turning_radius * cells
            made = self._file.scaled(cells) if self._file else generated(max(radius, 1.0))
            self._in_cells = resolution, made
        return self._in_cells[1]

    def _moves(self, costmap: Costmap, first: Floats) -> Moves:
        """Return the pieces that it drives, from its first pose [cells, rad].

        Where the robot cannot turn on the spot to the nearest of the lattice's headings, the
        lattice is turned to the robot's.
        """
        lattice, config = self._lattice(costmap), self._lattice_config
        factors = config.reverse_penalty, config.non_straight_penalty, config.change_penalty
        costs = (*factors, config.rotation_penalty)
        moves = laid_out(lattice, first[2], self._reverse, costs)
        turn = wrap(moves.angles[moves.start] - first[2])
        if lattice.spins and can_turn(first, turn, self._terrain(costmap)):
            return moves
        return moves.turned(-turn)

    def _rules(self, costmap: Costmap) -> Rules:
        lattice = self._lattice(costmap)
        rules = super()._rules(costmap)
        return rules._replace(spins=lattice.spins, shortcuts=False, radius=lattice.radius)

    @property
    def _reverse(self) -> bool:
        return self._lattice_config.allow_reverse_expansion
