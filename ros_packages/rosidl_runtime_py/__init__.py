"""ROS 2's `rosidl_runtime_py`: messages by the names of their types, as values, and filled."""

from rosidl_runtime_py.convert import (
    message_to_csv,
    message_to_ordereddict,
    message_to_yaml,
)
from rosidl_runtime_py.set_message import set_message_fields
from rosidl_runtime_py.utilities import (
    get_action_interfaces,
    get_interface_path,
    get_interfaces,
    get_message_interfaces,
    get_service_interfaces,
)
