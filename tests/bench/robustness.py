"""SLAM made hard: slipping wheels, a noisy lidar, lost beams, gaps, a person; many seeds each."""

from __future__ import annotations

import argparse
import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.inputs import named_robot, named_world
from arjuna_sim.simulation import Simulation, solo
from tests.slam.slam_room import Log, room
from tests.slam.trials import SCENARIOS, Figures, measure, room_log, spoil

_WAYPOINTS = (
    *((1.5, 2.0), (-0.3, 2.2), (-3.0, 1.5), (-3.5, -1.0), (-0.5, -2.0)),
    *((1.2, -1.5), (1.3, 1.0), (0.0, 0.0), (1.5, 2.0), (-0.3, 2.2)),
)
_REACHED, _SPEED, _TURN, _GAIN = 0.2, 0.5, 1.0, 2.0
_SIGMA = 0.01  # of both rooms' lidars [m]
_TICKS_MAX = 10_000
Source = Callable[[int], tuple[Log, NDArray[np.float64]]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--seeds", type=int, default=10, help="drives of each kind (%(default)s)")
    parser.add_argument(
        "--room", choices=sorted(_ROOMS), help="only this room: a drawn one, or Arjuna's, simulated"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map each drive in each scenario.

    Returns:
        For each room and scenario the mean and the worst of all seeds of `rmse_m`, `map_error_m`,
        the greatest error and the number of broken maps.
    """
    result: dict[str, Any] = {}
    for name, source in _ROOMS.items():
        if arguments.room in (None, name):
            result[name] = _run_room(name, source, arguments.seeds)
    return result


def _run_room(name: str, source: Source, seeds: int) -> dict[str, Any]:
    drives = [source(seed) for seed in range(seeds)]
    print(f"{name}, {seeds} seeds            RMSE mean / worst   map error mean / worst   broken")
    result = {}
    for title, scenario in SCENARIOS.items():
        found = [
            measure(spoil(log, scenario, _SIGMA, seed), walls)
            for seed, (log, walls) in enumerate(drives)
        ]
        row = result[title] = _row(found)
        print(
            f"  {title:24}{row['rmse_m']:10.4f} / {row['rmse_worst_m']:.4f} m"
            f"{row['map_error_m']:13.4f} / {row['map_error_worst_m']:.4f} m{row['broken']:9}"
        )
    return result


def _row(found: list[Figures]) -> dict[str, Any]:
    return {
        "rmse_m": float(np.mean([one.rmse for one in found])),
        "rmse_worst_m": max(one.rmse for one in found),
        "error_worst_m": max(one.worst for one in found),
        "map_error_m": float(np.mean([one.map_error for one in found])),
        "map_error_worst_m": max(one.map_error for one in found),
        "astray_worst": max(one.astray for one in found),
        "odometry_drift_m": float(np.mean([one.drift for one in found])),
        "broken": sum(one.broken for one in found),
        "seeds": [dataclasses.asdict(one) for one in found],
    }


def _drawn(seed: int) -> tuple[Log, NDArray[np.float64]]:
    return room_log(seed), room()


def _arjuna(seed: int) -> tuple[Log, NDArray[np.float64]]:
    return _simulated(seed, IDENTITY)


def _arjuna_askew(seed: int) -> tuple[Log, NDArray[np.float64]]:
    """Start anywhere, so that the map's cells do not lie along the walls."""
    x, y, theta = np.random.default_rng([seed, 3]).uniform((-0.5, -0.5, -3.0), (0.5, 0.5, 3.0))
    return _simulated(seed, SE2(float(x), float(y), float(theta)))


def _simulated(seed: int, spawn: SE2) -> tuple[Log, NDArray[np.float64]]:
    """Drive the Arjuna robot through its room; truth steers it, so that every seed can compare."""
    simulator = Simulation(
        solo(named_robot("", ""), spawn),
        named_world(""),
        SimulatorConfig(),
        np.random.default_rng(seed),
    )
    log: Log = []
    waypoints = list(_WAYPOINTS)
    for _ in range(_TICKS_MAX):
        command = _towards(simulator.robot.truth().pose, waypoints[0]) if log else Velocity()
        seen = simulator.drive(command)
        if seen.scan is not None:
            log.append((seen.scan, seen.odometry.T_odom_base, seen.truth.pose))
        if seen.truth.pose.distance(SE2(*waypoints[0])) < _REACHED:
            waypoints.pop(0)
        if not waypoints:
            break
    return log, simulator.robot.surfaces()


def _towards(pose: SE2, goal: tuple[float, float]) -> Velocity:
    error = wrap(math.atan2(goal[1] - pose.y, goal[0] - pose.x) - pose.theta)
    turn = min(max(_GAIN * error, -_TURN), _TURN)
    return Velocity(_SPEED if abs(error) < 0.5 else 0.0, yaw_rate=turn)


_ROOMS: dict[str, Source] = {
    "drawn": _drawn,
    "arjuna": _arjuna,
    "arjuna-askew": _arjuna_askew,
}
