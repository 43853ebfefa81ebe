"""The colours of Gazebo's material scripts, by name."""

from __future__ import annotations

_COLOURS = {
    "red": (0.8, 0.1, 0.1, 1.0),
    "green": (0.1, 0.7, 0.1, 1.0),
    "blue": (0.1, 0.1, 0.8, 1.0),
    "yellow": (0.9, 0.8, 0.1, 1.0),
    "orange": (1.0, 0.5, 0.1, 1.0),
    "purple": (0.6, 0.1, 0.7, 1.0),
    "turquoise": (0.1, 0.8, 0.8, 1.0),
    "indigo": (0.3, 0.1, 0.6, 1.0),
    "gold": (0.8, 0.65, 0.1, 1.0),
    "silver": (0.75, 0.75, 0.75, 1.0),
    "white": (1.0, 1.0, 1.0, 1.0),
    "black": (0.05, 0.05, 0.05, 1.0),
    "grey": (0.7, 0.7, 0.7, 1.0),
    "gray": (0.7, 0.7, 0.7, 1.0),
    "road": (0.2, 0.2, 0.2, 1.0),
    "wood": (0.65, 0.45, 0.25, 1.0),
}
_VARIANTS = ("dark", "light", "flat", "bright")
_SUFFIXES = ("transparent", "glow")


def gazebo_colour(name: str) -> tuple[float, ...] | None:
    """Return the colour of a material such as `Gazebo/DarkGrey`, or None.

    Args:
        name: The script's name; what stands before the last slash does not matter.
    """
    plain = name.strip().rpartition("/")[2].lower().replace("_", "")
    for variant in _VARIANTS:
        plain = plain.removeprefix(variant) or plain
    for suffix in _SUFFIXES:
        plain = plain.removesuffix(suffix)
    return _COLOURS.get(plain)
