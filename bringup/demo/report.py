"""The demo's report: its figures as JSON and as one screen of text."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.grid import OccupancyGrid
from arjuna_core.se2 import SE2
from bringup.demo.measures import Samples, explored_fraction, map_error

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
        samples: Samples,
        exploration_done: bool,
        grid: OccupancyGrid,
        surfaces: NDArray[np.float64],
        seed: int,
        wall_time: float,
        kidnap_recovered: bool | None,
        kidnap_recovery_s: float | None,
    ) -> Report:
        """Work out a run's figures."""
        position, heading = samples.localization_rmse()
        sim_time = float(samples.table[-1, 0])
        return Report(
            seed=seed,
            exploration_done=exploration_done,
            waypoints_total=len(samples.goals),
            waypoints_reached=sum(reached for *_, reached in samples.goals),
            kidnap_recovered=kidnap_recovered,
            kidnap_recovery_s=kidnap_recovery_s,
            missed=tuple(samples.missed),
            collisions=samples.collisions,
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
    def success(self) -> bool:
        """True if the robot did all that it was asked to, without touching anything."""
        return (
            self.waypoints_reached == self.waypoints_total
            and not self.missed
            and self.kidnap_recovered is not False
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
            f"{np.degrees(report.localization_rmse_rad):.2f} deg RMSE",
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
