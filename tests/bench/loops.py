"""Loops in made-up buildings or real logs with made-up drift: found, missed and wrong."""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_slam import offline
from arjuna_slam.graph.pose_graph import EdgeKind
from arjuna_slam.slam import Slam
from tests.helpers.building_drives import (
    LIDARS,
    Drift,
    Drive,
    agreement_of_loops,
    aligned_error,
    corrected,
    drifting,
    drive,
    errors,
    is_wrong,
    near_pairs,
    thinned,
    travelled,
)
from tests.helpers.buildings import CHOSEN_KINDS, KINDS, RESOLUTION, Building, building

_AGREE = 0.15  # [m]
_SPACINGS = (1.0, 1.0, 0.5)
_LENGTH_MIN, _LENGTH_MAX = 500.0, 5000.0  # [m]


@dataclass(frozen=True)
class Trial:
    """The map of a drive through a building.

    Attributes:
        kind: Of building, or the log's name.
        found: Those of them of which most positions agree.
        agree: Share of them that agree with the truth within 0.15 m.
        wrong: Those of them that are off by more than three deviations of what they claim.
        ate_m: Root mean square error of the positions, after alignment.
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
    parser.add_argument(
        "--count", type=int, default=5, help="buildings, or drifts of each log (%(default)s)"
    )
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
    parser.add_argument(
        "--kind", choices=[*KINDS, *CHOSEN_KINDS],
        help="of all buildings, each at least half the greatest size; without, kinds take turns",
    )  # fmt: skip
    parser.add_argument(
        "--log", type=Path, nargs="+", default=[], help="logs in place of made-up buildings"
    )
    parser.add_argument(
        "--corrected", action="store_true",
        help="the logs' poses are the truth; without, what SLAM makes of them",
    )  # fmt: skip


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map a drive through each building, or each log once a seed.

    Returns:
        `trials`, one a drive with the fields of `Trial`; of all together `agree` (share of near
        positions that agree), `agree_worst`, `wrong`, `loops`, `found` and `ate_m` (median).
    """
    print(
        "seed kind                size  length  scans  loops found  agree  closures wrong     ATE"
        "     CPU"
    )
    trials = []
    for trial in _trials(arguments):
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
        f"{100.0 * result['agree']:.2f} % of near positions agree, {100.0 * agree.min():.2f} % in "
        f"the worst; {result['found']} of {result['loops']} loops found, "
        f"{result['wrong']} closures wrong"
    )
    return result


def _trials(arguments: argparse.Namespace) -> Iterator[Trial]:
    drift = Drift().times(arguments.drift)
    seeds = range(arguments.seed, arguments.seed + arguments.count)
    if not arguments.log:
        for seed in seeds:
            yield attempt(seed, arguments.largest, arguments.length, drift, arguments.kind)
    for path in arguments.log:
        poses = thinned(corrected(path, as_is=arguments.corrected))
        for seed in seeds:
            yield measure(seed, path.name.partition(".")[0], None, drifting(poses, seed, drift))


def _row(t: Trial) -> str:
    size = f"{t.size_m[0]:.0f} x {t.size_m[1]:.0f} m"
    return (
        f"{t.seed:4} {t.kind:12} {size:>11} {t.length_m:5.0f} m {t.scans:6} {t.loops:6} {t.found:5}"
        f" {100.0 * t.agree:6.2f} {t.closures:9} {t.wrong:5} {t.ate_m:5.2f} m {t.cpu_s:5.1f} s"
    )


def attempt(
    seed: int, largest: float, length: float, drift: Drift, kind: str | None = None
) -> Trial:
    """Map one drive through one building.

    Args:
        seed: Of all that is random.
        largest: Share of the greatest size that the building has at most.
        length: Of the longest drive [m].
        kind: Of building; None for the one whose turn it is.
    """
    name, walls, log = case(seed, largest, length, drift, kind)
    return measure(seed, name, walls, log)


def measure(seed: int, kind: str, walls: Building | None, log: Drive) -> Trial:
    """Map one drive.

    Args:
        kind: As `Trial` names it.
        walls: Of the building; None where they are not known.
    """
    slam = Slam()
    start = time.process_time()
    trajectory = offline.run(slam, ((scan, odometry) for scan, odometry, _ in log))
    seconds = time.process_time() - start
    truth = {scan.stamp: pose for scan, _, pose in log}
    found = np.array([pose.array() for _, pose in trajectory])
    true = np.array([truth[stamp].array() for stamp, _ in trajectory])
    pairs = near_pairs(true, walls)
    good = errors(found, true, pairs) < _AGREE
    loops = agreement_of_loops(pairs, good)
    edges = [edge for edge in slam.graph.edges if edge.kind is EdgeKind.LOOP]
    nodes = [truth[stamp] for stamp, _ in slam.trajectory()]
    size = np.ptp(true[:, :2], axis=0)
    if walls is not None:
        size = RESOLUTION * np.array(walls.blocked.shape[::-1])
    return Trial(
        seed, kind, (float(size[0]), float(size[1])), travelled(true)[-1], len(log),
        len(loops), sum(share > 0.5 for share in loops), len(pairs),
        float(good.mean()) if len(pairs) else 1.0,
        len(edges), sum(is_wrong(edge, nodes) for edge in edges), slam.undone,
        aligned_error(found, true), seconds,
    )  # fmt: skip


def case(
    seed: int, largest: float, length: float, drift: Drift, kind: str | None = None
) -> tuple[str, Building, Drive]:
    """Return the kind of a building, the building and a drive through it."""
    kind, walls = building(seed, largest, kind)
    rng = np.random.default_rng([seed, 3])
    length = min(max(rng.uniform(2.0, 5.0) * walls.length, _LENGTH_MIN), _LENGTH_MAX, length)
    lidar = LIDARS[int(rng.integers(len(LIDARS)))]
    spacing = float(rng.choice(_SPACINGS))
    return kind, walls, drive(walls, seed, length, spacing, lidar, drift)
