"""Time of one AMCL update against particles and beams, beside the `amcl` package if installed."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.filter import ParticleFilter
from tests.slam.amcl.room import Robot, room_map

_PARTICLES = (250, 500, 1000, 2000, 5000, 20_000, 200_000)
_BEAMS = (30, 60, 180, 360)
_SPREAD = np.diag([0.05**2, 0.05**2, 0.03**2])
_ROOM = room_map(SE2(-5.2, -5.2, 0.0))  # the package knows no rotated maps

Log = list[tuple[SE2, Scan]]
Update = Callable[[SE2, Scan], object]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seed", type=int, default=0, help="seed of all chance (%(default)s)")
    parser.add_argument(
        "--budget", type=float, default=2.0, metavar="SECONDS", help="for each row (%(default)s)"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time updates of a fixed number of particles on a drive through a room, on one core.

    An update is the whole call with a new scan of 360 beams: motion, weighing, resampling,
    clusters, and for ours scan matching and the check of all beams. Times are processor time, the
    median and the best over the drive.

    Returns:
        `rows`, each `particles, beams, ms, best_ms, amcl_ms, amcl_best_ms, times_faster`; the
        last three None without the package or where it is too slow for the budget.
    """
    peer = importlib.import_module("amcl") if importlib.util.find_spec("amcl") else None
    if peer is None:
        print("amcl is not installed: nothing to compare with")
    log = _drive(arguments.seed)
    sizes = [(count, 60) for count in _PARTICLES] + [(2000, beams) for beams in _BEAMS]
    rows = [_row(count, beams, log, arguments, peer) for count, beams in dict.fromkeys(sizes)]
    return {"map_cells": list(_ROOM.frame.shape), "rows": rows}


def _row(
    count: int, beams: int, log: Log, arguments: argparse.Namespace, peer: Any
) -> dict[str, Any]:
    ours = _times(_our_update(count, beams, arguments.seed, log), log, arguments.budget)
    row: dict[str, Any] = {"particles": count, "beams": beams}
    row |= {"ms": float(np.median(ours)), "best_ms": min(ours)}
    row |= {"amcl_ms": None, "amcl_best_ms": None, "times_faster": None}
    text = (
        f"{count:7d} particles x {beams:3d} beams  {row['ms']:8.3f} ms (best {row['best_ms']:.3f})"
    )
    if peer is not None:
        theirs = _times(_their_update(peer, count, beams, log), log, arguments.budget)
        row |= {"amcl_ms": float(np.median(theirs)), "amcl_best_ms": min(theirs)}
        row["times_faster"] = row["amcl_ms"] / row["ms"]
        text += f"   amcl {row['amcl_ms']:9.3f} ms   {row['times_faster']:6.1f} x"
    print(text, flush=True)
    return row


def _drive(seed: int) -> Log:
    """Return odometry that begins at the true pose, from where both filters start, and scans."""
    robot = Robot(np.random.default_rng(seed))
    scan = robot.step()
    T_map_odom = robot.pose @ robot.odometry.inverse()
    log = [(T_map_odom @ robot.odometry, scan)]
    for _ in range(400):
        scan = robot.step()
        log.append((T_map_odom @ robot.odometry, scan))
    return log


def _times(update: Update, log: Log, budget: float) -> list[float]:
    """Return the processor time of each update [ms]; the first ones compile and warm up."""
    for pose, scan in log[1:4]:
        update(pose, scan)
    times: list[float] = []
    for pose, scan in log[4:]:
        start = time.thread_time()
        update(pose, scan)
        times.append(1e3 * (time.thread_time() - start))
        if sum(times) > 1e3 * budget and len(times) >= 3:
            break
    return times


def _our_update(count: int, beams: int, seed: int, log: Log) -> Update:
    config = AmclConfig(min_particles=count, max_particles=count, max_beams=beams)
    belief = ParticleFilter(config, _ROOM, np.random.default_rng(seed))
    belief.set_pose(log[0][0], _SPREAD)
    belief.update(*log[0], force=True)
    return lambda pose, scan: belief.update(pose, scan, force=True)


def _their_update(peer: Any, count: int, beams: int, log: Log) -> Update:
    """Return the package's update; making its scan from ours is not part of the time it takes."""
    c = AmclConfig()
    motion = peer.MotionParameters(c.alpha1, c.alpha2, c.alpha3, c.alpha4, c.alpha5)
    laser = peer.LaserParameters(
        c.z_hit, c.z_short, c.z_max, c.z_rand, c.sigma_hit, c.lambda_short, 0.0, beams
    )
    slow, fast = c.recovery_alpha_slow, c.recovery_alpha_fast
    localizer = peer.AMCL(count, count, slow, fast, motion, laser, "differential")
    frame = _ROOM.frame
    cells: Sequence[Sequence[int]] = _ROOM.data.astype(int).tolist()
    localizer.set_map(
        peer.create_occupancy_grid_from_list(
            cells, frame.resolution, frame.origin.x, frame.origin.y
        )
    )
    covariance = peer.create_diagonal_covariance(*np.diag(_SPREAD).tolist())
    start = log[0][0]
    localizer.set_initial_pose(peer.Vector3D(start.x, start.y, start.theta), covariance)
    localizer.set_laser_pose(peer.Vector3D(0.0, 0.0, 0.0))
    made = {
        id(scan): peer.create_laser_scan_from_list(
            np.column_stack((scan.ranges, scan.angles)).tolist(), scan.range_max
        )
        for _, scan in log
    }
    return lambda pose, scan: localizer.update(
        made[id(scan)], peer.Vector3D(pose.x, pose.y, pose.theta)
    )
