"""The fit of a scan to the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.doctor.snapshot import ScanFacts


def scan_facts(
    scan: Scan, frame: str, upside_down: bool, grid: OccupancyGrid | None, T_map_sensor: SE2 | None
) -> ScanFacts:
    """Return the facts of a scan in the sensor's frame."""
    hits = scan.valid
    fit = None
    if grid is not None and T_map_sensor is not None and hits.any() and grid.occupied().any():
        seen = scan.mirrored() if upside_down else scan
        fit = share_on_walls(replace(seen, T_base_sensor=T_map_sensor).points(), grid)
    return ScanFacts(
        frame,
        float(hits.mean()) if len(hits) else 0.0,
        float((hits & (scan.ranges < 0.05)).mean()) if len(hits) else 0.0,
        upside_down,
        scan.angle_increment < 0.0,
        fit,
    )


def share_on_walls(points: NDArray[np.float64], grid: OccupancyGrid, near: float = 0.15) -> float:
    """Return the share of points `(N, 2) float64` that lie near a map's occupied cells [m]."""
    cells = grid.frame.to_cells(points)
    rows, columns = cells[grid.frame.inside(cells)].T
    distances = distance_transform_edt(~grid.occupied()) * grid.frame.resolution
    return float((distances[rows, columns] <= near).sum() / len(points))
