"""One parameter: its default, bounds, unit and text, in a field of a frozen dataclass."""

from __future__ import annotations

import dataclasses
import keyword
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

_KEY = "arjuna"
_CODED_START = "_·"
_CODED = re.compile("·([0-9a-f]+)·")
SEED_MAX = 2**63 - 1
"""The greatest number that a ROS parameter can hold."""
_GREATEST = {"s": 1e9, "ms": 1e9}
_GREATEST_OF_ANY = 1e6
"""Far more than a robot's metres or counts, and no number that breaks arithmetic."""


@dataclass(frozen=True)
class ParamInfo:
    """A parameter's unit, bounds and description, beside its name, type and default.

    Attributes:
        unit: SI unit, or "" for none.
        minimum: Least valid value, inclusive.
        maximum: Greatest valid value, inclusive.
        choices: The valid values where only some are.
        read_only: Whether it is fixed once the component runs.
        path: Whether it is a path; those are read only, or clients could move folders.
        plugins: Of plug-ins' names: the `PluginTypes` or `NamedConfigs` that they are of.
        class_of: Of a class's name: the `PluginTypes` that it is of.
        of_robot: Which of the robot's own names it is, `scan_topic` or `cmd_vel_topic`; "" for
            none.
        theirs: The value with the behaviour of Nav2 or slam_toolbox, where another one is the
            default or is shipped.
    """

    description: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[Any, ...] = ()
    read_only: bool = False
    path: bool = False
    plugins: Any = None
    class_of: Any = None
    of_robot: str = ""
    theirs: Any = None

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest valid number; what names none has those of its unit."""
        greatest = _GREATEST.get(self.unit, _GREATEST_OF_ANY)
        low = -greatest if self.minimum is None else self.minimum
        return low, greatest if self.maximum is None else self.maximum


def param(
    default: Any,
    description: str,
    *,
    unit: str = "",
    minimum: float | None = None,
    maximum: float | None = None,
    choices: Sequence[Any] = (),
    read_only: bool = False,
    path: bool = False,
    class_of: Any = None,
    of_robot: str = "",
    theirs: Any = None,
) -> Any:
    """Declare one parameter as a field of a frozen dataclass.

    Args:
        description: One sentence for `--help`, docs and ROS descriptors.
        unit: SI unit.
        path: Whether it is a path of this machine; no client may change it.
        class_of: The `PluginTypes` of which it names the class.
        of_robot: Which of the robot's own names it is, which an option sets wherever it is.
        theirs: The value with the behaviour of Nav2 or slam_toolbox, which `--as-nav2` and
            `--as-slam-toolbox` set; None where there is no other.
    """
    fixed = read_only or path
    more = {"class_of": class_of, "of_robot": of_robot, "theirs": theirs}
    valid = tuple(choices)
    info = ParamInfo(description, unit, minimum, maximum, valid, fixed, path, **more)
    return dataclasses.field(default=default, metadata={_KEY: info})


def fixed(default: Any, description: str, **more: Any) -> Any:
    """Declare a parameter that holds from the start on: a topic, a frame, a kind."""
    return param(default, description, read_only=True, **more)


def length_param(default: Any, description: str, *, minimum: float = 0.0, **more: Any) -> Any:
    """Declare a length, as metres."""
    return param(default, description, unit="m", minimum=minimum, **more)


def duration_param(default: Any, description: str, *, minimum: float = 0.0, **more: Any) -> Any:
    """Declare a time span, as seconds."""
    return param(default, description, unit="s", minimum=minimum, **more)


def angle_param(default: Any, description: str, *, minimum: float = 0.0, **more: Any) -> Any:
    """Declare the size of an angle, as radians."""
    return param(default, description, unit="rad", minimum=minimum, **more)


def speed_param(default: Any, description: str, *, minimum: float = 0.0, **more: Any) -> Any:
    """Declare a speed, as metres a second."""
    return param(default, description, unit="m/s", minimum=minimum, **more)


def yaw_rate_param(default: Any, description: str, *, minimum: float = 0.0, **more: Any) -> Any:
    """Declare the size of a yaw rate, as radians a second."""
    return param(default, description, unit="rad/s", minimum=minimum, **more)


def share_param(default: Any, description: str, **more: Any) -> Any:
    """Declare a share or a probability, from 0 to 1."""
    return param(default, description, minimum=0.0, maximum=1.0, **more)


def plugin_names(default: tuple[str, ...] | str, description: str, types: Any) -> Any:
    """Declare the names of plug-ins, a list or a text; the parameters of each stand below its name.

    `arjuna_core.config.load` returns a config that has a field for each of them.

    Args:
        default: The default names, in a text with spaces between them.
        types: The `PluginTypes` that they may be of, or the `NamedConfigs` that they have.
    """
    info = ParamInfo(description, read_only=True, plugins=types)
    return dataclasses.field(default=default, metadata={_KEY: info})


def info_of(field: dataclasses.Field[Any]) -> ParamInfo:
    """Return a field's parameter information."""
    info: ParamInfo = field.metadata[_KEY]
    return info


def key_of(field: dataclasses.Field[Any]) -> str:
    """Return a field's parameter name, of which `field_of` made the field's."""
    name = field.name.removesuffix("_")
    return _CODED.sub(lambda each: chr(int(each[1], 16)), name.removeprefix(_CODED_START))


def field_of(key: str) -> str:
    """Return the name of the field of a parameter's name, which may be no name in Python.

    One that Python keeps for itself ends in `_`; letters that it does not allow are their codes.
    """
    if key.startswith(_CODED_START):
        return key
    if key.isascii() and key.isidentifier():
        return f"{key}_" if keyword.iskeyword(key) else key
    return _CODED_START + re.sub(r"[^A-Za-z0-9_]", lambda c: f"·{ord(c[0]):x}·", key)
