"""The one client of a running robot: a node that waits, with deadlines, for services and more."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.executors import Executor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.context import new_context

POLL = 0.02
"""From one look at whether something is done to the next [s]."""
_INTERRUPTED: list[Executor] = []
"""Executors into which Ctrl-C came: one that was adding entities ends the process when deleted."""


class ClientError(ArjunaError):
    """Nobody answers in time, or a request is refused; the message says what to do."""


class Session(ABC):
    """A node, and waiting while its callbacks run; never from within one of them.

    Attributes:
        error: What is raised where something does not come in time.
    """

    client: Node
    error: type[Exception] = ClientError

    @property
    def now(self) -> float:
        """The time that timeouts are of [s]."""
        return time.monotonic()

    @abstractmethod
    def spin_once(self, timeout: float = POLL) -> None:
        """Handle what comes next, within a timeout [s]."""

    def settle(self) -> None:  # noqa: B027 - nothing to do but in lock-step
        """Let what was just made or sent take effect, where no time passes by itself."""

    def run_until(
        self,
        done: Callable[[], bool],
        timeout: float = math.inf,
        what: str = "",
        required: bool = True,
    ) -> bool:
        """Handle what comes until something is done.

        Args:
            done: Asked after each event.
            timeout: [s].
            required: Whether a timeout is an error.

        Returns:
            Whether it was done in time.

        Raises:
            ArjunaError: It was not, and is required.
        """
        deadline = self.now + timeout
        while not done():
            if self.is_past(deadline):
                if required:
                    raise self.error(f"{what} did not come within {timeout:g} s")
                return False
            self.spin_once(min(deadline - self.now, POLL))
        return True

    def is_past(self, deadline: float, tolerance: float = 1e-9) -> bool:
        """Return whether a time has come [s], within the rounding of a sum of simulated ticks."""
        return deadline - self.now <= tolerance

    def pause(self, duration: float = math.inf) -> None:
        """Handle what comes for a time [s]."""
        self.run_until(lambda: False, duration, required=False)

    def wait_for(
        self,
        done: Callable[[], bool],
        timeout: float,
        what: str,
        remedy: str,
        patience: float = 2.5,
    ) -> None:
        """Wait until something is done; soon say what is waited for and what would bring it.

        Args:
            done: Asked after each event.
            timeout: [s].
            remedy: What to do if it does not come, a question or an order.
            patience: How long to wait without a message [s]; what runs is mostly found within 1 s.

        Raises:
            ArjunaError: It was not done in time.
        """
        soon = min(patience, timeout)
        if self.run_until(done, soon, required=False):
            return
        if timeout > soon:
            self.client.get_logger().warning(f"waiting for {what}: {remedy}")
            if self.run_until(done, timeout - soon, required=False):
                return
        raise self.error(f"{what} did not come within {timeout:g} s: {remedy}")

    def result(self, future: Any, timeout: float = math.inf, what: str = "an answer") -> Any:
        """Return a future's result.

        Raises:
            ArjunaError: It does not come in time [s].
        """
        self.run_until(future.done, timeout, what)
        return future.result()

    def call(
        self,
        service_type: Any,
        name: str | Sequence[str],
        request: Any,
        timeout: float = 10.0,
        appearance: float | None = None,
    ) -> Any:
        """Return a service's response.

        Args:
            name: Its name, or several of which the first one that is served is called.
            timeout: For the answer [s].
            appearance: For a server to appear [s]; as long as for the answer if None.

        Raises:
            ArjunaError: Nobody serves it, or does not answer in time.
        """
        names = [name] if isinstance(name, str) else list(name)
        clients = {one: self.client.create_client(service_type, one) for one in names}

        def ready() -> list[str]:
            return [one for one, client in clients.items() if client.service_is_ready()]

        try:
            self.settle()
            limit = timeout if appearance is None else appearance
            if not self.run_until(lambda: bool(ready()), limit, required=False):
                raise self.not_served(names[-1], limit)
            served = ready()[0]
            future = clients[served].call_async(request)
            self.settle()
            return self.result(future, timeout, f"an answer of '{served}'")
        finally:
            for client in clients.values():
                self.client.destroy_client(client)

    def not_served(self, name: str, timeout: float) -> Exception:
        """Return the error of a service that nobody serves within a time [s]."""
        return self.error(f"nobody serves '{name}' within {timeout:g} s")

    def send_goal(
        self,
        client: Any,
        goal: Any,
        feedback: Callable[[Any], None] | None = None,
        timeout: float = 10.0,
    ) -> Any:
        """Send a goal to a server that is there; return its handle, accepted or not.

        Raises:
            ArjunaError: No answer comes in time [s].
        """
        return self.result(client.send_goal_async(goal, feedback), timeout, "an answer to the goal")

    def cancel(self, handle: Any, timeout: float = 10.0) -> Any:
        """Cancel a goal; return the server's answer.

        Raises:
            ArjunaError: None comes in time [s].
        """
        what = "an answer to the cancellation"
        return self.result(handle.cancel_goal_async(), timeout, what)


class Connection(Session):
    """A node among those of the robots on this machine; times are real ones."""

    def __init__(
        self,
        name: str = "arjuna_client",
        namespace: str = "",
        use_sim_time: bool = False,
        executor: type[Executor] = EventsExecutor,
        words: list[str] | None = None,
        parameter_services: bool = False,
    ) -> None:
        self._context = new_context(words=words)
        self.client = Node(
            name,
            context=self._context,
            namespace=namespace,
            start_parameter_services=parameter_services,
            parameter_overrides=[Parameter("use_sim_time", value=True)] if use_sim_time else [],
        )
        self._executor = executor(context=self._context)
        self._executor.add_node(self.client)

    def spin_once(self, timeout: float = POLL) -> None:
        """Handle what comes next, within a timeout [s]."""
        try:
            self._executor.spin_once(timeout_sec=timeout)
        except KeyboardInterrupt:
            _INTERRUPTED.append(self._executor)
            raise

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.client.destroy_node()
        self._context.shutdown()
        self._context.destroy()  # else the graph keeps it until it is collected
