"""Claims: a message of too many parts costs next to nothing, and is refused as any other is."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from action_msgs.msg import GoalStatus, GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath, NavigateThroughPoses
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import Path
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.serialization import deserialize_message, serialize_message
from rosidl_parser import definition
from simulation_interfaces.srv import GetEntitiesStates, SpawnEntities
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_node import GoalNode
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.health import bounded
from tests.helpers.messages import fill
from tests.helpers.ros import RosBench
from tests.nodes.core.test_guard import FragileConfig

pytestmark = pytest.mark.ros
TYPES: tuple[Any, ...] = (
    *(Path, TFMessage, GoalStatusArray, DiagnosticArray, MarkerArray, SpawnEntities.Request),
    *(SetParameters.Request, GetParameters.Request, GetEntitiesStates.Request),
    *(FollowPath.Impl.SendGoalService.Request, NavigateThroughPoses.Impl.SendGoalService.Request),
)
FEW = 100
PATH = Path(poses=[PoseStamped()] * FEW)


class ReadingNode(GoalNode):
    """Takes paths by a topic, a service and an action."""

    Config = FragileConfig
    DEFAULT_NAME = "reading"

    def configure(self) -> None:
        self.heard: list[Any] = []
        self.subscribe(Path, "path", self.heard.append, qos.DEFAULT)
        self.serve(IsPathValid, "is_path_valid", self._on_path)
        self.server = self.keep(GoalServer(self, FollowPath, "follow_path"))

    def _on_path(self, request: Any, response: Any) -> Any:
        response.is_valid = True
        return response


@pytest.fixture
def bench() -> Iterator[RosBench]:
    bench = RosBench(transport="dds")
    yield bench
    bench.close()


@pytest.fixture
def node(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> ReadingNode:
    node = ReadingNode(bench.process)
    node.trigger_configure()
    node.trigger_activate()
    bench.process.drain()
    monkeypatch.setattr(bounded, "MOST_PARTS", 6 * FEW - 1)
    return node


def objects(message: Any) -> int:
    """Count the messages and texts in the lists of a message, which is what it takes to read it."""
    total = 0
    for name, kind in zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True):
        value = getattr(message, name)
        if isinstance(kind, definition.AbstractSequence):
            item = kind.value_type
            if isinstance(item, definition.AbstractGenericString):
                total += len(value)
            elif isinstance(item, definition.NamespacedType):
                total += sum(whole(each) + objects(each) for each in value)
        elif isinstance(kind, definition.NamespacedType):
            total += objects(value)
    return total


def whole(message: Any) -> int:
    """Count a message and those that are fields of it, and two for each array of fixed length."""
    fields = (getattr(message, name) for name in message.get_fields_and_field_types())
    within = sum(whole(f) for f in fields if hasattr(f, "SLOT_TYPES"))
    arrays = sum(isinstance(kind, definition.Array) for kind in message.SLOT_TYPES)
    return within + 2 * arrays + (100 if isinstance(message, Parameter) else 1)


@pytest.mark.parametrize("cls", TYPES, ids=lambda cls: str(cls.__name__))
def test_the_parts_in_c_are_those_in_python(cls: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    counted: list[int] = []
    count = bounded._parts

    def remembered(address: int, lists: Any) -> int:
        counted.append(count(address, lists))
        return counted[-1]

    bounded.bound([cls])
    monkeypatch.setattr(bounded, "_COPIED", 1 << 40)  # the bytes of texts are another test's
    monkeypatch.setattr(fill, "LENGTHS", (0, 1, 7, 30))
    monkeypatch.setattr(fill, "ZIGZAG", 50)
    filler = fill.Filler(np.random.default_rng(7))
    for _ in range(8):
        sent = serialize_message(filler.message(cls))
        with monkeypatch.context() as patch:
            patch.setattr(bounded, "_parts", remembered)
            got = deserialize_message(sent, cls)
        assert counted[-1] == objects(got)


def test_all_but_the_lists_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    cls = FollowPath.Impl.SendGoalService.Request
    bounded.bound([cls])
    sent = cls(goal=FollowPath.Goal(path=PATH, controller_id="a name"))
    sent.goal_id.uuid[3] = 7
    monkeypatch.setattr(bounded, "MOST_PARTS", 6 * FEW - 1)
    got = deserialize_message(serialize_message(sent), cls)
    assert got.goal.refusal == f"goal.path.poses has {FEW} items, too many to read"
    assert (got.goal_id, got.goal.controller_id) == (sent.goal_id, "a name")
    assert len(got.goal.path.poses) == 0


@pytest.mark.parametrize(
    "message",
    [
        GetParameters.Request(names=["x" * 10_000] * 20),
        ListParameters.Request(prefixes=["x"] * 20),
        Path(poses=[PoseStamped(header=Header(frame_id="x" * 10_000))] * 20),
    ],
    ids=["texts", "calls", "texts of items"],
)
def test_long_texts_and_calls_of_many_items_count(
    message: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    cls = type(message)
    bounded.bound([cls])
    sent = serialize_message(message)
    assert not hasattr(deserialize_message(sent, cls), "refusal")
    monkeypatch.setattr(bounded, "MOST_PARTS", 150)
    monkeypatch.setattr(bounded, "_COPIED", 1000)
    assert "has 20 items, too many to read" in deserialize_message(sent, cls).refusal


def test_what_is_raised_while_c_reads_is_raised_after_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(address: int, lists: Any) -> int:
        raise KeyboardInterrupt

    bounded.bound([Path])
    monkeypatch.setattr(bounded, "_parts", interrupted)
    assert deserialize_message(serialize_message(PATH), Path) == Path()
    with pytest.raises(KeyboardInterrupt):
        bounded.raise_what_was_raised()
    bounded.raise_what_was_raised()


def test_a_topic_s_message_is_refused_and_the_next_is_heard(
    bench: RosBench, node: ReadingNode
) -> None:
    bench.publish(Path, "path", PATH)
    assert not node.heard
    ((_, source), tally) = next(iter(bench.process.guard.tallies.items()))
    assert (source, tally.kind) == ("path", "refused")
    bench.publish(Path, "path", Path(poses=PATH.poses[1:]))
    assert [len(path.poses) for path in node.heard] == [FEW - 1]


def test_a_request_is_answered_as_failed(bench: RosBench, node: ReadingNode) -> None:
    assert not bench.call(IsPathValid, "is_path_valid", IsPathValid.Request(path=PATH)).is_valid
    assert bench.call(IsPathValid, "is_path_valid", IsPathValid.Request()).is_valid


def test_rclpy_s_own_services_are_bounded(bench: RosBench, node: ReadingNode) -> None:
    name = "reading/set_parameters"
    request = SetParameters.Request(parameters=[Parameter(name="limit")] * 6)
    assert not bench.call(SetParameters, name, request).results  # none of them was looked at
    few = SetParameters.Request(parameters=request.parameters[1:])
    assert len(bench.call(SetParameters, name, few).results) == 5


def test_a_parameter_of_no_type_is_refused(bench: RosBench, node: ReadingNode) -> None:
    request = SetParameters.Request(parameters=[Parameter(name="limit")])
    request.parameters[0].value.type = 97
    (result,) = bench.call(SetParameters, "reading/set_parameters", request).results
    assert result.reason == "limit: type 97; valid: 0 to 9"


def test_a_goal_is_aborted_and_says_why(bench: RosBench, node: ReadingNode) -> None:
    outcomes: list[GoalOutcome] = []
    client = GoalClient(node, FollowPath, "follow_path")
    client.send(FollowPath.Goal(path=PATH), outcomes.append)
    bench.process.drain()
    (outcome,) = outcomes
    assert outcome.status == GoalStatus.STATUS_ABORTED
    assert outcome.result is not None
    assert "too many to read" in outcome.result.error_msg
    client.destroy()
