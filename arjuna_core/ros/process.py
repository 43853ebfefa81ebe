"""The parts that the nodes of one process share: executor, clock, transforms."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal, Protocol

from rclpy.clock import ClockType, ROSClock
from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.task import Future, Task
from rosgraph_msgs.msg import Clock

from arjuna_core.errors import ArjunaError, ConfigError, nearest
from arjuna_core.ros import qos
from arjuna_core.ros.context import discovery, new_context
from arjuna_core.ros.convert import seconds
from arjuna_core.ros.health.checks import problem_of
from arjuna_core.ros.health.guard import Guard
from arjuna_core.ros.health.guarded import GuardedNode
from arjuna_core.ros.local.doors import PlainNode
from arjuna_core.ros.local.transport import LocalExecutor, Registry
from arjuna_core.ros.params import describe_sim_time
from arjuna_core.ros.reports import Diagnostics
from arjuna_core.ros.tf import TransformBuffer, TransformListener

POLL = 0.05  # a wake-up without work costs nothing measurable at this period [s]
_ISOLATED_DOMAIN = 231  # whose ports nobody uses: those who hold one of a domain are waited for


Transport = Literal["local", "dds"]


class MissingNodeError(ArjunaError):
    """A node that must live in the same process does not."""


class ClockedNode(Protocol):
    """The interface that a process needs of its nodes."""

    due_at: float

    def get_fully_qualified_name(self) -> str:
        """Return the node's name with its namespace."""

    def get_clock(self) -> Any:
        """Return the node's rclpy clock."""

    def on_time_jump(self) -> None:
        """React to a clock that was set back."""

    def run_due(self, now: float) -> None:
        """Run what is due at a time [s]; what is raised there ends there."""

    def trouble(self) -> str:
        """Return what keeps the node from its work now."""

    def destroy_node(self) -> None:
        """Leave the graph."""


class Process:
    """One executor, one clock and one transform buffer for every node of a process.

    A node per process subscribes to /clock and /tf, not one per node: deserialising them is most
    of what an idle sim-time node costs. It sets the time of all nodes, and then runs what is due
    in them, in the order in which they were added: one process runs alike every time.

    Args:
        use_sim_time: Whether time comes from /clock; else from the system clock.
        isolated: Whether nothing outside the process can see it or reach into it. Else discovery
            is on this machine only, unless ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise.
        namespace: The robot's namespace: all its nodes and topics are below, /tf and /clock too.
        strict: Whether what a callback raises is raised by `drain`, for tests; else it is logged
            and counted, and the process continues.
        beside: A process whose executor, graph participant and guard it shares: of one that has
            several robots each has a clock, transforms and nodes below a namespace of its own.
        transport: How the nodes of an isolated process talk: `local` hands objects over, `dds` goes
            through the middleware, as every process does that is not isolated.

    Attributes:
        clock: Its time; of the nodes of the local transport too, others have clocks of their own.
        isolated: See above; then all that runs is of one thread.
        transport: What the nodes make their publishers and services of; None for the middleware.
        guard: Where what a callback raises ends.
        remarks: Parameters without effect on which safety depends.
        on_long_step: Called before a step that may rightly take long, with how long at most [s].
    """

    def __init__(
        self,
        name: str,
        use_sim_time: bool = True,
        isolated: bool = False,
        namespace: str = "",
        strict: bool = False,
        beside: Process | None = None,
        transport: Transport = "local",
    ) -> None:
        self.now = 0.0
        self.known = 0.0  # by which stamps are judged: 0 while it is not known, not where set back
        self._steps = 0
        self._beside = beside
        self.guard: Guard = beside.guard if beside else Guard(lambda: self.known, strict)
        self.remarks: tuple[str, ...] = ()
        self.on_long_step: Callable[[float], None] = lambda patience: None
        if beside is not None:
            self.on_long_step = lambda patience: beside.on_long_step(patience)
        self.isolated: bool = beside.isolated if beside else isolated
        self.use_sim_time = use_sim_time
        self.namespace = namespace.strip("/")
        self.executor: Any = beside.executor if beside else None
        self.transport: Registry | None = beside.transport if beside else None
        if beside is None and isolated and transport == "local":
            self.executor = LocalExecutor()
            self.transport = Registry(self.executor)
        self._make_own_node(name, isolated)
        if self.executor is None:
            self.executor = EventsExecutor(context=self.context)
        if self.transport is not None:
            self._run_all = self.guard.guarded(self.node, "executor", self.executor.run_all)
        self.nodes: list[ClockedNode] = []
        self.clock = ROSClock()
        self.clock._set_ros_time_is_active(use_sim_time)
        self._clocks: list[Any] = [self.clock.handle]
        self.executor.add_node(self.node)
        self._diagnostics = Diagnostics(self.node, self.guard)
        self.transforms = TransformBuffer()
        TransformListener(self.node, self.transforms, lambda: self.known, self.namespace)
        if use_sim_time:
            self.node.create_subscription(Clock, "clock", self._on_clock, qos.CLOCK)
        else:
            self.node.create_timer(0.01, self._on_system_time)

    def _make_own_node(self, name: str, isolated: bool) -> None:
        """Make the context, if it has no part in another's, and the process's own node."""
        with discovery(isolated):
            # the middleware reads the range when the context's first node is made
            self.context: Context = (
                self._beside.context
                if self._beside
                else new_context(_ISOLATED_DOMAIN if isolated else None)
            )
            # clients that ask every node for its parameters wait for one that does not answer
            self.node = GuardedNode(
                self.guard,
                name,
                self.transport,
                context=self.context,
                namespace=self.namespace,
                start_parameter_services=not isolated,
            )
        describe_sim_time(self.node)

    def add(self, node: ClockedNode) -> None:
        """Take a node into the executor and under the clock."""
        self.nodes.append(node)
        if self.transport is None:
            self._clocks.append(node.get_clock().handle)
        self.executor.add_node(node)

    def make_node(self, name: str, spun: bool = True, **options: Any) -> PlainNode:
        """Return a plain node that talks with the others of the process, for clients and tests.

        Its callbacks run with those of the others if `spun`; options are those of rclpy's Node.
        """
        node = PlainNode(self.transport, name, context=self.context, **options)
        if spun:
            self.executor.add_node(node)
        return node

    def find(self, name: str) -> Any:
        """Return the node of a name below the robot's namespace that lives in this process.

        Raises:
            MissingNodeError: There is none; the message lists those there are.
        """
        found = {self.plain_name(node): node for node in self.nodes}
        if name not in found:
            raise MissingNodeError(f"no node '{name}' in this process; {nearest(name, found)}")
        return found[name]

    def plain_name(self, node: ClockedNode) -> str:
        """Return a node's name below the robot's namespace."""
        return node.get_fully_qualified_name().removeprefix(self.absolute("/"))

    def absolute(self, name: str) -> str:
        """Return an absolute name below the robot's namespace; one that is there already as it is.

        Relative names stay: ROS puts them below the node's namespace.
        """
        own = f"/{self.namespace}"
        if self.namespace and name.startswith(f"{self.namespace}/"):
            return f"/{name}"  # Gazebo's `robot1/scan` of a robot in /robot1
        outside = self.namespace and name.startswith("/") and not name.startswith(f"{own}/")
        return f"{own}{name}" if outside else name

    def set_time(self, nanoseconds: int) -> None:
        """Let the clock show a time [ns], as a message on /clock does."""
        self._advance(nanoseconds / 1e9, nanoseconds)

    def problem_of(self, message: Any) -> str | None:
        """Return why the message that is delivered now cannot be used, or None."""
        return problem_of(message, self.known) if self.transport is None else self.transport.problem

    def _on_clock(self, message: Any) -> None:
        problem = self.problem_of(message)
        if problem is not None:
            self.guard.refused(self.node, "clock", problem)
            return
        self._advance(seconds(message.clock), _nanoseconds(message.clock))

    def _on_system_time(self) -> None:
        self._advance(self.clock.now().nanoseconds / 1e9, None)

    def _advance(self, now: float, override: int | None) -> None:
        jumped_back = now < self.now
        self.now = now
        self.known = max(now, 1e-9) if jumped_back or self.known else now
        if jumped_back:
            self.transforms.clear()
        if override is not None:
            time = _rclpy.rcl_time_point_t(override, ClockType.ROS_TIME)
            for clock in self._clocks:  # as rclpy's Clock does, which takes five times as long
                clock.set_ros_time_override(time)
        if jumped_back:
            for node in self.nodes:
                node.due_at = 0.0
                self.guard.call(node, "a clock set back", node.on_time_jump)
        if self.transport is not None:
            self.transport.now = now
        self.later(self._run_due)
        if self.transport is not None:
            self.transport.run_timers()

    def later(self, callback: Callable[[], Any]) -> None:
        """Run a callback behind what waits in the executor."""
        if self.transport is None:
            self.executor.create_task(callback)
        else:
            self.executor.put(callback)

    def _run_due(self) -> None:
        """Run what is due, behind the transforms and scans that were queued with the clock."""
        now = self.now
        for node in self.nodes:
            if now >= node.due_at:
                node.run_due(now)
        self._diagnostics.run_due(self.now, [self.node, *self.nodes], self.remarks)

    def spin_once(self, timeout: float = POLL) -> None:
        """Run at most one waiting callback, waiting up to a timeout for it [s, wall].

        Callbacks of nodes end their own exceptions; here end those of rclpy's own tasks.
        """
        self.guard.call(self.node, "executor", self.executor.spin_once, timeout)

    def spin(self, duration: float) -> None:
        """Run what waits and what comes for a duration [s, wall].

        The executor runs all of it by itself: each return to Python costs as much as a message.
        """
        never: Future = Future(executor=self.executor)
        spin = self.executor.spin_until_future_complete
        self.guard.call(self.node, "executor", spin, never, duration)

    def drain(self) -> None:
        """Run everything that waits, and everything that it causes, until nothing is left.

        Deliveries inside a process are queued before `publish` returns, and the queue is first
        in, first out: a marker that comes back at once proves that nothing was before it.
        """
        if self.transport is None:
            while self.run_waiting() > 1:
                pass
        while self.transport is not None and len(self.executor):
            self._run_all()

    def run_waiting(self) -> int:
        """Run everything that waits, but nothing that comes meanwhile; return how much it was."""
        marker = self.executor.create_task(lambda: None)
        before = self._steps
        while not marker.done():
            self.guard.call(self.node, "executor", self._spin_until, marker)
        return self._steps - before

    def _spin_until(self, marker: Task[None]) -> None:
        """Run callbacks one by one up to a marker; guarded as one, for each costs time itself."""
        while not marker.done():
            self._steps += 1
            # 1 ms of wall time; the queue holds a marker, so that it is never waited out.
            self.executor.spin_once(0.001)

    def use_realtime_priority(self) -> None:
        """Run before all that has no such priority; 49 of SCHED_FIFO, as nav2_util sets it.

        Raises:
            ConfigError: The system does not allow it.
        """
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(49))
        except OSError as error:
            allowed = "CAP_SYS_NICE, or an rtprio in /etc/security/limits.conf"
            text = f"'use_realtime_priority' is true: {error.strerror}; valid: false, or {allowed}"
            raise ConfigError(text) from error

    def ok(self) -> bool:
        """Return whether the process has not been asked to stop."""
        return bool(self.context.ok())

    def close(self) -> None:
        """Destroy every node and leave the graph."""
        for node in (*self.nodes, self.node):
            if self._beside is not None:
                self.executor.remove_node(node)
            node.destroy_node()
        if self._beside is not None:
            return
        self.executor.shutdown()
        if self.context.ok():
            self.context.shutdown()


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
