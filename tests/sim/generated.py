"""Robots and worlds made by the number, for what must hold whatever a robot weighs and rolls on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.robots.robot_file import robot_of_text
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import Expanded
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.world import Body, World, ground_bodies

_SIDE = 400.0  # of a slope [m]
_THICK = 0.5
_GRAVITY = 9.81


@dataclass(frozen=True)
class Chassis:
    """A box on wheels.

    Attributes:
        mass: In all [kg].
        radius: Of the wheels [m].
        axles: With two wheels each; one axle has a caster behind it, or one at each end.
        wheel_share: Mass of one wheel, by the whole.
        wheel_spin: Inertia of a wheel about its axis, by that of a disc.
        body_turn: Inertia of the body, by that of its box.
        friction: Of the wheels.
        grip: Torque of all wheels together, by the weight times the radius.
        casters: How many there are of one axle.
        caster: What a caster is: a `sphere`, a `box`, a `roller` that is fixed or a `swivel` wheel.
        caster_radius: Of a caster, by that of the wheels.
        rubs: Friction of a caster, where its file names one.
        low: How far the casters reach below the wheels, by the radius.
        limp: How far the wheels' axles are off their middles, by the radius.
    """

    mass: float = 7.0
    radius: float = 0.05
    axles: int = 2
    wheel_share: float = 0.05
    wheel_spin: float = 1.0
    body_turn: float = 1.0
    friction: float = 1.0
    grip: float = 2.0
    casters: int = 1
    caster: str = "sphere"
    caster_radius: float = 0.5
    rubs: float | None = None
    low: float = 0.0
    limp: float = 0.0

    @property
    def name(self) -> str:
        """Its options, as the id of a test."""
        return (
            f"{2 * self.axles} wheels, {self.mass:.3g} kg, {1e3 * self.radius:.3g} mm, share"
            f" {self.wheel_share:.2g}, spin {self.wheel_spin:.2g}, turn {self.body_turn:.2g},"
            f" mu {self.friction:.2g}, {self.casters} {self.caster} {self.caster_radius:.2g}"
        )

    @property
    def wheelbase(self) -> float:
        """Between the first and the last axle [m]."""
        return 3.0 * self.radius * (self.axles - 1)

    @property
    def track(self) -> float:
        """Between the wheels' middles [m]."""
        return 5.0 * self.radius

    def robot(self) -> RobotModel:
        """Read it as a robot."""
        path = Path("generated.urdf")
        return robot_of_text(path, Expanded(self._urdf()), SearchPath())

    def _urdf(self) -> bytes:
        r, along = self.radius, self._axles()
        names = [(f"{s}{i}", x, y) for i, x in enumerate(along) for s, y in (("l", 1), ("r", -1))]
        wheels = "".join(self._wheel(name, x, y * self.track / 2) for name, x, y in names)
        left, right = (
            "".join(f"<{side}_joint>{n}</{side}_joint>" for n, _, _ in names if n[0] == side[0])
            for side in ("left", "right")
        )
        torque = self.grip * self.mass * _GRAVITY * r / (2 * self.axles)
        plugin = (
            f"<gazebo><plugin name='drive' filename='libgazebo_ros_diff_drive.so'>{left}{right}"
            f"<max_wheel_torque>{torque}</max_wheel_torque></plugin></gazebo>"
        )
        caster = "".join(map(self._caster, range(self.casters))) if self.axles == 1 else ""
        return f"<robot name='generated'>{self._body()}{wheels}{caster}{plugin}</robot>".encode()

    def _axles(self) -> list[float]:
        half = self.wheelbase / 2
        return np.linspace(half, -half, self.axles).tolist() if self.axles > 1 else [0.0]

    def _body(self) -> str:
        r = self.radius
        length, width, height = self.wheelbase + 4.0 * r, 3.6 * r, 2.0 * r
        mass = self.mass * (1.0 - 2 * self.axles * self.wheel_share)
        x = -0.4 * r if self.axles == 1 and self.casters == 1 else 0.0
        inertia = [
            mass / 12.0 * self.body_turn * (a * a + b * b)
            for a, b in ((width, height), (length, height), (length, width))
        ]
        return (
            f"<link name='base'><inertial><origin xyz='{x} 0 {0.6 * r}'/><mass value='{mass}'/>"
            f"{_inertia(*inertia)}</inertial><collision><origin xyz='{x} 0 {0.8 * r}'/><geometry>"
            f"<box size='{length} {width} {height}'/></geometry></collision></link>"
        )

    def _wheel(self, name: str, x: float, y: float) -> str:
        r, mass = self.radius, self.mass * self.wheel_share
        spin = self.wheel_spin * mass * r * r / 2.0
        across = max(mass * r * r / 4.0, 0.51 * spin)
        return (
            f"<link name='wheel_{name}'><inertial><mass value='{mass}'/>"
            f"{_inertia(across, across, spin)}</inertial><collision>"
            f"<origin xyz='{self.limp * r} 0 0'/><geometry>"
            f"<cylinder radius='{r}' length='{0.8 * r}'/></geometry></collision></link>"
            f"<joint name='{name}' type='continuous'><parent link='base'/>"
            f"<child link='wheel_{name}'/><origin xyz='{x} {y} 0' rpy='{-math.pi / 2} 0 0'/>"
            f"<axis xyz='0 0 1'/></joint><gazebo reference='wheel_{name}'>"
            f"<mu1>{self.friction}</mu1><mu2>{self.friction}</mu2></gazebo>"
        )

    def _caster(self, i: int) -> str:
        r, rubs = self.radius, "" if self.rubs is None else f"<mu1>{self.rubs}</mu1>"
        own = self.caster_radius * r
        x, z = (4 * i - 2) * r, own - (1.0 + self.low) * r
        shape, rpy, fork = f"<sphere radius='{own}'/>", "0 0 0", ""
        kind, parent = "fixed", "base"
        if self.caster == "box":
            shape = f"<box size='{2 * own} {own} {2 * own}'/>"
        elif self.caster in ("roller", "swivel"):
            shape, rpy = f"<cylinder radius='{own}' length='{own}'/>", f"{-math.pi / 2} 0 0"
        if self.caster == "swivel":
            kind, parent = "continuous", f"fork{i}"
            fork = (
                f"<link name='fork{i}'><inertial><mass value='{0.02 * self.mass}'/></inertial>"
                f"<visual><geometry><box size='{own} {own} {own}'/></geometry></visual></link>"
                f"<joint name='caster{i}_swivel' type='continuous'><parent link='base'/>"
                f"<child link='fork{i}'/><origin xyz='{x} 0 {z}'/><axis xyz='0 0 1'/></joint>"
            )
            x, z = -0.5 * own, 0.0
        return (
            f"{fork}<link name='caster{i}'><collision><geometry>{shape}</geometry></collision>"
            f"</link><joint name='caster{i}_joint' type='{kind}'><parent link='{parent}'/>"
            f"<child link='caster{i}'/><origin xyz='{x} 0 {z}' rpy='{rpy}'/><axis xyz='0 0 1'/>"
            f"</joint><gazebo reference='caster{i}'>{rubs}</gazebo>"
        )


def _inertia(x: float, y: float, z: float) -> str:
    return f"<inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' iyz='0'/>"


def chassis(count: int, seed: int = 0) -> Iterator[Chassis]:
    """Yield robots of all sizes, by the seed."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        axles = 1 + i % 3
        mass = float(np.exp(rng.uniform(math.log(0.5), math.log(100.0))))
        middle = float(np.clip(0.05 * (mass / 5.0) ** (1 / 3), 0.02, 0.2))
        yield Chassis(
            mass,
            float(np.clip(middle * np.exp(rng.uniform(-0.7, 0.7)), 0.02, 0.2)),
            axles,
            float(np.exp(rng.uniform(math.log(0.002), math.log(0.1)))),
            float(np.exp(rng.uniform(math.log(0.1), math.log(10.0)))),
            float(np.exp(rng.uniform(math.log(0.3), math.log(3.0)))),
            float(rng.uniform(0.8, 1.5)),
        )


def on_casters(count: int, seed: int = 0) -> Iterator[Chassis]:
    """Yield robots of one driven axle, on casters of each kind and of all sizes, by the seed."""
    rng = np.random.default_rng(seed)
    for i, robot in enumerate(chassis(count, seed)):
        yield replace(
            robot,
            axles=1,
            casters=1 + i // 4 % 2,
            caster=("sphere", "roller", "swivel", "box")[i % 4],
            caster_radius=float(rng.uniform(0.15, 0.6)),
            low=float(rng.choice((0.0, -0.01, -0.02))),
        )


def slope(degrees: float, friction: float | None = None) -> World:
    """Return a plane that falls towards -x, of a friction: a robot at the origin faces uphill."""
    angle = math.radians(degrees)
    position = (_THICK / 2 * math.sin(angle), 0.0, -_THICK / 2 * math.cos(angle))
    T = Pose3.from_rpy(position, (0.0, -angle, 0.0))
    part = Part(Shape(Kind.BOX, (_SIDE, _SIDE, _THICK)), T, friction=friction)
    return _world(Body("slope", part, True))


def sill(height: float, x: float, depth: float) -> World:
    """Return level ground with a sill across the path.

    Args:
        height: Of the sill [m].
        x: Where its near edge is [m].
        depth: Of the sill, along the path [m].
    """
    T = Pose3((x + depth / 2, 0.0, height / 2))
    return _world(
        *ground_bodies(), Body("sill", Part(Shape(Kind.BOX, (depth, 20.0, height)), T), True)
    )


def level() -> World:
    """Return level ground."""
    return _world(*ground_bodies())


def _world(*bodies: Body) -> World:
    return World(Path("generated.world"), "generated", bodies, ())
