"""Lock-step: simulator and stacks in one process, as fast as it goes, the same every time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.lifecycle import TransitionCallbackReturn

from arjuna_core.ros.process import Process, Transport
from bringup.client.session import POLL, ClientError, Session
from bringup.interrupts import check_interrupts
from bringup.parameters.files import Parameters, for_node
from bringup.stack import Group, with_further


class LockStepError(ClientError):
    """A node could not be brought up, or something did not happen in time."""


class LockStep(Session):
    """A whole robot in one process.

    `step` advances the simulator by one tick of 20 ms, and everything that the tick caused is
    drained before it returns.

    Args:
        isolated: Whether nothing outside the process can see it.
        strict: Whether what a callback raises is raised by `step`, for tests.
        beside: One with the simulator of several robots, of which this is one in its namespace;
            it steps that one, and is closed before it.
        transport: How its nodes talk: `local` hands objects over; `dds` goes through the
            middleware, as nodes of rclpy's own need that are to live in it. The run is the same.

    Attributes:
        client: A plain node for the caller's own clients and subscriptions.
        nodes: Every node by name.
        on_tick: Called after each tick, to measure.
    """

    error = LockStepError

    def __init__(
        self,
        parameters: Parameters,
        namespace: str = "",
        isolated: bool = True,
        strict: bool = False,
        beside: LockStep | None = None,
        transport: Transport = "local",
    ) -> None:
        self._parameters = parameters
        self._beside = beside
        shared = None if beside is None else beside.process
        self.process: Process = Process(
            "lockstep", True, isolated, namespace, strict, shared, transport
        )
        self.client = self.process.make_node("lockstep_client", namespace=namespace)
        self.nodes: dict[str, Any] = {}
        self.on_tick: Callable[[], None] = lambda: None

    @property
    def sim(self) -> Any:
        """The simulator's node; its truth is for measuring only."""
        return self.nodes["sim"] if self._beside is None else self._beside.sim

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.process.now

    def start(self, *groups: Group, parameters: Parameters | None = None) -> None:
        """Make the nodes of groups that are not there yet, configure all, then activate all.

        Groups that talk to each other are started together: a latched message reaches those who
        subscribe later by a thread of the middleware, at no fixed time.

        Raises:
            LockStepError: A node refuses a transition; its log says why.
        """
        values = self._parameters if parameters is None else parameters
        specs = [spec for group in groups for spec in with_further(group, values).nodes]
        for spec in specs:
            if spec.name not in self.nodes:
                self.nodes[spec.name] = spec.make(self.process, for_node(values, spec.name))
        self.process.drain()
        for step in ("configure", "activate"):
            for spec in specs:
                self._transition(spec.name, step)

    def stop(self, *groups: Group) -> None:
        """Deactivate and clean up the nodes of groups, last first; `start` takes them up again."""
        further = [with_further(group, self._parameters) for group in groups]
        for spec in reversed([spec for group in further for spec in group.nodes]):
            for step in ("deactivate", "cleanup"):
                self._transition(spec.name, step)

    def _transition(self, name: str, step: str) -> None:
        result = getattr(self.nodes[name], f"trigger_{step}")()
        self.process.drain()
        if result != TransitionCallbackReturn.SUCCESS:
            raise LockStepError(f"{name} failed to {step}; see its log above")

    def step(self) -> None:
        """Advance by one tick and run everything it causes."""
        check_interrupts()
        if self._beside is not None:
            self._beside.step()
            return
        self.sim.tick()
        self.process.drain()
        self.on_tick()

    def spin_once(self, timeout: float = POLL) -> None:
        """Advance by one tick, the shortest time that passes."""
        self.step()

    def settle(self) -> None:
        """Run what waits, at this time."""
        self.process.drain()

    def run(self, duration: float) -> None:
        """Advance by a duration of simulated time [s]."""
        self.pause(duration)

    def close(self) -> None:
        """Leave the graph."""
        self.process.executor.remove_node(self.client)
        self.client.destroy_node()
        self.process.close()
