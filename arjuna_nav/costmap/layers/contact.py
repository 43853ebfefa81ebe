"""The layer of what has stopped the robot: things that no sensor sees are known by touch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_core.arrays import Bools, Bytes, Floats
from arjuna_core.config import duration_param, fixed, length_param, param
from arjuna_core.grid import GridFrame
from arjuna_core.se2 import IDENTITY, SE2, wrap
from arjuna_core.transforms import TransformError
from arjuna_core.twist import Velocity
from arjuna_nav.costmap.costmap import LETHAL
from arjuna_nav.costmap.layers.base import Input, Layer, Master, moved
from arjuna_nav.costmap.window import Window

_TURNED = 0.2  # a robot that turns by more is not stopped [rad]


@dataclass(frozen=True)
class ContactConfig:
    """Parameters of the contact layer."""

    enabled: bool = param(True, "Whether the layer takes part.", theirs=False)
    topic: str = fixed("cmd_vel", "Commands by which the robot drives.", of_robot="cmd_vel_topic")
    enable_stamped_cmd_vel: bool = fixed(False, "Whether they are TwistStamped.")
    fixed_frame: str = param(
        "map", "Frame in which the robot stands still, though its wheels slip."
    )
    commanded_distance: float = length_param(
        0.3, "Distance commanded after which it is stopped.", minimum=0.05
    )
    moved_distance: float = length_param(0.05, "If it has moved by less.", minimum=0.005)
    memory: float = duration_param(300.0, "How long a contact is marked; 0 for ever.")


class ContactLayer(Layer):
    """Marks what lies ahead of a robot that is commanded to drive and does not move.

    Where another layer knows of an obstacle ahead, nothing is marked: that was touched. Clearing
    the costmap leaves what was touched, for no sensor would see it again.
    """

    Config: ClassVar[type[Any]] = ContactConfig

    def __init__(self, config: ContactConfig, name: str, master: Master) -> None:
        super().__init__(config, name, master)
        self._commands: list[Velocity] = []
        self._contacts: list[tuple[float, Floats]] = []
        self._points = np.zeros((0, 2))
        self._below: Bools = np.zeros(master.frame.shape, np.bool_)
        self._since: SE2 | None = None
        self._pushed, self._at = np.zeros(2), math.inf

    def inputs(self) -> tuple[Input, ...]:
        kind = "TwistStamped" if self.config.enable_stamped_cmd_vel else "Twist"
        return (Input("commands", self.config.topic, kind),)

    def receive(self, source: str, value: Velocity) -> None:
        self._commands.append(value)

    def start(self, now: float) -> None:
        """Begin at a time [s]: contacts of a later one are those of another run."""
        self._commands, self._since, self._at = [], None, now
        self._contacts = [contact for contact in self._contacts if contact[0] <= now]

    def update(self, T_global_base: SE2, now: float) -> Window | None:
        T_fixed_global = self._fixed()
        if self._is_stopped(T_fixed_global @ T_global_base, now):
            points = self._ahead(T_global_base)
            if len(points):
                self._contacts.append((now, T_fixed_global.apply(points)))
        if not self._contacts and not len(self._points):
            return None
        memory, frame = self.config.memory, self.master.frame
        before = frame.to_cells(self._points)
        self._contacts = [one for one in self._contacts if not 0.0 < memory < now - one[0]]
        points = np.vstack([np.zeros((0, 2)), *(one[1] for one in self._contacts)])
        self._points = T_fixed_global.inverse().apply(points)
        after = frame.to_cells(self._points)
        cells = np.vstack((before, after))
        cells = cells[frame.inside(cells)]
        if np.array_equal(before, after) or not len(cells):
            return None
        (row0, column0), (row1, column1) = cells.min(axis=0), cells.max(axis=0) + 1
        return slice(int(row0), int(row1)), slice(int(column0), int(column1))

    def write(self, costs: Bytes, window: Window) -> None:
        self._below[window] = costs == LETHAL
        corner = np.array([window[0].start, window[1].start])
        cells = self.master.frame.to_cells(self._points) - corner
        inside = ((cells >= 0) & (cells < costs.shape)).all(axis=1)
        costs[tuple(cells[inside].T)] = LETHAL

    def move(self, frame: GridFrame) -> None:
        below = moved(self._below.view(np.uint8), self.master.frame, frame, 0)
        self._below = below.view(np.bool_)

    def _fixed(self) -> SE2:
        """Return where the costmap lies in the fixed frame; where that is unknown, it is fixed."""
        own = self.master.config.global_frame
        if self.config.fixed_frame in ("", own):
            return IDENTITY
        try:
            return self.master.transform(self.config.fixed_frame, own)
        except TransformError:
            return IDENTITY

    def _is_stopped(self, pose: SE2, now: float) -> bool:
        """Return whether the robot was commanded to drive on from a pose, and is still there."""
        commands, self._commands = self._commands, []
        since, period, self._at = self._since, max(now - self._at, 0.0), now
        if not commands:
            return False
        pushed = np.mean([(one.x, one.y) for one in commands], axis=0) * min(period, 1.0)
        if since is None or not self._is_at(since, pose):
            self._since, self._pushed = pose, np.zeros(2)  # what was commanded has moved it
            return False
        if float(pushed @ self._pushed) < 0.0:
            self._since, self._pushed = pose, np.zeros(2)
        self._pushed = self._pushed + pushed
        if float(np.hypot(*self._pushed)) < self.config.commanded_distance:
            return False
        self._since = None
        return True

    def _is_at(self, since: SE2, pose: SE2) -> bool:
        turned = abs(wrap(pose.theta - since.theta))
        return since.distance(pose) < self.config.moved_distance and turned < _TURNED

    def _ahead(self, T_global_base: SE2) -> Floats:
        """Return the strip ahead of the outline, as wide as that, `(N, 2)` points [m].

        It is empty where an obstacle is known there.
        """
        outline, cell = self.master.footprint, self.master.frame.resolution
        step = cell * self._pushed / float(np.hypot(*self._pushed))
        reach = outline.circumscribed_radius + 3.0 * cell
        line = np.arange(-reach, reach, cell / 2.0)
        points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        own, ahead = outline.holds(points), outline.holds(points - step)
        near = T_global_base.apply(points[own | ahead | outline.holds(points - 2.0 * step)])
        cells = self.master.frame.to_cells(near)
        cells = cells[self.master.frame.inside(cells)]
        is_known = bool(self._below[tuple(cells.T)].any())
        return T_global_base.apply(points[ahead & ~own & (not is_known)])
