"""The links and joints of a robot file."""

from __future__ import annotations

import math

from tests.sim.robot_files.options import RobotFile
from tests.sim.robot_files.tags import box_inertia, fixed, hinged, sphere

_HALF = math.pi / 2
_Frame = tuple[str, str, str]
_WHEEL_FRAMES: dict[str, tuple[_Frame, _Frame]] = {
    # rpy of the joint, its axis, rpy of the shape, for wheels of the left and of the right
    "y": (("0 0 0", "0 1 0", f"{_HALF} 0 0"),) * 2,
    "-y": (("0 0 0", "0 -1 0", f"{_HALF} 0 0"),) * 2,
    "long y": (("0 0 0", "0 2.5 0", f"{-_HALF} 0 0"),) * 2,
    "z": ((f"{-_HALF} 0 0", "0 0 1", "0 0 0"),) * 2,
    "-z": ((f"{_HALF} 0 0", "0 0 -1", "0 0 0"),) * 2,
    "x": ((f"0 0 {_HALF}", "1 0 0", f"0 {_HALF} 0"),) * 2,
    "turned": (
        (f"{-_HALF} 0 0", "0 0 1", "0 0 0"),
        (f"{_HALF} 0 0", "0 0 -1", "0 0 0"),
    ),
    "about": (("0 0 0", "0 1 0", f"{_HALF} 0 0"), (f"0 0 {math.pi}", "0 1 0", f"{_HALF} 0 0")),
    "CAD": (("0 0 0", "-1e-6 1.0 2e-6", "1.570796 0.3 0"),) * 2,
    "spun": ((f"{-_HALF} 0.7 0", "-0.0 0.0 1.0", "0 0 0.4"),) * 2,
}


def base(robot: RobotFile) -> str:
    """Return the links of the base."""
    r, length = robot.radius, 4.0 * robot.radius
    if robot.layout != "two":
        length = 8.0 * r
    box = f"<geometry><box size='{length} {3.2 * r} {1.5 * r}'/></geometry>"
    low = "<link name='base_footprint'/>" + fixed("base_footprint", "base_link", f"0 0 {r}")
    x = -0.5 * r if robot.layout == "two" else 0.0
    own = f"<collision><origin xyz='{-2.5 * r} 0 {-0.5 * r}'/>{sphere(0.5 * r)}</collision>"
    return (
        f"{low if robot.footprint else ''}<link name='base_link'><inertial>"
        f"<origin xyz='{x} 0 {0.5 * r}'/><mass value='{robot.mass}'/>"
        f"{box_inertia(robot.mass, length, 3.2 * r, 1.5 * r)}</inertial>"
        f"<visual><origin xyz='{x} 0 {0.6 * r}'/>{box}</visual>"
        f"<collision><origin xyz='{x} 0 {0.6 * r}'/>{box}</collision>"
        f"{own if robot.layout == 'two' and robot.caster == 'of the base' else ''}</link>"
    )


def wheel(robot: RobotFile, name: str, x: float, y: float) -> str:
    """Return a wheel at a position [m], with what carries it."""
    if robot.layout == "ackermann" and name.startswith("front"):
        return steered(robot, name, x, y, "front_left" if "right" in name else "")
    parent, text = "base_link", ""
    for i in range(robot.hubs):
        share = f"{x / robot.hubs} {y / robot.hubs} 0"
        text += f"<link name='{name}_hub{i}'/>" + fixed(parent, f"{name}_hub{i}", share)
        parent = f"{name}_hub{i}"
    if robot.hubs:
        x = y = 0.0
    return text + _rolling(robot, name, parent, f"{x} {y} 0", right="right" in name)


def _rolling(robot: RobotFile, name: str, parent: str, position: str, right: bool) -> str:
    rpy, axis, own = _WHEEL_FRAMES[robot.frame][int(right)]
    friction = robot.friction
    mu = "" if friction is None else f"<mu1>{friction}</mu1><mu2>{friction}</mu2>"
    if robot.macros:
        return (
            f"<xacro:wheel name='{name}' parent='{parent}' axis='{axis}'>"
            f"<origin xyz='{position}' rpy='{rpy}'/><inside>{_round(robot, own)}</inside>"
            f"</xacro:wheel><gazebo reference='$(arg prefix){name}_wheel_link'>{mu}</gazebo>"
        )
    return (
        f"<link name='{name}_wheel_link'>{_round(robot, own)}</link>"
        f"<joint name='{name}_wheel_joint' type='continuous'><parent link='{parent}'/>"
        f"<child link='{name}_wheel_link'/><origin xyz='{position}' rpy='{rpy}'/>"
        f"<axis xyz='{axis}'/></joint><gazebo reference='{name}_wheel_link'>{mu}</gazebo>"
    )


def _round(robot: RobotFile, rpy: str) -> str:
    """Return what is inside a wheel's link."""
    r, width = robot.radius, 0.6 * robot.radius
    size = f"{2 * r} {2 * r} {width}"
    mirrored = f"{2 * r} {-2 * r} {width}"
    disc = f"<geometry><cylinder radius='{r}' length='{width}'/></geometry>"
    mesh = f"<geometry><mesh filename='{robot.uri}' scale='{size}'/></geometry>"
    other = f"<geometry><mesh filename='{robot.uri}' scale='{mirrored}'/></geometry>"
    seen, solid = {
        "cylinder": (disc, disc),
        "sphere": (disc, sphere(r)),
        "mesh": (mesh, mesh),
        "mirrored mesh": (other, other),
        "drawn mesh": (mesh, ""),
        "drawn cylinder": (disc, ""),
        "none": ("", ""),
    }[robot.solid]
    origin = f"<origin xyz='0 0 0' rpy='{rpy}'/>"
    text = _wheel_inertial(robot, rpy)
    text += f"<visual>{origin}{seen}</visual>" if seen else ""
    return text + (f"<collision>{origin}{solid}</collision>" if solid else "")


def _wheel_inertial(robot: RobotFile, rpy: str) -> str:
    mass, r = max(0.02 * robot.mass, 0.01), robot.radius
    spin, across = mass * r * r / 2.0, mass * r * r / 3.5
    position = "0 0 0"
    xx, yy, zz, xy = {
        "solid": (across, across, spin, 0.0),
        "tiny": (1e-9, 1e-9, 1e-9, 0.0),
        "zero": (0.0, 0.0, 0.0, 0.0),
        "one": (1.0, 1.0, 1.0, 0.0),
        "huge": (30 * across, 30 * across, 30 * spin, 0.0),
        "skew": (across, across, 3.0 * spin, 2.0 * across),
        "offset": (across, across, spin, 0.0),
    }[robot.inertia]
    if robot.inertia == "offset":
        position = f"0 0 {0.1 * r}"
    return (
        f"<inertial><origin xyz='{position}' rpy='{rpy}'/><mass value='{mass}'/>"
        f"<inertia ixx='{xx}' ixy='{xy}' ixz='0' iyy='{yy}' iyz='0' izz='{zz}'/></inertial>"
    )


def steered(robot: RobotFile, name: str, x: float, y: float, follows: str) -> str:
    """Return a wheel that steers, perhaps as another does."""
    mimic = f"<mimic joint='{follows}_steer_joint'/>" if follows else ""
    return (
        f"<link name='{name}_knuckle'><inertial><mass value='0.1'/>{box_inertia(0.1)}"
        f"</inertial></link><joint name='{name}_steer_joint' type='revolute'>"
        f"<parent link='base_link'/><child link='{name}_knuckle'/><origin xyz='{x} {y} 0'/>"
        "<axis xyz='0 0 1'/><limit lower='-0.6' upper='0.6' effort='10' velocity='3'/>"
        f"{mimic}</joint>" + _rolling(robot, name, f"{name}_knuckle", "0 0 0", "right" in name)
    )


def caster(robot: RobotFile, x: float) -> str:
    """Return what it stands on at a position along it [m], beside its wheels."""
    r = robot.radius
    half, mass = 0.5 * r, 0.02 * robot.mass
    inertial = f"<inertial><mass value='{mass}'/>{box_inertia(mass, r, r, r)}</inertial>"
    ball = f"<collision>{sphere(half)}</collision>"
    mesh = f"<geometry><mesh filename='{robot.uri}' scale='{r} {r} {r}'/></geometry>"
    disc = f"<geometry><cylinder radius='{half}' length='{0.3 * r}'/></geometry>"
    box = f"<geometry><box size='{r} {r} {r}'/></geometry>"
    turned = f"<collision><origin rpy='{_HALF} 0 0'/>"
    position = f"{x} 0 {-half}"
    link = "<link name='caster_link'>{}</link>"
    slippery = "<gazebo reference='caster_link'><mu1>0.0</mu1><mu2>0.0</mu2></gazebo>"
    swivel = (
        f"<link name='fork'>{inertial}</link>{hinged('base_link', 'fork', position, '0 0 1')}"
        + link.format(f"{inertial}{turned}{disc}</collision>")
        + hinged("fork", "caster_link", f"{-0.3 * r} 0 0", "0 1 0")
    )
    return {
        "sphere": link.format(ball) + fixed("base_link", "caster_link", position) + slippery,
        "rolling": link.format(inertial + ball)
        + hinged("base_link", "caster_link", position, "0 1 0"),
        "swivel": swivel,
        "of the base": "",
        "mesh": link.format(f"{turned}{mesh}</collision>")
        + fixed("base_link", "caster_link", position),
        "wheel": link.format(f"{inertial}{turned}{disc}</collision>")
        + hinged("base_link", "caster_link", position, "0 1 0"),
        "box": link.format(f"<collision>{box}</collision>")
        + fixed("base_link", "caster_link", position),
    }[robot.caster]
