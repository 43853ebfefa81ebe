"""base_footprint_publisher: the robot's pose in space, on the ground."""

from __future__ import annotations

import pytest
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, transform_msg
from arjuna_core.se2 import SE2
from bringup.stack import further_nodes
from tests.helpers.ros import RosBench


@pytest.mark.parametrize(
    ("values", "frames"),
    [
        ({}, ("base_link", "base_footprint")),
        ({"base_link_frame": "imu", "base_footprint_frame": "ground"}, ("imu", "ground")),
    ],
)
def test_height_roll_and_pitch_are_taken_off(
    values: dict[str, str], frames: tuple[str, str]
) -> None:
    bench = RosBench()
    (spec,) = further_nodes({"base_footprint_publisher": {}})
    node = spec.make(bench.process, values)
    node.trigger_configure()
    node.trigger_activate()
    bench.advance(0.1)
    seen = bench.collect(TFMessage, "/tf")
    tilted = transform_msg(SE2(1.0, 2.0, 0.7), "odom", frames[0], 0.06)
    tilted.transform.translation.z = 0.4
    tilted.transform.rotation.x += 0.1
    other = transform_msg(SE2(), "odom", "wheel", 0.06)
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[other, tilted]), qos.TF)
    (level,) = [each for m in seen for each in m.transforms if each.child_frame_id == frames[1]]
    assert level.header.frame_id == "odom"
    assert seconds(level.header.stamp) == pytest.approx(0.06)
    moved, turn = level.transform.translation, level.transform.rotation
    assert (moved.x, moved.y, moved.z, turn.x, turn.y) == (1.0, 2.0, 0.0, 0.0, 0.0)
    bench.close()
