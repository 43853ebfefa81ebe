"""Calls of `gz` as tutorials write them, by the commands that do the same here."""

from __future__ import annotations

import pytest

from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.gz_tools import command_of, read_message

pytestmark = pytest.mark.ros
CREATE = (
    "ign service -s /world/default/create --reqtype ignition.msgs.EntityFactory"
    " --reptype ignition.msgs.Boolean --timeout 1000"
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", {}),
        ('sdf_filename: "/a b/c.sdf", name: "x"', {"sdf_filename": "/a b/c.sdf", "name": "x"}),
        ("linear: {x: 0.5}, angular: {z: -1e-1}", {"linear": {"x": 0.5}, "angular": {"z": -0.1}}),
        ("pose { position { x: 1 y: 2 } }", {"pose": {"position": {"x": 1, "y": 2}}}),
        ("pause: true; n: 3", {"pause": True, "n": 3}),
        ("data: 'a: {b}'", {"data": "a: {b}"}),
    ],
)
def test_messages_are_in_the_text_format(text: str, message: dict[str, object]) -> None:
    assert read_message(text) == message


@pytest.mark.parametrize("text", ["x: {y: 1", "{", "x:", "x: }"])
def test_what_is_in_no_such_format_is_refused(text: str) -> None:
    with pytest.raises(Ros2Error, match="a message"):
        read_message(text)


@pytest.mark.parametrize(
    ("call", "request_", "command"),
    [
        (
            CREATE,
            'sdf_filename: "/r.sdf", name: "r", pose: {position: {z: 0.2}}',
            "create -name r -file /r.sdf -x 0 -y 0 -z 0.2 -Y 0",
        ),
        (
            "gz service -s /world/w/set_pose",
            'name: "box", position: {x: 1}, orientation: {z: 1}',
            "entity move box 1 0 --z 0 --heading 3.14159",
        ),
        ("gz service -s /world/w/remove", 'name: "box" type: MODEL', "entity delete box"),
        ("gz service -s /world/w/control", "pause: false", "world play"),
        ("gz service -s /world/w/control", "multi_step: 5", "world step 5"),
        ("gz service -s /world/w/control", "reset: {all: true}", "world reset"),
        ("gz service -l", "", "ros2 service list"),
        ("gz topic -l", "", "ros2 topic list"),
        ("gz topic -e -t /odom -n 1", "", "ros2 topic echo /odom --once"),
        ("gz topic -i -t /odom", "", "ros2 topic info /odom"),
        ("gz model --list", "", "entity list"),
    ],
)
def test_a_call_is_the_command_that_does_the_same(call: str, request_: str, command: str) -> None:
    program, words = command_of([*call.split()[1:], "--req", request_])
    assert [program, *words] == command.split()


def test_a_topic_is_published_once() -> None:
    text = "linear: {x: 0.5}, angular: {z: 0.05}"
    program, words = command_of(["topic", "-t", "/cmd_vel", "-m", "gz.msgs.Twist", "-p", text])
    assert (program, words[:3]) == ("ros2", ["topic", "pub", "--once"])
    assert words[3:5] == ["/cmd_vel", "geometry_msgs/msg/Twist"]
    assert words[5] == '{"linear": {"x": 0.5}, "angular": {"z": 0.05}}'


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        ("service -s /world/w/light_config", "no service 'light_config' of Gazebo's is here"),
        ("service -s /world/w/create --req pose:1", "the request is none of 'create': pose:1"),
        ("service -s /world/w/control --req multi_step:no", "the request is none of 'control'"),
        ("topic -t /x -m gz.msgs.Pose -p x", "'gz topic' publishes no 'gz.msgs.Pose' here"),
        ("sdf -p model.sdf", "'gz sdf' asks Gazebo itself"),
    ],
)
def test_what_nothing_here_does_is_refused(call: str, reason: str) -> None:
    with pytest.raises(Ros2Error, match=reason):
        command_of(call.split())
