"""Claims: a definition is complete, so that a reader needs none of its own."""

from __future__ import annotations

from nav2_msgs.action import NavigateToPose
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bringup.recording.message_definitions import message_definition, type_hash

FEEDBACK = "nav2_msgs/action/NavigateToPose_FeedbackMessage"


def test_a_definition_carries_every_type_it_needs_once() -> None:
    text = message_definition("nav_msgs/msg/OccupancyGrid")
    named = [line[5:] for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(named) == [
        "builtin_interfaces/Time",
        "geometry_msgs/Point",
        "geometry_msgs/Pose",
        "geometry_msgs/Quaternion",
        "nav_msgs/MapMetaData",
        "std_msgs/Header",
    ]


def test_the_feedback_of_an_action_can_be_read_by_its_definition() -> None:
    message = NavigateToPose.Impl.FeedbackMessage()
    message.feedback.distance_remaining = 3.5
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(message_definition(FEEDBACK), FEEDBACK))
    read = store.deserialize_cdr(serialize_message(message), FEEDBACK)
    assert read.feedback.distance_remaining == 3.5  # type: ignore[attr-defined]
    assert type_hash(FEEDBACK).startswith("RIHS01_")
