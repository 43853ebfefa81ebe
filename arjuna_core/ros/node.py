"""ManagedNode: the lifecycle node that every node of ours is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any, ClassVar, TypeVar

from lifecycle_msgs.msg import Transition
from rclpy.exceptions import NameValidationException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter

from arjuna_core.config import NoParameters
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.deferred import deferred_service
from arjuna_core.ros.health.guarded import Guarded
from arjuna_core.ros.local.lifecycle import LIFECYCLE_SERVICES, AnnouncedStates
from arjuna_core.ros.params import ParameterBinding, describe_sim_time
from arjuna_core.ros.process import Process
from arjuna_core.ros.reports import failed
from arjuna_core.ros.tf import TransformBuffer
from arjuna_core.timing import Periodic

T = TypeVar("T")
_REACHED = {
    **dict.fromkeys((Transition.TRANSITION_CONFIGURE, "configure"), ("inactive", "active")),
    **dict.fromkeys((Transition.TRANSITION_ACTIVATE, "activate"), ("active",)),
}
"""The states in which a node is up as far as a transition would bring it."""


class ManagedNode(Guarded, LifecycleNode):
    """A lifecycle node: parameters from a dataclass, periodic work on ROS time, shared transforms.

    `__init__` only stores and declares; `configure` reads files, builds the core and creates
    publishers, subscriptions and services; `activate` starts work; `deactivate` stops it; `cleanup`
    drops what `configure` made. Each raises an ArjunaError to refuse, which is logged and fails the
    transition. What else a callback raises ends in the process's guard: the message is dropped, the
    request answered as failed, the transition ends in `unconfigured`, and the node continues.

    Attributes:
        Config: The frozen dataclass of the node's parameters.
        config: The current parameters, an instance of it.
        due_at: Time before which `run_due` has nothing to do [s].

    Args:
        values: Parameters that differ from the defaults, nested or dotted.
        namespace: Namespace of the node, below that of the process.
    """

    trusted = True
    Config: ClassVar[type[Any]] = NoParameters
    DEFAULT_NAME: ClassVar[str]
    config: Any

    def __init__(
        self,
        process: Process,
        values: Mapping[str, Any] | None = None,
        name: str | None = None,
        namespace: str = "",
    ) -> None:
        self.process = process
        self.guard, self.transport = process.guard, process.transport
        self.transforms: TransformBuffer = process.transforms
        sim_time = [Parameter("use_sim_time", value=True)] if process.use_sim_time else []
        super().__init__(
            name or self.DEFAULT_NAME,
            namespace="/".join(filter(None, (process.namespace, namespace))),
            context=process.context,
            parameter_overrides=sim_time,
            enable_rosout=process.transport is None,  # nobody would hear it
            enable_communication_interface=process.transport is None,
        )
        self._use_clock_of(process)
        if process.transport is None:
            self._guard_lifecycle_services()
        else:
            self._serve_lifecycle()
        describe_sim_time(self)
        self.active = False
        self.due_at = math.inf
        self._tasks: list[tuple[Periodic, Callable[[], None]]] = []
        self._made: list[tuple[Callable[[Any], Any], Any]] = []
        ParameterBinding(self, self.Config, values or {}, self._take_config)
        process.add(self)

    def _use_clock_of(self, process: Process) -> None:
        """Let the process set the time; a second subscription to /clock would be all cost."""
        if process.transport is not None:  # rcl warns of a clock that many actions' timers share
            self._clock = process.clock
        for subscription in list(self.subscriptions):
            if subscription.topic_name == "/clock":
                self.destroy_subscription(subscription)

    def _guard_lifecycle_services(self) -> None:
        """Guard the services that rclpy makes without `create_service`."""
        change = self._service_change_state
        change.callback = self._allowed_only(change.callback)
        for service in list(self.services):
            if hasattr(service.callback, "__wrapped__"):
                continue
            service.callback = self.answering(service.srv_name, service.callback)

    def _serve_lifecycle(self) -> None:
        """Make the services and the topic of lifecycle nodes, which rclpy makes without methods."""
        for name, kind in LIFECYCLE_SERVICES.items():
            answer = getattr(self, f"_LifecycleNodeMixin__on_{name}")
            checked = self._allowed_only(answer) if name == "change_state" else answer
            self.create_service(kind, f"~/{name}", checked)
        self._state_machine: Any = AnnouncedStates(self, self._state_machine)

    def _allowed_only(self, change: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Refuse a transition that is unknown or not allowed now: rclpy raises.

        One up to where the node is succeeds: clients configure and activate what would wait there.
        """

        def answer(request: Any, response: Any) -> Any:
            asked = request.transition
            allowed = {item[0]: item[1] for item in self._state_machine.available_transitions}
            if self.state_label in _REACHED.get(asked.label or asked.id, ()):
                self.get_logger().info(f"change_state: it is {self.state_label} already")
                response.success = True  # ours come up by themselves
                return response
            if asked.label or asked.id in allowed:
                return change(request, response)
            valid = ", ".join(f"{number} {label}" for number, label in allowed.items())
            problem = f"transition {asked.id} is not allowed in {self.state_label}; valid: {valid}"
            self.guard.refused(self, "change_state", problem)
            return response

        return answer

    @property
    def state_label(self) -> str:
        """The lifecycle state in words, as `active`."""
        return str(self._state_machine.current_state[1])

    @property
    def configured(self) -> bool:
        """True from `configure` to `cleanup`: what it works with is made."""
        return self.state_label in ("inactive", "active")

    def _take_config(self, config: Any) -> None:
        if self.configured:  # else `configure` is yet to read it
            self.on_config(config)

    # Asked some 20 times a tick: without a frame of Python (`bench speed`).
    now: float = property(attrgetter("process.now"), doc="The process's time [s].")  # type: ignore[assignment]

    def full_topic(self, topic: str) -> str:
        """Return a topic's full name, below the robot's namespace and as it is remapped."""
        return str(self.resolve_topic_name(self.process.absolute(topic)))

    def every(self, period: float, task: Callable[[], None]) -> None:
        """Run a task each `period` [s] of ROS time while the node is active.

        Called in `configure` or `activate`. The first run is at the next multiple of the period.
        """
        name = getattr(task, "__name__", "task").strip("_")
        guarded = self.guarded(name, task, self.on_failure)
        self._tasks.append((Periodic(period), guarded))
        self.due_at = 0.0

    def run_due(self, now: float) -> None:
        """Run the periodic tasks that are due at a time [s]; the process calls this."""
        due_at = math.inf
        if self.active:
            for periodic, task in self._tasks:
                if periodic.due(now):
                    task()
                if periodic.next < due_at:
                    due_at = periodic.next
        self.due_at = due_at

    def publisher(self, message_type: Any, topic: str, profile: Any) -> Any:
        """Create a publisher that lives until cleanup; `/` is the robot's namespace."""
        made = self.create_publisher(message_type, self.process.absolute(topic), profile)
        return self._keep(self.destroy_publisher, made)

    def subscribe(
        self,
        message_type: Any,
        topic: str,
        callback: Callable[[Any], None],
        profile: Any,
        *,
        while_inactive: bool = False,
        shared: bool = False,
    ) -> Any:
        """Create and return a subscription that lives until cleanup; `/` is the robot's namespace.

        It delivers only while the node is active, unless `while_inactive`: what is latched comes
        once, perhaps before activation. What cannot be used is refused and counted. With `shared`,
        a topic `/name` is listened to outside the namespace too, as one map of several robots.
        """
        process, name = self.process, self.process.absolute(topic)
        transport = process.transport  # which has judged it: a call less for each message

        def deliver(message: Any) -> None:
            if not (self.active or while_inactive):
                return
            problem = transport.problem if transport else process.problem_of(message)
            if problem is None:
                callback(message)
            else:
                self.guard.refused(self, name, problem)

        if shared and topic.startswith("/") and topic != name:
            outside = self.create_subscription(message_type, topic, deliver, profile)
            self._keep(self.destroy_subscription, outside)
        subscription = self.create_subscription(message_type, name, deliver, profile)
        return self._keep(self.destroy_subscription, subscription)

    def unsubscribe(self, subscription: Any) -> None:
        """End a subscription before cleanup does."""
        self._made = [one for one in self._made if one[1] is not subscription]
        self.destroy_subscription(subscription)

    def serve(self, service_type: Any, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Create a service that lives until cleanup; requests that cannot be used are refused."""

        def answer(request: Any, response: Any) -> Any:
            # 30 s at most; a request may read a file.
            self.process.on_long_step(30.0)
            return callback(request, response)

        made = self.create_service(service_type, self.process.absolute(name), answer)
        self._keep(self._retire, made)

    def serve_later(
        self, service_type: Any, name: str, on_request: Callable[[Any, Callable[[Any], None]], None]
    ) -> None:
        """Create a service as `serve` does; `on_request` also gets what answers, perhaps later."""

        def refuse(reason: str, request: Any, respond: Callable[[Any], None]) -> None:
            respond(failed(request, service_type.Response(), reason))

        def take_valid(request: Any, respond: Callable[[Any], None]) -> None:
            problem = self.problem_of(name, request)
            if problem is None:
                on_request(request, respond)
            else:
                refuse(problem, request, respond)

        path = self.process.absolute(name)
        take = self.guarded(name, take_valid, refuse)
        if self.transport is None:
            made = deferred_service(self, service_type, path, take)
        else:
            made = self.create_deferred_service(service_type, path, take)
        self._keep(self._retire, made)

    def _retire(self, service: Any) -> None:
        """Destroy a service behind the requests that came; rclpy makes those in between errors."""
        self._services.remove(service)
        self._wake_executor()
        self.executor.create_task(service.destroy)

    def client(self, service_type: Any, name: str) -> Any:
        """Create a service client that lives until cleanup."""
        made = self.create_client(service_type, self.process.absolute(name))
        return self._keep(self.destroy_client, made)

    def keep(self, entity: Any) -> Any:
        """Keep something with a `destroy()` method until cleanup and return it."""
        return self._keep(lambda item: item.destroy(), entity)

    def _keep(self, destroy: Callable[[Any], Any], entity: Any) -> Any:
        self._made.append((destroy, entity))
        return entity

    def kept(self, kind: type[T]) -> list[T]:
        """Return what is kept until cleanup and is of a kind."""
        return [entity for _, entity in self._made if isinstance(entity, kind)]

    def configure(self) -> None:
        """Build the core and the interfaces; raise an ArjunaError to refuse."""

    def activate(self) -> None:
        """Start work; raise an ArjunaError to refuse."""

    def deactivate(self) -> None:
        """Stop work; the periodic tasks and subscriptions already rest."""

    def cleanup(self) -> None:
        """Drop what `configure` made, beyond the entities, which are destroyed already."""

    def on_time_jump(self) -> None:
        """React to a clock that was set back; the transforms are cleared already."""

    def on_config(self, config: Any) -> None:
        """React to parameters changed once the node is configured."""

    def on_failure(self, reason: str) -> None:
        """React to a periodic task that raised, or to an outcome that could not be taken in."""

    def _attempt(self, step: Callable[[], None]) -> TransitionCallbackReturn:
        def run() -> TransitionCallbackReturn:
            try:
                step()
            except ArjunaError as error:
                self.get_logger().error(str(error))
                return TransitionCallbackReturn.FAILURE
            except NameValidationException as error:  # a parameter's, as any that is not valid
                self.get_logger().error(" ".join(str(error).removesuffix("^").split()))
                return TransitionCallbackReturn.FAILURE
            return TransitionCallbackReturn.SUCCESS

        # 90 s at most; the first transition ever compiles the algorithms.
        self.process.on_long_step(90.0)
        failed = TransitionCallbackReturn.ERROR
        return self.guarded(step.__name__, run, lambda reason: failed)()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run `configure`; what it made before it refused is destroyed again."""
        result = self._attempt(self.configure)
        if result != TransitionCallbackReturn.SUCCESS:
            self._release()
        return result

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Run `activate`, then let callbacks and periodic tasks in."""
        result = self._attempt(self.activate)
        self.active = result == TransitionCallbackReturn.SUCCESS
        self.due_at = 0.0
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Keep callbacks and periodic tasks out, then run `deactivate`."""
        self.active = False
        return self._attempt(self.deactivate)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Destroy the entities, then run `cleanup`."""
        self._release()
        return self._attempt(self.cleanup)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop and release everything, from any state."""
        if self.active:
            self.active = False
            self._attempt(self.deactivate)
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Release everything after a transition that raised; the node is unconfigured then."""
        self.active = False
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Shut down from any state; one that a client has shut down before stays so."""
        if self.state_label == "finalized":  # where rclpy raises
            return TransitionCallbackReturn.SUCCESS
        return super().trigger_shutdown()

    def destroy_node(self) -> None:
        """Leave the graph, with what rclpy forgets."""
        super().destroy_node()
        self._state_machine.destroy_when_not_in_use()

    def _release(self) -> None:
        self._tasks.clear()
        while self._made:
            destroy, entity = self._made.pop()
            destroy(entity)
