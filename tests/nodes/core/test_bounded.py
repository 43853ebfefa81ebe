"""Claims: a message of too many parts is refused as any other is, and costs little."""

from __future__ import annotations

import math
import time
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowPath
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter as RclpyParameter
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_server import GoalNode, GoalServer
from arjuna_core.ros.health import rules
from arjuna_core.ros.messages import is_of_lists
from tests.helpers.ros import RosBench
from tests.nodes.core.test_guard import FragileConfig

LONG = Path(poses=[PoseStamped()] * (rules.POSES + 1))


class ReadingNode(GoalNode):
    """Takes paths by a topic, a service and an action."""

    Config = FragileConfig
    DEFAULT_NAME = "reading"

    def configure(self) -> None:
        self.received: list[Any] = []
        self.subscribe(Path, "path", self.received.append, qos.DEFAULT)
        self.serve(IsPathValid, "is_path_valid", self._on_path)
        self.server = self.keep(GoalServer(self, FollowPath, "follow_path"))

    def _on_path(self, request: Any, response: Any) -> Any:
        response.is_valid = True
        return response


BENCH = {"transport": "dds"}


NODE = ReadingNode


def test_messages_of_lists_alone_are_known() -> None:
    assert all(map(is_of_lists, (Path, TFMessage)))
    assert not any(map(is_of_lists, (Odometry, OccupancyGrid, PointCloud2, String)))


def test_a_topic_s_message_is_not_even_read_and_the_next_is_received(
    bench: RosBench, node: ReadingNode
) -> None:
    publisher = bench.node.create_publisher(Path, "path", qos.DEFAULT)
    bench.process.drain()
    publisher.publish(Path(poses=[PoseStamped()] * 100_000))
    start = time.process_time()
    bench.process.drain()
    assert time.process_time() - start < 0.2
    assert not node.received
    ((_, source), tally) = next(iter(bench.process.guard.tallies.items()))
    assert (source, tally.kind) == ("path", "refused")
    assert tally.reason.endswith(f"bytes of lists; at most {rules.LISTED} are valid")
    bench.publish(Path, "path", Path(poses=LONG.poses[1:]))
    assert [len(path.poses) for path in node.received] == [rules.POSES]


def test_a_request_is_answered_as_failed(bench: RosBench, node: ReadingNode) -> None:
    assert not bench.call(IsPathValid, "is_path_valid", IsPathValid.Request(path=LONG)).is_valid
    assert bench.call(IsPathValid, "is_path_valid", IsPathValid.Request()).is_valid


@pytest.mark.parametrize(
    ("kind", "name", "field", "item"),
    [
        (SetParameters, "set_parameters", "parameters", Parameter(name="limit")),
        (GetParameters, "get_parameters", "names", "limit"),
        (ListParameters, "list_parameters", "prefixes", "limit"),
    ],
)
def test_rclpy_s_own_services_are_bounded(
    bench: RosBench, node: ReadingNode, kind: Any, name: str, field: str, item: Any
) -> None:
    counts = (rules.CALLS + 1, rules.CALLS)
    for count in counts:
        request = kind.Request(**{field: [item] * count})
        bench.call(kind, f"reading/{name}", request)
    (tally,) = bench.process.guard.tallies.values()
    assert tally.reason == f"{field}: {counts[0]} items; at most {counts[1]} are valid"


def test_a_parameter_of_no_type_is_refused(bench: RosBench, node: ReadingNode) -> None:
    request = SetParameters.Request(parameters=[Parameter(name="limit")])
    request.parameters[0].value.type = 97
    (result,) = bench.call(SetParameters, "reading/set_parameters", request).results
    assert result.reason == "parameters: item 0: value: type 97; valid: 0 to 9"


def test_a_parameter_that_is_not_finite_leaves_the_others_of_its_request(
    bench: RosBench, node: ReadingNode
) -> None:
    given = [RclpyParameter("limit", value=value).to_parameter_msg() for value in (math.nan, 5.0)]
    request = SetParameters.Request(parameters=given)
    first, second = bench.call(SetParameters, "reading/set_parameters", request).results
    assert (first.successful, second.successful) == (False, True)
    assert node.config.limit == 5.0


def test_a_goal_is_aborted_and_says_why(bench: RosBench, node: ReadingNode) -> None:
    outcomes: list[GoalOutcome] = []
    client = GoalClient(node, FollowPath, "follow_path")
    client.send(FollowPath.Goal(path=LONG), outcomes.append)
    bench.process.drain()
    (outcome,) = outcomes
    assert outcome.status == GoalStatus.STATUS_ABORTED
    assert outcome.result is not None
    assert f"path.poses: {rules.POSES + 1} items" in outcome.result.error_msg
    client.destroy()
