"""Bodies that a world's file moves: they keep their velocity, or are pushed along waypoints."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from arjuna_core.twist import Velocity
from arjuna_sim.model.joints import EFFORT, POSITION, Gains
from arjuna_sim.model.world import Follower, Motor, Mover

_MOST = np.array((30.0, 30.0, 100.0))  # as hard as it pushes [m/s^2, m/s^2, rad/s^2]
_RESPONSE = 0.05  # [s] of a motor whose file gives no gains


class Motors:
    """Turns the hinges of models as gz-sim's joint controllers do, each by its last command.

    Args:
        found: By the name of what swings.
    """

    def __init__(self, found: Mapping[str, Motor]) -> None:
        self._motors = dict(found)
        self.rewind()

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._motors)

    def rewind(self) -> None:
        """Take the commands of the start again."""
        self._wanted = {name: motor.start for name, motor in self._motors.items()}
        self._sums = dict.fromkeys(self._motors, 0.0)

    def command(self, name: str, value: float) -> None:
        """Command one until the next command [rad or m, rad/s or m/s, N m or N]."""
        if math.isfinite(value):
            self._wanted[name] = value

    def push(self, model: Any, data: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Turn those whose positions and rates `handles` has."""
        step = model.opt.timestep
        for name in self._motors.keys() & handles.keys():
            motor, wanted, (_, at, rate) = self._motors[name], self._wanted[name], handles[name]
            speed, moved = data.qvel[rate], model.dof_M0[rate]
            effort, most = wanted, motor.most
            if motor.command == POSITION:
                off = wanted - data.qpos[at]
                effort = self._servo(name, model, data, (off, speed), rate)
            elif motor.command != EFFORT:
                carried = _carried(data, rate) + model.dof_damping[rate] * wanted
                effort = carried + moved * (wanted - speed) / step
                most = min(most, abs(carried) + _MOST[2] * moved)
            data.qfrc_applied[rate] = min(max(effort, -most), most)

    def _servo(
        self, name: str, model: Any, data: Any, state: tuple[float, float], rate: int
    ) -> float:
        """Return the effort to a position, of gains by the error and speed at the step's end."""
        (off, speed), step, moved = state, model.opt.timestep, model.dof_M0[rate]
        gains, carried = self._motors[name].gains, 0.0
        if gains is None:
            # [rad or m] Dry friction keeps it so far from where it is to be.
            stiffness = max(moved / _RESPONSE**2, model.dof_frictionloss[rate] / 1e-3)
            gains = Gains(stiffness, d=2.0 * math.sqrt(stiffness * moved))
            carried = _carried(data, rate)
        summed = self._sums[name] + gains.i * off * step
        self._sums[name] = summed = min(max(summed, -gains.clamp), gains.clamp)
        damping = gains.d + step * gains.p
        pushed = gains.p * off - damping * speed + summed + carried
        return float(pushed / (1.0 + step * damping / moved))


def _carried(data: Any, rate: int) -> float:
    """Return the effort that holds a hinge against what pulls at it."""
    return float(data.qfrc_bias[rate] - data.qfrc_gravcomp[rate])


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
        return bool(self._starts or self._followers or self.motors)

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
        self.motors.push(model, data, handles)
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
