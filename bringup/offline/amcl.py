"""`nav --offline`: AMCL on a recording and a map; trajectory, report and picture into a folder."""

from __future__ import annotations

import argparse
import importlib
import json
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.config import load
from arjuna_core.errors import InputFileError
from arjuna_core.files.maps import load_map
from arjuna_core.se2 import SE2
from bringup.offline.files import Count, make_folder, tum
from bringup.parameters.files import for_node, load_parameters, merged, shipped_parameters
from bringup.viewing.pictures import draw_path

_NODE = "amcl"
_SPREAD = np.diag([0.25, 0.25, 0.0685])  # of the initial pose, as RViz's [m^2, m^2, rad^2]
ARTIFACTS = ("trajectory.tum", "report.json", "plot.png")


def run(arguments: argparse.Namespace) -> str:
    """Localize the robot of a recording on a map and write where it was.

    It starts at `initial_pose` where `set_initial_pose` is on, else anywhere.

    Args:
        arguments: What `cli_parser.parse` returned.

    Returns:
        The report as text.

    Raises:
        ArjunaError: An input cannot be used, or the folder not be written.
    """
    offline = importlib.import_module("arjuna_slam.offline")
    replay = importlib.import_module("arjuna_slam.amcl.replay")
    config = _config(arguments.params)
    topics = offline.RecordingTopics(
        arguments.scan_topic or "",
        arguments.odom_topic or "",
        config.odom_frame_id,
        config.base_frame_id,
    )
    log = offline.open_log(arguments.offline, topics)
    grid = load_map(arguments.map)
    belief = _started(config, grid, arguments.seed or 0)
    make_folder(arguments.out)
    count = Count(log)
    start, cpu = time.monotonic(), time.process_time()
    fixes = replay.replay(belief, count)
    spent = time.monotonic() - start, time.process_time() - cpu
    if not fixes:
        raise InputFileError(arguments.offline, f"none of its {count.scans} scans can be used")
    report = _report(arguments, fixes, count, spent)
    _write(arguments.out, grid, fixes, report)
    return _summary(arguments.out, report, log.problems)


def _config(paths: list[Path]) -> Any:
    cls = importlib.import_module("arjuna_slam.amcl_node_config").AmclNodeConfig
    parameters = merged(shipped_parameters(), load_parameters(paths))
    return load(cls, for_node(parameters, _NODE), _NODE)


def _started(config: Any, grid: Any, seed: int) -> Any:
    module = importlib.import_module("arjuna_slam.amcl.filter")
    belief = module.ParticleFilter(config, grid, np.random.default_rng(seed))
    if config.set_initial_pose:
        at = config.initial_pose
        belief.set_pose(SE2(at.x, at.y, at.yaw), _SPREAD)
    else:
        belief.globalize()
    return belief


def _report(
    arguments: argparse.Namespace, fixes: list[Any], count: Count, spent: tuple[float, float]
) -> dict[str, Any]:
    states = Counter(fix.status.value for fix in fixes)
    points = np.array([(fix.T_map_base.x, fix.T_map_base.y) for fix in fixes])
    return {
        "input": str(arguments.offline),
        "map": str(arguments.map),
        "scans": count.scans,
        "log_s": count.seconds,
        "time_s": spent[0],
        "cpu_s": spent[1],
        "realtime_factor": count.seconds / max(spent[0], 1e-9),
        "path_length_m": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        "quality": float(np.mean([fix.quality for fix in fixes])),
        "scans_by_status": dict(sorted(states.items())),
    }


def _write(out: Path, grid: Any, fixes: list[Any], report: dict[str, Any]) -> None:
    lines = [tum((fix.stamp, fix.T_map_base)) for fix in fixes]
    try:
        (out / ARTIFACTS[0]).write_text("".join(lines), encoding="ascii")
        (out / ARTIFACTS[1]).write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
        draw_path(out / ARTIFACTS[2], grid, np.array([fix.T_map_base.array() for fix in fixes]))
    except OSError as error:
        raise InputFileError(out, f"cannot be written: {error.strerror}") from error


def _summary(out: Path, report: dict[str, Any], problems: list[str]) -> str:
    states = ", ".join(f"{n} {state}" for state, n in report["scans_by_status"].items())
    rows = [
        ("scans", f"{report['scans']}: {states}"),
        ("quality", f"{report['quality']:.2f} in the mean"),
        ("path", f"{report['path_length_m']:.1f} m in {report['log_s']:.0f} s"),
        ("speed", f"{report['realtime_factor']:.0f} x real time ({report['time_s']:.1f} s)"),
        *(("note", problem) for problem in problems),
        ("artifacts", f"{out}: {', '.join(ARTIFACTS)}"),
    ]
    return "\n".join([f"amcl, {report['input']}", *(f"  {a:11}{b}" for a, b in rows)])
