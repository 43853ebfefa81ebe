"""AMCL on tours through our worlds: how well it tracks, finds itself, and notices a kidnap."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.config import load
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclConfig
from arjuna_slam.amcl.estimate import Estimate, Status
from arjuna_slam.amcl.filter import ParticleFilter
from tests.helpers.tours import Step, TourWorld, crowded, with_odometry, without_walls

WORLDS = ("arjuna_room", "office", "warehouse")
ODOMETRY = ("wheels", "perfect", "noisy", "slipping")
_HEADLINE = "wheels"
_START = np.diag([0.1**2, 0.1**2, 0.1**2])
_SETTLING = 10  # scans after the start that do not count
_DIVERGED, _DIVERGED_HEADING = 0.5, 0.5  # [m, rad]
_RIGHT, _RIGHT_HEADING = 0.1, 0.1
_GLOBAL_TIME, _GLOBAL_DISTANCE = 10.0, 2.0
_NOTICED, _RECOVERED = 3.0, 10.0
_PERIOD = 0.1
_AFAR = 1.0  # a kidnap goes at least so far [m]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seeds", type=int, default=10, help="tours a world (%(default)s)")
    parser.add_argument("--seconds", type=float, default=60.0, help="a tour's (%(default)s)")
    parser.add_argument("--worlds", nargs="+", default=WORLDS, choices=WORLDS)
    parser.add_argument("--starts", type=int, default=100, help="global starts (%(default)s)")
    parser.add_argument("--kidnaps", type=int, default=50, help="kidnaps (%(default)s)")
    parser.add_argument(
        "--set",
        nargs="+",
        default=[],
        metavar="NAME=VALUE",
        help="text or number parameters of amcl that differ from the defaults",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Drive tours in the simulator, then replay each in every case.

    Errors are those of the pose at each scan. Boxes and people are cut into the scans; the maps
    are rasterised from the worlds' true surfaces.

    Returns:
        `tracking_rmse_m`, `tracking_rmse_rad` and `tracking_p99_m` of the skid-steer robot's own
        odometry on a free path, in the worst world; `global_success` and
        `kidnap_success`, 0..1; and `rows`, one a world and case.
    """
    config = load(AmclConfig, dict(_pair(text) for text in arguments.set))
    rows: list[dict[str, Any]] = []
    tours: list[tuple[TourWorld, list[list[Step]]]] = []
    for name in arguments.worlds:
        world = TourWorld(name)
        drives = [world.drive(seed, arguments.seconds) for seed in range(arguments.seeds)]
        tours.append((world, drives))
        rows += [_show(row) for row in _tracking(world, drives, config)]
    found = _search_rows(tours, config, arguments.starts, _global_start, "global")
    caught = _search_rows(tours, config, arguments.kidnaps, _kidnap, "kidnap")
    headline = [row for row in rows if row["case"] == _HEADLINE]
    return {
        "tracking_rmse_m": max(row["rmse_m"] for row in headline),
        "tracking_rmse_rad": max(row["rmse_rad"] for row in headline),
        "tracking_p99_m": max(row["p99_m"] for row in headline),
        "global_success": _share(found),
        "kidnap_success": _share(caught),
        "rows": rows + found + caught,
    }


def _pair(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    try:
        return name, int(value)
    except ValueError:
        pass
    try:
        return name, float(value)
    except ValueError:
        return name, value


def _tracking(
    world: TourWorld, drives: list[list[Step]], config: AmclConfig
) -> Iterator[dict[str, Any]]:
    """Yield a row a case: each odometry, then clutter and a poor map with the wheels' own."""
    for case in (*ODOMETRY, "crowded", "missing walls"):
        errors = []
        for seed, drive in enumerate(drives):
            rng = np.random.default_rng(1000 + seed)
            grid, steps = world.map, drive
            if case in ODOMETRY:
                steps = with_odometry(drive, case, rng)
            elif case == "crowded":
                steps = crowded(world, drive, rng)
            else:
                grid = without_walls(world.map, rng)
            errors.append(_errors(grid, steps, config, seed))
        yield _row(world.name, case, errors)


def _row(world: str, case: str, errors: list[NDArray[np.float64]]) -> dict[str, Any]:
    everything = np.vstack(errors)
    lost = [(run[:, 0] > _DIVERGED) | (run[:, 1] > _DIVERGED_HEADING) for run in errors]
    return {
        "world": world,
        "case": case,
        "tours": len(errors),
        "rmse_m": float(np.sqrt(np.mean(everything[:, 0] ** 2))),
        "rmse_rad": float(np.sqrt(np.mean(everything[:, 1] ** 2))),
        "p99_m": float(np.quantile(everything[:, 0], 0.99)),
        "max_m": float(everything[:, 0].max()),
        "quality": float(everything[:, 2].mean()),
        "diverged": int(sum(bool(run.any()) for run in lost)),
    }


def _show(row: dict[str, Any]) -> dict[str, Any]:
    print(
        f"{row['world']:12} {row['case']:14} {row['tours']:3d} tours  "
        f"rmse {1e3 * row['rmse_m']:6.1f} mm {1e3 * row['rmse_rad']:6.2f} mrad  "
        f"p99 {1e3 * row['p99_m']:6.1f} mm  max {1e3 * row['max_m']:6.1f} mm  "
        f"quality {row['quality']:.2f}  {row['diverged']} diverged",
        flush=True,
    )
    return row


@dataclass
class _Follower:
    """A filter fed with a drive, as a node feeds it."""

    belief: ParticleFilter
    estimate: Estimate | None = None

    def feed(self, step: Step) -> tuple[float, float, float]:
        """Take in a scan; return the errors of position [m] and heading [rad], and the quality."""
        estimate = self.belief.update(step.odometry, step.scan)
        if estimate is not None:
            self.estimate = estimate
        assert self.estimate is not None
        pose = self.estimate.T_map_odom @ step.odometry
        off = abs(wrap(pose.theta - step.truth.theta))
        return pose.distance(step.truth), off, self.estimate.quality

    @property
    def sure(self) -> bool:
        """True while the filter reports that it knows the pose."""
        return self.estimate is not None and self.estimate.status is Status.TRACKING


def _errors(
    grid: OccupancyGrid, steps: list[Step], config: AmclConfig, seed: int
) -> NDArray[np.float64]:
    """Return the errors after a start that is 10 cm off, `(N, 3)`."""
    rng = np.random.default_rng(seed)
    follower = _Follower(ParticleFilter(config, grid, rng))
    off = SE2.from_array(rng.normal(0.0, 0.1, 3))
    follower.belief.set_pose(steps[0].truth @ off, _START)
    errors = [follower.feed(step) for step in steps]
    return np.array(errors[min(_SETTLING, len(errors) - 1) :])


def _search_rows(
    tours: list[tuple[TourWorld, list[list[Step]]]],
    config: AmclConfig,
    count: int,
    attempt: Any,
    case: str,
) -> list[dict[str, Any]]:
    """Return a row a world: how many of its share of attempts succeeded."""
    rows = []
    for k, (world, drives) in enumerate(tours):
        mine = range(k, count, len(tours))
        results = [attempt(world, drives, config, seed) for seed in mine]
        row = {
            "world": world.name,
            "case": case,
            "count": len(results),
            "succeeded": sum(result[0] for result in results),
            "surely_wrong": sum(result[1] for result in results),
            "seconds": float(np.median([result[2] for result in results])) if results else None,
        }
        print(
            f"{world.name:12} {case:14} {row['succeeded']} of {row['count']} right in time, "
            f"median {row['seconds']} s; {row['surely_wrong']} surely wrong on the way"
        )
        rows.append(row)
    return rows


def _share(rows: list[dict[str, Any]]) -> float | None:
    count = sum(row["count"] for row in rows)
    return sum(row["succeeded"] for row in rows) / count if count else None


def _right(errors: tuple[float, float, float]) -> bool:
    return errors[0] < _RIGHT and errors[1] < _RIGHT_HEADING


def _global_start(
    world: TourWorld, drives: list[list[Step]], config: AmclConfig, seed: int
) -> tuple[bool, bool, float]:
    """Start anywhere; return whether it is right in time, ever surely wrong, and when right."""
    rng = np.random.default_rng(2000 + seed)
    drive = drives[int(rng.integers(len(drives)))]
    start = int(rng.integers(max(1, len(drive) - round(_GLOBAL_TIME / _PERIOD))))
    follower = _Follower(ParticleFilter(config, world.map, rng))
    follower.belief.globalize()
    driven, first, wrong = 0.0, math.inf, False
    good = False
    for k, step in enumerate(drive[start : start + round(_GLOBAL_TIME / _PERIOD)]):
        if k:
            driven += step.truth.distance(drive[start + k - 1].truth)
        if driven > _GLOBAL_DISTANCE:
            break
        errors = follower.feed(step)
        good = follower.sure and _right(errors)
        wrong |= follower.sure and errors[0] > _DIVERGED
        first = (first if math.isfinite(first) else k * _PERIOD) if good else math.inf
    return good, wrong, first


def _kidnap(
    world: TourWorld, drives: list[list[Step]], config: AmclConfig, seed: int
) -> tuple[bool, bool, float]:
    """Carry the robot from one drive to another; return as `_global_start`, from then on.

    It is noticed once the filter is not sure any more, or right again.
    """
    rng = np.random.default_rng(3000 + seed)
    before = drives[seed % len(drives)][:50]
    after = _afar(drives, before[-1].truth, rng)
    T = before[-1].odometry @ after[0].odometry.inverse()
    moved = [replace(step, odometry=T @ step.odometry) for step in after]
    late = before[-1].scan.stamp + _PERIOD - after[0].scan.stamp
    follower = _Follower(ParticleFilter(config, world.map, rng))
    follower.belief.set_pose(before[0].truth, _START)
    for step in before:
        follower.feed(step)
    noticed, first, wrong = math.inf, math.inf, False
    for k, step in enumerate(moved):
        scan = replace(step.scan, stamp=step.scan.stamp + late)
        errors = follower.feed(replace(step, scan=scan))
        good = follower.sure and _right(errors)
        if good or not follower.sure:
            noticed = min(noticed, k * _PERIOD)
        wrong |= follower.sure and not good and k * _PERIOD > _NOTICED
        first = (first if math.isfinite(first) else k * _PERIOD) if good else math.inf
    return noticed <= _NOTICED and first <= _RECOVERED, wrong, first


def _afar(drives: list[list[Step]], here: SE2, rng: np.random.Generator) -> list[Step]:
    """Return ten seconds of a drive that begin far from a pose."""
    length = round(_RECOVERED / _PERIOD) + 1
    while True:
        drive = drives[int(rng.integers(len(drives)))]
        start = int(rng.integers(max(1, len(drive) - length)))
        if drive[start].truth.distance(here) > _AFAR:
            return drive[start : start + length]
