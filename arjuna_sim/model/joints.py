"""Joints that are driven, and the controllers that command them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

POSITION, VELOCITY, EFFORT = "position", "velocity", "effort"
COMMANDS = (POSITION, VELOCITY, EFFORT)
"""Interfaces by which joints are commanded, as ros2_control names them."""


@dataclass(frozen=True)
class Gains:
    """Gains of a joint's servo, in effort per error of position.

    Attributes:
        clamp: Greatest effort of the integral.
    """

    p: float
    i: float = 0.0
    d: float = 0.0
    clamp: float = math.inf


@dataclass(frozen=True)
class DrivenJoint:
    """A joint with a motor.

    Attributes:
        commands: Interfaces by which it may be commanded.
        states: Interfaces that report it.
        initial: Its position at the start [rad or m].
        gains: Its servo's, where the file gives them; else they are derived from what it moves.
    """

    name: str
    commands: tuple[str, ...] = COMMANDS
    states: tuple[str, ...] = COMMANDS
    initial: float = 0.0
    gains: Gains | None = None


class ControllerKind(Enum):
    """The form of a controller's commands."""

    FORWARD = "values"
    TRAJECTORY = "trajectories"
    GRIPPER = "positions of a gripper"
    OTHER = "nothing of joints"


@dataclass(frozen=True)
class ControllerSettings:
    """A controller of joints, of ros2_control or a plug-in of Gazebo.

    Attributes:
        type: Its class, as the file has it.
        command: The interface by which it commands its joints.
        claims: All interfaces that it claims, as `elbow/position`.
        topic: Of its commands.
        is_managed: Whether it is one of controller_manager's, with topics below its name.
        partial: Whether a trajectory may leave out joints.
        path_tolerance: Greatest error of each joint on its path, 0 for any [rad or m].
        goal_tolerance: Greatest error at the goal, 0 for any [rad or m].
        goal_time: How late the goal may be reached, 0 for ever [s].
        stopped_velocity: Greatest speed at the goal, 0 for any [rad/s or m/s].
        stall_timeout: A gripper stalls where it stands so long [s].
        allow_stalling: Whether a gripper that stalls has succeeded.
    """

    name: str
    type: str
    kind: ControllerKind
    joints: tuple[str, ...] = ()
    command: str = POSITION
    claims: tuple[str, ...] = ()
    topic: str = ""
    is_managed: bool = True
    partial: bool = False
    path_tolerance: tuple[float, ...] = ()
    goal_tolerance: tuple[float, ...] = ()
    goal_time: float = 0.0
    stopped_velocity: float = 0.01
    stall_timeout: float = 1.0
    allow_stalling: bool = False

    @property
    def is_push(self) -> bool:
        """True where its commands are efforts."""
        return self.kind is ControllerKind.FORWARD and self.command == EFFORT

    def turns_wheels(self, drive: str, steers: bool) -> bool:
        """Return whether it turns wheels, pushes or steers them, that a drive turns otherwise.

        Args:
            drive: Name of the plugin that drives them; "" for a drive that was guessed.
        """
        commands = (POSITION,) if steers else (VELOCITY, EFFORT)
        return not drive and self.kind is ControllerKind.FORWARD and self.command in commands
