"""The displays' common part: the messages they take, their settings, and where they are found."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar

import numpy as np

from arjuna_core.errors import ConfigError
from arjuna_core.param import info_of
from arjuna_core.plugins import PluginTypes
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.values import Colour, Colours, Parts

_HERE = "bringup.viewing.displays"
DISPLAYS = PluginTypes(
    "display",
    {
        name: f"{_HERE}.{module}:{name}"
        for module, names in {
            "robot": "RobotModel TF Axes People",
            "map": "Map GridCells",
            "clouds": "LaserScan PointCloud2 PointCloud DepthCloud",
            "poses": "Path Polygon Pose PoseArray ParticleCloud PoseWithCovariance Odometry",
            "markers": "Marker MarkerArray InteractiveMarkers",
            "sensors": "Range PointStamped Wrench TwistStamped AccelStamped Imu Temperature"
            " RelativeHumidity Illuminance FluidPressure",
            "panels": "Image Speed LocalizationQuality DistanceToGoal BehaviorTree",
        }.items()
        for name in names.split()
    },
    "",
)
"""The displays by RViz's names of their classes; `module:Class` of a user's own is another."""
PIXELS = 100.0
"""Pixels of the screen that stand for a metre, where RViz and a browser have not the same unit."""
ALL = "All Enabled"
"""Beside the frames of a TF display: the switch of all, which they themselves say too."""
SHOWN: dict[str, Any] = {"Namespaces": True, "Frames": {"Value": True}}
"""Properties with a switch for each of many names, and one that is on."""


@dataclass(frozen=True)
class DisplaySpec:
    """A display as a user has it.

    Attributes:
        kind: Its class, a name of `DISPLAYS` or `module:Class`.
        topic: Empty for the class's own.
        settings: Of its `Config`, by field; what is not given has its default.
        rviz: What a file of RViz said of it, to be saved again.
    """

    kind: str
    name: str
    topic: str = ""
    shown: bool = True
    settings: Mapping[str, Any] = field(default_factory=dict)
    anywhere: bool = False
    rviz: Mapping[str, Any] = field(default_factory=dict)

    def make(self) -> Display:
        """Return the display.

        Raises:
            ConfigError: There is no such class.
        """
        cls: type[Display] = DISPLAYS.resolve(self.kind)
        if not (isinstance(cls, type) and issubclass(cls, Display)):
            raise ConfigError(f"'{self.kind}' is no display; valid: a class of Display")
        display = cls(cls.Config(**self.settings), self.topic or cls.topic)
        display.anywhere = self.anywhere
        return display


@dataclass
class Moment:
    """The robot's surroundings while the displays are drawn.

    Attributes:
        now: Time [s, monotonic].
        distance: Left to the goal [m].
        people: What the simulator says stands around the robot since the last call, or None.
    """

    now: float
    frames: Frames
    distance: float | None = None
    people: Parts | None = None


@dataclass(frozen=True)
class Wanted:
    """A topic that a display listens to; `every` where no message of it may be missed."""

    topic: str
    types: tuple[str, ...]
    every: bool = False


@dataclass(frozen=True)
class NoSettings:
    """The settings of a display that has none."""


class Display:
    """Makes drawings of messages; a plug-in overrides what it needs.

    Attributes:
        types: Messages that it takes, `package/msg/Name`.
        topic: The topic that they usually come on.
        latched: Whether they are published once, for whoever comes later.
        raw: Whether it takes them serialized.
        every: Whether no message may be missed.
        property: Where RViz writes its topic.
        anywhere: Whether another topic of its types will do while its own is silent.
    """

    types: ClassVar[tuple[str, ...]] = ()
    topic: ClassVar[str] = ""
    latched: ClassVar[bool] = False
    raw: ClassVar[bool] = False
    every: ClassVar[bool] = False
    property: ClassVar[str] = "Topic"
    anywhere: bool = False
    Config: ClassVar[type[Any]] = NoSettings

    def __init__(self, config: Any, topic: str) -> None:
        self.config = config
        self.name = topic

    def wanted(self) -> tuple[Wanted, ...]:
        """Return the topics to listen to."""
        return (Wanted(self.name, self.types, self.every),) if self.types else ()

    def take(self, message: Any) -> Parts | None:
        """Return what to draw in place of what was, or None to leave it.

        Raises:
            ValueError: The message makes no sense.
        """
        return None

    def tick(self, moment: Moment) -> Parts | None:
        """Return what to draw in place of what was, or None to leave it; called ten times a second.

        It is where a display that takes no messages draws, and where lifetimes end.
        """
        return None


@cache
def kinds_of(type_name: str) -> tuple[str, ...]:
    """Return the displays of a type of message."""
    return tuple(name for name in DISPLAYS.types if type_name in DISPLAYS.resolve(name).types)


def rviz_name(field_name: str) -> str:
    """Return RViz's name of a setting: `line_width` is "Line Width", `size_m` "Size (m)"."""
    words = field_name.split("_")
    unit = f" ({words.pop()})" if words[-1] == "m" else ""
    return " ".join(word.capitalize() for word in words) + unit


def settings_of(kind: str, properties: Mapping[str, Any]) -> dict[str, Any]:
    """Return a display's settings from RViz's properties; what does not fit is left out.

    Some are below its `Shape`. Points of a size in pixels are as wide as paths of it: 1 cm each.
    """
    found: dict[str, Any] = {}
    shape = properties.get("Shape")
    properties = {**(shape if isinstance(shape, Mapping) else {}), **properties}
    pixels = properties.get("Size (Pixels)")
    if properties.get("Style") == "Points" and isinstance(pixels, (int, float)):
        properties["Size (m)"] = pixels / PIXELS
    for each in dataclasses.fields(DISPLAYS.resolve(kind).Config):
        value = properties.get(rviz_name(each.name))
        if value is not None and (fitting := _fitted(value, each)) is not None:
            found[each.name] = fitting
    return found


def _fitted(value: Any, each: dataclasses.Field[Any]) -> Any:
    """Return a value as a field has it, within its bounds; None where it is none."""
    info, default = info_of(each), each.default
    if isinstance(value, Mapping):  # a switch with more below it, or namespaces with one each
        off = (False, {"Value": False})
        hidden = ";".join(str(key) for key, shown in value.items() if shown in off and key != ALL)
        value = value.get("Value", hidden)
    try:
        if isinstance(default, bool):
            return value if isinstance(value, bool) else str(value).lower() == "true"
        if isinstance(default, (int, float)):
            return type(default)(np.clip(float(value), *info.bounds))
        if isinstance(default, tuple):
            parts = str(value).split(";") if not isinstance(value, tuple) else value
            red, green, blue = (int(np.clip(float(part), 0, 255)) for part in parts)
            return red, green, blue
    except (ValueError, TypeError):
        return None
    if not info.choices:
        return str(value)
    return next((one for one in info.choices if one.lower() == str(value).lower()), None)


def properties_of(display: Display) -> dict[str, Any]:
    """Return a display's settings as RViz writes them."""
    found = {}
    for each in dataclasses.fields(display.config):
        value = getattr(display.config, each.name)
        name = rviz_name(each.name)
        if name in SHOWN:
            off = False if SHOWN[name] is True else {"Value": False}
            value = dict.fromkeys(filter(None, value.split(";")), off)
        found[name] = "; ".join(map(str, value)) if type(value) is tuple else value
    return found


def rainbow(values: Any, low: float | None = None, high: float | None = None) -> Colours:
    """Return colours `(N, 3) uint8` of numbers, red for the least to magenta, as RViz has it."""
    values = np.asarray(values, dtype=np.float32)
    finite = values[np.isfinite(values)]
    low = low if low is not None else float(finite.min(initial=np.inf))
    high = high if high is not None else float(finite.max(initial=-np.inf))
    share = np.clip((np.nan_to_num(values) - low) / max(high - low, 1e-6), 0.0, 1.0)
    turn = share * np.float32(5.0)
    hues = np.abs((turn[:, None] + np.array([0.0, 4.0, 2.0], np.float32)) % 6.0 - 3.0) - 1.0
    colours: Colours = (255.0 * np.clip(hues, 0.0, 1.0)).astype(np.uint8)
    return colours


def colour_of(message: Any) -> Colour:
    """Return a ColorRGBA message's colour."""
    red, green, blue = (
        round(255.0 * min(max(v, 0.0), 1.0)) for v in (message.r, message.g, message.b)
    )
    return red, green, blue
