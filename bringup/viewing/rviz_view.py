"""From where a file of RViz looks: its current view controller, as an eye and what it looks at."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Point3 = tuple[float, float, float]
FIELD_OF_VIEW = math.radians(75.0)
"""Of the browser's camera, from top to bottom [rad]."""
_HEIGHT = 800.0  # of RViz's picture [pixels], by which a scale in pixels a metre is a height
_NEARLY = 1e-3  # [m] aside from straight above, so that the picture has an upper side


@dataclass(frozen=True)
class View:
    """A camera's place.

    Attributes:
        eye: Where it stands [m], in the fixed frame's directions.
        focus: The point that it looks at [m].
        frame: The frame that both move with; empty for the fixed frame.
    """

    eye: Point3
    focus: Point3
    frame: str = ""


def read_view(current: Mapping[str, Any], fixed_frame: str) -> View | None:
    """Return what a file's `Current` view shows; None where there is no such kind here."""
    kind = str(current.get("Class", "")).rpartition("/")[2]
    if kind not in _KINDS:
        return None
    target = str(current.get("Target Frame") or "").lstrip("/")
    followed = "" if target.startswith("<") or target == fixed_frame else target
    return View(*_KINDS[kind](current), followed)


def _number(part: Any, name: str, default: float = 0.0) -> float:
    """Return a finite number of a mapping, the default where it holds none."""
    value = part.get(name, default) if isinstance(part, Mapping) else default
    try:
        return float(value) if math.isfinite(float(value)) else default
    except (TypeError, ValueError):
        return default


def _point(part: Any) -> Point3:
    x, y, z = (_number(part, axis) for axis in "XYZ")
    return x, y, z


def _along(start: Point3, yaw: float, pitch: float, distance: float) -> Point3:
    """Return the point at a distance [m] from another, by angles [rad] about z and above level."""
    level = distance * math.cos(pitch)
    x, y, z = start
    return (
        x + level * math.cos(yaw),
        y + level * math.sin(yaw),
        z + distance * math.sin(pitch),
    )


def _orbit(view: Mapping[str, Any]) -> tuple[Point3, Point3]:
    focus = _point(view.get("Focal Point"))
    yaw, pitch = (_number(view, name, math.pi / 4.0) for name in ("Yaw", "Pitch"))
    return _along(focus, yaw, pitch, max(_number(view, "Distance", 10.0), 0.01)), focus


def _first_person(view: Mapping[str, Any]) -> tuple[Point3, Point3]:
    eye = _point(view.get("Position"))
    return eye, _along(eye, _number(view, "Yaw"), -_number(view, "Pitch"), 1.0)


def _from_above(view: Mapping[str, Any]) -> tuple[Point3, Point3]:
    focus = (_number(view, "X"), _number(view, "Y"), 0.0)
    seen = _HEIGHT / max(abs(_number(view, "Scale", 10.0)), 0.1)  # from top to bottom [m]
    x, y, z = _along(focus, 0.0, math.pi / 2.0, seen / 2.0 / math.tan(FIELD_OF_VIEW / 2.0))
    below = _number(view, "Angle") - math.pi / 2.0  # at 0 y points up the screen
    return (x + _NEARLY * math.cos(below), y + _NEARLY * math.sin(below), z), focus


_KINDS: dict[str, Callable[[Mapping[str, Any]], tuple[Point3, Point3]]] = {
    **dict.fromkeys(("Orbit", "XYOrbit", "ThirdPersonFollower"), _orbit),
    "FPS": _first_person,
    "TopDownOrtho": _from_above,
}
