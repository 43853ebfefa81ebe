"""Copies of messages, and their bytes: the same as those that go through rclpy."""

from __future__ import annotations

import math
import struct
import time
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, PoseStamped, PoseWithCovarianceStamped, Twist
from nav2_msgs.action import FollowPath
from nav2_msgs.srv import IsPathValid
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Log, Parameter, SetParametersResult
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter as RclpyParameter
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan, PointCloud2
from simulation_interfaces.srv import SpawnEntities
from std_msgs.msg import Empty, String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.goal_server import GoalNode, GoalServer
from arjuna_core.ros.health import rules
from arjuna_core.ros.local.cdr import to_cdr
from arjuna_core.ros.local.reading import handed_over, reader
from arjuna_core.ros.messages import is_of_lists, maker, quicken
from tests.fuzz import messages as fill
from tests.helpers.ros import RosBench
from tests.nodes.core.test_guard import FragileConfig

TYPES: tuple[Any, ...] = (
    *(Odometry, Imu, JointState, LaserScan, TFMessage, Clock, Twist, PoseWithCovarianceStamped),
    *(Image, CameraInfo, PointCloud2, OccupancyGrid, Path, MarkerArray, DiagnosticArray, Empty),
    *(SetParameters.Request, SpawnEntities.Request),
)


def parts(value: Any, kind: str = "") -> Any:
    """Return what a message is made of and what those parts are in Python; NaN is itself."""
    if hasattr(value, "SLOT_TYPES"):
        within = value.get_fields_and_field_types().items()
        return type(value), [parts(getattr(value, name), kind) for name, kind in within]
    if isinstance(value, list):
        return [parts(item) for item in value]
    single = np.float32(value) if kind == "float" else value
    return type(value), getattr(value, "dtype", None), repr(single)


@pytest.fixture
def filler(monkeypatch: pytest.MonkeyPatch) -> fill.Filler:
    monkeypatch.setattr(fill, "LENGTHS", (0, 1, 7, 30))
    monkeypatch.setattr(fill, "ZIGZAG", 50)
    monkeypatch.setattr(fill, "_MOST", 1000)
    return fill.Filler(np.random.default_rng(4))


@pytest.mark.parametrize("cls", [*TYPES, Log, SetParametersResult], ids=lambda cls: cls.__name__)
def test_copies_bytes_and_reading_are_the_middlewares(cls: Any, filler: fill.Filler) -> None:
    read, copied = reader(cls), handed_over(cls, trusted=False)
    assert copied is not None
    for message in (cls(), *(filler.message(cls) for _ in range(8))):
        theirs, ours = serialize_message(message), to_cdr(message)
        through = parts(deserialize_message(theirs, cls))
        assert parts(copied(message)) == through
        assert parts(deserialize_message(ours, cls)) == through
        assert len(ours) <= len(theirs)  # rclpy counts gaps before what is not there
        assert all(a == b for a, b in zip(theirs, ours, strict=False) if b != 0)
        assert to_cdr(message) == ours
        for data in (theirs, ours):
            assert parts(read(data)) == through
            assert read(bytes(data)) is read(data), "the readers of a process share it"
        rounded = handed_over(cls, trusted=True)
        assert rounded is None or rounded(message) is message
        assert parts(message) == through, "a trusted message is rounded"


@pytest.mark.parametrize("cls", [Odometry, LaserScan, TFMessage, JointState, CameraInfo])
def test_truncated_or_invalid_bytes_are_no_message(cls: Any, filler: fill.Filler) -> None:
    data = to_cdr(filler.message(cls))
    for end in (*range(0, len(data) - 1, 1 + len(data) // 50), len(data) - 1):
        with pytest.raises(ValueError, match=f"{end} bytes that are no {cls.__name__}"):
            reader(cls)(data[:end])
    with pytest.raises(ValueError, match="that are no"):
        reader(cls)(data[:4] + b"\xff" * (len(data) - 4))


def test_another_byte_order_is_read_too() -> None:
    data = b"\x00\x00\x00\x00" + struct.pack(">iI", 7, 9)
    assert reader(Clock)(data).clock == Time(sec=7, nanosec=9)


def test_a_text_ends_where_rclpy_ends_it() -> None:
    for text in (b"odom\x00", b"od\x00om\x00", b"", b"\xff\x00", b"odom"):
        data = b"\x00\x01\x00\x00" + struct.pack("<I", len(text)) + text
        assert reader(String)(data).data == deserialize_message(data, String).data


def rclpy_default(cls: Any, **given: Any) -> Any:
    """Return what the constructor of rclpy's generator makes."""
    message = object.__new__(cls)
    cls.__init__.__wrapped__(message, **given)
    return message


@pytest.mark.parametrize("cls", TYPES, ids=lambda cls: str(cls.__name__))
def test_constructors_and_makers_make_what_rclpys_own_do(cls: Any, filler: fill.Filler) -> None:
    quicken(cls)
    assert parts(cls()) == parts(maker(cls)()) == parts(rclpy_default(cls))
    message, names = filler.message(cls), list(cls.get_fields_and_field_types())
    given = {name: getattr(message, name) for name in names}
    assert parts(cls(**given)) == parts(rclpy_default(cls, **given)) == parts(message)
    assert parts(maker(cls, *names)(*given.values())) == parts(message)


def test_fields_that_are_given_as_lists_become_arrays_as_rclpys_do() -> None:
    quicken(Odometry, OccupancyGrid)
    grid = OccupancyGrid(data=[1, 2])
    assert (grid.data.typecode, list(grid.data)) == ("b", [1, 2])
    grid.data = [3]
    assert (grid.data.typecode, list(grid.data)) == ("b", [3])
    covariance = Odometry().pose
    covariance.covariance = [1.0] * 36
    assert covariance.covariance.dtype == np.float64


@pytest.mark.parametrize("cls", [Odometry, OccupancyGrid, TFMessage])
def test_a_fresh_message_is_a_default_one_of_its_own(cls: Any) -> None:
    quicken(cls)
    first = cls()
    assert parts(first) == parts(cls())
    if cls is Odometry:
        first.pose.covariance[0] = first.twist.twist.linear.x = 1.0
    elif cls is OccupancyGrid:
        first.data.append(1)
    else:
        first.transforms.append(None)
    assert parts(cls()) == parts(rclpy_default(cls))


def test_a_maker_sets_fields_of_fields_and_shares_no_arrays() -> None:
    make = maker(Odometry, "twist.twist.angular.z", "header.stamp.sec", "pose.pose.position")
    first, at = make(0.5, 3, Point(x=1.0)), make(0.0, 0, Point(y=2.0)).pose.pose.position
    first.pose.covariance[0] = 1.0
    assert (first.twist.twist.angular.z, first.header.stamp.sec) == (0.5, 3)
    assert (first.pose.pose.position.x, at.y) == (1.0, 2.0)
    assert not make(0.0, 0, Point()).pose.covariance.any()
    with pytest.raises(ValueError, match=r"Twist has no linear\.v"):
        maker(Twist, "linear.x", "linear.v")


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


def test_a_huge_message_is_skipped_unread(bench: RosBench, node: ReadingNode) -> None:
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


def test_a_parameter_not_finite_leaves_the_others(bench: RosBench, node: ReadingNode) -> None:
    given = [RclpyParameter("limit", value=value).to_parameter_msg() for value in (math.nan, 5.0)]
    request = SetParameters.Request(parameters=given)
    first, second = bench.call(SetParameters, "reading/set_parameters", request).results
    assert (first.successful, second.successful) == (False, True)
    assert node.config.limit == 5.0
