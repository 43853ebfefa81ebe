"""Messages filled from values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bringup.ros2.errors import Ros2Error
from bringup.ros2.values import fill

__all__ = ["set_message_fields"]


def set_message_fields(
    msg: Any,
    values: dict[str, Any],
    expand_header_auto: bool = False,
    expand_time_now: bool = False,
) -> list[Callable[[Any], None]]:
    """Set a message's fields; return what sets the stamps that are given as `now` or `auto`.

    Raises:
        AttributeError: There is no such field.
        TypeError: A value has another type; or ValueError.
    """
    try:
        return fill(msg, values)
    except Ros2Error as error:
        raise (error.__cause__ or error) from error
