"""Lifecycles of the nodes that were launched: changed and reported by events."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from typing import Any

from launch.event_handler import EventHandler
from launch.launch_context import LaunchContext
from launch.logging import get_logger

_PATIENCE = 30.0  # [s] for a node's services to be there
_DONE = {1: (2, 3), 3: (3,)}  # states in which configuring, activating is done already


class LifecycleTransitions:
    """A node of ROS in the launching process, which asks the launched ones."""

    def __init__(self, context: LaunchContext) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        from arjuna_core.ros.context import new_context

        self._context, self._loop = context, asyncio.get_running_loop()
        self._ros = new_context(words=[])  # the launch file's arguments are no remappings
        self._node = rclpy.create_node("launch_ros", context=self._ros)
        self._executor = SingleThreadedExecutor(context=self._ros)
        self._executor.add_node(self._node)
        threading.Thread(target=self._spin, daemon=True).start()
        context.on_end.append(self._ros.try_shutdown)

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        with suppress(ExternalShutdownException):
            self._executor.spin()

    @classmethod
    def of(cls, context: LaunchContext) -> LifecycleTransitions:
        found = getattr(context.locals, "lifecycle_transitions", None)
        if found is None:
            found = cls(context)
            context.extend_locals({"lifecycle_transitions": found})
        return found

    def follow(self, action: Any, autostart: bool) -> None:
        """Follow a node's state, and change it when events ask for it."""
        from lifecycle_msgs.msg import TransitionEvent

        from launch_ros.events.lifecycle import ChangeState, StateTransition

        def changed(message: Any) -> None:
            start, goal = message.start_state.label, message.goal_state.label
            event = StateTransition(action=action, start_state=start, goal_state=goal)
            self._loop.call_soon_threadsafe(self._context.emit_event_sync, event)

        topic = f"{action.node_name}/transition_event"
        self._node.create_subscription(TransitionEvent, topic, changed, 10)

        def asked(event: Any, context: LaunchContext) -> None:
            context.start(self.change(action.node_name, event.transition_id))

        self._context.register_event_handler(
            EventHandler(
                matcher=lambda event: (
                    isinstance(event, ChangeState) and event.lifecycle_node_matcher(action)
                ),
                entities=asked,
            )
        )
        if autostart:
            self._context.start(self.change(action.node_name, 1, 3))

    async def change(self, node: str, *transitions: int) -> None:
        """Take a node, by its full name, through transitions."""
        from lifecycle_msgs.srv import ChangeState, GetState

        async def is_done(number: int) -> bool:
            state = await self._ask(GetState, f"{node}/get_state", GetState.Request())
            return state is not None and state.current_state.id in _DONE.get(number, ())

        for number in transitions:
            if await is_done(number):
                continue
            request = ChangeState.Request()
            request.transition.id = number
            done = await self._ask(ChangeState, f"{node}/change_state", request)
            if (done is None or not done.success) and not await is_done(number):  # by a manager
                why = "its services do not answer" if done is None else "it refused"
                problem = f"Failed to make transition {number} of '{node}': {why}"
                get_logger("launch_ros").error(problem)
                return

    async def _ask(self, kind: Any, name: str, request: Any) -> Any:
        client = self._node.create_client(kind, name)
        end = self._loop.time() + _PATIENCE
        try:
            while not client.service_is_ready():
                if self._loop.time() > end or self._context.is_shutdown:
                    return None
                await asyncio.sleep(0.1)
            future = client.call_async(request)
            while not future.done():
                if self._loop.time() > end or self._context.is_shutdown:
                    return None
                await asyncio.sleep(0.02)
            return future.result()
        finally:
            self._node.destroy_client(client)
