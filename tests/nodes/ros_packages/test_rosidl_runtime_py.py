"""Messages by the names of their types, as scripts that read recordings use them."""

from __future__ import annotations

from collections import OrderedDict

import pytest
from geometry_msgs.msg import PoseArray, PoseStamped, Twist
from rosidl_runtime_py import (
    get_interface_path,
    get_message_interfaces,
    message_to_csv,
    message_to_ordereddict,
    message_to_yaml,
    set_message_fields,
)
from rosidl_runtime_py.utilities import (
    get_action,
    get_interface,
    get_message,
    get_service,
    is_action,
    is_message,
    is_service,
)


def test_interfaces_are_found_by_their_types_names() -> None:
    assert get_message("geometry_msgs/msg/Twist") is Twist
    assert is_message(get_interface("nav_msgs/msg/Odometry"))
    assert is_message(get_message("nav2_msgs/action/Wait_FeedbackMessage"))
    assert is_service(get_service("std_srvs/srv/SetBool"))
    assert is_action(get_action("nav2_msgs/action/NavigateToPose"))
    assert "msg/Twist" in get_message_interfaces(["geometry_msgs"])["geometry_msgs"]
    assert get_interface_path("geometry_msgs/msg/Twist").endswith("/geometry_msgs/msg/Twist.msg")
    with pytest.raises(ValueError, match="'geometry_msgs/msg/Twst' is no such interface; valid: "):
        get_message("geometry_msgs/msg/Twst")


def test_a_message_is_filled_and_written() -> None:
    message = Twist()
    set_message_fields(message, {"linear": {"x": 1.5}})
    values = message_to_ordereddict(message)
    assert isinstance(values["linear"], OrderedDict)
    assert values["linear"]["x"] == message.linear.x == 1.5
    assert message_to_yaml(message).startswith("linear:\n  x: 1.5\n")
    assert message_to_csv(message) == "1.5,0.0,0.0,0.0,0.0,0.0"
    poses = message_to_ordereddict(PoseArray(poses=[PoseStamped().pose]))["poses"]
    assert poses[0]["orientation"]["w"] == 1.0


@pytest.mark.parametrize(
    ("values", "error"),
    [({"linaer": {"x": 1.0}}, AttributeError), ({"linear": {"x": "fast"}}, ValueError)],
)
def test_what_does_not_fit_is_refused(values: dict[str, object], error: type[Exception]) -> None:
    with pytest.raises(error, match=r"linaer|fast"):
        set_message_fields(Twist(), values)
