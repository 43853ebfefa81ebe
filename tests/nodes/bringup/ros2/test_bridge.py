"""A ros_gz_bridge's arguments and file give topics of the simulator other names."""

from __future__ import annotations

from pathlib import Path

import pytest
from std_msgs.msg import String

from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.bridge import Bridged, Relay, bridged
from tests.helpers.ros import RosBench

STRING = "std_msgs/msg/String"
CONFIG = f"""
- ros_topic_name: "/front/scan"
  gz_topic_name: "scan"
  ros_type_name: "{STRING}"
  gz_type_name: "gz.msgs.LaserScan"
  direction: GZ_TO_ROS
- topic_name: "chatter"
  ros_type_name: "{STRING}"
  gz_type_name: "gz.msgs.StringMsg"
"""


def test_arguments_and_remappings_are_read() -> None:
    words = [f"/scan@{STRING}[gz.msgs.LaserScan", f"/cmd_vel@{STRING}]gz.msgs.Twist"]
    words += ["--ros-args", "-r", "/scan:=/front/scan"]
    assert list(bridged(words)) == [
        Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"),
        Bridged("/cmd_vel", "/cmd_vel", STRING, "ROS_TO_GZ"),
    ]
    with pytest.raises(Ros2Error, match="'/scan' is no topic"):
        list(bridged(["/scan"]))


def test_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "bridge.yaml"
    path.write_text(CONFIG)
    words = ["--ros-args", "-p", f"config_file:={path}"]
    assert list(bridged(words)) == [
        Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"),
        Bridged("/chatter", "/chatter", STRING, "BIDIRECTIONAL"),
    ]
    path.write_text("- ros_topic_name: a\n")
    with pytest.raises(Ros2Error, match="needs ros_topic_name, gz_topic_name"):
        list(bridged(words))


def test_messages_come_under_the_other_name_while_somebody_listens(bench: RosBench) -> None:
    relay = Relay(bench.node, Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"), raw=False)
    relay.look()
    bench.publish(String, "/scan", String(data="early"))
    assert bench.node.count_subscribers("/scan") == 0
    heard = bench.collect(String, "/front/scan")
    relay.look()
    bench.publish(String, "/scan", String(data="now"))
    assert [message.data for message in heard] == ["now"]


def test_commands_go_the_other_way(bench: RosBench) -> None:
    taken = bench.collect(String, "/model/cmd_vel")
    topic = Bridged("/model/cmd_vel", "/cmd_vel", STRING, "BIDIRECTIONAL")
    relay = Relay(bench.node, topic, raw=False)
    relay.look()
    bench.publish(String, "/cmd_vel", String(data="go"))
    assert [message.data for message in taken] == ["go"]
