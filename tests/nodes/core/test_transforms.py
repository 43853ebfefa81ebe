"""The transform buffer: composition, interpolation, refusal to extrapolate, jumps."""

from __future__ import annotations

import math

import pytest
from rclpy.node import Node
from tf2_msgs.msg import TFMessage

from arjuna_core.ros.context import new_context
from arjuna_core.ros.convert import transform_msg
from arjuna_core.ros.tf import TransformBuffer, TransformError, TransformListener
from arjuna_core.se2 import SE2


@pytest.fixture
def buffer() -> TransformBuffer:
    buffer = TransformBuffer()
    buffer.insert("base", "lidar", 0.0, SE2(0.1, 0.0, math.pi / 2), static=True)
    for stamp, x in ((1.0, 0.0), (2.0, 1.0), (3.0, 3.0)):
        buffer.insert("odom", "base", stamp, SE2(x, 0.0, 0.0))
        buffer.insert("map", "odom", stamp, SE2(0.0, 5.0, 0.0))
    return buffer


def close(a: SE2, b: SE2) -> bool:
    return a.distance(b) < 1e-12 and abs(a.theta - b.theta) < 1e-12


def test_composes_up_and_down_the_tree(buffer: TransformBuffer) -> None:
    T_map_lidar = buffer.lookup("map", "lidar", 2.0)
    assert close(T_map_lidar, SE2(1.1, 5.0, math.pi / 2))
    assert close(buffer.lookup("lidar", "map", 2.0), T_map_lidar.inverse())


def test_interpolates_between_stamps(buffer: TransformBuffer) -> None:
    assert close(buffer.lookup("odom", "base", 2.25), SE2(1.5, 0.0, 0.0))


def test_interpolates_the_shorter_turn() -> None:
    buffer = TransformBuffer()
    buffer.insert("a", "b", 0.0, SE2(0.0, 0.0, 3.0))
    buffer.insert("a", "b", 1.0, SE2(0.0, 0.0, -3.0))
    middle = buffer.lookup("a", "b", 0.5).theta
    assert abs(abs(middle) - math.pi) < 1e-12


@pytest.mark.parametrize(("stamp", "side"), [(0.5, "oldest"), (3.2, "newest")])
def test_refuses_to_extrapolate_and_says_by_how_much(
    buffer: TransformBuffer, stamp: float, side: str
) -> None:
    with pytest.raises(TransformError, match=rf"{side} is at .* s off"):
        buffer.lookup("odom", "base", stamp)
    assert buffer.try_lookup("odom", "base", stamp) is None


def test_latest_is_the_newest_common_time(buffer: TransformBuffer) -> None:
    buffer.insert("map", "odom", 4.0, SE2(0.0, 7.0, 0.0))
    assert close(buffer.lookup("map", "base"), SE2(3.0, 5.0, 0.0))


def test_names_the_frames_it_knows(buffer: TransformBuffer) -> None:
    with pytest.raises(TransformError, match="known frames: base, lidar, map, odom"):
        buffer.lookup("map", "camera")


def test_a_jump_back_clears_all_but_static(buffer: TransformBuffer) -> None:
    buffer.insert("odom", "base", 0.1, SE2(9.0, 0.0, 0.0))
    assert close(buffer.lookup("odom", "base"), SE2(9.0, 0.0, 0.0))
    assert buffer.try_lookup("map", "odom") is None
    assert close(buffer.lookup("base", "lidar"), SE2(0.1, 0.0, math.pi / 2))


def test_refuses_a_loop() -> None:
    buffer = TransformBuffer()
    buffer.insert("a", "b", 0.0, SE2())
    buffer.insert("b", "a", 0.0, SE2())
    with pytest.raises(TransformError, match="frames form a loop"):
        buffer.lookup("a", "c")


def test_forgets_what_is_older_than_its_span() -> None:
    buffer = TransformBuffer()
    for tick in range(5000):
        buffer.insert("a", "b", tick * 0.02, SE2(tick, 0.0, 0.0))
    assert buffer.try_lookup("a", "b", 1.0) is None
    assert buffer.try_lookup("a", "b", 75.0) is not None


def test_a_client_s_plain_node_listens_and_refuses_too() -> None:
    context = new_context()
    node = Node("plain", context=context)
    buffer = TransformBuffer()
    listener = TransformListener(node, buffer)
    good, bad = (transform_msg(SE2(), "odom", child, 0.0) for child in ("base", "arm"))
    bad.transform.translation.x = math.nan
    listener._on_moving(TFMessage(transforms=[bad, good]))
    node.destroy_node()
    context.shutdown()
    assert buffer.try_lookup("odom", "base") is not None
    assert buffer.try_lookup("odom", "arm") is None
