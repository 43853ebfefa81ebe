"""Commands of driven joints: which controller commands which joint, and each joint's setpoint."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_core.errors import ArjunaError, nearest
from arjuna_sim.devices.driving.trajectory import Trajectory
from arjuna_sim.devices.driving.wheel_commands import WheelCommands
from arjuna_sim.model.joints import VELOCITY, ControllerKind, ControllerSettings
from arjuna_sim.model.robot import RobotModel

UNLOADED, UNCONFIGURED, INACTIVE, ACTIVE = "", "unconfigured", "inactive", "active"
"""States of a controller; it is unloaded where only its file names it."""


class JointCommands(NamedTuple):
    """Setpoints of a tick, in the order of `GazeboSettings.driven`, each `(N,)`.

    Attributes:
        is_effort: Which push with an effort; the others follow a position.
        position: Wanted at the tick's start [rad or m].
        velocity: How fast that changes [rad/s or m/s].
        effort: The effort, or what is added to that of the servo [N m or N].
    """

    is_effort: Bools
    position: Floats
    velocity: Floats
    effort: Floats


class ControllerError(ArjunaError):
    """A controller cannot do what it is asked for."""


class _Running:
    """A controller as it runs.

    Attributes:
        values: The last command, for each of its joints; before the first no effort, and of other
            commands what is not a number.
        path: The trajectory that is followed, and the time when it began [s].
        yields: Whether it is active because no client has chosen, so that any choice displaces it.
    """

    def __init__(self, settings: ControllerSettings, index: Sequence[int]) -> None:
        self.settings = settings
        self.joints = np.array(index, np.int64)
        self.state, self.yields = ACTIVE, True
        self.stop()

    def stop(self) -> None:
        self.values = np.full(len(self.joints), 0.0 if self.settings.is_push else np.nan)
        self.path: tuple[Trajectory, float] | None = None


class JointControllers:
    """The controllers of a robot's driven joints.

    From the start all are active that claim different joints, until a client chooses others. A
    joint that no active controller commands is held where it is. Wheels that no file gives to a
    drive are a controller's from its first command on.

    Args:
        robot: The robot, its joints named as in its file.
    """

    def __init__(self, robot: RobotModel) -> None:
        driven = robot.settings.driven
        self.names = tuple(joint.name for joint in driven)
        self.initial = np.array([joint.initial for joint in driven], np.float64)
        joints = [robot.urdf.joints[name] for name in self.names]
        free = -np.inf, np.inf
        limits = [j.limits if j.limits and j.limits[0] < j.limits[1] else free for j in joints]
        self._low, self._high = np.array(limits, np.float64).reshape(-1, 2).T
        self._speed = np.array([joint.max_speed or np.inf for joint in joints])
        # [rad/s or m/s] A joint that jumps to a position and has no limit goes so fast.
        self._jump = np.minimum(
            self._speed, [1.0 if j.kind == "prismatic" else np.pi for j in joints]
        )
        self._gains = [joint.gains for joint in driven]
        self._running: dict[str, _Running] = {}
        for settings in robot.settings.controllers:
            index = [self.names.index(n) if n in self.names else -1 for n in settings.joints]
            running = _Running(settings, index)
            running.state = INACTIVE if self._blockers(settings) else ACTIVE
            self._running[settings.name] = running
        self._wheels = WheelCommands(robot)
        self.rest(self.initial)

    def _blockers(self, wanted: ControllerSettings) -> list[str]:
        """Return the active controllers that claim a joint which another one wants."""
        joints = {claim.rpartition("/")[0] for claim in wanted.claims}
        return [
            settings.name
            for settings, state in self.states
            if state == ACTIVE
            and settings.name != wanted.name
            and joints & {claim.rpartition("/")[0] for claim in settings.claims}
        ]

    @property
    def states(self) -> list[tuple[ControllerSettings, str]]:
        """All controllers and their states, in the file's order."""
        return [(running.settings, running.state) for running in self._running.values()]

    @property
    def claimed(self) -> set[str]:
        """The claims of active controllers."""
        return {c for settings, state in self.states if state == ACTIVE for c in settings.claims}

    @property
    def is_pushed(self) -> bool:
        """True where an active controller hands on efforts."""
        return any(settings.is_push and state == ACTIVE for settings, state in self.states)

    def _find(self, name: str) -> _Running:
        if name not in self._running:
            problem = f"controller '{name}' does not exist; {nearest(name, self._running)}"
            raise ControllerError(problem)
        return self._running[name]

    def set_state(self, name: str, state: str, allowed: Iterable[str]) -> None:
        """Put a controller from one of some states into another.

        Raises:
            ControllerError: It does not exist, or is in none of these states.
        """
        found = self._find(name)
        if found.state not in allowed:
            valid = " or ".join(allowed)
            state = found.state or "not loaded"
            raise ControllerError(f"controller '{name}' is {state}; valid: {valid or 'not loaded'}")
        found.state = state
        found.stop()

    def switch(self, activate: Sequence[str], deactivate: Sequence[str], forced: bool) -> None:
        """Deactivate controllers and activate others.

        Args:
            forced: Whether those that command the same joints are deactivated too.

        Raises:
            ControllerError: One does not exist, is not configured or would command a joint that
                another one commands; nothing has changed.
        """
        before = {name: copy.copy(running) for name, running in self._running.items()}
        try:
            for name in deactivate:
                self.set_state(name, INACTIVE, (ACTIVE, INACTIVE))
            for name in activate:
                self._activate(name, forced)
        except ControllerError:
            self._running = before
            raise

    def _activate(self, name: str, forced: bool) -> None:
        found = self._find(name)
        if found.state == ACTIVE:
            return
        blockers = self._blockers(found.settings)
        chosen = [other for other in blockers if not self._running[other].yields]
        if chosen and not forced:
            listed = ", ".join(f"'{other}'" for other in chosen)
            problem = f"controller '{name}' wants joints that {listed} commands"
            raise ControllerError(f"{problem}; deactivate that in the same call")
        for other in blockers:
            self.set_state(other, INACTIVE, (ACTIVE,))
        self.set_state(name, ACTIVE, (INACTIVE,))
        found.yields = False

    def rest(self, positions: Floats) -> None:
        """Hold the joints at positions [rad or m], and forget all commands."""
        self._wanted, self._moving = positions.copy(), np.zeros(len(positions))
        self._sum = np.zeros(len(positions))
        for running in self._running.values():
            running.stop()

    def command(self, name: str, values: Sequence[float]) -> None:
        """Command a controller's joints, by one value for all or one for each.

        Raises:
            ControllerError: They are too few or too many, or not finite; or it is not active.
        """
        found = self._active(name)
        if len(values) not in (1, len(found.joints)):
            problem = f"'{name}' got {len(values)} values; it has {len(found.joints)} joints"
            raise ControllerError(problem)
        if not np.isfinite(values).all():
            raise ControllerError(f"'{name}' got {list(values)}; all must be finite")
        found.values, found.path = np.broadcast_to(values, len(found.joints)).copy(), None

    def _active(self, name: str) -> _Running:
        found = self._find(name)
        if found.state != ACTIVE:
            raise ControllerError(f"controller '{name}' is {found.state}; activate it first")
        return found

    def follow(
        self, name: str, joints: Sequence[str], path: Trajectory, begin: float
    ) -> Trajectory:
        """Follow a trajectory of some joints of a controller from a time on [s].

        Returns:
            What is followed, of all its joints: from where they are wanted now.

        Raises:
            ControllerError: It is not active, has other joints, or all must be named.
        """
        self.check_joints(name, joints)
        found = self._find(name)
        own = found.settings.joints
        # joints without a motor stay at 0
        now, moving = (np.append(v, 0.0)[found.joints] for v in (self._wanted, self._moving))
        order = [own.index(joint) for joint in joints]
        rest = np.zeros((len(path.times), len(own)))
        tables = rest + now, rest.copy(), rest.copy()
        for table, given in zip(
            tables, (path.positions, path.velocities, path.accelerations), strict=True
        ):
            table[:, order] = given
        whole = Trajectory(path.times, *tables).starting_at(now, moving)
        found.values, found.path = np.full(len(own), np.nan), (whole, begin)
        return whole

    def check_joints(self, name: str, joints: Sequence[str]) -> None:
        """Refuse joints that a trajectory of a controller cannot have.

        Raises:
            ControllerError: It is not active, has other joints, or all must be named.
        """
        found = self._active(name)
        own = found.settings.joints
        if unknown := [joint for joint in joints if joint not in own]:
            raise ControllerError(f"joint '{unknown[0]}' is none of {', '.join(own)}")
        missing = [joint for joint in own if joint not in joints]
        if missing and not found.settings.partial:
            raise ControllerError(f"joint '{missing[0]}' is missing; all must be named")

    def path(self, name: str) -> Trajectory | None:
        """Return the trajectory that a controller follows, None for none."""
        path = self._find(name).path
        return None if path is None else path[0]

    def hold(self, name: str) -> None:
        """Stop a controller's joints where they are wanted now."""
        self._find(name).stop()

    def update(self, now: float, tick: float, at: Floats) -> JointCommands:
        """Return what the joints do in a tick.

        Args:
            now: The time at its start [s].
            tick: How long it is [s].
            at: The joints' positions [rad or m].
        """
        count = len(self.names)
        is_effort, effort, velocity = np.zeros(count, bool), np.zeros(count), np.zeros(count)
        for running in self._running.values():
            if running.state != ACTIVE:
                continue
            given = np.isfinite(running.values) & (running.joints >= 0)
            joints, values = running.joints[given], running.values[given]
            command = running.settings.command
            if running.path is not None:
                path, begin = running.path
                own = running.joints >= 0
                joints = running.joints[own]
                velocity[joints] = (path.at(now + tick - begin)[own] - self._wanted[joints]) / tick
            elif running.settings.is_push:
                is_effort[joints], effort[joints] = True, values
                self._wanted[joints] = at[joints]
            elif command == VELOCITY and running.settings.kind is ControllerKind.FORWARD:
                velocity[joints] = values
                # [rad or m] What is held fast is not made up for.
                behind = np.clip(self._wanted[joints] - at[joints], -0.1, 0.1)
                self._wanted[joints] = at[joints] + behind
            else:
                velocity[joints] = self._towards(joints, values, tick)
        velocity = np.clip(velocity, -self._speed, self._speed)
        position = self._wanted
        self._wanted = np.clip(position + velocity * tick, self._low, self._high)
        self._moving = velocity = (self._wanted - position) / tick
        return JointCommands(
            is_effort, position, velocity, effort + self._integral(position - at, tick)
        )

    def of_wheels(self, speeds: Floats, angles: Floats) -> tuple[Floats, Floats, Floats | None]:
        """Return what `WheelCommands.over` does, given the speeds and angles of the drive."""
        if not self._wheels:
            return speeds, angles, None
        active = {n: one.values for n, one in self._running.items() if one.state == ACTIVE}
        return self._wheels.over(active, speeds, angles)

    def _towards(self, joints: Ints, values: Floats, tick: float) -> Floats:
        """Return how fast joints go to positions, as far as they may jump."""
        speed: Floats = (values - self._wanted[joints]) / tick
        return np.clip(speed, -self._jump[joints], self._jump[joints])

    def _integral(self, error: Floats, tick: float) -> Floats:
        """Return the efforts of integral gains, where files give them."""
        for i, gains in enumerate(self._gains):
            if gains is not None:
                self._sum[i] += gains.i * error[i] * tick
                self._sum[i] = np.clip(self._sum[i], -gains.clamp, gains.clamp)
        return self._sum
