"""Tags of Gazebo in a robot's file, as the readers of URDF and SDF both collect them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sensor_tag import SensorTag


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
    """

    items: list[PluginTag | SensorTag] = field(default_factory=list)
    friction: dict[str, float] = field(default_factory=dict)
    colours: dict[str, tuple[float, ...]] = field(default_factory=dict)
    stiffness: dict[str, dict[str, float]] = field(default_factory=dict)
    grips: dict[str, tuple[float, float]] = field(default_factory=dict)
    uneven: list[str] = field(default_factory=list)
    controlled: set[str] = field(default_factory=set)

    @property
    def plugins(self) -> list[Element]:
        """The plugins."""
        return [item.element for item in self.items if isinstance(item, PluginTag)]
