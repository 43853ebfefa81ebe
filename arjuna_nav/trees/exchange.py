"""The requests of trees to the robot's servers, and their answers."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from arjuna_core.se2 import SE2
from arjuna_core.twist import STILL, Velocity


@dataclass(frozen=True, eq=False)
class Ask:
    """A request to a server of an action or service `kind`; its answer comes under the same key.

    The fields are plain values by nav2_msgs' names: poses as SE2, paths `(N, 3) float64`,
    durations [s]. An action takes the goal, and a service answers, within the timeout [s], that
    of all servers if 0.
    """

    key: int
    kind: str
    server: str
    fields: Mapping[str, Any]
    feedback: bool = False
    timeout: float = 0.0


@dataclass(frozen=True)
class Withdraw:
    """Cancel what was asked; no answer of it counts any more."""

    key: int


@dataclass(frozen=True, eq=False)
class Answer:
    """A server's answer, its result in plain values as in `Ask`; code 0 is no error."""

    succeeded: bool
    code: int = 0
    message: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)


class TopicKind(enum.Enum):
    """The kinds of topics that trees listen to."""

    CHOICE = enum.auto()
    GOAL = enum.auto()
    BATTERY = enum.auto()
    CALL = enum.auto()
    """A service without fields that is offered, not a topic."""


class Topic(NamedTuple):
    """A topic that a tree listens to."""

    kind: TopicKind
    name: str


class Battery(NamedTuple):
    """A battery: share (0..1) that is left, voltage [V], and whether it is being charged."""

    share: float
    voltage: float
    charges: bool


@dataclass(frozen=True, eq=False)
class TreeState:
    """The state of the robot and of the requests at a tick of a tree.

    Attributes:
        now: Time [s].
        pose: Of the robot in the global frame, None where it is not known.
        measured_at: When it had that velocity [s].
        feedback: The newest of what is asked and not answered yet, once, in plain values.
        selected: What was chosen on the selectors' topics.
        moved_goal: The newest pose on the topic goal_update since the goal came.
        batteries: By their topics.
        transform: Returns where the second frame is in the first, None where that is not known;
            the navigator's own frames stand for empty names.
        mean_velocity: Returns the robot's over `filter_duration`.
    """

    now: float
    pose: SE2 | None = None
    velocity: Velocity = STILL
    measured_at: float = 0.0
    answers: Mapping[int, Answer] = field(default_factory=dict)
    feedback: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    selected: Mapping[str, str] = field(default_factory=dict)
    moved_goal: SE2 | None = None
    batteries: Mapping[str, Battery] = field(default_factory=dict)
    transform: Callable[[str, str], SE2 | None] = lambda parent, child: None
    mean_velocity: Callable[[], Velocity] = lambda: STILL

    def robot(self, frame: str = "", base: str = "") -> SE2 | None:
        """Return where a frame of the robot is in another, None where that is not known."""
        return self.transform(frame, base) if frame or base else self.pose


@dataclass(frozen=True)
class StatusChange:
    """A change of a node's status at a time [s], as nav2_msgs/BehaviorTreeStatusChange.

    `uid` is the node's number in the tree, in the order of the file.
    """

    now: float
    node: str
    uid: int
    before: str
    after: str
