"""Messages as YAML and CSV, and filled from YAML."""

from __future__ import annotations

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Pose, PoseArray, PoseWithCovariance, Twist
from sensor_msgs.msg import CompressedImage, JointState, LaserScan
from std_msgs.msg import String

from bringup.ros2.errors import Ros2Error
from bringup.ros2.values import Abridge, fill, parse, to_csv, to_yaml


def test_fields_keep_their_order() -> None:
    scan = LaserScan(range_min=0.5, ranges=[1.0, float("inf"), float("nan")])
    assert to_yaml(scan).splitlines()[:4] == ["header:", "  stamp:", "    sec: 0", "    nanosec: 0"]
    assert to_yaml(scan).endswith("ranges:\n- 1.0\n- .inf\n- .nan\nintensities: []\n")


@pytest.mark.parametrize(
    ("abridge", "line"),
    [
        (Abridge(), "data: abcdefg"),
        (Abridge(length=7), "data: abcdefg"),
        (Abridge(length=3), "data: abc..."),
        (Abridge(no_strings=True), "data: '<string length: <7>>'"),
    ],
)
def test_strings_are_cut(abridge: Abridge, line: str) -> None:
    assert to_yaml(String(data="abcdefg"), abridge) == f"{line}\n"


def test_arrays_are_cut_or_described() -> None:
    state = JointState(position=[1.0, 2.0, 3.0])
    assert "position:\n- 1.0\n- 2.0\n- '...'\n" in to_yaml(state, Abridge(length=2))
    described = to_yaml(state, Abridge(no_arrays=True))
    assert "position: '<sequence type: double, length: 3>'\n" in described
    assert "name: '<sequence type: string, length: 0>'\n" in described
    fixed = to_yaml(PoseWithCovariance(), Abridge(no_arrays=True))
    assert "covariance: '<array type: double[36]>'\n" in fixed


def test_csv_is_one_line_of_all_values() -> None:
    state = JointState(name=["a", "b"], position=[1.5, 2.0])
    assert to_csv(state) == "0,0,,a,b,1.5,2.0,,"
    assert to_csv(state, Abridge(length=1)) == "0,0,,a,...,1.5,...,,"
    assert to_csv(String()) == ""
    assert to_csv(DiagnosticStatus(level=b"\2", name="n")) == "b'\\x02',n,,,"


def test_lists_alone_stand_on_one_line() -> None:
    state = JointState(name=["a", "b"])
    assert to_yaml(state, flow=True) == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n"
        "name: [a, b]\nposition: []\nvelocity: []\neffort: []\n"
    )
    poses = PoseArray(poses=[Pose()])
    assert "\nposes: [{position: {x: 0.0, y: 0.0, z: 0.0}, orientation: {" in to_yaml(
        poses, flow=True
    )


@pytest.mark.parametrize(
    ("text", "line"), [("\U0001f600", "\U0001f600"), ("\x85", "'\x85  '"), ("\x07", '"\\a"')]
)
def test_odd_characters_are_written_as_ros2cli_does(text: str, line: str) -> None:
    assert to_yaml(String(data=text)) == f"data: {line}\n"


def test_nested_fields_are_set_and_numbers_converted() -> None:
    twist = Twist()
    fill(twist, parse("{linear: {x: 1, y: 2.5}}"))
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (1.0, 2.5, 0.0)


def test_arrays_of_numbers_bytes_and_messages_are_set() -> None:
    scan, poses, image = LaserScan(), PoseArray(), CompressedImage()
    fill(scan, parse("{ranges: [1, 2.5, .inf]}"))
    fill(poses, parse("{poses: [{position: {x: 1}}, {orientation: {w: 0.5}}]}"))
    fill(image, parse("{format: png, data: [1, 2]}"))
    assert list(scan.ranges) == [1.0, 2.5, float("inf")]
    assert [pose.position.x for pose in poses.poses] == [1.0, 0.0]
    assert poses.poses[1].orientation.w == 0.5
    assert bytes(image.data) == b"\x01\x02"


def test_now_and_auto_are_filled_in_later() -> None:
    state = JointState()
    (stamp,) = fill(state, parse("{header: auto}"))
    stamp(Time(sec=7))
    assert state.header.stamp.sec == 7
    (stamp,) = fill(state, parse("{header: {stamp: now}}"))
    stamp(Time(sec=8))
    assert state.header.stamp.sec == 8


def test_yaml_comes_back_as_the_message() -> None:
    before = JointState(name=["left"], position=[0.25])
    after = JointState()
    fill(after, parse(to_yaml(before)))
    assert after == before


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{linear: 3}", "Value '3' is expected to be a dictionary but is a int"),
        ("{linear: {x: fast}}", "could not convert string to float"),
        ("{linear: {x: [1]}}", r"Value '\[1\]' is expected to be a dictionary but is a list"),
        ("{speed: 1}", "object has no attribute 'speed'"),
        ("[1, 2]", "is expected to be a dictionary but is a list"),
        ("{a: [", "is no YAML"),
    ],
)
def test_what_does_not_fit_is_refused(text: str, problem: str) -> None:
    with pytest.raises(Ros2Error, match=problem):
        fill(Twist(), parse(text))
