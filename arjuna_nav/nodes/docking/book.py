"""The docks and their kinds as the docking server knows them, and what a goal means by them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arjuna_core.errors import ArjunaError, ConfigError
from arjuna_core.files.maps_folder import path_in_folder
from arjuna_core.ros.convert import se2_from_pose
from arjuna_nav.docking.database import DockPlace, dock_places, read_docks, unknown_types
from arjuna_nav.docking.dock_types import DOCK_TYPES, DockType
from arjuna_nav.docking.docking import DockingError
from arjuna_nav.nodes.docking.orders import DockingServerConfig


class RefusedError(ArjunaError):
    """An order that cannot be carried out.

    Args:
        error: Its code.
        message: Why, and what is valid.
    """

    def __init__(self, error: DockingError, message: str) -> None:
        super().__init__(message)
        self.error = error


class DockBook:
    """Looks up docks and their kinds.

    Args:
        config: Parameters of the docking server.
        warn: Takes what is odd about a file of docks.

    Raises:
        ArjunaError: A dock has no pose or is of no kind there is, or the file cannot be read.
    """

    def __init__(self, config: DockingServerConfig, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self.types: dict[str, DockType] = {}
        self.judge_by(config)
        if config.dock_database:
            self._docks = self._checked(read_docks(config.dock_database, warn))
        else:
            named = {name: getattr(config, name) for name in config.docks}
            self._docks = self._checked(dock_places(named))

    def judge_by(self, config: DockingServerConfig) -> None:
        """Take the kinds' parameters."""
        self.types = {name: DOCK_TYPES.make(getattr(config, name)) for name in config.dock_plugins}

    def reload(self, folder: str, filepath: str) -> None:
        """Take the docks of a file in a folder; they stay as they were where that fails.

        Raises:
            ArjunaError: The file cannot be used.
        """
        self._docks = self._checked(read_docks(path_in_folder(folder, filepath), self._warn))

    def _checked(self, docks: dict[str, DockPlace]) -> dict[str, DockPlace]:
        problems = unknown_types(docks, self.types)
        if problems:
            raise ConfigError(*problems)
        return docks

    def place(self, goal: Any, frame: str) -> DockPlace:
        """Return the dock that a goal of dock_robot names or describes.

        Args:
            goal: The goal.
            frame: The frame of a pose that names none.

        Raises:
            RefusedError: There is no such dock, or its pose is none.
        """
        if goal.use_dock_id:
            if goal.dock_id in self._docks:
                return self._docks[goal.dock_id]
            valid = ", ".join(self._docks) or "none"
            message = f"there is no dock '{goal.dock_id}'; valid: {valid}"
            raise RefusedError(DockingError.DOCK_NOT_IN_DB, message)
        frame = goal.dock_pose.header.frame_id.lstrip("/") or frame
        try:
            return DockPlace(goal.dock_type, frame, se2_from_pose(goal.dock_pose.pose))
        except ValueError as error:
            raise RefusedError(DockingError.DOCK_NOT_VALID, f"invalid pose: {error}") from error

    def kind(self, name: str) -> tuple[str, DockType]:
        """Return a kind of docks and its name, the only one where none is named.

        Raises:
            RefusedError: There is none of that name.
        """
        if not name and len(self.types) == 1:
            name = next(iter(self.types))
        if name not in self.types:
            valid = ", ".join(self.types)
            message = f"there is no dock type '{name}'; valid: {valid}"
            raise RefusedError(DockingError.DOCK_NOT_VALID, message)
        return name, self.types[name]
