"""Actors: people and things that follow waypoints, whatever stands in their way."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

import numpy as np
from numpy.typing import NDArray

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2, wrap
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.shapes import Kind, Part, Shape

PERSON = (0.25, 1.7)
"""Radius and height of the cylinder that stands for a person [m]."""
_WAYPOINTS_MAX = 10_000
_STEP = 1e-3  # over which a velocity is measured [s]


@dataclass(frozen=True)
class Trajectory:
    """Poses at times, and straight lines between them.

    Attributes:
        times: When each waypoint is reached, from the start, never falling [s].
        poses: The waypoints in the world.
        loop: Whether it starts again at its end.
        delay: Time to stand at the first waypoint before each round [s].
    """

    times: tuple[float, ...]
    poses: tuple[SE2, ...]
    loop: bool = True
    delay: float = 0.0

    @staticmethod
    def along(points: NDArray[np.float64], speed: float, loop: bool = True) -> Trajectory:
        """Build a trajectory that follows points at a constant speed, facing ahead.

        Args:
            points: Where to go `(N, 2) float64` [m]; a loop goes back to the first.
            speed: On the way [m/s].
            loop: Whether it starts again at its end.

        Raises:
            ConfigError: There are fewer than two points, or a value is no path or speed.
        """
        if len(points) < 2 or not np.isfinite(points).all():
            raise ConfigError(f"a path needs two or more finite points, got {len(points)}")
        if not 0.0 < speed < math.inf:
            raise ConfigError(f"speed is {speed} m/s; valid: above 0")
        path = np.vstack((points, points[:1])) if loop else points
        times, poses, now = [], [], 0.0
        for (x0, y0), (x1, y1) in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
            heading = math.atan2(y1 - y0, x1 - x0)
            end = now + math.hypot(x1 - x0, y1 - y0) / speed
            times += [now, end]
            poses += [SE2(x0, y0, heading), SE2(x1, y1, heading)]
            now = end
        return Trajectory(tuple(times), tuple(poses), loop)

    def pose(self, elapsed: float) -> SE2:
        """Return the pose at a time from the start [s]."""
        whole = self.delay + self.times[-1]
        if self.loop and whole > 0.0:
            elapsed = math.fmod(elapsed, whole)
        t = elapsed - self.delay
        i = bisect_right(self.times, t)
        if i == 0 or i == len(self.times):
            return self.poses[min(i, len(self.times) - 1)]
        a, b = self.poses[i - 1], self.poses[i]
        ratio = (t - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        return SE2(
            a.x + ratio * (b.x - a.x),
            a.y + ratio * (b.y - a.y),
            wrap(a.theta + ratio * wrap(b.theta - a.theta)),
        )

    def velocity(self, elapsed: float) -> tuple[float, float, float]:
        """Return `(vx, vy, w)` in the world at a time from the start [m/s, m/s, rad/s]."""
        a, b = self.pose(elapsed), self.pose(elapsed + _STEP)
        turn = wrap(b.theta - a.theta)
        return (b.x - a.x) / _STEP, (b.y - a.y) / _STEP, turn / _STEP


@dataclass(frozen=True)
class Actor:
    """One actor of a world file.

    Attributes:
        name: Its name.
        parts: What it is made of, in its own frame, which stands on the ground.
        start: Where it is before it moves.
        trajectory: How it moves; None for one that stands.
    """

    name: str
    parts: tuple[Part, ...]
    start: SE2
    trajectory: Trajectory | None


def person() -> tuple[Part, ...]:
    """Return the shape that stands for a person: an upright cylinder."""
    height = PERSON[1]
    middle = Pose3((0.0, 0.0, height / 2))
    return (Part(Shape(Kind.CYLINDER, PERSON), middle, (0.3, 0.4, 0.8, 1.0)),)


def read_actor(xml: XmlFile, element: Element, T_world: Pose3) -> Actor:
    """Read an SDF `<actor>`: its name, pose and scripted trajectories.

    Its skin and animations are not drawn: a cylinder stands for it.

    Args:
        xml: The file.
        element: The actor.
        T_world: Its own pose in the world.

    Raises:
        InputFileError: A waypoint lacks its time or pose, or they are no numbers.
    """
    name = xml.attribute(element, "name", "an actor")
    xml.note(f"actor '{name}': an upright cylinder stands for its skin")
    script = element.find("script")
    trajectory = None if script is None else _read_script(xml, script, f"actor '{name}'")
    start = T_world.planar() if trajectory is None else trajectory.poses[0]
    return Actor(name, person(), start, trajectory)


def _read_script(xml: XmlFile, script: Element, place: str) -> Trajectory | None:
    """Join a script's trajectories by their ids, as Gazebo plays them."""
    if not _flag(script.findtext("auto_start"), True):
        xml.note(f"{place}: <auto_start> is false, so it stands still")
        return None
    waypoints = [w for t in script.findall("trajectory") for w in t.findall("waypoint")]
    if not waypoints:
        return None
    if len(waypoints) > _WAYPOINTS_MAX:
        raise xml.fail(place, f"has {len(waypoints)} waypoints; at most {_WAYPOINTS_MAX} are read")
    read = [_read_waypoint(xml, waypoint, place) for waypoint in waypoints]
    read.sort(key=lambda item: item[0])
    delay = xml.number(script, "delay_start", 0.0, place)
    if delay < 0.0:
        raise xml.fail(place, f"<delay_start> is {delay}; valid: 0 or more")
    loop = _flag(script.findtext("loop"), True)
    return Trajectory(tuple(t for t, _ in read), tuple(p for _, p in read), loop, delay)


def _read_waypoint(xml: XmlFile, waypoint: Element, place: str) -> tuple[float, SE2]:
    place = f"{place} waypoint"
    (time,) = xml.numbers(xml.child(waypoint, "time", place).text or "", 1, f"{place} <time>")
    if time < 0.0:
        raise xml.fail(place, f"<time> is {time}; valid: 0 or more")
    text = xml.child(waypoint, "pose", place).text or ""
    values: Sequence[float] = xml.numbers(text, 6, f"{place} <pose>")
    return time, SE2(values[0], values[1], values[5])


def _flag(text: str | None, default: bool) -> bool:
    return default if text is None else text.strip().lower() in ("true", "1")
