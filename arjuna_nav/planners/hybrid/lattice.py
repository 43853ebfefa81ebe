"""Smac lattice: plans of a differential drive that also turns on the spot, its outline checked."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners.hybrid.config import SmacLatticeConfig
from arjuna_nav.planners.hybrid.moves import Moves
from arjuna_nav.planners.hybrid.planner import PoseSearch
from arjuna_nav.planners.hybrid.primitives import Lattice, generated, laid_out, read
from arjuna_nav.planners.hybrid.search import Rules, can_turn


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
        """Return the lattice in a costmap's cells."""
        resolution = costmap.frame.resolution
        if self._in_cells is None or self._in_cells[0] != resolution:
            cells = 1.0 / resolution
            radius = self._config.minimum_turning_radius * cells
            made = self._file.scaled(cells) if self._file else generated(max(radius, 1.0))
            self._in_cells = resolution, made
        return self._in_cells[1]

    def _moves(self, costmap: Costmap, first: NDArray[np.float64]) -> Moves:
        """Return the pieces that it drives, from its first pose [cells, rad].

        Where the robot cannot turn on the spot to the nearest of the lattice's headings, the
        lattice is turned to the robot's.
        """
        lattice, config = self._lattice(costmap), self._lattice_config
        factors = config.reverse_penalty, config.non_straight_penalty, config.change_penalty
        costs = (*factors, config.rotation_penalty)
        moves = laid_out(lattice, first[2], self._reverse, costs)
        turn = wrap(moves.angles[moves.start] - first[2])
        terrain = self._terrain(costmap, np.empty((0, 0), np.float32))
        if lattice.spins and can_turn(first, turn, terrain):
            return moves
        return moves.turned(-turn)

    def _rules(self, costmap: Costmap) -> Rules:
        """Return how the robot drives."""
        lattice = self._lattice(costmap)
        rules = super()._rules(costmap)
        return rules._replace(spins=lattice.spins, shortcuts=False, radius=lattice.radius)

    @property
    def _reverse(self) -> bool:
        return self._lattice_config.allow_reverse_expansion
