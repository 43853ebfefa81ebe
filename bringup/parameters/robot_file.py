"""A driven robot's own file beside parameters: what it adds to them, and what contradicts it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from arjuna_core.config import flatten, load
from arjuna_core.files.shipped import shipped_file
from bringup.parameters.files import Parameters, for_node, merged, shipped_parameters
from bringup.parameters.remarks import Kind, Remark
from bringup.parameters.sources import COSTMAPS, OUTLINE, keys_by_name, of_names
from bringup.stack import (
    AMCL,
    COLLISION_MONITOR,
    CONTROLLER_SERVER,
    EKF,
    GLOBAL_COSTMAP,
    LOCAL_COSTMAP,
    VELOCITY_SMOOTHER,
    Group,
    NodeSpec,
    fusion_nodes,
)

_MAP_TF = "tf_broadcast"
"""Whether AMCL says where the map is."""
_OUTLINES = {**dict.fromkeys(COSTMAPS, ""), "explorer": "costmap."}
"""The nodes with a costmap, and what stands before its parameters."""
_STEERED, _RADIUS = (
    ("planner_server", "controller_server", "behavior_server", "velocity_smoother"),
    "min_turning_radius",
)
"""The nodes that plan and drive by the tightest bend of a steered robot, and their parameter."""
_BRAKES = {
    "controller_server": (
        ("foresight.deceleration",),
        ("tracker.angular_deceleration", "FollowPath.max_angular_accel"),
    ),
    "collision_monitor": (
        ("FootprintApproach.deceleration",),
        ("FootprintApproach.angular_deceleration",),
    ),
    "behavior_server": ((), ("rotational_acc_lim",)),
}
"""The parameters by which nodes reckon with a robot's braking: ahead, and of its turns."""
_BENDING_PLANNER = {
    "GridBased.plugin": "nav2_smac_planner::SmacPlannerHybrid",
    "GridBased.motion_model_for_search": "REEDS_SHEPP",
}
_BENDING_CONTROLLER = {
    "FollowPath.use_rotate_to_heading": False,
    "FollowPath.allow_reversing": True,
}
"""What of a steered robot takes the place of the shipped plug-ins' turns on the spot."""
_BY_GYRO = {
    "slam_toolbox": {"odometry_heading_deviation": 0.02},
    "amcl": {"alpha1": 0.001, "alpha2": 0.0004},  # 3 % of a turn, 0.02 rad a metre
}
"""How far off the headings are that the filter of wheels and gyro gives; what is shipped holds for
odometry of any kind, wheels that skid among them."""
_OPEN = "exploration.max_open_distance"
"""The parameter of the explorer that keeps it where its lidar sees something."""
_SCATTER = 6.0
"""By how many standard deviations a point lies above the ground that marks an obstacle."""
_STANDARD = {
    "scan_topic": "scan",
    "cloud_topic": "depth/points",
    "odom_topic": "odom",
    "base_frame": "base_link",
    "odom_frame": "odom",
}
"""The usual names of what nodes take from the robot; who takes velocities is watched at run time.
"""
_MAPS = {"odom_frame": {"map"}}
"""Frames that others than the robot give: a local costmap may be in the map's."""


@dataclass(frozen=True)
class Driven:
    """A driven robot, as the simulator's parameters have it.

    Attributes:
        sim: Those parameters, which name its file.
        read: Reads a robot of the parameters `robot` and `robot_arguments`.
    """

    sim: Mapping[str, Any]
    read: Callable[[str, str], Any]

    @cached_property
    def robot(self) -> Any:
        """The robot, with the topics that the simulator gives it."""
        robot = self.read(self.sim.get("robot", ""), self.sim.get("robot_arguments", ""))
        return robot.standard() if self.sim.get("standard_topics") else robot

    @property
    def is_fused(self) -> bool:
        """True where the filter of wheels and gyro publishes its odometry, if it is simulated."""
        from arjuna_sim.inputs import needs_fusion

        return bool(needs_fusion(self.robot) and self.sim.get("fused_odometry", True))

    @property
    def is_shipped(self) -> bool:
        """True for the shipped one."""
        file = self.sim.get("robot")
        return not file or Path(file) == shipped_file("urdf/arjuna.urdf")


def of_robot(
    parameters: Parameters,
    driven: Driven,
    groups: Iterable[Group],
    simulated: bool = True,
) -> Parameters:
    """Return a robot's names, outline, sight and bend, unless parameter files say otherwise.

    Where their outline without its padding leaves out some of its body, the body goes to the local
    costmap, for those who keep it free of the points that are seen, and not of cells alone.

    Args:
        simulated: Whether the simulator makes its topics and odometry; of a real robot, whose
            drivers do, outline, sight and bend alone are returned.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    own = {} if driven.is_shipped else _of_another_robot(parameters, driven, groups, simulated)
    values = parameters.get(LOCAL_COSTMAP.name, {})
    if not values.get("body") and any(LOCAL_COSTMAP in group.nodes for group in groups):
        left_out = _left_out(merged(parameters, own), driven, (LOCAL_COSTMAP,), padded=False)
        outline = own.get(LOCAL_COSTMAP.name, {}).get("footprint")
        if body := outline or next((body for _, body, _ in left_out), ""):
            own = merged(own, {LOCAL_COSTMAP.name: {"body": body}})
    return own


def contradictions(parameters: Parameters, driven: Driven) -> Iterator[Remark]:
    """Yield where the parameters of all nodes contradict a robot's file.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for where, body, reason in _left_out(parameters, driven, (LOCAL_COSTMAP, GLOBAL_COSTMAP)):
        found.setdefault((reason, body), []).append(where)
    for (reason, body), (where, *others) in found.items():
        too = f" ({others[0].partition('/')[0]} too)" if others else ""
        advice = f"its own outline: --param 'footprint:={body}'"
        text = f"{reason} and can touch obstacles{too}; {advice}"
        yield Remark(Kind.UNLIKE, where, text, safety=True)
    bends = () if driven.is_shipped else _other_bends(parameters, driven.robot)
    ground = _ground(parameters, driven.robot)
    for where, reason in (*_sideways(parameters, driven.robot), *bends, *ground):
        yield Remark(Kind.UNLIKE, where, reason)


def lacking(driven: Driven) -> Iterator[Remark]:
    """Yield what a simulated robot's file lacks: a lidar, its odometry as a transform.

    Where its file leaves that transform to a filter, there is none here without an IMU.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    from arjuna_sim.inputs import frames_and_topics

    robot = driven.robot
    if not frames_and_topics(robot)["scan_topic"]:
        reason = (
            "its file has no lidar: nothing shows where it is on a map, and it does not drive"
            " before a node of yours publishes scans"
        )
        yield Remark(Kind.UNLIKE, "sim: robot", reason)
    if driven.is_fused or "odom_tf" in robot.drive.publishes:
        return
    frames = f"{robot.drive.odometry_frame} -> {robot.urdf.root}"
    reason = (
        f"the robot's file publishes no transform {frames} (publish_odom_tf is false) and has no"
        " IMU to fuse: a filter of yours must, or --param sim:standard_topics:=true"
    )
    yield Remark(Kind.UNLIKE, f"{LOCAL_COSTMAP.name}: global_frame", reason)


def other_names(
    parameters: Parameters, driven: Driven, groups: Iterable[Group], namespace: str = ""
) -> Iterator[Remark]:
    """Yield the topics, frames and transforms that nothing gives where a simulated robot drives.

    Odometry may come from robot_localization's nodes, by any name, where a file has them.

    Raises:
        ArjunaError: The robot's file cannot be used.
    """
    from arjuna_sim.inputs import frames_and_topics, names_of

    its, given = names_of(driven.robot, driven.is_fused), frames_and_topics(driven.robot)
    if fused := fusion_nodes(parameters):
        del given["odom_topic"], given["odom_frame"]
    found: dict[tuple[str, str], dict[str, list[str]]] = {}
    for spec in (spec for group in groups for spec in group.nodes if spec != EKF):
        values = parameters.get(spec.name, {})
        if spec == VELOCITY_SMOOTHER and values.get("feedback") != "CLOSED_LOOP":
            continue  # it does not listen
        keys = keys_by_name(spec, values)
        for what, its_own in given.items():
            valid = its_own | _MAPS.get(what, set())
            if namespace and what.endswith("topic"):  # said with the namespace or within it
                valid |= {name.removeprefix(f"{namespace}/") for name in its_own}
            for key in keys[what] if its_own else ():
                name = str(values.get(key) or "").removeprefix(f"/{namespace}/").strip("/")
                if name and name not in valid:
                    found.setdefault((what, name), {}).setdefault(key, []).append(spec.name)
    for (what, name), nodes in found.items():
        (where, *others) = (f"{node}: {key}" for key, of in nodes.items() for node in of)
        own = its.get(what, _STANDARD[what]).partition(" ")[0]
        advice = " ".join(
            f"--param '{of[0] + ':' if len(of) == 1 else ''}{key}:={own}'"
            for key, of in nodes.items()
        )
        too = f" (also {', '.join(others)})" if others else ""
        reason = f"'{name}', but the robot's own is '{own}'{too}: if no node of yours gives it,"
        yield Remark(Kind.UNLIKE, where, f"{reason} {advice}")
    nodes_of = [node for group in groups for node in group.nodes]
    if AMCL in nodes_of and not fused and not parameters.get(AMCL.name, {}).get(_MAP_TF, True):
        advice = f"map -> odom: if no node of yours does, --param '{AMCL.name}:{_MAP_TF}:=true'"
        yield Remark(Kind.UNLIKE, f"{AMCL.name}: {_MAP_TF}", f"false, and nothing gives {advice}")
    if COLLISION_MONITOR in nodes_of:
        own = driven.robot.drive.command_topic.strip("/")
        yield from _other_commands(parameters, own, namespace)


def _other_commands(parameters: Parameters, own: str, namespace: str) -> Iterator[Remark]:
    """Yield where the chain of velocities ends elsewhere than on the robot's own topic.

    The monitor is its last, or the smoother where it takes what the monitor lets pass.
    """

    def topic(node: str, end: str, usual: str) -> str:
        name = str(parameters.get(node, {}).get(f"cmd_vel_{end}_topic") or usual)
        return name.removeprefix(f"/{namespace}/" if namespace else "/").strip("/")

    own = own.removeprefix(f"{namespace}/" if namespace else "")
    monitor, smoother = COLLISION_MONITOR.name, VELOCITY_SMOOTHER.name
    passed, taken = topic(monitor, "out", "cmd_vel"), topic(monitor, "in", "cmd_vel_smoothed")
    is_first = topic(smoother, "in", "cmd_vel_nav") == passed
    if own == (topic(smoother, "out", taken) if is_first else passed):
        return
    where, advice = f"{monitor}: cmd_vel_out_topic", f"--param '{monitor}:cmd_vel_out_topic:={own}'"
    reason = (
        f"'{passed}', but the robot's own is '{own}': if no node of yours passes it on, {advice}"
    )
    if bypassed := taken == own:
        reason = f"'{passed}', but the robot's own is '{own}', what comes to the monitor: it drives"
        reason += f" unwatched; --param '{monitor}:cmd_vel_in_topic:=cmd_vel_smoothed' {advice}"
    yield Remark(Kind.UNLIKE, where, reason, safety=bypassed)


def _of_another_robot(
    parameters: Parameters, driven: Driven, groups: Iterable[Group], simulated: bool
) -> Parameters:
    from arjuna_sim.inputs import axle_of, footprint_of, names_of, ramps_of, turning_radius_of

    robot, shipped = driven.robot, shipped_parameters()

    def is_set(node: str, key: str) -> bool:
        """Return whether a file gives a value that is not the shipped one."""
        return bool(parameters.get(node, {}).get(key) != shipped.get(node, {}).get(key))

    found = Parameters()
    if simulated:
        is_fused = driven.is_fused
        named = of_names(names_of(robot, is_fused), groups, parameters, is_set)
        found = merged(named, _heights(robot, parameters), _BY_GYRO if is_fused else {})
    radius = round(turning_radius_of(robot), 4)
    own = {
        node: {key: value for key, value in values.items() if not is_set(node, key)}
        for node, values in merged(found, _by_reach(robot, radius, shipped)).items()
    }
    for node, prefix in _OUTLINES.items():
        frame = _base_frame(merged(parameters, own), node, prefix)
        if not any(is_set(node, f"{prefix}{key}") for key in OUTLINE):
            outline = footprint_of(robot, frame)
            own = merged(own, {node: {f"{prefix}footprint": outline}} if outline else {})
        if (axle := round(axle_of(robot, frame), 3)) and not is_set(node, f"{prefix}axle"):
            own = merged(own, {node: {f"{prefix}axle": axle}})
    own = merged(own, _ramps(parameters, shipped, *ramps_of(robot)))
    return merged(own, _in_bends(parameters, shipped, radius)) if radius else own


def _by_reach(robot: Any, radius: float, shipped: Parameters) -> Parameters:
    """Return what follows from how far a robot sees, how large it is and how wide it bends."""
    from arjuna_nav.exploration.frontiers import ExplorationConfig
    from arjuna_sim.inputs import footprint_of, sight_of

    found: Parameters = {node: {_RADIUS: radius} for node in _STEERED} if radius else {}
    if 0.0 < (sight := sight_of(robot)) < ExplorationConfig.max_open_distance:
        found = merged(found, {"explorer": {_OPEN: sight}})
    window = _window(footprint_of(robot, ""), radius)
    local = LOCAL_COSTMAP.name
    sides = {key: window for key in ("width", "height") if window > shipped[local][key]}
    return merged(found, {local: sides} if sides else {})


def _window(outline: str, radius: float) -> int:
    """Return how wide a local costmap is that holds a robot a metre away, or a bend more [m]."""
    from arjuna_nav.costmap.footprint import Footprint

    reach = Footprint.parse(outline, 0.0, 0.0).circumscribed_radius if outline else 0.0
    return math.ceil(2.0 * (reach + 1.0 + radius))


def _ramps(parameters: Parameters, shipped: Parameters, linear: Any, angular: Any) -> Parameters:
    """Return what has the nodes reckon with a robot whose speeds change slower than is shipped.

    Commands change no faster: one that is to drive on and has hardly begun to is taken for stopped
    by what it touches.
    """
    braking = (linear.down, min(angular.up, angular.down))
    limits: dict[str, dict[str, Any]] = {
        node: {key: most for keys, most in zip(kinds, braking, strict=True) for key in keys}
        for node, kinds in _BRAKES.items()
    }
    pairs = [(ramp.up, ramp.down) for ramp in (linear, linear, angular)]
    limits[VELOCITY_SMOOTHER.name] = {
        "max_accel": [min(pair) for pair in pairs],
        "max_decel": [-max(pair) for pair in pairs],
    }
    found = Parameters()
    for node, values in limits.items():
        given, usual = parameters.get(node, {}), shipped[node]
        found[node] = {
            key: _nearer_zero(usual[key], most)
            for key, most in values.items()
            if given.get(key) == usual[key] != _nearer_zero(usual[key], most)
        }
    return {node: values for node, values in found.items() if values}


def _nearer_zero(usual: Any, most: Any) -> Any:
    """Return what is nearer to zero of two numbers, or of each two in lists."""
    if isinstance(usual, list):
        return [min(*pair, key=abs) for pair in zip(usual, most, strict=True)]
    return min(usual, most)


def _in_bends(parameters: Parameters, shipped: Parameters, radius: float) -> Parameters:
    """Return what has a steered robot plan and drive in bends, where no file gives another planner.

    The shipped controller does so whose file does not say whether it turns on the spot.
    """

    def planner(of: Parameters) -> dict[str, Any]:
        values = of.get("planner_server", {})
        return {key: value for key, value in values.items() if key.startswith("GridBased.")}

    found, controls = Parameters(), parameters.get("controller_server", {})
    if planner(parameters) == planner(shipped):
        bend = {"GridBased.minimum_turning_radius": radius}
        found["planner_server"] = {**_BENDING_PLANNER, **bend}
    key = "FollowPath.plugin"
    is_shipped = controls.get(key) == shipped["controller_server"][key]
    if is_shipped and not controls.keys() & _BENDING_CONTROLLER.keys():
        found["controller_server"] = dict(_BENDING_CONTROLLER)
    return found


def _heights(robot: Any, parameters: Parameters) -> Parameters:
    """Return between which heights clouds mark in the costmaps: from the ground to the robot's top.

    Heights are those of its root, which may be a wheel's radius above the ground. Of a layer with
    other heights than the shipped ones they stay as they are.
    """
    from arjuna_sim.inputs import heights_of

    at, found, shipped = heights_of(robot), Parameters(), shipped_parameters()
    for spec in (LOCAL_COSTMAP, GLOBAL_COSTMAP):
        node, values = spec.name, parameters.get(spec.name, {})
        layer = next(iter(keys_by_name(spec, values)["cloud_topic"]), "").partition(".")[0]
        keys = [f"{layer}.{key}" for key in ("min_obstacle_height", "max_obstacle_height")]
        low, high, edge = (shipped[node].get(key, 0.0) for key in (*keys, f"{layer}.z_resolution"))
        if not edge or any(parameters[node].get(k) != shipped[node].get(k) for k in keys):
            continue
        low, high = max(low, _SCATTER * at.scatter), max(high, at.top - at.ground)
        found[node] = {
            key: round(z + at.ground, 3) for key, z in zip(keys, (low, high), strict=True)
        }
        found[node][f"{layer}.origin_z"] = round(at.ground, 3)
        found[node][f"{layer}.z_voxels"] = max(10, math.ceil(high / edge))
    return found


def _base_frame(parameters: Parameters, node: str = LOCAL_COSTMAP.name, prefix: str = "") -> str:
    return parameters.get(node, {}).get(f"{prefix}robot_base_frame") or "base_link"


def _left_out(
    parameters: Parameters,
    driven: Driven,
    costmaps: Iterable[NodeSpec],
    padded: bool = True,
) -> Iterator[tuple[str, str, str]]:
    """Give each parameter that leaves out some of the robot's body, the body, and the reason."""
    from arjuna_nav.costmap.footprint import Footprint
    from arjuna_sim.inputs import footprint_of

    for spec in costmaps:
        config: Any = load(spec.config, for_node(parameters, spec.name), spec.name)
        text = footprint_of(driven.robot, config.robot_base_frame)
        if not text:
            continue
        given = config.footprint, config.robot_radius, config.footprint_padding * padded
        outline, body = Footprint.parse(*given), Footprint.parse(text, 0.0, 0.0)
        if not (out := outline.outreach(body)):
            continue
        if outline.circular:
            reach = f"reaches {body.circumscribed_radius:.3g} m from {config.robot_base_frame}"
            key, value = "robot_radius", f"{config.robot_radius:g} m"
        else:
            key, value = "footprint", " ".join(config.footprint.split())
            reach = f"stands out of it by {out:.2g} m"
        yield f"{spec.name}: {key}", text, f"{value}, but the robot's body {reach}"


def _sideways(parameters: Parameters, robot: Any) -> Iterator[tuple[str, str]]:
    """Give each controller's parameter that drives sideways, where the robot cannot.

    Where it can, the smoother's that lets nothing of it pass, as Nav2's own file does.
    """
    from arjuna_sim.inputs import moves_sideways

    able, most = (
        moves_sideways(robot),
        parameters.get(VELOCITY_SMOOTHER.name, {}).get("max_velocity"),
    )
    server = parameters.get(CONTROLLER_SERVER.name, {})
    for name in server.get("controller_plugins", ()):
        model, speed = (server.get(f"{name}.{key}") for key in ("motion_model", "max_vel_y"))
        if model == "Omni":
            key, value, own = "motion_model", "Omni", "DiffDrive"
        elif speed:
            key, value, own = "max_vel_y", f"{speed:g} m/s", "0.0"
        else:
            continue
        if not able:
            advice = f"--param '{name}.{key}:={own}'"
            where = f"{CONTROLLER_SERVER.name}: {name}.{key}"
            yield where, f"{value}, but the robot's wheels do not move it sideways; {advice}"
        elif most and not most[1]:
            reason = f"none sideways, where '{name}' drives so: the robot stands for it"
            yield f"{VELOCITY_SMOOTHER.name}: max_velocity", f"{most}: {reason}"


def _other_bends(parameters: Parameters, robot: Any) -> Iterator[tuple[str, str]]:
    """Give each parameter that contradicts the robot's steering, and the reason."""
    from arjuna_sim.inputs import turning_radius_of

    radius = turning_radius_of(robot)
    for node in _STEERED:
        said = parameters.get(node, {}).get(_RADIUS, 0.0)
        where = f"{node}: {_RADIUS}"
        if not radius and said:
            yield where, f"{said:g} m, but the robot's file has no steering: it turns"
        elif said < radius - 1e-3:
            bend = f"the robot's file allows bends of {radius:.3g} m"
            yield where, f"{said:g} m is tighter than {bend}"


def _ground(parameters: Parameters, robot: Any) -> Iterator[tuple[str, str]]:
    """Give each height of points above which the ground that the robot's camera sees marks."""
    from arjuna_sim.inputs import frames_and_topics, heights_of

    at, own = heights_of(robot), frames_and_topics(robot)["cloud_topic"]
    least = at.ground + _SCATTER * at.scatter  # all of it; of one scatter, a sixth marks
    for spec in (LOCAL_COSTMAP, GLOBAL_COSTMAP):
        values = flatten(load(spec.config, for_node(parameters, spec.name), spec.name))
        for source in (key.removesuffix(".topic") for key in values if key.endswith(".topic")):
            of = {key: values.get(f"{source}.{key}") for key in ("data_type", "marking", "topic")}
            if of["data_type"] != "PointCloud2" or not of["marking"]:
                continue
            keys = [f"{one}.min_obstacle_height" for one in (source, source.rpartition(".")[0])]
            low = max(values.get(key, -math.inf) for key in keys)
            if low < at.ground + at.scatter and str(of["topic"]).strip("/") in own:
                seen = f"{low:g} m, but the robot's camera sees the ground up to {least:.2g} m"
                advice = f"--param '{keys[0]}:={math.ceil(least * 100.0) / 100.0}'"
                yield f"{spec.name}: {keys[0]}", f"{seen}: it marks obstacles; {advice}"
