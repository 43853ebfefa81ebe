"""With `--as-slam-toolbox` the mapper does what slam_toolbox's published sources say.

A row each: a measurement, its result as slam_toolbox, worked out by hand, and as shipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.config import load
from arjuna_core.grid import FREE, OCCUPIED
from arjuna_core.scan import Scan
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_slam.config import SlamNodeConfig
from arjuna_slam.graph.loops import LoopCloser
from arjuna_slam.localization import Localizer
from arjuna_slam.mapping.session import Start, StartKind
from arjuna_slam.nodes.slam_files import start_of
from arjuna_slam.pose_tracker import Pace
from arjuna_slam.slam import Slam
from bringup.parameters.checking import merged_sources
from tests.slam.graph.loop_scenes import LAST, NOTHING, Scripted, square, up_to
from tests.slam.mapping.test_occupancy import scans
from tests.slam.slam_room import drive

pytestmark = pytest.mark.ros


def config_of(*originals: str) -> SlamNodeConfig:
    """Return the node's parameters as the command line sets them."""
    return load(SlamNodeConfig, merged_sources([], originals=originals).parameters["slam_toolbox"])


def scan_of(ranges: Any, stamp: float = 0.0) -> Scan:
    return Scan(np.asarray(ranges, np.float64), -0.5, 0.01, 0.1, 30.0, stamp, 0.0)


def taken(step: SE2, period: float) -> Callable[[SlamNodeConfig], list[int]]:
    """Return which of 17 scans are processed, so far apart in motion and time [s]."""

    def measure(c: SlamNodeConfig) -> list[int]:
        pace, pose, found = Pace(), IDENTITY, []
        for k in range(17):
            if pace.is_due(c, scan_of([1.0], k * period), pose):
                found.append(k)
            pose = pose @ step
        return found

    return measure


def cells(c: SlamNodeConfig, ranges: float, value: int) -> int:
    """Return how many cells have a value where three scans of a range were traced."""
    keyframes = c.core.keyframes()
    for _ in range(3):
        keyframes.add(scan_of(np.full(100, ranges)), IDENTITY)
    grid = keyframes.map()
    return 0 if grid is None else int((grid.data == value).sum())


def thickness(c: SlamNodeConfig) -> int:
    """Return how many cells of a noisy wall, 3 cm, lie one behind another."""
    keyframes = c.core.keyframes()
    for scan in scans(0.03):
        keyframes.add(scan, IDENTITY)
    grid = keyframes.map()
    assert grid is not None
    counts = (grid.data == OCCUPIED).sum(axis=1)
    return int(np.median(counts[counts > 0]))


def closing(c: SlamNodeConfig, off: SE2 = IDENTITY, response: float = 0.9) -> tuple[Scripted, int]:
    """Return the matcher asked for a loop, and the edges, where a keyframe is tried twice."""
    graph, submaps = square()
    matcher = Scripted(off, response)
    closer = LoopCloser(c.core, matcher, 20.0)
    edges = [closer.close(graph, up_to(LAST + 0.1 * k), NOTHING, submaps) for k in range(2)]
    return matcher, len(edges[0])


def window(c: SlamNodeConfig) -> tuple[float, float]:
    asked = closing(c)[0].asked[0][2]
    return round(asked.xy, 3), round(asked.theta, 3)


def compares_submaps(c: SlamNodeConfig) -> bool:
    graph, submaps = square()
    return LoopCloser(c.core, Scripted(), 20.0).step(graph, submaps, []) is not None


EVERY = list(range(17))
FOURTH = EVERY[::4]
ROWS: dict[str, tuple[Callable[[SlamNodeConfig], Any], Any, Any]] = {
    # Mapper::HasMovedEnough: 4 x 0.125 m reach minimum_travel_distance, 0.5
    "travel": (taken(SE2(0.125), 1.0), FOURTH, EVERY),
    # and 4 x 0.125 rad minimum_travel_heading, 0.5
    "heading": (taken(SE2(0.0, 0.0, 0.125), 1.0), FOURTH, EVERY),
    # shouldProcessScan: 4 x 0.125 s reach minimum_time_interval, 0.5
    "interval": (taken(SE2(1.0), 0.125), FOURTH, EVERY),
    # OccupancyGrid::AddScan leaves out what is not below the lidar's range_max
    "no return": (lambda c: cells(c, math.inf, FREE) > 0, False, True),
    # max_laser_range 25: a beam of 22 m ends in a cell, not clears up to 20
    "range": (lambda c: cells(c, 22.0, OCCUPIED) > 0, True, False),
    # OccupancyGrid::UpdateCell: more than a tenth of the beams, whatever is beside. A wall 2 cm
    # behind the middle of a cell, 3 cm of noise: 50 % and 40 % of the beams end in that cell and
    # the next; the 3 % that reach the third all end there
    "cells": (thickness, 3, 2),
    # MapperGraph::TryCloseLoop: a match that is good enough is added, how far off it may be
    "loop far off": (lambda c: closing(c, SE2(0.5))[1], 1, 0),
    # where the graph does not leave it open as well
    "loop unlikely": (lambda c: closing(c, SE2(-2.0))[1], 1, 0),
    # loop_match_minimum_response_fine, 0.45
    "loop bad": (lambda c: (closing(c, SE2(0.5), 0.44)[1], closing(c, SE2(), 0.46)[1]), (0, 1),
                 (0, 1)),
    # half of loop_search_space_dimension, 8; coarse_search_angle_offset
    "loop window": (window, (4.0, 0.349), (1.276, 0.138)),
    # each keyframe is tried
    "loop again": (lambda c: len(closing(c, response=0.1)[0].asked), 2, 1),
    # near is loop_search_maximum_distance alone: nothing is searched by drift
    "loop by drift": (compares_submaps, False, True),
    # loadPoseGraphByParams: START_AT_GIVEN_POSE or LOCALIZE_AT_POSE at 0 0 0
    "start": (start_of, Start(StartKind.NEAR_POSE), Start(StartKind.ANYWHERE)),
    # correlation_search_space_dimension 0.5; minimum_distance_penalty 0.05
    "window": (lambda c: (c.window.xy, c.window.floor_xy), (0.25, 0.05), (0.5, 0.8)),
}  # fmt: skip


@pytest.mark.parametrize("row", ROWS)
def test_row(row: str) -> None:
    measure, theirs, ours = ROWS[row]
    assert measure(config_of("slam_toolbox")) == theirs
    assert measure(config_of("nav2")) == measure(config_of()) == ours


def test_the_buffer_carries_localization_beyond_the_map() -> None:
    c = replace(config_of().core, max_laser_range=4.0)
    log = drive(seed=5)
    slam = Slam(c)
    for scan, odometry, _ in log[:60]:
        slam.process(scan, odometry)
    session = slam.session()
    assert session is not None
    worst, known = dict.fromkeys((0, 10), 0.0), {}
    for size in worst:
        sized = replace(c, scan_buffer_size=size)
        localizer = Localizer(sized, session, Start(StartKind.FIRST_NODE))
        for scan, odometry, truth in log[:200]:
            update = localizer.process(scan, odometry)
            assert update is not None
            worst[size] = max(worst[size], (log[0][2] @ update.T_map_base).distance(truth))
        grid = localizer.map()
        assert grid is not None
        known[size] = int((grid.data == OCCUPIED).sum())
    assert worst[10] < 0.03 < 0.1 < worst[0]
    assert known[10] > known[0]
    localizer.clear_buffer()
    cleared = localizer.map()
    assert cleared is not None
    assert int((cleared.data == OCCUPIED).sum()) == known[0]
