"""The node sim: topics, order, commands, pacing and its lifecycle."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.ros.convert import quaternion, seconds
from arjuna_core.se2 import SE2
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim


def test_a_tick_moves_the_clock_of_the_whole_process(bench: RosBench) -> None:
    sim = start_sim(bench)
    clocks = bench.collect(Clock, "/clock", qos.LATEST)
    run(bench, sim, 3)
    assert [seconds(c.clock) for c in clocks] == [0.02, 0.04, 0.06]
    assert bench.process.now == 0.06
    assert sim.last is not None
    assert sim.last.time == 0.06


def test_topics_have_the_standard_frames_and_rates(bench: RosBench) -> None:
    sim = start_sim(bench)
    odom = bench.collect(Odometry, "/odom")
    truth = bench.collect(Odometry, "/ground_truth/odom")
    joints = bench.collect(JointState, "/joint_states")
    imu = bench.collect(Imu, "/imu/data")
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert [len(m) for m in (odom, truth, joints, imu, scans)] == [50, 50, 50, 50, 10]
    assert (odom[0].header.frame_id, odom[0].child_frame_id) == ("odom", "base_footprint")
    assert truth[0].header.frame_id == "world"
    assert imu[0].header.frame_id == "imu_link"
    assert imu[0].linear_acceleration.z == pytest.approx(9.81, abs=0.3)
    assert scans[0].header.frame_id == "lidar_link"
    assert joints[0].name[0] == "front_left_joint"
    scan = scans[-1]
    assert len(scan.ranges) == 360
    assert (scan.range_min, scan.range_max) == pytest.approx((0.12, 12.0))
    assert scan.angle_max == pytest.approx(math.pi, abs=1e-5)
    assert scan.ranges[180] == pytest.approx(2.25, abs=0.06)  # the red box ahead


def test_transform_comes_before_what_it_belongs_to(bench: RosBench) -> None:
    sim = start_sim(bench)
    order: list[str] = []
    for kind, topic in ((Clock, "/clock"), (TFMessage, "/tf"), (Odometry, "/odom")):
        taken = partial(lambda name, _: order.append(name), topic)
        bench.node.create_subscription(kind, topic, taken, qos.TF)
    bench.node.create_subscription(LaserScan, "/scan", lambda _: order.append("/scan"), qos.TF)
    bench.process.drain()
    run(bench, sim, 5)
    assert order[-4:] == ["/clock", "/tf", "/odom", "/scan"]
    assert bench.process.transforms.try_lookup("odom", "base_footprint", 0.1) is not None


def test_cmd_vel_drives_and_its_silence_stops(bench: RosBench) -> None:
    sim = start_sim(bench)
    command = Twist()
    command.linear.x, command.angular.z = 0.5, 0.2
    for _ in range(50):
        bench.publish(Twist, "/cmd_vel", command)
        run(bench, sim, 1)
    assert sim.last is not None
    assert sim.last.truth.v == pytest.approx(0.5, abs=0.02)
    assert sim.last.truth.w == pytest.approx(0.2, abs=0.02)
    run(bench, sim, 50)
    assert abs(sim.last.truth.v) < 0.01


def test_command_that_is_not_finite_is_ignored(bench: RosBench) -> None:
    sim = start_sim(bench)
    command = Twist()
    command.linear.x = math.nan
    bench.publish(Twist, "/cmd_vel", command)
    run(bench, sim, 5)
    assert sim.last is not None
    assert abs(sim.last.truth.v) < 1e-3


def stamped_commands_drive(bench: RosBench, sim: SimNode) -> None:
    command = TwistStamped()
    command.twist.linear.x = 0.4
    for _ in range(40):
        bench.publish(TwistStamped, "/cmd_vel", command)
        run(bench, sim, 1)
    assert sim.last is not None
    assert sim.last.truth.v == pytest.approx(0.4, abs=0.02)


def test_stamped_commands_drive_when_enabled(bench: RosBench) -> None:
    sim = start_sim(bench, enable_stamped_cmd_vel=True)
    stamped_commands_drive(bench, sim)


def test_wrong_command_type_is_warned_of_once(
    bench: RosBench, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = start_sim(bench)
    # A participant refuses a second type on a topic, so the other process is played here.
    both = [
        SimpleNamespace(node_name=name, topic_type=f"geometry_msgs/msg/{kind}")
        for name, kind in (("teleop", "TwistStamped"), ("nav", "Twist"))
    ]
    monkeypatch.setattr(sim, "get_publishers_info_by_topic", lambda topic: both)
    run(bench, sim, 250)
    assert capfd.readouterr().err.count("publishes cmd_vel as geometry_msgs/msg/TwistStamped") == 1


def test_the_published_type_is_taken(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> None:
    sim = start_sim(bench)
    stamped = SimpleNamespace(node_name="nav", topic_type="geometry_msgs/msg/TwistStamped")
    monkeypatch.setattr(sim, "get_publishers_info_by_topic", lambda topic: [stamped])
    run(bench, sim, 40)  # the old subscription ends a look before the new begins
    stamped_commands_drive(bench, sim)


def test_pacing_asks_for_a_tick_each_20_ms_of_wall_time(bench: RosBench) -> None:
    sim = start_sim(bench, real_time_factor=2.0)
    assert sim.realtime_due(100.0) <= 0.0
    run(bench, sim, 1)
    assert sim.realtime_due(100.0) == pytest.approx(0.01)
    assert sim.realtime_due(100.004) == pytest.approx(0.006)
    run(bench, sim, 1)
    assert sim.realtime_due(200.0) == 0.0  # far behind: it gives up catching up
    run(bench, sim, 1)
    assert sim.realtime_due(200.0) == pytest.approx(0.01)


def test_initial_pose_and_nested_parameters_reach_the_core(bench: RosBench) -> None:
    sim = start_sim(
        bench,
        initial_pose={"x": 1.0, "y": -0.4, "yaw": 0.5},
        drive={"max_linear_velocity": 0.2},
        seed=4,
    )
    pose = sim.simulator.robots[SOLO].truth().pose
    assert (pose.x, pose.y, pose.theta) == pytest.approx((1.0, -0.4, 0.5))
    assert sim.simulator.config.drive.max_linear_velocity == 0.2


def test_unknown_parameter_is_refused(bench: RosBench) -> None:
    with pytest.raises(ConfigError, match="did you mean 'real_time_factor'"):
        SimNode(bench.process, {"realtime_factor": 1.0})


def test_missing_robot_fails_the_transition(bench: RosBench, tmp_path: Path) -> None:
    node = SimNode(bench.process, {"robot": str(tmp_path / "none.urdf")})
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


def test_inactive_simulator_stands_still(bench: RosBench) -> None:
    sim = start_sim(bench)
    run(bench, sim, 2)
    sim.trigger_deactivate()
    run(bench, sim, 5)
    assert sim.simulator.time == 0.04


def test_a_simulator_resumes_where_a_killed_one_was(bench: RosBench, tmp_path: Path) -> None:
    kept = {"resume_file": str(tmp_path / "sim"), "robot": str(shipped_file("urdf/arjuna.urdf"))}
    first = start_sim(bench, **kept)
    bench.publish(Twist, "/cmd_vel", Twist(linear=Vector3(x=0.4), angular=Vector3(z=0.5)))
    run(bench, first, 100)
    clocks = bench.collect(Clock, "/clock", qos.LATEST)
    second = start_sim(bench, **kept)  # the first one did not end: nothing told it to
    run(bench, second, 1)
    assert first.last is not None
    assert second.last is not None
    assert 2.0 < seconds(clocks[-1].clock) <= 2.0 + 0.1 + 0.02
    assert second.last.truth.pose.distance(first.last.truth.pose) < 0.05
    odometry = second.last.odometry.T_odom_base
    assert odometry.distance(first.last.odometry.T_odom_base) < 0.05
    assert odometry.x > 0.3


def test_what_was_kept_and_cannot_be_read_is_said(
    bench: RosBench, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "sim").write_text('{"time": 1.0}', encoding="utf-8")
    sim = start_sim(bench, resume_file=str(tmp_path / "sim"))
    assert sim.simulator.time == 0.0
    assert "the run before cannot be continued: 'poses'" in capfd.readouterr().err
    sim.trigger_deactivate()
    sim.trigger_cleanup()
    assert not (tmp_path / "sim").exists()


def test_a_robot_placed_by_estimates_is_where_the_last_says_and_its_odometry_does_not_notice(
    bench: RosBench, capfd: pytest.CaptureFixture[str]
) -> None:
    world = str(shipped_file("maps/office.yaml"))
    sim = start_sim(bench, world=world, placed_by_estimate=True)
    run(bench, sim, 5)
    estimate = PoseWithCovarianceStamped()

    def said(x: float) -> SE2:
        estimate.pose.pose.position.x, estimate.pose.pose.orientation = x, quaternion(1.0)
        bench.publish(PoseWithCovarianceStamped, "/initialpose", estimate)
        run(bench, sim, 5)
        assert sim.last is not None
        assert abs(sim.last.odometry.T_odom_base.x) < 0.01
        return sim.last.truth.pose

    assert said(-1.0).distance(SE2(-1.0, 0.0, 1.0)) < 0.01
    for x, problem in ((math.nan, "finite"), (-9.9, "the pose is blocked by ")):
        assert said(x).distance(SE2(-1.0, 0.0, 1.0)) < 0.01
        assert problem in capfd.readouterr().err
