"""The stacks as data: which nodes live in which process, under which lifecycle manager."""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Any

_MANAGER = "lifecycle_manager_"
ORIGINALS = {"nav2": "Nav2", "slam_toolbox": "slam_toolbox"}
"""The stacks whose behaviour `--as-...` sets, and how they are written."""


@dataclass(frozen=True)
class NodeSpec:
    """One node.

    Attributes:
        name: Its name, absolute without the slash; also its key in parameter files.
    """

    name: str
    module: str
    cls: str

    @property
    def original(self) -> str:
        """The one of `ORIGINALS` whose behaviour its parameters can have."""
        return "slam_toolbox" if self.name == "slam_toolbox" else "nav2"

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
        cores: The modules of their algorithms, which import no ROS.
        commandable: Whether clients may command their lifecycle manager. Not the simulator's: one
            that shuts all down, as nav2_simple_commander can, means the robot, not the world.
        managed_as: What their manager has in its name, if not the group's.
    """

    name: str
    nodes: tuple[NodeSpec, ...]
    cores: tuple[str, ...] = ()
    commandable: bool = True
    managed_as: str = ""

    @property
    def manager(self) -> str:
        """Name of their lifecycle manager."""
        return f"{_MANAGER}{self.managed_as or self.name}"

    @property
    def manager_spec(self) -> NodeSpec:
        """Their lifecycle manager, which only processes of their own make."""
        return replace(LIFECYCLE_MANAGER, name=self.manager)


def _node(package: str, name: str, module: str = "", cls: str = "") -> NodeSpec:
    camel = "".join(word.capitalize() for word in name.split("_"))
    return NodeSpec(name, f"{package}.nodes.{module or name}", cls or f"{camel}Node")


SIM = _node("arjuna_sim", "sim")
ROBOT_STATE_PUBLISHER = _node("arjuna_sim", "robot_state_publisher")
EKF = _node("arjuna_sim", "ekf_filter_node", "ekf", "EkfNode")
SLAM_TOOLBOX = _node("arjuna_slam", "slam_toolbox")
MAP_SAVER = _node("arjuna_slam", "map_saver", "map_server")
MAP_SERVER = _node("arjuna_slam", "map_server")
AMCL = _node("arjuna_slam", "amcl")
LOCAL_COSTMAP, GLOBAL_COSTMAP = (
    _node("arjuna_nav", f"{name}/{name}", "costmap.node", "CostmapNode")
    for name in ("local_costmap", "global_costmap")
)
CONTROLLER_SERVER = _node("arjuna_nav", "controller_server")
SMOOTHER_SERVER = _node("arjuna_nav", "smoother_server")
PLANNER_SERVER = _node("arjuna_nav", "planner_server")
BEHAVIOR_SERVER = _node("arjuna_nav", "behavior_server")
BT_NAVIGATOR = _node("arjuna_nav", "bt_navigator")
VELOCITY_SMOOTHER = _node("arjuna_nav", "velocity_smoother")
COLLISION_MONITOR = _node("arjuna_nav", "collision_monitor")
WAYPOINT_FOLLOWER = _node("arjuna_nav", "waypoint_follower")
DOCKING_SERVER = _node("arjuna_nav", "docking_server", "docking.server")
ROUTE_SERVER = _node("arjuna_nav", "route_server")
EXPLORER = _node("arjuna_nav", "explorer")

MESSAGES = (
    *("geometry_msgs.msg", "nav_msgs.msg", "nav_msgs.srv", "sensor_msgs.msg", "tf2_msgs.msg"),
    *("lifecycle_msgs.srv", "rcl_interfaces.srv", "diagnostic_msgs.msg", "std_srvs.srv"),
    *("type_description_interfaces.srv", "rosgraph_msgs.msg"),
)
"""The modules of the messages that every process needs."""

_SIM_CORES = "arjuna_sim.simulation", "arjuna_sim.devices.ekf", "simulation_interfaces.srv"
SIM_GROUP = Group("sim", (SIM, EKF, ROBOT_STATE_PUBLISHER), _SIM_CORES, commandable=False)
WORLD_GROUP = Group("world", (SIM,), _SIM_CORES, commandable=False, managed_as="sim")
"""The simulator of several robots, which makes what else each of them needs itself."""
SLAM_GROUP = Group(
    "slam", (SLAM_TOOLBOX, MAP_SAVER), ("arjuna_slam.slam", "arjuna_slam.localization")
)
LOCALIZATION_GROUP = Group("localization", (MAP_SERVER, AMCL), ("arjuna_slam.amcl.filter",))
NAVIGATION_GROUP = Group(
    "navigation",
    (
        *(LOCAL_COSTMAP, CONTROLLER_SERVER, GLOBAL_COSTMAP, SMOOTHER_SERVER, PLANNER_SERVER),
        *(ROUTE_SERVER, BEHAVIOR_SERVER, VELOCITY_SMOOTHER, COLLISION_MONITOR, BT_NAVIGATOR),
        *(WAYPOINT_FOLLOWER, DOCKING_SERVER),
    ),
    (
        *("arjuna_nav.navigator", "arjuna_nav.trees.xml_file", "arjuna_nav.docking.docking"),
        *("arjuna_nav.safety.collision_monitor", "nav2_msgs.action", "nav2_msgs.srv"),
    ),
)
EXPLORER_GROUP = Group("explorer", (EXPLORER,))
DESCRIPTION_GROUP = Group("description", (ROBOT_STATE_PUBLISHER,), ("arjuna_sim.inputs",))
ODOMETRY_GROUP = Group("odometry", (EKF,), ("arjuna_sim.devices.ekf",))
_FUSION_CORES = "arjuna_sim.fusion.estimator", "robot_localization.srv"

_COMMANDING = (
    CONTROLLER_SERVER,
    BEHAVIOR_SERVER,
    VELOCITY_SMOOTHER,
    COLLISION_MONITOR,
    DOCKING_SERVER,
)
VELOCITY_CHAIN = tuple(spec.name for spec in _COMMANDING)
"""The nodes that a velocity passes, or comes from, to the wheels."""

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


_MAPS = "arjuna_slam.nodes.map_server"
_FURTHER: dict[str, tuple[frozenset[str], tuple[str, str]]] = {
    "*mask_server": (frozenset({"yaml_filename", "topic_name"}), (_MAPS, "MapServerNode")),
    "*filter_info_server": (
        frozenset({"filter_info_topic", "mask_topic"}),
        (_MAPS, "FilterInfoServerNode"),
    ),
    "base_footprint_publisher": (
        frozenset(),
        ("arjuna_nav.nodes.base_footprint", "BaseFootprintPublisherNode"),
    ),
    "collision_detector": (
        frozenset(),
        ("arjuna_nav.nodes.safety.detector", "CollisionDetectorNode"),
    ),
}
"""Nodes that run beside navigation where a file has a section of such a name, or with such keys."""


_FILTER_NODE = "arjuna_sim.nodes.localization.filter_node"
_NAVSAT = "navsat_transform*"
_OF_SENSOR = re.compile(r"(odom|pose|twist|imu)\d+_\w+")
_UNSCENTED = {"alpha", "kappa", "beta"}


def further_nodes(sections: Mapping[str, Mapping[str, Any]]) -> list[NodeSpec]:
    """Return the nodes that run for their sections of a parameter file alone, in its order."""
    return [*nodes_beside_navigation(sections), *fusion_nodes(sections)]


def nodes_beside_navigation(sections: Mapping[str, Mapping[str, Any]]) -> list[NodeSpec]:
    """Return the nodes that run beside navigation for their sections of a file alone."""
    usual = {spec.name.rpartition("/")[2] for spec in all_nodes()} | {"**"}
    found: dict[str, NodeSpec] = {}
    for section, values in sections.items():
        name = section.rpartition("/")[2]
        for pattern, (keys, origin) in _FURTHER.items():
            known = name not in usual and keys and keys <= values.keys()
            if known or fnmatchcase(name, pattern):
                found.setdefault(name, NodeSpec(name, *origin))
    return list(found.values())


def fusion_nodes(sections: Mapping[str, Mapping[str, Any]]) -> list[NodeSpec]:
    """Return robot_localization's nodes: the filters' sections, of any name, have sensors' masks.

    What stands below `/**` is of the filter with the usual name.
    """
    found = {}
    for section, values in sections.items():
        name = EKF.name if section == "/**" else section.rpartition("/")[2]
        if fnmatchcase(name, _NAVSAT):
            found[name] = navsat_node(name)
        elif any(map(_OF_SENSOR.fullmatch, values)):
            unscented = "ukf" in name or not _UNSCENTED.isdisjoint(values)
            found[name] = filter_node(name, unscented)
    return list(found.values())


def filter_node(name: str, unscented: bool) -> NodeSpec:
    """Return a filter of robot_localization under a name."""
    return NodeSpec(name, _FILTER_NODE, "UkfFilterNode" if unscented else "EkfFilterNode")


def navsat_node(name: str) -> NodeSpec:
    """Return robot_localization's conversion of GPS under a name."""
    return NodeSpec(name, "arjuna_sim.nodes.localization.navsat", "NavsatTransformNode")


def with_further(group: Group, sections: Mapping[str, Mapping[str, Any]]) -> Group:
    """Return a group with the nodes that parameters' sections add to it.

    robot_localization's run where our odometry does, and in its stead if one estimates in odom.
    """
    if group == NAVIGATION_GROUP:
        return replace(group, nodes=(*group.nodes, *nodes_beside_navigation(sections)))
    fused = fusion_nodes(sections)
    if group not in (SIM_GROUP, ODOMETRY_GROUP) or not fused:
        return group
    filters = filter(is_filter, fused)
    instead = any(
        estimates_in_odom(sections.get(one.name, sections.get("/**", {}))) for one in filters
    )
    kept = (one for one in group.nodes if not (instead and one == EKF))
    return replace(group, nodes=(*kept, *fused), cores=(*group.cores, *_FUSION_CORES))


def is_filter(spec: NodeSpec) -> bool:
    """Return whether a node is a filter of robot_localization."""
    return spec.module == _FILTER_NODE


def estimates_in_odom(values: Mapping[str, Any]) -> bool:
    """Return whether a filter's parameters have it estimate in odom, not in map."""
    return values.get("world_frame", "") in ("", values.get("odom_frame", "odom"))


def _processing(name: str, module: str, cls: str) -> NodeSpec:
    return NodeSpec(name, f"arjuna_sim.nodes.processing.{module}", f"{cls}Node")


_JOY = _processing("joy_node", "joystick", "Joy")
PROGRAMS: dict[tuple[str, str], NodeSpec] = {
    ("depthimage_to_laserscan", "depthimage_to_laserscan_node"): _processing(
        "depthimage_to_laserscan", "to_scan", "DepthimageToLaserscan"
    ),
    ("diagnostic_aggregator", "aggregator_node"): _processing(
        "analyzers", "diagnostics", "DiagnosticAggregator"
    ),
    ("explore_lite", "explore"): NodeSpec(
        "explore_node", "arjuna_nav.nodes.explore_lite", "ExploreLiteNode"
    ),
    ("imu_filter_madgwick", "imu_filter_madgwick_node"): _processing(
        "imu_filter_madgwick", "imu_filter", "ImuFilter"
    ),
    ("irobot_create_nodes", "motion_control"): NodeSpec(
        "motion_control", "arjuna_nav.nodes.motion_control", "MotionControlNode"
    ),
    ("joint_state_publisher", "joint_state_publisher"): _processing(
        "joint_state_publisher", "joint_state_publisher", "JointStatePublisher"
    ),
    ("joy", "joy_node"): _JOY,
    ("joy_linux", "joy_linux_node"): _JOY,
    ("laser_filters", "scan_to_scan_filter_chain"): _processing(
        "scan_to_scan_filter_chain", "laser_filters", "ScanFilterChain"
    ),
    ("pointcloud_to_laserscan", "laserscan_to_pointcloud_node"): _processing(
        "laserscan_to_pointcloud", "to_scan", "LaserscanToPointcloud"
    ),
    ("pointcloud_to_laserscan", "pointcloud_to_laserscan_node"): _processing(
        "pointcloud_to_laserscan", "to_scan", "PointcloudToLaserscan"
    ),
    ("robot_localization", "ekf_node"): filter_node(EKF.name, False),
    ("robot_localization", "navsat_transform_node"): navsat_node("navsat_transform_node"),
    ("robot_localization", "ukf_node"): filter_node("ukf_filter_node", True),
    ("robot_state_publisher", "robot_state_publisher"): ROBOT_STATE_PUBLISHER,
    ("slam_toolbox", "merge_maps_kinematic"): NodeSpec(
        "map_merging", "arjuna_slam.nodes.merge_maps", "MergeMapsNode"
    ),
    ("teleop_twist_joy", "teleop_node"): _processing(
        "teleop_twist_joy_node", "joystick", "TeleopTwistJoy"
    ),
    ("twist_mux", "twist_mux"): _processing("twist_mux", "twist_mux", "TwistMux"),
}
"""The node that `ros2 run PACKAGE EXECUTABLE` starts, under its usual name."""
LIFECYCLE_MANAGER = NodeSpec(
    f"{_MANAGER}navigation", "bringup.processes.lifecycle.manager", "LifecycleManager"
)
NAV2_PROGRAMS: dict[tuple[str, str], NodeSpec] = {
    ("nav2_amcl", "amcl"): AMCL,
    ("nav2_behaviors", "behavior_server"): BEHAVIOR_SERVER,
    ("nav2_bt_navigator", "bt_navigator"): BT_NAVIGATOR,
    ("nav2_collision_monitor", "collision_detector"): NodeSpec(
        "collision_detector", *_FURTHER["collision_detector"][1]
    ),
    ("nav2_collision_monitor", "collision_monitor"): COLLISION_MONITOR,
    ("nav2_controller", "controller_server"): CONTROLLER_SERVER,
    ("nav2_lifecycle_manager", "lifecycle_manager"): LIFECYCLE_MANAGER,
    ("nav2_map_server", "costmap_filter_info_server"): NodeSpec(
        "costmap_filter_info_server", *_FURTHER["*filter_info_server"][1]
    ),
    ("nav2_map_server", "map_saver_server"): MAP_SAVER,
    ("nav2_map_server", "map_server"): MAP_SERVER,
    ("nav2_planner", "planner_server"): PLANNER_SERVER,
    ("nav2_route", "route_server"): ROUTE_SERVER,
    ("nav2_smoother", "smoother_server"): SMOOTHER_SERVER,
    ("nav2_velocity_smoother", "velocity_smoother"): VELOCITY_SMOOTHER,
    ("nav2_waypoint_follower", "waypoint_follower"): WAYPOINT_FOLLOWER,
    ("opennav_docking", "opennav_docking"): DOCKING_SERVER,
}
"""The same of Nav2's servers, each of which a stack runs too."""
_WITH_COSTMAP = {CONTROLLER_SERVER: LOCAL_COSTMAP, PLANNER_SERVER: GLOBAL_COSTMAP}


_OWN_KEYS = {
    r"filter\d+\.type": ("laser_filters", "scan_to_scan_filter_chain"),
    r"(topics|locks)\.\w+\.priority": ("twist_mux", "twist_mux"),
    r"(axis|scale)_(linear|angular)\.\w+": ("teleop_twist_joy", "teleop_node"),
    r"mag_bias_[xyz]|zeta": ("imu_filter_madgwick", "imu_filter_madgwick_node"),
}
"""Parameters that a program alone has, by which its section is known under any name."""


def program_of(section: str, keys: Iterable[str] = ()) -> tuple[str, str] | None:
    """Return package and executable of a section's node, by its name or what it has alone."""
    usual = {executable: (package, executable) for package, executable in PROGRAMS}
    usual |= {spec.name: names for names, spec in reversed(PROGRAMS.items())}
    if (named := usual.get(section.rpartition("/")[2])) is not None:
        return named
    own = (
        known for key in keys for pattern, known in _OWN_KEYS.items() if re.fullmatch(pattern, key)
    )
    return next(own, None)


def program_nodes(spec: NodeSpec) -> tuple[NodeSpec, ...]:
    """Return the nodes of a program: its own, behind the costmap that it works on."""
    return (*filter(None, [_WITH_COSTMAP.get(spec)]), spec)


def program_group(spec: NodeSpec, name: str) -> Group:
    """Return the process of a program's nodes alone, its own under a name."""
    if spec == LIFECYCLE_MANAGER:
        return Group(name, (), managed_as=name.removeprefix(_MANAGER))
    *before, own = program_nodes(spec)
    return Group(name, (*before, replace(own, name=name)))


def all_nodes() -> list[NodeSpec]:
    """Return every node there is, with the groups' lifecycle managers."""
    nodes = [spec for group in DEMO_GROUPS for spec in group.nodes]
    return [*nodes, *(group.manager_spec for group in DEMO_GROUPS)]
