"""Kinds of docks: where to stage before one, and how contact and charging show.

Source: opennav_docking, SimpleChargingDock and SimpleNonChargingDock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from arjuna_core.config import (
    duration_param,
    length_param,
    load,
    param,
    share_param,
    yaw_rate_param,
)
from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import SE2


@dataclass(frozen=True)
class DockSenses:
    """Evidence that the robot stands in a dock.

    Attributes:
        distance: From the robot to the dock's pose [m], None where that pose is not known.
        effort: Mean effort of the joints watched, None where it is not known.
        speed: Mean speed of the joints watched, None where it is not known.
        current: Of the battery, positive while it charges [A], None where it is not known.
    """

    distance: float | None = None
    effort: float | None = None
    speed: float | None = None
    current: float | None = None


@dataclass(frozen=True)
class SimpleDockConfig:
    """Parameters of a simple dock, by Nav2's names."""

    docking_threshold: float = length_param(
        0.05, "Distance to the dock's pose that counts as docked."
    )
    staging_x_offset: float = param(-0.7, "Staging pose ahead of the dock's pose.", unit="m")
    staging_yaw_offset: float = param(0.0, "Heading of the staging pose against it.", unit="rad")
    dock_direction: str = param(
        "",
        "How the robot drives into such docks; empty: as the server's dock_backwards says.",
        choices=("", "forward", "backward"),
    )
    use_external_detection_pose: bool = param(
        False, "Whether detected_dock_pose says where the dock is; else its pose as given."
    )
    external_detection_timeout: float = duration_param(1.0, "How old a detection may be.")
    external_detection_translation_x: float = param(
        -0.2, "Dock's pose ahead of what is detected.", unit="m"
    )
    external_detection_translation_y: float = param(
        0.0, "Dock's pose to the left of what is detected.", unit="m"
    )
    external_detection_rotation_roll: float = param(-1.57, "Turn of the detection.", unit="rad")
    external_detection_rotation_pitch: float = param(1.57, "Turn of the detection.", unit="rad")
    external_detection_rotation_yaw: float = param(0.0, "Turn of the detection.", unit="rad")
    filter_coef: float = share_param(
        0.1, "Share of a new detection in the pose believed; 0: all of it."
    )
    use_stall_detection: bool = param(
        False, "Whether joints that push without moving show contact; else the distance."
    )
    stall_joint_names: tuple[str, ...] = param((), "The joints watched.")
    stall_velocity_threshold: float = yaw_rate_param(1.0, "Speed below which joints stand.")
    stall_effort_threshold: float = param(
        1.0, "Effort above which joints push.", unit="Nm", minimum=0.0
    )

    def __post_init__(self) -> None:
        if self.use_stall_detection and not self.stall_joint_names:
            raise ConfigError("'use_stall_detection' needs joints in 'stall_joint_names'")


@dataclass(frozen=True)
class SimpleChargingDockConfig(SimpleDockConfig):
    """Parameters of a simple dock that charges, by Nav2's names."""

    use_battery_status: bool = param(
        True, "Whether battery_state shows that the robot charges; else contact does."
    )
    charging_threshold: float = param(
        0.5, "Current of the battery above which it charges.", unit="A", minimum=0.0
    )


class DockType:
    """A kind of docks; this one does not charge, and contact is all there is to sense."""

    Config: ClassVar[type[Any]] = SimpleDockConfig
    charges = False

    def __init__(self, config: Any) -> None:
        self.config = config

    def backs_in(self, default: bool) -> bool:
        """Return whether the robot backs into such docks, as the server does by default."""
        direction: str = getattr(self.config, "dock_direction", "")  # of one's own kind: none
        return direction == "backward" if direction else default

    def staging_pose(self, dock: SE2) -> SE2:
        """Return where to stand before an approach, given the dock's pose."""
        return dock @ SE2(self.config.staging_x_offset, 0.0, self.config.staging_yaw_offset)

    def is_docked(self, senses: DockSenses) -> bool:
        """Return whether the joints push without moving, or the robot is near enough."""
        config = self.config
        if not config.use_stall_detection:
            return senses.distance is not None and senses.distance < config.docking_threshold
        if senses.effort is None or senses.speed is None:
            return False
        stands = senses.speed < config.stall_velocity_threshold
        return bool(stands and senses.effort > config.stall_effort_threshold)

    def is_charging(self, senses: DockSenses) -> bool:
        """Return whether the battery is being charged."""
        return False

    def is_in(self, senses: DockSenses) -> bool:
        """Return whether contact or current show that the robot stands in the dock."""
        return self.is_docked(senses) or self.is_charging(senses)


class SimpleChargingDock(DockType):
    """A dock that charges: the battery says so, or contact does."""

    Config: ClassVar[type[Any]] = SimpleChargingDockConfig
    charges = True

    def is_charging(self, senses: DockSenses) -> bool:
        """Return whether the battery is being charged."""
        if not self.config.use_battery_status:
            return self.is_docked(senses)
        return senses.current is not None and senses.current > self.config.charging_threshold


_HERE = "arjuna_nav.docking.dock_types"
_CHARGING = "opennav_docking::SimpleChargingDock"
_NON_CHARGING = "opennav_docking::SimpleNonChargingDock"
DOCK_TYPES = PluginTypes(
    "dock type",
    {_CHARGING: f"{_HERE}:SimpleChargingDock", _NON_CHARGING: f"{_HERE}:DockType"},
    _CHARGING,
    {"simple_non_charging_dock": _NON_CHARGING},
)


@dataclass(frozen=True)
class DockConfig:
    """One dock: of which kind, and where."""

    type: str = param("", "Its kind, of 'dock_plugins'; may be empty where there is one kind.")
    frame: str = param("map", "Frame of its pose.")
    pose: tuple[float, ...] = param(
        (), "Its x [m], y [m] and heading into it [rad]; the robot's base ends there."
    )
    id: str = param("", "What names it to those who detect it.")

    def __post_init__(self) -> None:
        if len(self.pose) not in (0, 3):
            raise ConfigError(f"'pose' has {len(self.pose)} numbers; valid: [x, y, heading]")

    @property
    def docked(self) -> SE2:
        """The robot's docked pose, in `frame`."""
        return SE2(*self.pose)


def placed(docks: Mapping[str, DockConfig]) -> dict[str, DockConfig]:
    """Return docks by name, each of which has a pose.

    Raises:
        ConfigError: A dock has none.
    """
    lost = [name for name, dock in docks.items() if not dock.pose]
    if lost:
        raise ConfigError(*(f"'{name}.pose' is missing; valid: [x, y, heading]" for name in lost))
    return dict(docks)


def read_docks(path: str | Path, warn: Callable[[str], None]) -> dict[str, DockConfig]:
    """Read a file of docks, `docks: {name: {type, frame, pose, id}}`.

    Args:
        warn: Takes a sentence for each key that no dock has.

    Raises:
        InputFileError: It is missing, no YAML, or holds no docks as above.
    """
    document = read_yaml(Path(path))
    entries = document.get("docks") if isinstance(document, Mapping) else None
    if not isinstance(entries, Mapping) or not all(
        isinstance(entry, Mapping) for entry in entries.values()
    ):
        raise InputFileError(path, "expected 'docks: {name: {type, frame, pose}}'")
    try:
        return placed(
            {str(k): load(DockConfig, v, f"{path}: {k}", warn) for k, v in entries.items()}
        )
    except ConfigError as error:
        raise InputFileError(path, "; ".join(error.problems)) from error


def unknown_types(docks: Mapping[str, DockConfig], types: Iterable[str]) -> list[str]:
    """Return a sentence for each dock of a kind that is not among those there are."""
    valid = list(types)
    return [
        f"dock '{name}' is of type '{dock.type}'; valid: {', '.join(valid) or 'none'}"
        for name, dock in docks.items()
        if dock.type not in valid and (dock.type or len(valid) != 1)
    ]
