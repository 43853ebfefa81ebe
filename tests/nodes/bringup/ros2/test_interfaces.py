"""`ros2 interface` and `pkg`; messages as YAML and CSV."""

from __future__ import annotations

from pathlib import Path

import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Pose, PoseArray, PoseWithCovariance, Twist
from sensor_msgs.msg import CompressedImage, JointState, LaserScan
from std_msgs.msg import String

from bringup.recording.message_definitions import nested_type
from bringup.ros2.errors import Ros2Error
from bringup.ros2.main import main
from bringup.ros2.types import bare
from bringup.ros2.values import Abridge, fill, parse, to_csv, to_yaml


def output(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(words) == 0
    return capsys.readouterr().out


def test_show_indents_nested_types_without_comments(capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys, "interface", "show", "geometry_msgs/msg/PoseStamped") == (
        "# A Pose with reference coordinate frame and timestamp\n\n"
        "std_msgs/Header header\n\tbuiltin_interfaces/Time stamp\n\t\tint32 sec\n"
        "\t\tuint32 nanosec\n\tstring frame_id\nPose pose\n\tPoint position\n\t\tfloat64 x\n"
        "\t\tfloat64 y\n\t\tfloat64 z\n\tQuaternion orientation\n\t\tfloat64 x 0\n"
        "\t\tfloat64 y 0\n\t\tfloat64 z 0\n\t\tfloat64 w 1\n"
    )


def test_show_without_comments(capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys, "interface", "show", "std_srvs/srv/SetBool", "--no-comments") == (
        "bool data #\n---\nbool success   #\nstring message #\n"
    )


def test_show_all_comments_has_nested_ones(capsys: pytest.CaptureFixture[str]) -> None:
    text = output(capsys, "interface", "show", "geometry_msgs/msg/Twist", "--all-comments")
    assert "\t# This represents a vector in free space.\n" in text


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        ("Point position", "geometry_msgs/msg/Point"),
        ("std_msgs/Header header", "std_msgs/msg/Header"),
        ("std_msgs/msg/Header header", "std_msgs/msg/Header"),
        ("Point32[<=4] points", "geometry_msgs/msg/Point32"),
        ("Pose[] poses", "geometry_msgs/msg/Pose"),
        ("float64 x 0", None),
        ("string<=10 name", None),
        ("uint8 ADD=0", None),
        ("---", None),
        ("", None),
    ],
)
def test_only_fields_of_messages_are_nested(code: str, expected: str | None) -> None:
    assert nested_type(code, "geometry_msgs") == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("float64 x", "float64 x"),
        ("float64 x  # along", "float64 x  #"),
        ("float64 x #along", "float64 x"),
        ("float64 x # [m]", "float64 x # [m]"),
        ("uint8 A = 1  # the first", "uint8 A = 1  # the first"),
        ("# about it", None),
        ("#", "#"),
        ("   # more of it", "   # more of it"),
        ("", None),
        ("---", "---"),
    ],
)
def test_comments_go_as_far_as_ros2cli_finds_them(line: str, expected: str | None) -> None:
    assert bare(line) == expected


def test_interfaces_of_every_kind_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    names = output(capsys, "interface", "list").split()
    names = [name for name in names if "/" in name]
    assert len(names) > 200
    for name in names[::8]:
        assert main(["interface", "show", name]) == 0, name


def test_proto_is_yaml_in_quotes(capsys: pytest.CaptureFixture[str]) -> None:
    assert output(capsys, "interface", "proto", "std_srvs/srv/SetBool") == '"data: false\n"\n'
    assert output(capsys, "interface", "proto", "--no-quotes", "std_msgs/msg/String") == (
        "data: ''\n\n"
    )


def test_lists_are_by_kind(capsys: pytest.CaptureFixture[str]) -> None:
    actions = output(capsys, "interface", "list", "-a").splitlines()
    assert actions[0] == "Actions:"
    assert "    nav2_msgs/action/NavigateToPose" in actions
    assert output(capsys, "interface", "package", "std_srvs") == (
        "std_srvs/srv/Empty\nstd_srvs/srv/SetBool\nstd_srvs/srv/Trigger\n"
    )
    packages = output(capsys, "interface", "packages", "-a").split()
    assert "nav2_msgs" in packages
    assert "std_srvs" not in packages


def test_packages_and_their_manifests(capsys: pytest.CaptureFixture[str]) -> None:
    assert {"rclpy", "tf2_ros", "nav2_msgs"} <= set(output(capsys, "pkg", "list").split())
    assert output(capsys, "pkg", "xml", "std_srvs", "-t", "name") == "std_srvs\n"
    assert output(capsys, "pkg", "executables", "tf2_tools") == "tf2_tools view_frames\n"
    path = Path(output(capsys, "pkg", "executables", "--full-path", "tf2_tools").strip())
    assert (path.is_file(), path.parts[-2:]) == (True, ("tf2_tools", "view_frames"))


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("interface show std_msgs/msg/Nope", "Could not find the interface 'std_msgs/msg/Nope'\n"),
        (
            "interface show std_msgs/String",
            "Invalid name 'std_msgs/String'. Expected three parts separated by '/'\n",
        ),
        ("interface show nope/msg/Nope", "Unknown package 'nope'\n"),
        ("interface package nope", "Unknown package 'nope'\n"),
        ("pkg prefix nope", "Package not found\n"),
        ("pkg executables nope", "Package 'nope' not found\n"),
        ("pkg xml std_srvs -t nope", "XML tag not found\n"),
    ],
)
def test_what_is_not_there_is_said(
    words: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words.split()) == 1
    assert capsys.readouterr() == ("", problem)


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
