"""People and boxes: asks a simulator, where one runs, what is in its world."""

from __future__ import annotations

from typing import Any

from simulation_interfaces.srv import GetEntitiesStates, GetEntityBounds, GetEntityInfo

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import seconds
from bringup.viewing.drawing.surroundings import Kind, bodies
from bringup.viewing.drawing.values import Bodies
from bringup.viewing.robot.services import Services


class EntityWatch:
    """Asks for the poses of all entities, and once for what each of them is.

    Args:
        services: The viewer's service clients.
    """

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
        poses = [
            (name, pose3(state.pose))
            for name, state in zip(response.entities, response.states, strict=True)
        ]
        stamps = [seconds(state.header.stamp) for state in response.states]
        self._newest = (max(stamps, default=0.0), poses)
        self._kinds = {name: kind for name, kind in self._kinds.items() if name in dict(poses)}
        self._names = [name for name, _ in poses]
        if not self._services.busy("get_entity_info"):
            self._ask_next_kind()

    def _ask_next_kind(self) -> None:
        """Learn what the next new entity is: its category, then its size."""
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

    def take(self, robot_frame: str) -> Bodies | None:
        """Return what stands around the robot since the last call, or None."""
        if self._newest is None:
            return None
        (stamp, poses), self._newest = self._newest, None
        found = bodies(self._kinds, poses)
        if found is None:
            return None
        return Bodies(frame=robot_frame, stamp=stamp, bodies=found)


def pose3(message: Any) -> Pose3:
    """Return a Pose or Transform message as a pose of space."""
    place = message.position if hasattr(message, "position") else message.translation
    turn = message.orientation if hasattr(message, "orientation") else message.rotation
    return Pose3((place.x, place.y, place.z), (turn.w, turn.x, turn.y, turn.z))
