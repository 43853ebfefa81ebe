"""ekf_node, ukf_node: topics, frames and services of robot_localization's filters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    Twist,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from robot_localization.srv import GetState, SetPose, ToggleFilterProcessing
from sensor_msgs.msg import Imu
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, pose3_msg, seconds, transform3_msg
from arjuna_sim.nodes.localization.filter_node import EkfFilterNode, UkfFilterNode
from tests.helpers.ros import TICK, RosBench
from tests.nodes.sim.running import start


def _mask(*states: int) -> list[bool]:
    return [i in states for i in range(15)]


PLANAR: dict[str, Any] = {
    "two_d_mode": True,
    "frequency": 50.0,
    "odom0": "wheels",
    "odom0_config": _mask(6, 7),
    "imu0": "imu",
    "imu0_config": _mask(11),
}


def _odometry(now: float, v: float, w: float = 0.0, pose: Pose3 | None = None) -> Odometry:
    message = Odometry(header=header("odom", now), child_frame_id="base_link")
    message.twist.twist.linear.x, message.twist.twist.angular.z = v, w
    message.pose.pose = pose3_msg(pose or Pose3())
    message.pose.covariance = (np.eye(6) * 1e-4).ravel()
    message.twist.covariance = (np.eye(6) * 1e-4).ravel()
    return message


def _imu(now: float, rate: float) -> Imu:
    message = Imu(header=header("base_link", now))
    message.angular_velocity.z = rate
    message.angular_velocity_covariance = (np.eye(3) * 1e-6).ravel()
    return message


def _drive(bench: RosBench, ticks: int, v: float = 0.5, w: float = 0.6) -> None:
    for _ in range(ticks):
        bench.advance(TICK)
        now = bench.process.now
        bench.publish(Odometry, "wheels", _odometry(now, v, -w))
        bench.publish(Imu, "imu", _imu(now, w))
    bench.advance(TICK)


@pytest.mark.parametrize("cls", [EkfFilterNode, UkfFilterNode])
def test_the_masks_choose_what_counts_and_both_outputs_agree(bench: RosBench, cls: Any) -> None:
    start(bench, cls(bench.process, PLANAR))
    odometry = bench.collect(Odometry, "odometry/filtered")
    transforms = bench.collect(TFMessage, "/tf")
    _drive(bench, 100)
    last, tf = odometry[-1], transforms[-1].transforms[0]
    assert len(odometry) >= 95
    assert seconds(last.header.stamp) == seconds(tf.header.stamp) == pytest.approx(2.0)
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
    assert (tf.header.frame_id, tf.child_frame_id) == ("odom", "base_link")
    # the wheels' turn rate, of the wrong sign, has no place in the mask
    assert last.twist.twist.angular.z == pytest.approx(0.6, abs=0.01)
    pose = last.pose.pose
    assert 2.0 * math.atan2(pose.orientation.z, pose.orientation.w) == pytest.approx(1.2, abs=0.03)
    assert pose.position.x == pytest.approx(tf.transform.translation.x)
    assert pose.position.x == pytest.approx(0.5 / 0.6 * math.sin(1.2), abs=0.03)
    assert pose.position.z == pytest.approx(0.0, abs=1e-6)


def test_a_filter_of_the_map_publishes_map_to_odom(bench: RosBench) -> None:
    values = {"world_frame": "map", "pose0": "gps", "pose0_config": _mask(0, 1, 5)}
    start(bench, EkfFilterNode(bench.process, values, name="ekf_filter_node_map"))
    transforms = bench.collect(TFMessage, "/tf")
    odometry = bench.collect(Odometry, "odometry/filtered")
    bench.advance(TICK)
    T_odom_base = transform3_msg(Pose3((1.0, 0.0, 0.0)), "odom", "base_link", TICK)
    bench.publish(TFMessage, "/tf", TFMessage(transforms=[T_odom_base]), qos.TF)
    message = PoseWithCovarianceStamped(header=header("map", TICK))
    message.pose.pose = pose3_msg(Pose3((3.0, 2.0, 0.0)))
    bench.publish(PoseWithCovarianceStamped, "gps", message)
    bench.advance(0.1)
    ours = [t for m in transforms for t in m.transforms if t.header.frame_id == "map"]
    assert ours[-1].child_frame_id == "odom"
    T = ours[-1].transform.translation
    assert (T.x, T.y) == pytest.approx((2.0, 2.0))
    assert odometry[-1].header.frame_id == "map"


def test_a_frame_that_has_a_parent_is_carried_by_it(bench: RosBench) -> None:
    mount = transform3_msg(Pose3((0.2, 0.0, 0.1)), "base_footprint", "base_link", 0.0)
    bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)
    start(bench, EkfFilterNode(bench.process, PLANAR))
    odometry = bench.collect(Odometry, "odometry/filtered")
    transforms = bench.collect(TFMessage, "/tf")
    _drive(bench, 20)
    tf, pose = transforms[-1].transforms[0], odometry[-1].pose.pose
    assert (tf.header.frame_id, tf.child_frame_id) == ("odom", "base_footprint")
    p, q = pose.position, pose.orientation
    T_odom_base = Pose3((p.x, p.y, p.z), (q.w, q.x, q.y, q.z))
    at = (T_odom_base @ Pose3((-0.2, 0.0, -0.1))).position
    T = tf.transform.translation
    assert (T.x, T.y, T.z) == pytest.approx(at)
    assert bench.process.transforms.knows("base_link")


def test_a_silent_sensor_is_named_once(bench: RosBench, capfd: pytest.CaptureFixture[str]) -> None:
    bench.publish(Imu, "imu/data", _imu(0.0, 0.0))
    start(bench, EkfFilterNode(bench.process, PLANAR))
    bench.advance(10.0)
    text = capfd.readouterr().err
    line = "no imu message comes on '/imu': nobody publishes it; imu messages are on /imu/data"
    assert text.count(f"{line}: set imu0") == 1
    assert text.count("no odom message comes on '/wheels'") == 1


def test_what_comes_in_a_frame_that_is_not_there_is_passed_over(bench: RosBench) -> None:
    values = {"twist0": "twist", "twist0_config": _mask(6)}
    start(bench, EkfFilterNode(bench.process, values))
    odometry = bench.collect(Odometry, "odometry/filtered")

    def say() -> None:
        bench.advance(0.1)
        message = TwistWithCovarianceStamped(header=header("wheel", bench.process.now))
        message.twist.twist.linear.x = 1.0
        bench.publish(TwistWithCovarianceStamped, "twist", message)
        bench.advance(0.1)

    say()
    assert not odometry
    mount = transform3_msg(Pose3.from_rpy((0, 0, 0), (0, 0, math.pi)), "base_link", "wheel", 0.0)
    bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[mount]), qos.TF_STATIC)
    say()
    assert odometry[-1].twist.twist.linear.x == pytest.approx(-1.0)


def test_gravity_is_taken_out_and_accelerations_are_published(bench: RosBench) -> None:
    values = {
        "publish_acceleration": True,
        "publish_tf": False,
        "imu0": "imu",
        "imu0_config": _mask(4, 12, 14),
        "imu0_remove_gravitational_acceleration": True,
    }
    start(bench, EkfFilterNode(bench.process, values))
    found = bench.collect(AccelWithCovarianceStamped, "accel/filtered")
    transforms = bench.collect(TFMessage, "/tf")
    tilted = Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, 0.2, 0.0))
    for _ in range(20):
        bench.advance(TICK)
        message = Imu(header=header("base_link", bench.process.now))
        message.orientation = pose3_msg(tilted).orientation
        felt = tilted.rotation().T @ np.array((0.0, 0.0, 9.80665))
        message.linear_acceleration.x = felt[0] + 0.3
        message.linear_acceleration.z = felt[2]
        bench.publish(Imu, "imu", message)
    bench.advance(0.1)
    linear = found[-1].accel.accel.linear
    assert (linear.x, linear.z) == pytest.approx((0.3, 0.0), abs=1e-3)
    assert not transforms


@pytest.mark.parametrize("threshold", [0.0, 3.0])
def test_an_outlier_is_rejected_beyond_its_threshold(bench: RosBench, threshold: float) -> None:
    values = PLANAR | {"odom0_twist_rejection_threshold": threshold}
    start(bench, EkfFilterNode(bench.process, values))
    odometry = bench.collect(Odometry, "odometry/filtered")
    _drive(bench, 50)
    bench.publish(Odometry, "wheels", _odometry(bench.process.now, 5.0))
    bench.advance(TICK)
    jumped = abs(odometry[-1].twist.twist.linear.x - 0.5) > 0.5
    assert jumped == (threshold == 0.0)


def test_pose_reset_toggle_and_enable(bench: RosBench) -> None:
    start(bench, EkfFilterNode(bench.process, PLANAR | {"disabled_at_startup": True}))
    odometry = bench.collect(Odometry, "odometry/filtered")
    _drive(bench, 10)
    assert not odometry
    bench.call(Empty, "/enable", Empty.Request())
    _drive(bench, 10)
    assert odometry
    request = SetPose.Request()
    request.pose.header = header("odom", bench.process.now)
    request.pose.pose.pose = pose3_msg(Pose3((7.0, 8.0, 0.0)))
    bench.call(SetPose, "/set_pose", request)
    _drive(bench, 2, 0.0, 0.0)
    assert odometry[-1].pose.pose.position.x == pytest.approx(7.0, abs=0.01)
    off = ToggleFilterProcessing.Request(on=False)
    assert bench.call(ToggleFilterProcessing, "/toggle", off).status
    assert not bench.call(ToggleFilterProcessing, "/toggle", off).status
    count = len(odometry)
    _drive(bench, 5)
    assert len(odometry) == count
    on = ToggleFilterProcessing.Request(on=True)
    assert bench.call(ToggleFilterProcessing, "/toggle", on).status
    _drive(bench, 5, 0.0, 0.0)
    assert odometry[-1].pose.pose.position.x == pytest.approx(0.0, abs=0.05)
    bench.call(Empty, "/reset", Empty.Request())
    count = len(odometry)
    bench.advance(0.1)
    assert len(odometry) == count


def test_state_is_had_at_a_time(bench: RosBench) -> None:
    start(bench, EkfFilterNode(bench.process, PLANAR))
    odometry = bench.collect(Odometry, "odometry/filtered")
    _drive(bench, 10)
    message = odometry[-1]
    speed, at = message.twist.twist.linear.x, seconds(message.header.stamp)
    request = GetState.Request(time_stamp=header("", at + 2.0).stamp)
    later = bench.call(GetState, "/get_state", request)
    now = bench.call(GetState, "/get_state", GetState.Request(frame_id="base_link"))
    assert now.state[0] == pytest.approx(message.pose.pose.position.x)
    assert now.state[6] == pytest.approx(speed)
    assert speed > 0.1
    moved = math.hypot(later.state[0] - now.state[0], later.state[1] - now.state[1])
    assert moved == pytest.approx(2.0 * speed, rel=0.2)
    assert later.covariance[0] > now.covariance[0]
    lost = bench.call(GetState, "/get_state", GetState.Request(frame_id="lost"))
    assert not lost.covariance.any()


def test_commands_predict_where_nothing_measures(bench: RosBench) -> None:
    values = PLANAR | {
        "use_control": True,
        "control_timeout": 10.0,
        "control_config": [True, False, False, False, False, True],
        "acceleration_limits": [0.5] * 6,
    }
    start(bench, EkfFilterNode(bench.process, values))
    odometry = bench.collect(Odometry, "odometry/filtered")
    _drive(bench, 5, 0.0, 0.0)
    command = Twist()
    command.linear.x = 0.4
    bench.publish(Twist, "cmd_vel", command)
    bench.advance(0.4)
    assert odometry[-1].twist.twist.linear.x == pytest.approx(0.15, abs=0.06)


def test_a_sensor_without_a_mask_and_a_bad_world_are_named(bench: RosBench) -> None:
    with pytest.raises(ConfigError, match=r"'odom0_config' has 3 values; valid: 15"):
        EkfFilterNode(bench.process, {"odom0_config": [True] * 3})
    with pytest.raises(ConfigError, match=r"'world_frame' is 'earth'; valid: map_frame 'map'"):
        EkfFilterNode(bench.process, {"world_frame": "earth"})
    node = EkfFilterNode(bench.process, {"odom0": "wheels"})
    assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
    assert not [s for s in node.subscriptions if s.topic_name == "/wheels"]
