"""simulation_interfaces: what is in the world, where it is, and how it comes and goes."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any

from simulation_interfaces.msg import (
    EntityCategory,
    EntityInfo,
    Resource,
    Result,
    SimulationState,
    Spawnable,
    SpawnResult,
)
from simulation_interfaces.srv import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityBounds,
    GetEntityInfo,
    GetEntityState,
    GetSpawnables,
    SetEntityInfo,
    SetEntityState,
    SpawnEntities,
    SpawnEntity,
)

from arjuna_core.errors import ArjunaError, nearest
from arjuna_sim.actors import Trajectory
from arjuna_sim.entities import (
    Entity,
    EntityMotion,
    PlaceTakenError,
    entity_of_robot,
)
from arjuna_sim.entity_files import read_entity
from arjuna_sim.library import ResourceError
from arjuna_sim.nodes.entity_filters import FilterError, matching
from arjuna_sim.nodes.messages import (
    WORLD,
    box_msg,
    entity_state,
    motion_msg,
    pose3_from_msg,
)
from arjuna_sim.nodes.results import OK, refusal, resource_refusal
from arjuna_sim.pose3 import Pose3

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

ALIAS = "robot"
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./:-]{0,127}")
_NAMESPACE = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
_EXAMPLES = ("box:0.5,0.5,1.0", "cylinder:0.2,1.0", "sphere:0.25", "person")


class _RequestError(ArjunaError):
    """A request that is refused, with its result."""

    def __init__(self, code: int, problem: str) -> None:
        self.result = refusal(code, problem)
        super().__init__(problem)


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
            (GetSpawnables, "get_spawnables", self._get_spawnables),
            (DeleteEntity, "delete_entity", self._delete),
            (SpawnEntity, "spawn_entity", self._spawn),
            (SpawnEntities, "spawn_entities", self._spawn_all),
        ):
            node.serve(service, name, self._answering(answer))

    def _answering(self, answer: Any) -> Any:
        """Wrap a callback: what it raises becomes the response's result."""

        def callback(request: Any, response: Any) -> Any:
            response.result = OK
            try:
                if self._node.state == SimulationState.STATE_NO_WORLD:
                    problem = "no world is loaded; load one first"
                    raise _RequestError(Result.RESULT_INCORRECT_STATE, problem)
                answer(request, response)
            except _RequestError as error:
                response.result = error.result
            return response

        return callback

    def reset(self) -> None:
        """Forget descriptions and tags that clients gave."""
        self._infos.clear()

    def _entities(self) -> list[Entity]:
        return [self._robot, *self._node.simulator.stage.entities]

    def _find(self, name: str) -> Entity:
        wanted = name.strip("/")
        entities = {entity.name: entity for entity in self._entities()}
        if wanted == ALIAS and wanted not in entities:
            return self._robot
        if wanted not in entities:
            problem = f"entity '{name}' does not exist; {nearest(wanted, [*entities, ALIAS])}"
            raise _RequestError(Result.RESULT_NOT_FOUND, problem)
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
        found = [(e, self._info(e), self._state(e).pose) for e in self._entities()]
        try:
            return matching(found, filters)
        except FilterError as error:
            raise _RequestError(error.code, str(error)) from error

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

    def _get_spawnables(self, request: Any, response: Any) -> None:
        if request.sources:
            problem = "only the simulator's own sources are searched; leave sources empty"
            raise _RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        library = self._node.library
        uris = [*_EXAMPLES, *(str(folder) for folder in library.models())]
        abouts = dict.fromkeys(_EXAMPLES, "a simple shape; other sizes work as well")
        response.spawnables = [
            Spawnable(entity_resource=Resource(uri=uri), description=abouts.get(uri, "a model"))
            for uri in uris
        ]

    def _delete(self, request: Any, response: Any) -> None:
        entity = self._find(request.entity)
        if entity is self._robot:
            problem = "the robot cannot be deleted, for the simulation is its own"
            raise _RequestError(Result.RESULT_OPERATION_FAILED, problem)
        self._node.simulator.stage.delete(entity.name)
        self._infos.pop(entity.name, None)

    def _set_entity_state(self, request: Any, response: Any) -> None:
        entity = self._find(request.entity)
        if request.set_twist or request.set_acceleration or not request.set_pose:
            problem = "only the pose can be set: set_pose true, set_twist, set_acceleration false"
            raise _RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        invalid = SetEntityState.Response.INVALID_POSE
        pose = self._pose(request.state.header.frame_id, request.state.pose, invalid)
        if entity is self._robot:
            self._move_robot(request, pose)
        elif entity.trajectory is not None:
            problem = f"'{entity.name}' follows its path; delete it and spawn it elsewhere"
            raise _RequestError(Result.RESULT_OPERATION_FAILED, problem)
        else:
            try:
                self._node.simulator.stage.move(entity.name, pose)
            except PlaceTakenError as error:
                raise _RequestError(invalid, str(error)) from error

    def _move_robot(self, request: Any, pose: Pose3) -> None:
        simulator = self._node.simulator
        touched = simulator.obstacles_at(pose.planar())
        if touched:
            problem = f"the place is taken by {', '.join(touched)}"
            raise _RequestError(SetEntityState.Response.INVALID_POSE, problem)
        simulator.set_pose(pose.planar())

    def _pose(self, frame: str, message: Any, invalid: int) -> Pose3:
        """Return a pose that a client gave, in the world."""
        try:
            pose = pose3_from_msg(message)
        except ValueError as error:
            raise _RequestError(invalid, str(error)) from error
        frame = frame.strip("/")
        if frame in ("", WORLD):
            return pose
        names = [entity.name for entity in self._entities()]
        if frame not in names and frame != ALIAS:
            problem = f"frame '{frame}' is unknown; {nearest(frame, [WORLD, *names])}"
            raise _RequestError(invalid, problem)
        return pose3_from_msg(self._state(self._find(frame)).pose) @ pose

    def _spawn(self, request: Any, response: Any) -> None:
        response.entity_name = self._spawn_one(request)

    def _spawn_all(self, request: Any, response: Any) -> None:
        for item in request.spawn_requests:
            result = SpawnResult(result=OK)
            try:
                result.entity_name = self._spawn_one(item)
            except _RequestError as error:
                result.result = error.result
            response.results.append(result)
        failed = sum(r.result.result != Result.RESULT_OK for r in response.results)
        if failed:
            problem = f"{failed} of {len(response.results)} entities were not spawned"
            raise _RequestError(SpawnEntities.Response.ENTITIES_SPAWN_FAILED, problem)

    def _spawn_one(self, request: Any) -> str:
        """Spawn what a request asks for; return its name."""
        codes = SpawnEntity.Response
        if request.name and not _NAME.fullmatch(request.name):
            problem = f"name '{request.name}' is invalid; valid: letters, digits and _ . / : -"
            raise _RequestError(codes.NAME_INVALID, problem)
        if not request.name and not request.allow_renaming:
            problem = "the name is empty; give one, or allow renaming"
            raise _RequestError(codes.NAME_INVALID, problem)
        if request.entity_namespace and not _NAMESPACE.fullmatch(request.entity_namespace):
            problem = f"namespace '{request.entity_namespace}' is invalid; valid: as /a/b"
            raise _RequestError(codes.NAMESPACE_INVALID, problem)
        resource = request.entity_resource
        try:
            entity = read_entity(resource.uri, resource.resource_string, self._node.library)
        except ResourceError as error:
            raise _RequestError(*_parts(resource_refusal(codes, error))) from error
        name = self._free_name(request.name or entity.name, request.allow_renaming)
        start = request.initial_pose
        pose = self._pose(start.header.frame_id, start.pose, codes.INVALID_POSE)
        self._put(placed(entity, name, pose))
        return name

    def _put(self, entity: Entity) -> None:
        try:
            self._node.simulator.stage.spawn(entity)
        except PlaceTakenError as error:
            raise _RequestError(SpawnEntity.Response.INVALID_POSE, str(error)) from error
        except ArjunaError as error:  # MuJoCo refuses it
            code = SpawnEntity.Response.RESOURCE_PARSE_ERROR
            raise _RequestError(code, str(error)) from error

    def _free_name(self, name: str, renaming: bool) -> str:
        taken = {ALIAS, *(entity.name for entity in self._entities())}
        if name not in taken:
            return name
        if not renaming:
            problem = f"the name '{name}' is taken; give another, or allow renaming"
            raise _RequestError(SpawnEntity.Response.NAME_NOT_UNIQUE, problem)
        number = 1
        while f"{name}_{number}" in taken:
            number += 1
        return f"{name}_{number}"


def placed(entity: Entity, name: str, pose: Pose3) -> Entity:
    """Return an entity under a name at a pose, with its path; a free one stands on the ground."""
    path: Trajectory | None = entity.trajectory
    if path is not None:
        T = pose.planar()
        path = dataclasses.replace(path, poses=tuple(T @ point for point in path.poses))
    elif entity.mass > 0.0:
        lowest = float(entity.corners(pose)[:, 2].min())
        x, y, z = pose.position
        pose = Pose3((x, y, z - min(0.0, lowest)), pose.quaternion)
    return dataclasses.replace(entity, name=name, start=pose, trajectory=path)


def _parts(result: Result) -> tuple[int, str]:
    return result.result, result.error_message
