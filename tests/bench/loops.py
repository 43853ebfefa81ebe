"""Loops in made-up buildings with made-up drift: how many are closed, and how many wrongly."""

from __future__ import annotations

import argparse
import dataclasses
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arjuna_core.raycast import cast
from arjuna_core.se2 import SE2
from arjuna_slam import offline
from arjuna_slam.graph.pose_graph import Edge, EdgeKind
from arjuna_slam.slam import Slam
from tests.helpers.building_drives import LIDARS, Drift, Drive, drive
from tests.helpers.buildings import RESOLUTION, Building, building

_NEAR, _APART = 1.5, 20.0  # two places near each other, and the way between two visits [m]
_AGREE = 0.15  # [m]
_RUN_GAP = 5  # scans that see no place again without ending a loop
_SLACK = np.diag([0.1**2, 0.1**2, 0.03**2])  # on top of what a closure claims of itself
_DEVIATIONS = 3.0
_SPACINGS = (1.0, 1.0, 0.5)
_LENGTH_MIN, _LENGTH_MAX = 500.0, 5000.0  # [m]


@dataclass(frozen=True)
class Trial:
    """How a drive through a building was mapped.

    Attributes:
        seed: Of the building and the drive.
        kind: Of building.
        size_m: Of it.
        length_m: Of the drive.
        scans: Of the drive.
        loops: Stretches that see places again.
        found: Those of them of which most places agree.
        pairs: Near places, each seen twice.
        agree: Share of them that agree with the truth within 0.15 m.
        closures: Loop edges left in the graph.
        wrong: Those of them that are off by more than three deviations of what they claim.
        undone: Loop edges taken back.
        ate_m: Root mean square error of the positions, after alignment.
        cpu_s: Time.
    """

    seed: int
    kind: str
    size_m: tuple[float, float]
    length_m: float
    scans: int
    loops: int
    found: int
    pairs: int
    agree: float
    closures: int
    wrong: int
    undone: int
    ate_m: float
    cpu_s: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument("--count", type=int, default=5, help="buildings (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="the first's seed (%(default)s)")
    parser.add_argument(
        "--largest", type=float, default=0.4,
        help="share of 300 x 200 m that a building has at most (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--length", type=float, default=1500.0, help="longest drive, in metres (%(default)s)"
    )
    parser.add_argument(
        "--drift", type=float, default=1.0,
        help="factor on 0.02 rad per sqrt(m), 0.01 rad/m and 2 %% (%(default)s)",
    )  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map a drive through each building.

    Returns:
        `trials`, one a building with the fields of `Trial`; of all together `agree` (share of near
        places that agree), `agree_worst`, `wrong`, `loops`, `found` and `ate_m` (median).
    """
    print(
        "seed kind                size     way  scans  loops found  agree  closures wrong     ATE"
        "     CPU"
    )
    trials = []
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        trial = attempt(seed, arguments.largest, arguments.length, Drift().times(arguments.drift))
        trials.append(trial)
        print(_row(trial), flush=True)
    pairs = np.array([trial.pairs for trial in trials])
    agree = np.array([trial.agree for trial in trials])
    result: dict[str, Any] = {
        "trials": [dataclasses.asdict(trial) for trial in trials],
        "agree": float((pairs * agree).sum() / max(1, pairs.sum())),
        "agree_worst": float(agree.min()),
        "wrong": sum(trial.wrong for trial in trials),
        "loops": sum(trial.loops for trial in trials),
        "found": sum(trial.found for trial in trials),
        "ate_m": float(np.median([trial.ate_m for trial in trials])),
    }
    print(
        f"{100.0 * result['agree']:.2f} % of near places agree, {100.0 * agree.min():.2f} % in the "
        f"worst building; {result['found']} of {result['loops']} loops found, "
        f"{result['wrong']} closures wrong"
    )
    return result


def _row(t: Trial) -> str:
    size = f"{t.size_m[0]:.0f} x {t.size_m[1]:.0f} m"
    return (
        f"{t.seed:4} {t.kind:12} {size:>11} {t.length_m:5.0f} m {t.scans:6} {t.loops:6} {t.found:5}"
        f" {100.0 * t.agree:6.2f} {t.closures:9} {t.wrong:5} {t.ate_m:5.2f} m {t.cpu_s:5.1f} s"
    )


def attempt(seed: int, largest: float, length: float, drift: Drift) -> Trial:
    """Map one drive through one building.

    Args:
        seed: Of all that is random.
        largest: Share of the greatest size that the building has at most.
        length: Of the longest drive [m].
        drift: Of the odometry.
    """
    kind, walls, log = case(seed, largest, length, drift)
    slam = Slam()
    start = time.process_time()
    trajectory = offline.run(slam, ((scan, odometry) for scan, odometry, _ in log))
    seconds = time.process_time() - start
    truth = {scan.stamp: pose for scan, _, pose in log}
    found = np.array([pose.array() for _, pose in trajectory])
    true = np.array([truth[stamp].array() for stamp, _ in trajectory])
    pairs = near_places(true, walls)
    good = _errors(found, true, pairs) < _AGREE
    loops = _loops(pairs, good)
    edges = [edge for edge in slam.graph.edges if edge.kind is EdgeKind.LOOP]
    nodes = [truth[stamp] for stamp, _ in slam.trajectory()]
    height, width = walls.blocked.shape
    return Trial(
        seed, kind, (width * RESOLUTION, height * RESOLUTION), _travel(true)[-1], len(log),
        len(loops), sum(share > 0.5 for share in loops), len(pairs),
        float(good.mean()) if len(pairs) else 1.0,
        len(edges), sum(is_wrong(edge, nodes) for edge in edges), slam.undone,
        _aligned_error(found, true), seconds,
    )  # fmt: skip


def case(seed: int, largest: float, length: float, drift: Drift) -> tuple[str, Building, Drive]:
    """Return the kind of a building, the building and a drive through it."""
    kind, walls = building(seed, largest)
    rng = np.random.default_rng([seed, 3])
    way = min(max(rng.uniform(2.0, 5.0) * walls.length, _LENGTH_MIN), _LENGTH_MAX, length)
    lidar = LIDARS[int(rng.integers(len(LIDARS)))]
    spacing = float(rng.choice(_SPACINGS))
    return kind, walls, drive(walls, seed, way, spacing, lidar, drift)


def near_places(true: NDArray[np.float64], walls: Building) -> NDArray[np.int64]:
    """Return pairs of poses near each other, in sight, with a way between them, `(P, 2)`."""
    travel = _travel(true)
    pairs = cKDTree(true[:, :2]).query_pairs(_NEAR, output_type="ndarray")
    pairs = pairs[np.abs(travel[pairs[:, 1]] - travel[pairs[:, 0]]) > _APART]
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    seen = np.array([_in_sight(true[i], true[j], walls) for i, j in pairs], np.bool_)
    visible: NDArray[np.int64] = pairs[seen]
    return visible


def _in_sight(a: NDArray[np.float64], b: NDArray[np.float64], walls: Building) -> bool:
    gap = b - a
    bearing, far = np.array([math.atan2(gap[1], gap[0])]), math.hypot(gap[0], gap[1])
    free = cast(walls.blocked, RESOLUTION, float(a[0]), float(a[1]), bearing, far)[0]
    return bool(free >= far)


def _travel(true: NDArray[np.float64]) -> NDArray[np.float64]:
    steps = np.hypot(*np.diff(true[:, :2], axis=0).T)
    return np.concatenate(([0.0], np.cumsum(steps)))


def _errors(
    found: NDArray[np.float64], true: NDArray[np.float64], pairs: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return how far off the second of each pair is as seen from the first, `(P,)` [m]."""
    seen = []
    for poses in (found, true):
        first, second = poses[pairs[:, 0]], poses[pairs[:, 1]]
        c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
        dx, dy = (second - first)[:, :2].T
        seen.append(np.array([c * dx + s * dy, c * dy - s * dx]))
    error: NDArray[np.float64] = np.hypot(*(seen[0] - seen[1]))
    return error


def _loops(pairs: NDArray[np.int64], good: NDArray[np.bool_]) -> list[float]:
    """Return the share of agreeing pairs of each stretch that sees places again."""
    return [float(good[k].mean()) for k in _stretches(pairs)]


def _stretches(pairs: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    if len(pairs):
        breaks = np.flatnonzero(np.diff(pairs[:, 1]) > _RUN_GAP) + 1
        yield from np.split(np.arange(len(pairs)), breaks)


def is_wrong(edge: Edge, truth: list[SE2]) -> bool:
    """Tell whether a closure is off by more than it says of itself, and some slack."""
    true = truth[edge.i].inverse() @ truth[edge.j]
    error = edge.T_i_j.array() - true.array()
    error[2] = math.remainder(error[2], 2.0 * math.pi)
    claimed = np.linalg.inv(edge.information) + _SLACK
    return bool(error @ np.linalg.solve(claimed, error) > _DEVIATIONS**2)


def _aligned_error(found: NDArray[np.float64], true: NDArray[np.float64]) -> float:
    """Return the root mean square error of positions after the best rigid alignment [m]."""
    a, b = (complex_poses - complex_poses.mean() for complex_poses in map(_complex, (found, true)))
    turn = np.vdot(a, b)
    return float(np.sqrt(np.mean(np.abs(a * turn / max(abs(turn), 1e-12) - b) ** 2)))


def _complex(poses: NDArray[np.float64]) -> NDArray[np.complex128]:
    places: NDArray[np.complex128] = poses[:, 0] + 1j * poses[:, 1]
    return places
