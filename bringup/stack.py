"""The stacks as data: which nodes live in which process, under which lifecycle manager."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Any


@dataclass(frozen=True)
class NodeSpec:
    """One node.

    Attributes:
        name: Its name, absolute without the slash; also its key in parameter files.
        module: The module that holds its class.
        cls: The class, a ManagedNode.
    """

    name: str
    module: str
    cls: str

    @property
    def node_class(self) -> Any:
        """The class, which is imported."""
        return getattr(importlib.import_module(self.module), self.cls)

    @property
    def config(self) -> type[Any]:
        """The dataclass of the class's parameters."""
        config: type[Any] = self.node_class.Config
        return config

    def make(self, process: Any, values: Mapping[str, Any]) -> Any:
        """Make the node in a process.

        Raises:
            ConfigError: A value is unknown, of the wrong type or out of bounds.
        """
        namespace, _, name = self.name.rpartition("/")
        return self.node_class(process, values, name=name, namespace=namespace)


@dataclass(frozen=True)
class Group:
    """The nodes of one process, in the order in which they are brought up.

    Attributes:
        name: Name of the process.
        nodes: The nodes.
        manager: Name of their lifecycle manager.
        commandable: Whether clients may command that manager. Not the simulator's: a client that
            shuts every manager down, as nav2_simple_commander can, means the robot, not the world.
        cores: The modules of their algorithms, which import no ROS.
    """

    name: str
    nodes: tuple[NodeSpec, ...]
    manager: str = field(default="")
    commandable: bool = True
    cores: tuple[str, ...] = ()


SIM = NodeSpec("sim", "arjuna_sim.nodes.sim", "SimNode")
ROBOT_STATE_PUBLISHER = NodeSpec(
    "robot_state_publisher",
    "arjuna_sim.nodes.robot_state_publisher",
    "RobotStatePublisherNode",
)
EKF = NodeSpec("ekf_filter_node", "arjuna_sim.nodes.ekf", "EkfNode")
SLAM_TOOLBOX = NodeSpec("slam_toolbox", "arjuna_slam.nodes.slam_toolbox", "SlamToolboxNode")
MAP_SAVER = NodeSpec("map_saver", "arjuna_slam.nodes.map_server", "MapSaverNode")
MAP_SERVER = NodeSpec("map_server", "arjuna_slam.nodes.map_server", "MapServerNode")
AMCL = NodeSpec("amcl", "arjuna_slam.nodes.amcl", "AmclNode")
LOCAL_COSTMAP = NodeSpec(
    "local_costmap/local_costmap", "arjuna_nav.nodes.costmap.node", "CostmapNode"
)
GLOBAL_COSTMAP = NodeSpec(
    "global_costmap/global_costmap", "arjuna_nav.nodes.costmap.node", "CostmapNode"
)
CONTROLLER_SERVER = NodeSpec(
    "controller_server", "arjuna_nav.nodes.controller_server", "ControllerServerNode"
)
SMOOTHER_SERVER = NodeSpec(
    "smoother_server", "arjuna_nav.nodes.smoother_server", "SmootherServerNode"
)
PLANNER_SERVER = NodeSpec("planner_server", "arjuna_nav.nodes.planner_server", "PlannerServerNode")
BEHAVIOR_SERVER = NodeSpec(
    "behavior_server", "arjuna_nav.nodes.behavior_server", "BehaviorServerNode"
)
BT_NAVIGATOR = NodeSpec("bt_navigator", "arjuna_nav.nodes.bt_navigator", "BtNavigatorNode")
VELOCITY_SMOOTHER = NodeSpec(
    "velocity_smoother", "arjuna_nav.nodes.velocity_smoother", "VelocitySmootherNode"
)
COLLISION_MONITOR = NodeSpec(
    "collision_monitor", "arjuna_nav.nodes.collision_monitor", "CollisionMonitorNode"
)
WAYPOINT_FOLLOWER = NodeSpec(
    "waypoint_follower", "arjuna_nav.nodes.waypoint_follower", "WaypointFollowerNode"
)
DOCKING_SERVER = NodeSpec("docking_server", "arjuna_nav.nodes.docking.server", "DockingServerNode")
ROUTE_SERVER = NodeSpec("route_server", "arjuna_nav.nodes.route_server", "RouteServerNode")
EXPLORER = NodeSpec("explorer", "arjuna_nav.nodes.explorer", "ExplorerNode")

MESSAGES = (
    *("geometry_msgs.msg", "nav_msgs.msg", "nav_msgs.srv", "sensor_msgs.msg", "tf2_msgs.msg"),
    *("lifecycle_msgs.srv", "rcl_interfaces.srv", "diagnostic_msgs.msg", "std_srvs.srv"),
    *("type_description_interfaces.srv", "rosgraph_msgs.msg"),
)
"""The modules of the messages that every process needs."""

SIM_GROUP = Group(
    "sim",
    (SIM, EKF, ROBOT_STATE_PUBLISHER),
    "lifecycle_manager_sim",
    commandable=False,
    cores=("arjuna_sim.simulation", "arjuna_sim.devices.ekf", "simulation_interfaces.srv"),
)
WORLD_GROUP = Group("world", (SIM,), SIM_GROUP.manager, False, SIM_GROUP.cores)
"""The simulator of several robots, which makes what else each of them needs itself."""
SLAM_GROUP = Group(
    "slam",
    (SLAM_TOOLBOX, MAP_SAVER),
    "lifecycle_manager_slam",
    cores=("arjuna_slam.slam", "arjuna_slam.localization"),
)
LOCALIZATION_GROUP = Group(
    "localization",
    (MAP_SERVER, AMCL),
    "lifecycle_manager_localization",
    cores=("arjuna_slam.amcl.filter",),
)
NAVIGATION_GROUP = Group(
    "navigation",
    (
        LOCAL_COSTMAP,
        CONTROLLER_SERVER,
        GLOBAL_COSTMAP,
        SMOOTHER_SERVER,
        PLANNER_SERVER,
        ROUTE_SERVER,
        BEHAVIOR_SERVER,
        VELOCITY_SMOOTHER,
        COLLISION_MONITOR,
        BT_NAVIGATOR,
        WAYPOINT_FOLLOWER,
        DOCKING_SERVER,
    ),
    "lifecycle_manager_navigation",
    cores=(
        *("arjuna_nav.navigator", "arjuna_nav.trees.xml_file", "arjuna_nav.docking.docking"),
        *("arjuna_nav.safety.collision_monitor", "nav2_msgs.action", "nav2_msgs.srv"),
    ),
)
VELOCITY_CHAIN = tuple(
    spec.name
    for spec in (
        CONTROLLER_SERVER,
        BEHAVIOR_SERVER,
        VELOCITY_SMOOTHER,
        COLLISION_MONITOR,
        DOCKING_SERVER,
    )
)
"""The nodes that a velocity passes, or comes from, to the wheels."""
EXPLORER_GROUP = Group("explorer", (EXPLORER,), "lifecycle_manager_explorer")
DESCRIPTION_GROUP = Group(
    "description",
    (ROBOT_STATE_PUBLISHER,),
    "lifecycle_manager_description",
    cores=("arjuna_sim.inputs",),
)
ODOMETRY_GROUP = Group(
    "odometry", (EKF,), "lifecycle_manager_odometry", cores=("arjuna_sim.devices.ekf",)
)

STACKS: dict[str, tuple[Group, ...]] = {
    "sim": (SIM_GROUP,),
    "slam": (SLAM_GROUP,),
    "nav": (LOCALIZATION_GROUP, NAVIGATION_GROUP),
    "nav --slam": (SLAM_GROUP, NAVIGATION_GROUP),
    "explore": (EXPLORER_GROUP,),
}
REAL_STACKS: dict[str, tuple[Group, ...]] = {
    "robot": (DESCRIPTION_GROUP, ODOMETRY_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP),
    "robot --slam": (DESCRIPTION_GROUP, ODOMETRY_GROUP, SLAM_GROUP, NAVIGATION_GROUP),
}
DEMO_GROUPS = tuple(dict.fromkeys(group for groups in STACKS.values() for group in groups))
"""Every group: the demo runs them all, and a parameter file may name any node of theirs."""
ALL_GROUPS = (*DEMO_GROUPS, WORLD_GROUP, DESCRIPTION_GROUP, ODOMETRY_GROUP)
"""Those, and the ones that several robots or a real one have instead of the simulator's."""


_FURTHER = {
    "*mask_server": ("arjuna_slam.nodes.map_server", "MapServerNode"),
    "*filter_info_server": ("arjuna_slam.nodes.filter_info_server", "FilterInfoServerNode"),
    "collision_detector": ("arjuna_nav.nodes.safety.detector", "CollisionDetectorNode"),
}
"""Nodes that run beside navigation where a parameter file has a section of such a name."""


def further_nodes(sections: Iterable[str]) -> list[NodeSpec]:
    """Return the nodes that run for their sections of a parameter file alone, in its order."""
    names = dict.fromkeys(section.rpartition("/")[2] for section in sections)
    return [
        NodeSpec(name, *origin)
        for name in names
        for pattern, origin in _FURTHER.items()
        if fnmatchcase(name, pattern)
    ]


def with_further(group: Group, sections: Iterable[str]) -> Group:
    """Return a group with the nodes that parameters' sections add to it."""
    if group != NAVIGATION_GROUP:
        return group
    return replace(group, nodes=(*group.nodes, *further_nodes(sections)))


def all_nodes() -> list[NodeSpec]:
    """Return every node there is."""
    return [spec for group in DEMO_GROUPS for spec in group.nodes]
