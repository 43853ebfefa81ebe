"""Claims: a message that cannot be used is refused where it enters, in words, and counted."""

from __future__ import annotations

import math
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import (
    Point32,
    Polygon,
    PoseStamped,
    PoseWithCovariance,
)
from nav2_msgs.action import FollowPath
from nav2_msgs.srv import IsPathValid, LoadMap, SetInitialPose
from nav_msgs.msg import Odometry, Path
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import transform_msg
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_server import GoalNode, GoalServer
from arjuna_core.ros.health import rules
from arjuna_core.ros.health.checks import problem_of
from arjuna_core.se2 import SE2
from tests.helpers.ros import RosBench, changed
from tests.nodes.core.test_guard import FragileConfig


class OpenNode(GoalNode):
    """Takes whatever comes, and does nothing with it."""

    Config = FragileConfig
    DEFAULT_NAME = "open"
    trusted = False

    def configure(self) -> None:
        self.received: list[Any] = []
        self.subscribe(Odometry, "odom", self.received.append, qos.DEFAULT)
        self.serve(LoadMap, "load_map", lambda request, response: response)
        valid = IsPathValid.Response(is_valid=True)
        self.serve(IsPathValid, "is_path_valid", lambda request, response: valid)
        self.serve_later(IsPathValid, "later", lambda request, respond: respond(valid))
        self.server = self.keep(GoalServer(self, FollowPath, "follow_path", unknown=100))


NODE = OpenNode


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (Path(poses=[PoseStamped()] * (rules.POSES + 1)), f"poses: {rules.POSES + 1} items"),
        (Polygon(points=[Point32()] * (rules.CORNERS + 1)), "points: 1001 items"),
        (LoadMap.Request(map_url="x" * 5000), "map_url: 5000 characters"),
        (String(data="x" * (rules.DOCUMENT + 1)), "data: 16777217 characters"),
        (Clock(clock=Time(sec=-1)), "clock: -1 s"),
        (PointCloud2(width=1, height=1), "'x' is no field of a point"),
        (PoseWithCovariance(covariance=[-1.0] + [0.0] * 35), "a variance is -1.0"),
        (FollowPath.Goal(path=Path(poses=[PoseStamped()] * 100_000)), "path.poses: 100000"),
    ],
)
def test_what_is_too_long_or_cannot_be_is_refused_unread(message: Any, problem: str) -> None:
    assert problem in str(problem_of(message))


def test_a_duration_may_be_negative_but_not_of_too_many_nanoseconds() -> None:
    request = SetInitialPose.Request()
    assert problem_of(request) is None
    assert problem_of(Duration(sec=-1)) is None


def test_a_measurement_from_the_future_is_refused_and_a_goal_s_stamp_is_not() -> None:
    later = Time(sec=1000)
    assert "990 s ahead" in str(problem_of(changed(Odometry(), "header.stamp", later), 10.0))
    assert problem_of(changed(Odometry(), "header.stamp", later)) is None  # no clock yet
    assert problem_of(changed(PoseStamped(), "header.stamp", later), 10.0) is None


def test_a_node_hears_only_what_it_can_use(bench: RosBench, node: OpenNode) -> None:
    bench.publish(Odometry, "odom", changed(Odometry(), "pose.pose.position.x", math.nan))
    bench.publish(Odometry, "odom", Odometry())
    assert len(node.received) == 1
    tally = bench.process.guard.tallies[("/open", "odom")]
    assert (tally.kind, tally.count) == ("refused", 1)
    assert tally.reason == "pose.pose.position.x: nan is not finite"


def test_an_unusable_request_is_answered_in_its_own_code(bench: RosBench, node: OpenNode) -> None:
    answer = bench.call(LoadMap, "load_map", LoadMap.Request(map_url="x" * 5000))
    assert answer.result == LoadMap.Response.RESULT_UNDEFINED_FAILURE
    for service in ("is_path_valid", "later"):
        for x in (math.inf, 0.0):
            path = Path(poses=[changed(PoseStamped(), "pose.position.x", x)])
            answer = bench.call(IsPathValid, service, IsPathValid.Request(path=path))
            assert answer.is_valid is (x == 0.0)


def test_an_unusable_goal_is_aborted_with_the_reason(bench: RosBench, node: OpenNode) -> None:
    outcomes: list[GoalOutcome] = []
    client = GoalClient(node, FollowPath, "follow_path")
    bench.process.drain()
    goal = FollowPath.Goal()
    goal.path.poses = [changed(PoseStamped(), "pose.position.x", 1e300)]
    client.send(goal, outcomes.append)
    bench.process.drain()
    assert outcomes[0].status == GoalStatus.STATUS_ABORTED
    result: Any = outcomes[0].result
    assert (result.error_code, result.error_msg) == (
        FollowPath.Result.INVALID_PATH,
        "path.poses: item 0: pose.position.x: 1e+300 is too great",
    )
    assert node.server.goal is None


def test_what_is_refused_is_reported_on_diagnostics(bench: RosBench, node: OpenNode) -> None:
    received = bench.collect(DiagnosticArray, "/diagnostics")
    bench.advance(8.0)
    bench.publish(Odometry, "odom", changed(Odometry(), "pose.pose.position.x", math.nan))
    bench.advance(1.0)
    before, after = (
        {status.name: status for status in array.status}["/open: messages"]
        for array in (received[0], received[-1])
    )
    assert (before.level, before.message) == (DiagnosticStatus.OK, "all could be used")
    assert (after.level, after.message) == (
        DiagnosticStatus.WARN,
        "pose.pose.position.x: nan is not finite",
    )
    assert [(item.key, item.value.split(",")[0]) for item in after.values] == [
        ("odom refused", "1")
    ]
    bench.advance(12.0)
    last = {status.name: status for status in received[-1].status}["/open: messages"]
    assert last.level == DiagnosticStatus.OK
    assert len(last.values) == 1


def test_a_broken_transform_leaves_the_good_ones(bench: RosBench, node: OpenNode) -> None:
    good = transform_msg(SE2(1.0, 2.0), "odom", "base_link", 1.0)
    broken = transform_msg(SE2(0.0, 0.0), "odom", "other", 1.0)
    broken.transform.translation.x = math.nan
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[broken, good]))
    assert bench.process.transforms.lookup("odom", "base_link") == SE2(1.0, 2.0)
    assert bench.process.transforms.try_lookup("odom", "other") is None


def test_a_clock_that_cannot_be_leaves_the_time_as_it_is(bench: RosBench) -> None:
    bench.advance(1.0)
    clock = Clock(clock=Time(sec=-1))
    bench.publish(Clock, "/clock", clock)
    assert bench.process.now == pytest.approx(1.0)
