"""Filters of robot_localization that a parameter file brings: the topics that connect them."""

from __future__ import annotations

import re
from typing import Any

from bringup.parameters.files import Parameters, for_node
from bringup.stack import SIM, estimates_in_odom, fusion_nodes, is_filter

_ODOMETRY = re.compile(r"odom\d+")
_LOCAL, _GLOBAL = "odometry/local", "odometry/global"


def between_filters(parameters: Parameters) -> Parameters:
    """Return the topics that connect a file's filters, where launch files remap them otherwise.

    Of several, the one in odom and the one in map have the topics of robot_localization's own
    launch file, whose conversion of GPS takes that in map. The wheels of a simulated robot have
    their file's topic, without a transform, where a filter in odom takes the place of ours, unless
    it listens to ours.
    """
    from arjuna_sim.model.settings import WHEEL_ODOMETRY

    nodes = fusion_nodes(parameters)
    filters = {one.name: for_node(parameters, one.name) for one in nodes if is_filter(one)}
    in_odom = {name for name, values in filters.items() if estimates_in_odom(values)}
    found: dict[str, dict[str, Any]] = {}
    if in_odom and len(filters) > len(in_odom):
        topics = {one.name: _LOCAL if one.name in in_odom else _GLOBAL for one in nodes}
        for name, topic in topics.items():
            if "odom_topic" not in for_node(parameters, name):
                found[name] = {"odom_topic": topic}
    heard = (
        str(topic).strip("/")
        for name in in_odom
        for key, topic in filters[name].items()
        if _ODOMETRY.fullmatch(key)
    )
    if in_odom and WHEEL_ODOMETRY not in heard and "wheel_odometry" not in parameters[SIM.name]:
        found[SIM.name] = {"wheel_odometry": ""}
    return found
