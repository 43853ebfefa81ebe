"""Memory of AMCL over a long drive: whether it grows."""

from __future__ import annotations

import argparse
import gc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Status
from arjuna_slam.amcl.filter import ParticleFilter
from tests.helpers.tours import Step, TourWorld

_TOUR = 120.0
_PERIOD = 0.1
_EACH = 300.0  # from one reading of the memory to the next [s]
_WARM = 2  # readings until everything has been used once
_PAGE = 4096


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--hours", type=float, default=2.0, help="of simulated time (%(default)s)")
    parser.add_argument("--world", default="office", help="name of a world (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Replay a simulated tour over and over; each time the robot is carried back to its start.

    Returns:
        `hours`, `first_mb` and `last_mb` of resident memory, `slope_mb_per_h` of a line through
        all readings, and `kidnaps` with how many the filter had recovered from by the tour's end.
    """
    world = TourWorld(arguments.world)
    tour = world.drive(0, _TOUR)
    belief = ParticleFilter(AmclConfig(), world.map, np.random.default_rng(0))
    belief.set_pose(tour[0].truth, np.diag([0.01, 0.01, 0.01]))
    readings: list[tuple[float, float]] = []
    estimate, kidnaps, recovered = None, 0, 0
    scans = round(arguments.hours * 3600.0 / _PERIOD)
    for k, (step, odometry, scan) in enumerate(_rounds(tour, scans)):
        estimate = belief.update(odometry, scan) or estimate
        if k % round(_EACH / _PERIOD) == 0:
            gc.collect()
            readings.append((k * _PERIOD / 3600.0, _resident_mb()))
        if step is tour[-1]:
            assert estimate is not None
            kidnaps += 1
            off = (estimate.T_map_odom @ odometry).distance(step.truth)
            recovered += estimate.status is Status.TRACKING and off < 0.1
    table = np.array(readings[_WARM:] if len(readings) > _WARM + 1 else readings)
    slope = float(np.polyfit(table[:, 0], table[:, 1], 1)[0]) if len(table) > 1 else None
    print(
        f"{arguments.hours:.1f} h: {table[0, 1]:.1f} MB to {table[-1, 1]:.1f} MB, "
        f"slope {slope} MB/h; recovered from {recovered} of {kidnaps} kidnaps"
    )
    return {
        "hours": arguments.hours,
        "first_mb": float(table[0, 1]),
        "last_mb": float(table[-1, 1]),
        "slope_mb_per_h": slope,
        "kidnaps": kidnaps,
        "recovered": recovered,
    }


def _rounds(tour: list[Step], scans: int) -> Iterator[tuple[Step, SE2, Scan]]:
    """Yield steps of the tour, endless odometry, and scans stamped accordingly."""
    T = SE2()
    for k in range(scans):
        step = tour[k % len(tour)]
        if step is tour[0]:
            T = T @ step.odometry.inverse()
        odometry = T @ step.odometry
        yield step, odometry, replace(step.scan, stamp=k * _PERIOD)
        if step is tour[-1]:
            T = odometry


def _resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE / 1e6
