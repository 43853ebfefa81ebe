"""The layers of the picture, in the order of the panel."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Layer:
    """What can be shown or hidden.

    Attributes:
        label: Its name for a person.
        shown: Whether it is shown at first.
    """

    label: str
    shown: bool = True


LAYERS = {
    "robot": Layer("Robot"),
    "map": Layer("Map"),
    "scan": Layer("Laser scan"),
    "global_costmap": Layer("Global costmap", shown=False),
    "local_costmap": Layer("Local costmap"),
    "particles": Layer("Particles and covariance"),
    "global_path": Layer("Global path"),
    "local_path": Layer("Local path"),
    "goals": Layer("Goals"),
    "people": Layer("People and boxes", shown=False),
    "axes": Layer("TF axes", shown=False),
    "camera": Layer("Camera", shown=False),
}
