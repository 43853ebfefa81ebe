"""Bodies that a world's file moves: they keep their velocity, or are pushed along waypoints."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from arjuna_core.twist import Velocity
from arjuna_sim.model.joints import EFFORT, VELOCITY, Gains
from arjuna_sim.model.world import Follower, Motor, Mover
from arjuna_sim.physics.scene import Scene

_MOST = np.array((30.0, 30.0, 100.0))  # as hard as it pushes [m/s^2, m/s^2, rad/s^2]
_NO_GAINS = Gains(0.0)


class Motors:
    """Turns the hinges of models as gz-sim's joint controllers do, each by its last command.

    Args:
        found: By the name of what swings.

    Attributes:
        belts: Those that are belts.
    """

    def __init__(self, found: Mapping[str, Motor]) -> None:
        self._motors = dict(found)
        self.belts = {name for name, motor in found.items() if motor.belt is not None}
        self.rewind()

    def rewind(self) -> None:
        """Take the commands of the start again."""
        self._wanted = {name: motor.start for name, motor in self._motors.items()}
        self._points = dict.fromkeys(self._motors, 0.0)
        self._sums = dict.fromkeys(self._motors, 0.0)

    def command(self, name: str, value: float) -> None:
        """Command one until the next command [rad or m, rad/s or m/s, N m or N]."""
        if math.isfinite(value):
            self._wanted[name] = value

    def run_belts(self, data: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Put belts whose positions and rates `handles` has back, at their speeds."""
        for name in self.belts & handles.keys():
            _, at, rate = handles[name]
            least, most = self._motors[name].belt or (0.0, 0.0)
            data.qpos[at], data.qvel[rate] = 0.0, min(max(self._wanted[name], least), most)

    def drive(self, scene: Scene, data: Any, elapsed: float) -> None:
        """Command those of a scene for a time [s]."""
        found = [self._motors[name] for name in scene.turned]
        wanted = np.array([self._wanted[name] for name in scene.turned])
        now = data.qpos[scene.motors.position]
        is_effort = np.array([motor.command == EFFORT for motor in found], bool)
        is_speed = np.array([motor.command == VELOCITY for motor in found], bool)
        for i, (name, motor) in enumerate(zip(scene.turned, found, strict=True)):
            gains = motor.gains or _NO_GAINS
            summed = self._sums[name] + gains.i * (wanted[i] - now[i]) * elapsed
            self._sums[name] = min(max(summed, -gains.clamp), gains.clamp)
            reach = scene.motors.reach[i]
            self._points[name] = min(max(self._points[name], now[i] - reach), now[i] + reach)
        points = np.array([self._points[name] for name in scene.turned])
        sums = np.array([self._sums[name] for name in scene.turned])
        scene.motors.drive(
            scene.model,
            data,
            is_effort,
            np.where(is_speed, points, wanted),
            is_speed * wanted,
            np.where(is_effort, wanted, ~is_speed * sums),
        )
        for name, speed in zip(scene.turned, is_speed * wanted, strict=True):
            self._points[name] += speed * elapsed


class Movers:
    """Keeps the velocity of bodies in their own frames, as gz-sim's VelocityControl does.

    They fall and do not tip, the ground takes nothing off them, and walls stop them. Followers are
    pushed and turned by forces, as its TrajectoryFollower does: the ground holds them, too.

    Args:
        found: By name.
        followers: By name, too.
        motors: By the name of what they turn.

    Attributes:
        motors: What turns parts of models.
    """

    def __init__(
        self,
        found: Mapping[str, Mover],
        followers: Mapping[str, Follower] = MappingProxyType({}),
        motors: Mapping[str, Motor] = MappingProxyType({}),
    ) -> None:
        self.motors = Motors(motors)
        self._starts = {name: mover.velocity for name, mover in found.items()}
        self._followers = dict(followers)
        self.rewind()

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._starts or self._followers or self.motors.belts)

    def rewind(self) -> None:
        """Take the commands and the waypoints of the start again."""
        self.motors.rewind()
        self._wanted = dict(self._starts)
        self._ways = {name: deque(each.waypoints) for name, each in self._followers.items()}
        self._held: set[str] = set()

    def command(self, name: str, velocity: Velocity) -> None:
        """Command one until the next command."""
        self._wanted[name] = velocity

    def smooth(self, model: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Let nothing rub on those whose bodies' rates `handles` has by name."""
        for name in self._starts.keys() & handles.keys():
            geoms = model.geom_bodyid == model.dof_bodyid[handles[name][2]]
            model.geom_condim[geoms], model.geom_priority[geoms] = 1, 1

    def push(self, model: Any, data: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Push those whose bodies' positions and rates `handles` has."""
        self.motors.run_belts(data, handles)
        for name in self._followers.keys() & handles.keys():
            self._follow(name, model, data, handles[name])
        for name in self._starts.keys() & handles.keys():
            wanted, (_, at, rate) = self._wanted[name], handles[name]
            w, x, y, z = data.qpos[at + 3 : at + 7].tolist()
            yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
            c, s = math.cos(yaw), math.sin(yaw)
            x, y = c * wanted.x - s * wanted.y, s * wanted.x + c * wanted.y
            rates = [rate, rate + 1, rate + 5]
            push = ((x, y, wanted.yaw_rate) - data.qvel[rates]) / model.opt.timestep
            data.qfrc_applied[rates] = model.dof_M0[rates] * np.clip(push, -_MOST, _MOST)
            data.qvel[rate + 3 : rate + 5] = 0.0

    def _follow(self, name: str, model: Any, data: Any, handle: tuple[int, int, int]) -> None:
        """Push a body at its centre of mass to its next waypoint, or turn it there."""
        follower, way, (_, at, rate) = self._followers[name], self._ways[name], handle
        body = model.dof_bodyid[rate]
        turned = data.xmat[body].reshape(3, 3)
        to = turned.T @ (*(way[0] - data.qpos[at : at + 2]), 0.0)
        bearing, push = math.atan2(to[1], to[0]), data.xfrc_applied[body]
        push[:] = 0.0
        if np.linalg.norm(to) <= follower.reach:
            if follower.loop:
                way.rotate(-1)
            elif len(way) > 1:
                way.popleft()
        elif abs(bearing) <= follower.aim:
            push[:3] = follower.force * turned[:, 0]
            if follower.holds and abs(bearing) <= follower.aim / 2:
                self._held.add(name)
        else:
            push[3:] = math.copysign(follower.torque, bearing) * turned[:, 2]
            self._held.discard(name)
        if name in self._held:
            data.qvel[rate + 3 : rate + 6] = 0.0
