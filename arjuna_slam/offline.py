"""SLAM and AMCL on a recorded log."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.config import load
from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text
from arjuna_core.files.maps import load_map
from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2, wrap
from arjuna_slam.amcl.config import AmclNodeConfig
from arjuna_slam.amcl.estimate import Status
from arjuna_slam.amcl.filter import ParticleFilter
from arjuna_slam.config import SlamNodeConfig
from arjuna_slam.graph.pose_graph import EdgeKind
from arjuna_slam.logs.log import Log, open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.pose_tracker import Pace
from arjuna_slam.slam import Forgotten, Slam

_SPREAD = np.diag([0.25, 0.25, 0.0685])  # of the initial pose, as RViz's [m^2, m^2, rad^2]
Watch = Callable[[Log], Iterable[tuple[Scan, SE2]]]
_Placed = tuple[float, int, SE2]
"""Stamp [s] of a scan, a keyframe's number and the pose seen from it."""


@dataclass(frozen=True)
class MappedLog:
    """The result of SLAM on a log."""

    # stamp [s] and optimised pose in map of every usable scan, by stamp
    trajectory: list[tuple[float, SE2]]
    grid: OccupancyGrid  # the map
    counts: dict[str, int]  # scans skipped, keyframes, edges, closures, closures undone
    error: RelationError | None  # against the reference relations, if there are any
    problems: list[str]  # the parts of the log that were skipped


def map_log(
    path: Path,
    parameters: Mapping[str, Any],
    *,
    scan_topic: str = "",
    odom_topic: str = "",
    relations: Path | None = None,
    watch: Watch = iter,
) -> MappedLog:
    """Run SLAM over a log.

    Args:
        path: What `open_log` reads.
        parameters: Of slam_toolbox, by name.
        scan_topic: Of a recording; "" for the only one.
        odom_topic: Of a recording; "" for what /tf says.
        relations: File of reference relations to compare with.
        watch: Passes the scans on, to see how far it is.

    Raises:
        ArjunaError: An input cannot be used.
    """
    config = load(SlamNodeConfig, parameters, "slam_toolbox")
    topics = RecordingTopics(scan_topic, odom_topic, config.odom_frame, config.base_frame)
    log = open_log(path, topics)
    known = None if relations is None else read_relations(relations)
    slam, pace = Slam(config.core), Pace()
    trajectory = run(slam, watch(log), lambda *entry: pace.is_due(config, *entry))
    grid = slam.map()
    if not trajectory or grid is None:
        raise InputFileError(path, "none of its scans has anything in range")
    error = None
    if relations is not None and known is not None:
        try:
            error = evaluate(trajectory, known)
        except ValueError as problem:
            raise InputFileError(relations, str(problem)) from problem
    return MappedLog(trajectory, grid, _counts(slam), error, log.problems)


def _counts(slam: Slam) -> dict[str, int]:
    return {
        "scans_skipped": slam.scans.skipped,
        "keyframes": len(slam.graph),
        "edges": len(slam.graph.edges),
        "closures": sum(edge.kind is EdgeKind.LOOP for edge in slam.graph.edges),
        "closures_undone": slam.undone,
    }


def run(
    slam: Slam,
    log: Iterable[tuple[Scan, SE2]],
    is_due: Callable[[Scan, SE2], bool] = lambda scan, T_odom_base: True,
) -> list[tuple[float, SE2]]:
    """Feed a log and return stamp [s] and optimised pose in map of every usable scan, by stamp.

    Scans that are not due are where odometry since the last that was due has them. Loggers stamp
    some scans too early or late (the Intel log 631 of 13631): the order of the log is believed and
    the stamps given to SLAM are raised where they would step back.
    """
    placed: list[_Placed] = []
    last, latest = -math.inf, None
    for scan, T_odom_base in log:
        if not is_due(scan, T_odom_base):
            if latest is not None:
                node, T_node_odom = latest
                placed.append((scan.stamp, node, T_node_odom @ T_odom_base))
            continue
        last = max(scan.stamp, math.nextafter(last, math.inf))
        update = slam.process(replace(scan, stamp=last), T_odom_base)
        if update is None:
            continue
        if slam.forgotten is not None:
            placed = list(_on_kept(placed, slam.forgotten))
        latest = update.node, update.T_node_base @ T_odom_base.inverse()
        placed.append((scan.stamp, update.node, update.T_node_base))
    slam.finish()
    placed.sort(key=lambda entry: entry[0])
    return [(stamp, slam.graph.pose(node) @ pose) for stamp, node, pose in placed]


def _on_kept(placed: Iterable[_Placed], forgotten: Forgotten) -> Iterator[_Placed]:
    """Give poses seen from keyframes by their new numbers, those of one gone from the nearest."""
    index, poses = forgotten
    kept = np.flatnonzero(index >= 0)
    for stamp, node, pose in placed:
        seen_from = node
        if index[node] < 0:
            gaps = np.hypot(*(poses[kept, :2] - poses[node, :2]).T)
            seen_from = int(kept[gaps.argmin()])
            T_map_kept, T_map_node = (SE2.from_array(poses[one]) for one in (seen_from, node))
            pose = T_map_kept.inverse() @ T_map_node @ pose
        yield stamp, int(index[seen_from]), pose


@dataclass(frozen=True)
class Fix:
    """The filter's estimate of the pose at a scan."""

    stamp: float  # [s]
    T_map_base: SE2  # pose of the base in the map
    quality: float  # trust, 0..1
    status: Status  # how the last update ended


def replay(belief: ParticleFilter, log: Iterable[tuple[Scan, SE2]]) -> list[Fix]:
    """Return a fix for each scan from the first estimate on.

    Raises:
        LocalizationError: An odometry pose is not finite.
    """
    fixes: list[Fix] = []
    estimate = None
    for scan, T_odom_base in log:
        estimate = belief.update(T_odom_base, scan) or estimate
        if estimate is not None:
            pose = estimate.T_map_odom @ T_odom_base
            fixes.append(Fix(scan.stamp, pose, estimate.quality, estimate.status))
    return fixes


@dataclass(frozen=True)
class LocalizedLog:
    """The result of AMCL on a log."""

    fixes: list[Fix]  # one for each scan from the first estimate on
    grid: OccupancyGrid  # the map
    problems: list[str]  # the parts of the log that were skipped


def localize_log(
    path: Path,
    map_path: Path,
    parameters: Mapping[str, Any],
    *,
    scan_topic: str = "",
    odom_topic: str = "",
    seed: int = 0,
    watch: Watch = iter,
) -> LocalizedLog:
    """Run AMCL over a log, from `initial_pose` where `set_initial_pose` is on, else from anywhere.

    Args:
        path: What `open_log` reads.
        parameters: Of amcl, by name.
        scan_topic: Of a recording; "" for the only one.
        odom_topic: Of a recording; "" for what /tf says.
        seed: Of all chance.
        watch: Passes the scans on, to see how far it is.

    Raises:
        ArjunaError: An input cannot be used.
    """
    config = load(AmclNodeConfig, parameters, "amcl")
    frames = config.odom_frame_id, config.base_frame_id
    log = open_log(path, RecordingTopics(scan_topic, odom_topic, *frames))
    grid = load_map(map_path)
    belief = ParticleFilter(config, grid, np.random.default_rng(seed))
    if config.set_initial_pose:
        at = config.initial_pose
        belief.set_pose(SE2(at.x, at.y, at.yaw), _SPREAD)
    else:
        belief.globalize()
    fixes = replay(belief, watch(log))
    if not fixes:
        raise InputFileError(path, "none of its scans can be used")
    return LocalizedLog(fixes, grid, log.problems)


def read_relations(path: Path) -> Floats:
    """Read relations as `evaluate` takes them, a line each.

    Raises:
        InputFileError: It cannot be read as such.
    """
    try:
        relations = np.loadtxt(io.StringIO(read_text(path, 20_000_000)), ndmin=2)
    except ValueError as error:
        raise InputFileError(path, f"cannot be read as relations: {error}") from error
    if relations.shape[1] != 8:
        problem = f"has {relations.shape[1]} columns; valid: t1 t2 x y z roll pitch yaw"
        raise InputFileError(path, problem)
    return relations


@dataclass(frozen=True)
class RelationError:
    """Error of a trajectory against relations."""

    translation: tuple[float, float]  # mean and standard deviation [m]
    rotation: tuple[float, float]  # mean and standard deviation [rad]
    count: int  # relations evaluated


def evaluate(trajectory: list[tuple[float, SE2]], relations: Floats) -> RelationError:
    """Compare a trajectory, increasing stamps [s] and poses, with reference relations.

    A relation is t1, t2, x, y, z, roll, pitch, yaw of the pose at t2 in that at t1: `(R, 8)`.

    Raises:
        ValueError: No relation lies within the trajectory.
    """
    stamps = np.array([stamp for stamp, _ in trajectory])
    times = relations[:, :2]
    relations = relations[((times >= stamps[0]) & (times <= stamps[-1])).all(axis=1)]
    if len(relations) == 0:
        raise ValueError(f"no relation within {stamps[0]:.3f}..{stamps[-1]:.3f} s")
    error = np.empty((len(relations), 2))
    for k, row in enumerate(relations):
        first, second = (_at(stamps, trajectory, t) for t in row[:2])
        e = SE2(row[2], row[3], row[7]).inverse() @ (first.inverse() @ second)
        error[k] = math.hypot(e.x, e.y), abs(wrap(e.theta))
    mean, deviation = error.mean(axis=0), error.std(axis=0)
    return RelationError(
        (float(mean[0]), float(deviation[0])), (float(mean[1]), float(deviation[1])), len(error)
    )


def _at(stamps: Floats, trajectory: list[tuple[float, SE2]], stamp: float) -> SE2:
    k = int(np.searchsorted(stamps, stamp))
    if k == 0 or stamps[k] == stamp:
        return trajectory[k][1]
    ratio = (stamp - stamps[k - 1]) / (stamps[k] - stamps[k - 1])
    return trajectory[k - 1][1].interpolate(trajectory[k][1], float(ratio))
