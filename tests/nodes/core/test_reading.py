"""Claims: a message that is read the fast way is the one that was sent, part for part."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.srv import SetParameters
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from rosidl_parser import definition
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan, PointCloud2
from simulation_interfaces.srv import SpawnEntities
from std_msgs.msg import Empty, String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from arjuna_core.ros.health import bounded
from arjuna_core.ros.health.reading import reader_of
from tests.helpers.messages import fill

pytestmark = pytest.mark.ros
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


@pytest.mark.parametrize("cls", TYPES, ids=lambda cls: str(cls.__name__))
def test_what_is_read_is_what_was_sent(cls: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    assert reader_of(cls) is not None
    bounded.bound([cls])
    monkeypatch.setattr(fill, "LENGTHS", (0, 1, 7, 30))
    monkeypatch.setattr(fill, "ZIGZAG", 50)
    monkeypatch.setattr(fill, "_MOST", 1000)
    filler = fill.Filler(np.random.default_rng(3))
    for message in (cls(), *(filler.message(cls) for _ in range(8))):
        got = deserialize_message(serialize_message(message), cls)
        assert parts(got) == parts(message)


def test_what_is_read_shares_no_memory() -> None:
    from arjuna_core.ros.health import bounded

    bounded.bound([Odometry])
    sent = serialize_message(Odometry())
    first, second = (deserialize_message(sent, Odometry) for _ in range(2))
    first.pose.covariance[0] = 1.0
    assert second.pose.covariance[0] == 0.0


def test_a_type_that_only_rclpy_can_read_is_left_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = tuple(definition.UnboundedWString() for _ in String.SLOT_TYPES)
    monkeypatch.setattr(String, "SLOT_TYPES", wide)
    assert reader_of(String) is None
