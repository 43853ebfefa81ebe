"""FootprintCollisionChecker: costs below a robot's outline, under the original's names."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Any

from geometry_msgs.msg import Point32, Polygon

from nav2_simple_commander.costmap_2d import PyCostmap2D

NO_INFORMATION = 255
LETHAL_OBSTACLE = 254
INSCRIBED_INFLATED_OBSTACLE = 253
MAX_NON_OBSTACLE = 252
FREE_SPACE = 0


class FootprintCollisionChecker:
    """Reads the greatest cost along a footprint's edges; `setCostmap` comes first."""

    def __init__(self) -> None:
        self.costmap_: PyCostmap2D | None = None

    def setCostmap(self, costmap: PyCostmap2D) -> None:
        self.costmap_ = costmap

    def _costmap(self) -> PyCostmap2D:
        if self.costmap_ is None:
            hint = "use setCostmap to specify the costmap first"
            raise ValueError(f"Costmap not specified, {hint}")
        return self.costmap_

    def footprintCostAtPose(self, x: float, y: float, theta: float, footprint: Polygon) -> float:
        """Return the cost of a footprint [m] that is moved to a pose [m, rad]."""
        c, s = math.cos(theta), math.sin(theta)
        moved = [
            Point32(x=x + c * point.x - s * point.y, y=y + s * point.x + c * point.y)
            for point in footprint.points
        ]
        return self.footprintCost(Polygon(points=moved))

    def footprintCost(self, footprint: Polygon) -> float:
        """Return the greatest cost along the edges; that of an obstacle where one is outside."""
        cells = [self.worldToMapValidated(point.x, point.y) for point in footprint.points]
        if (None, None) in cells:
            return LETHAL_OBSTACLE
        edges: Any = pairwise([*cells, cells[0]])
        return _worst(self.lineCost(x0, x1, y0, y1) for (x0, y0), (x1, y1) in edges)

    def lineCost(self, x0: int, x1: int, y0: int, y1: int, step_size: float = 0.5) -> float:
        """Return the greatest cost along a line of cells, that of an obstacle before all.

        In difference to the original no cell of a steep line is left out.
        """
        count = max(math.ceil(max(abs(x1 - x0), abs(y1 - y0)) / step_size), 1)
        shares = (k / count for k in range(count + 1))
        cells = ((x0 + share * (x1 - x0), y0 + share * (y1 - y0)) for share in shares)
        return _worst(self.pointCost(int(round(x, 5)), int(round(y, 5))) for x, y in cells)

    def worldToMap(self, wx: float, wy: float) -> tuple[int, int]:
        return self._costmap().worldToMap(wx, wy)

    def worldToMapValidated(self, wx: float, wy: float) -> tuple[int, int] | tuple[None, None]:
        return self._costmap().worldToMapValidated(wx, wy)

    def pointCost(self, x: int, y: int) -> float:
        return float(self._costmap().getCostXY(x, y))


def _worst(costs: Iterable[float]) -> float:
    return max(costs, key=lambda cost: (cost == LETHAL_OBSTACLE, cost))
