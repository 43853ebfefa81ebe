"""Messages as values, YAML and CSV."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

from bringup.ros2.values import Abridge, to_csv, to_plain, to_yaml

__all__ = ["message_to_csv", "message_to_ordereddict", "message_to_yaml"]


def message_to_ordereddict(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> OrderedDict[str, Any]:
    """Return a message's values by the names of its fields, messages in it likewise."""
    return _ordered(to_plain(msg, Abridge(truncate_length, no_arr, no_str)))


def _ordered(values: dict[str, Any]) -> OrderedDict[str, Any]:
    def plain(value: Any) -> Any:
        if isinstance(value, list):
            return [plain(each) for each in value]
        return _ordered(value) if isinstance(value, dict) else value

    return OrderedDict((name, plain(value)) for name, value in values.items())


def message_to_yaml(
    msg: Any,
    *,
    truncate_length: int | None = None,
    no_arr: bool = False,
    no_str: bool = False,
    flow_style: bool = False,
) -> str:
    return to_yaml(msg, Abridge(truncate_length, no_arr, no_str), flow_style)


def message_to_csv(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> str:
    return to_csv(msg, Abridge(truncate_length, no_arr, no_str))
