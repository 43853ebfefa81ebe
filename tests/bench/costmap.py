"""Times of costmap updates: a scan on a large map, in a rolling window, and all of it again."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.costmap import LayeredCostmap, PlacedScan
from arjuna_nav.costmap.inflation import Inflation
from tests.helpers.nav.layers import costmap_config, see

_RESOLUTION = 0.05
_BEAMS = 720


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--edge", type=int, default=4000, help="of the global one (%(default)s)")
    parser.add_argument("--repeats", type=int, default=50, help="scans (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, float]:
    """Time the changes on the processor.

    Returns:
        Median times [ms]: `global_scan`, `local_scan` and `inflation` of 800 x 600 cells.
    """
    result = {
        "global_scan": _scans(_fixed(arguments.edge), arguments.repeats),
        "local_scan": _scans(_rolling(), arguments.repeats),
        "inflation": _inflation(arguments.repeats),
    }
    for name, value in result.items():
        print(f"{name:12}{value:9.3f} ms")
    return result


def walls(height: int, width: int, seed: int = 0) -> NDArray[np.bool_]:
    """Return rooms with furniture, as occupied cells."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros((height, width), np.bool_)
    for at in range(0, max(height, width), 120):
        occupied[at : at + 3, :] = occupied[:, at : at + 3] = True
    for at in range(60, max(height, width), 120):
        occupied[at : at + 24, :] = occupied[:, at : at + 24] = False
    for row, column in rng.integers(0, (height, width), (height * width // 4000, 2)):
        occupied[row : row + rng.integers(2, 12), column : column + rng.integers(2, 12)] = True
    return occupied


def _fixed(edge: int) -> LayeredCostmap:
    config = costmap_config(
        resolution=_RESOLUTION,
        track_unknown_space=True,
        robot_radius=0.25,
        inflation_layer={"inflation_radius": 0.6, "cost_scaling_factor": 5.0},
    )
    half = edge * _RESOLUTION / 2.0
    data = np.where(walls(edge, edge), 100, 0).astype(np.int8)
    layered = LayeredCostmap(config)
    frame = GridFrame(_RESOLUTION, edge, edge, SE2(-half, -half))
    layered.set_map(OccupancyGrid(frame, data))
    return layered


def _rolling() -> LayeredCostmap:
    return LayeredCostmap(
        costmap_config(
            rolling_window=True,
            resolution=_RESOLUTION,
            width=5,
            height=5,
            robot_radius=0.25,
            plugins=("obstacle_layer", "inflation_layer"),
            inflation_layer={"inflation_radius": 0.6, "cost_scaling_factor": 5.0},
        )
    )


def _scans(layered: LayeredCostmap, repeats: int) -> float:
    """Return the median time [ms] of an update by a scan that differs, from a moving pose."""
    rng = np.random.default_rng(1)
    smooth = 2.0 + np.sin(np.linspace(0.0, 8.0 * math.pi, _BEAMS))

    def update(k: int) -> None:
        ranges = smooth + rng.normal(0.0, 0.02, _BEAMS)
        pose = SE2(0.02 * k, 0.013 * k, 0.01 * k)
        scan = Scan(ranges, -math.pi, 2.0 * math.pi / _BEAMS, 0.1, 12.0, stamp=0.1 * k)
        see(layered, pose, 0.1 * k, [PlacedScan(scan, pose)])

    return _median(update, repeats)


def _inflation(repeats: int) -> float:
    data = np.where(walls(600, 800), 254, 0).astype(np.uint8)
    inflation = Inflation(0.6, 10.0, 0.28, _RESOLUTION)
    return _median(lambda k: inflation.apply(data.copy()), repeats)


def _median(call: Callable[[int], Any], repeats: int) -> float:
    spent = []
    for k in range(repeats + 1):
        before = time.process_time()
        call(k)
        spent.append(time.process_time() - before)
    return float(np.median(spent[1:])) * 1e3
