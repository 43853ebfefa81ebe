"""People and boxes: asks a simulator, where one runs, about the entities of its world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from simulation_interfaces.msg import EntityCategory
from simulation_interfaces.srv import GetEntitiesStates, GetEntityBounds, GetEntityInfo

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import seconds
from bringup.viewing.drawing.messages import pose3
from bringup.viewing.drawing.solids import solids
from bringup.viewing.drawing.values import Colour, Parts
from bringup.viewing.robot.services import Services

ROBOT, HUMAN = EntityCategory.CATEGORY_ROBOT, EntityCategory.CATEGORY_HUMAN
_COLOURS: dict[int, Colour] = {
    HUMAN: (235, 140, 60),
    EntityCategory.CATEGORY_STATIC_OBJECT: (150, 150, 160),
}
Corner = tuple[float, float, float]


@dataclass(frozen=True)
class Kind:
    """An entity's category and the corners of its bounding box in its own frame [m]."""

    category: int
    low: Corner
    high: Corner


class EntityWatch:
    """Asks for the poses of all entities, and once for the category and size of each."""

    def __init__(self, services: Services) -> None:
        self._services = services
        self._kinds: dict[str, Kind] = {}
        self._names: list[str] = []
        self._newest: tuple[float, list[tuple[str, Pose3]]] | None = None

    def ask(self) -> None:
        """Ask for the poses, unless an answer is still due."""
        if not self._services.busy("get_entities_states"):
            self._services.ask(
                *(GetEntitiesStates, "get_entities_states", GetEntitiesStates.Request()),
                self._on_states,
            )

    def _on_states(self, response: Any) -> None:
        states = list(zip(response.entities, response.states, strict=True))
        stamp = max((seconds(state.header.stamp) for _, state in states), default=0.0)
        self._newest = (stamp, [(name, pose3(state.pose)) for name, state in states])
        self._names = [name for name, _ in states]
        self._kinds = {name: kind for name, kind in self._kinds.items() if name in self._names}
        if not self._services.busy("get_entity_info"):
            self._ask_next_kind()

    def _ask_next_kind(self) -> None:
        name = next((name for name in self._names if name not in self._kinds), None)
        if name is None:
            return

        def on_info(response: Any) -> None:
            category = response.info.category.category
            self._services.ask(
                *(GetEntityBounds, "get_entity_bounds", GetEntityBounds.Request(entity=name)),
                lambda bounds: self._learn(name, category, bounds.bounds.points),
            )

        request = GetEntityInfo.Request(entity=name)
        self._services.ask(GetEntityInfo, "get_entity_info", request, on_info)

    def _learn(self, name: str, category: int, points: Any) -> None:
        corners = [(p.x, p.y, p.z) for p in points]
        high, low = corners if len(corners) == 2 else ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self._kinds[name] = Kind(category, low, high)
        self._ask_next_kind()

    def take(self, robot_frame: str) -> Parts | None:
        """Return the bodies around the robot that came since the last call, or None."""
        if self._newest is None:
            return None
        (stamp, poses), self._newest = self._newest, None
        found = bodies(self._kinds, poses)
        if found is None:
            return None
        return {
            shape: solids(shape, rows, frame=robot_frame, stamp=stamp)
            for shape, rows in found.items()
        }


def bodies(
    kinds: Mapping[str, Kind], poses: Iterable[tuple[str, Pose3]]
) -> dict[str, list[Any]] | None:
    """Return rows of `solids` in the robot's frame by their shapes; None where there is no robot.

    People are cylinders, all else is boxes. A simulator's world and a map need not have the same
    origin; the robot is in both.

    Args:
        poses: All entities' poses in the world.
    """
    known = [(kinds[name], pose) for name, pose in poses if name in kinds]
    robots = [pose for kind, pose in known if kind.category == ROBOT]
    if not robots:
        return None
    T_robot_world = robots[0].inverse()
    found: dict[str, list[Any]] = {"cylinder": [], "box": []}
    for kind, pose in known:
        if kind.category != ROBOT and kind.low != kind.high:
            low, high = np.array(kind.low), np.array(kind.high)
            middle = T_robot_world @ pose @ Pose3(tuple(((low + high) / 2.0).tolist()))
            colour = _COLOURS.get(kind.category, (180, 140, 90))
            shape = "cylinder" if kind.category == HUMAN else "box"
            found[shape].append((middle.position, middle.quaternion, high - low, colour, 0.9))
    return found
