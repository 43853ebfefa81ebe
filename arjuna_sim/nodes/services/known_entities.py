"""The entities as clients know them: by name, with what clients say of them, and in frames."""

from __future__ import annotations

import dataclasses
from typing import Any

from simulation_interfaces.msg import EntityCategory, EntityInfo, EntityState, Result

from arjuna_core.errors import nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.entities import Entity, entity_of_robot
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.messages import WORLD, entity_state, motion_msg, pose3_from_msg
from arjuna_sim.nodes.services.results import RequestError
from arjuna_sim.simulation import Simulation

ALIAS = "robot"
"""A name for the simulator's own robot, whatever its file calls it."""


class KnownEntities:
    """The robots, and what the stage holds.

    Args:
        simulator: Holds them.

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
        """Return a robot as an entity; the simulator's own has the name of its file."""
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
        simulator = self._simulator
        robot = self.robot(entity)
        if robot is not None:
            return entity_state(robot.truth(), simulator.time)
        return motion_msg(simulator.stage.motion(entity.name), simulator.time)

    def info(self, entity: Entity) -> EntityInfo:
        """Return what a client said of an entity, or else what its file says."""
        category = EntityCategory(category=entity.category.value)
        plain = EntityInfo(category=category, description=entity.description)
        return self.infos.get(entity.name, plain)

    def pose(self, frame: str, message: Any, invalid: int) -> Pose3:
        """Return a pose that a client gave, in the world.

        Args:
            frame: The frame it is given in: empty, the world's or an entity's.
            message: The Pose message.
            invalid: The result's code where it is no pose.

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
