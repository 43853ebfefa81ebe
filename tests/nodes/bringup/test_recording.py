"""Recordings: what arrives is written byte for byte, with what rosbag2 needs to play it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

import yaml
from geometry_msgs.msg import Twist
from mcap.reader import make_reader
from nav_msgs.msg import OccupancyGrid
from rclpy.serialization import deserialize_message

from arjuna_core.ros import qos
from bringup.recording.message_definitions import message_definition, type_hash
from bringup.recording.recorder import Recorder, RecordingError
from tests.helpers.ros import RosBench

pytestmark = pytest.mark.ros


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    bench = RosBench()
    with Recorder(bench.process, path):
        bench.process.drain()
        for speed in (0.5, 1.5):
            bench.advance(0.1)
            message = Twist()
            message.linear.x = speed
            bench.publish(Twist, "/cmd_vel", message)
        bench.publish(OccupancyGrid, "/map", OccupancyGrid(), qos.LATCHED)
    bench.close()
    return path


def read(path: Path) -> list[tuple[Any, Any, Any]]:
    with path.open("rb") as file:
        return list(make_reader(file).iter_messages())


def test_messages_are_stamped_with_simulated_time_and_unchanged(recording: Path) -> None:
    rows = [(c.topic, m.log_time, m.data) for _, c, m in read(recording)]
    assert [(topic, time) for topic, time, _ in rows] == [
        ("/cmd_vel", 100_000_000),
        ("/cmd_vel", 200_000_000),
        ("/map", 200_000_000),
    ]
    assert [deserialize_message(data, Twist).linear.x for _, _, data in rows[:2]] == [0.5, 1.5]


def test_latched_topics_stay_latched(recording: Path) -> None:
    schema, channel, _ = read(recording)[-1]
    offered = yaml.safe_load(channel.metadata["offered_qos_profiles"])
    assert offered[0]["durability"] == "transient_local"
    assert channel.metadata["topic_type_hash"] == type_hash("nav_msgs/msg/OccupancyGrid")
    assert (schema.name, schema.encoding) == ("nav_msgs/msg/OccupancyGrid", "ros2msg")


def test_a_definition_carries_every_type_it_needs_once() -> None:
    text = message_definition("nav_msgs/msg/OccupancyGrid")
    named = [line[5:] for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(named) == [
        "builtin_interfaces/Time",
        "geometry_msgs/Point",
        "geometry_msgs/Pose",
        "geometry_msgs/Quaternion",
        "nav_msgs/MapMetaData",
        "std_msgs/Header",
    ]


def test_an_existing_recording_is_never_overwritten(recording: Path) -> None:
    bench = RosBench()
    with pytest.raises(RecordingError, match="exists already and is not overwritten"):
        Recorder(bench.process, recording)
    bench.close()
