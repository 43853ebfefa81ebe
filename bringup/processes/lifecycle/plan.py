"""The transitions that a lifecycle manager's commands stand for, and their order."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, IntEnum
from typing import NamedTuple


class State(IntEnum):
    """Primary states, numbered as in lifecycle_msgs/State."""

    UNKNOWN = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4


class Command(IntEnum):
    """Commands, numbered as in nav2_msgs/ManageLifecycleNodes."""

    STARTUP = 0
    PAUSE = 1
    RESUME = 2
    RESET = 3
    SHUTDOWN = 4
    CONFIGURE = 5
    CLEANUP = 6


class Transition(Enum):
    """A transition: its number in lifecycle_msgs/Transition, where it starts and where it ends."""

    CONFIGURE = (1, State.UNCONFIGURED, State.INACTIVE)
    CLEANUP = (2, State.INACTIVE, State.UNCONFIGURED)
    ACTIVATE = (3, State.INACTIVE, State.ACTIVE)
    DEACTIVATE = (4, State.ACTIVE, State.INACTIVE)
    SHUTDOWN = (5, State.UNCONFIGURED, State.FINALIZED)

    def __init__(self, number: int, start: State, end: State) -> None:
        self.number, self.start, self.end = number, start, end

    @property
    def upward(self) -> bool:
        """True for a transition towards the active state."""
        return self in (Transition.CONFIGURE, Transition.ACTIVATE)


class Step(NamedTuple):
    """One transition of one node."""

    node: str
    transition: Transition


class Verdict(Enum):
    """The decision about a step in a node's present state."""

    DO = "do"
    SKIP = "skip"
    REFUSE = "refuse"


_PLANS: dict[Command, tuple[Transition, ...]] = {
    Command.STARTUP: (Transition.CONFIGURE, Transition.ACTIVATE),
    Command.PAUSE: (Transition.DEACTIVATE,),
    Command.RESUME: (Transition.ACTIVATE,),
    Command.RESET: (Transition.DEACTIVATE, Transition.CLEANUP),
    Command.SHUTDOWN: (Transition.DEACTIVATE, Transition.CLEANUP, Transition.SHUTDOWN),
    Command.CONFIGURE: (Transition.CONFIGURE,),
    Command.CLEANUP: (Transition.CLEANUP,),
}


def plan(command: Command, nodes: Sequence[str]) -> tuple[Step, ...]:
    """Return each transition of a command for all nodes in order, downward ones last node first."""
    return tuple(
        Step(node, transition)
        for transition in _PLANS[command]
        for node in (nodes if transition.upward else reversed(nodes))
    )


def judge(transition: Transition, state: State) -> Verdict:
    """Return what to do about a transition in a node's present state.

    A node that is there already, or beyond, is left alone, so that a command can be given again
    after it half failed.
    """
    if state == transition.start:
        return Verdict.DO
    if state == State.UNKNOWN:
        return Verdict.REFUSE
    if state == State.FINALIZED:
        return Verdict.REFUSE if transition.upward else Verdict.SKIP
    beyond = state > transition.start if transition.upward else state < transition.start
    return Verdict.SKIP if beyond else Verdict.REFUSE
