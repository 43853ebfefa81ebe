"""A demo's samples, and its report of figures against the truth, which the robot never sees."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import label

from arjuna_core.arrays import Floats
from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2, wrap
from bringup.viewing.snapshot import Snapshot


def distance_to_surfaces(points: Floats, surfaces: Floats, batch: int = 4096) -> Floats:
    """Return distances of points `(N, 2)` to the nearest of segments `(M, 4)` [m]."""
    chunks = [points[i : i + batch] for i in range(0, len(points), batch)]
    return np.concatenate([_nearest(chunk, surfaces) for chunk in chunks])


def _nearest(points: Floats, surfaces: Floats) -> Floats:
    start, along = surfaces[None, :, :2], (surfaces[:, 2:] - surfaces[:, :2])[None]
    offset = points[:, None] - start
    length2 = np.maximum((along**2).sum(2), 1e-12)
    ratio = np.clip((offset * along).sum(2) / length2, 0.0, 1.0)
    gaps: Floats = np.linalg.norm(offset - ratio[..., None] * along, axis=2)
    nearest: Floats = gaps.min(axis=1)
    return nearest


def map_error(grid: OccupancyGrid, surfaces: Floats) -> float:
    """Return the mean distance of occupied cells to the true segments, `(M, 4) float64` [m].

    Raises:
        ValueError: The map has no occupied cell.
    """
    cells = np.argwhere(grid.occupied())
    if len(cells) == 0:
        raise ValueError("the map has no occupied cell")
    return float(distance_to_surfaces(grid.frame.to_points(cells), surfaces).mean())


def segments_from(frame: SE2, segments: Floats) -> Floats:
    """Return segments as seen from a frame, `(M, 4) float64` [m]."""
    return frame.inverse().apply(segments.reshape(-1, 2)).reshape(-1, 4)


def explored_fraction(
    grid: OccupancyGrid, surfaces: Floats, start: SE2, resolution: float = 0.05
) -> float:
    """Return the share of the area that is truly free and connected to the start and mapped free.

    Cells within half a cell of a surface belong to neither.

    Args:
        grid: The map, in the world's frame.
        surfaces: True segments, `(M, 4) float64` [m].
        start: A pose in the free area.
        resolution: Edge of a cell of the truth's raster [m].
    """
    ends = np.vstack((surfaces.reshape(-1, 2), [[start.x, start.y]]))
    low = ends.min(axis=0)
    size = np.ceil((ends.max(axis=0) - low) / resolution).astype(int) + 1
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    centres = low + (np.column_stack((columns.ravel(), rows.ravel())) + 0.5) * resolution
    clear = distance_to_surfaces(centres, surfaces) > 0.75 * resolution
    regions, _ = label(clear.reshape(size[1], size[0]))
    seed = ((np.array([start.x, start.y]) - low) / resolution).astype(int)
    reachable = centres[(regions == regions[seed[1], seed[0]]).ravel()]
    cells = grid.frame.to_cells(reachable)
    inside = grid.frame.inside(cells)
    known = np.zeros(len(cells), dtype=bool)
    known[inside] = grid.free()[cells[inside, 0], cells[inside, 1]]
    return float(known.mean())


def rmse(estimates: Floats, truths: Floats) -> tuple[float, float]:
    """Return the root mean square errors of position [m] and heading [rad]."""
    difference = estimates - truths
    heading = wrap(difference[:, 2])
    position = float(np.sqrt((difference[:, :2] ** 2).sum(axis=1).mean()))
    return position, float(np.sqrt((heading**2).mean()))


@dataclass
class Samples:
    """Truth and estimate of a run, a row a tick.

    Attributes:
        rows: `time, true x, y, theta, estimated x, y, theta`; NaN where there is no estimate.
        judged: For each row whether the estimate counts as localization (after mapping and not
            between a kidnap and the recovery from it).
        stamps: For each row of when the estimate is [s]: as late as the robot's odometry comes.
        touched: What contacts with the world began with, `(names, x, y)`.
        missed: Which goals were not reached, and why; why none could be drawn.
        goals: `(x, y, yaw, reached)` in order.
    """

    rows: list[tuple[float, ...]] = field(default_factory=list)
    judged: list[bool] = field(default_factory=list)
    stamps: list[float] = field(default_factory=list)
    touched: list[tuple[str, float, float]] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    goals: list[tuple[float, float, float, bool]] = field(default_factory=list)
    _touching: bool = False

    def add(
        self,
        now: float,
        truth: SE2,
        estimate: SE2 | None,
        contacts: Any,
        judge: bool,
        stamp: float | None = None,
    ) -> None:
        """Add the sample of a tick [s]; the estimate is of a stamp [s], of now if None."""
        self.stamps.append(now if stamp is None else stamp)
        guess = (np.nan,) * 3 if estimate is None else (estimate.x, estimate.y, estimate.theta)
        self.rows.append((now, truth.x, truth.y, truth.theta, *guess))
        self.judged.append(judge and estimate is not None)
        touching = len(contacts) > 0
        if touching and not self._touching:
            self.touched.append((", ".join(sorted(contacts)), truth.x, truth.y))
        self._touching = touching

    @property
    def table(self) -> Floats:
        """The rows as `(N, 7) float64`."""
        return np.array(self.rows, dtype=np.float64).reshape(-1, 7)

    def snapshot(self, grid: OccupancyGrid) -> Snapshot:
        """Return the run's paths, goals and touches on a map, as they are drawn."""
        return Snapshot(
            grid=grid,
            true=[(row[1], row[2]) for row in self.rows],
            believed=[(row[4], row[5]) for row in self.rows],
            goals=[SE2(*goal[:3]) for goal in self.goals],
            missed=frozenset(n for n, goal in enumerate(self.goals, 1) if not goal[3]),
            touches=[SE2(x, y) for _, x, y in self.touched],
        )

    def sha256(self) -> str:
        """Return a digest of every sample's bytes."""
        return hashlib.sha256(self.table.tobytes()).hexdigest()

    def path_length(self) -> float:
        """Return the length of the true path [m], leaps of a kidnap left out."""
        steps = np.linalg.norm(np.diff(self.table[:, 1:3], axis=0), axis=1)
        return float(steps[steps < 0.1].sum())

    def localization_rmse(self, same_time: float = 1e-6) -> tuple[float, float]:
        """Return the root mean square errors [m], [rad] of the judged samples.

        Each is compared with where the robot was at the estimate's stamp: odometry of 10 Hz is up
        to 0.1 s old, in which a robot turns by degrees. Stamps closer than
        `same_time` [s] are equal.
        """
        table, judged = self.table, np.array(self.judged, dtype=bool)
        dated = np.searchsorted(table[:, 0], np.array(self.stamps)[judged] - same_time)
        return rmse(table[judged, 4:7], table[np.minimum(dated, len(table) - 1), 1:4])


REACHED_WITHIN = 0.25  # nav2's xy_goal_tolerance, judged by the truth [m]
ARTIFACTS = ("map.pgm", "map.yaml", "map.png", "trajectory.png", "run.mcap", "report.json")


@dataclass(frozen=True)
class Report:
    """The figures of one run; lengths [m], angles [rad], times [s]."""

    seed: int
    exploration_done: bool
    waypoints_total: int
    waypoints_reached: int
    kidnap_recovered: bool | None
    kidnap_recovery_s: float | None
    missed: tuple[str, ...]
    collisions: int
    touched: tuple[str, ...]
    localization_rmse_m: float
    localization_rmse_rad: float
    map_error_m: float | None
    explored_fraction: float
    path_length_m: float
    sim_time_s: float
    wall_time_s: float
    real_time_factor: float
    trajectory_sha256: str
    artifacts: tuple[str, ...] = ARTIFACTS

    @staticmethod
    def of(
        samples: Samples, grid: OccupancyGrid, surfaces: Floats, wall_time: float, **facts: Any
    ) -> Report:
        """Work out a run's figures; the fields that follow from none of these are given."""
        position, heading = samples.localization_rmse()
        sim_time = float(samples.table[-1, 0])
        return Report(
            **facts,
            waypoints_total=len(samples.goals),
            waypoints_reached=sum(reached for *_, reached in samples.goals),
            missed=tuple(samples.missed),
            collisions=len(samples.touched),
            touched=tuple(f"{name} at ({x:.2f}, {y:.2f})" for name, x, y in samples.touched),
            localization_rmse_m=position,
            localization_rmse_rad=heading,
            map_error_m=map_error(grid, surfaces) if grid.occupied().any() else None,
            explored_fraction=explored_fraction(
                grid, surfaces, SE2.from_array(samples.table[0, 1:4])
            ),
            path_length_m=samples.path_length(),
            sim_time_s=sim_time,
            wall_time_s=wall_time,
            real_time_factor=sim_time / wall_time,
            trajectory_sha256=samples.sha256(),
        )

    @property
    def lost(self) -> bool:
        """True if the robot's word about its place was off by more than a goal may be."""
        return self.localization_rmse_m > REACHED_WITHIN

    @property
    def success(self) -> bool:
        """True if the robot did all that it was asked to, knew its place, and touched nothing."""
        return (
            self.waypoints_reached == self.waypoints_total
            and not self.missed
            and self.kidnap_recovered is not False
            and not self.lost
            and self.collisions == 0
        )


def write_report(folder: Path, report: Report) -> None:
    """Write `report.json` into a folder."""
    text = json.dumps({"success": report.success, **dataclasses.asdict(report)}, indent=2)
    (folder / "report.json").write_text(text + "\n", encoding="utf-8")


def summary(folder: Path, report: Report) -> str:
    """Return the report as one screen of text."""
    error = math.nan if report.map_error_m is None else 100.0 * report.map_error_m
    reached = f"{report.waypoints_reached} of {report.waypoints_total} reached"
    ended = "" if report.exploration_done else ", then its time was over"
    rows = (
        ("explored", f"{100.0 * report.explored_fraction:.1f} % of the free area{ended}"),
        ("map error", f"{error:.1f} cm, mean distance to true surfaces"),
        ("waypoints", "; ".join((reached, *report.missed))),
        ("kidnap", _kidnap(report)),
        ("collisions", "; ".join((f"{report.collisions}", *report.touched))),
        (
            "localization",
            f"{100.0 * report.localization_rmse_m:.1f} cm, "
            f"{np.degrees(report.localization_rmse_rad):.2f} deg RMSE"
            + (f": more than {100.0 * REACHED_WITHIN:g} cm, lost" if report.lost else ""),
        ),
        ("driven", f"{report.path_length_m:.1f} m in {report.sim_time_s:.0f} s of simulated time"),
        ("speed", f"{report.real_time_factor:.1f} x real time ({report.wall_time_s:.0f} s)"),
        ("artifacts", f"{folder}: {', '.join(report.artifacts)}"),
    )
    verdict = "SUCCESS" if report.success else "FAILED"
    return "\n".join([f"demo, seed {report.seed}: {verdict}", *(f"  {a:13}{b}" for a, b in rows)])


def _kidnap(report: Report) -> str:
    if report.kidnap_recovered is None:
        return "not tried"
    recovery = report.kidnap_recovery_s
    after = f"after {recovery:.1f} s" if recovery is not None else "never"
    return f"found itself {after}" + (", drove home" if report.kidnap_recovered else "")
