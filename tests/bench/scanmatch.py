"""Scan matching beside Karto's matcher (`karto-scanmatcher`): same scans, guesses and window."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.config import SlamConfig
from arjuna_slam.graph.submap import Submap
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.matching.correlative import Window
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import ScanMatcher
from arjuna_slam.matching.surface import extract
from tests.slam.slam_room import room, scan_at

_HALF_WIDTH, _HALF_ANGLE = 0.25, 0.349  # slam_toolbox's default window
_GUESS_WITHIN = 0.8  # share of the window that guesses are off by, at most
_GENERATED_REFERENCES = 10
_OVERLAP_DISTANCE, _OVERLAP_TURN = 1.0, 0.8  # scanners that see half around must share a view
_FAILED_POSITION, _FAILED_HEADING = 0.1, math.radians(3.0)
_REPEATS = 3


@dataclass(frozen=True)
class _Case:
    """A scan to be found among others: their poses, its true pose and a guess of it."""

    references: list[tuple[Scan, SE2]]
    scan: Scan
    truth: SE2
    guess: SE2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--log", type=Path, help="CARMEN log; without, a room's scans are made")
    parser.add_argument("--relations", type=Path, help="its reference relations, the truth")
    parser.add_argument("--count", type=int, default=200, help="matches (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed (%(default)s)")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Match each scan with both; building the reference is part of a match, as in Karto.

    Returns:
        `match_ms` (CPU time, the least of three runs, mean of all), `position_m` and `heading_deg`
        (medians of the error), `failed` (share of matches over 0.1 m or 3 degrees off); Karto's as
        `karto_*`, None without it; `speedup`.
    """
    rng = np.random.default_rng(arguments.seed)
    if arguments.log is None or arguments.relations is None:
        cases = [_generated(rng) for _ in range(arguments.count)]
    else:
        cases = _recorded(arguments.log, arguments.relations, arguments.count, rng)
    result = _measure(cases, _arjuna(), "")
    if importlib.util.find_spec("karto_scanmatcher") is None:
        print("karto-scanmatcher is not installed: nothing to compare with")
        karto = {f"karto_{key}": None for key in result} | {"speedup": None}
    else:
        karto = _measure(cases, _karto(), "karto_")
        karto["speedup"] = karto["karto_match_ms"] / result["match_ms"]
        print(f"{karto['speedup']:.1f} times as fast")
    return {"matches": len(cases)} | result | karto


def _generated(rng: np.random.Generator) -> _Case:
    """Scans along a metre of a drive, at poses known exactly, and one at its end."""
    x, y, theta = rng.uniform((4.0, 4.0, -math.pi), (6.0, 6.0, math.pi)).tolist()
    start = SE2(x, y, theta)
    track = [start @ SE2(0.1 * k, 0.0, 0.02 * k) for k in range(-_GENERATED_REFERENCES, 1)]
    scans = [scan_at(room(), pose, sigma=0.01, rng=rng) for pose in track]
    truth = track[-1]
    references = list(zip(scans[:-1], track[:-1], strict=True))
    return _Case(references, scans[-1], truth, truth @ _offset(rng))


def _recorded(log: Path, relations: Path, count: int, rng: np.random.Generator) -> list[_Case]:
    """Pairs of scans of a log that a short relation joins."""
    scans = {round(scan.stamp, 6): scan for scan, _ in open_log(log, RecordingTopics())}
    cases = []
    for t1, t2, x, y, _, _, _, yaw in np.loadtxt(relations, ndmin=2).tolist():
        first, second = scans.get(round(t1, 6)), scans.get(round(t2, 6))
        near = math.hypot(x, y) < _OVERLAP_DISTANCE and abs(yaw) < _OVERLAP_TURN
        if first is None or second is None or not near:
            continue
        truth = SE2(x, y, yaw)
        cases.append(_Case([(first, SE2())], second, truth, truth @ _offset(rng)))
    chosen = rng.permutation(len(cases))[:count]
    return [cases[k] for k in sorted(chosen.tolist())]


def _offset(rng: np.random.Generator) -> SE2:
    half = _GUESS_WITHIN * np.array([_HALF_WIDTH / math.sqrt(2.0)] * 2 + [_HALF_ANGLE])
    return SE2.from_array(rng.uniform(-half, half))


def _measure(cases: list[_Case], match: Callable[[_Case], SE2], prefix: str) -> dict[str, Any]:
    match(cases[0])
    best, found = math.inf, []
    for _ in range(_REPEATS):
        start = time.process_time()
        found = [match(case) for case in cases]
        best = min(best, time.process_time() - start)
    errors = [case.truth.inverse() @ pose for case, pose in zip(cases, found, strict=True)]
    position = np.array([math.hypot(error.x, error.y) for error in errors])
    heading = np.abs([error.theta for error in errors])
    failed = (position > _FAILED_POSITION) | (heading > _FAILED_HEADING)
    result = {
        "match_ms": 1e3 * best / len(cases),
        "position_m": float(np.median(position)),
        "heading_deg": math.degrees(float(np.median(heading))),
        "failed": float(failed.mean()),
    }
    print(
        f"{prefix.strip('_') or 'arjuna':8} {result['match_ms']:8.3f} ms a match, median error "
        f"{result['position_m']:.4f} m {result['heading_deg']:.3f} deg, "
        f"failed {100.0 * result['failed']:.1f} %"
    )
    return {f"{prefix}{key}": value for key, value in result.items()}


def _arjuna() -> Callable[[_Case], SE2]:
    config = SlamConfig()
    matcher, penalties = ScanMatcher(config), config.window
    window = Window(
        _HALF_WIDTH, _HALF_ANGLE, penalties.depth, penalties.distance_penalty,
        penalties.angle_penalty, penalties.floor_xy, penalties.floor_theta,
    )  # fmt: skip

    def match(case: _Case) -> SE2:
        submap = Submap(
            Field(
                config.field_resolution,
                config.field_deviation,
            )
        )
        for node, (scan, pose) in enumerate(case.references):
            submap.insert(node, extract(scan, config.max_laser_range), pose)
        surface = extract(case.scan, config.max_laser_range)
        least = config.match_minimum_response
        return matcher.match(submap.field, surface, case.guess, window, least).T_field_base

    return match


def _karto() -> Callable[[_Case], SE2]:
    """Return Karto's matcher with its defaults, called as slam_toolbox does."""
    karto = importlib.import_module("karto_scanmatcher")
    settings = karto.ScanMatcherConfig()
    settings.search_size = 2.0 * _HALF_WIDTH
    settings.coarse_search_angle_offset = _HALF_ANGLE
    matcher = karto.Wrapper(settings)

    def localized(scan: Scan, pose: SE2, number: int) -> Any:
        sensor = pose @ scan.T_base_sensor
        last = scan.angle_min + (len(scan.ranges) - 1) * scan.angle_increment
        laser = karto.LaserScanConfig(
            scan.angle_min, last, scan.angle_increment, scan.range_min, scan.range_max,
            SlamConfig().max_laser_range, "laser",
        )  # fmt: skip
        sensor_pose = karto.Pose2(sensor.x, sensor.y, sensor.theta)
        ranges = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_max).tolist()
        return karto.LocalizedRangeScan(laser, ranges, sensor_pose, sensor_pose, number, scan.stamp)

    def match(case: _Case) -> SE2:
        references = [localized(scan, pose, k) for k, (scan, pose) in enumerate(case.references)]
        scan = localized(case.scan, case.guess, len(references))
        pose = matcher.match_scan(scan, references, True, True).best_pose
        return SE2(pose.x, pose.y, pose.yaw) @ case.scan.T_base_sensor.inverse()

    return match
