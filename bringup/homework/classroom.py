"""A class on one machine: a domain, a port and a folder for each student, and a page of all."""

from __future__ import annotations

import csv
import html
import math
import threading
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError
from arjuna_core.files.maps import save_map
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.grid import OccupancyGrid
from bringup.campaign.report import page_of
from bringup.parameters.options import DOMAINS

PAGE, SEATS = "index.html", "class.csv"


@dataclass(frozen=True)
class Seat:
    """A student's seat.

    Attributes:
        domain: Of ROS, which nobody else of the class has.
        port: For `view`.
    """

    name: str
    domain: int
    port: int
    folder: str


def seats(count: int, out: Path, first_domain: int, first_port: int) -> list[Seat]:
    """Return the seats of a class.

    Raises:
        ArjunaError: There are not so many domains or ports.
    """
    last = first_domain + count - 1
    if count < 1 or first_domain < 0 or last > DOMAINS:
        most = DOMAINS - max(first_domain, 0) + 1
        raise ArjunaError(f"{count} students from domain {first_domain}; valid: 1 to {most}")
    if not 1024 <= first_port <= 65536 - count:
        raise ArjunaError(f"port {first_port} is no first port; valid: 1024 to {65536 - count}")
    width = len(str(count))
    return [
        Seat(name, first_domain + k, first_port + k, str(out / name))
        for k in range(count)
        for name in [f"student{k + 1:0{width}}"]
    ]


def hand_out_seats(every: Sequence[Seat], out: Path) -> None:
    """Write the table of the seats, and into each folder what its shell reads.

    Raises:
        OSError: A file cannot be written.
    """
    out.mkdir(parents=True, exist_ok=True)
    with (out / SEATS).open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerows([[field.name for field in fields(Seat)], *map(astuple, every)])
    for seat in every:
        folder = Path(seat.folder)
        folder.mkdir(exist_ok=True)
        (folder / "setup.sh").write_text(
            f"# {seat.name}: 'source setup.sh' in each shell; the robot is shown by\n"
            f"# 'python -m bringup view --port {seat.port}'\nexport ROS_DOMAIN_ID={seat.domain}\n",
            encoding="utf-8",
        )


class Watcher:
    """Sees one robot: of a domain of its own, so by a participant of its own."""

    def __init__(self, seat: Seat, drawn: int = 600) -> None:
        from nav_msgs.msg import Odometry
        from rclpy.node import Node

        from arjuna_core.ros import qos
        from arjuna_core.ros.context import new_context

        self.seat, self.path = seat, deque[tuple[float, float, float]](maxlen=drawn)
        self.state = "no robot yet"
        self._time, self._type = -math.inf, Odometry
        self._context = new_context(seat.domain)
        self._node = Node(
            "class_page", context=self._context, start_parameter_services=False, enable_rosout=False
        )
        self._odometry = self._node.create_subscription(
            Odometry, "ground_truth/odom", lambda message: None, qos.SENSOR_SUBSCRIPTION
        )

    def look(self) -> None:
        """Take the newest that has come; nothing is run, and nobody waits."""
        from arjuna_core.ros.convert import se2_from_pose, seconds

        last: Any = None
        handle = self._odometry.handle
        with handle:
            while (taken := handle.take_message(self._type, False)) is not None:
                last = taken[0]
        if last is None:
            self.state = f"silent since {self._time:.0f} s" if self.path else self.state
            return
        pose, speed = se2_from_pose(last.pose.pose), last.twist.twist.linear.x
        self._time = seconds(last.header.stamp)
        if self.path and math.dist(self.path[-1][:2], (pose.x, pose.y)) < 0.02:  # turns on the spot
            self.path.pop()
        self.path.append((pose.x, pose.y, pose.theta))
        moves = f"drives at {speed:.2f} m/s" if abs(speed) > 0.01 else "stands"
        self.state = f"{moves} at ({pose.x:.2f}, {pose.y:.2f}), {self._time:.0f} s"

    def close(self) -> None:
        """Leave the domain."""
        self._node.destroy_node()
        self._context.shutdown()


def watch(every: Sequence[Seat], out: Path, grid: OccupancyGrid | None, period: float = 2.0) -> int:
    """Write the class's page again and again, until the process ends [s]."""
    watchers = [Watcher(seat) for seat in every]
    if grid is not None:
        save_map(grid, out / "map", "png")
    while True:
        for watcher in watchers:
            watcher.look()
        write_atomically(out / PAGE, page(watchers, grid).encode())
        threading.Event().wait(period)


def page(watchers: Iterable[Watcher], grid: OccupancyGrid | None) -> str:
    """Return the page: each robot's picture and state."""
    figures = (
        f"<figure>{_picture(list(one.path), grid)}<figcaption><b>{html.escape(one.seat.name)}</b>"
        f"<br>domain {one.seat.domain}, <a href='http://127.0.0.1:{one.seat.port}'>view</a>"
        f"<br>{html.escape(one.state)}</figcaption></figure>"
        for one in watchers
    )
    return page_of("The class", figures, refresh=3)


def _picture(path: list[tuple[float, float, float]], grid: OccupancyGrid | None) -> str:
    """Return a robot and its path as SVG, metres as its unit."""
    if grid is not None:
        frame = grid.frame
        left, bottom = frame.origin.x, frame.origin.y
        width, height = frame.width * frame.resolution, frame.height * frame.resolution
        size = f"x='{left}' y='{-bottom - height}' width='{width}' height='{height}'"
        back = f"<image href='map.png' {size} preserveAspectRatio='none'/>"
    else:
        side = 2.0 + max((max(abs(x), abs(y)) for x, y, _ in path), default=0.0)
        left, bottom, width, height, back = -side, -side, 2.0 * side, 2.0 * side, ""
    points = " ".join(f"{x:.2f},{-y:.2f}" for x, y, _ in path)
    robot = ""
    if path:
        x, y, theta = path[-1]
        turn = f"translate({x:.2f} {-y:.2f}) rotate({-math.degrees(theta):.1f})"
        robot = f"<path d='M.35 0L-.25 .22V-.22Z' fill='#c33' transform='{turn}'/>"
    return (
        f"<svg viewBox='{left} {-bottom - height} {width} {height}' width=240 height=240>{back}"
        f"<polyline points='{points}' fill=none stroke='#27c' stroke-width='.06'/>{robot}</svg>"
    )
