"""`ros2 interface` and `ros2 pkg`: what is installed, without a graph."""

from __future__ import annotations

import pytest

from bringup.recording.message_definitions import nested_type
from bringup.ros2.main import main
from bringup.ros2.types import bare


def output(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(words) == 0
    return capsys.readouterr().out


def test_show_indents_nested_types_without_their_comments(
    capsys: pytest.CaptureFixture[str],
) -> None:
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


def test_show_with_all_comments_has_those_of_nested_types(
    capsys: pytest.CaptureFixture[str],
) -> None:
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


def test_installed_interfaces_of_every_kind_can_be_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
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
