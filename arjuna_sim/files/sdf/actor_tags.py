"""Reading SDF's actors and their scripted trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.actors import Actor, Trajectory, person

_WAYPOINTS_MAX = 10_000


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
