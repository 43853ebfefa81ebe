"""The entities as clients know them: by name, in frames, and as filters choose them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import re2
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityInfo,
    EntityState,
    Result,
    TagsFilter,
)

from arjuna_core.arrays import Floats
from arjuna_core.errors import nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.entities import Entity, EntityMotion, entity_of_robot
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.messages import WORLD, motion_msg, pose3_from_msg
from arjuna_sim.nodes.services.host import RequestError
from arjuna_sim.simulation import Simulation

ALIAS = "robot"
"""A name for the simulator's own robot, whatever its file calls it."""


def matching(found: list[tuple[Entity, EntityInfo, Any]], filters: Any) -> list[Entity]:
    """Return the entities that pass all of an EntityFilters message, in their order.

    Args:
        found: Each entity with its description and its pose in the world.

    Raises:
        RequestError: The pattern is no regular expression, or the bounds cannot be used.
    """
    name = _pattern(filters.filter)
    categories = {item.category for item in filters.categories}
    inside = _space(filters.bounds)
    return [
        entity
        for entity, info, pose in found
        if name.search(entity.name)
        and (not categories or info.category.category in categories)
        and _tagged(info.tags, filters.tags)
        and (inside is None or _overlaps(inside, entity.corners(pose3_from_msg(pose))))
    ]


def _pattern(text: str) -> Any:
    """Return an expression, which RE2 searches in time linear in the text, whatever it is."""
    options = re2.Options()
    options.log_errors = False
    try:
        return re2.compile(text, options)
    except re2.error as error:
        reason = error.args[0].decode("utf-8", "replace")
        problem = f"the filter '{text}' is no regular expression of RE2: {reason}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem) from error


def _tagged(tags: list[str], wanted: TagsFilter) -> bool:
    if not wanted.tags:
        return True
    held = [tag in tags for tag in wanted.tags]
    return all(held) if wanted.filter_mode == TagsFilter.FILTER_MODE_ALL else any(held)


def _space(bounds: Bounds) -> tuple[int, Floats] | None:
    if bounds.type == Bounds.TYPE_EMPTY:
        return None
    if bounds.type not in (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE):
        problem = f"bounds of type {bounds.type} are not supported; valid: 1 (box), 3 (sphere)"
        raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
    points = np.array([[p.x, p.y, p.z] for p in bounds.points]).reshape(-1, 3)
    if len(points) != 2 or not np.isfinite(points).all():
        problem = f"bounds of a box or sphere need 2 finite points, got {len(points)}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
    return bounds.type, points


def _overlaps(space: tuple[int, Floats], corners: Floats) -> bool:
    """Return whether a box or sphere meets the upright box around corners."""
    kind, (first, second) = space
    low, high = corners.min(axis=0), corners.max(axis=0)
    if kind == Bounds.TYPE_SPHERE:
        nearest = np.clip(first, low, high)
        return bool(np.linalg.norm(nearest - first) <= second[0])
    least, greatest = np.minimum(first, second), np.maximum(first, second)
    return bool((low <= greatest).all() and (high >= least).all())


class KnownEntities:
    """The robots, and what the stage holds.

    Attributes:
        infos: Descriptions and tags that clients gave, by name.
    """

    def __init__(self, simulator: Simulation) -> None:
        self._simulator = simulator
        self._entities: dict[str, tuple[DrivenRobot, Entity]] = {}
        self.infos: dict[str, EntityInfo] = {}

    def all(self) -> list[Entity]:
        """Return the robots, and what the stage holds."""
        robots = [self._entity(robot) for robot in self._simulator.robots.values()]
        taken = {robot.name for robot in robots}
        return [*robots, *(e for e in self._simulator.stage.entities if e.name not in taken)]

    def _entity(self, robot: DrivenRobot) -> Entity:
        known = self._entities.get(robot.name)
        if known is None or known[0] is not robot:
            entity = entity_of_robot(robot.model.urdf)
            if robot.name != SOLO:
                entity = dataclasses.replace(entity, name=robot.name)
            known = self._entities[robot.name] = robot, entity
        return known[1]

    def robot(self, entity: Entity) -> DrivenRobot | None:
        """Return the robot that an entity is, None where it is none."""
        found = (each for each in self._simulator.robots.values() if self._entity(each) is entity)
        return next(found, None)

    def find(self, name: str) -> Entity:
        """Return the entity of a name.

        Raises:
            RequestError: There is none; the message names the nearest.
        """
        wanted = name.strip("/")
        entities = {entity.name: entity for entity in self.all()}
        if wanted == ALIAS and wanted not in entities and SOLO in self._simulator.robots:
            return self._entity(self._simulator.robots[SOLO])
        if wanted not in entities:
            problem = f"entity '{name}' does not exist; {nearest(wanted, [*entities, ALIAS])}"
            raise RequestError(Result.RESULT_NOT_FOUND, problem)
        return entities[wanted]

    def state(self, entity: Entity) -> EntityState:
        """Return where an entity is and how it moves."""
        simulator, robot = self._simulator, self.robot(entity)
        if robot is None:
            return motion_msg(simulator.stage.motion(entity.name), simulator.time)
        true = robot.truth()
        motion = EntityMotion(true.pose3, (true.v, true.side, 0.0), (0.0, 0.0, true.w))
        return motion_msg(motion, simulator.time)

    def info(self, entity: Entity) -> EntityInfo:
        """Return what a client said of an entity, or else what its file says."""
        category = EntityCategory(category=entity.category.value)
        plain = EntityInfo(category=category, description=entity.description)
        return self.infos.get(entity.name, plain)

    def pose(self, frame: str, message: Any, invalid: int) -> Pose3:
        """Return a client's pose in the world; its frame is an entity's, the world's or empty.

        Raises:
            RequestError: It is not finite, no rotation, too far away or in no known frame.
        """
        try:
            pose = pose3_from_msg(message)
        except ValueError as error:
            raise RequestError(invalid, str(error)) from error
        frame = frame.strip("/")
        if frame in ("", WORLD):
            return pose
        names = [entity.name for entity in self.all()]
        if frame not in names and frame != ALIAS:
            problem = f"frame '{frame}' is unknown; {nearest(frame, [WORLD, *names])}"
            raise RequestError(invalid, problem)
        return pose3_from_msg(self.state(self.find(frame)).pose) @ pose
