"""tf2_ros, tf2_geometry_msgs and tf_transformations, as scripts use them."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import rclpy
import tf2_geometry_msgs  # noqa: F401 - registers the types
import tf_transformations
from geometry_msgs.msg import PointStamped, PoseStamped, PoseWithCovarianceStamped
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from std_msgs.msg import String
from tf2_ros import (
    Buffer,
    BufferClient,
    BufferServer,
    ConnectivityException,
    ExtrapolationException,
    LookupException,
    StaticTransformBroadcaster,
    TimeoutException,
    TransformBroadcaster,
    TransformException,
    TransformListener,
    TypeException,
)

from tests.helpers.processes import wait_until
from tests.nodes.ros_packages.test_buffer_core import transform


class Bench:
    """Two nodes of a context of their own: one that broadcasts, one that listens."""

    def __init__(self, context: Context) -> None:
        self.talker = Node("talker", context=context)
        self.listener = Node("listener", context=context)
        self.executor = SingleThreadedExecutor(context=context)
        for node in (self.talker, self.listener):
            self.executor.add_node(node)
        self.buffer = Buffer(node=self.listener)
        TransformListener(self.buffer, self.listener)

    def spin_until_known(self, target: str, source: str) -> None:
        self.spin_until(lambda: self.buffer.can_transform(target, source, Time()))

    def spin_until(self, done: Callable[[], bool]) -> None:
        wait_until(done, lambda: self.executor.spin_once(timeout_sec=0.05), "a transform")


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    context = Context()
    rclpy.init(context=context)
    bench = Bench(context)
    yield bench
    for node in (bench.talker, bench.listener):
        node.destroy_node()
    context.shutdown()


def test_what_is_broadcast_is_looked_up(bench: Bench) -> None:
    StaticTransformBroadcaster(bench.talker).sendTransform(transform("base", "lidar", 0.0, 0.5))
    moving = TransformBroadcaster(bench.talker)
    moving.sendTransform([transform("odom", "base", 3.0, 1.0), transform("map", "odom", 3.0, 10.0)])
    bench.spin_until_known("map", "lidar")
    assert bench.buffer.lookup_transform("map", "lidar", Time()).transform.translation.x == 11.5


def test_static_transforms_of_several_calls_all_reach_who_comes_later(bench: Bench) -> None:
    broadcaster = StaticTransformBroadcaster(bench.talker)
    broadcaster.sendTransform(transform("base", "lidar", 0.0, 0.5))
    broadcaster.sendTransform(transform("base", "camera", 0.0, 0.2))
    broadcaster.sendTransform(transform("base", "lidar", 0.0, 0.7))
    late = Buffer(node=bench.listener)
    TransformListener(late, bench.listener)
    bench.spin_until(lambda: late.get_frame_names() == ["camera", "lidar"])

    def distance() -> float:
        return float(late.lookup_transform("base", "lidar", Time()).transform.translation.x)

    bench.spin_until(lambda: distance() == 0.7)


def test_a_future_is_done_when_the_transform_comes(bench: Bench) -> None:
    future = bench.buffer.wait_for_transform_async("odom", "base", Time())
    assert not future.done()
    TransformBroadcaster(bench.talker).sendTransform(transform("odom", "base", 1.0, 2.0))
    bench.spin_until_known("odom", "base")
    assert future.done()
    assert future.result().transform.translation.x == 2.0


def test_a_transform_between_two_times_is_waited_for_and_applied(bench: Bench) -> None:
    buffer, early, late = bench.buffer, Time(seconds=1), Time(seconds=2)
    future = buffer.wait_for_transform_full_async("base", late, "base", early, fixed_frame="odom")
    buffer.set_transform(transform("odom", "base", 1.0, 0.5), "test")
    assert not future.done()
    buffer.set_transform(transform("odom", "base", 2.0, 2.0), "test")
    assert future.result().transform.translation.x == -1.5
    point = PointStamped()
    point.header.frame_id, point.header.stamp = "base", early.to_msg()
    point.point.x = 2.0
    assert buffer.transform_full(point, "base", late, "odom").point.x == 0.5
    with pytest.raises(ExtrapolationException, match="into the future"):
        buffer.transform_full(point, "base", Time(seconds=3), "odom")


def test_messages_are_transformed(bench: Bench) -> None:
    buffer = bench.buffer
    buffer.set_transform_static(transform("map", "base", 0.0, 1.0, math.pi / 2.0), "test")
    point = PointStamped()
    point.header.frame_id = "base"
    point.point.x = 2.0
    moved = buffer.transform(point, "map")
    assert (moved.point.x, moved.point.y) == pytest.approx((1.0, 2.0))
    point.header.stamp = Time()  # rclpy's own, which tf2 takes as well
    assert buffer.transform(point, "map").point.x == pytest.approx(1.0)
    pose = PoseStamped()
    pose.header.frame_id = "base"
    pose.pose.orientation.w = 1.0
    turned = buffer.transform(pose, "map").pose.orientation
    assert (turned.z, turned.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    sure = PoseWithCovarianceStamped()
    sure.header.frame_id = "base"
    sure.pose.pose.orientation.w = 1.0
    sure.pose.covariance[0] = 4.0  # along x becomes along y
    covariance = np.array(buffer.transform(sure, "map").pose.covariance).reshape(6, 6)
    assert (covariance[0, 0], covariance[1, 1]) == pytest.approx((0.0, 4.0))


def test_what_cannot_be_transformed_says_why(bench: Bench) -> None:
    with pytest.raises(TypeException, match="is not loaded or supported"):
        bench.buffer.transform(String(), "map")
    with pytest.raises(LookupException, match='"map" passed to lookupTransform'):
        bench.buffer.lookup_transform("map", "base", Time())
    assert issubclass(LookupException, TransformException)


@pytest.mark.parametrize("axes", ["sxyz", "rzyx", "szyx", "sxzy"])
def test_angles_come_back_from_quaternions(axes: str) -> None:
    quaternion = tf_transformations.quaternion_from_euler(0.1, -0.2, 0.3, axes)
    angles = tf_transformations.euler_from_quaternion(quaternion, axes)
    assert angles == pytest.approx((0.1, -0.2, 0.3))


def test_quaternions_are_x_y_z_w_and_multiply_as_rotations_do() -> None:
    quarter = tf_transformations.quaternion_from_euler(0.0, 0.0, math.pi / 2.0)
    assert quarter == pytest.approx([0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)])
    half = tf_transformations.quaternion_multiply(quarter, quarter)
    assert tf_transformations.euler_from_quaternion(half)[2] == pytest.approx(math.pi)
    back = tf_transformations.quaternion_multiply(
        quarter, tf_transformations.quaternion_inverse(quarter)
    )
    assert back == pytest.approx([0.0, 0.0, 0.0, 1.0])


def test_a_rotation_about_a_point_leaves_it_where_it_is() -> None:
    matrix = tf_transformations.rotation_matrix(1.0, (0, 0, 1), (2.0, 3.0, 0.0))
    assert matrix @ (2.0, 3.0, 0.0, 1.0) == pytest.approx([2.0, 3.0, 0.0, 1.0])


@pytest.mark.parametrize("scale", [(1.0, 2.0, 0.5), (1.0, 1.0, 1.0), (-2.0, -1.0, -3.0)])
def test_a_matrix_is_made_of_its_parts_and_taken_apart(scale: tuple[float, ...]) -> None:
    parts: list[tuple[float, ...]]
    parts = [scale, (0.1, 0.2, 0.3), (0.4, -0.5, 0.6), (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)]
    found = tf_transformations.decompose_matrix(tf_transformations.compose_matrix(*parts))
    for value, part in zip(found, parts, strict=True):
        assert np.asarray(value) == pytest.approx(np.asarray(part), abs=1e-9)
    pose = tf_transformations.compose_matrix(translate=[0.5, 0, 0], angles=[0, 0, math.pi / 2])
    assert pose @ (1.0, 0.0, 0.0, 1.0) == pytest.approx([0.5, 1.0, 0.0, 1.0])
    with pytest.raises(ValueError, match="matrix is singular"):
        tf_transformations.decompose_matrix(tf_transformations.scale_matrix(0.0))


def test_a_quaternion_without_length_turns_by_nothing() -> None:
    assert tf_transformations.euler_from_quaternion((0, 0, 0, 0)) == (0.0, 0.0, 0.0)
    assert tf_transformations.quaternion_matrix((0, 0, 0, 0)) == pytest.approx(np.identity(4))
    assert tf_transformations.quaternion_real((1, 2, 3, 4)) == 4.0
    assert tf_transformations.quaternion_imag((1, 2, 3, 4)) == pytest.approx([1, 2, 3])


def test_random_rotations_and_vectors_are_drawn() -> None:
    turned = tf_transformations.random_rotation_matrix((0.5, 0.0, 0.0))[:3, :3]
    assert turned @ turned.T == pytest.approx(np.identity(3))
    assert all(0.0 <= each <= 1.0 for each in tf_transformations.random_vector(4))
    assert tf_transformations.scale_matrix(2.0, (1.0, 0.0, 0.0)) @ (1.0, 0.0, 0.0, 1.0) == (
        pytest.approx([1.0, 0.0, 0.0, 1.0])
    )


def test_invalid_axes_are_refused() -> None:
    with pytest.raises(ValueError, match="no axes: 'xyz'; valid"):
        tf_transformations.quaternion_from_euler(0.0, 0.0, 0.0, "xyz")


@pytest.fixture
def asked(bench: Bench) -> Iterator[tuple[BufferClient, Buffer]]:
    """A client, and the buffer that answers it; both are spun by another thread."""
    buffer = Buffer(node=bench.talker)
    server = BufferServer(buffer, bench.talker, "tf2_buffer_server")
    client = BufferClient(bench.listener, "tf2_buffer_server", timeout_padding=Duration(seconds=5))
    thread = threading.Thread(target=bench.executor.spin, daemon=True)
    thread.start()
    assert client.wait_for_server(Duration(seconds=10.0))
    yield client, buffer
    bench.executor.shutdown()
    thread.join(5.0)
    server.destroy()


def test_a_buffer_elsewhere_answers_once_it_knows(asked: tuple[BufferClient, Buffer]) -> None:
    client, buffer = asked
    buffer.set_transform_static(transform("base", "lidar", 0.0, 0.5), "test")
    assert client.lookup_transform("base", "lidar", Time()).transform.translation.x == 0.5
    point = PointStamped()
    point.header.frame_id = "lidar"
    assert client.transform(point, "base").point.x == 0.5
    point.header.stamp = Time()
    assert client.transform(point, "base").point.x == 0.5
    later = threading.Timer(
        0.2, buffer.set_transform, (transform("map", "base", 3.0, 10.0), "test")
    )
    later.start()
    stamp = Time(seconds=3)
    assert client.can_transform("map", "lidar", stamp, Duration(seconds=5.0))
    found = client.lookup_transform_full("map", stamp, "lidar", stamp, "map")
    assert found.transform.translation.x == 10.5
    later.join()


def test_a_buffer_elsewhere_says_why_not(asked: tuple[BufferClient, Buffer]) -> None:
    client, buffer = asked
    with pytest.raises(LookupException, match="does not exist"):
        client.lookup_transform("map", "nowhere", Time())
    for child in ("a", "b"):
        buffer.set_transform_static(transform(f"over_{child}", child, 0.0, 1.0), "test")
    with pytest.raises(ConnectivityException, match=r"a|b"):
        client.lookup_transform("a", "b", Time())
    assert not client.can_transform("map", "nowhere", Time())


def test_without_a_buffer_elsewhere_a_question_times_out(bench: Bench) -> None:
    client = BufferClient(bench.listener, "nobody", timeout_padding=Duration(seconds=0.1))
    with pytest.raises(TimeoutException, match="no answer from nobody within"):
        client.lookup_transform("map", "base", Time())


@pytest.mark.parametrize("last", ["rclpy.shutdown()", "node.destroy_node()", ""])
def test_a_program_whose_listener_has_a_thread_ends_well(last: str) -> None:
    """Whatever it does last: the thread ended with a traceback, or all of it with an abort."""
    program = (
        "import rclpy, tf2_ros\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('listening')\n"
        "buffer = tf2_ros.Buffer()\n"
        "listener = tf2_ros.TransformListener(buffer, node, spin_thread=True)\n"
        "buffer.can_transform('a', 'b', rclpy.time.Time(), rclpy.duration.Duration(seconds=0.3))\n"
        f"{last}\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
