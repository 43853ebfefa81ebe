"""Drive plugins, and the wheels where these say nothing or something else."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.files.robots.plugins import read_drive, read_wheelless, torque_of
from arjuna_sim.model.settings import DriveKind, DriveSettings
from tests.sim.builders import texts, urdf_file
from tests.sim.wheeled import weight, wheeled

POSITIONS = ((0.0, 0.25, 0.0), (0.0, -0.25, 0.0))  # wheels of 0.1 m, 0.5 m apart
FOUR = ((0.2, 0.25, 0.0), (0.2, -0.25, 0.0), (-0.2, 0.25, 0.0), (-0.2, -0.25, 0.0))
DIFF = "libgazebo_ros_diff_drive.so"
SIDES = "<left_joint>a</left_joint><right_joint>b</right_joint>"


def read(
    inside: str = SIDES,
    positions: tuple[tuple[float, float, float], ...] = POSITIONS,
    mass: float = 1.0,
    name: str = "name='p'",
    file: str = "f.so",
) -> tuple[DriveSettings | None, tuple[str, ...]]:
    """Return what a plugin says of wheels `a`, `b`, ... at their positions, and what is noted."""
    xml = urdf_file(f"<gazebo><plugin {name} filename='{file}'>{inside}</plugin></gazebo>")
    urdf = wheeled(positions, base=weight(mass))
    return read_drive(xml, xml.child(xml.root, "gazebo/plugin", "r"), urdf), texts(xml.notes)


def drive(*args: Any, **given: Any) -> DriveSettings:
    found = read(*args, **given)[0]
    assert found is not None
    return found


def test_a_plugin_that_names_wheels_alone_drives_by_their_shapes() -> None:
    found, notes = read()
    assert found is not None
    lengths = (found.separation, found.radius, found.effective_track, found.effective_radius)
    assert lengths == pytest.approx((0.5, 0.1, 0.5, 0.1))
    assert found == DriveSettings(
        ("a",), ("b",), found.separation, found.radius, 5.0, *lengths[2:], plugin="p"
    )
    assert notes == ()


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("<left_joint>{}</left_joint>", "<right_joint>{}</right_joint>"),
        ("<leftJoint>{}</leftJoint>", "<rightJoint>{}</rightJoint>"),
        ("<leftFrontJoint>{}</leftFrontJoint>", "<rightRearJoint>{}</rightRearJoint>"),
        ("<front_left_joint>{}</front_left_joint>", "<middle_right_joint>{}</middle_right_joint>"),
        ("<back_left_joint>{}</back_left_joint>", "<right_back_joint>{}</right_back_joint>"),
        ("<left_front>{}</left_front>", "<right_rear>{}</right_rear>"),
        (  # a Kobuki's
            "<left_wheel_joint_name>{}</left_wheel_joint_name>",
            "<right_wheel_joint_name>{}</right_wheel_joint_name>",
        ),
        ("<left_wheel_joint>{}</left_wheel_joint>", "<right_wheel_joint>{}</right_wheel_joint>"),
        ("<front_left_wheel>{}</front_left_wheel>", "<back_right_wheel>{}</back_right_wheel>"),
    ],
)
def test_sides_are_named_by_any_of_their_tags(left: str, right: str) -> None:
    found = drive(left.format(" a ") + right.format("b"))
    assert (found.left, found.right) == (("a",), ("b",))


@pytest.mark.parametrize(("file", "drives"), [("libmakers_car.so", False), (DIFF, True)])
def test_a_plugin_of_unknown_type_drives_no_joint_that_steers(file: str, drives: bool) -> None:
    xml = urdf_file(f"<gazebo><plugin filename='{file}'>{SIDES}</plugin></gazebo>")
    urdf = wheeled(POSITIONS)
    upright = dataclasses.replace(urdf.joints["a"], axis=(0.0, 0.0, 1.0))
    urdf = dataclasses.replace(urdf, joints={**urdf.joints, "a": upright})
    found = read_drive(xml, xml.child(xml.root, "gazebo/plugin", "r"), urdf)
    assert (found is not None) == drives


def test_sides_that_are_swapped_are_exchanged() -> None:
    given = "<left_joint>{}</left_joint><left_joint>{}</left_joint>"
    given += given.replace("left", "right")
    found, notes = read(given.format(*"bdac"), FOUR)
    assert found is not None
    assert (found.left, found.right) == (("a", "c"), ("b", "d"))
    assert "plugin 'p': its left wheels stand on the right, so left and right are exchanged" in (
        notes
    )
    # By where the wheels of a side stand on the average: c is far to the left, a near the middle.
    spread = ((0.0, -0.1, 0.0), (0.0, 0.1, 0.0), (-0.2, 0.5, 0.0), (-0.2, -0.5, 0.0))
    found, notes = read(given.format(*"acbd"), spread)
    assert found is not None
    assert found.left == ("a", "c")
    assert not any("exchanged" in note for note in notes)
    aside = tuple((x, y + 1.0, z) for x, y, z in POSITIONS)
    found, notes = read(positions=aside)
    assert found is not None
    assert found.left == ("a",)
    assert notes == ()


def test_a_wheel_that_is_named_twice_counts_once() -> None:
    """Gazebo turns it twice by the same speed."""
    found, notes = read(SIDES + "<right_joint>b</right_joint>")
    assert found is not None
    assert (found.left, found.right) == (("a",), ("b",))
    assert "plugin 'p': names a joint twice: it counts once" in notes


def test_what_names_no_wheels_of_both_sides_is_no_drive() -> None:
    assert read("")[0] is None
    assert read("<left_joint>a</left_joint>")[0] is None
    assert read("<right_joint>a</right_joint>")[0] is None


def test_wheels_without_sides_are_a_row() -> None:
    found = drive("<wheel_joint>a</wheel_joint><wheel_joint>b</wheel_joint>")
    assert (found.left, found.right) == (("a", "b"), ())
    assert found.separation == pytest.approx(0.5)
    assert found.effective_track == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        (SIDES.replace(">b<", ">bb<"), r"plugin 'p'.*joint 'bb' does not exist"),
        (SIDES.replace(">b<", ">a<"), r"plugin 'p'.*has 'a' on both sides"),
        (SIDES + "<wheel_diameter>-1</wheel_diameter>", r"'-1' must not be negative"),
        (SIDES + "<steering_joint>x</steering_joint>", r"joint 'x' does not exist"),
    ],
)
def test_what_a_plugin_gets_wrong_is_refused(inside: str, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        read(inside)


@pytest.mark.parametrize(
    ("tag", "changed"),
    [
        ("<wheel_diameter>0.3</wheel_diameter>", {"radius": 0.15}),
        ("<wheel_diameter>0.1</wheel_diameter><wheel_diameter>0.2</wheel_diameter>", {}),  # pairs
        ("<wheel_radius>0.15</wheel_radius>", {"radius": 0.15}),
        ("<wheel_radius>0.2</wheel_radius><wheel_diameter>0.3</wheel_diameter>", {"radius": 0.15}),
        ("<wheel_separation>0.7</wheel_separation>", {"separation": 0.7}),
        ("<effective_track_width>0.8</effective_track_width>", {"effective_track": 0.8}),
        ("<effective_wheel_radius>0.12</effective_wheel_radius>", {"effective_radius": 0.12}),
        ("<torque>3</torque>", {"torque": 3.0}),
        ("<wheelTorque>3</wheelTorque>", {"torque": 3.0}),
        ("<max_wheel_torque>3</max_wheel_torque>", {"torque": 3.0}),
        ("<steering_limit>0.6</steering_limit>", {"steering_limit": 0.6}),
        ("<max_steer>0.6</max_steer>", {"steering_limit": 0.6}),
        ("<max_wheel_acceleration>2</max_wheel_acceleration>", {"max_acceleration": 2.0}),
        ("<maxLinearAcceleration>2</maxLinearAcceleration>", {"max_acceleration": 2.0}),
        (  # Gazebo Sim's hold in their own direction
            "<max_linear_acceleration>2</max_linear_acceleration>",
            {"max_acceleration": 2.0, "max_deceleration": math.inf},
        ),
        (
            "<max_angular_acceleration>2</max_angular_acceleration>",
            {"max_turn_acceleration": 2.0, "max_turn_deceleration": math.inf},
        ),
        (
            "<min_acceleration>-2</min_acceleration>",
            {"max_deceleration": 2.0, "max_turn_deceleration": 2.0},
        ),
        ("<min_linear_acceleration>-2</min_linear_acceleration>", {"max_deceleration": 2.0}),
        ("<max_jerk>3</max_jerk><min_jerk>-2</min_jerk>", {"max_jerk": 2.0, "max_turn_jerk": 2.0}),
        ("<max_angular_jerk>3</max_angular_jerk>", {"max_turn_jerk": 3.0}),
        ("<max_linear_velocity>2</max_linear_velocity>", {"max_velocity": 2.0}),
        ("<max_linear_speed>2</max_linear_speed>", {"max_velocity": 2.0}),
        ("<max_angular_speed>2</max_angular_speed>", {"max_turn": 2.0}),
        ("<update_rate>20</update_rate>", {"rate": 20.0}),
        ("<odom_publish_frequency>20</odom_publish_frequency>", {"rate": 20.0}),
        ("<updateRate>30</updateRate><odometryRate>50</odometryRate>", {"rate": 50.0}),
        ("<update_rate>100</update_rate><publish_rate>10</publish_rate>", {"rate": 10.0}),
        ("<commandTopic>go</commandTopic>", {"command_topic": "go"}),
        (
            "<robotNamespace>/a</robotNamespace>",
            {"command_topic": "/a/cmd_vel", "odometry_topic": "/a/odom"},
        ),
        (
            "<ros><namespace>/a</namespace><remapping>odom:=way</remapping></ros>",
            {"command_topic": "/a/cmd_vel", "odometry_topic": "/a/way"},
        ),
        ("<topic>go</topic>", {"command_topic": "go"}),
        ("<odom_topic>way</odom_topic>", {"odometry_topic": "way"}),
        ("<odometryFrame>here</odometryFrame>", {"odometry_frame": "here"}),
        ("<frame_id>here</frame_id>", {"odometry_frame": "here"}),
        ("<odometryFrame>/here</odometryFrame>", {"odometry_frame": "here"}),
        ("<robotBaseFrame>me</robotBaseFrame>", {"base_frame": "me"}),
        ("<robotBaseFrame>/me</robotBaseFrame>", {"base_frame": "me"}),
        ("<odometrySource>world</odometrySource>", {"from_world": True}),
        ("<odometrySource>1</odometrySource>", {"from_world": True}),
        ("<odometrySource>encoder</odometrySource>", {}),
        ("<odometry_source>0</odometry_source>", {}),
        ("<stamped>true</stamped>", {"stamped": True}),
        ("<publish_odom>false</publish_odom>", {"publishes": ("odom_tf",)}),
        ("<publish_odom_tf>false</publish_odom_tf>", {"publishes": ("odom",)}),
        ("<broadcastTF>0</broadcastTF>", {"publishes": ("odom",)}),
        ("<publish_wheel_tf>1</publish_wheel_tf>", {"publishes": ("odom", "odom_tf", "wheel_tf")}),
        (
            "<publishWheelJointState>true</publishWheelJointState>",
            {"publishes": ("odom", "odom_tf", "joint_states")},
        ),
    ],
)
def test_each_tag_says_one_thing(tag: str, changed: dict[str, Any]) -> None:
    before, after = drive(), drive(SIDES + tag)
    assert vars(after) == vars(before) | changed


@pytest.mark.parametrize(
    ("file", "tag", "begins_in_world"),
    [
        ("libgazebo_ros_diff_drive.so", "", True),
        ("libgazebo_ros_skid_steer_drive.so", "", True),
        ("libgazebo_ros_diff_drive.so", "<odometry_source>0</odometry_source>", False),
        ("libgazebo_ros_diff_drive.so", "<odometrySource>encoder</odometrySource>", False),
        ("gz-sim-diff-drive-system", "", False),
    ],
)
def test_gazebo_classic_begins_in_the_world_where_no_source_is_named(
    file: str, tag: str, begins_in_world: bool
) -> None:
    assert drive(SIDES + tag, file=file).begins_in_world == begins_in_world


@pytest.mark.parametrize(
    ("tag", "noted"),
    [
        ("<wheel_separation>0.52</wheel_separation>", ""),  # 4 % off
        ("<wheel_separation>0.48</wheel_separation>", ""),
        ("<wheel_separation>0.53</wheel_separation>", "wheel_separation is 0.53, but the wheels"),
        ("<wheel_separation>0.47</wheel_separation>", "wheel_separation is 0.47, but the wheels"),
        ("<wheel_radius>0.104</wheel_radius>", ""),
        ("<wheel_radius>0.106</wheel_radius>", "wheel radius is 0.106, but the wheels have 0.1:"),
        ("<wheel_radius>0.2</wheel_radius><effective_track_width>1</effective_track_width>", ""),
        ("<wheel_radius>0.2</wheel_radius><effective_wheel_radius>1</effective_wheel_radius>", ""),
    ],
)
def test_what_contradicts_the_wheels_by_a_twentieth_is_noted(tag: str, noted: str) -> None:
    found, notes = read(SIDES + tag)
    assert found is not None
    assert ["it drives by that" in note and noted in note for note in notes] == [True] * bool(noted)
    if "effective" not in tag:
        assert (found.effective_track, found.effective_radius) == pytest.approx((0.5, 0.1))


@pytest.mark.parametrize(
    ("file", "tags", "noted"),
    [
        ("gz-sim-diff-drive-system", "<wheel_diameter>0.2</wheel_diameter>", ["1", "0.2"]),
        ("gz-sim-diff-drive-system", "<wheel_separation>0.5</wheel_separation>", ["0.2"]),
        ("libignition-gazebo-diff-drive-system.so", "<wheelRadius>0.1</wheelRadius>", ["1"]),
        ("libgazebo_ros_diff_drive.so", "", []),
    ],
)
def test_what_gazebo_assumes_for_a_tag_that_lacks_is_noted(
    file: str, tags: str, noted: list[str]
) -> None:
    notes = [note for note in read(SIDES + tags, file=file)[1] if "without <wheel_" in note]
    assert [note.partition("Gazebo takes ")[2].partition(",")[0] for note in notes] == noted


def test_what_is_not_simulated_is_noted_once() -> None:
    extra = "<wibble>1</wibble><aaa/><wibble>2</wibble><legacyMode>1</legacyMode>"
    assert read(SIDES + extra)[1] == ("plugin 'p': not simulated: <aaa>, <wibble>",)
    assert read(SIDES + "<aaa/>", name="")[1] == ("plugin 'f.so': not simulated: <aaa>",)
    least = "<max_wibble>1</max_wibble><min_wibble>{}</min_wibble>"
    for other, tags in (("-1.0", ""), ("-2", ", <min_wibble>"), ("much", ", <min_wibble>")):
        noted = (f"plugin 'p': not simulated: <max_wibble>{tags}",)
        assert read(SIDES + least.format(other))[1] == noted


def test_motors_whose_file_names_no_torque_pull_twice_the_weight_but_five_at_least() -> None:
    heavy = wheeled(POSITIONS, base=weight(100.0))
    assert torque_of(heavy, 0.1, 2) == pytest.approx(2.0 * 9.81 * 100.0 * 0.1 / 2)
    assert torque_of(heavy, 0.1, 40) == 5.0
    assert drive(mass=100.0).torque == pytest.approx(98.1)


@pytest.mark.parametrize(
    ("kind", "source", "from_world"),
    [
        (DriveKind.PLANAR, "encoder", True),
        (DriveKind.SIDES, "encoder", False),
        (DriveKind.SIDES, "world", True),
    ],
)
def test_planar_drives_have_true_odometry(kind: DriveKind, source: str, from_world: bool) -> None:
    inside = f"<odometrySource>{source}</odometrySource><odometryFrame>o</odometryFrame>"
    xml = urdf_file(f"<plugin name='p'>{inside}</plugin>")
    found = read_wheelless(xml, xml.child(xml.root, "plugin", "r"), kind)
    assert found == DriveSettings(
        *((), (), 1.0, 1.0, 5.0, 1.0, 1.0),
        plugin="p",
        odometry_frame="o",
        from_world=from_world,
    )


@pytest.mark.parametrize(
    ("file", "torque"),
    [
        ("libgazebo_ros_diff_drive.so", 5.0),  # reads <wheelTorque> alone
        ("libgazebo_ros_skid_steer_drive.so", 0.1),
    ],
)
def test_a_drive_of_two_sides_reads_no_plain_torque(file: str, torque: float) -> None:
    found, notes = read(SIDES + "<torque>0.1</torque>", file=file)
    assert found is not None
    assert found.torque == torque
    assert notes == ()
