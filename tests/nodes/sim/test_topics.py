"""Topics, frames, rates and flags of the robot's file, and that each rate is exact in sim time."""

from __future__ import annotations

from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import Empty
from tf2_msgs.msg import TFMessage

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros import qos
from arjuna_core.ros.convert import seconds
from arjuna_sim.model.robot import SOLO
from arjuna_sim.model.settings import BRIDGES
from arjuna_sim.nodes.sim import SimNode
from arjuna_sim.nodes.sim_config import SimConfig
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim


def _robot(folder: Path, *edits: tuple[str, str]) -> str:
    text = shipped_file("urdf/arjuna.urdf").read_text(encoding="utf-8")
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return str(path)


RENAMED = (
    ("<commandTopic>cmd_vel<", "<commandTopic>base/cmd<"),
    ("<odometryTopic>odom<", "<odometryTopic>wheels/odom<"),
    ("<odometryFrame>odom<", "<odometryFrame>wheel_odom<"),
    ("<topicName>scan<", "<topicName>front/scan<"),
    ("out:=imu/data<", "out:=imu/raw<"),
)


def test_topics_and_frame_of_the_file_are_used(bench: RosBench, tmp_path: Path) -> None:
    sim = start_sim(bench, robot=_robot(tmp_path, *RENAMED))
    odom = bench.collect(Odometry, "/wheels/odom")
    scans = bench.collect(LaserScan, "/front/scan", qos.SENSOR_SUBSCRIPTION)
    imu = bench.collect(Imu, "/imu/raw")
    transforms = bench.collect(TFMessage, "/tf")
    command = Twist()
    command.linear.x = 0.5
    for _ in range(20):
        bench.publish(Twist, "/base/cmd", command)
        run(bench, sim, 1)
    assert (len(scans), len(imu)) == (4, 20)
    assert odom[-1].header.frame_id == "wheel_odom"
    assert odom[-1].twist.twist.linear.x > 0.3
    assert transforms[-1].transforms[0].header.frame_id == "wheel_odom"


@pytest.mark.parametrize(
    ("named", "described", "frame"),
    [
        ("base_link", True, "base_footprint"),
        ("r1/base_link", True, "r1/base_footprint"),
        ("r1/chassis", True, "r1/chassis"),
        ("r1/chassis", False, "base_footprint"),
    ],
)
def test_a_base_frame_that_is_no_link_of_the_file_is_somebody_else_s(
    bench: RosBench, tmp_path: Path, named: str, described: bool, frame: str
) -> None:
    """Of whoever publishes the robot's description; else it is the root link."""
    tag = "robotBaseFrame"
    robot = _robot(tmp_path, (f"<{tag}>base_footprint<", f"<{tag}>{named}<"))
    sim = start_sim(bench, robot=robot, frames_of_file=described)
    odom, transforms = bench.collect(Odometry, "/odom"), bench.collect(TFMessage, "/tf")
    run(bench, sim, 2)
    assert {odom[-1].child_frame_id, transforms[-1].transforms[0].child_frame_id} == {frame}


def test_standard_topics_can_be_asked_for(bench: RosBench, tmp_path: Path) -> None:
    sim = start_sim(bench, robot=_robot(tmp_path, *RENAMED), standard_topics=True)
    odom = bench.collect(Odometry, "/odom")
    run(bench, sim, 2)
    assert odom[-1].header.frame_id == "odom"


@pytest.mark.parametrize(("rate", "count"), [(30.0, 60), (7.0, 14), (50.0, 100)])
def test_lidar_rate_is_exact_in_sim_time(
    bench: RosBench, tmp_path: Path, rate: float, count: int
) -> None:
    edit = ("<update_rate>10", f"<update_rate>{rate:g}")
    sim = start_sim(bench, robot=_robot(tmp_path, edit))
    scans = bench.collect(LaserScan, "/scan", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 100)
    assert len(scans) == count
    late = [seconds(scan.header.stamp) - (i + 1) / rate for i, scan in enumerate(scans)]
    assert min(late) > -1e-6  # none early, and none later than the tick that follows
    assert max(late) < 0.02 - 1e-6


@pytest.mark.parametrize("rate", [1.0, 10.0, 25.0])
def test_odometry_rate_of_the_file_is_exact(bench: RosBench, tmp_path: Path, rate: float) -> None:
    """Its transform comes no less often than navigation needs it."""
    edit = ("<updateRate>50", f"<updateRate>{rate:g}")
    sim = start_sim(bench, robot=_robot(tmp_path, edit))
    odom = bench.collect(Odometry, "/odom")
    transforms = bench.collect(TFMessage, "/tf")
    run(bench, sim, 100)
    assert len(odom) == round(2.0 * rate)
    assert len(transforms) == round(2.0 * max(rate, SimConfig().transform_rate))


def test_wheels_come_often_enough_to_be_fused(bench: RosBench, tmp_path: Path) -> None:
    edit = ("<updateRate>50", "<updateRate>1")
    sim = start_sim(bench, robot=_robot(tmp_path, edit), fused_odometry=True)
    odom = bench.collect(Odometry, "/wheel_odom")
    run(bench, sim, 100)
    assert len(odom) == round(2.0 * SimConfig().transform_rate)


def test_joint_states_and_imu_keep_their_rates(bench: RosBench, tmp_path: Path) -> None:
    sim = start_sim(bench, robot=_robot(tmp_path, ("<update_rate>50", "<update_rate>20")))
    joints = bench.collect(JointState, "/joint_states")
    imu = bench.collect(Imu, "/imu/data")
    run(bench, sim, 100)
    assert (len(joints), len(imu)) == (100, 40)
    assert [seconds(m.header.stamp) for m in imu[:4]] == pytest.approx([0.06, 0.1, 0.16, 0.2])


def test_world_odometry_is_the_truth(bench: RosBench, tmp_path: Path) -> None:
    edit = ("<wheelSeparation>", "<odometrySource>world</odometrySource><wheelSeparation>")
    robot = _robot(tmp_path, edit)
    sim = start_sim(bench, robot=robot, initial_pose={"x": 1.0, "y": 0.5, "yaw": 0.3})
    odom = bench.collect(Odometry, "/odom")
    run(bench, sim, 5)
    truth = sim.simulator.robots[SOLO].truth().pose
    point = odom[-1].pose.pose.position
    assert (point.x, point.y) == pytest.approx((truth.x, truth.y), abs=1e-9)
    assert truth.x == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("frames_of_file", "x"), [(True, 1.0), (False, 0.0)])
def test_odometry_of_classic_begins_where_it_is_in_the_world(
    bench: RosBench, tmp_path: Path, frames_of_file: bool, x: float
) -> None:
    robot = _robot(tmp_path)
    given = {"initial_pose": {"x": 1.0, "y": 0.5, "yaw": 0.3}, "frames_of_file": frames_of_file}
    sim = start_sim(bench, robot=robot, **given)
    odom = bench.collect(Odometry, "/odom")
    run(bench, sim, 5)
    assert odom[-1].pose.pose.position.x == pytest.approx(x, abs=1e-3)


def test_the_uncertainty_of_odometry_lies_along_the_robot_s_way(
    bench: RosBench, tmp_path: Path
) -> None:
    """At first the distance is less sure than the heading: of one that drives along y, y is."""
    given = {"initial_pose": {"x": 0.0, "y": -2.0, "yaw": 1.5708}, "frames_of_file": True}
    sim = start_sim(bench, robot=_robot(tmp_path), **given)
    odom, command = bench.collect(Odometry, "/odom"), Twist()
    command.linear.x = 0.5
    for _ in range(150):
        bench.publish(Twist, "/cmd_vel", command)
        run(bench, sim, 1)
    covariance = odom[-1].pose.covariance
    assert covariance[7] > 1.2 * covariance[0] > 0.0


def test_flags_of_the_file_switch_the_transform_off(bench: RosBench, tmp_path: Path) -> None:
    edit = ("<broadcastTF>1</broadcastTF>", "<broadcastTF>0</broadcastTF>")
    sim = start_sim(bench, robot=_robot(tmp_path, edit))
    odom = bench.collect(Odometry, "/odom")
    transforms = bench.collect(TFMessage, "/tf")
    run(bench, sim, 3)
    assert (len(odom), len(transforms)) == (3, 0)


@pytest.mark.parametrize(
    ("system", "marks", "frames"),
    [
        ("gz::sim::systems::DiffDrive", ("",), 0),
        ("gz::sim::systems::DiffDrive", ("", "/tf"), 60),
        ("gz::sim::systems::DiffDrive", (), 60),
        ("skid_steer_drive", ("",), 60),
    ],
)
def test_gazebo_sim_s_transform_comes_where_a_bridge_hands_it_on(
    bench: RosBench, tmp_path: Path, system: str, marks: tuple[str, ...], frames: int
) -> None:
    """Beside a filter's, as their authors mean it, odometry had two parents in turn."""
    robot = _robot(tmp_path, ('name="skid_steer_drive"', f'name="{system}"'))
    sim = start_sim(bench, robot=robot)
    for mark in marks:
        bench.node.create_publisher(Empty, f"{BRIDGES}{mark}", qos.DEFAULT)
    transforms, odom = bench.collect(TFMessage, "/tf"), bench.collect(Odometry, "/odom")
    run(bench, sim, 60)
    assert (len(odom), len(transforms)) == (60, frames)


def test_topic_that_no_topic_can_be_is_refused(bench: RosBench, tmp_path: Path) -> None:
    robot = _robot(tmp_path, ("<topicName>scan<", "<topicName>my{scan<"))
    node = SimNode(bench.process, {"robot": robot})
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE
    again = SimNode(bench.process, {"robot": robot, "standard_topics": True}, name="again")
    assert again.trigger_configure() == TransitionCallbackReturn.SUCCESS


@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_a_fast_imu_reads_between_ticks(bench: RosBench, tmp_path: Path, rate: float) -> None:
    edit = ("<update_rate>50", f"<update_rate>{rate:g}")
    sim = start_sim(bench, robot=_robot(tmp_path, edit))
    imu = bench.collect(Imu, "/imu/data", qos.TF)
    run(bench, sim, 100)
    assert len(imu) == round(2.0 * rate)
    stamps = [seconds(message.header.stamp) for message in imu]
    late = [stamp - (i + 1) / rate for i, stamp in enumerate(stamps)]
    assert min(late) > -1e-6
    assert max(late) < 0.004 - 1e-6  # the physics step
    assert imu[-1].linear_acceleration.z == pytest.approx(9.81, abs=0.2)


def test_sensor_faster_than_the_simulation_is_said_so(
    bench: RosBench, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    edits = (("<update_rate>50", "<update_rate>1000"), ("<update_rate>10", "<update_rate>80"))
    start_sim(bench, robot=_robot(tmp_path, *edits))
    said = capfd.readouterr().err
    assert "the imu has 1000 Hz, but comes at 250 Hz at most" in said
    assert "the lidar has 80 Hz, but comes at 50 Hz at most" in said


_SENSORS = {
    "imu": {"/imu/data"},
    "lidar": {"/scan"},
    "camera": {"/camera/image_raw", "/camera/camera_info"},
}


@pytest.mark.parametrize("lacking", [(), *((kind,) for kind in _SENSORS), tuple(_SENSORS)])
def test_only_topics_of_sensors_that_are_there_are_advertised(
    bench: RosBench, tmp_path: Path, lacking: tuple[str, ...]
) -> None:
    """So that `ros2 topic list` without /scan shows that the lidar failed."""
    text = shipped_file("urdf/arjuna.urdf").read_text(encoding="utf-8")
    for kind in lacking:
        type_ = "ray" if kind == "lidar" else kind  # the depth camera's points too, else a scan
        assert f'type="{type_}"' in text
        text = text.replace(f'type="{type_}"', 'type="none"')
    path = tmp_path / "lacking.urdf"
    path.write_text(text, encoding="utf-8")
    node = start_sim(bench, robot=str(path))
    names = {name for name, _ in node.get_topic_names_and_types()}
    there = {kind for kind, topics in _SENSORS.items() if topics <= names}
    assert there == _SENSORS.keys() - set(lacking)
    for kind in lacking:
        assert names.isdisjoint(_SENSORS[kind])


def test_a_thing_without_wheels_has_no_topics_of_them(bench: RosBench, tmp_path: Path) -> None:
    path = tmp_path / "box.urdf"
    path.write_text(
        "<robot name='box'><link name='base'><inertial><mass value='1'/><inertia ixx='.1' iyy='.1'"
        " izz='.1' ixy='0' ixz='0' iyz='0'/></inertial><collision><geometry><box size='.2 .2 .2'/>"
        "</geometry></collision></link></robot>",
        encoding="utf-8",
    )
    node = start_sim(bench, robot=str(path), publish_ground_truth=False)
    names = {name for name, _ in node.get_topic_names_and_types()}
    assert names.isdisjoint({"/odom", "/scan", "/imu/data", "/ground_truth/odom"})


def test_a_cut_command_is_reported_once(bench: RosBench, capfd: pytest.CaptureFixture[str]) -> None:
    sim = start_sim(bench)
    for speed in (5.0, 6.0, 0.5, 7.0):
        command = Twist()
        command.linear.x = speed
        bench.publish(Twist, "/cmd_vel", command)
        run(bench, sim, 2)
    said = [line for line in capfd.readouterr().err.splitlines() if "is cut to" in line]
    (line,) = said
    assert "cmd_vel: a command of 5 m/s is cut to 1 m/s, by plugin 'skid_steer_drive'" in line
