"""Recordings: what arrives is written byte for byte, with what rosbag2 needs to play it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

import yaml
from ament_index_python.packages import get_package_share_directory
from geometry_msgs.msg import Twist
from mcap.reader import make_reader
from nav_msgs.msg import OccupancyGrid
from rclpy.serialization import deserialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from arjuna_core.ros import qos
from arjuna_core.ros.ament import add_environment_to_ament_index
from bringup.recording.recorder import TOPICS, Recorder, RecordingError
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
    assert channel.metadata["topic_type_hash"].startswith("RIHS01_8d348150c12913a31ee0")
    assert (schema.name, schema.encoding) == ("nav_msgs/msg/OccupancyGrid", "ros2msg")


@pytest.mark.parametrize("kind", sorted({kind for kind, _ in TOPICS.values()}))
def test_definitions_and_hashes_are_those_of_the_installed_packages(kind: str) -> None:
    add_environment_to_ament_index()
    package, name = kind.split("/msg/")
    share = Path(get_package_share_directory(package)) / "msg"
    types = get_typestore(Stores.ROS2_JAZZY)
    fields = get_types_from_msg((share / f"{name}.msg").read_text(), kind)
    assert fields[kind] == types.fielddefs[kind]
    described = json.loads((share / f"{name}.json").read_text())["type_hashes"]
    (found,) = (entry["hash_string"] for entry in described if entry["type_name"] == kind)
    assert types.hash_rihs01(kind) == found


def test_an_existing_recording_is_never_overwritten(recording: Path) -> None:
    bench = RosBench()
    with pytest.raises(RecordingError, match="exists already and is not overwritten"):
        Recorder(bench.process, recording)
    bench.close()
