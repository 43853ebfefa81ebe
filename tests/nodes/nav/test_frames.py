"""The robot's pose: an error of a transform comes with its remedy."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from tf2_msgs.msg import TFMessage

from arjuna_core.ros import qos
from arjuna_core.ros.convert import pose_stamped, seconds, transform_msg
from arjuna_core.se2 import SE2
from arjuna_core.transforms import TransformBuffer, TransformError
from arjuna_nav.nodes.frames import pose_in, robot_pose
from bringup.stack import further_nodes
from tests.helpers.ros import RosBench


def _node(now: float, *edges: tuple[str, str]) -> Any:
    """Return what `robot_pose` needs of a node, with transforms of 10 s."""
    tree = TransformBuffer()
    for parent, child in edges:
        tree.insert(parent, child, 10.0, SE2(1.0, 0.0))
    return SimpleNamespace(transforms=tree, now=now)


CHAIN = (("map", "odom"), ("odom", "robot_footprint"))


@pytest.mark.parametrize(
    ("now", "edges", "base", "said"),
    [
        (10.1, CHAIN, "base_link", "'map' carries 'robot_footprint'; set robot_base_frame: robot_"),
        (10.1, CHAIN[1:], "base_link", "'odom' carries 'robot_footprint'; set robot_base_frame"),
        (10.1, (), "base_link", "is odometry's transform on /tf"),
        (10.1, CHAIN[1:], "robot_footprint", "no transform connects 'map' and 'robot_footprint'"),
        (12.0, CHAIN, "robot_footprint", "2.00 s old, over the tolerance of 0.3 s"),
        (1.8e9, CHAIN, "robot_footprint", "start this node with use_sim_time:=true"),
    ],
)
def test_a_pose_that_is_not_known_names_the_remedy(
    now: float, edges: tuple[tuple[str, str], ...], base: str, said: str
) -> None:
    with pytest.raises(TransformError, match=said):
        robot_pose(_node(now, *edges), "map", base, 0.3)


def test_a_pose_that_is_known_is_returned() -> None:
    assert robot_pose(_node(10.1, *CHAIN), "map", "robot_footprint", 0.3) == SE2(2.0, 0.0)


def test_a_pose_without_a_frame_is_refused() -> None:
    with pytest.raises(TransformError, match=r"frame_id is empty; valid: 'map'"):
        pose_in(_node(10.0), "map", pose_stamped(SE2(1.0, 0.0), "", 10.0))


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
