"""Controllers of joints and Gazebo's tags."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from defusedxml.ElementTree import fromstring

from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.devices.sensors.imu import ImuSettings
from arjuna_sim.devices.sensors.navsat import NavSatSettings
from arjuna_sim.files.robots.gazebo import with_primary_first
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.joints import ControllerKind, Gains
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import GazeboSettings, SensorSettings
from arjuna_sim.model.urdf import Mimic, Urdf
from tests.sim.arms import CONTROLLERS, JOINTS, write_arm
from tests.sim.builders import urdf_file
from tests.sim.drive_cases import Robot, Wheel, plugin

POSITION = "<plugin filename='gz-sim-joint-position-controller-system' name='p'>{}</plugin>"


def notes(robot: RobotModel) -> str:
    return "\n".join(note.text for note in robot.notes)


def test_controllers_and_motors_are_read(tmp_path: Path) -> None:
    robot = load_robot(write_arm(tmp_path, CONTROLLERS))
    found = {one.name: one for one in robot.settings.controllers}
    assert list(found) == list(CONTROLLERS)
    assert found["arm_controller"].goal_tolerance == (0.01,) * 3
    assert found["arm_controller"].goal_time == 0.5
    assert [found[n].command for n in ("positions", "speeds", "efforts")] == [
        *("position", "velocity", "effort")
    ]
    assert found["gripper"].kind is ControllerKind.GRIPPER
    assert found["broadcaster"].kind is ControllerKind.OTHER
    assert found["speeds"].claims == tuple(f"{joint}/velocity" for joint in JOINTS)
    driven = {joint.name: joint for joint in robot.settings.driven}
    assert set(driven) == {*JOINTS, "finger"}  # what mimics has no motor of its own
    assert (driven["elbow"].initial, driven["elbow"].commands) == (0.25, ("position",))
    assert robot.settings.hardware == ("arm_system", "gz_ros2_control/GazeboSimSystem")


def test_gains_count_where_a_controller_commands_efforts(tmp_path: Path) -> None:
    gains = {joint: {"p": 40.0, "i": 2.0, "d": 3.0, "i_clamp": 5.0} for joint in JOINTS}
    for command, wanted in (("effort", Gains(40.0, 2.0, 3.0, 5.0)), ("position", None)):
        arm = {**CONTROLLERS["arm_controller"], "gains": gains, "command_interfaces": [command]}
        robot = load_robot(write_arm(tmp_path, {"arm": arm}))
        given = {joint.name: joint.gains for joint in robot.settings.driven}
        assert [given[joint] for joint in JOINTS] == [wanted] * 3


def test_gazebos_plugin_has_its_topic_gains_and_start(tmp_path: Path) -> None:
    tags = "<joint_name>elbow</joint_name><p_gain>90</p_gain><d_gain>4</d_gain>"
    tags += "<initial_position>0.7</initial_position><cmd_max>3</cmd_max>"
    robot = load_robot(write_arm(tmp_path, extra=f"<gazebo>{POSITION.format(tags)}</gazebo>"))
    (controller,), (joint,) = robot.settings.controllers, robot.settings.driven
    assert controller.topic == "/model/arm/joint/elbow/_0/cmd_pos"
    assert (joint.gains, joint.initial) == (Gains(90.0, 0.0, 4.0), 0.7)
    assert "not simulated: <cmd_max>" in notes(robot)
    file = write_arm(
        tmp_path, extra=f"<gazebo>{POSITION.format(tags.replace('p_', 'i_'))}</gazebo>"
    )
    assert load_robot(file).settings.driven[0].gains == Gains(1.0, 90.0, 4.0)


def test_what_names_no_joint_is_noted(tmp_path: Path) -> None:
    arm = {**CONTROLLERS["positions"], "joints": ["elbow", "nobody"]}
    robot = load_robot(
        write_arm(tmp_path, {"arm": arm, "empty": CONTROLLERS["gripper"] | {"joint": ""}})
    )
    assert "joint 'nobody' does not exist" in notes(robot)
    assert "controller 'empty': names no joints" in notes(robot)


def test_joints_that_mimic_in_ros2_control_alone_do_so(tmp_path: Path) -> None:
    """As gz_ros2_control of Humble reads it."""
    tag = "<ros2_control><joint name='wrist'><param name='mimic'>{}</param><param"
    tag += " name='multiplier'>-0.5</param><command_interface name='position'/></joint>"
    robot = load_robot(write_arm(tmp_path, extra=f"{tag}</ros2_control>".format("elbow")))
    assert robot.urdf.joints["wrist"].mimic == Mimic("elbow", -0.5, 0.0)
    assert "wrist" not in [joint.name for joint in robot.settings.driven]
    robot = load_robot(write_arm(tmp_path, extra=f"{tag}</ros2_control>".format("nobody")))
    assert "joint 'wrist' mimic: joint 'nobody' does not exist" in notes(robot)


def test_wheels_stay_the_drives(tmp_path: Path) -> None:
    wheels = (Wheel("left_wheel", 0.0, 0.2), Wheel("right_wheel", 0.0, -0.2))
    names = "".join(f"<joint_name>{wheel.name}_joint</joint_name>" for wheel in wheels)
    tag = plugin("gz-sim-joint-controller-system", names)
    sides = "<left_joint>left_wheel_joint</left_joint><right_joint>right_wheel_joint</right_joint>"
    drive = plugin("gz-sim-diff-drive-system", sides)
    for more, text in ((drive, "is the drive's, which alone turns it"), ("", "until then cmd_vel")):
        robot = load_robot(Robot(wheels, tag + more).write(tmp_path))
        assert robot.settings.driven == ()
        assert robot.drive.wheels == ("left_wheel_joint", "right_wheel_joint")
        assert text in notes(robot)


@pytest.mark.parametrize("value", ["0", "-1", "inf", "much"])
def test_efforts_that_are_no_limit_count_for_none(tmp_path: Path, value: str) -> None:
    path = write_arm(tmp_path)
    path.write_text(path.read_text().replace("effort='60'", f"effort='{value}'"))
    assert load_robot(path).urdf.joints["elbow"].max_effort == 0.0


IMU = ImuSettings(link="base", frame="base", rate=50.0, name="imu")
GPS = NavSatSettings(link="base", frame="base", rate=5.0, name="gps", topic="gps/fix")
CAMERA = CameraSettings(
    link="eye",
    frame="eye",
    rate=30.0,
    name="cam",
    width=64,
    height=48,
    horizontal_fov=1.0,
    near=0.1,
    far=9.0,
)
DEPTH = replace(CAMERA, name="deep", depth=True)


def settle(xml: XmlFile, sensors: list[SensorSettings]) -> GazeboSettings:
    urdf = Urdf(Path("r.urdf"), "r", "", "base")
    return GazeboSettings(sensors=tuple(with_primary_first(xml, urdf, sensors)))


def named(sensors: tuple[SensorSettings, ...]) -> list[tuple[str, str]]:
    return [(sensor.name, sensor.topic) for sensor in sensors]


def test_sensors_of_one_name_are_numbered_and_of_one_topic_get_their_own() -> None:
    xml = urdf_file()
    found = settle(
        xml, [IMU, replace(IMU), replace(IMU, topic="/imu/data"), replace(IMU, topic="own")]
    )
    assert found.first(ImuSettings) == IMU
    assert named(found.further) == [
        *(("imu_2", "imu_2/data"), ("imu_3", "imu_3/data"), ("imu_4", "own")),
    ]
    assert [note.text for note in xml.notes] == [
        "sensor 'imu_2': publishes on imu_2/data, since imu/data is another's",
        "sensor 'imu_3': publishes on imu_3/data, since /imu/data is another's",
    ]


def test_who_names_a_topic_has_it_before_who_has_it_for_want_of_a_name() -> None:
    found = settle(urdf_file(), [replace(IMU, name="lazy"), replace(IMU, is_named=True)])
    assert found.first(ImuSettings) == replace(IMU, is_named=True)
    assert named(found.further) == [("lazy", "lazy/data")]


@pytest.mark.parametrize(("tag", "is_named"), [("", False), ("<topic>imu/data</topic>", True)])
def test_a_sensor_s_tag_says_whether_it_names_its_topic(tag: str, is_named: bool) -> None:
    sensor = fromstring(f'<sensor name="s" type="imu">{tag}</sensor>')
    mount = SensorTag(urdf_file(), sensor, "base").mount(50.0, "imu/data")
    assert (mount["topic"], mount["is_named"]) == ("imu/data", is_named)


def test_names_and_topics_of_their_own_are_kept() -> None:
    xml = urdf_file()
    found = settle(xml, [GPS, IMU, replace(GPS, name="other", topic="other/fix")])
    assert (found.first(CameraSettings), found.first(ImuSettings)) == (None, IMU)
    assert named(found.further) == [("gps", "gps/fix"), ("other", "other/fix")]
    assert not xml.notes


@pytest.mark.parametrize(
    ("cameras", "first"),
    [([DEPTH, CAMERA], CAMERA), ([CAMERA, DEPTH], CAMERA), ([DEPTH], DEPTH), ([], None)],
)
def test_the_first_camera_is_one_of_colours_where_there_is_one(
    cameras: list[SensorSettings], first: CameraSettings | None
) -> None:
    found = settle(urdf_file(), [GPS, *cameras])
    assert found.first(CameraSettings) == first
    assert len(found.further) == len(cameras) + 1 - (first is not None)
    assert found.further[0] == GPS
