"""simulation_interfaces: what is in the world, where it is, and how it comes and goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simulation_interfaces.msg import (
    EntityCategory,
    EntityInfo,
    Result,
    SimulationState,
)
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    SetEntityInfo,
    SetEntityState,
)

from arjuna_core.errors import nearest
from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import (
    Entity,
    EntityMotion,
    PlaceTakenError,
    entity_of_robot,
)
from arjuna_sim.nodes.messages import (
    WORLD,
    box_msg,
    entity_state,
    motion_msg,
    pose3_from_msg,
)
from arjuna_sim.nodes.services.entity_filters import FilterError, matching
from arjuna_sim.nodes.services.results import OK, RequestError

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

ALIAS = "robot"


class EntityServices:
    """Serves what concerns entities: the robot, and what the stage holds.

    Args:
        node: The simulator's node, being configured.
    """

    def __init__(self, node: SimNode) -> None:
        self._node = node
        self._robot = entity_of_robot(node.simulator.robot.urdf)
        self._infos: dict[str, EntityInfo] = {}
        for service, name, answer in (
            (GetEntities, "get_entities", self._get_entities),
            (GetEntitiesStates, "get_entities_states", self._get_entities_states),
            (GetEntityState, "get_entity_state", self._get_entity_state),
            (SetEntityState, "set_entity_state", self._set_entity_state),
            (GetEntityInfo, "get_entity_info", self._get_entity_info),
            (SetEntityInfo, "set_entity_info", self._set_entity_info),
            (GetEntityBounds, "get_entity_bounds", self._get_entity_bounds),
            (DeleteEntity, "delete_entity", self._delete),
        ):
            node.serve(service, name, self.answering(answer))

    def answering(self, answer: Any) -> Any:
        """Wrap a callback: what it raises becomes the response's result."""

        def callback(request: Any, response: Any) -> Any:
            response.result = OK
            try:
                if self._node.state == SimulationState.STATE_NO_WORLD:
                    problem = "no world is loaded; load one first"
                    raise RequestError(Result.RESULT_INCORRECT_STATE, problem)
                answer(request, response)
            except RequestError as error:
                response.result = error.result
            return response

        return callback

    def reset(self) -> None:
        """Forget descriptions and tags that clients gave."""
        self._infos.clear()

    def entities(self) -> list[Entity]:
        """Return the robot, and what the stage holds."""
        return [self._robot, *self._node.simulator.stage.entities]

    def _find(self, name: str) -> Entity:
        wanted = name.strip("/")
        entities = {entity.name: entity for entity in self.entities()}
        if wanted == ALIAS and wanted not in entities:
            return self._robot
        if wanted not in entities:
            problem = f"entity '{name}' does not exist; {nearest(wanted, [*entities, ALIAS])}"
            raise RequestError(Result.RESULT_NOT_FOUND, problem)
        return entities[wanted]

    def _motion(self, entity: Entity) -> EntityMotion:
        return self._node.simulator.stage.motion(entity.name)

    def _state(self, entity: Entity) -> Any:
        simulator = self._node.simulator
        if entity is self._robot:
            return entity_state(simulator.truth(), simulator.time)
        return motion_msg(self._motion(entity), simulator.time)

    def _info(self, entity: Entity) -> EntityInfo:
        known = self._infos.get(entity.name)
        category = EntityCategory(category=entity.category.value)
        return known or EntityInfo(category=category, description=entity.description)

    def _matching(self, filters: Any) -> list[Entity]:
        found = [(e, self._info(e), self._state(e).pose) for e in self.entities()]
        try:
            return matching(found, filters)
        except FilterError as error:
            raise RequestError(error.code, str(error)) from error

    def _get_entities(self, request: Any, response: Any) -> None:
        response.entities = [entity.name for entity in self._matching(request.filters)]

    def _get_entities_states(self, request: Any, response: Any) -> None:
        found = self._matching(request.filters)
        response.entities = [entity.name for entity in found]
        response.states = [self._state(entity) for entity in found]

    def _get_entity_state(self, request: Any, response: Any) -> None:
        response.state = self._state(self._find(request.entity))

    def _get_entity_info(self, request: Any, response: Any) -> None:
        response.info = self._info(self._find(request.entity))

    def _set_entity_info(self, request: Any, response: Any) -> None:
        self._infos[self._find(request.entity).name] = request.info

    def _get_entity_bounds(self, request: Any, response: Any) -> None:
        response.bounds = box_msg(*self._find(request.entity).bounds())

    def _delete(self, request: Any, response: Any) -> None:
        entity = self._find(request.entity)
        if entity is self._robot:
            problem = "the robot cannot be deleted, for the simulation is its own"
            raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
        self._node.simulator.stage.delete(entity.name)
        self._infos.pop(entity.name, None)

    def _set_entity_state(self, request: Any, response: Any) -> None:
        entity = self._find(request.entity)
        if request.set_twist or request.set_acceleration or not request.set_pose:
            problem = "only the pose can be set: set_pose true, set_twist, set_acceleration false"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        invalid = SetEntityState.Response.INVALID_POSE
        pose = self.pose(request.state.header.frame_id, request.state.pose, invalid)
        if entity is self._robot:
            self._move_robot(request, pose)
        elif entity.trajectory is not None:
            problem = f"'{entity.name}' follows its path; delete it and spawn it elsewhere"
            raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
        else:
            try:
                self._node.simulator.stage.move(entity.name, entity.lifted(pose))
            except PlaceTakenError as error:
                raise RequestError(invalid, str(error)) from error

    def _move_robot(self, request: Any, pose: Pose3) -> None:
        simulator = self._node.simulator
        touched = simulator.obstacles_at(pose.planar())
        if touched:
            problem = f"the place is taken by {', '.join(touched)}"
            raise RequestError(SetEntityState.Response.INVALID_POSE, problem)
        simulator.set_pose(pose.planar())

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
        names = [entity.name for entity in self.entities()]
        if frame not in names and frame != ALIAS:
            problem = f"frame '{frame}' is unknown; {nearest(frame, [WORLD, *names])}"
            raise RequestError(invalid, problem)
        return pose3_from_msg(self._state(self._find(frame)).pose) @ pose
