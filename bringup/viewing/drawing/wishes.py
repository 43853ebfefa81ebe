"""What a person asks for in the picture or the panel, as plain values."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from arjuna_core.se2 import SE2


class Tool(Enum):
    """What a click on the ground does."""

    LOOK = "look around"
    GOAL = "2D goal"
    POSE = "2D pose estimate"
    POINT = "publish point"


HINTS = {
    Tool.LOOK: "Drag to turn the view, right button to shift it, wheel to come closer.",
    Tool.GOAL: "Press where the robot shall go, drag to where it shall look, let go.",
    Tool.POSE: "Press where the robot is, drag to where it looks, let go.",
    Tool.POINT: "Click on the ground.",
}


@dataclass(frozen=True)
class Goal:
    """Drive to a pose in the fixed frame."""

    pose: SE2


@dataclass(frozen=True)
class PoseEstimate:
    """The robot is at a pose in the fixed frame."""

    pose: SE2


@dataclass(frozen=True)
class GroundPoint:
    """A place in the fixed frame [m], for whoever listens."""

    x: float
    y: float


@dataclass(frozen=True)
class Pointed:
    """A place was clicked, or a line drawn, on the ground, in the fixed frame [m].

    Attributes:
        start: Where the button went down.
        end: Where it came up.
    """

    start: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class Take:
    """Take up a tool."""

    tool: Tool


@dataclass(frozen=True)
class Drive:
    """Drive by hand for a moment; it is renewed as long as a button is held down.

    Attributes:
        speed: Forward [m/s].
        turn_rate: To the left [rad/s].
    """

    speed: float
    turn_rate: float


@dataclass(frozen=True)
class Stop:
    """Cancel all goals and stand still."""


@dataclass(frozen=True)
class Manage:
    """Send a lifecycle manager's nodes somewhere: a command of nav2_msgs/ManageLifecycleNodes."""

    command: str


@dataclass(frozen=True)
class ClearCostmaps:
    """Empty all costmaps."""


@dataclass(frozen=True)
class Show:
    """Show or hide a layer."""

    layer: str
    shown: bool


@dataclass(frozen=True)
class Viewers:
    """So many browsers look."""

    count: int


Wish = (
    Goal
    | PoseEstimate
    | GroundPoint
    | Pointed
    | Take
    | Drive
    | Stop
    | Manage
    | ClearCostmaps
    | Show
    | Viewers
)
