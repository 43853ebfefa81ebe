"""The nodes sim and robot_state_publisher: topics, frames, order, commands, services."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    GetEntityState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    StepSimulation,
)
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.errors import ConfigError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds, time_msg
from arjuna_core.se2 import SE2
from arjuna_sim.devices.camera import CameraError, Photographer, Shot
from arjuna_sim.nodes.robot_state_publisher import RobotStatePublisherNode
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench

pytestmark = pytest.mark.ros
SUCCESS = TransitionCallbackReturn.SUCCESS


@pytest.fixture
def bench() -> Iterator[RosBench]:
    bench = RosBench()
    yield bench
    bench.close()


def _start(bench: RosBench, node: Any) -> Any:
    assert node.trigger_configure() == SUCCESS
    assert node.trigger_activate() == SUCCESS
    bench.process.drain()
    return node


def _sim(bench: RosBench, **values: Any) -> SimNode:
    node: SimNode = _start(bench, SimNode(bench.process, values))
    return node


def _run(bench: RosBench, sim: SimNode, ticks: int) -> None:
    for _ in range(ticks):
        sim.tick()
        bench.process.drain()


def test_a_tick_moves_the_clock_of_the_whole_process(bench: RosBench) -> None:
    sim = _sim(bench)
    clocks = bench.collect(Clock, "/clock", qos.LATEST)
    _run(bench, sim, 3)
    assert [seconds(c.clock) for c in clocks] == [0.02, 0.04, 0.06]
    assert bench.process.now == 0.06
    assert sim.last is not None
    assert sim.last.time == 0.06


def test_topics_have_the_standard_frames_and_rates(bench: RosBench) -> None:
    sim = _sim(bench)
    odom = bench.collect(Odometry, "/odom")
    truth = bench.collect(Odometry, "/ground_truth/odom")
    joints = bench.collect(JointState, "/joint_states")
    imu = bench.collect(Imu, "/imu/data")
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
    _run(bench, sim, 50)
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
    sim = _sim(bench)
    order: list[str] = []
    for kind, topic in ((Clock, "/clock"), (TFMessage, "/tf"), (Odometry, "/odom")):
        bench.node.create_subscription(kind, topic, lambda _, t=topic: order.append(t), qos.TF)
    bench.node.create_subscription(LaserScan, "/scan", lambda _: order.append("/scan"), qos.TF)
    bench.process.drain()
    _run(bench, sim, 5)
    assert order[-4:] == ["/clock", "/tf", "/odom", "/scan"]
    assert bench.process.transforms.try_lookup("odom", "base_footprint", 0.1) is not None


def test_cmd_vel_drives_and_its_silence_stops(bench: RosBench) -> None:
    sim = _sim(bench)
    command = Twist()
    command.linear.x, command.angular.z = 0.5, 0.2
    for _ in range(50):
        bench.publish(Twist, "/cmd_vel", command)
        _run(bench, sim, 1)
    assert sim.last is not None
    assert sim.last.truth.v == pytest.approx(0.5, abs=0.02)
    assert sim.last.truth.w == pytest.approx(0.2, abs=0.02)
    _run(bench, sim, 50)
    assert abs(sim.last.truth.v) < 0.01


def test_command_that_is_not_finite_is_ignored(bench: RosBench) -> None:
    sim = _sim(bench)
    command = Twist()
    command.linear.x = math.nan
    bench.publish(Twist, "/cmd_vel", command)
    _run(bench, sim, 5)
    assert sim.last is not None
    assert abs(sim.last.truth.v) < 1e-3


def test_stamped_commands_drive_when_enabled(bench: RosBench) -> None:
    sim = _sim(bench, enable_stamped_cmd_vel=True)
    command = TwistStamped()
    command.twist.linear.x = 0.4
    for _ in range(40):
        bench.publish(TwistStamped, "/cmd_vel", command)
        _run(bench, sim, 1)
    assert sim.last is not None
    assert sim.last.truth.v == pytest.approx(0.4, abs=0.02)


def test_wrong_command_type_is_warned_of_once(
    bench: RosBench, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = _sim(bench)
    # A participant refuses a second type on a topic, so the other process is played here.
    other = SimpleNamespace(node_name="teleop", topic_type="geometry_msgs/msg/TwistStamped")
    monkeypatch.setattr(sim, "get_publishers_info_by_topic", lambda topic: [other])
    _run(bench, sim, 250)
    assert capfd.readouterr().err.count("publishes cmd_vel as geometry_msgs/msg/TwistStamped") == 1


def test_kidnap_by_set_entity_state_shows_in_truth_and_scan_only(bench: RosBench) -> None:
    sim = _sim(bench)
    _run(bench, sim, 5)
    request = SetEntityState.Request(entity="arjuna", set_pose=True)
    request.state.pose.position.x, request.state.pose.position.y = 1.0, 2.0
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == Result.RESULT_OK
    _run(bench, sim, 1)
    state = bench.call(GetEntityState, "/get_entity_state", GetEntityState.Request(entity="robot"))
    assert state.result.result == Result.RESULT_OK
    assert (state.state.pose.position.x, state.state.pose.position.y) == pytest.approx(
        (1.0, 2.0), abs=1e-3
    )
    assert sim.last is not None
    assert sim.last.odometry.T_odom_base.distance(SE2()) < 1e-3


@pytest.mark.parametrize(
    ("entity", "x", "flags", "code", "words"),
    [
        (
            "nobody",
            0.0,
            {"set_pose": True},
            Result.RESULT_NOT_FOUND,
            "valid: arjuna, obstacle_blue",
        ),
        ("arjuna", 2.5, {"set_pose": True}, 101, "taken by obstacle_red"),
        ("arjuna", math.nan, {"set_pose": True}, 101, "not finite"),
        ("arjuna", 1.0, {"set_twist": True}, Result.RESULT_FEATURE_UNSUPPORTED, "only the pose"),
    ],
)
def test_impossible_kidnap_is_refused_and_moves_nothing(
    bench: RosBench, entity: str, x: float, flags: dict[str, bool], code: int, words: str
) -> None:
    sim = _sim(bench)
    request = SetEntityState.Request(entity=entity, **flags)
    request.state.pose.position.x = x
    response = bench.call(SetEntityState, "/set_entity_state", request)
    assert response.result.result == code
    assert words in response.result.error_message
    assert sim.simulator.truth().pose.distance(SE2()) < 1e-6


def test_reset_goes_back_in_time_and_repeats_the_scans(bench: RosBench) -> None:
    sim = _sim(bench)
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
    _run(bench, sim, 20)
    response = bench.call(ResetSimulation, "/reset_simulation", ResetSimulation.Request())
    assert response.result.result == Result.RESULT_OK
    _run(bench, sim, 20)
    assert bench.process.now == 0.4
    assert len(scans) == 8
    assert all(
        np.array_equal(a.ranges, b.ranges) for a, b in zip(scans[:4], scans[4:], strict=True)
    )


def test_pause_holds_time_and_steps_advance_it(bench: RosBench) -> None:
    sim = _sim(bench)
    _run(bench, sim, 2)
    pause = SetSimulationState.Request()
    pause.state.state = SimulationState.STATE_PAUSED
    response = bench.call(SetSimulationState, "/set_simulation_state", pause)
    assert response.result.result == Result.RESULT_OK
    _run(bench, sim, 5)
    assert sim.simulator.time == 0.04
    assert sim.realtime_due(0.0) == math.inf
    response = bench.call(StepSimulation, "/step_simulation", StepSimulation.Request(steps=3))
    assert response.result.result == Result.RESULT_OK
    assert bench.process.now == 0.1


def test_features_name_what_is_served(bench: RosBench) -> None:
    _sim(bench)
    response = bench.call(
        GetSimulatorFeatures, "/get_simulator_features", GetSimulatorFeatures.Request()
    )
    assert SimulatorFeatures.ENTITY_STATE_SETTING in response.features.features


def test_pacing_asks_for_a_tick_each_20_ms_of_wall_time(bench: RosBench) -> None:
    sim = _sim(bench, real_time_factor=2.0)
    assert sim.realtime_due(100.0) <= 0.0
    _run(bench, sim, 1)
    assert sim.realtime_due(100.0) == pytest.approx(0.01)
    assert sim.realtime_due(100.004) == pytest.approx(0.006)
    _run(bench, sim, 1)
    assert sim.realtime_due(200.0) == 0.0  # far behind: it gives up catching up
    _run(bench, sim, 1)
    assert sim.realtime_due(200.0) == pytest.approx(0.01)


def test_camera_publishes_only_for_who_looks(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = _sim(bench)
    drawn: list[float] = []

    def draw(self: Any, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        drawn.append(sim.simulator.time)
        assert color
        return Shot(
            np.zeros((480, 640, 3), np.uint8), np.ones((480, 640), np.float32) if depth else None
        )

    monkeypatch.setattr(Photographer, "shoot", draw)
    _run(bench, sim, 10)
    assert drawn == []
    images = bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    infos = bench.collect(CameraInfo, "/camera/camera_info", qos.SENSOR_SUBSCRIPTION)
    _run(bench, sim, 50)
    assert len(images) == len(infos) == len(drawn) == 30
    assert (images[0].encoding, images[0].step) == ("rgb8", 1920)
    assert images[0].header.frame_id == "camera_link"
    assert infos[0].k[2] == 320.0
    depths = bench.collect(Image, "/camera/depth/image_raw", qos.SENSOR_SUBSCRIPTION)
    _run(bench, sim, 50)
    assert (len(images), len(depths), len(drawn)) == (60, 30, 60)  # one shot for both
    assert (depths[0].encoding, depths[0].step, len(depths[0].data)) == (
        "32FC1", 2560, 2560 * 480
    )  # fmt: skip


def test_camera_that_cannot_draw_is_switched_off_and_nothing_else(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = _sim(bench)
    tries: list[float] = []

    def fail(*arguments: Any) -> Any:
        tries.append(sim.simulator.time)
        raise CameraError("no off-screen OpenGL works")

    monkeypatch.setattr(Photographer, "shoot", fail)
    bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    _run(bench, sim, 20)
    assert len(tries) == 1
    assert sim.simulator.time == 0.4


def test_initial_pose_and_nested_parameters_reach_the_core(bench: RosBench) -> None:
    sim = _sim(
        bench, initial_pose={"x": 1.0, "yaw": 0.5}, drive={"max_linear_velocity": 0.2}, seed=4
    )
    pose = sim.simulator.truth().pose
    assert (pose.x, pose.y, pose.theta) == pytest.approx((1.0, 0.0, 0.5))
    assert sim.simulator.config.drive.max_linear_velocity == 0.2


def test_unknown_parameter_is_refused(bench: RosBench) -> None:
    with pytest.raises(ConfigError, match="did you mean 'real_time_factor'"):
        SimNode(bench.process, {"realtime_factor": 1.0})


def test_missing_robot_fails_the_transition(bench: RosBench, tmp_path: Path) -> None:
    node = SimNode(bench.process, {"robot": str(tmp_path / "none.urdf")})
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


@pytest.mark.parametrize("cls", [SimNode, RobotStatePublisherNode])
def test_lifecycle_runs_twice(bench: RosBench, cls: Any) -> None:
    node = cls(bench.process)
    for _ in range(2):
        for step in ("configure", "activate", "deactivate", "cleanup"):
            assert getattr(node, f"trigger_{step}")() == SUCCESS
            bench.process.drain()


def test_inactive_simulator_stands_still(bench: RosBench) -> None:
    sim = _sim(bench)
    _run(bench, sim, 2)
    sim.trigger_deactivate()
    _run(bench, sim, 5)
    assert sim.simulator.time == 0.04


def test_description_and_fixed_frames_are_latched(bench: RosBench) -> None:
    description = bench.collect(String, "/robot_description", qos.LATCHED)
    static = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    _start(bench, RobotStatePublisherNode(bench.process))
    assert description[0].data.startswith("<?xml")
    children = {t.child_frame_id: t for t in static[0].transforms}
    assert sorted(children) == ["base_link", "camera_link", "imu_link", "lidar_link"]
    assert children["lidar_link"].header.frame_id == "base_link"
    assert children["lidar_link"].transform.translation.z == pytest.approx(0.2)


def test_wheels_turn_in_tf_at_most_at_the_publish_frequency(bench: RosBench) -> None:
    sim = _sim(bench)
    _start(bench, RobotStatePublisherNode(bench.process))
    messages = bench.collect(TFMessage, "/tf")
    _run(bench, sim, 50)
    wheels = [m for m in messages if m.transforms[0].child_frame_id.endswith("_wheel")]
    assert 18 <= len(wheels) <= 21
    assert len(wheels[0].transforms) == 4
    rotation = wheels[0].transforms[0].transform.rotation
    assert rotation.x == pytest.approx(-math.sqrt(0.5), abs=0.01)


def test_whole_tree_connects_odom_to_the_lidar(bench: RosBench) -> None:
    sim = _sim(bench)
    _start(bench, RobotStatePublisherNode(bench.process))
    _run(bench, sim, 5)
    assert bench.process.transforms.try_lookup("odom", "lidar_link") is not None


def test_in_real_time_pictures_are_drawn_beside_the_physics(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A picture that takes long holds no tick up, and comes with the stamp of what it shows."""
    sim = _sim(bench)
    begun, go_on = threading.Event(), threading.Event()

    def draw(self: Any, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        begun.set()
        assert go_on.wait(10.0)
        return Shot(np.zeros((480, 640, 3), np.uint8), None)

    monkeypatch.setattr(Photographer, "shoot", draw)
    images = bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    sim.realtime_due(0.0)
    _run(bench, sim, 20)
    assert begun.wait(10.0)
    assert images == []
    assert sim.simulator.time == 0.4
    go_on.set()
    while not images:
        _run(bench, sim, 1)
        assert sim.simulator.time < 100.0
    assert images[0].header.stamp == time_msg(0.04)
    sim.trigger_deactivate()
    sim.trigger_cleanup()
    assert not [thread for thread in threading.enumerate() if thread.name == "camera"]
