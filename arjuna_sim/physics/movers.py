"""Bodies that a world's file moves: they keep their velocity until something holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from arjuna_core.twist import Velocity
from arjuna_sim.model.world import Mover

_MOST = np.array((30.0, 30.0, 100.0))  # as hard as it pushes [m/s^2, m/s^2, rad/s^2]


class Movers:
    """Keeps the velocity of bodies in their own frames, as gz-sim's VelocityControl does.

    They fall and do not tip, the ground takes nothing off them, and walls stop them.

    Args:
        found: By name.
    """

    def __init__(self, found: Mapping[str, Mover]) -> None:
        self._starts = {name: mover.velocity for name, mover in found.items()}
        self.rewind()

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._starts)

    def rewind(self) -> None:
        """Take the commands of the start again."""
        self._wanted = dict(self._starts)

    def command(self, name: str, velocity: Velocity) -> None:
        """Command one until the next command."""
        self._wanted[name] = velocity

    def smooth(self, model: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Let nothing rub on those whose bodies' rates `handles` has by name."""
        for name in self._starts.keys() & handles.keys():
            geoms = model.geom_bodyid == model.dof_bodyid[handles[name][2]]
            model.geom_condim[geoms], model.geom_priority[geoms] = 1, 1

    def push(self, model: Any, data: Any, handles: Mapping[str, tuple[int, int, int]]) -> None:
        """Push those whose bodies' positions and rates `handles` has to their velocities."""
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
