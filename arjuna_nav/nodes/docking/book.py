"""The docking server's parameters, docks and kinds, and the orders that name them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from arjuna_core.config import duration_param, fixed, param, plugin_names
from arjuna_core.errors import ConfigError
from arjuna_core.files.maps_folder import path_in_folder
from arjuna_core.plugins import NamedConfigs
from arjuna_core.ros.convert import se2_from_pose
from arjuna_core.ros.goal_server import GoalError, GoalServer
from arjuna_core.se2 import SE2
from arjuna_nav.docking.dock_types import (
    DOCK_TYPES,
    DockConfig,
    DockType,
    placed,
    read_docks,
    unknown_types,
)
from arjuna_nav.docking.docking import Docking, DockingConfig, DockingError, Undocking


@dataclass(frozen=True)
class DockingServerConfig(DockingConfig):
    """Parameters of the node `docking_server`, by Nav2's names."""

    base_frame: str = fixed("base_link", "Frame of the robot.")
    fixed_frame: str = fixed("odom", "Frame to approach in; smooth, not the map's.")
    dock_plugins: tuple[str, ...] = plugin_names(
        ("simple_charging_dock",), "The kinds of docks.", DOCK_TYPES
    )
    docks: tuple[str, ...] = plugin_names((), "The docks.", NamedConfigs(DockConfig))
    dock_database: str = param("", "File of docks, instead of 'docks'.", path=True)
    dock_folder: str = param(".", "Folder that reload_database may read from.", path=True)
    navigator_bt_xml: str = param("", "Behavior tree that drives to a staging pose.", path=True)
    transform_tolerance: float = duration_param(0.3, "Greatest age of the robot's pose.")
    costmap_update_timeout: float = duration_param(1.0, "How old the costmap may be.")
    cmd_vel_topic: str = fixed("cmd_vel", "Topic of what to drive.")
    enable_stamped_cmd_vel: bool = fixed(False, "Whether cmd_vel is TwistStamped.")


class DockBook:
    """Looks up docks and their kinds.

    Args:
        warn: Takes what is odd about docks; one of a kind that is not there fails its goals.

    Raises:
        ArjunaError: A dock has no pose, or the file cannot be read.
    """

    def __init__(self, config: DockingServerConfig, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self.types: dict[str, DockType] = {}
        self.judge_by(config)
        if config.dock_database:
            self._keep(read_docks(config.dock_database, warn))
        else:
            self._keep(placed({name: getattr(config, name) for name in config.docks}))

    def judge_by(self, config: DockingServerConfig) -> None:
        """Take the kinds' parameters."""
        self.types = {name: DOCK_TYPES.make(getattr(config, name)) for name in config.dock_plugins}

    def reload(self, folder: str, filepath: str) -> None:
        """Take the docks of a file in a folder; they stay as they were where that fails.

        Raises:
            ArjunaError: The file cannot be used, or has a dock of no kind there is.
        """
        docks = read_docks(path_in_folder(folder, filepath), self._warn)
        if problems := unknown_types(docks, self.types):
            raise ConfigError(*problems)
        self._docks = docks

    def _keep(self, docks: dict[str, DockConfig]) -> None:
        for problem in unknown_types(docks, self.types):
            self._warn(problem)
        self._docks = docks

    def dock(self, goal: Any, frame: str) -> DockConfig:
        """Return the dock that a goal names or describes by a pose, in a frame if it names none.

        Raises:
            GoalError: There is no such dock, or its pose is none.
        """
        if goal.use_dock_id:
            if goal.dock_id in self._docks:
                return self._docks[goal.dock_id]
            valid = ", ".join(self._docks) or "none"
            message = f"there is no dock '{goal.dock_id}'; valid: {valid}"
            raise GoalError(DockingError.DOCK_NOT_IN_DB, message)
        frame = goal.dock_pose.header.frame_id.lstrip("/") or frame
        try:
            return DockConfig(
                goal.dock_type, frame, tuple(se2_from_pose(goal.dock_pose.pose).array())
            )
        except ValueError as error:
            raise GoalError(DockingError.DOCK_NOT_VALID, f"invalid pose: {error}") from error

    def kind(self, name: str) -> tuple[str, DockType]:
        """Return a kind of docks and its name, the only one where none is named.

        Raises:
            GoalError: There is none of that name.
        """
        if not name and len(self.types) == 1:
            name = next(iter(self.types))
        if name not in self.types:
            valid = ", ".join(self.types)
            message = f"there is no dock type '{name}'; valid: {valid}"
            raise GoalError(DockingError.DOCK_NOT_VALID, message)
        return name, self.types[name]


@dataclass
class Order:
    """One goal that is carried out.

    Attributes:
        since: When it began [s].
        dock: The dock to drive to; None where the robot leaves one.
        nominal: Where that dock is in the fixed frame, once it was needed.
        staged: Whether the staging pose was reached, None while it is driven to.
        lost_since: Since when the robot's pose is not known [s].
    """

    server: GoalServer
    action: Any
    kind: DockType
    type: str
    core: Docking | Undocking
    since: float
    dock: DockConfig | None = None
    nominal: SE2 | None = None
    staged: bool | None = None
    lost_since: float | None = None
