"""Something that is tried once more after a costmap was cleared."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from arjuna_nav.commands import Clear, Command, NavigatorState, Outcome


class Step(enum.Enum):
    """Where an attempt is."""

    IDLE = enum.auto()
    RUNNING = enum.auto()
    CLEARING = enum.auto()


@dataclass
class Attempt:
    """Planning or following, with a second try.

    Attributes:
        costmap: What is cleared before it.
        retryable: Error codes that it may mend.
        step: Where it is.
        retried: Whether it is the second try.
    """

    costmap: str
    retryable: frozenset[int]
    step: Step = Step.IDLE
    retried: bool = False

    def reset(self) -> None:
        """Begin anew, with both tries."""
        self.step, self.retried = Step.IDLE, False

    def is_cleared(self, state: NavigatorState) -> bool:
        """Tell whether the costmap is clear for the second try."""
        return self.step is Step.CLEARING and self.costmap in state.cleared

    def failed(self, outcome: Outcome) -> list[Command] | Outcome:
        """Clear for another try, or return the outcome that stands."""
        if self.retried or outcome.code not in self.retryable:
            self.reset()
            return outcome
        self.step, self.retried = Step.CLEARING, True
        return [Clear(self.costmap)]
