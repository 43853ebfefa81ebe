"""Gazebo's tags of a robot, of URDF and SDF alike: sensors, plugins and surfaces."""

from __future__ import annotations

import copy
import dataclasses
import re
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement  # parsing is defusedxml's

from arjuna_core.errors import InputFileError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.tag_text import remappings, text_of, topic, value
from arjuna_sim.files.xml_file import XmlFile

RATE_MAX = 1000.0
"""Greatest rate of a sensor [Hz]."""
_PACE = ("updaterate", "updateratehz")  # tags of plugins in a sensor

_OUT = re.compile(r".*gazebo_ros_(ray|imu|gps)_sensor\.so")  # plug-ins of ROS 2: on ~/out
_OF_ROS_1 = {
    *("cameraName", "imageTopicName", "cameraInfoTopicName", "frameName", "pointCloudTopicName"),
    *("depthImageTopicName", "depthImageCameraInfoTopicName", "topicName"),
}
"""Names of topics and frames that plug-ins of ROS 1 read, those of ROS 2 not (gazebo_ros)."""
_SYSTEM = re.compile(r"^(ignition::gazebo|gz::sim)::systems::")


@dataclass(frozen=True)
class SensorTag:
    """A `<sensor>` and its mounting; also a `<plugin>` that is a sensor by itself.

    A system of Gazebo's that is written in a sensor is left out: what it holds of ROS, copied from
    Gazebo Classic's plugins, is nothing to it.

    Attributes:
        link: The link that carries it.
        pose: Its pose in the link; None where the tag's own `<pose>` is that.
    """

    xml: XmlFile
    element: Element
    link: str
    pose: Pose3 | None = None

    def __post_init__(self) -> None:
        """Leave out Gazebo's systems, and names of ROS 1 where a plug-in is ROS 2's."""
        systems = [plugin for plugin in self.element.findall("plugin") if is_system(plugin)]
        if systems:
            object.__setattr__(self, "element", without(self.element, systems))
        for plugin in self.element.findall("plugin"):
            old = [child for child in plugin if child.tag in _OF_ROS_1]
            if old and _is_of_ros_2(plugin, self.xml.root):
                names = ", ".join(f"<{child.tag}>" for child in old)
                self.note(f"{names}: of ROS 1, not read by the plug-in of ROS 2")
                rest = without(self.element, [plugin])
                rest.append(without(plugin, old))
                object.__setattr__(self, "element", rest)

    @property
    def name(self) -> str:
        """Its name, else its type."""
        return self.element.get("name") or self.element.get("type") or ""

    @property
    def label(self) -> str:
        """The name of its element in messages."""
        return f"{self.element.tag} '{self.name or '?'}'"

    @property
    def frame(self) -> str:
        """The frame that its messages name, its link where the file names none."""
        names = ("framename", "gzframeid", "ignitionframeid", "frameid")
        return self.text(*names, default=self.link).lstrip("/")

    @property
    def robot(self) -> str:
        """The robot's name, as its file has it."""
        root = self.xml.root
        model = root if root.get("name") else root.find("model")
        return "robot" if model is None else model.get("name", "robot")

    def own_topic(self, last: str) -> str:
        """Return the topic of a sensor whose file names none: its name, and what it publishes."""
        return f"{self.name or last}/{last}"

    def placed(self) -> Element:
        """Return the tag with its pose in the link."""
        if self.pose is None:
            return self.element
        placed = copy.copy(self.element)
        for own in placed.findall("pose"):
            placed.remove(own)
        numbers = (*self.pose.position, *self.pose.rpy())
        SubElement(placed, "pose").text = " ".join(repr(float(number)) for number in numbers)
        return placed

    def with_plugin(self, plugin: Element) -> SensorTag:
        """Return the tag with one of its plugins alone."""
        others = [other for other in self.element.findall("plugin") if other is not plugin]
        return dataclasses.replace(self, element=without(self.element, others))

    def mount(self, rate: float, topic_name: str) -> dict[str, Any]:
        """Return the settings that all sensors have, as keywords.

        Raises:
            RobotError: Its pose or rate is invalid.
        """
        pose, lens = self.pose, self.element.find("camera[pose]")
        if pose is None:
            pose = raw_pose(self.xml, self.element, self.label)
        if lens is not None:
            pose = pose @ raw_pose(self.xml, lens, self.label)
        tags = ("topicname", "topic", "rostopic")
        for plugin in self.element.findall("plugin"):
            if plugin.get("name") and _OUT.fullmatch(plugin.get("filename", "")):
                topic_name = f"{plugin.get('name')}/out"
        return {
            "link": self.link,
            "frame": self.frame,
            "rate": self._rate(rate),
            "topic": topic(self.element, topic_name, "~/out", *tags),
            "is_named": bool(text_of(self.element, *tags) or list(remappings(self.element))),
            "name": (self.name or "sensor").strip(),
            "pose": pose,
        }

    def _rate(self, default: float) -> float:
        rate = self.number("update_rate", default)
        if self.element.tag == "plugin":
            rate = value(self.xml, self.element, self.label, default, "updaterate")
        elif self.number("update_rate", 0.0) == 0.0:  # as often as its plugin takes it
            paced = (
                value(self.xml, p, self.label, 0.0, *_PACE) for p in self.element.findall("plugin")
            )
            rate = next((pace for pace in paced if pace > 0.0), rate)
        if not rate >= 0.0:
            raise self.fail(f"<update_rate> is {rate}; valid: above 0 Hz")
        taken = min(rate, RATE_MAX) or default
        if rate != taken:
            self.note(f"<update_rate> {rate:g} is taken as {taken:g} Hz")
        return taken

    def deviation(self, *paths: str, named: str = "gaussiannoise") -> float | None:
        """Return the standard deviation of the first noise that is there; None without one.

        Args:
            paths: Of the noise's tag below this one, or below its plugin.
            named: Plain name of a plugin's tag that holds it; of three axes the first counts.

        Raises:
            RobotError: It is negative.
        """
        for path in paths:
            mean = self.first(f"{path}/mean")
            with suppress(ValueError):  # what is no number is Gazebo's 0
                if mean is not None and float(mean.text or "0") != 0.0:
                    self.note("<noise>: its <mean> is taken to be 0")
        found = (self.first(f"{path}/stddev") for path in paths)
        text = next((e.text for e in found if e is not None and e.text), None) or self.text(named)
        if not text.strip():
            return None
        noise = self.xml.numbers(text.split()[0], 1, f"{self.label} <stddev>")[0]
        if noise < 0.0:
            raise self.fail(f"<stddev> is {noise}; it must not be negative")
        return noise

    def bias(self, path: str) -> tuple[float, float]:
        """Return mean and standard deviation of a noise's bias.

        Raises:
            RobotError: One is no number.
        """
        mean, spread = (self.number(f"{path}/bias_{key}", 0.0) for key in ("mean", "stddev"))
        return mean, abs(spread)

    def drift(self, path: str) -> tuple[float, float] | None:
        """Return how a noise's bias grows per root second and its correlation time [s].

        None where one of them is not above 0, as in gz-sensors.

        Raises:
            RobotError: One is no number.
        """
        names = ("stddev", "correlation_time")
        grows, keeps = (self.number(f"{path}/dynamic_bias_{name}", 0.0) for name in names)
        return (grows, keeps) if grows > 0.0 and keeps > 0.0 else None

    def first(self, *tags: str) -> Element | None:
        """Return the first child that has one of these tags, else the first of a plugin's."""
        paths = (*tags, *(f"plugin/{tag}" for tag in tags))
        return next((e for path in paths if (e := self.element.find(path)) is not None), None)

    def text(self, *names: str, default: str = "") -> str:
        """Return the first text under the first of these plain names that is there."""
        return text_of(self.element, *names, default=default)

    def number(self, path: str, default: float, below: Element | None = None) -> float:
        """Return the number at a path below an element, or below the tag itself."""
        return self.xml.number(self.element if below is None else below, path, default, self.label)

    def count(self, path: str, default: int, below: Element | None = None) -> int:
        """Return the whole number at a path below an element, or below the tag itself."""
        return self.xml.count(self.element if below is None else below, path, default, self.label)

    def fail(self, problem: str) -> InputFileError:
        """Return the exception to raise for a problem."""
        return self.xml.fail(self.label, problem)

    def note(self, text: str) -> None:
        """Keep one line on what is simulated otherwise than the file says."""
        self.xml.note(f"{self.label}: {text}")


def is_system(plugin: Element) -> bool:
    """Return whether a plugin is a system of Gazebo Sim's, by its class."""
    return _SYSTEM.match(plugin.get("name", "")) is not None


def _is_of_ros_2(plugin: Element, root: Element) -> bool:
    """Return whether a plugin is of ROS 2: by its file or, where both have one, by others' tags."""
    name = plugin.get("filename", "")
    both = name.endswith("gazebo_ros_camera.so") and root.find(".//plugin/ros") is not None
    return both or _OUT.fullmatch(name) is not None


def without(element: Element, children: list[Element]) -> Element:
    """Return a copy of an element that lacks some of its children."""
    rest = copy.copy(element)
    for child in children:
        rest.remove(child)
    return rest


class PluginTag(NamedTuple):
    """A `<plugin>`, and the link whose tags hold it; None for the robot's own."""

    element: Element
    link: str | None


@dataclass
class Tags:
    """All tags of a robot.

    Attributes:
        items: Plugins and sensors in the file's order.
        friction: By link, the friction of its shapes.
        colours: By link, the colour of its material.
        stiffness: By link, `kp` and `kd`.
        grips: By link, the unit vector of the ground along which friction acts.
        uneven: Notes on links whose friction differs along and across.
        controlled: Names of the joints that a velocity controller moves.
        springs: By joint, a spring's stiffness and where it is at rest.
        T_model: Where the root link is in its SDF model.
        T_world: Where the model stands in the world of its file; None without a world.
    """

    items: list[PluginTag | SensorTag] = field(default_factory=list)
    friction: dict[str, float] = field(default_factory=dict)
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)
    stiffness: dict[str, dict[str, float]] = field(default_factory=dict)
    grips: dict[str, tuple[float, float]] = field(default_factory=dict)
    uneven: list[str] = field(default_factory=list)
    controlled: set[str] = field(default_factory=set)
    springs: dict[str, dict[str, Any]] = field(default_factory=dict)
    T_model: Pose3 = ORIGIN
    T_world: Pose3 | None = None

    @property
    def plugins(self) -> list[Element]:
        """The plugins."""
        return [item.element for item in self.items if isinstance(item, PluginTag)]
