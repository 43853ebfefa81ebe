"""Goals in a scene, one after the other, and the figures of the drives to them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from bringup.scenarios.course import Arrival, course
from bringup.terminal import show


def drive_to_goals(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive to one goal after the other; return the `figures_of` the drives.

    Goals are drawn before the first drive: how one ends changes no other's.

    Raises:
        ArjunaError: A file cannot be used, or the map has no room for goals.
    """
    rng = np.random.default_rng(arguments.seed or 0)
    with TemporaryDirectory() as folder, course(arguments, rng, Path(folder)) as driver:
        goals = driver.given or [driver.draw(rng) for _ in range(arguments.count)]
        result = figures_of([driver.drive(goal) for goal in goals], driver.speed)
    for name, value in result.items():
        show(f"{name:16}{value:10.4g}")
    return result


def figures_of(arrivals: Sequence[Arrival], speed: float) -> dict[str, Any]:
    """Return the figures of some drives.

    The shortest path is the one that a robot of `--radius` could drive among all that it could
    touch, be it on the robot's map or not: who does not know pays for finding out, and no path is
    asked for that leads through what the map lacks. Its inscribed radius is less than what the
    costmaps keep free, so that the ratio holds the room that a robot leaves beside it too.

    Args:
        speed: That the controller is asked to drive [m/s].

    Returns:
        The mean `score` of the goals: the shortest path's length over the time [m/s], 0 where a
        goal was not reached or something touched; `succeeded` and `missed` of `count`, `touches`,
        of people by the robot's own doing, how often it `met` people at all, a steered robot's
        `curvature_max` [1/m], `arrival_p95_m` and `arrival_p95_rad` by the truth,
        `believed_p95_m` by the robot's own word, `path_ratio` to the shortest path (see above),
        `speed_ratio` to the desired speed and `time_per_metre_s` of the shortest path, of the
        goals reached.
    """
    reached = [one for one in arrivals if one.succeeded]

    def p95(values: list[float]) -> float:
        return float(np.percentile(values, 95)) if values else math.nan

    length = sum(one.length for one in reached)
    shortest = max(sum(one.shortest for one in reached), 1e-9)
    time = sum(one.time for one in reached)
    return {
        "score": float(np.mean([one.score for one in arrivals])),
        "succeeded": len(reached),
        "count": len(arrivals),
        "missed": len(arrivals) - len(reached),
        "touches": sum(one.touches for one in arrivals),
        "met": sum(one.met for one in arrivals),
        "curvature_max": max((one.curvature for one in arrivals), default=math.nan),
        "arrival_p95_m": p95([one.off_m for one in reached]),
        "arrival_p95_rad": p95([one.off_rad for one in reached]),
        "believed_p95_m": p95([one.believed_m for one in reached]),
        "path_ratio": length / shortest if reached else math.nan,
        "speed_ratio": length / max(time, 1e-9) / speed if reached else math.nan,
        "time_per_metre_s": time / shortest if reached else math.nan,
    }
