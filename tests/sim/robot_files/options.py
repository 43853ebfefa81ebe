"""Options of robot files, and a choice of them by a seed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

_FRAMES = ("y", "-y", "long y", "z", "-z", "x", "turned", "about", "CAD", "spun")
_SOLIDS = ("cylinder", "sphere", "mesh", "mirrored mesh", "drawn mesh", "drawn cylinder", "none")
_URIS = (
    "package://made_description/meshes/unit.stl",
    "package:/made_description/meshes/unit.stl",
    "model://made_description/meshes/unit.stl",
    "package:///made_description/meshes/unit.stl",
    "file://$(find made_description)/meshes/unit.stl",
    "../meshes/unit.stl",
)
_DRIVES = ("classic", "ROS 1", "gz", "ros2_control", "transmission", "none", "bare gz")
_SILENT = ("transmission", "none")  # which tell no radius
_CASTERS = ("sphere", "rolling", "swivel", "of the base", "mesh", "wheel", "box")
_INERTIAS = ("solid", "tiny", "zero", "one", "huge", "skew", "offset")
_LAYOUTS = ("two", "skid", "six", "two", "ackermann", "two", "tricycle", "skid")


@dataclass(frozen=True)
class RobotFile:
    """A robot as its owner wrote it.

    Attributes:
        layout: Of its wheels.
        frame: How wheel joints and their shapes are turned, one of `_FRAMES`.
        solid: What shape its wheels have.
        uri: How it refers to meshes.
        drive: What says which wheels drive.
        caster: What it stands on beside driven wheels.
        inertia: What its wheels' inertias are.
        hubs: How many fixed links there are between base and wheel.
        radius: Of the wheels [m].
        mass: Of the base [kg].
        footprint: Whether its root is on the ground.
        macros: Whether it is written with macros, arguments and a file included.
        friction: Of the wheels, where the file names it.
    """

    layout: str = "two"
    frame: str = "y"
    solid: str = "cylinder"
    uri: str = _URIS[0]
    drive: str = "classic"
    caster: str = "sphere"
    inertia: str = "solid"
    hubs: int = 0
    radius: float = 0.05
    mass: float = 5.0
    footprint: bool = True
    macros: bool = False
    friction: float | None = None

    @property
    def name(self) -> str:
        """Its options, as the id of a test."""
        return (
            f"{self.layout}, axis {self.frame}, {self.solid}, {self.drive}, {self.caster} caster,"
            f" {self.inertia}, {self.hubs} hubs, {1e3 * self.radius:.0f} mm, {self.mass:.3g} kg,"
            f" {'xacro' if self.macros else 'urdf'}"
        )

    @property
    def track(self) -> float:
        """Between the wheels' middles [m]."""
        return 5.0 * self.radius

    @property
    def steers(self) -> bool:
        """True if its front wheels steer."""
        return self.layout in ("ackermann", "tricycle")

    def wheels(self) -> list[tuple[str, float, float]]:
        """Return the names of the wheels in pairs, and where they are [m]."""
        r = self.radius
        axles = {
            "two": [("", 0.0)],
            "skid": [("front_", 2.0 * r), ("rear_", -2.0 * r)],
            "six": [("front_", 3.0 * r), ("middle_", 0.0), ("rear_", -3.0 * r)],
            "ackermann": [("front_", 3.0 * r), ("rear_", -3.0 * r)],
            "tricycle": [("rear_", -3.0 * r)],
        }[self.layout]
        return [
            (f"{end}{side}", x, direction * self.track / 2)
            for end, x in axles
            for side, direction in (("left", 1.0), ("right", -1.0))
        ]


def robot_files(count: int, seed: int = 0) -> Iterator[RobotFile]:
    """Yield robots of all kinds, by the seed; each form comes before one comes again."""
    rng = np.random.default_rng(seed)

    def shuffled(values: tuple[str, ...]) -> Iterator[str]:
        while True:
            yield from rng.permutation(values).tolist()

    frames, solids, uris = shuffled(_FRAMES), shuffled(_SOLIDS), shuffled(_URIS)
    drives, casters, inertias = shuffled(_DRIVES), shuffled(_CASTERS), shuffled(_INERTIAS)
    for i in range(count):
        mass = float(np.exp(rng.uniform(math.log(0.2), math.log(300.0))))
        radius = float(
            np.clip(0.04 * (mass / 3.0) ** (1 / 3) * np.exp(rng.uniform(-0.5, 0.5)), 0.015, 0.3)
        )
        layout, solid, drive = _LAYOUTS[i % len(_LAYOUTS)], next(solids), next(drives)
        steers = layout in ("ackermann", "tricycle")
        yield RobotFile(
            layout,
            next(frames),
            "drawn mesh" if solid == "none" and (steers or drive in _SILENT) else solid,
            next(uris),
            drive,
            next(casters),
            next(inertias),
            int(rng.integers(0, 3)),
            radius,
            mass,
            bool(rng.integers(0, 2)),
            bool(rng.integers(0, 2)),
            float(rng.uniform(0.6, 1.5)) if rng.integers(0, 2) else None,
        )
