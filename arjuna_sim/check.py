"""Saying what was understood of a robot or world, and what was not."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.shipped import shipped_file
from arjuna_core.pose3 import ORIGIN
from arjuna_sim.devices.driving.steered import SteeredBase
from arjuna_sim.files.robots.guess import save_guess
from arjuna_sim.files.robots.robot_file import load_robot, names_drive, split_model
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import parse_arguments
from arjuna_sim.files.world_file import MAP_SUFFIXES, load_world, robots_in
from arjuna_sim.files.xml_file import BYTES_MAX, root_tag
from arjuna_sim.model.geometry.shapes import Part
from arjuna_sim.model.joints import ControllerKind
from arjuna_sim.model.notes import Note, NoteKind, gathered
from arjuna_sim.model.optical import sensor_frame
from arjuna_sim.model.robot import SOLO, RobotModel, footprint
from arjuna_sim.model.settings import DriveKind, GazeboSettings
from arjuna_sim.model.urdf import Urdf
from arjuna_sim.model.world import World
from arjuna_sim.physics.scene import build_scene
from arjuna_sim.physics.wheels.servo import ServoConfig
from arjuna_sim.sills import crossed_sill
from arjuna_sim.trial import Trial

_TIMESTEP = 0.004  # of a robot that no simulator has stepped yet [s]
_ROBOT_SUFFIXES = (".urdf", ".xacro")
_WORLD_SUFFIXES = (".sdf", ".world", *MAP_SUFFIXES)


@dataclass(frozen=True)
class Found:
    """The result of a check.

    Attributes:
        lines: What was understood, to be printed.
        notes: What was not.
    """

    lines: tuple[str, ...]
    notes: tuple[Note, ...]

    def text(self) -> str:
        """Return all of it, with the notes last."""
        rest = [f"  - {text}" for text in gathered(self.notes)]
        heading = f"not simulated, or otherwise than the file says ({len(rest)}):"
        return "\n".join([*self.lines, heading if rest else "all understood", *rest])


def describe_file(
    path: Path, arguments: Sequence[str] = (), guess: Path | None = None, named: bool = False
) -> str:
    """Return what is understood of a robot, world or map, and what is not.

    Args:
        arguments: Arguments of a xacro file, each `name:=value`.
        named: Whether it is surely a robot's.

    Raises:
        InputFileError: The file does not load, or the guess cannot be written.
        ConfigError: An argument is none.
    """
    read = _check_robot if named else check
    return read(path, SearchPath.of(), parse_arguments(list(arguments)), guess).text()


def check(
    path: Path,
    search: SearchPath,
    arguments: Mapping[str, str],
    guess: Path | None = None,
) -> Found:
    """Load a robot or world as the simulator would.

    Raises:
        InputFileError: It does not load, or the guess cannot be written.
    """
    if split_model(path)[1] or is_robot(path):
        return _check_robot(path, search, arguments, guess)
    if guess is not None:
        raise InputFileError(path, "is a world: only of a robot the drive is guessed")
    robots = robots_in(path, search)
    world = load_world(path, search, without=robots)
    build_scene({}, world, ServoConfig(), _TIMESTEP)
    held = (f"  robot '{name}': --check {path}#{name} says more" for name in robots)
    return Found((f"{path}: loads", *_world_lines(world), *held), world.notes)


def is_robot(path: Path) -> bool:
    """Return whether a file describes a robot rather than a world, by its root, else its suffix.

    An SDF file is a robot's where it holds no `<world>` but a plugin that drives or controls.

    Raises:
        InputFileError: It cannot be read.
    """
    text = read_bytes(path, BYTES_MAX, InputFileError)
    root = root_tag(text)
    if root and path.suffix not in MAP_SUFFIXES:
        return root == "robot" or (b"<world" not in text and names_drive(text))
    if path.suffix not in (*_ROBOT_SUFFIXES, *_WORLD_SUFFIXES):
        valid = ", ".join((*_ROBOT_SUFFIXES, *_WORLD_SUFFIXES))
        raise InputFileError(path, f"is neither <robot> nor <sdf>; valid: {valid}")
    return path.suffix in _ROBOT_SUFFIXES


def _check_robot(
    path: Path, search: SearchPath, arguments: Mapping[str, str], guess: Path | None
) -> Found:
    robot = load_robot(path, search, arguments)
    if guess is not None:
        _refuse_if_found_again(robot, path)
    empty = load_world(shipped_file("worlds/empty.world"))
    support = build_scene({SOLO: robot}, empty, ServoConfig(), _TIMESTEP).robots[SOLO].support
    lines = [f"{path}: loads", *_robot_lines(robot)]
    height = round(support.ride_height, 6) + 0.0  # which is never -0
    lines.append(f"  stands with '{robot.urdf.root}' {height:.4g} m above the ground")
    trial = Trial(robot, empty)
    if math.isfinite(support.steady) and not trial.leans:
        lines.append(f"  neither slips nor tips up to {support.steady:.3g} m/s^2")
    sill = crossed_sill(robot, empty)
    lines += [] if sill is None else [f"  {sill.text()}"]
    if guess is not None:
        save_guess(guess, path, robot.urdf.name, robot.drive)
        lines.append(f"  guess saved as {guess}, which loads instead of the robot")
    # A robot that hardly drives has been told why.
    faults = (*support.faults, *trial.leans, *(() if support.faults else trial.lags))
    return Found(tuple(lines), robot.notes + tuple(Note(NoteKind.CHANGED, t) for t in faults))


def _refuse_if_found_again(robot: RobotModel, path: Path) -> None:
    if not robot.drive.is_guessed:
        problem = "has a drive plugin" if robot.drive.wheels else "has no wheels"
        raise InputFileError(path, f"{problem}, so there is no guess to save")
    if robot.drive.kind is not DriveKind.SIDES:
        problem = f"drives by {robot.drive.kind.value}, which is found again; nothing to save"
        raise InputFileError(path, problem)


def _robot_lines(robot: RobotModel) -> Iterator[str]:
    urdf = robot.urdf
    yield f"robot '{urdf.name}', root link '{urdf.root}'"
    yield f"  links ({len(urdf.links)}):"
    for link in urdf.links.values():
        mass = "massless" if link.inertial is None else f"{link.inertial.mass:.4g} kg"
        solid, drawn = _shapes(link.collisions), _shapes(link.visuals)
        yield f"    {link.name}: {mass}; solid: {solid}; drawn: {drawn}"
    kinds = Counter(joint.kind for joint in urdf.joints.values())
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    yield f"  joints ({len(urdf.joints)}): {counts or 'none'}"
    for joint in urdf.joints.values():
        if joint.kind != "fixed":
            limits = (
                "" if joint.limits is None else f" {joint.limits[0]:.4g} to {joint.limits[1]:.4g}"
            )
            mimic = "" if joint.mimic is None else f", follows {joint.mimic.joint}"
            yield f"    {joint.name}: {joint.kind}{limits}, {joint.parent} -> {joint.child}{mimic}"
    outline = footprint(robot, urdf.root)
    if len(outline):
        yield f"  outline from above, a costmap's footprint: {outline.tolist()}"
    yield from _drive_lines(robot)
    yield from _joint_lines(robot.settings)
    yield from _sensor_lines(robot.settings, urdf)
    frictions = {name: f"{mu:g}" for name, mu in robot.settings.friction.items()}
    yield from (f"  friction of {names}: {mu}" for names, mu in _alike(frictions))
    contacts = {
        name: ", ".join(f"{key} {value:g}" for key, value in values.items())
        for name, values in robot.settings.stiffness.items()
    }
    for names, read in _alike(contacts):
        yield f"  contact of {names}: {read} (the simulator's own tyres hold instead)"


def _alike(texts: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Yield what links have in common, each with those links: wheels have tens of rollers."""
    for text in dict.fromkeys(texts.values()):
        yield ", ".join(name for name, each in texts.items() if each == text), text


def _shapes(parts: tuple[Part, ...]) -> str:
    return ", ".join(_shape(part) for part in parts) or "nothing"


def _shape(part: Part) -> str:
    shape = part.shape
    if shape.mesh is not None:
        return f"mesh {shape.mesh.path.name} ({len(shape.mesh.triangles)} triangles)"
    return f"{shape.kind.value} {' x '.join(f'{size:.4g}' for size in shape.size)}"


def _drive_lines(robot: RobotModel) -> Iterator[str]:
    drive, root = robot.drive, robot.urdf.root
    if not drive.wheels:
        yield f"  drive: none{', fixed to the world' if robot.anchored else ''}"
        return
    source = f"plugin '{drive.plugin}'" if drive.plugin else "guessed (--save-guess FILE keeps it)"
    yield f"  drive: {source}"
    if drive.kind is not DriveKind.SIDES:
        yield f"    by {drive.kind.value}"
    left, right = ", ".join(drive.left), ", ".join(drive.right)
    yield f"    left: {left}; right: {right}" if right else f"    driven: {left}"
    if drive.steering:
        limit = math.degrees(drive.steering_limit)
        yield f"    steers by {', '.join(drive.steering)}, up to {limit:.3g} deg"
    if drive.kind is DriveKind.STEERED:
        bend = SteeredBase.of(robot.urdf, drive).turning_radius
        yield f"    bends of {bend:.3g} m and wider, wheel diameter {drive.diameter:.4g} m"
    else:
        yield f"    wheel separation {drive.separation:.4g} m, diameter {drive.diameter:.4g} m"
    turns = f"turns as a track of {drive.effective_track:.4g} m, "
    turns = turns if drive.kind in (DriveKind.SIDES, DriveKind.TRACKED) else ""
    yield f"    {turns}rolls as a radius of {drive.effective_radius:.4g} m"
    acceleration, turning = map(_or_none, (drive.max_acceleration, drive.max_turn_acceleration))
    yield f"    torque {drive.torque:.4g} N m, acceleration {acceleration} m/s^2, {turning} rad/s^2"
    back = f" (back {drive.max_reverse:.4g} m/s)" if drive.max_reverse else ""
    yield (
        f"    speed {_or_none(drive.max_velocity)} m/s{back}, {_or_none(drive.max_turn)} rad/s,"
        f" rate {_or_none(drive.rate)} Hz"
    )
    if drive.command_timeout is not None:
        yield f"    a command holds for {_forever(drive.command_timeout)}"
    stamped = " (TwistStamped)" if drive.stamped else ""
    yield f"    commands on {drive.command_topic}{stamped}, odometry on {drive.odometry_topic}"
    source = "the world" if drive.from_world else "the encoders"
    named = drive.base_frame not in ("", root)
    other = f" (its root link; the file says {drive.base_frame})" if named else ""
    yield f"    odometry of {source}, {drive.odometry_frame} -> {root}{other}"
    if drive.begins_in_world:
        yield "    in launch files it begins at the pose in the world, as Gazebo Classic's there"
    yield f"    publishes: {', '.join(drive.publishes) or 'nothing'}"


def _or_none(value: float) -> str:
    return f"{value:.4g}" if value > 0.0 else "unlimited"


def _forever(seconds: float) -> str:
    return f"{seconds:.4g} s" if seconds > 0.0 else "ever"


def _joint_lines(settings: GazeboSettings) -> Iterator[str]:
    if settings.driven:
        yield f"  driven joints: {', '.join(joint.name for joint in settings.driven)}"
    for one in settings.controllers:
        if one.kind is not ControllerKind.OTHER:
            where = one.name if one.is_managed else f"on {one.topic}"
            yield f"    {one.kind.value} for {', '.join(one.joints)}: {where}"


def _sensor_lines(settings: GazeboSettings, urdf: Urdf) -> Iterator[str]:
    for sensor in settings.sensors:
        frame = sensor_frame(urdf, sensor).name
        said = "" if frame == sensor.frame else f" ({sensor.frame} in the file)"
        x, y, z = sensor.pose.position
        offset = "" if sensor.pose == ORIGIN else f" + ({x:.4g}, {y:.4g}, {z:.4g})"
        yield (
            f"  {sensor.title}: topic {sensor.topic}, frame {frame}{said}, {sensor.rate:g} Hz,"
            f" on {sensor.link}{offset}"
        )
        if details := sensor.details():
            yield f"    {details}"
    if not settings.sensors:
        yield "  sensors: none"


def _world_lines(world: World) -> Iterator[str]:
    names = list(dict.fromkeys(body.model for body in world.bodies))
    yield f"world '{world.name}': {len(names)} models, {len(world.actors)} actors"
    for name in names:
        bodies = [body for body in world.bodies if body.model == name]
        solid = Counter(b.part.shape.kind.value for b in bodies if b.collides)
        drawn = sum(not body.collides for body in bodies)
        x, y, z = bodies[0].T_world_model.position
        shapes = ", ".join(f"{count} {kind}" for kind, count in sorted(solid.items())) or "nothing"
        yield f"  {name} at {x:.4g} {y:.4g} {z:.4g}: solid: {shapes}; drawn: {drawn}"
    for actor in world.actors:
        yield f"  actor {actor.name}"
