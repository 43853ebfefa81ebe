"""Asks the robot's servers what a tree asks, and collects their answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String

from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_nav.nodes.frames import pose_in
from arjuna_nav.nodes.trees.messages import (
    action_type,
    answer_of,
    plain_values,
    request_msg,
    service_type,
    unknown_code,
)
from arjuna_nav.trees.exchange import Answer, Ask, Battery, Heard, Topic, TreeState, Withdraw
from arjuna_nav.trees.nav2.decorators import GOAL_UPDATE


@dataclass
class _Question:
    """Something asked that is not answered yet."""

    ask: Ask
    since: float
    client: Any
    sent: bool = False


class TreeClients:
    """Carries out what trees ask.

    Args:
        node: bt_navigator; made in its `configure`.
        config: Its parameters.
    """

    def __init__(self, node: ManagedNode, config: Any) -> None:
        self._node = node
        self._config = config
        self._clients: dict[tuple[str, str], Any] = {}
        self._open: dict[int, _Question] = {}
        self._answers: dict[int, Answer] = {}
        self._topics: set[Topic] = set()
        self._feedback: dict[int, Mapping[str, Any]] = {}
        self._selected: dict[str, str] = {}
        self._batteries: dict[str, Battery] = {}
        self._moved_goal: SE2 | None = None

    def listen(self, topics: set[Topic]) -> None:
        """Listen to the topics that a tree must be told of; what moved an older goal is over."""
        self._moved_goal = None
        for topic in sorted(topics - self._topics, key=lambda topic: topic.name):
            self._topics.add(topic)
            if topic.heard is Heard.GOAL:
                self._node.subscribe(PoseStamped, topic.name, self._on_moved_goal, qos.DEFAULT)
            elif topic.heard is Heard.BATTERY:
                hear = partial(self._on_battery, topic.name)
                self._node.subscribe(BatteryState, topic.name, hear, qos.SENSOR_SUBSCRIPTION)
            else:
                take = partial(self._select, topic.name)
                self._node.subscribe(String, topic.name, take, qos.LATCHED, while_inactive=True)

    def _select(self, topic: str, message: Any) -> None:
        self._selected[topic] = message.data

    def _on_battery(self, topic: str, message: Any) -> None:
        charges = message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
        self._batteries[topic] = Battery(message.percentage, message.voltage, charges)

    def _on_moved_goal(self, message: Any) -> None:
        try:
            self._moved_goal = pose_in(self._node, self._config.global_frame, message)
        except TransformError as error:
            self._node.get_logger().warning(f"{GOAL_UPDATE} ignored: {error}")

    def state(self, pose: SE2 | None, velocity: Velocity, measured_at: float) -> TreeState:
        """Return what a tree is told now, answers and feedback once.

        Args:
            pose: Of the robot, None where it is not known.
            velocity: Of the robot.
            measured_at: When it had that velocity [s].
        """
        for key, question in list(self._open.items()):
            self._look_after(key, question)
        answers, self._answers = self._answers, {}
        feedback, self._feedback = self._feedback, {}
        return TreeState(
            self._node.now,
            pose,
            velocity,
            measured_at,
            answers,
            feedback,
            self._selected,
            self._moved_goal,
            self._batteries,
            self._connected,
        )

    def _connected(self, parent: str, child: str) -> bool:
        return self._node.transforms.try_lookup(parent, child) is not None

    def stop(self) -> None:
        """Cancel all that was asked."""
        for key in list(self._open):
            self.carry_out(Withdraw(key))
        self._answers.clear()
        self._feedback.clear()

    def carry_out(self, command: Ask | Withdraw) -> None:
        """Ask, or withdraw what was asked."""
        if isinstance(command, Ask):
            client = self._client(command.kind, command.server)
            self._drop_older(client)
            question = _Question(command, self._node.now, client)
            self._open[command.key] = question
            self._look_after(command.key, question)
            return
        withdrawn = self._open.pop(command.key, None)
        self._answers.pop(command.key, None)
        if withdrawn is not None and withdrawn.sent and isinstance(withdrawn.client, GoalClient):
            withdrawn.client.cancel()

    def _drop_older(self, client: Any) -> None:
        """Forget what the same action was asked before: the newer goal takes its place."""
        if isinstance(client, GoalClient):
            for key in [k for k, q in self._open.items() if q.client is client]:
                del self._open[key]

    def _client(self, kind: str, server: str) -> Any:
        if (kind, server) not in self._clients:
            action = action_type(kind)
            self._clients[kind, server] = (
                self._node.client(service_type(kind), server)
                if action is None
                else self._node.keep(GoalClient(self._node, action, server))
            )
        return self._clients[kind, server]

    def _look_after(self, key: int, question: _Question) -> None:
        """Send what is not sent yet; give up on who is not there or does not answer."""
        client, ask = question.client, question.ask
        is_action = isinstance(client, GoalClient)
        ready = client.ready if is_action else client.service_is_ready()
        if ready and not question.sent:
            question.sent, question.since = True, self._node.now
            (self._send_goal if is_action else self._call)(key, question)
            return
        limit = self._config.wait_for_service_timeout / 1000.0
        silent = self._node.now - question.since > limit
        if silent and not (ready and is_action):
            what = "did not answer" if ready else "is not there"
            self._fail(key, f"{ask.server} {what} within {limit:g} s at {self._node.now:.2f} s")

    def _send_goal(self, key: int, question: _Question) -> None:
        ask, frame = question.ask, self._config.global_frame
        goal = request_msg(action_type(ask.kind).Goal, ask.fields, frame, self._node.now)  # type: ignore[union-attr]

        def ended(outcome: GoalOutcome) -> None:
            if self._open.get(key) is not question:
                return
            if outcome.result is None:
                self._fail(key, f"{ask.server} refused the goal; its log says why")
            else:
                self._answer(key, answer_of(outcome.result, outcome.succeeded))

        def told(feedback: Any) -> None:
            if self._open.get(key) is question:
                self._feedback[key] = plain_values(feedback)

        question.client.send(goal, ended, told if ask.feedback else None)

    def _call(self, key: int, question: _Question) -> None:
        ask, frame = question.ask, self._config.global_frame
        message = service_type(ask.kind).Request
        request = request_msg(message, ask.fields, frame, self._node.now)

        def answered(future: Any) -> None:
            if self._open.get(key) is question:
                self._answer(key, Answer(bool(getattr(future.result(), "is_valid", True))))

        question.client.call_async(request).add_done_callback(answered)

    def _fail(self, key: int, message: str) -> None:
        action = action_type(self._open[key].ask.kind)
        code = unknown_code(action.Result) if action is not None else 0
        self._node.get_logger().warning(message)
        self._answer(key, Answer(False, code, message))

    def _answer(self, key: int, answer: Answer) -> None:
        del self._open[key]
        self._answers[key] = answer
