"""Plans on large maps, NavFn beside its array version in C, and MovingAI's maps."""

from __future__ import annotations

import argparse
import lzma
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import InputFileError
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import SE2, wrap
from arjuna_nav.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.planners import NavFn, NavFnConfig, Planner, PlanStatus
from arjuna_nav.planners import path as paths
from arjuna_nav.planners.hybrid.config import HybridConfig, SmacLatticeConfig
from arjuna_nav.planners.hybrid.lattice import SmacLattice
from arjuna_nav.planners.hybrid.planner import Hybrid
from arjuna_nav.planners.smac_2d import Smac2D, Smac2DConfig
from arjuna_nav.planners.theta_star import ThetaStar, ThetaStarConfig
from tests.helpers.nav.navfn_maps import COURSES, RESOLUTION, ROBOT_RADIUS, rooms
from tests.helpers.nav.navfn_peer import ArrayNavFn, compiled

_FREE = frozenset(b".GS")
PLANNERS: dict[str, Planner] = {
    "NavFn": NavFn(NavFnConfig()),
    "NavFn, A*": NavFn(NavFnConfig(use_astar=True)),
    "Theta*": ThetaStar(ThetaStarConfig()),
    "Smac 2D": Smac2D(Smac2DConfig(max_iterations=0)),
    "Smac Hybrid-A*": Hybrid(HybridConfig(), Footprint.circle(ROBOT_RADIUS)),
    "Smac lattice": SmacLattice(SmacLatticeConfig(), Footprint.circle(ROBOT_RADIUS)),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--sizes", type=int, nargs="*", default=[1000, 2000], metavar="N", help="edges of maps"
    )
    parser.add_argument("--repeats", type=int, default=5, help="the best of them (%(default)s)")
    parser.add_argument("--maps", type=int, default=2, help="random maps a size (%(default)s)")
    parser.add_argument(
        "--arrays", type=int, default=7, help="repeats beside NavFn in C; 0: none (%(default)s)"
    )
    parser.add_argument(
        "--queries", type=int, default=20, help="of 18 m, to Hybrid-A*; 0: none (%(default)s)"
    )
    parser.add_argument(
        "--scenarios", type=Path, metavar="DIR", help="a folder of MovingAI's .map and .scen files"
    )
    parser.add_argument(
        "--limit", type=int, default=50, help="scenarios of each file, evenly (%(default)s)"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time every planner on every map.

    Returns:
        For each planner and size the time of the processor [ms] and the length by that of the first
        planner; for the scenarios how many were solved and the length by the octile optimum.
    """
    result: dict[str, Any] = {}
    for size in arguments.sizes:
        rows = [_large(size, seed, arguments.repeats) for seed in range(arguments.maps)]
        for name in PLANNERS:
            worst = max(row[name][0] for row in rows)
            ratio = max(row[name][1] / next(iter(row.values()))[1] for row in rows)
            result[f"{name} {size}"] = {"ms": worst, "length_ratio": ratio}
            print(f"{name:18}{size:6} x {size:<6}{worst:8.1f} ms   length x {ratio:.4f}")
    if arguments.arrays > 0:
        result["arrays"] = against_arrays(arguments.arrays)
    for model in ("DUBIN", "REEDS_SHEPP") if arguments.queries else ():
        result[model] = _hybrid(model, arguments.queries)
    if arguments.scenarios is not None:
        for name, planner in PLANNERS.items():
            result[name] = _scenarios(name, planner, arguments.scenarios, arguments.limit)
    return result


def against_arrays(repeats: int) -> dict[str, dict[str, float]]:
    """Time NavFn on nine maps, in turn with its array version in C; none without a compiler.

    Returns:
        For each map the median times of the processor [ms], their ratio, and the lengths [m].
    """
    library, result = compiled(), {}
    if library is None:
        print("NavFn by arrays: no C compiler")
        return {}
    for name, make in COURSES.items():
        course = make()
        planner = NavFn(NavFnConfig(use_astar=course.astar))
        peer = ArrayNavFn(library, course.costmap.data.shape)
        ends = [SE2(*course.costmap.frame.to_point(*c)) for c in (course.start, course.goal)]
        cells = course.start, course.goal, course.astar
        times, path, other = [], np.empty((0, 3)), np.empty((0, 2))
        for _ in range(repeats + 1):
            before = time.process_time()
            path = planner.plan(course.costmap, *ends).path
            between = time.process_time()
            other = peer.plan(course.costmap.data, *cells)
            times.append((between - before, time.process_time() - between))
        peer.close()
        ours, theirs = (1e3 * float(t) for t in np.median(times[1:], axis=0))
        lengths = [float(np.hypot(*np.diff(p[:, :2], axis=0).T).sum()) for p in (path, other)]
        row = {"ms": ours, "arrays_ms": theirs, "ratio": ours / theirs}
        result[name] = {**row, "m": lengths[0], "arrays_m": lengths[1] * RESOLUTION}
        print(
            f"{name:18}{ours:8.2f} ms, arrays in C {theirs:8.2f} ms: {ours / theirs:5.2f}"
            f"   {lengths[0]:8.1f} m, {lengths[1] * RESOLUTION:8.1f} m"
        )
    return result


def _hybrid(model: str, queries: int, size: int = 1000, cells: int = 360) -> dict[str, float]:
    """Time Hybrid-A* from pose to pose 18 m off through rooms; compare its turns with Theta*'s."""
    costmap, rng, robot = rooms(size, 0), np.random.default_rng(5), Footprint.circle(ROBOT_RADIUS)
    planner = Hybrid(HybridConfig(motion_model_for_search=model), robot)
    theta_star = ThetaStar(ThetaStarConfig())
    free = np.argwhere(costmap.data < 100)
    spent: list[float] = []
    turns: list[float] = []
    direct: list[float] = []
    while len(spent) < queries:
        start = free[rng.integers(len(free))]
        far = free[np.abs(np.hypot(*(free - start).T) - cells) < 3]
        ends = start, far[rng.integers(len(far))] if len(far) else start
        poses = [
            SE2(*costmap.frame.to_point(*map(int, end)), rng.uniform(-math.pi, math.pi))
            for end in ends
        ]
        straight = theta_star.plan(costmap, *poses)
        planned = planner.plan(costmap, *poses)  # compiles, the first time
        if planned.status != PlanStatus.SUCCEEDED or paths.length(straight.path) > 25.0:
            continue
        before = time.process_time()
        planner.plan(costmap, *poses)
        spent.append(1e3 * (time.process_time() - before))
        turns.append(float(np.abs(wrap(np.diff(planned.path[:, 2]))).sum()))
        direct.append(float(np.abs(wrap(np.diff(straight.path[:, 2]))).sum()))
    row = {"ms": float(np.median(spent)), "p90_ms": float(np.percentile(spent, 90))}
    row |= {"turns_rad": float(np.mean(turns)), "theta_star_turns_rad": float(np.mean(direct))}
    print(f"{model:18}18 m: " + "   ".join(f"{key} {value:.2f}" for key, value in row.items()))
    return row


def _large(size: int, seed: int, repeats: int) -> dict[str, tuple[float, float]]:
    """Return each planner's best time [ms] and length [m] from the first corner to the last."""
    costmap = rooms(size, seed)
    edge = size * RESOLUTION
    start, goal = SE2(0.5, 0.5), SE2(edge - 0.5, edge - 0.5)
    rows = {}
    for name, planner in PLANNERS.items():
        spent, result = math.inf, planner.plan(costmap, start, goal)
        if result.status is not PlanStatus.SUCCEEDED:
            raise InputFileError(Path(f"seed {seed}"), f"{name} found no path: {result.message}")
        for _ in range(repeats):
            before = time.process_time()
            planner.plan(costmap, start, goal)
            spent = min(spent, time.process_time() - before)
        rows[name] = spent * 1e3, paths.length(result.path)
    return rows


@dataclass(frozen=True)
class Scenario:
    """One query of MovingAI.

    Attributes:
        start: In cells, x right and y down.
        goal: As `start`.
        optimal: Length of the octile optimum [cells].
    """

    map: Path
    start: tuple[int, int]
    goal: tuple[int, int]
    optimal: float


def read_map(path: Path) -> NDArray[np.bool_]:
    """Return the free cells of a MovingAI map, `(height, width) bool`, row 0 at its top.

    Raises:
        InputFileError: It is no such map.
    """
    lines = _text(path).splitlines()
    if len(lines) < 4 or not lines[0].startswith("type"):
        raise InputFileError(path, "is no MovingAI map; valid: type, height, width, map, rows")
    height, width = int(lines[1].split()[1]), int(lines[2].split()[1])
    rows = [[ord(c) in _FREE for c in line] for line in lines[4 : 4 + height]]
    return np.array(rows, dtype=np.bool_).reshape(height, width)


def read_scenarios(path: Path) -> list[Scenario]:
    """Return the queries of a `.map.scen` file, whose map lies beside it."""
    found = []
    beside = path.with_name(path.name.replace(".map.scen", ".map"))
    for line in filter(str.strip, _text(path).splitlines()[1:]):
        *ends, optimal = line.split()[-5:]
        x0, y0, x1, y1 = map(int, ends)
        found.append(Scenario(beside, (x0, y0), (x1, y1), float(optimal)))
    return found


def _text(path: Path) -> str:
    data = path.read_bytes()
    return (lzma.decompress(data) if path.suffix == ".xz" else data).decode("ascii")


def _queries(folder: Path, limit: int) -> Iterator[tuple[Costmap, Scenario]]:
    files = sorted((*folder.rglob("*.map.scen"), *folder.rglob("*.map.scen.xz")))
    if not files:
        raise InputFileError(folder, "holds no scenarios; valid: NAME.map.scen[.xz], NAME.map[.xz]")
    for path in files:
        scenarios = read_scenarios(path)
        free = read_map(scenarios[0].map)
        data = np.where(free, 0, 254).astype(np.uint8)
        costmap = Costmap(GridFrame(1.0, free.shape[1], free.shape[0]), data)
        for k in np.unique(np.linspace(0, len(scenarios) - 1, limit).astype(int)):
            yield costmap, scenarios[k]


def _scenarios(name: str, planner: Planner, folder: Path, limit: int) -> dict[str, float]:
    """Solve scenarios; print and return how many, how long and how fast."""
    solved, count, length, optimal, spent, worst = 0, 0, 0.0, 0.0, 0.0, 0.0
    for costmap, one in _queries(folder, limit):
        count += 1
        start, goal = (SE2(x + 0.5, y + 0.5) for x, y in (one.start, one.goal))
        before = time.process_time()
        result = planner.plan(costmap, start, goal)
        took = time.process_time() - before
        spent, worst = spent + took, max(worst, took)
        if result.status is PlanStatus.SUCCEEDED:
            solved += 1
            length += paths.length(result.path)
            optimal += one.optimal
    ratio = length / optimal if optimal else math.nan
    print(
        f"{name:18}{solved} of {count} scenarios   length x {ratio:.4f} of the octile optimum"
        f"   mean {spent / max(count, 1) * 1e3:.1f} ms, worst {worst * 1e3:.1f} ms"
    )
    return {
        "solved": solved,
        "scenarios": count,
        "octile_ratio": ratio,
        "mean_ms": spent / max(count, 1) * 1e3,
        "worst_ms": worst * 1e3,
    }
