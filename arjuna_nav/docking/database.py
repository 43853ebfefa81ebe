"""The docks that are known: of the parameters, or of a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from arjuna_core.config import load, param
from arjuna_core.errors import ConfigError, InputFileError
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.plugins import PluginTypes
from arjuna_core.se2 import SE2


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


class Dock:
    """One dock as an entry of the list `docks`."""

    Config: ClassVar[type[Any]] = DockConfig

    def __init__(self, config: Any) -> None:
        self.config = config


_DOCK = "opennav_docking::Dock"
DOCKS = PluginTypes("dock", {_DOCK: "arjuna_nav.docking.database:Dock"}, _DOCK)


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
