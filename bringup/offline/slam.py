"""`slam --offline`: SLAM on a log; map, trajectory, report and picture into a folder."""

from __future__ import annotations

import argparse
import importlib
import json
import math
import resource
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.config import load
from arjuna_core.errors import InputFileError
from arjuna_core.files.maps import save_map
from bringup.offline.files import Count, make_folder, tum
from bringup.parameters.files import for_node, load_parameters, merged, shipped_parameters
from bringup.viewing.pictures import draw_path

_NODE = "slam_toolbox"


def run(arguments: argparse.Namespace) -> str:
    """Run SLAM over a log and write its results.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The report as text.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    slam, offline = (importlib.import_module(f"arjuna_slam.{name}") for name in ("slam", "offline"))
    config = _config(arguments.params)
    topics = offline.RecordingTopics(
        arguments.scan_topic or "", arguments.odom_topic or "", config.odom_frame, config.base_frame
    )
    log = offline.open_log(arguments.offline, topics)
    relations = _relations(arguments.relations)
    make_folder(arguments.out)
    mapper = slam.Slam(config)
    count = Count(log)
    start, cpu = time.monotonic(), time.process_time()
    trajectory = offline.run(mapper, count)
    mapper.map()
    spent = time.monotonic() - start, time.process_time() - cpu
    report = _report(arguments.offline, mapper, trajectory, count, spent)
    if relations is not None:
        report["relations"] = _errors(offline, arguments.relations, trajectory, relations)
    _write(arguments.out, mapper, trajectory, report)
    return _summary(arguments.out, report, log.problems)


def _config(paths: Iterable[Path]) -> Any:
    cls = importlib.import_module("arjuna_slam.slam_node_config").SlamNodeConfig
    parameters = merged(shipped_parameters(), load_parameters(paths))
    return load(cls, for_node(parameters, _NODE), _NODE)


def _relations(path: Path | None) -> Any:
    if path is None:
        return None
    try:
        relations = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise InputFileError(path, f"cannot be read as relations: {error}") from error
    if relations.shape[1] != 8:
        problem = f"has {relations.shape[1]} columns; valid: t1 t2 x y z roll pitch yaw"
        raise InputFileError(path, problem)
    return relations


def _errors(offline: Any, path: Path, trajectory: Any, relations: Any) -> dict[str, float]:
    try:
        result = offline.evaluate(trajectory, relations)
    except ValueError as error:
        raise InputFileError(path, str(error)) from error
    return {
        "translation_m": result.translation[0],
        "translation_sd_m": result.translation[1],
        "rotation_deg": math.degrees(result.rotation[0]),
        "rotation_sd_deg": math.degrees(result.rotation[1]),
        "count": result.count,
    }


def _report(
    path: Path, mapper: Any, trajectory: Any, count: Count, spent: tuple[float, float]
) -> dict[str, Any]:
    if not trajectory:
        raise InputFileError(path, f"none of its {count.scans} scans has anything in range")
    points = np.array([(pose.x, pose.y) for _, pose in trajectory])
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {
        "input": str(path),
        "scans": count.scans,
        "scans_skipped": mapper.scans.skipped,
        "log_s": count.seconds,
        "time_s": spent[0],
        "cpu_s": spent[1],
        "realtime_factor": count.seconds / max(spent[0], 1e-9),
        "memory_mb": memory,
        "path_length_m": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        "keyframes": len(mapper.graph),
        "edges": len(mapper.graph.edges),
        "closures": sum(edge.kind.value == "loop" for edge in mapper.graph.edges),
        "closures_undone": mapper.undone,
    }


def _write(out: Path, mapper: Any, trajectory: Any, report: dict[str, Any]) -> None:
    grid = mapper.map()
    save_map(grid, out / "map")
    report["map"] = {
        "width": grid.frame.width, "height": grid.frame.height, "resolution": grid.frame.resolution
    }  # fmt: skip
    try:
        (out / "trajectory.tum").write_text("".join(map(tum, trajectory)), encoding="ascii")
        (out / "report.json").write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        draw_path(out / "plot.png", grid, np.array([pose.array() for _, pose in trajectory]))
    except OSError as error:
        raise InputFileError(out, f"cannot be written: {error.strerror}") from error


def _summary(out: Path, report: dict[str, Any], problems: list[str]) -> str:
    rows = [
        ("scans", f"{report['scans']}, {report['scans_skipped']} skipped"),
        ("keyframes", f"{report['keyframes']}, {report['closures']} loop edges"),
        ("path", f"{report['path_length_m']:.1f} m in {report['log_s']:.0f} s"),
        ("speed", f"{report['realtime_factor']:.0f} x real time ({report['time_s']:.1f} s)"),
        ("map", f"{report['map']['width']} x {report['map']['height']} cells"),
    ]
    if "relations" in report:
        error = report["relations"]
        text = f"{error['translation_m']:.4f} m, {error['rotation_deg']:.3f} deg mean error"
        rows.append(("relations", text))
    rows += [("note", problem) for problem in problems]
    rows.append(("artifacts", f"{out}: map.pgm, map.yaml, trajectory.tum, report.json, plot.png"))
    return "\n".join([f"slam, {report['input']}", *(f"  {a:11}{b}" for a, b in rows)])
