"""ekf_filter_node: odometry of wheels and gyro, whichever of them come."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.files.shipped import shipped_file
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header, se2_from_pose, seconds, transform3_msg
from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.ekf import EkfNode
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import TICK, RosBench
from tests.nodes.sim.running import run, start, start_sim
from tests.sim.builders import edited
from tests.sim.drive_cases import Robot, mecanum, planar


def _wheels(now: float, v: float, w: float) -> Odometry:
    message = Odometry(header=header("odom", now), child_frame_id="base_footprint")
    message.twist.twist.linear.x, message.twist.twist.angular.z = v, w
    return message


def _imu(now: float, rate: float) -> Imu:
    message = Imu(header=header("imu_link", now))
    message.angular_velocity.z = rate
    return message


def test_gyro_overrules_wheels_and_both_outputs_agree(bench: RosBench) -> None:
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    transforms = bench.collect(TFMessage, "/tf")
    for i in range(1, 151):
        moving = i > 50
        bench.publish(Odometry, "wheel_odom", _wheels(i * TICK, 0.5 * moving, 1.0 * moving))
        bench.publish(Imu, "imu/data", _imu(i * TICK, 0.6 * moving))
    assert len(odometry) == len(transforms) == 150
    last, tf = odometry[-1], transforms[-1].transforms[0]
    assert seconds(last.header.stamp) == seconds(tf.header.stamp) == pytest.approx(3.0)
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_footprint")
    assert (tf.header.frame_id, tf.child_frame_id) == ("odom", "base_footprint")
    pose = se2_from_pose(last.pose.pose)
    assert pose.theta == pytest.approx(1.2, abs=0.03)
    assert tf.transform.translation.x == pytest.approx(pose.x)
    assert last.twist.twist.angular.z == pytest.approx(0.6, abs=0.01)
    assert last.pose.covariance[35] > 0.0


@pytest.mark.parametrize("knows", [True, False])
@pytest.mark.parametrize("rpy", [(math.pi, 0.0, 0.3), (0.0, 0.5, -1.0), (-math.pi / 2, 0.4, 0.0)])
def test_imu_may_sit_askew_or_upside_down(
    bench: RosBench, rpy: tuple[float, float, float], knows: bool
) -> None:
    """One that knows no orientation is taken as it is mounted."""
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    mount = Pose3.from_rpy((0.1, 0.0, 0.2), rpy)
    if not knows:
        fixed = transform3_msg(mount, "base_footprint", "imu_link", 0.0)
        bench.publish(TFMessage, "/tf_static", TFMessage(transforms=[fixed]), qos.TF_STATIC)
    rates = mount.rotation().T @ (0.0, 0.0, 0.6)
    for i in range(1, 101):
        message = Imu(header=header("imu_link", i * TICK))
        turn, q = message.angular_velocity, message.orientation
        turn.x, turn.y, turn.z = rates.tolist()
        if knows:
            q.w, q.x, q.y, q.z = mount.quaternion
        else:
            message.orientation_covariance[0] = -1.0
        bench.publish(Odometry, "wheel_odom", _wheels(i * TICK, 0.5, 1.0))
        bench.publish(Imu, "imu/data", message)
    assert odometry[-1].twist.twist.angular.z == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("moved", [mecanum(), planar("<publish_odom_tf>false</publish_odom_tf>")])
def test_a_base_that_moves_sideways_has_fused_odometry(
    bench: RosBench, tmp_path: Path, moved: Robot
) -> None:
    """A planar_move too, whose file leaves the frame to a filter, as linorobot2's does."""
    sensor = "<sensor name='imu' type='imu'><update_rate>50</update_rate></sensor>"
    imu = f"<gazebo reference='base'>{sensor}</gazebo>"
    robot = replace(moved, extra=moved.extra + imu).write(tmp_path)
    sim = start_sim(bench, fused_odometry=True, robot=str(robot))
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    command = Twist()
    command.linear.y = 0.2
    for _ in range(50):
        bench.publish(Twist, sim.simulator.robots[SOLO].model.drive.command_topic, command)
        run(bench, sim, 1)
    last = odometry[-1]
    assert last.twist.twist.linear.y == pytest.approx(0.2, abs=0.02)
    assert se2_from_pose(last.pose.pose).y == pytest.approx(
        sim.simulator.robots[SOLO].truth().pose.y, rel=0.05
    )


def test_wheels_alone_make_odometry_a_message_late(bench: RosBench) -> None:
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    for i in range(1, 51):
        bench.publish(Odometry, "wheel_odom", _wheels(i * TICK, 0.5, 0.0))
    assert len(odometry) == 49
    assert se2_from_pose(odometry[-1].pose.pose).x == pytest.approx(0.5, abs=0.03)


def test_a_gyro_without_wheels_makes_none(bench: RosBench) -> None:
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    bench.publish(Imu, "imu/data", _imu(TICK, 1.0))
    bench.publish(Odometry, "wheel_odom", _wheels(TICK, 0.0, 0.0))
    bench.publish(Imu, "imu/data", _imu(1.0, 1.0))  # long after the wheels
    assert odometry == []


def test_a_gyro_faster_than_the_wheels_is_used_in_between(bench: RosBench) -> None:
    start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    for i in range(1, 101):
        if i % 5 == 1:
            bench.publish(Odometry, "wheel_odom", _wheels(i * TICK, 0.2, 0.3))
        bench.publish(Imu, "imu/data", _imu(i * TICK, 0.5 if i % 5 else 0.0))
    assert len(odometry) == 100
    theta = se2_from_pose(odometry[-1].pose.pose).theta
    assert theta == pytest.approx(0.8, abs=0.1)  # 0.5 rad/s in four of five, not 0.3 or 0


@pytest.mark.parametrize(
    ("odom0", "odom_topic"),
    [
        ("odom", "odom"),
        ("/odom", "odom"),
        ("wheel_odom", "wheel_odom"),
        ("odometry/filtered", "/odometry/filtered"),
    ],
)
def test_self_listening_filters_are_refused(bench: RosBench, odom0: str, odom_topic: str) -> None:
    """As `odom0: odom` of public files makes it, whose filter publishes odometry/filtered."""
    node = EkfNode(bench.process, {"odom0": odom0, "odom_topic": odom_topic})
    with pytest.raises(ConfigError, match=f"odom0 '{odom0}' is /.*\\n.*odom0: wheel_odom, or"):
        node.configure()
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


def test_inputs_are_those_of_the_file_below_the_namespace(bench: RosBench) -> None:
    given = {"odom0": "odom", "imu0": "imu", "odom_topic": "odometry/filtered"}
    start(bench, EkfNode(bench.process, given))
    odometry = bench.collect(Odometry, "odometry/filtered")
    bench.publish(Odometry, "odom", _wheels(TICK, 0.5, 0.0))
    bench.publish(Imu, "imu", _imu(TICK, 0.1))
    assert len(odometry) == 1


def test_a_clock_that_is_set_back_starts_at_the_origin(bench: RosBench) -> None:
    start(bench, EkfNode(bench.process))
    bench.advance(2.0)
    odometry = bench.collect(Odometry, "odom")
    for now in (1.98, 2.0):
        bench.publish(Odometry, "wheel_odom", _wheels(now, 0.5, 0.0))
        bench.publish(Imu, "imu/data", _imu(now, 0.0))
    bench.set_back()
    bench.publish(Odometry, "wheel_odom", _wheels(TICK, 0.0, 0.0))
    bench.publish(Imu, "imu/data", _imu(TICK, 0.0))
    assert se2_from_pose(odometry[-1].pose.pose) == SE2(0.0, 0.0, 0.0)


def test_wheels_of_the_time_before_a_clock_was_set_back_to_0_are_refused() -> None:
    """The middleware may deliver them behind it; odometry had their stamp until time passed it."""
    with closing(RosBench(transport="dds")) as bench:
        start(bench, EkfNode(bench.process))
        bench.advance(30.0, ticks=50)
        odometry = bench.collect(Odometry, "odom")
        bench.publish(Clock, "/clock", Clock())
        bench.publish(Odometry, "wheel_odom", _wheels(30.0, 0.0, 0.0))
        for now in (TICK, 2 * TICK):
            bench.publish(Odometry, "wheel_odom", _wheels(now, 0.0, 0.0))
            bench.publish(Imu, "imu/data", _imu(now, 0.0))
        assert seconds(odometry[-1].header.stamp) == pytest.approx(2 * TICK)


def test_simulator_leaves_odometry_to_the_filter(bench: RosBench) -> None:
    sim = start(bench, SimNode(bench.process, {"fused_odometry": True}))
    wheels, odometry = bench.collect(Odometry, "wheel_odom"), bench.collect(Odometry, "odom")
    transforms = bench.collect(TFMessage, "/tf")
    sim.tick()
    bench.process.drain()
    assert (len(wheels), len(odometry), len(transforms)) == (1, 0, 0)
    start(bench, EkfNode(bench.process))
    sim.tick()
    bench.process.drain()
    assert (len(wheels), len(odometry), len(transforms)) == (2, 1, 1)
    assert seconds(odometry[0].header.stamp) == seconds(wheels[1].header.stamp)


def test_a_file_that_asks_for_the_worlds_odometry_gets_it(bench: RosBench, tmp_path: Path) -> None:
    source, end = shipped_file("urdf/arjuna.urdf"), "</wheelSeparation>"
    robot = edited(source, tmp_path, end, f"{end}<odometrySource>world</odometrySource>")
    sim = start_sim(bench, fused_odometry=True, robot=str(robot))
    start(bench, EkfNode(bench.process))
    wheels, odometry = bench.collect(Odometry, "wheel_odom"), bench.collect(Odometry, "odom")
    run(bench, sim, 50)
    assert (len(wheels), len(odometry)) == (0, 50)
    truth = sim.simulator.robots[SOLO].truth().pose
    assert se2_from_pose(odometry[-1].pose.pose).distance(truth) < 1e-9


@pytest.mark.parametrize(("others", "warnings"), [(0, 1), (1, 0)])
def test_wheels_that_never_come_are_reported_unless_somebody_else_publishes_odometry(
    bench: RosBench, capfd: pytest.CaptureFixture[str], others: int, warnings: int
) -> None:
    start(bench, EkfNode(bench.process))
    for _ in range(others):
        bench.node.create_publisher(Odometry, "odom", 1)
    for _ in range(4):
        bench.advance(2.0)
    assert capfd.readouterr().err.count("no odometry of the wheels") == warnings


def test_wheels_that_are_silent_for_the_timeout_end_the_odometry(bench: RosBench) -> None:
    node = start(bench, EkfNode(bench.process))
    assert node.set_parameters([Parameter("sensor_timeout", value=0.05)])[0].successful
    odometry = bench.collect(Odometry, "odom")
    bench.publish(Odometry, "wheel_odom", _wheels(TICK, 0.1, 0.0))
    bench.publish(Imu, "imu/data", _imu(0.06, 0.0))
    assert len(odometry) == 1
    bench.publish(Imu, "imu/data", _imu(0.08, 0.0))
    assert len(odometry) == 1  # the wheels have been silent for longer


def test_a_trust_changed_at_run_time_reaches_the_filter(bench: RosBench) -> None:
    node = start(bench, EkfNode(bench.process))
    odometry = bench.collect(Odometry, "odom")
    for i in range(1, 4):
        if i == 3:
            noise = Parameter("rest_noise", value=0.1)
            assert node.set_parameters([noise])[0].successful
        bench.publish(Odometry, "wheel_odom", _wheels(i * TICK, 0.0, 0.0))
        bench.publish(Imu, "imu/data", _imu(i * TICK, 0.0))
    before, after = (message.twist.covariance[0] for message in odometry[1:])
    assert after > 10.0 * before
