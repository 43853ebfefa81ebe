"""FootprintCollisionChecker: the costs below an outline's edges, under the original's names."""

from __future__ import annotations

import itertools
import math

from geometry_msgs.msg import Point32, Polygon

from nav2_simple_commander.costmap_2d import PyCostmap2D
from nav2_simple_commander.line_iterator import LineIterator

NO_INFORMATION = 255
LETHAL_OBSTACLE = 254
INSCRIBED_INFLATED_OBSTACLE = 253
MAX_NON_OBSTACLE = 252
FREE_SPACE = 0


class FootprintCollisionChecker:
    """Returns costs of a costmap, `LETHAL_OBSTACLE` where there is one or the costmap ends."""

    def __init__(self) -> None:
        self.costmap_: PyCostmap2D | None = None

    def setCostmap(self, costmap: PyCostmap2D) -> None:
        """Take a costmap."""
        self.costmap_ = costmap

    def footprintCost(self, footprint: Polygon) -> float:
        """Return the greatest cost below the edges of an outline in the costmap's frame [m]."""
        cells = [self.worldToMapValidated(point.x, point.y) for point in footprint.points]
        worst = 0.0
        for (x0, y0), (x1, y1) in itertools.pairwise([*cells, cells[0]]):
            if x0 is None or y0 is None or x1 is None or y1 is None:
                return LETHAL_OBSTACLE
            worst = max(worst, float(self.lineCost(x0, x1, y0, y1)))
            if worst == LETHAL_OBSTACLE:
                break
        return worst

    def lineCost(self, x0: int, x1: int, y0: int, y1: int, step_size: float = 0.5) -> float:
        """Return the greatest cost of the cells along a line between two cells."""
        if (x0, y0) == (x1, y1):
            return float(self.pointCost(x0, y0))
        worst, line = 0.0, LineIterator(x0, y0, x1, y1, step_size)
        while line.isValid():
            cost = float(self.pointCost(int(line.getX()), int(line.getY())))
            if cost == LETHAL_OBSTACLE:
                return cost
            worst = max(worst, cost)
            line.advance()
        return worst

    def worldToMapValidated(self, wx: float, wy: float) -> tuple[int | None, int | None]:
        """Return the cell of a point [m], `(None, None)` where it is outside."""
        return self._known().worldToMapValidated(wx, wy)

    def pointCost(self, x: int, y: int) -> int:
        """Return the cost of a cell."""
        return int(self._known().getCostXY(x, y))

    def footprintCostAtPose(self, x: float, y: float, theta: float, footprint: Polygon) -> float:
        """Return the greatest cost below an outline's edges at a pose [m, rad]."""
        c, s = math.cos(theta), math.sin(theta)
        placed = [
            Point32(x=x + c * point.x - s * point.y, y=y + s * point.x + c * point.y)
            for point in footprint.points
        ]
        return self.footprintCost(Polygon(points=placed))

    def _known(self) -> PyCostmap2D:
        if self.costmap_ is None:
            raise ValueError("there is no costmap; setCostmap takes one")
        return self.costmap_
