"""The Numba functions that robots call, with the types of their arguments, as plain values."""

from __future__ import annotations

import importlib
import json
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numba.core import types
from numba.core.dispatcher import Dispatcher

Entry = tuple[str, str, list[Any]]
_ARRAY = re.compile(r"(\w+)\[(\d)([ACF])(r?)\]")


def use_all() -> None:
    """Run a demo and all that it seldom does."""
    from arjuna_nav.costmap.footprint import Footprint
    from arjuna_nav.planners.outline import relaxed_inscribed
    from arjuna_nav.planners.waves.potential import reachable
    from arjuna_sim.model.geometry.thickness import depths
    from arjuna_sim.physics.walkers import put_bodies

    _drive_demo()
    reachable(np.zeros((1, 1), np.uint8), np.ones(256, np.float32), np.zeros((1, 2)))
    depths(np.zeros((1, 3, 3)), np.zeros((1, 3)), 0.1)
    one, whole = np.zeros(1), np.zeros(1, np.int64)
    ways = np.ones(1), one, np.zeros((1, 1)), np.zeros((1, 1, 4))
    put_bodies(one, *ways, whole, np.zeros((1, 3)), np.zeros((1, 4)))
    relaxed_inscribed(np.zeros((1, 1), np.uint8), 1.0)
    Footprint.parse("[[1, 0], [0, 1], [-1, -1]]", 0.0, 0.0).holds(np.zeros((1, 2)))
    _escape()
    for parameters in _each_plugin():
        _drive(parameters, as_nav2=False)
        _drive(parameters, as_nav2=True)


def _escape() -> None:
    """Leave tight spots: round a box ahead, and through a gap that is as narrow as the robot."""
    from arjuna_core.config import load
    from arjuna_core.grid import GridFrame, OccupancyGrid
    from arjuna_core.se2 import SE2
    from arjuna_core.twist import STILL
    from arjuna_nav.controllers.escape import Escape, EscapeConfig
    from arjuna_nav.controllers.tracker import TrackerConfig
    from arjuna_nav.costmap.config import CostmapConfig
    from arjuna_nav.costmap.footprint import Footprint
    from arjuna_nav.costmap.layered import LayeredCostmap

    corners = "[[0.3, 0.15], [-0.3, 0.15], [-0.3, -0.15], [0.3, -0.15]]"
    body = Footprint.parse(corners, 0.0, 0.0)
    values = {"plugins": ("static_layer", "inflation_layer"), "footprint": corners}
    config = load(CostmapConfig, {**values, "resolution": 0.05, "footprint_padding": 0.0})
    path = np.column_stack((np.linspace(2.0, 5.0, 61), np.full(61, 1.5), np.zeros(61)))
    for rows in ((slice(27, 33),), (slice(0, 26), slice(34, 60))):
        data = np.zeros((60, 120), np.int8)
        for each in rows:
            data[each, 56:62] = 100
        costmap, pose = LayeredCostmap(config), SE2(2.0, 1.5)
        costmap.set_map(OccupancyGrid(GridFrame(0.05, 120, 60), data))
        escape = Escape(EscapeConfig(), TrackerConfig(), body, body)
        if not escape.begin(pose, path, costmap.costmap):
            raise RuntimeError(f"no trajectory past {rows}")
        for tick in range(200):
            command = escape.compute(pose, STILL, path, costmap.costmap, 0.05 * tick)
            if command is None or escape.can_hand_over(pose, path, costmap.costmap):
                break
            pose = pose @ SE2.exp(0.05 * np.array([command.x, 0.0, command.yaw_rate]))


def _each_plugin() -> Iterator[dict[str, Any]]:
    """Yield parameters so that each controller, planner, layer and kind of drive is in some."""
    from arjuna_nav.controllers.mppi.config import NAV2_CRITICS
    from arjuna_nav.controllers.plugins import CONTROLLERS
    from arjuna_nav.planners.base import PLANNERS

    hybrid, mppi = "nav2_smac_planner::SmacPlannerHybrid", "nav2_mppi_controller::MPPIController"
    for name, planner in zip_longest(CONTROLLERS.types, PLANNERS.types):
        shim = {"FollowPath.primary_controller": mppi} if "Shim" in (name or "") else {}
        yield {
            "controller_server": {"FollowPath.plugin": name, **shim} if name else {},
            "planner_server": {"GridBased.plugin": planner} if planner else {},
        }
    yield {
        "controller_server": {
            "FollowPath.plugin": mppi,
            "FollowPath.motion_model": "Omni",
            "FollowPath.critics": list(NAV2_CRITICS),
        },
        "local_costmap": {"plugins": ["obstacle_layer", "denoise_layer", "inflation_layer"]},
    }
    steered = {"min_turning_radius": 0.6}
    yield {
        "controller_server": {
            "FollowPath.plugin": mppi,
            "FollowPath.motion_model": "Ackermann",
            **steered,
        },
        "planner_server": {
            "GridBased.plugin": hybrid,
            "GridBased.motion_model_for_search": "REEDS_SHEPP",
            **steered,
        },
    }


def _drive(parameters: dict[str, Any], as_nav2: bool) -> None:
    """Drive a robot with parameters to a goal on the shipped map, where it turns back.

    Args:
        as_nav2: Whether Nav2's behaviour takes the place of our defaults.
    """
    from arjuna_core.files.shipped import shipped_file
    from arjuna_core.se2 import SE2
    from bringup.client.goals import Goals
    from bringup.lockstep import LockStep
    from bringup.parameters.files import merged, shipped_parameters
    from bringup.parameters.sources import as_theirs
    from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP, all_nodes

    room = {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))}
    known: dict[str, dict[str, Any]] = {
        "map_server": room,
        "amcl": {"set_initial_pose": True},
    }
    meant = [spec for spec in all_nodes() if spec.original == "nav2"] if as_nav2 else []
    base = as_theirs(merged(shipped_parameters(), parameters), meant, replaces=True)
    robot = LockStep(merged(base, known, parameters))
    with closing(robot):
        robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
        robot.run(1.0)  # until its pose is known
        goals = Goals(robot)
        goals.navigate(SE2(0.8, 0.8, 3.0), 6.0)
        goals.navigate(SE2(0.6, 0.6, 3.0), 1.0)  # as near as a controller is asked for headings


def _drive_demo() -> None:
    """Run a short demo with one waypoint in this process."""
    from arjuna_core.se2 import SE2
    from bringup.demo.demo import Demo, DemoOptions
    from bringup.parameters.files import shipped_parameters
    from bringup.terminal import Progress

    with tempfile.TemporaryDirectory() as folder:
        near, loop = (SE2(1.0, 1.0),), 75.0  # by then the graph has a loop to close
        options = DemoOptions(0, Path(folder), shipped_parameters(), near, explore_time=loop)
        Demo(options, Progress()).run()


def in_use() -> list[Entry]:
    """Return the functions that this process has loaded, with each one's types, sorted.

    One that compiled some has types of inner calls too, which no list holds.
    """
    found: dict[int, tuple[str, str, Any]] = {}
    for module in sorted(name for name in sys.modules if name.startswith("arjuna_")):
        for name, value in vars(sys.modules[module]).items():
            if isinstance(value, Dispatcher) and hasattr(
                getattr(value, "_cache", None), "cache_path"
            ):
                own = value.py_func.__module__ == module
                if own or id(value) not in found:
                    found[id(value)] = (module, name, value)
    entries = [
        (module, name, [encode(each) for each in arguments])
        for module, name, function in found.values()
        for arguments in function.overloads
    ]
    return sorted(entries, key=json.dumps)


def encode(kind: Any) -> Any:
    """Return a Numba type as what JSON holds.

    Raises:
        TypeError: It is of a sort that `decode` does not know.
    """
    if isinstance(kind, types.Array) and kind.aligned:
        return f"{encode(kind.dtype)}[{kind.ndim}{kind.layout}{'' if kind.mutable else 'r'}]"
    if isinstance(kind, types.BaseTuple):
        cls = getattr(kind, "instance_class", None)  # a named tuple's
        head = "tuple" if cls is None else f"{cls.__module__}:{cls.__name__}"
        parts: Any = kind
        return [head, *map(encode, parts)]
    if isinstance(kind, types.IntegerLiteral):
        return ["literal", kind.literal_value]
    if isinstance(kind, types.Number | types.Boolean | types.NoneType):
        return str(kind)
    raise TypeError(f"no encoding for {kind!r}")


def decode(value: Any) -> Any:
    """Return the Numba type that `encode` made a value of."""
    if isinstance(value, str):
        return _decode_word(value)
    head, *rest = value
    if head == "literal":
        return types.literal(rest[0])
    parts = [decode(each) for each in rest]
    if head == "tuple":
        return types.Tuple(parts)
    module, _, name = head.partition(":")
    cls = getattr(importlib.import_module(module), name)
    same = len(set(parts)) == 1
    return types.NamedUniTuple(parts[0], len(parts), cls) if same else types.NamedTuple(parts, cls)


def _decode_word(word: str) -> Any:
    if array := _ARRAY.fullmatch(word):
        layout: Any = array[3]
        return types.Array(_decode_word(array[1]), int(array[2]), layout, readonly=bool(array[4]))
    return {"bool": types.boolean, "none": types.none}.get(word) or getattr(types, word)
