"""The parameters of the docking server, and the orders that it carries out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arjuna_core.config import param, plugin_names
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.se2 import SE2
from arjuna_nav.docking.config import DockingConfig
from arjuna_nav.docking.database import DOCKS, DockPlace
from arjuna_nav.docking.dock_types import DOCK_TYPES, DockType
from arjuna_nav.docking.docking import Docking
from arjuna_nav.docking.undocking import Undocking


@dataclass(frozen=True)
class DockingServerConfig(DockingConfig):
    """Parameters of the node `docking_server`, by Nav2's names."""

    base_frame: str = param("base_link", "Frame of the robot.", read_only=True)
    fixed_frame: str = param("odom", "Frame to approach in; smooth, not the map's.", read_only=True)
    dock_plugins: tuple[str, ...] = plugin_names(
        ("simple_charging_dock",), "The kinds of docks.", DOCK_TYPES
    )
    docks: tuple[str, ...] = plugin_names((), "The docks.", DOCKS)
    dock_database: str = param("", "File of docks, instead of 'docks'.", read_only=True)
    dock_folder: str = param(".", "Folder that reload_database may read from.")
    navigator_bt_xml: str = param("", "Behavior tree that drives to a staging pose.")
    transform_tolerance: float = param(0.3, "Age of the pose borne.", unit="s", minimum=0.0)
    costmap_update_timeout: float = param(1.0, "How old the costmap may be.", unit="s", minimum=0.0)
    cmd_vel_topic: str = param("cmd_vel", "Topic of what to drive.", read_only=True)
    enable_stamped_cmd_vel: bool = param(False, "Whether cmd_vel is TwistStamped.", read_only=True)


@dataclass
class Order:
    """One goal under way.

    Attributes:
        server: Whose goal it is.
        action: The goal's action type.
        kind: The dock's kind.
        type: The name of that kind.
        core: What is done.
        since: When it began [s].
        place: The dock to drive to; None where the robot leaves one.
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
    place: DockPlace | None = None
    nominal: SE2 | None = None
    staged: bool | None = None
    lost_since: float | None = None
