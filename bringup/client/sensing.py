"""A robot's lidar; scans, maps and paths that a notebook shows as pictures."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import scan_from_msg
from arjuna_core.ros.scan_queue import scan_seen_from
from arjuna_core.ros.tf import TransformBuffer, TransformError
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.client.session import Session
from bringup.viewing.snapshot import Snapshot


def _png(snapshot: Snapshot, title: str) -> bytes:
    from bringup.viewing.pictures import draw_snapshot

    picture = io.BytesIO()
    draw_snapshot(picture, snapshot, title, size=5.0)
    return picture.getvalue()


class DrawnScan(Scan):
    """A scan that draws itself, as its robot sees it: ahead is to the right."""

    def _repr_png_(self) -> bytes:
        return _png(Snapshot(scan=self.points(), robot=SE2()), "Scan, seen from the robot")


class DrawnMap(OccupancyGrid):
    """A map that draws itself."""

    def _repr_png_(self) -> bytes:
        return _png(Snapshot(grid=self), "Map")


@dataclass(frozen=True)
class DrivenPath:
    """The path that a robot drove, by its odometry; it draws itself.

    Attributes:
        poses: x, y, heading, `(N, 3) float64` [m, m, rad], oldest first.
        frame: `map`, or `odom` where no map is.
        grid: The map below it, if one has come.
    """

    poses: NDArray[np.float64]
    frame: str
    grid: OccupancyGrid | None = None

    @property
    def length(self) -> float:
        """Distance driven [m]."""
        return float(np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1).sum())

    def _repr_png_(self) -> bytes:
        trail = [(float(x), float(y)) for x, y, _ in self.poses]
        robot = SE2.from_array(self.poses[-1]) if len(self.poses) else None
        grid = self.grid if self.frame == "map" else None
        return _png(Snapshot(grid=grid, robot=robot, believed=trail), f"Path in '{self.frame}'")


class Lidar:
    """The scans of a topic from the first use on.

    Attributes:
        topic: Theirs.
        calling: Whether functions of `on_scan` run, in which nothing can be waited for.
    """

    def __init__(self, session: Session, transforms: TransformBuffer, topic: str) -> None:
        self._session, self._transforms, self.topic = session, transforms, topic
        self._message: Any = None
        self._subscription: Any = None
        self._callbacks: list[Callable[[DrawnScan], object]] = []
        self.calling = False

    @property
    def latest(self) -> DrawnScan | None:
        """The last scan as the base sees it; as the lidar does where its mount is not known."""
        if self._message is None:
            return None
        base = self._transforms.base_below("odom") or ""
        try:
            scan = scan_seen_from(self._transforms, base, self._message)
        except TransformError:
            scan = scan_from_msg(self._message)
        return DrawnScan(**vars(scan))

    def listen(self) -> Callable[[], bool]:
        """Subscribe, once; return a function that says whether another scan has come since."""
        if self._subscription is None:
            self._subscription = self._session.client.create_subscription(
                LaserScan, self.topic, self._take, qos.SENSOR_SUBSCRIPTION
            )
        last = self._message
        return lambda: self._message is not last

    def on_scan(self, callback: Callable[[DrawnScan], object]) -> Callable[[], None]:
        """Call a function with each scan until it raises; return a function that ends this."""
        self.listen()
        self._callbacks = [*self._callbacks, callback]
        return lambda: self._end(callback)

    def close(self) -> None:
        """Call no function any more."""
        self._callbacks = []

    def _end(self, callback: Callable[[DrawnScan], object]) -> None:
        self._callbacks = [one for one in self._callbacks if one is not callback]

    def _take(self, message: Any) -> None:
        self._message = message
        if not self._callbacks or (scan := self.latest) is None:
            return
        for callback in self._callbacks:
            self.calling = True
            try:
                callback(scan)
            except BaseException:
                self._end(callback)
                raise
            finally:
                self.calling = False
