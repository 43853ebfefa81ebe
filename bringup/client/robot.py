"""The robot in Python: a thin API for scripts and notebooks."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseWithCovariance, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from sensor_msgs.msg import LaserScan

from arjuna_core.files.map_image import MAP_SAVER, MapOptions
from arjuna_core.files.maps import save_map
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import (
    grid_from_msg,
    header,
    planar_covariance,
    pose_msg,
    scan_from_msg,
)
from arjuna_core.ros.tf import TransformBuffer, TransformListener
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from bringup.client.goals import GoalEnd, Goals
from bringup.client.session import Connection, Session
from bringup.client.velocity import stop, velocity_output

GOAL_TIMEOUT, EXPLORER_GRACE = 600.0, 60.0
_INITIAL_COVARIANCE = np.diag([0.5**2, 0.5**2, 0.26**2])  # what RViz's "2D Pose Estimate" sends
_REMEDIES = {
    "scan": "is 'python -m bringup sim' running, and not paused?",
    "map": "is 'python -m bringup slam' or 'nav' running, and does a scan come?",
    "initialpose": "is 'python -m bringup nav --map FILE' running?",
    "transform": "is 'python -m bringup slam' or 'nav' running? AMCL may want 'initial-pose X Y'",
}
_REMEDY = "'ros2 topic info -v {}' says who publishes it"


class Robot:
    """A running robot; close it, or use it in a `with` block.

    Args:
        timeout: How long to wait for what should be there at once [s].
        namespace: The robot's namespace.
        session: The robot to use, as a lock-step one; a new connection by default.

    Example:
        >>> with Robot() as robot:
        ...     robot.goto(2.0, 2.0)
        ...     print(robot.pose())
    """

    def __init__(
        self, timeout: float = 10.0, namespace: str = "", session: Session | None = None
    ) -> None:
        self._timeout = timeout
        self._own: Connection | None = None
        if session is None:
            session = self._own = Connection(namespace=namespace)
        self.session: Session = session
        self._goals = Goals(self.session)
        self._transforms = TransformBuffer()
        TransformListener(self.session.client, self._transforms)
        self._velocity: VelocityOutput | None = None

    def __enter__(self) -> Robot:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop, if this drove, and leave the graph."""
        self.stop()
        if self._own is not None:
            self._own.close()
            self._own = None

    def pose(self, frame: str = "map", base_frame: str = "") -> SE2:
        """Return where the robot is in a frame, `map` or `odom` [m, m, rad].

        Args:
            base_frame: The robot's; empty for the one that its odometry moves.

        Raises:
            ArjunaError: Nobody says so in time.
        """
        found: list[SE2] = []

        def known() -> bool:
            base = base_frame or self._transforms.base_below(frame)
            pose = None if base is None else self._transforms.try_lookup(frame, base)
            found.extend([] if pose is None else [pose])
            return pose is not None

        what = f"the transform {frame} -> {base_frame or 'base'}"
        self._wait(known, what, _REMEDIES["transform"])
        return found[-1]

    def scan(self) -> Scan:
        """Return the lidar's next scan, in the lidar's frame."""
        return scan_from_msg(self.message(LaserScan, "scan", qos.SENSOR_SUBSCRIPTION))

    def map(self, topic: str = "map") -> OccupancyGrid:
        """Return the map that a topic has."""
        return grid_from_msg(self.message(OccupancyGridMsg, topic, qos.LATCHED))

    def save_map(
        self,
        path: str | Path,
        topic: str = "map",
        image_format: str = "pgm",
        options: MapOptions = MAP_SAVER,
    ) -> Path:
        """Write the map as `path.pgm` and `path.yaml`; return the YAML's path.

        Raises:
            ArjunaError: There is no map, or the files cannot be written.
        """
        return save_map(self.map(topic), path, image_format, options)[0]

    def goto(
        self,
        x: float,
        y: float,
        yaw: float = 0.0,
        timeout: float = GOAL_TIMEOUT,
        progress: Callable[[Any], None] = lambda feedback: None,
    ) -> GoalEnd:
        """Drive to a pose of the map [m, m, rad]; return how that ended, within a time [s].

        `progress` takes nav2's feedback.
        """
        return self._goals.navigate(SE2(x, y, yaw), timeout, progress)

    def tour(
        self, waypoints: Iterable[tuple[float, float, float]], timeout: float = GOAL_TIMEOUT
    ) -> list[GoalEnd]:
        """Drive to poses of the map [m, m, rad], one after the other, each within a time [s]."""
        return [self.goto(*pose, timeout=timeout) for pose in waypoints]

    def explore(self, timeout: float = 1800.0) -> bool:
        """Drive to the edges of the map until all is seen; return whether it was in time [s].

        Navigation must run while mapping: `python -m bringup nav --slam`.
        """
        command = [sys.executable, "-m", "bringup", "explore", "--timeout", str(timeout)]
        done = subprocess.run(  # noqa: S603 - our own command
            command, timeout=timeout + EXPLORER_GRACE, check=False
        )
        return done.returncode == 0

    def set_pose(self, x: float, y: float, yaw: float = 0.0) -> None:
        """Set the pose that AMCL starts from, roughly [m, m, rad].

        Raises:
            ArjunaError: Nobody listens in time.
        """
        session = self.session
        publisher = session.client.create_publisher(
            PoseWithCovarianceStamped, "initialpose", qos.DEFAULT
        )
        what = "somebody who listens on 'initialpose'"
        count = publisher.get_subscription_count
        self._wait(lambda: count() > 0, what, _REMEDIES["initialpose"])
        pose = PoseWithCovariance(
            pose=pose_msg(SE2(x, y, yaw)), covariance=planar_covariance(_INITIAL_COVARIANCE)
        )
        publisher.publish(PoseWithCovarianceStamped(header=header("map", 0.0), pose=pose))
        session.pause(0.1)  # it is sent

    def drive(self, v: float, w: float, duration: float, period: float = 0.1) -> None:
        """Drive at a speed [m/s] and turn rate [rad/s] for a time [s], then stop.

        Commands are sent at a period [s].
        """
        session = self.session
        end = session.now + duration
        while session.now < end:
            self.command(v, w)
            session.pause(min(period, end - session.now))
        self.stop()

    def command(self, v: float, w: float) -> None:
        """Ask for a speed [m/s] and turn rate [rad/s] once; the robot stops soon without more."""
        if self._velocity is None:
            self._velocity = velocity_output(self.session, self._timeout)
        self._velocity.publish(Velocity(v, yaw_rate=w))

    def stop(self) -> None:
        """Stop what `drive` or `command` began."""
        if self._velocity is not None:
            stop(self.session, self._velocity)

    def message(self, message_type: Any, topic: str, profile: Any = qos.DEFAULT) -> Any:
        """Return the next message of a topic, or the latched one.

        Raises:
            ArjunaError: None comes in time.
        """
        session = self.session
        found: list[Any] = []
        subscription = session.client.create_subscription(
            message_type, topic, found.append, profile
        )
        try:
            remedy = _REMEDIES.get(topic, _REMEDY.format(topic))
            self._wait(lambda: bool(found), f"a message on '{topic}'", remedy)
        finally:
            session.client.destroy_subscription(subscription)
        return found[0]

    def _wait(self, done: Callable[[], bool], what: str, remedy: str) -> None:
        self.session.wait_for(done, self._timeout, what, remedy)
