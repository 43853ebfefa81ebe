"""The lifecycle manager: brings nodes up in order, and takes commands as Nav2's manager does."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.srv import ManageLifecycleNodes
from rclpy.clock import Clock, ClockType
from std_srvs.srv import Trigger

from arjuna_core.config import duration_param, fixed, flatten
from arjuna_core.ros.deferred import deferred_service
from arjuna_core.ros.health.guarded import GuardedNode
from arjuna_core.ros.params import ParameterBinding, describe_sim_time
from arjuna_core.ros.process import Process
from bringup.processes.lifecycle.bonds import Bonds
from bringup.processes.lifecycle.plan import Command, State, Step, Transition, Verdict, judge, plan

SERVICE_DEADLINE = 10.0
"""Time-out for the services of a node that is taken down [s]."""
START_DEADLINE = 60.0
"""The same of one that comes up, where another command waits; so long one that is up may be busy
[s]."""
_TOLD_EVERY = 2.0
"""From when on, and how often, it is told what is waited for, as Nav2's manager does [s]."""
TRANSITION_DEADLINE = 90.0
"""Time-out of a transition [s]; the first ever compiles the algorithms."""
_UPS = (Command.STARTUP, Command.RESUME)


@dataclass(frozen=True)
class LifecycleManagerConfig:
    """Parameters of a lifecycle manager, by Nav2's names."""

    node_names: tuple[str, ...] = fixed(
        (), "Further lifecycle nodes, of one's own, that come up behind those of the process."
    )
    autostart: bool = fixed(True, "Whether nodes come up at once; else by manage_nodes.")
    bond_timeout: float = fixed(
        4.0,
        "How long a node of one's own may show no sign of life before all are taken down; "
        "for ever from 0 down.",
        unit="s",
    )
    attempt_respawn_reconnection: bool = fixed(
        True, "Whether all come up again once it lives again."
    )
    bond_respawn_max_duration: float = duration_param(
        10.0, "How long that is waited for.", read_only=True
    )


@dataclass
class _Job:
    """A command in progress: its remaining steps, and what takes its success."""

    command: Command
    steps: deque[Step]
    reply: Callable[[bool], None]
    started: float = 0.0
    step_started: float = 0.0
    future: Any = None
    failures: list[str] = field(default_factory=list)


class LifecycleManager(GuardedNode):
    """A lifecycle manager: `<name>/manage_nodes` and `<name>/is_active`.

    Nodes of one's own are watched: where one is lost all are taken down, and up again with it.
    Deadlines run on a steady clock: bringing nodes up must not wait for a simulator's time.

    Args:
        nodes: The managed nodes in the order of bring-up.
        config: Parameters; the process's nodes among `node_names` are in it already.
        commandable: Whether clients may command it by `<name>/manage_nodes`.
        ready: Whether the first command may begin; asked until it is so.
        on_wait: Takes what is waited for, before it is; empty where nothing is.
        period: From one look at the command in progress to the next [s].
    """

    Config = LifecycleManagerConfig

    def __init__(
        self,
        process: Process,
        name: str,
        nodes: Sequence[str],
        config: LifecycleManagerConfig | None = None,
        commandable: bool = True,
        ready: Callable[[], bool] = lambda: True,
        on_wait: Callable[[str], None] = lambda what: None,
        period: float = 0.05,
    ) -> None:
        super().__init__(process.guard, name, context=process.context, namespace=process.namespace)
        describe_sim_time(self)
        config = config or LifecycleManagerConfig()
        own = [each for each in config.node_names if each.strip("/") not in nodes]
        nodes = (*nodes, *own)
        self.config = replace(config, node_names=nodes)
        ParameterBinding(self, LifecycleManagerConfig, flatten(self.config), lambda config: None)
        self.system_active = False
        self._ready, self._on_wait = ready, on_wait
        self._nodes = tuple(nodes)
        self._states = {n: self.create_client(GetState, f"{n}/get_state") for n in nodes}
        self._changes = {n: self.create_client(ChangeState, f"{n}/change_state") for n in nodes}
        self._jobs: deque[_Job] = deque()
        self._bonds = Bonds(self, {name: self._states[name] for name in own})
        self._respawn_until: float | None = None
        if commandable:
            deferred_service(self, ManageLifecycleNodes, f"{name}/manage_nodes", self._on_manage)
        self.create_service(Trigger, f"{name}/is_active", self._on_is_active)
        self._timer = self.create_timer(
            period, self._advance, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        if own and self.config.bond_timeout > 0.0:
            self.create_timer(0.5, self._watch, clock=Clock(clock_type=ClockType.STEADY_TIME))
        process.executor.add_node(self)
        if self.config.autostart:
            self.submit(Command.STARTUP, lambda success: None)
        else:
            self._on_wait(f"{name}/manage_nodes: autostart is false")

    def submit(
        self, command: Command, reply: Callable[[bool], None], without: Sequence[str] = ()
    ) -> None:
        """Queue a command; `reply` is called with its success when it is done."""
        nodes = [name for name in self._nodes if name not in without]
        self._jobs.append(_Job(command, deque(plan(command, nodes)), reply))
        self._timer.reset()

    def _watch(self) -> None:
        """Take all down where a node of one's own is lost, and up again where it has come back."""
        now, config = time.monotonic(), self.config
        self._bonds.look(now)
        silent = self._bonds.silent(now, config.bond_timeout, START_DEADLINE)
        if self._jobs:
            return
        if self._respawn_until is not None:
            if not silent:
                self._respawn_until = None
                self.submit(Command.STARTUP, lambda success: None)
            elif now > self._respawn_until:
                self._respawn_until = None
                waited = f"{config.bond_respawn_max_duration:g} s"
                self.get_logger().error(f"{', '.join(silent)} did not come back within {waited}")
        elif self.system_active and silent:
            text = f"no sign of life within {config.bond_timeout:g} s; all nodes are taken down"
            self.get_logger().error(f"{', '.join(silent)}: {text}")
            self.submit(Command.RESET, lambda success: None, silent)
            if config.attempt_respawn_reconnection:
                self._respawn_until = now + config.bond_respawn_max_duration

    def _on_is_active(self, request: Any, response: Any) -> Any:
        response.success = self.system_active
        response.message = "Managed nodes are active" if self.system_active else "not active"
        return response

    def _on_manage(self, request: Any, reply: Callable[[Any], None]) -> None:
        if request.command not in list(Command):
            valid = ", ".join(f"{command.value} {command.name}" for command in Command)
            self.get_logger().error(f"unknown command {request.command}; valid: {valid}")
            reply(ManageLifecycleNodes.Response(success=False))
            return
        self.submit(
            Command(request.command),
            lambda success: reply(ManageLifecycleNodes.Response(success=success)),
        )

    def _advance(self) -> None:
        if not self._jobs:
            self._timer.cancel()
            return
        if not self._ready():
            return
        job, now = self._jobs[0], time.monotonic()
        if job.started == 0.0:
            job.started = job.step_started = now
        if not job.steps:
            self._finish(job)
        elif job.future is None:
            self._ask(job, now)
        elif now - job.step_started > TRANSITION_DEADLINE:
            self._fail(job, f"no answer within {TRANSITION_DEADLINE:.0f} s")

    def _ask(self, job: _Job, now: float) -> None:
        node, upward = job.steps[0].node, job.steps[0].transition.upward
        deadline = START_DEADLINE if upward else SERVICE_DEADLINE
        waited = now - job.step_started
        if self._states[node].service_is_ready() and self._changes[node].service_is_ready():
            self._wait_for(job, self._states[node].call_async(GetState.Request()), self._on_state)
        elif waited <= deadline or (upward and len(self._jobs) == 1):  # as Nav2's, for ever
            self._on_wait(f"{node}, to offer its lifecycle services")
            if waited >= _TOLD_EVERY:
                text = f"Waiting for service {node}/get_state..."
                self.get_logger().info(text, throttle_duration_sec=_TOLD_EVERY)
        else:
            self._fail(job, f"offers no lifecycle services after {deadline:.0f} s")

    def _wait_for(self, job: _Job, future: Any, then: Callable[[_Job, Any], None]) -> None:
        def done(finished: Any) -> None:
            if job.future is finished:  # else its deadline has passed
                then(job, finished.result())

        job.future = future
        future.add_done_callback(self.guarded("an answer", done))

    def _on_state(self, job: _Job, answer: Any) -> None:
        step, state = job.steps[0], State(answer.current_state.id)
        verdict = judge(step.transition, state)
        if verdict is Verdict.SKIP:
            self._next(job)
        elif verdict is Verdict.REFUSE:
            self._fail(job, f"is {state.name.lower()}: cannot {step.transition.name.lower()}")
        else:
            self._on_wait(f"{step.node} to {step.transition.name.lower()}")
            request = ChangeState.Request()
            request.transition.id = step.transition.number
            future = self._changes[step.node].call_async(request)
            self._wait_for(job, future, self._on_changed)

    def _on_changed(self, job: _Job, answer: Any) -> None:
        step = job.steps[0]
        if not answer.success:
            asked = self._states[step.node].call_async(GetState.Request())
            self._wait_for(job, asked, self._on_refused)
            return
        if step.transition is Transition.ACTIVATE:
            seconds = time.monotonic() - job.started
            self.get_logger().debug(f"{step.node} active after {seconds:.1f} s")
        self._next(job)

    def _on_refused(self, job: _Job, answer: Any) -> None:
        """Continue if the node has come there meanwhile, by another manager."""
        step = job.steps[0]
        if judge(step.transition, State(answer.current_state.id)) is Verdict.SKIP:
            self._next(job)
        else:
            self._fail(job, f"refused to {step.transition.name.lower()}; its log says why")

    def _next(self, job: _Job) -> None:
        job.steps.popleft()
        job.future = None
        job.step_started = time.monotonic()
        self._advance()

    def _fail(self, job: _Job, problem: str) -> None:
        """Give up bringing up; continue taking down, so that as much as possible rests."""
        step = job.steps[0]
        job.failures.append(step.node)
        self.get_logger().error(f"{step.node} {problem}")
        if step.transition.upward:
            job.steps = deque([step])
        self._next(job)

    def _finish(self, job: _Job) -> None:
        self._jobs.popleft()
        success = not job.failures
        self.system_active = success and job.command in _UPS
        if self.system_active:
            self._bonds.begin(time.monotonic())
            self.get_logger().info("Managed nodes are active")
        elif not success:
            self.get_logger().error(f"{job.command.name} failed: {', '.join(job.failures)}")
        self._on_wait("" if success else f"{', '.join(job.failures)}: failed, see the log")
        job.reply(success)
