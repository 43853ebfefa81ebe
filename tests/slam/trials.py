"""Drives made harder: slip, noise, lost beams, gaps, a person who walks; and the figures."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.slam import Slam
from tests.slam.slam_room import Log, distance_to_walls, drive

_PERSON_RADIUS, _PERSON_SPEED, _PERSON_GAP = 0.2, 1.0, 0.6  # [m], [m/s], [m]
_ASTRAY = 0.15  # an occupied cell this far from any wall is none [m]


@dataclass(frozen=True)
class Scenario:
    """Settings that make a drive harder.

    Attributes:
        slip: Factor on each step's odometry error.
        noise: Factor on the deviation of the ranges.
        dropped: Share of beams that return nothing.
        gap: Time without scans in the middle of the drive [s].
        person: Whether somebody walks to and fro across the room.
    """

    slip: float = 1.0
    noise: float = 1.0
    dropped: float = 0.0
    gap: float = 0.0
    person: bool = False


SCENARIOS = {
    "as it is": Scenario(),
    "slip doubled": Scenario(slip=2.0),
    "noise tripled": Scenario(noise=3.0),
    "30 % of beams lost": Scenario(dropped=0.3),
    "2 s without scans": Scenario(gap=2.0),
    "a person walks": Scenario(person=True),
    "all of it": Scenario(2.0, 3.0, 0.3, 2.0, True),
}


@dataclass(frozen=True)
class Figures:
    """Errors of a trial [m].

    Attributes:
        rmse: Root mean square error of the poses as they came.
        worst: The greatest of these errors.
        map_error: Mean distance of occupied cells to true surfaces.
        astray: Share of occupied cells far from any.
        drift: How far the odometry was off in the end.
    """

    rmse: float
    worst: float
    map_error: float
    astray: float
    drift: float

    @property
    def broken(self) -> bool:
        """True if the map is of no use: walls doubled or bent."""
        return self.worst > 0.3 or self.map_error > 0.06 or self.astray > 0.1


def room_log(seed: int) -> Log:
    """Return a drive round the room from a start of its own: the map lies askew in it."""
    lap = drive(seed, laps=2.0)
    start = int(np.random.default_rng([seed, 7]).integers(0, len(lap) // 3))
    return lap[start : start + int(len(lap) * 0.65)]


def spoil(log: Log, scenario: Scenario, sigma: float, seed: int) -> Log:
    """Return a drive as the scenario has it.

    Args:
        log: The drive.
        scenario: What makes it harder.
        sigma: Deviation of the drive's ranges [m].
        seed: Of what is random.
    """
    rng = np.random.default_rng([seed, 11])
    start, odometry = log[0][0].stamp, log[0][1]
    middle = 0.5 * (start + log[-1][0].stamp)
    centre = np.mean([(truth.x, truth.y) for _, _, truth in log], axis=0)
    result: Log = []
    for k, (scan, wheels, truth) in enumerate(log):
        if k > 0:
            odometry = odometry @ _slipped(log[k - 1], log[k], scenario.slip)
        if scenario.gap > 0.0 and abs(scan.stamp - middle) < 0.5 * scenario.gap:
            continue
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        if scenario.person:
            ranges = _behind(ranges, scan, truth, _person(scan.stamp - start, truth, centre))
        if scenario.noise > 1.0:
            extra = sigma * math.sqrt(scenario.noise**2 - 1.0)
            ranges = ranges + rng.normal(0.0, extra, len(ranges))
        ranges = np.where(rng.random(len(ranges)) < scenario.dropped, np.inf, ranges)
        pose = odometry if scenario.slip != 1.0 else wheels
        result.append((dataclasses.replace(scan, ranges=ranges), pose, truth))
    return result


def _slipped(before: tuple[Scan, SE2, SE2], now: tuple[Scan, SE2, SE2], factor: float) -> SE2:
    """Return an odometry step whose error is a multiple of what it was."""
    true_step = before[2].inverse() @ now[2]
    error = (true_step.inverse() @ (before[1].inverse() @ now[1])).log()
    return true_step @ SE2.exp(factor * error)


def _person(time: float, robot: SE2, centre: Floats) -> Floats:
    """Return where the person is, to and fro within 4 m of a point, `(2,)` [m]."""
    along = math.remainder(_PERSON_SPEED * time, 16.0)
    at: Floats = centre + np.array([abs(along) - 4.0, 0.3 * math.sin(0.7 * time)])
    gap = at - (robot.x, robot.y)
    distance = float(np.hypot(*gap))
    if distance < _PERSON_GAP:  # who walks does not walk into the robot
        at = at + gap / max(distance, 1e-6) * (_PERSON_GAP - distance)
    return at


def _behind(ranges: Floats, scan: Scan, robot: SE2, person: Floats) -> Floats:
    """Return ranges that end at the person where the person stands before a wall."""
    sensor = robot @ scan.T_base_sensor
    bearing = scan.angles + sensor.theta
    offset = person - (sensor.x, sensor.y)
    along = offset[0] * np.cos(bearing) + offset[1] * np.sin(bearing)
    across = offset[1] * np.cos(bearing) - offset[0] * np.sin(bearing)
    inside = _PERSON_RADIUS**2 - across**2
    hit = along - np.sqrt(np.maximum(inside, 0.0))
    return np.where((inside > 0.0) & (hit > 0.0) & (hit < ranges), hit, ranges)


def measure(log: Log, walls: Floats, slam: Slam | None = None) -> Figures:
    """Map a drive and return the figures.

    Args:
        log: The drive.
        walls: True segments, `(M, 4) float64` [m].
        slam: The mapper; one with its defaults if None.
    """
    slam = slam or Slam()
    T_world_map = log[0][2] @ log[0][1].inverse()
    errors = []
    for scan, odometry, truth in log:
        update = slam.process(scan, odometry)
        if update is not None:
            errors.append((T_world_map @ update.T_map_base).distance(truth))
    slam.optimize()
    grid = slam.map()
    assert grid is not None
    cells = grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64))
    gaps = distance_to_walls(walls, T_world_map.apply(cells))
    wheels = log[0][1].inverse() @ log[-1][1]
    drift = wheels.distance(log[0][2].inverse() @ log[-1][2])
    return Figures(
        math.sqrt(float(np.mean(np.square(errors)))),
        max(errors),
        float(gaps.mean()),
        float((gaps > _ASTRAY).mean()),
        drift,
    )
