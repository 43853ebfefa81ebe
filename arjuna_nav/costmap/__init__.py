"""Costmaps: layers, inflation and the grid planners and controllers read."""

from arjuna_nav.costmap.config import CostmapConfig
from arjuna_nav.costmap.costmap import FREE, INSCRIBED, LETHAL, MAX_NON_OBSTACLE, UNKNOWN, Costmap
from arjuna_nav.costmap.layered import LayeredCostmap
from arjuna_nav.costmap.layers.observations import PlacedCloud, PlacedRange, PlacedScan
