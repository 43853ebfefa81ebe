"""The robots among a world's models: those that drive, and where each stands."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from xml.etree.ElementTree import Element  # a type alone

import numpy as np

from arjuna_core.errors import RobotError, nearest
from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.files.robots.controllers import drive_of_controllers
from arjuna_sim.files.robots.joint_controllers import is_joint_plugin, read_joint_plugin
from arjuna_sim.files.robots.plugins import drive_kind, is_control, types_of
from arjuna_sim.files.robots.rules import limit_of
from arjuna_sim.files.sdf.frames import Scope
from arjuna_sim.files.sdf.includes import Includes, leaving_out
from arjuna_sim.files.sdf.model_tags import SWINGING, SdfJoint, SdfLink, is_static, own_pose
from arjuna_sim.files.sdf.world_state import moved_models
from arjuna_sim.files.tag_text import is_true, text_of, topic
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import VELOCITY, ControllerKind, DrivenJoint
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.model.urdf import Hinge
from arjuna_sim.model.world import Follower, Motor, Mover

_CIRCLE = 8  # waypoints around a circle, as gz-sim has


def models_by_name(world: Element) -> dict[str, Element]:
    """Return the models of an expanded world in the file's order; of two of one name the first."""
    found: dict[str, Element] = {}
    for model in world.findall("model"):
        found.setdefault(model.get("name", "").strip(), model)
    return found


def is_mover(model: Element) -> bool:
    """Return whether a model is an obstacle that a plugin moves in the plane, rather than a robot.

    It has neither joints that move nor sensors nor odometry, nor a robot's own `cmd_vel`.
    """
    kinds = [drive_kind(plugin) for plugin in model.iter("plugin")]
    return (
        {*kinds} - {None} == {DriveKind.PLANAR}
        and not any(joint.get("type") != "fixed" for joint in model.iter("joint"))
        and model.find(".//sensor") is None
        and not any("odometrypublisher" in types_of(each) for each in model.iter("plugin"))
        and _mover_of(model, "")[1].lstrip("/") != "cmd_vel"
    )


def _mover_of(model: Element, name: str) -> tuple[Element, str]:
    """Return the plugin that moves a model, and the topic of its commands."""
    plugin = next(p for p in model.iter("plugin") if drive_kind(p) is DriveKind.PLANAR)
    own = f"/model/{name}/cmd_vel" if "velocitycontrol" in types_of(plugin) else "cmd_vel"
    return plugin, topic(plugin, own, "cmd_vel", "commandtopic", "topic")


def read_mover(xml: XmlFile, model: Element, name: str) -> Mover:
    """Return what moves a model of a world.

    Raises:
        InputFileError: A value is no vector.
    """
    plugin, commands = _mover_of(model, name)
    label, found = f"plugin of model '{name}'", list[float]()
    for tag, index in (("initial_linear", 0), ("initial_linear", 1), ("initial_angular", 2)):
        found.append(xml.numbers(plugin.findtext(tag) or "0 0 0", 3, f"{label} <{tag}>")[index])
    return Mover(Velocity(found[0], y=found[1], yaw_rate=found[2]), commands)


def read_follower(xml: XmlFile, model: Element, name: str, T_world: Pose3) -> Follower | None:
    """Return what pushes a model of a world along waypoints; None where nothing does.

    Source: gz-sim's TrajectoryFollower.

    Args:
        T_world: Where its link stands.

    Raises:
        InputFileError: It has no waypoints, or a value is no number.
    """
    plugins = (p for p in model.findall("plugin") if "trajectoryfollower" in types_of(p))
    if (plugin := next(plugins, None)) is None:
        return None
    label, usual = f"plugin of model '{name}'", Follower(())
    force, torque, reach, aim = (
        xml.number(plugin, tag, default, label)
        for tag, default in (
            ("force", usual.force),
            ("torque", usual.torque),
            ("range_tolerance", usual.reach),
            ("bearing_tolerance", math.degrees(usual.aim)),
        )
    )
    return Follower(
        _waypoints(xml, plugin, label, T_world),
        *(is_true(plugin.findtext("loop")), force, torque, reach, math.radians(aim)),
        holds=is_true(plugin.findtext("zero_vel_on_bearing_reached")),
    )


def _waypoints(
    xml: XmlFile, plugin: Element, label: str, T_world: Pose3
) -> tuple[tuple[float, float], ...]:
    """Return waypoints as they are listed, or those of a circle or a line [m]."""
    texts = [each.text or "" for each in plugin.findall("waypoints/waypoint")]
    points = [xml.numbers(text, 2, f"{label} <waypoint>") for text in texts]
    x, y, _ = T_world.position
    circle, line = plugin.find("circle"), plugin.find("line")
    if circle is not None and not points:
        radius = xml.numbers(circle.findtext("radius") or "", 1, f"{label} <radius>")[0]
        turns = (math.tau * k / _CIRCLE for k in range(_CIRCLE))
        points = [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in turns]
    elif line is not None and not points:
        turn, length = (
            xml.numbers(line.findtext(tag) or "", 1, f"{label} <{tag}>")[0]
            for tag in ("direction", "length")
        )
        ahead = np.array([[length * math.cos(turn), length * math.sin(turn), 0.0]])
        points = [(x, y), T_world.apply(ahead)[0, :2].tolist()]
    if not points:
        raise xml.fail(label, "lacks its way; valid: <waypoints>, <circle>, <line>")
    return tuple((float(a), float(b)) for a, b in points)


def read_motors(
    xml: XmlFile, plugin: Element, model: str, joints: Sequence[SdfJoint]
) -> dict[str, Motor]:
    """Return what a plugin of a world's model turns by values, by the joint; {} for another plugin.

    Raises:
        InputFileError: A value is no number.
    """
    if not is_joint_plugin(plugin):
        return {}
    found = {j.name.rpartition("::")[2]: j for j in joints if j.kind in SWINGING}
    driven = dict[str, DrivenJoint]()
    controller = read_joint_plugin(xml, plugin, model, (), driven)
    if controller.kind is not ControllerKind.FORWARD:
        return {}
    motors = dict[str, Motor]()
    for name in (each for each in controller.joints if each in found):
        joint, start = driven[name], driven[name].initial
        most = limit_of(found[name].element.findtext("axis/limit/effort"))
        if controller.command == VELOCITY:
            start = xml.number(plugin, "initial_velocity", 0.0, f"joint '{name}'")
        motors[found[name].name] = Motor(
            controller.topic, controller.command, start, joint.gains, most
        )
    return motors


def read_belt(
    xml: XmlFile, plugin: Element, model: str, links: Sequence[SdfLink]
) -> dict[str, tuple[Hinge, Motor]]:
    """Return the belt of a world's model that stands fast, by its link; {} for another plugin.

    What lies on it moves along its x axis, which `<track_orientation>` turns.

    Source: gz-sim's TrackController.

    Raises:
        InputFileError: A value is no number.
    """
    name = text_of(plugin, "link")
    if "trackcontroller" not in types_of(plugin) or not any(
        link.name == name and link.static and link.solid for link in links
    ):
        return {}
    label = f"plugin of model '{model}'"
    rpy = xml.numbers(text_of(plugin, "trackorientation") or "0 0 0", 3, f"{label} orientation")
    x, y, z = Pose3.from_rpy((0.0, 0.0, 0.0), rpy).rotation()[:, 0].tolist()
    least, most = (
        xml.limit(text_of(plugin, tag) or None, default, f"{label} <{tag}>")
        for tag, default in (("minvelocity", -math.inf), ("maxvelocity", math.inf))
    )
    for tag in ("max_acceleration", "min_acceleration", "max_jerk", "min_jerk", "max_command_age"):
        if plugin.findtext(tag):
            xml.note(f"{label} <{tag}>: not simulated", NoteKind.IGNORED)
    commands = topic(plugin, f"/model/{model}/link/{name}/track_cmd_vel", "", "velocitytopic")
    return {
        name: (Hinge(True, (x, y, z), runs=True), Motor(commands, VELOCITY, belt=(least, most)))
    }


def driven_joints(model: Element, names: Collection[str], is_robot: bool) -> set[str]:
    """Return the joints of a model that a plugin moves or holds; all those of a robot."""
    plugins = list(model.iter("plugin"))
    texts = {(tag.text or "").strip() for plugin in plugins for tag in plugin.iter()}
    every = is_robot or any(map(is_control, plugins))
    return {name for name in names if every or name.rpartition("::")[2] in texts}


def robots_of(xml: XmlFile, includes: Includes, world: Element) -> dict[str, Element]:
    """Return an expanded world's models that drive by their names, in the file's order."""

    def drives(file: XmlFile, plugin: Element) -> bool:
        with leaving_out(file, f"plugin '{plugin.get('name', '?')}'"):
            controlled = drive_of_controllers(file, plugin) if is_control(plugin) else None
            return drive_kind(plugin if controlled is None else controlled) is not None
        return False

    return {
        name: model
        for name, model in models_by_name(world).items()
        if not is_static(model)
        and not is_mover(model)
        and any(drives(includes.file_of(model, xml), each) for each in model.iter("plugin"))
    }


def cut_out(xml: XmlFile, includes: Includes, world: Element, name: str) -> Pose3:
    """Leave only the model of a robot in a file, as if its world had never held it.

    Args:
        name: Of the model; "" for the only one that drives.

    Returns:
        Where the model stands in the world.

    Raises:
        RobotError: There is no such model, or not one alone.
    """
    models = models_by_name(world)
    if not name:
        found = robots_of(xml, includes, world)
        if not found:
            free = ", ".join(n for n, model in models.items() if not is_static(model))
            problem = "is a world in which no model has a drive"
            others = f"; --robot {xml.path}#NAME takes one without: {free}" if free else ""
            raise RobotError(xml.path, f"{problem}{others}")
        if len(found) > 1:
            valid = ", ".join(f"--robot {xml.path}#{each}" for each in found)
            raise RobotError(xml.path, f"holds {len(found)} robots; valid: {valid}")
        (name,) = found
    if name not in models:
        raise RobotError(xml.path, f"'{name}' is no model of its world; {nearest(name, models)}")
    model = models[name]
    T_world = pose_in(xml, includes, world, model)
    for element in list(xml.root):
        xml.root.remove(element)
    xml.root.append(model)
    return T_world


def pose_in(xml: XmlFile, includes: Includes, world: Element, model: Element) -> Pose3:
    """Return where a model of an expanded world stands.

    Raises:
        InputFileError: A frame that it is relative to does not exist.
    """
    label = f"model '{model.get('name', '?')}'"
    moved = moved_models(xml, world).get(model.get("name", ""))
    if moved is not None:
        return moved
    pose = Scope(xml, world, "world").pose(model, label)
    return own_pose(model, Scope(includes.file_of(model, xml), model, label), pose)
