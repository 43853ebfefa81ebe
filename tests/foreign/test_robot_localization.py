"""A robot's ekf.yaml, as Nav2's setup guide has it, beside that robot in the simulator."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from bringup.cli import parse
from bringup.lockstep import LockStep
from bringup.parameters.inputs import gather
from bringup.stack import SIM_GROUP
from tests.helpers.files import written

pytestmark = [pytest.mark.ros, pytest.mark.system]
WHEELS, GYRO = (6, 7, 11), (11,)


def _filter(world: str, odometry: str) -> dict[str, Any]:
    return {
        "two_d_mode": True,
        "world_frame": world,
        "base_link_frame": "base_footprint",
        "odom0": odometry,
        "odom0_config": [k in WHEELS for k in range(15)],
        "imu0": "imu",
        "imu0_config": [k in GYRO for k in range(15)],
    }


def driven(folder: Path, sections: dict[str, dict[str, Any]]) -> dict[str, list[Any]]:
    """Return what is published while a Burger drives ahead for two seconds."""
    text = json.dumps({name: {"ros__parameters": values} for name, values in sections.items()})
    words = ["--robot", str(shipped_file("urdf/burger.urdf")), "--params"]
    parameters = gather(parse(["sim", *words, str(written(folder, text, "ekf.yaml"))]))
    topics = ("odom", "wheel_odom", "odometry/filtered", "odometry/local", "odometry/global")
    got: dict[str, list[Any]] = {topic: [] for topic in (*topics, "tf")}
    with closing(LockStep(parameters, strict=True)) as robot:
        robot.start(SIM_GROUP)
        for topic in topics:
            robot.client.create_subscription(Odometry, topic, got[topic].append, qos.DEFAULT)
        robot.client.create_subscription(TFMessage, "/tf", got["tf"].append, qos.TF)
        commands = robot.client.create_publisher(Twist, "cmd_vel", qos.DEFAULT)
        robot.process.drain()
        for _ in range(100):
            message = Twist()
            message.linear.x = 0.2
            commands.publish(message)
            robot.step()
    return got


@pytest.mark.parametrize("topic", ["odom", "/odom", "wheel_odom"])
def test_a_filter_hears_the_wheels_by_the_robot_s_topic(topic: str, tmp_path: Path) -> None:
    got = driven(tmp_path, {"ekf_filter_node": _filter("odom", topic)})
    assert bool(got["odom"]) == (topic != "wheel_odom") != bool(got["wheel_odom"])
    assert got["odometry/filtered"][-1].pose.pose.position.x > 0.3
    moved = [tf for each in got["tf"] for tf in each.transforms if tf.header.frame_id == "odom"]
    assert len(moved) <= len(got["odometry/filtered"])  # the filter's alone


def test_one_in_odom_and_one_in_map_have_topics_of_their_own(tmp_path: Path) -> None:
    names = {"ekf_filter_node_odom": "odom", "ekf_filter_node_map": "map"}
    got = driven(tmp_path, {name: _filter(world, "odom") for name, world in names.items()})
    assert not got["odometry/filtered"]
    for topic, frame in (("odometry/local", "odom"), ("odometry/global", "map")):
        assert {message.header.frame_id for message in got[topic]} == {frame}
        assert got[topic][-1].pose.pose.position.x > 0.3
