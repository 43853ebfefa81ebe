"""The requests and answers of trees as nav2_msgs' messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geometry_msgs.msg import Point
from nav2_msgs import action, srv
from std_srvs.srv import Empty

from arjuna_core.ros.convert import duration_msg, path_msg, pose_stamped, poses_from_path, seconds
from arjuna_core.se2 import SE2
from arjuna_nav.trees.exchange import Answer

_POSE = "geometry_msgs/PoseStamped"
_PATH = "nav_msgs/Path"
_DURATION = "builtin_interfaces/Duration"
_ROUTE = "nav2_msgs/Route"


def action_type(kind: str) -> Any | None:
    """Return an action type by its name, None where that is no action."""
    return getattr(action, kind, None)


def service_type(kind: str) -> Any:
    """Return a service type by its name."""
    return Empty if kind == "Empty" else getattr(srv, kind)


def request_msg(message: type[Any], values: Mapping[str, Any], frame: str, now: float) -> Any:
    """Return a goal or a request of plain values, each by its field's type."""
    types = message.get_fields_and_field_types()
    return message(**{k: _field(types[k], value, frame, now) for k, value in values.items()})


def filled(message: type[Any], values: Mapping[str, Any], frame: str = "", now: float = 0.0) -> Any:
    """Return a message as `request_msg` does, of those of the values that it has a field for."""
    known = message.get_fields_and_field_types()
    return request_msg(message, {k: values[k] for k in values if k in known}, frame, now)


def _field(kind: str, value: Any, frame: str, now: float) -> Any:
    if kind == _POSE:
        return pose_stamped(value, frame, now)
    if kind == f"sequence<{_POSE}>":
        return [pose_stamped(each, frame, now) for each in value]
    if kind == _PATH:
        return path_msg(value, frame, now)
    if kind == _DURATION:
        return duration_msg(value)
    if kind == "geometry_msgs/Point":
        return Point(x=float(value))
    return value


def answer_of(result: Any, succeeded: bool) -> Answer:
    """Return an action's result in plain values; a path without poses is a failure."""
    values = plain_values(result)
    code, message = values.pop("error_code", 0), values.pop("error_msg", "")
    if succeeded and "path" in values and not len(values["path"]):
        succeeded, code, message = False, code or unknown_code(result), "the path has 0 poses"
    if not succeeded:
        values.pop("path", None)
        code = code or unknown_code(result)
    return Answer(succeeded, int(code), str(message), values)


def plain_values(message: Any) -> dict[str, Any]:
    """Return a result's or a feedback's fields in plain values; a route as its nodes' poses."""
    values: dict[str, Any] = {}
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if kind == _PATH:
            values[name] = poses_from_path(value)
        elif kind == _DURATION:
            values[name] = seconds(value)
        elif kind == _ROUTE:
            values[name] = tuple(SE2(n.position.x, n.position.y) for n in value.nodes)
        elif isinstance(value, (bool, int, float, str)):
            values[name] = value
    return values


def unknown_code(result: Any) -> int:
    """Return the error code of an unknown failure of an action, 0 where it has none."""
    return int(getattr(result, "UNKNOWN", 0))
