"""The robot in Python: a thin API for scripts and notebooks."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg

from arjuna_core.files.map_image import MAP_SAVER, MapOptions
from arjuna_core.files.maps import save_map
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg
from arjuna_core.ros.tf import TransformListener
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from bringup.client.goals import GoalEnd, Goals, initial_pose_msg
from bringup.client.motion import ODOM, Reckoning, Trail, stop, velocity_output
from bringup.client.sensing import DrawnMap, DrawnScan, DrivenPath, Lidar
from bringup.client.session import ClientError, Connection, Session

GOAL_TIMEOUT, EXPLORER_GRACE = 600.0, 60.0
_REMEDIES = {
    "scan": "is 'python -m bringup sim' running, and not paused?",
    "map": "is 'python -m bringup slam' or 'nav' running, and does a scan come?",
    "initialpose": "is 'python -m bringup nav --map FILE' running?",
    "transform": "is 'python -m bringup slam' or 'nav' running? AMCL may want 'initial-pose X Y'",
}
_REMEDY = "'ros2 topic info -v {}' says who publishes it"

_R = TypeVar("_R", bound="Robot")


class Robot:
    """A running robot; close it, or use it in a `with` block.

    Args:
        timeout: How long to wait for what should be there at once [s].
        namespace: The robot's namespace.
        session: The robot to use, as a lock-step one; a new connection by default.
        scan_topic: Of its lidar.
        cmd_vel_topic: Of its commands.

    Example:
        >>> with Robot() as robot:
        ...     robot.forward(1.0)
        ...     print(robot.pose("odom"))
    """

    def __init__(
        self,
        timeout: float = 10.0,
        namespace: str = "",
        session: Session | None = None,
        scan_topic: str = "scan",
        cmd_vel_topic: str = "cmd_vel",
    ) -> None:
        self._timeout = timeout
        self._own: Connection | None = None
        if session is None:
            session = self._own = Connection(namespace=namespace)
        self.session: Session = session
        self._goals = Goals(self.session)
        self._transforms = Trail()
        TransformListener(self.session.client, self._transforms)
        self._velocity: VelocityOutput | None = None
        self._reckoning = Reckoning(self.session, self._transforms, self._publish, timeout)
        self._map: DrawnMap | None = None
        self._lidar = Lidar(self.session, self._transforms, scan_topic)
        self._cmd_vel_topic = cmd_vel_topic
        self._stopped = False

    def __enter__(self: _R) -> _R:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop, if this drove, and leave the graph."""
        self._lidar.close()
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

    def scan(self) -> DrawnScan:
        """Return the lidar's next scan; inside a callback of `on_scan`, the one that it is of."""
        if not self._lidar.calling:
            what = f"a message on '{self._lidar.topic}'"
            self._wait(self._lidar.listen(), what, _REMEDIES["scan"])
        scan = self._lidar.latest
        assert scan is not None
        return scan

    def nearest(self, bearing: float = 0.0, width: float = 2.0 * math.pi) -> float:
        """Return the distance from the lidar to the nearest thing that it sees [m]; inf if none.

        Args:
            bearing: Middle of the sector that is looked at, 0 ahead, positive to the left [rad].
            width: Of that sector, all around by default [rad].
        """
        return self.scan().nearest(bearing, width)

    def on_scan(self, callback: Callable[[DrawnScan], object]) -> Callable[[], None]:
        """Call a function with each scan from now on; return a function that ends this.

        It is called while the robot is waited for, as in `wait` or `forward`, and cannot wait
        itself: `command`, `stop` and `nearest` are for it.
        """
        return self._lidar.on_scan(callback)

    def map(self, topic: str = "map") -> DrawnMap:
        """Return the map that a topic has."""
        grid = grid_from_msg(self.message(OccupancyGridMsg, topic, qos.LATCHED))
        self._map = DrawnMap(**vars(grid))
        return self._map

    @property
    def path(self) -> DrivenPath:
        """The path driven since the robot was connected to, on the map that `map` last gave."""
        trail, moved = self._transforms, self._transforms.try_lookup("map", ODOM)
        now = [trail.odometry()[1]] if trail.poses else []
        poses = [pose if moved is None else moved @ pose for pose in (*trail.poses, *now)]
        table = np.array([pose.array() for pose in poses]).reshape(-1, 3)
        return DrivenPath(table, ODOM if moved is None else "map", self._map)

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
        heading: float = 0.0,
        timeout: float = GOAL_TIMEOUT,
        progress: Callable[[Any], None] = lambda feedback: None,
    ) -> GoalEnd:
        """Drive to a pose of the map [m, m, rad]; return how that ended, within a time [s].

        `progress` takes nav2's feedback.
        """
        return self._goals.navigate(SE2(x, y, heading), timeout, progress)

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

    def set_pose(self, x: float, y: float, heading: float = 0.0) -> None:
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
        # as roughly as RViz's "2D Pose Estimate"
        publisher.publish(initial_pose_msg(SE2(x, y, heading), 0.5, 0.26, 0.0))
        # Who leaves during discovery may wait in Fast DDS 2.14 for ever: let it end.
        session.pause(0.5)

    def forward(self, metres: float, speed: float = 0.2, clearance: float = 0.3) -> float:
        """Drive straight by a distance, back where it is negative; return the distance driven [m].

        The odometry closes it, so that it ends where it should; `stop` in a callback ends it.

        Args:
            speed: Greatest speed [m/s].
            clearance: Stop where the lidar sees something nearer in that direction [m]; 0 never.

        Raises:
            ArjunaError: Something is in the way, it takes too long, or a value is not valid.
        """
        _check("forward: metres", metres, abs(metres) < math.inf, "a finite distance")
        _check("forward: speed", speed, 0.0 < speed < math.inf, "above 0; metres have the sign")
        direction = 0.0 if metres >= 0.0 else math.pi

        def check(done: float) -> None:
            scan = self._lidar.latest if clearance > 0.0 else None
            seen = math.inf if scan is None else scan.nearest(direction, math.pi / 3.0)
            if seen < clearance:
                raise ClientError(
                    f"something is in the way, {seen:.2f} m off, after {done:.2f} of {metres:g} m:"
                    f" it stopped (clearance={clearance:g})"
                )

        self._lidar.listen()
        with self._driving():
            return self._reckoning.forward(metres, speed, check)

    def turn(self, radians: float, rate: float = 1.0) -> float:
        """Turn on the spot, to the left where it is positive; return the angle turned [rad].

        Args:
            rate: Greatest turn rate [rad/s].

        Raises:
            ArjunaError: It takes too long, or a value is not valid.
        """
        fits = abs(radians) <= 4.0 * math.pi
        valid = f"at most two turns in radians (math.radians({radians:g}) if it is in degrees)"
        _check("turn: radians", radians, fits, valid)
        _check("turn: rate", rate, 0.0 < rate < math.inf, "above 0; radians have the sign")
        with self._driving():
            return self._reckoning.turn(radians, rate)

    def drive(self, v: float, w: float, duration: float, period: float = 0.1) -> None:
        """Drive at a speed [m/s] and turn rate [rad/s] for a time [s], then stop.

        Commands are sent at a period [s].
        """
        session, self._stopped = self.session, False
        end = session.now + duration
        with self._driving():
            while not (session.is_past(end) or self._stopped):
                self.command(v, w)
                session.pause(min(period, end - session.now))

    def command(self, v: float, w: float) -> None:
        """Ask for a speed [m/s] and turn rate [rad/s] once; the robot stops soon without more."""
        self._reckoning.interrupt()
        self._publish(Velocity(v, yaw_rate=w))

    def stop(self) -> None:
        """Stop, and end what `forward`, `turn`, `drive` or `command` began."""
        self._stopped = True
        self._reckoning.interrupt()
        if self._velocity is None:
            return
        if self._lidar.calling:
            self._velocity.stop()
        else:
            stop(self.session, self._velocity)

    def wait(self, duration: float) -> None:
        """Let time pass, and functions of `on_scan` be called [s]."""
        self._must_not_call_back()
        self.session.pause(duration)

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
        self._must_not_call_back()
        self.session.wait_for(done, self._timeout, what, remedy)

    def _must_not_call_back(self) -> None:
        if self._lidar.calling:
            raise ClientError(
                "a function of on_scan cannot wait, it holds up the scans; valid in it: 'command',"
                " 'stop', 'nearest', 'scan'"
            )

    def _publish(self, velocity: Velocity) -> None:
        if self._velocity is None:
            session, topic = self.session, self._cmd_vel_topic
            if self._lidar.calling:
                self._velocity = VelocityOutput(session.client, None, frame="", topic=topic)
            else:
                self._velocity = velocity_output(session, self._timeout, topic)
        self._velocity.publish(velocity)

    @contextmanager
    def _driving(self) -> Iterator[None]:
        """Stand still at the end, however it comes."""
        self._must_not_call_back()
        try:
            yield
        finally:
            if self._velocity is not None:
                stop(self.session, self._velocity)


def _check(what: str, value: float, is_valid: bool, valid: str) -> None:
    if not is_valid:
        raise ClientError(f"{what} = {value:g} is not valid; valid: {valid}")
