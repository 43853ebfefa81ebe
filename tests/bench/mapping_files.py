"""Mapping by others' parameter files: when the first map comes, and how far off the robot is.

Each file drives the same simulated robot through the same world in lock-step, and the shipped
parameters do. The robot wanders: ahead, and round where something stands before it.
"""

from __future__ import annotations

import argparse
import bisect
import math
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from arjuna_core.se2 import SE2, wrap
from bringup.parameters import options

_PATIENCE = 5.0  # [s] for the first map
_AHEAD, _NEAR = 0.5, 0.6  # half the sector that must be free [rad], how far [m]
_SPEED, _TURN = 0.2, 0.6  # [m/s, rad/s]
_GRAIN = 0.005  # between points of the true walls [m]
_COMMAND_TICKS = 5  # from one command to the next


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    options.add(parser, *options.SIMULATION, *options.NODES)
    options.add_robot_names(parser)
    options.add(parser, "--seed")
    parser.add_argument(
        "--localize",
        action="store_true",
        help="on the graph that the shipped parameters have made, instead of mapping",
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="of driving (%(default)s)")
    parser.set_defaults(log_level="fatal", command="slam")


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Map with the shipped parameters, then map or localize with each file over them.

    Returns:
        By file: `first_map_s`, None where none came within 5 s; `maps` in all; `walls_m`, the mean
        distance of the last map's occupied cells from the world's true surfaces; `mean_m`, `last_m`
        and `last_deg` by which the poses of the scans that were used are off the truth.
    """
    from rclpy.logging import LoggingSeverity, set_logger_level

    set_logger_level("", LoggingSeverity[arguments.log_level.upper()])
    options.extend_search(arguments)
    files = arguments.params
    with TemporaryDirectory() as folder:
        graph = Path(folder) / "graph"
        result = {"shipped": _mapped(arguments, None, graph if arguments.localize else None)}
        if arguments.localize:
            words = (
                "mode:=localization",
                f"map_file_name:={graph}",
                "map_start_pose:=[0., 0., 0.]",
            )
            arguments.param = [*arguments.param, *(f"slam_toolbox:{word}" for word in words)]
        result |= {path.stem: _mapped(arguments, path, None) for path in files}
    width = max(map(len, result))
    for name, row in result.items():
        cells = "  ".join(
            f"{key} {value:.3f}" if isinstance(value, float) else f"{key} {value}"
            for key, value in row.items()
        )
        print(f"{name:{width}}  {cells}")
    return result


def _mapped(arguments: argparse.Namespace, path: Path | None, graph: Path | None) -> dict[str, Any]:
    """Drive with a file's parameters, save the graph if it has a path, and return the errors."""
    from arjuna_slam.mapping.session import save_session
    from bringup.lockstep import LockStep
    from bringup.parameters.files import for_node
    from bringup.parameters.inputs import gather
    from bringup.stack import SIM_GROUP, SLAM_GROUP

    arguments.params = [] if path is None else [path]
    parameters = gather(arguments)
    parameters["slam_toolbox"]["debug_logging"] = False
    with closing(LockStep(parameters)) as robot:
        drive = _Drive(robot, for_node(parameters, "slam_toolbox"))
        robot.start(SIM_GROUP, SLAM_GROUP)
        start = robot.now
        came = robot.run_until(lambda: drive.maps > 0, _PATIENCE, "a map", required=False)
        first = robot.now - start if came else None
        robot.on_tick = drive.tick
        robot.run(arguments.seconds)
        if graph is not None:
            save_session(Path(f"{graph}.posegraph"), robot.nodes["slam_toolbox"].slam.session())
        errors = drive.errors(_points(robot.sim.simulator.robot.surfaces()))
        return {"first_map_s": first, "maps": drive.maps, **errors}


def _points(segments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points each few millimetres on segments `(N, 4)` from x, y to x, y, `(M, 2)` [m]."""
    counts = np.ceil(np.hypot(*(segments[:, 2:] - segments[:, :2]).T) / _GRAIN).astype(int) + 1
    lines = [np.linspace(s[:2], s[2:], n) for s, n in zip(segments, counts, strict=True)]
    return np.concatenate(lines)


class _Drive:
    """Wanders about and notes how far the estimate is off; the truth is for measuring alone.

    Attributes:
        maps: How many maps have come.
    """

    def __init__(self, robot: Any, values: dict[str, Any]) -> None:
        from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
        from nav_msgs.msg import OccupancyGrid
        from sensor_msgs.msg import LaserScan

        from arjuna_core.ros import qos

        self._robot, self._twist = robot, Twist
        self._path_free, self._ticks, self.maps = True, 0, 0
        self._origin = SE2()
        self._map: Any = None
        self._truths: list[tuple[float, SE2]] = []
        self._poses: list[tuple[float, SE2]] = []
        client, scans = robot.client, values.get("scan_topic", "scan")
        client.create_subscription(LaserScan, scans, self._on_scan, qos.SENSOR_SUBSCRIPTION)
        client.create_subscription(OccupancyGrid, "map", self._on_map, qos.LATCHED)
        client.create_subscription(PoseWithCovarianceStamped, "pose", self._on_pose, qos.DEFAULT)
        self._commands = client.create_publisher(Twist, "cmd_vel", qos.DEFAULT)

    def _on_map(self, message: Any) -> None:
        if self.maps == 0:
            self._origin = self._robot.sim.last.truth.pose
        self.maps += 1
        self._map = message

    def _on_pose(self, message: Any) -> None:
        from arjuna_core.ros.convert import se2_from_pose, seconds

        self._poses.append((seconds(message.header.stamp), se2_from_pose(message.pose.pose)))

    def _on_scan(self, message: Any) -> None:
        ranges = np.asarray(message.ranges)
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        ahead = np.abs(np.remainder(angles + math.pi, 2.0 * math.pi) - math.pi) < _AHEAD
        seen = ahead & (ranges > message.range_min)
        self._path_free = not (ranges[seen] < _NEAR).any()

    def tick(self) -> None:
        """Command a velocity now and then, and note where the robot truly is."""
        self._ticks += 1
        if self._ticks % _COMMAND_TICKS == 1:
            command = self._twist()
            command.linear.x = _SPEED if self._path_free else 0.0
            command.angular.z = 0.0 if self._path_free else _TURN
            self._commands.publish(command)
        self._truths.append((self._robot.now, self._robot.sim.last.truth.pose))

    def _gaps(self) -> NDArray[np.float64]:
        """Return how far off each pose of the drive is, `(N, 2) float64` [m, deg]."""
        stamps = [stamp for stamp, _ in self._truths]
        found: list[tuple[float, float]] = []
        for stamp, estimate in self._poses:
            k = bisect.bisect_left(stamps, stamp)
            if 0 < k < len(stamps):
                (before, a), (after, b) = self._truths[k - 1 : k + 1]
                pose = a.interpolate(b, (stamp - before) / (after - before))
                truth = self._origin.inverse() @ pose
                turn = math.degrees(abs(wrap(estimate.theta - truth.theta)))
                found.append((estimate.distance(truth), turn))
        return np.array(found).reshape(-1, 2)

    def errors(self, surfaces: NDArray[np.float64]) -> dict[str, float | None]:
        """Return errors of map [m] and poses [m, deg]; None where none came.

        Args:
            surfaces: The world's true ones, `(N, 2) float64` [m].
        """
        gaps = self._gaps()
        if not len(gaps) or self._map is None:
            return dict.fromkeys(("walls_m", "mean_m", "last_m", "last_deg"))
        from arjuna_core.ros.convert import grid_from_msg

        grid = grid_from_msg(self._map)
        cells = grid.frame.to_points(np.argwhere(grid.occupied()).astype(np.int64))
        far = cKDTree(surfaces).query(self._origin.apply(cells))[0]
        return {
            "walls_m": float(far.mean()),
            "mean_m": float(gaps[:, 0].mean()),
            "last_m": float(gaps[-1, 0]),
            "last_deg": float(gaps[-1, 1]),
        }
