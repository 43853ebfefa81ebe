"""Commands of controllers to the wheels of a robot whose file names no drive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_sim.model.robot import RobotModel


class _Part(NamedTuple):
    """The part of a controller that commands wheels, or the joints that steer them.

    Attributes:
        what: What it commands: 0 the wheels' speeds, 1 the angles of steering, 2 their torques.
        joints: Which of all wheels or of all steering joints.
        order: Which of its values are for those.
    """

    controller: str
    what: int
    joints: Ints
    order: Ints


class WheelCommands:
    """The wheels that a controller turns once it is commanded, in place of the guessed drive."""

    def __init__(self, robot: RobotModel) -> None:
        self._parts = list(_parts(robot))

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._parts)

    def over(
        self, values: Mapping[str, Floats], speeds: Floats, angles: Floats
    ) -> tuple[Floats, Floats, Floats | None]:
        """Return how wheels turn [rad/s] and steer [rad], and what pushes them [N m].

        Of the torques those of wheels that are not pushed are no number; None where none is.

        Args:
            values: Last commands of the active controllers; no number before the first.
            speeds: Of the wheels, as the drive wants them.
            angles: Of the steering, as the drive wants it.
        """
        found = [speeds, angles, np.full(len(speeds), np.nan)]
        for part in self._parts:
            own = values.get(part.controller)
            if own is None or not np.isfinite(own[part.order]).any():
                continue
            given = np.isfinite(own[part.order])
            found[part.what] = found[part.what].copy()
            found[part.what][part.joints[given]] = own[part.order][given]
        return found[0], found[1], found[2] if np.isfinite(found[2]).any() else None


def _parts(robot: RobotModel) -> Iterator[_Part]:
    for controller in robot.settings.controllers:
        for steers, names in ((False, robot.drive.wheels), (True, robot.drive.steering)):
            own = enumerate(controller.joints)
            pairs = [(names.index(name), i) for i, name in own if name in names]
            if pairs and controller.turns_wheels(robot.drive.plugin, steers):
                joints, order = np.array(pairs, np.int64).T
                yield _Part(controller.name, 2 if controller.is_push else steers, joints, order)
