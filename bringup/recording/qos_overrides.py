"""Profiles of topics from a file, as `--qos-profile-overrides-path` names one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    InvalidQoSProfileException,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from arjuna_core.errors import InputFileError, nearest
from arjuna_core.files.yaml_file import read_yaml

POLICIES = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}
_WRONG = (InvalidQoSProfileException, ValueError, TypeError, AttributeError, OverflowError)
_DURATIONS = ("deadline", "lifespan", "liveliness_lease_duration")
_VALUES: dict[str, type[int]] = {"depth": int, "avoid_ros_namespace_conventions": bool}


def read_overrides(path: Path) -> dict[str, QoSProfile]:
    """Return the profile of each topic in a file.

    Raises:
        InputFileError: It is no file of profiles.
    """
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise InputFileError(path, "holds no profiles; valid: '/topic: {reliability: reliable}'")
    found = {}
    for topic, profile in content.items():
        try:
            parts = {name: _part(name, value) for name, value in profile.items()}
            found[str(topic)] = QoSProfile(**parts)
        except _WRONG as error:
            raise InputFileError(path, str(error), str(topic)) from error
    return found


def _part(name: str, value: Any) -> Any:
    if name in POLICIES:
        policy = POLICIES[name]
        if value not in policy.short_keys():
            raise ValueError(f"'{value}' is no {name}; {nearest(str(value), policy.short_keys())}")
        return policy.get_from_short_key(value)
    if name in _DURATIONS:
        return _duration(name, value)
    if name not in _VALUES:
        valid = nearest(name, (*POLICIES, *_DURATIONS, *_VALUES))
        raise ValueError(f"unexpected key '{name}'; {valid}")
    if type(value) is not _VALUES[name]:
        raise TypeError(f"{name} is {value!r}, which is no {_VALUES[name].__name__}")
    if value < 0:
        raise ValueError(f"{name} is {value}; it may not be negative")
    return value


def _duration(name: str, value: Any) -> Duration:
    if not value:
        return Duration()
    if not isinstance(value, dict) or not {"sec", "nsec"} <= value.keys():
        raise ValueError("Time overrides must include both seconds (sec) and nanoseconds (nsec).")
    if min(value["sec"], value["nsec"]) < 0:
        raise ValueError(f"{name} may not be negative")
    return Duration(seconds=value["sec"], nanoseconds=value["nsec"])
