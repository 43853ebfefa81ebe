"""Sends the requests of trees to the robot's servers, and collects the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, velocity_from_twist
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_core.timing import Periodic
from arjuna_core.twist import RecentVelocities
from arjuna_nav.nodes.frames import pose_in
from arjuna_nav.nodes.trees.messages import (
    action_type,
    answer_of,
    plain_values,
    request_msg,
    service_type,
    unknown_code,
)
from arjuna_nav.trees.decorators import GOAL_UPDATE
from arjuna_nav.trees.exchange import Answer, Ask, Battery, Topic, TopicKind, TreeState, Withdraw


@dataclass
class _Request:
    """A request that is not answered yet.

    Attributes:
        since: When it was made, sent, or its action's server last seen [s].
        take: Called with the answer.
        sent: Whether it was sent.
        late: How many looks found it unanswered for too long.
    """

    ask: Ask
    since: float
    client: Any
    take: Callable[[Answer], None]
    sent: bool = False
    late: int = 0


class TreeClients:
    """The one client of the robot's servers: it carries out the requests of trees.

    It listens to what trees go by, too, and puts it together as the state of each tick.

    Args:
        node: bt_navigator; made in its `configure`.
        look_period: From one look for servers to the next [s]; one searches the graph, 0.3 ms.
    """

    def __init__(self, node: ManagedNode, config: Any, look_period: float = 0.2) -> None:
        self._node = node
        self._config = config
        self._clients: dict[tuple[str, str, bool], Any] = {}
        self._open: dict[int, _Request] = {}
        self._answers: dict[int, Answer] = {}
        self._topics: set[Topic] = set()
        self._feedback: dict[int, Mapping[str, Any]] = {}
        self._selected: dict[str, str] = {}
        self._batteries: dict[str, Battery] = {}
        self._calls: Mapping[str, Callable[[], str]] = {}
        self._moved_goal: SE2 | None = None
        self._look = Periodic(look_period)
        self._trials = 0
        self._recent = RecentVelocities(config.filter_duration)
        node.subscribe(Odometry, config.odom_topic, self._on_odometry, qos.SENSOR_SUBSCRIPTION)
        node.every(look_period, self._look_after_cancels)

    def listen(self, topics: set[Topic], calls: Mapping[str, Callable[[], str]]) -> None:
        """Listen to the topics of a tree, and answer its calls; what moved an older goal is over.

        Args:
            topics: Of the tree.
            calls: Its nodes' services; each returns why it refuses, or nothing.
        """
        self._moved_goal, self._calls = None, calls
        for topic in sorted(topics - self._topics, key=lambda topic: topic.name):
            self._topics.add(topic)
            if topic.kind is TopicKind.GOAL:
                self._node.subscribe(PoseStamped, topic.name, self._on_moved_goal, qos.DEFAULT)
            elif topic.kind is TopicKind.BATTERY:
                take = partial(self._on_battery, topic.name)
                self._node.subscribe(BatteryState, topic.name, take, qos.SENSOR_SUBSCRIPTION)
            elif topic.kind is TopicKind.CALL:
                self._node.serve(Trigger, topic.name, partial(self._on_call, topic.name))
            else:
                take = partial(self._on_selected, topic.name)
                self._node.subscribe(String, topic.name, take, qos.LATCHED, while_inactive=True)

    def _on_call(self, name: str, request: Any, response: Any) -> Any:
        call = self._calls.get(name, lambda: "the tree that has this service does not run")
        response.message = call()
        response.success = not response.message
        return response

    def _on_selected(self, topic: str, message: Any) -> None:
        self._selected[topic] = message.data

    def _on_battery(self, topic: str, message: Any) -> None:
        charges = message.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
        self._batteries[topic] = Battery(message.percentage, message.voltage, charges)

    def _on_moved_goal(self, message: Any) -> None:
        try:
            self._moved_goal = pose_in(self._node, self._config.global_frame, message)
        except TransformError as error:
            self._node.get_logger().warning(f"{GOAL_UPDATE} ignored: {error}")

    def _on_odometry(self, message: Any) -> None:
        self._recent.add(velocity_from_twist(message.twist.twist), seconds(message.header.stamp))

    def state(self) -> TreeState:
        """Return the state of a tree's tick, with each answer and feedback once."""
        if self._look.due(self._node.now):
            for key, request in list(self._open.items()):
                self._look_after(key, request)
        answers, self._answers = self._answers, {}
        feedback, self._feedback = self._feedback, {}
        frames = self._config.global_frame, self._config.robot_base_frame
        measured_at, velocity = self._recent.newest
        return TreeState(
            self._node.now,
            self._node.transforms.try_lookup(*frames),
            velocity,
            measured_at,
            answers,
            feedback,
            self._selected,
            self._moved_goal,
            self._batteries,
            self._transform,
            self._recent.mean,
        )

    def _transform(self, parent: str, child: str) -> SE2 | None:
        config = self._config
        frames = parent or config.global_frame, child or config.robot_base_frame
        return self._node.transforms.try_lookup(*frames)

    def stop(self) -> None:
        """Cancel all requests of the tree."""
        for key in [key for key in self._open if key > 0]:
            self._withdraw(key)
        self._answers.clear()
        self._feedback.clear()

    def carry_out(self, command: Ask | Withdraw) -> None:
        """Ask, or withdraw what was asked."""
        if isinstance(command, Withdraw):
            self._withdraw(command.key)
            return
        client = self._client(command.kind, command.server)
        self._begin(command, client, partial(self._keep, command.key))

    def trial_plan(self, goals: tuple[SE2, ...], take: Callable[[Answer], None]) -> None:
        """Ask for a plan to a pose, or through several, only to look at; `take` gets the answer."""
        fields: dict[str, Any] = {"planner_id": self._selected.get("planner_selector", "")}
        if len(goals) == 1:
            kind, server, fields["goal"] = "ComputePathToPose", "compute_path_to_pose", goals[0]
        else:
            kind, server = "ComputePathThroughPoses", "compute_path_through_poses"
            fields["goals"] = goals
        self._trials += 1
        ask = Ask(-self._trials, kind, server, fields)
        self._begin(ask, self._client(kind, server, trial=True), take)

    def _keep(self, key: int, answer: Answer) -> None:
        self._answers[key] = answer

    def _begin(self, ask: Ask, client: Any, take: Callable[[Answer], None]) -> None:
        if isinstance(client, GoalClient):  # the newer goal takes the place of the older
            for key in [k for k, request in self._open.items() if request.client is client]:
                del self._open[key]
        self._open[ask.key] = _Request(ask, self._node.now, client, take)
        self._look_after(ask.key, self._open[ask.key])

    def _withdraw(self, key: int) -> None:
        withdrawn = self._open.pop(key, None)
        self._answers.pop(key, None)
        if withdrawn is not None and withdrawn.sent and isinstance(withdrawn.client, GoalClient):
            withdrawn.client.cancel()

    def _client(self, kind: str, server: str, trial: bool = False) -> Any:
        if (kind, server, trial) not in self._clients:
            action = action_type(kind)
            self._clients[kind, server, trial] = (
                self._node.client(service_type(kind), server)
                if action is None
                else self._node.keep(GoalClient(self._node, action, server))
            )
        return self._clients[kind, server, trial]

    def _look_after(self, key: int, request: _Request) -> None:
        """Send what is not sent yet; give up on who is not there or does not answer."""
        client, ask, config, now = request.client, request.ask, self._config, self._node.now
        is_action = isinstance(client, GoalClient)
        runs = request.sent and is_action and client.acknowledged
        if runs and now - request.since <= config.wait_for_service_timeout / 1000.0:
            return  # its server was there lately
        ready = client.ready if is_action else client.service_is_ready()
        if ready and (runs or not request.sent):
            sent, request.sent, request.since = request.sent, True, now
            if not sent:
                (self._send_goal if is_action else self._call)(key, request)
            return
        waits = request.sent and ready  # for the goal to be taken, or for an answer
        own = waits * ask.timeout
        common = config.default_server_timeout if waits else config.wait_for_service_timeout
        limit = own or common / 1000.0
        request.late += now - request.since > limit
        # At the first look an answer may wait in the executor, behind what took long.
        if request.late > waits:
            problem = "did not answer" if waits else "is not there"
            if waits and is_action:
                client.cancel()
            self._fail(key, f"{ask.server} {problem} within {limit:g} s at {now:.2f} s")

    def _look_after_cancels(self) -> None:
        """Say which servers did not answer when a goal of theirs was cancelled."""
        limit = self._config.default_cancel_timeout / 1000.0
        for client in self._clients.values():
            if isinstance(client, GoalClient) and client.take_late_cancels(limit):
                text = f"{client.name}: a cancel was not answered within {limit:g} s"
                self._node.get_logger().error(text)

    def _send_goal(self, key: int, request: _Request) -> None:
        ask, frame = request.ask, self._config.global_frame
        goal = request_msg(action_type(ask.kind).Goal, ask.fields, frame, self._node.now)  # type: ignore[union-attr]

        def ended(outcome: GoalOutcome) -> None:
            if self._open.get(key) is not request:
                return
            if outcome.result is None:
                now = self._node.now
                self._fail(key, f"{ask.server} refused the goal at {now:.2f} s; its log says why")
            else:
                self._answer(key, answer_of(outcome.result, outcome.succeeded))

        def take_feedback(feedback: Any) -> None:
            if self._open.get(key) is request:
                self._feedback[key] = plain_values(feedback)

        request.client.send(goal, ended, take_feedback if ask.feedback else None)

    def _call(self, key: int, request: _Request) -> None:
        ask, frame = request.ask, self._config.global_frame
        message = service_type(ask.kind).Request
        body = request_msg(message, ask.fields, frame, self._node.now)

        def answered(future: Any) -> None:
            if self._open.get(key) is request:
                values = plain_values(future.result())
                self._answer(key, Answer(bool(values.get("is_valid", True)), values=values))

        request.client.call_async(body).add_done_callback(answered)

    def _fail(self, key: int, message: str) -> None:
        action = action_type(self._open[key].ask.kind)
        code = unknown_code(action.Result) if action is not None else 0
        self._node.get_logger().warning(message)
        self._answer(key, Answer(False, code, message))

    def _answer(self, key: int, answer: Answer) -> None:
        self._open.pop(key).take(answer)
