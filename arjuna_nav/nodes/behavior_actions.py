"""The behaviours as nav2_msgs' actions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nav2_msgs import action

from arjuna_core.config import NoParameters
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros.convert import duration_msg, seconds
from arjuna_nav.behaviors.base import Behavior, BehaviorStatus, InvalidGoalError
from arjuna_nav.behaviors.motions import AssistedTeleop, DriveConfig, DriveOnHeading, Spin, Wait


@dataclass(frozen=True)
class BehaviorAction:
    """One behaviour as an action.

    Attributes:
        make: Makes the behaviour from a goal; of one that moves, also from the parameters, the
            footprint and the time allowance, and its own parameters if it has any.
        feedback: Makes the feedback from the behaviour's progress.
        moves: Whether it drives, so that it needs the robot's pose and a costmap.
        area: The costmap that it needs, `local` or `global`.
        unknown: Error code of an unknown failure, where the action itself names none.
        Config: Its own parameters; those of all behaviours stand at behavior_server.
    """

    type: Any
    make: Callable[..., Behavior]
    feedback: Callable[[float], Any]
    moves: bool = True
    area: str = "local"
    unknown: int = 0
    Config: type[Any] = NoParameters

    def error_code(self, status: BehaviorStatus) -> int:
        """Return the action's code for how it failed; one that it does not name is unknown."""
        codes = self.type.Result
        return int(getattr(codes, status.name, getattr(codes, "UNKNOWN", self.unknown)))


def _along_x(target: Any) -> float:
    if target.y or target.z:
        raise InvalidGoalError(f"target ({target.x:g}, {target.y:g}, {target.z:g}) is not on x")
    return float(target.x)


SPIN = BehaviorAction(
    action.Spin,
    lambda goal, *rest: Spin(goal.target_yaw, *rest),
    lambda angle: action.Spin.Feedback(angular_distance_traveled=angle),
)
BACKUP = BehaviorAction(
    action.BackUp,
    lambda goal, *rest: DriveOnHeading(  # of either sign, as in nav2_behaviors
        -abs(_along_x(goal.target)), -abs(goal.speed), *rest
    ),
    lambda distance: action.BackUp.Feedback(distance_traveled=distance),
    Config=DriveConfig,
)
DRIVE_ON_HEADING = BehaviorAction(
    action.DriveOnHeading,
    lambda goal, *rest: DriveOnHeading(_along_x(goal.target), goal.speed, *rest),
    lambda distance: action.DriveOnHeading.Feedback(distance_traveled=distance),
    Config=DriveConfig,
)
ASSISTED_TELEOP = BehaviorAction(
    action.AssistedTeleop,
    lambda goal, *rest: AssistedTeleop(*rest),
    lambda time: action.AssistedTeleop.Feedback(current_teleop_duration=duration_msg(time)),
)
WAIT = BehaviorAction(
    action.Wait,
    lambda goal: Wait(seconds(goal.time)),
    lambda time: action.Wait.Feedback(time_left=duration_msg(time)),
    moves=False,
    unknown=740,
)
BEHAVIORS = PluginTypes(
    "behavior",
    {
        f"nav2_behaviors::{name}": f"{__name__}:{constant}"
        for name, constant in (
            ("Spin", "SPIN"),
            ("BackUp", "BACKUP"),
            ("DriveOnHeading", "DRIVE_ON_HEADING"),
            ("AssistedTeleop", "ASSISTED_TELEOP"),
            ("Wait", "WAIT"),
        )
    },
    "nav2_behaviors::Wait",
    {
        "spin": "nav2_behaviors::Spin",
        "backup": "nav2_behaviors::BackUp",
        "drive_on_heading": "nav2_behaviors::DriveOnHeading",
        "assisted_teleop": "nav2_behaviors::AssistedTeleop",
    },
)
"""Behaviours by Nav2's class names; a user's own is a `module:BehaviorAction`."""
DEFAULT_BEHAVIORS = ("spin", "backup", "drive_on_heading", "assisted_teleop", "wait")
