"""SLAM on a recorded log: error against reference relations, pace, worst case and memory."""

from __future__ import annotations

import argparse
import gc
import resource
import time
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam import offline
from arjuna_slam.graph.pose_graph import EdgeKind
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.offline import evaluate, read_relations
from arjuna_slam.pose_tracker import SlamUpdate
from arjuna_slam.slam import Slam

_WARM_UP_SCANS = 300


class _TimedSlam(Slam):
    """Notes how long each scan took."""

    def __init__(self) -> None:
        super().__init__()
        self.seconds: list[float] = []

    def process(self, scan: Scan, T_odom_base: SE2, motion: SE2 | None = None) -> SlamUpdate | None:
        start = time.perf_counter()
        update = super().process(scan, T_odom_base, motion)
        self.seconds.append(time.perf_counter() - start)
        return update


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--log", type=Path, required=True, help="log: .clf or .log (also .xz, .gz, .bz2), or mcap"
    )
    parser.add_argument(
        "--relations", type=Path, help="reference relations: t1 t2 x y z roll pitch yaw a line"
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map the log with the default parameters, in one thread.

    Returns:
        `translation_m`, `translation_sd_m`, `rotation_deg`, `rotation_sd_deg` (None without
        relations); `time_s` from opening the log to the optimised trajectory, compilation left out;
        `realtime_factor`, `cpu_s`, `memory_mb` (peak of the process), `callback_*_ms` of the calls
        with one scan, `map_s` of the first map, and counts.
    """
    _warm_up(arguments.log)
    result = _map(arguments.log, arguments.relations)
    width = max(map(len, result))
    for key, value in result.items():
        print(
            f"{key:{width}}  {value:.4f}" if isinstance(value, float) else f"{key:{width}}  {value}"
        )
    return result


def _open(path: Path) -> Iterable[tuple[Scan, SE2]]:
    return open_log(path, RecordingTopics())


def _warm_up(path: Path) -> None:
    """Compile all that is compiled."""
    slam = Slam()
    offline.run(slam, islice(_open(path), _WARM_UP_SCANS))
    slam.map()


def _map(path: Path, relations: Path | None) -> dict[str, Any]:
    stamps: list[float] = []

    def entries() -> Iterator[tuple[Scan, SE2]]:
        for scan, T_odom_base in _open(path):
            stamps.append(scan.stamp)
            yield scan, T_odom_base

    gc.collect()
    slam = _TimedSlam()
    start, start_cpu = time.perf_counter(), time.process_time()
    trajectory = offline.run(slam, entries())
    seconds, cpu = time.perf_counter() - start, time.process_time() - start_cpu
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    start = time.perf_counter()
    slam.map()
    map_seconds = time.perf_counter() - start
    duration = max(stamps) - min(stamps)
    result = {
        **_errors(trajectory, relations),
        "log_s": duration,
        "time_s": seconds,
        "realtime_factor": duration / seconds,
        "cpu_s": cpu,
        "memory_mb": memory,
        "map_s": map_seconds,
    }
    return result | _callbacks(slam) | _counts(slam, len(stamps))


def _errors(trajectory: list[tuple[float, SE2]], relations: Path | None) -> dict[str, Any]:
    keys = ("translation_m", "translation_sd_m", "rotation_deg", "rotation_sd_deg", "relations")
    if relations is None:
        return dict.fromkeys(keys)
    rows = read_relations(relations)
    measured = evaluate(trajectory, rows)
    rotation = np.degrees(measured.rotation).tolist()
    return dict(zip(keys, (*measured.translation, *rotation, measured.count), strict=True))


def _callbacks(slam: _TimedSlam) -> dict[str, Any]:
    milliseconds = 1e3 * np.array(slam.seconds)
    p50, p99 = np.quantile(milliseconds, [0.5, 0.99]).tolist()
    return {
        "callback_p50_ms": p50,
        "callback_p99_ms": p99,
        "callback_worst_ms": float(milliseconds.max()),
    }


def _counts(slam: Slam, scans: int) -> dict[str, Any]:
    return {
        "scans": scans,
        "skipped": slam.scans.skipped,
        "keyframes": len(slam.graph),
        "closures": sum(edge.kind is EdgeKind.LOOP for edge in slam.graph.edges),
        "undone": slam.undone,
    }
