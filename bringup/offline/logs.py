"""`slam --offline`, `nav --offline`: a log's trajectory, report and picture into a folder."""

from __future__ import annotations

import argparse
import json
import math
import resource
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.files.maps import save_map
from arjuna_core.files.whole_file import emptied_folder, writing
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.logs.log import Log
from arjuna_slam.offline import MappedLog, localize_log, map_log
from bringup.parameters.checking import merged_sources, write_remarks
from bringup.parameters.files import for_node, merged
from bringup.parameters.sources import of_names, originals_of
from bringup.stack import STACKS
from bringup.terminal import Bar
from bringup.viewing.pictures import draw_snapshot
from bringup.viewing.snapshot import Snapshot

Trajectory = list[tuple[float, SE2]]
_ARTIFACTS = "trajectory.tum", "report.json", "plot.png"


def run_slam(arguments: argparse.Namespace) -> str:
    """Run SLAM over a log, write its results and return the report as text.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    progress = _Progress(arguments.out)
    mapped = map_log(
        arguments.offline,
        _parameters(arguments, "slam_toolbox"),
        scan_topic=arguments.scan_topic or "",
        odom_topic=arguments.odom_topic or "",
        relations=arguments.relations,
        watch=progress.watch,
    )
    frame = mapped.grid.frame
    report = {
        **progress.report(arguments.offline, mapped.trajectory),
        **mapped.counts,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        **_relations(mapped),
        "map": {"width": frame.width, "height": frame.height, "resolution": frame.resolution},
    }
    save_map(mapped.grid, arguments.out / "map")
    rows = [
        ("scans", f"{report['scans']}, {report['scans_skipped']} skipped"),
        ("keyframes", f"{report['keyframes']}, {report['closures']} loop edges"),
        ("map", f"{frame.width} x {frame.height} cells"),
    ]
    if mapped.error is not None:
        metres, degrees = mapped.error.translation[0], math.degrees(mapped.error.rotation[0])
        rows.append(("relations", f"{metres:.4f} m, {degrees:.3f} deg mean error"))
    _write(arguments.out, report, mapped.grid, mapped.trajectory)
    made = f"{arguments.out}: {', '.join(('map.pgm', 'map.yaml', *_ARTIFACTS))}"
    return _summary(f"slam, {arguments.offline}", report, rows, mapped.problems, made)


def run_amcl(arguments: argparse.Namespace) -> str:
    """Localize a log's robot on a map, write the results and return the report as text.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    progress = _Progress(arguments.out)
    localized = localize_log(
        arguments.offline,
        arguments.map,
        _parameters(arguments, "amcl"),
        scan_topic=arguments.scan_topic or "",
        odom_topic=arguments.odom_topic or "",
        seed=arguments.seed or 0,
        watch=progress.watch,
    )
    trajectory = [(fix.stamp, fix.T_map_base) for fix in localized.fixes]
    states = Counter(fix.status.value for fix in localized.fixes)
    report = {
        **progress.report(arguments.offline, trajectory),
        "map": str(arguments.map),
        "quality": float(np.mean([fix.quality for fix in localized.fixes])),
        "scans_by_status": dict(sorted(states.items())),
    }
    counts = ", ".join(f"{n} {state}" for state, n in sorted(states.items()))
    rows = [
        ("scans", f"{report['scans']}: {counts}"),
        ("quality", f"{report['quality']:.2f} in the mean"),
    ]
    _write(arguments.out, report, localized.grid, trajectory)
    made = f"{arguments.out}: {', '.join(_ARTIFACTS)}"
    return _summary(f"amcl, {arguments.offline}", report, rows, localized.problems, made)


def _parameters(arguments: argparse.Namespace, node: str) -> dict[str, Any]:
    read = merged_sources(
        arguments.params,
        arguments.param,
        arguments.namespace,
        arguments.strict,
        originals_of(vars(arguments)),
    )
    write_remarks(read.remarks)
    named = of_names(vars(arguments), STACKS[arguments.command], read.parameters)
    return dict(for_node(merged(read.parameters, named), node))


class _Progress:
    """Counts a log's scans and their time, and shows the share; the first makes the folder."""

    def __init__(self, out: Path) -> None:
        self._out = out
        self._scans = 0
        self._seconds = 0.0

    def watch(self, log: Log) -> Iterator[tuple[Scan, SE2]]:
        """Yield a log's scans and odometry."""
        emptied_folder(self._out)
        self._start = time.monotonic(), time.process_time()
        bar, first = Bar(sys.stderr), None
        for scan, odometry in log:
            first = scan.stamp if first is None else first
            self._scans += 1
            self._seconds = max(self._seconds, scan.stamp - first)
            yield scan, odometry
            bar.show(log.progress, f"{self._scans} scans")
        bar.finish(f"{self._scans} scans")

    def report(self, path: Path, trajectory: Trajectory) -> dict[str, Any]:
        """Return the part of a report that both have."""
        spent = time.monotonic() - self._start[0]
        points = np.array([(pose.x, pose.y) for _, pose in trajectory])
        return {
            "input": str(path),
            "scans": self._scans,
            "log_s": self._seconds,
            "time_s": spent,
            "cpu_s": time.process_time() - self._start[1],
            "realtime_factor": self._seconds / max(spent, 1e-9),
            "path_length_m": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        }


def _write(out: Path, report: dict[str, Any], grid: OccupancyGrid, trajectory: Trajectory) -> None:
    with writing(out):
        (out / _ARTIFACTS[0]).write_text("".join(map(_tum, trajectory)), encoding="ascii")
        (out / _ARTIFACTS[1]).write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        path = [(pose.x, pose.y) for _, pose in trajectory]
        found = Snapshot(grid=grid, believed=path, robot=trajectory[-1][1])
        draw_snapshot(out / _ARTIFACTS[2], found, "Map and trajectory", leap=math.inf)


def _tum(entry: tuple[float, SE2]) -> str:
    """Return stamp [s] and pose as a line `time x y z qx qy qz qw`."""
    stamp, pose = entry
    z, w = math.sin(0.5 * pose.theta), math.cos(0.5 * pose.theta)
    return f"{stamp:.6f} {pose.x:.6f} {pose.y:.6f} 0 0 0 {z:.9f} {w:.9f}\n"


def _summary(
    title: str, report: dict[str, Any], rows: list[tuple[str, str]], problems: list[str], out: str
) -> str:
    lines = [
        *rows,
        ("path", f"{report['path_length_m']:.1f} m in {report['log_s']:.0f} s"),
        ("speed", f"{report['realtime_factor']:.0f} x real time ({report['time_s']:.1f} s)"),
        *(("note", problem) for problem in problems),
        ("artifacts", out),
    ]
    return "\n".join([title, *(f"  {a:11}{b}" for a, b in lines)])


def _relations(mapped: MappedLog) -> dict[str, dict[str, float]]:
    error = mapped.error
    if error is None:
        return {}
    rotation = [math.degrees(value) for value in error.rotation]
    names = "translation_m", "translation_sd_m", "rotation_deg", "rotation_sd_deg", "count"
    values = *error.translation, *rotation, error.count
    return {"relations": dict(zip(names, values, strict=True))}
