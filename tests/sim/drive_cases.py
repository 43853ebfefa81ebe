"""A generator of robots with any drive: mecanum, omni, steered and in the plane, as URDF files."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path

from tests.sim.robot_files.tags import plugin as plugin
from tests.sim.robot_files.tags import sides

INERTIAL = (
    "<inertial><mass value='{m}'/><inertia ixx='{i}' iyy='{i}' izz='{i}'"
    " ixy='0' ixz='0' iyz='0'/></inertial>"
)


@dataclass(frozen=True)
class Wheel:
    """A wheel of a made-up robot.

    Attributes:
        name: Of its link; its joint is `<name>_joint`.
        x: Where it is [m].
        y: Where it is [m].
        heading: In which it rolls, from the robot's x axis [rad].
        steered: Whether a joint `<name>_steer_joint` turns it about the vertical.
        follows: Name of the wheel whose steering that joint mimics, where it does.
        rolls_with: Name of the joint that the wheel's own mimics, where it does.
        aside: How far to the left of the joint that steers it it stands [m].
    """

    name: str
    x: float
    y: float
    heading: float = 0.0
    steered: bool = False
    follows: str = ""
    rolls_with: str = ""
    aside: float = 0.0


@dataclass(frozen=True)
class Robot:
    """A box on wheels.

    Attributes:
        wheels: The wheels.
        extra: Tags of the file beside links and joints.
        radius: Of the wheels [m].
        mass: Of the box [kg].
        limit: Of steering [rad].
        steering: The kind of its steering joints.
        files: Files beside it, by name.
        middle: Where the box's middle is along x [m].
        rolled: How the box's link is turned in an SDF model, and raised then [rad].
    """

    wheels: tuple[Wheel, ...]
    extra: str = ""
    radius: float = 0.06
    mass: float = 12.0
    limit: float = 0.6
    steering: str = "revolute"
    files: dict[str, str] = field(default_factory=dict)
    middle: float = 0.0
    rolled: float = 0.0

    def write(self, folder: Path, name: str = "made.urdf") -> Path:
        """Write its files; return the URDF."""
        for other, text in self.files.items():
            (folder / other).write_text(text, encoding="utf-8")
        path = folder / name
        origin = f"<origin xyz='{self.middle} 0 0'/>" if self.middle else ""
        inertial = INERTIAL.format(m=self.mass, i=0.02 * self.mass)
        inertial = inertial.replace("<inertial>", f"<inertial>{origin}")
        body = (
            f"<link name='base'>{inertial}<collision>{origin}"
            "<geometry><box size='0.3 0.2 0.06'/></geometry></collision></link>"
        )
        wheels = "".join(map(self._wheel, self.wheels))
        path.write_text(f"<robot name='made'>{body}{wheels}{self.extra}</robot>", encoding="utf-8")
        return path

    def write_sdf(self, folder: Path) -> Path:
        """Write it as an SDF model; return its file."""
        for other, text in self.files.items():
            (folder / other).write_text(text, encoding="utf-8")
        path = folder / "made.sdf"
        path.write_text(f"<sdf version='1.8'>{self.sdf_model('made')}</sdf>", encoding="utf-8")
        return path

    def sdf_model(self, name: str, before: str = "") -> str:
        """Return it as an SDF model, with more tags before its own."""
        turned = f"<pose>0 0 0.1 {self.rolled} 0 0</pose>" if self.rolled else ""
        inertial = _sdf_inertial(self.mass, 0.02 * self.mass)
        body = (
            f"<link name='base'>{turned}{inertial}<collision name='c'>"
            "<geometry><box><size>0.3 0.2 0.06</size></box></geometry></collision></link>"
        )
        wheels = "".join(map(self._sdf_wheel, self.wheels))
        extra = self.extra.replace("<gazebo>", "").replace("</gazebo>", "")
        return f"<model name='{name}'>{before}{body}{wheels}{extra}</model>"

    def _sdf_wheel(self, wheel: Wheel) -> str:
        carrier, steer, inertia = "base", "", 0.4 * 0.4 * self.radius**2
        if wheel.steered:
            carrier = f"{wheel.name}_knuckle"
            limit = f"<limit><lower>-{self.limit}</lower><upper>{self.limit}</upper></limit>"
            steer = (
                f"<link name='{carrier}'><pose>{wheel.x} {wheel.y} 0 0 0 0</pose>"
                f"{_sdf_inertial(0.2, 1e-4)}</link><joint name='{wheel.name}_steer_joint'"
                f" type='revolute'><parent>base</parent><child>{carrier}</child><axis>"
                f"<xyz>0 0 1</xyz>{limit}</axis></joint>"
            )
        return (
            f"{steer}<link name='{wheel.name}'><pose>{wheel.x} {wheel.y} 0 {-math.pi / 2} 0"
            f" {wheel.heading}</pose>{_sdf_inertial(0.4, inertia)}<collision name='c'><geometry>"
            f"<cylinder><radius>{self.radius}</radius><length>0.03</length></cylinder></geometry>"
            f"</collision></link><joint name='{wheel.name}_joint' type='revolute'>"
            f"<parent>{carrier}</parent><child>{wheel.name}</child><axis><xyz>0 0 1</xyz></axis>"
            "</joint>"
        )

    def _wheel(self, wheel: Wheel) -> str:
        carrier, position = "base", f"{wheel.x} {wheel.y} 0"
        steer = ""
        if wheel.steered:
            carrier = f"{wheel.name}_knuckle"
            mimic = wheel.follows and f"<mimic joint='{wheel.follows}_steer_joint'/>"
            steer = (
                f"<link name='{carrier}'>{INERTIAL.format(m=0.2, i=1e-4)}</link>"
                f"<joint name='{wheel.name}_steer_joint' type='{self.steering}'>"
                f"<parent link='base'/><child link='{carrier}'/><origin xyz='{position}'/>"
                "<axis xyz='0 0 1'/>"
                f"<limit lower='-{self.limit}' upper='{self.limit}' effort='9' velocity='9'/>"
                f"{mimic}</joint>"
            )
            position = f"0 {wheel.aside} 0"
        inertia = INERTIAL.format(m=0.4, i=0.4 * 0.4 * self.radius**2)
        mimic = wheel.rolls_with and f"<mimic joint='{wheel.rolls_with}'/>"
        return (
            f"{steer}<link name='{wheel.name}'>{inertia}<collision><geometry>"
            f"<cylinder radius='{self.radius}' length='0.03'/></geometry></collision></link>"
            f"<joint name='{wheel.name}_joint' type='continuous'><parent link='{carrier}'/>"
            f"<child link='{wheel.name}'/>"
            f"<origin xyz='{position}' rpy='{-math.pi / 2} 0 {wheel.heading}'/>"
            f"<axis xyz='0 0 1'/>{mimic}</joint>"
        )


def _sdf_inertial(mass: float, inertia: float) -> str:
    values = "".join(f"<{key}>{inertia}</{key}>" for key in ("ixx", "iyy", "izz"))
    return f"<inertial><mass>{mass}</mass><inertia>{values}</inertia></inertial>"


def control(parameters: str) -> tuple[str, dict[str, str]]:
    """Return the tag of ros2_control's plugin, and the file of its controllers' parameters."""
    tag = plugin("libgz_ros2_control-system.so", "<parameters>controllers.yaml</parameters>")
    return tag, {"controllers.yaml": parameters}


def four(names: str = "{end}_{side}_wheel") -> tuple[Wheel, ...]:
    """Return four wheels at the corners, of which none is steered."""
    return tuple(
        Wheel(names.format(end=end, side=side), x, y)
        for end, x in (("front", 0.15), ("rear", -0.13))
        for side, y in (("left", 0.14), ("right", -0.14))
    )


def mecanum(controlled: bool = False) -> Robot:
    """Return a robot on mecanum wheels."""
    ends = [("front", "front"), ("back", "rear")]
    if controlled:
        lines = [
            f"    {end}_{side}_wheel_command_joint_name: {end}_{side}_wheel_joint\n"
            for _, end in ends
            for side in ("left", "right")
        ]
        text = "mecanum_drive_controller:\n  ros__parameters:\n" + "".join(lines)
        tag, files = control(text)
        return Robot(four(), tag, files=files)
    joints = "".join(
        f"<{given}_{side}_joint>{end}_{side}_wheel_joint</{given}_{side}_joint>"
        for given, end in ends
        for side in ("left", "right")
    )
    return Robot(four(), plugin("gz-sim-mecanum-drive-system", joints))


def planar(more: str = "") -> Robot:
    """Return a robot on wheels called mecanum ones, which Gazebo moves in the plane."""
    topics = f"<command_topic>go</command_topic><odometry_topic>way</odometry_topic>{more}"
    wheels = four("{end}_{side}_mecanum_wheel")
    return Robot(wheels, plugin("libgazebo_ros_planar_move.so", topics))


def planar_on(*wheels: Wheel) -> Robot:
    """Return a robot that Gazebo moves in the plane, on plain wheels, or on none."""
    return Robot(wheels, plugin("gz-sim-velocity-control-system"))


def planar_on_forks() -> Robot:
    """Return a robot that Gazebo moves in the plane, whose wheels stand beside their forks."""
    wheels = (replace(wheel, steered=True, aside=0.03) for wheel in four())
    return replace(planar_on(*wheels), steering="continuous")


def two_axles(rear: str = "") -> Robot:
    """Return a robot with a plugin for each of its axles, and more tags in the rear one's."""
    drive = "gz-sim-diff-drive-system"
    return Robot(four(), plugin(drive, sides("front")) + plugin(drive, sides("rear") + rear))


def tracked(
    ends: bool = False,
    flippers: bool = False,
    low: bool = False,
    classic: bool = False,
    swapped: bool = False,
) -> Robot:
    """Return a robot on two tracks.

    Args:
        ends: Whether the tracks have round ends, else they are boxes.
        flippers: Whether each has another one in front, off the ground.
        low: Whether those are just above it, with a large end behind and a small one in front.
        classic: Whether the plugin is Gazebo Classic's.
        swapped: Whether the left tracks stand on the right.
    """
    round_end = (
        "<collision><origin xyz='{} 0 {}' rpy='1.5708 0 0'/>"
        "<geometry><cylinder radius='{}' length='0.06'/></geometry></collision>"
    )
    solid = "<collision><geometry><box size='0.4 0.06 0.1'/></geometry></collision>"
    solid = "".join(round_end.format(x, 0.0, 0.05) for x in (-0.15, 0.15)) if ends else solid
    flipper = round_end.format(-0.1, 0.0, 0.048) + round_end.format(0.1, 0.1, 0.02)
    extra, names = "", dict[str, list[str]]()
    left = -0.15 if swapped else 0.15
    for side, y in (("left", left), ("right", -left)):
        parts = [("track", 0.0, 0.0, solid)]
        parts += [("flipper", 0.35, 0.1, solid)] if flippers else []
        parts += [("flipper", 0.25, 0.0, flipper)] if low else []
        for name, x, z, shape in parts:
            names.setdefault(side, []).append(f"{side}_{name}")
            extra += (
                f"<link name='{side}_{name}'>{INERTIAL.format(m=1.0, i=0.01)}{shape}</link>"
                f"<joint name='{side}_{name}_joint' type='fixed'><parent link='base'/>"
                f"<child link='{side}_{name}'/><origin xyz='{x} {y} {z}'/></joint>"
            )
    if classic:
        text = "".join(f"<{side}_track>{side}_track</{side}_track>" for side in names)
        return Robot((), extra + plugin("libSimpleTrackedVehiclePlugin.so", text))
    tags = [f"<{side}_track><link>{n}</link></{side}_track>" for side in names for n in names[side]]
    extra += plugin("gz-sim-track-controller-system", "<link>left_track</link>")
    return Robot((), extra + plugin("gz-sim-tracked-vehicle-system", "".join(tags)))


def omni(count: int, controlled: bool = False, classic: bool = False) -> Robot:
    """Return a robot on omni wheels about its middle.

    Args:
        count: Its wheels.
        controlled: Whether ros2_control's controller drives it.
        classic: Whether Gazebo Classic's plugin for three wheels does.
    """
    first = math.pi / 4 if count == 4 else 0.0
    turns = [first + 2.0 * math.pi * i / count for i in range(count)]
    wheels = tuple(
        Wheel(f"w{i}_wheel", 0.16 * math.cos(a), 0.16 * math.sin(a), a + math.pi / 2)
        for i, a in enumerate(turns)
    )
    if classic:
        joints = "".join(
            f"<{side}_joint>w{i}_wheel_joint</{side}_joint>"
            for side, i in (("left", 1), ("right", 2), ("back", 0))
        )
        return Robot(wheels, plugin("libgazebo_ros_omni_3wd_drive.so", joints))
    if not controlled:
        return Robot(wheels)
    names = ", ".join(f"w{i}_wheel_joint" for i in range(count))
    tag, files = control(
        f"omni_wheel_drive_controller:\n  ros__parameters:\n    wheel_names: [{names}]\n"
    )
    return Robot(wheels, tag, files=files)


def car(
    source: str,
    driven: str = "rear",
    steer: str = "revolute",
    *,
    axle: float = -0.16,
    limit: float = 0.5,
) -> Robot:
    """Return a car.

    Args:
        source: What says how it drives: `gz`, `classic`, `control`, or nothing, in which case one
            front wheel's steering mimics the other's.
        driven: Its driven wheels, `rear` or `all`.
        steer: The kind of its steering joints.
        axle: Where its rear axle is; its box and its front axle stay before it [m].
        limit: Of steering, where a plugin says one [rad].
    """
    follows = {"left": "", "right": "" if source else "front_left_wheel"}
    wheels = tuple(
        Wheel(f"{end}_{side}_wheel", x, y, steered=end == "front", follows=follows[side])
        for end, x in (("front", axle + 0.36), ("rear", axle))
        for side, y in (("left", 0.12), ("right", -0.12))
    )
    ends = ("front", "rear") if driven == "all" else ("rear",)
    if source == "control":
        tag, files = control(
            "ackermann_steering_controller:\n  ros__parameters:\n"
            "    traction_joints_names: [rear_right_wheel_joint, rear_left_wheel_joint]\n"
            "    steering_joints_names: [front_right_wheel_steer_joint,"
            " front_left_wheel_steer_joint]\n    use_stamped_vel: false\n"
        )
        return Robot(wheels, tag, files=files)
    if not source:
        return Robot(wheels, steering=steer)
    joints = sides(*ends) + "".join(
        f"<{side}_steering_joint>front_{side}_wheel_steer_joint</{side}_steering_joint>"
        for side in ("left", "right")
    )
    file = "gz-sim-ackermann-steering-system" if source == "gz" else "libgazebo_ros_ackermann_drive"
    joints += f"<steering_limit>{limit}</steering_limit>"
    return Robot(wheels, plugin(file, joints), limit=max(limit, 0.6), middle=axle + 0.16)


def prius() -> Robot:
    """Return a car whose plugin is of no known type, but names wheels and steering joints."""
    tags = "".join(
        f"<{end}_{side}_wheel>{wheel}_{side}_wheel_joint</{end}_{side}_wheel>"
        for end, wheel in (("front", "front"), ("back", "rear"))
        for side in ("left", "right")
    ) + "".join(
        f"<front_{side}_wheel_steering>front_{side}_wheel_steer_joint</front_{side}_wheel_steering>"
        for side in ("left", "right")
    )
    return replace(car("classic"), extra=plugin("libPriusHybridPlugin.so", tags))


def steered_all_round(source: str, limit: float = 0.6, steering: str = "revolute") -> Robot:
    """Return a robot that steers its four wheels.

    Args:
        source: What says so: `gz-sim-fourwids-drive-system` or another plugin, `control` for
            ros2_control's swerve controller, or nothing.
        limit: How far they are steered [rad].
        steering: The kind of the steering joints.
    """
    wheels = tuple(replace(wheel, steered=True) for wheel in four("{end}_{side}_wheel"))
    if not source:
        return Robot(wheels, limit=limit, steering=steering)
    if source == "control":
        text = "swerve:\n  ros__parameters:\n    type: swerve_drive_controller/SwerveController\n"
        text += "    use_stamped_vel: false\n"
        for name in (wheel.name for wheel in wheels):
            text += f"    {name}_joint: {name}_joint\n"
            text += f"    {name.removesuffix('wheel')}axle_joint: {name}_steer_joint\n"
        tag, files = control(text)
        return Robot(wheels, tag, files=files, limit=limit)
    tags = (("END_SIDE_joint", ""), ("END_SIDE_steering_joint", "_steer"))
    if "ros" in source:
        tags = (("SIDEENDJoint", ""), ("swerveSIDEENDJoint", "_steer"))
    joints = "".join(
        f"<{tag}>{end}_{side}_wheel{name}_joint</{tag}>".replace("END", given).replace("SIDE", side)
        for given, end in (("front", "front"), ("back", "rear"))
        for side in ("left", "right")
        for tag, name in tags
    )
    return Robot(wheels, plugin(source, joints), limit=limit, steering=steering)


def car_led(virtual: bool) -> Robot:
    """Return a car of a bicycle's controller, whose other wheels mimic those that it names.

    Args:
        virtual: Whether those are in the middle of the axles, without a shape.
    """
    steer = "<axis xyz='0 0 1'/><limit lower='-0.5' upper='0.5' effort='9' velocity='9'/>"
    roll = "<axis xyz='0 1 0'/><dynamics damping='0.2'/>"
    extra = "".join(
        f"<link name='{name}'/><joint name='{name}_joint' type='{kind}'><parent link='base'/>"
        f"<child link='{name}'/><origin xyz='{x} 0 0'/>{tags}</joint>"
        for name, kind, x, tags in (
            ("virtual_steer", "revolute", 0.2, steer),
            ("virtual_wheel", "continuous", -0.16, roll),
        )
    )
    fronts = ("virtual", "virtual") if virtual else ("", "front_left_wheel")
    rears = ("virtual_wheel_joint",) * 2 if virtual else ("", "rear_left_wheel_joint")
    wheels = [
        Wheel(f"front_{side}_wheel", 0.2, y, steered=True, follows=front)
        for side, y, front in zip(("left", "right"), (0.12, -0.12), fronts, strict=True)
    ]
    wheels += [
        Wheel(f"rear_{side}_wheel", -0.16, y, rolls_with=rear)
        for side, y, rear in zip(("left", "right"), (0.12, -0.12), rears, strict=True)
    ]
    names = ("virtual_wheel", "virtual") if virtual else ("rear_left_wheel", "front_left_wheel")
    tag, files = control(
        "bicycle_steering_controller:\n  ros__parameters:\n"
        f"    rear_wheels_names: [{names[0]}_joint]\n"
        f"    front_wheels_names: [{names[1]}_steer_joint]\n"
    )
    return Robot(tuple(wheels), (extra if virtual else "") + tag, limit=0.5, files=files)


def on_real_rollers(omni: bool, count: int = 8) -> Robot:
    """Return a robot whose wheels are bare hubs with rollers of their own, each on its joint.

    Args:
        omni: Whether they are three omni wheels about its middle, else four mecanum wheels.
        count: Rollers of a wheel.
    """
    wheels = four("{end}_{side}_hub")
    slants: tuple[float, ...] = (1.0, -1.0, -1.0, 1.0)
    if omni:
        turns = [2.0 * math.pi * i / 3 for i in range(3)]
        wheels = tuple(
            Wheel(f"hub{i}", 0.16 * math.cos(a), 0.16 * math.sin(a), a + math.pi / 2)
            for i, a in enumerate(turns)
        )
        slants = (0.0, 0.0, 0.0)
    extra = ""
    for wheel, slant in zip(wheels, slants, strict=True):
        hub = f"<link name='{wheel.name}'>{INERTIAL.format(m=0.4, i=5e-4)}</link>"
        extra += f"{hub}<joint name='{wheel.name}_joint' type='continuous'><parent link='base'/>"
        extra += f"<child link='{wheel.name}'/><origin xyz='{wheel.x} {wheel.y} 0'"
        extra += f" rpy='0 0 {wheel.heading}'/><axis xyz='0 1 0'/></joint>"
        for i in range(count):
            a = 2.0 * math.pi * i / count
            x, y, z = math.cos(a), math.tan(slant * math.pi / 4), -math.sin(a)
            tilt, turn = math.atan2(math.hypot(x, y), z), math.atan2(y, x)
            name = f"{wheel.name}_{i}"
            extra += (
                f"<link name='{name}'>{INERTIAL.format(m=0.01, i=1e-6)}<collision><geometry>"
                "<cylinder radius='0.012' length='0.03'/></geometry></collision></link>"
                f"<joint name='{name}_pin' type='continuous'><parent link='{wheel.name}'/>"
                f"<child link='{name}'/><origin xyz='{0.048 * math.sin(a)} 0"
                f" {0.048 * math.cos(a)}' rpy='0 {tilt} {turn}'/><axis xyz='0 0 1'/></joint>"
            )
    return Robot((), extra)


def own_control(steered: bool = False, rollers: bool = False) -> Robot:
    """Return a robot whose wheels a node of its maker's turns, by controllers of their joints.

    Args:
        steered: Whether each wheel is steered, too.
        rollers: Whether their friction is that of mecanum wheels.
    """
    wheels = tuple(replace(wheel, steered=steered) for wheel in four())
    names = [f"{wheel.name}_joint" for wheel in wheels]
    text = "velocities:\n  ros__parameters:\n    type: velocity_controllers/"
    text += f"JointGroupVelocityController\n    joints: [{', '.join(names)}]\n"
    if steered:
        names = [f"{wheel.name}_steer_joint" for wheel in wheels]
        text += "angles:\n  ros__parameters:\n    type: position_controllers/"
        text += f"JointGroupPositionController\n    joints: [{', '.join(names)}]\n"
    extra, files = control(text)
    if rollers:
        extra += "".join(
            f"<gazebo reference='{wheel.name}'><mu1>1</mu1><mu2>0</mu2>"
            f"<fdir1>1 {-math.copysign(1.0, wheel.x * wheel.y)} 0</fdir1></gazebo>"
            for wheel in wheels
        )
    return Robot(wheels, extra, files=files, limit=3.1)


def tricycle(classic: bool = False) -> Robot:
    """Return a robot whose one front wheel steers and drives.

    Args:
        classic: Whether Gazebo's plugin drives it, else ros2_control.
    """
    wheels = (
        Wheel("front_wheel", 0.2, 0.0, steered=True),
        Wheel("left_wheel", -0.12, 0.13),
        Wheel("right_wheel", -0.12, -0.13),
    )
    if classic:
        joints = "<steering_joint>front_wheel_steer_joint</steering_joint>"
        joints += "<actuated_wheel_joint>front_wheel_joint</actuated_wheel_joint>"
        joints += "<actuated_wheel_diameter>0.12</actuated_wheel_diameter>"
        joints += "<encoder_wheel_left_joint>left_wheel_joint</encoder_wheel_left_joint>"
        joints += "<wheel_separation>0.26</wheel_separation>"
        return Robot(wheels, plugin("libgazebo_ros_tricycle_drive.so", joints))
    tag, files = control(
        "tricycle_controller:\n  ros__parameters:\n    traction_joint_name: front_wheel_joint\n"
        "    steering_joint_name: front_wheel_steer_joint\n"
    )
    return Robot(wheels, tag, files=files)
