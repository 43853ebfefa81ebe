"""BehaviorTree.CPP's nodes with one child.

Source: BehaviorTree.CPP 4, decorators.
"""

from __future__ import annotations

from typing import ClassVar

from arjuna_nav.trees.node import Decorator, Status
from arjuna_nav.trees.ports import NUMBER, WHOLE, Port

_ENDED = (Status.SUCCESS, Status.FAILURE)


class Inverter(Decorator):
    """Turns success into failure and failure into success."""

    def tick(self) -> Status:
        """Tick the child."""
        self.set_status(Status.RUNNING)
        turned = {Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS}
        status = self.child.execute()
        return turned.get(status, status)


class ForceSuccess(Decorator):
    """Succeeds when the child ends."""

    ANSWER: ClassVar[Status] = Status.SUCCESS

    def tick(self) -> Status:
        """Tick the child."""
        self.set_status(Status.RUNNING)
        status = self.child.execute()
        return self.ANSWER if status in _ENDED else status


class ForceFailure(ForceSuccess):
    """Fails when the child ends."""

    ANSWER = Status.FAILURE


class KeepRunningUntilFailure(Decorator):
    """Runs until the child fails."""

    def tick(self) -> Status:
        """Tick the child."""
        self.set_status(Status.RUNNING)
        status = self.child.execute()
        return status if status is Status.FAILURE else Status.RUNNING


class _Counted(Decorator):
    """Runs the child again, once a tick, while it ends in one way; -1 times means for ever."""

    PORT: ClassVar[str]
    AGAIN: ClassVar[Status]
    _count = 0

    def tick(self) -> Status:
        """Tick the child."""
        self.set_status(Status.RUNNING)
        status = self.child.execute()
        if status is Status.RUNNING:
            return status
        limit = self.get(self.PORT)
        self._count += 1
        if status is self.AGAIN and (limit < 0 or self._count < limit):
            return Status.RUNNING
        self._count = 0
        return status

    def on_halt(self) -> None:
        """Begin to count anew."""
        self._count = 0


class Repeat(_Counted):
    """Runs the child again while it succeeds."""

    PORTS: ClassVar[dict[str, Port]] = {"num_cycles": Port(WHOLE)}
    PORT, AGAIN = "num_cycles", Status.SUCCESS


class RetryUntilSuccessful(_Counted):
    """Runs the child again while it fails."""

    PORTS: ClassVar[dict[str, Port]] = {"num_attempts": Port(WHOLE)}
    PORT, AGAIN = "num_attempts", Status.FAILURE


class RunOnce(Decorator):
    """Runs the child to its end once, and answers the same from then on."""

    _answer: Status | None = None

    def tick(self) -> Status:
        """Tick the child, or answer as it did."""
        if self._answer is not None:
            return self._answer
        self.set_status(Status.RUNNING)
        status = self.child.execute()
        if status in _ENDED:
            self._answer = status
        return status


class _Timed(Decorator):
    """A node that counts from its first tick."""

    _since: float | None = None

    def elapsed(self) -> float:
        """Return the time since the first tick [s]."""
        now = self.running.state.now
        if self._since is None:
            self._since = now
        return now - self._since

    def on_halt(self) -> None:
        """Begin to count anew."""
        self._since = None


class Timeout(_Timed):
    """Fails where the child runs for too long."""

    PORTS: ClassVar[dict[str, Port]] = {"msec": Port(NUMBER)}

    def tick(self) -> Status:
        """Tick the child, unless its time is over."""
        self.set_status(Status.RUNNING)
        if self.elapsed() * 1000.0 >= self.get("msec"):
            self.child.reset()
            self._since = None
            return Status.FAILURE
        status = self.child.execute()
        if status is not Status.RUNNING:
            self._since = None
        return status


class Delay(_Timed):
    """Ticks the child after a while."""

    PORTS: ClassVar[dict[str, Port]] = {"delay_msec": Port(NUMBER)}

    def tick(self) -> Status:
        """Wait, then tick the child."""
        self.set_status(Status.RUNNING)
        if self.elapsed() * 1000.0 < self.get("delay_msec"):
            return Status.RUNNING
        status = self.child.execute()
        if status is not Status.RUNNING:
            self._since = None
        return status
