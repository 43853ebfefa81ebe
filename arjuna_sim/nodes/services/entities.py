"""simulation_interfaces: what is in the world, where it is and how it goes, and spawning it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from geometry_msgs.msg import Pose
from simulation_interfaces import srv
from simulation_interfaces.msg import Resource, Result, Spawnable, SpawnResult

from arjuna_core.errors import ArjunaError
from arjuna_core.files.whole_file import own_folder
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.library import ResourceError
from arjuna_sim.files.spawned import read_driven, read_entity
from arjuna_sim.files.xml_file import root_tag
from arjuna_sim.model.entities import BlockedPoseError, Entity, EntityError
from arjuna_sim.model.notes import gathered
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.model.world import Trajectory
from arjuna_sim.nodes.fleet import NamespaceError
from arjuna_sim.nodes.messages import box_msg
from arjuna_sim.nodes.services.host import (
    OK,
    Host,
    RequestError,
    resource_error,
    serve_all,
)
from arjuna_sim.nodes.services.known_entities import ALIAS, KnownEntities, matching
from arjuna_sim.nodes.sim_config import NAMESPACE

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./:-]{0,127}")
_EXAMPLES = ("box:0.5,0.5,1.0", "cylinder:0.2,1.0", "sphere:0.25", "person")


class EntityServices:
    """Serves what concerns entities: those that are there, and those to be spawned.

    Attributes:
        answers: What answers each service, by its name.
    """

    def __init__(self, host: Host, known: KnownEntities) -> None:
        self._host = host
        self._known = known
        self._texts: TemporaryDirectory[str] | None = None
        services = (
            (srv.GetEntities, "get_entities", self._get_entities),
            (srv.GetEntitiesStates, "get_entities_states", self._get_entities_states),
            (srv.GetEntityState, "get_entity_state", self._get_entity_state),
            (srv.SetEntityState, "set_entity_state", self._set_entity_state),
            (srv.GetEntityInfo, "get_entity_info", self._get_entity_info),
            (srv.SetEntityInfo, "set_entity_info", self._set_entity_info),
            (srv.GetEntityBounds, "get_entity_bounds", self._get_entity_bounds),
            (srv.DeleteEntity, "delete_entity", self._delete),
            (srv.GetSpawnables, "get_spawnables", self._get_spawnables),
            (srv.SpawnEntity, "spawn_entity", self._spawn),
            (srv.SpawnEntities, "spawn_entities", self._spawn_all),
        )
        self.answers = serve_all(host, services, in_world=host)

    def _matching(self, filters: Any) -> list[Entity]:
        known = self._known
        return matching([(e, known.info(e), known.state(e).pose) for e in known.all()], filters)

    def _get_entities(self, request: Any, response: Any) -> None:
        response.entities = [entity.name for entity in self._matching(request.filters)]

    def _get_entities_states(self, request: Any, response: Any) -> None:
        found = self._matching(request.filters)
        response.entities = [entity.name for entity in found]
        response.states = [self._known.state(entity) for entity in found]

    def _get_entity_state(self, request: Any, response: Any) -> None:
        response.state = self._known.state(self._known.find(request.entity))

    def _get_entity_info(self, request: Any, response: Any) -> None:
        response.info = self._known.info(self._known.find(request.entity))

    def _set_entity_info(self, request: Any, response: Any) -> None:
        self._known.infos[self._known.find(request.entity).name] = request.info

    def _get_entity_bounds(self, request: Any, response: Any) -> None:
        response.bounds = box_msg(*self._known.find(request.entity).bounds())

    def _delete(self, request: Any, response: Any) -> None:
        entity = self._known.find(request.entity)
        robot = self._known.robot(entity)
        if robot is None:
            self._host.simulator.stage.delete(entity.name)
        elif robot.name == SOLO:
            problem = "the robot cannot be deleted, for the simulation is its own"
            raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
        else:
            self._host.fleet.remove(robot.name)
        self._known.infos.pop(entity.name, None)

    def _set_entity_state(self, request: Any, response: Any) -> None:
        entity = self._known.find(request.entity)
        if request.set_acceleration or not (request.set_pose or request.set_twist):
            problem = "valid: set_pose, set_twist or both; no acceleration can be set"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        state, invalid = request.state, srv.SetEntityState.Response.INVALID_POSE
        frame = self._known.pose(state.header.frame_id, Pose(), invalid)
        pose = self._known.pose(state.header.frame_id, state.pose, invalid)
        if entity.trajectory is not None:
            problem = f"'{entity.name}' follows its path; delete it and spawn it elsewhere"
            raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
        try:
            if request.set_pose:
                self._move(entity, pose)
            if request.set_twist:
                self._push(entity, state.twist, frame)
        except BlockedPoseError as error:
            raise RequestError(invalid, str(error)) from error
        except EntityError as error:
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, str(error)) from error

    def _push(self, entity: Entity, twist: Any, frame: Pose3) -> None:
        """Set the velocity of what moves freely; robots are driven."""
        v, w = twist.linear, twist.angular
        velocity = np.reshape((v.x, v.y, v.z, w.x, w.y, w.z), (2, 3)) @ frame.rotation().T
        if self._known.robot(entity) is not None:
            raise EntityError(f"'{entity.name}' is a robot: its velocity is commanded, not set")
        if not np.isfinite(velocity).all():
            raise EntityError("a velocity must be finite")
        self._host.simulator.stage.push(entity.name, velocity.ravel())

    def _move(self, entity: Entity, pose: Pose3) -> None:
        robot = self._known.robot(entity)
        if robot is None:
            self._host.simulator.stage.move(entity.name, entity.lifted(pose))
            return
        if touched := robot.obstacles_at(pose.planar()):
            raise BlockedPoseError(f"the pose is blocked by {', '.join(touched)}")
        robot.set_pose(pose.planar())

    def _get_spawnables(self, request: Any, response: Any) -> None:
        if request.sources:
            problem = "only the simulator's own sources are searched; leave sources empty"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        library = self._host.library
        uris = [*_EXAMPLES, *(str(folder) for folder in library.models())]
        abouts = dict.fromkeys(_EXAMPLES, "a simple shape; other sizes work as well")
        response.spawnables = [
            Spawnable(entity_resource=Resource(uri=uri), description=abouts.get(uri, "a model"))
            for uri in uris
        ]

    def _spawn(self, request: Any, response: Any) -> None:
        response.entity_name = self._spawn_one(request)

    def _spawn_all(self, request: Any, response: Any) -> None:
        for item in request.spawn_requests:
            result = SpawnResult(result=OK)
            try:
                result.entity_name = self._spawn_one(item)
            except RequestError as error:
                result.result = error.result
            response.results.append(result)
        failed = sum(r.result.result != Result.RESULT_OK for r in response.results)
        if failed:
            problem = f"{failed} of {len(response.results)} entities were not spawned"
            raise RequestError(srv.SpawnEntities.Response.ENTITIES_SPAWN_FAILED, problem)

    def _spawn_one(self, request: Any) -> str:
        codes = srv.SpawnEntity.Response
        if request.name and not _NAME.fullmatch(request.name):
            problem = f"name '{request.name}' is invalid; valid: letters, digits and _ . / : -"
            raise RequestError(codes.NAME_INVALID, problem)
        if not request.name and not request.allow_renaming:
            problem = "the name is empty; give one, or allow renaming"
            raise RequestError(codes.NAME_INVALID, problem)
        wanted = request.entity_namespace.removeprefix("/")
        if wanted and not NAMESPACE.fullmatch(wanted):
            problem = f"namespace '{request.entity_namespace}' is invalid; valid: as /a/b"
            raise RequestError(codes.NAMESPACE_INVALID, problem)
        what = request.entity_resource.uri, request.entity_resource.resource_string
        try:
            robot = read_driven(*what, self._host.library)
            entity = read_entity(*what, self._host.library, drives=robot is not None)
        except ResourceError as error:
            raise resource_error(codes, error) from error
        name = self._free_name(request.name or entity.name, request.allow_renaming)
        start = request.initial_pose
        pose = self._known.pose(start.header.frame_id, start.pose, codes.INVALID_POSE)
        if entity.mass == 0.0 or entity.trajectory is not None:
            robot = None
        for text in entity.notes if robot is None else gathered(robot.notes):
            self._host.get_logger().warning(f"'{name}': {text}")
        if robot is None:
            self._put(lambda: self._host.simulator.stage.spawn(placed(entity, name, pose)))
            return name
        namespace = (request.entity_namespace or name).strip("/")
        if not NAMESPACE.fullmatch(namespace):
            problem = f"a robot that drives needs an entity_namespace, for '{name}' cannot be one"
            raise RequestError(codes.NAMESPACE_INVALID, f"{problem}; valid: as /a/b")
        if not what[0].strip():
            robot = self._kept(robot, namespace, what[1])
        self._put(lambda: self._host.fleet.add(name, namespace, robot, pose.planar()))
        return name

    def _kept(self, robot: RobotModel, namespace: str, text: str) -> RobotModel:
        """Return a robot of a text with a file that holds it, which who drives it can read."""
        self._texts = self._texts or own_folder("spawned")
        ending = "sdf" if root_tag(text.encode()) == "sdf" else "urdf"
        path = Path(self._texts.name, f"{namespace.replace('/', '.')}.{ending}")
        path.write_text(text, encoding="utf-8")
        return dataclasses.replace(robot, urdf=dataclasses.replace(robot.urdf, path=path))

    def _put(self, put: Callable[[], None]) -> None:
        try:
            put()
        except NamespaceError as error:
            code = srv.SpawnEntity.Response.NAMESPACE_INVALID
            raise RequestError(code, str(error)) from error
        except BlockedPoseError as error:
            raise RequestError(srv.SpawnEntity.Response.INVALID_POSE, str(error)) from error
        except ArjunaError as error:  # MuJoCo refuses it
            code = srv.SpawnEntity.Response.RESOURCE_PARSE_ERROR
            raise RequestError(code, str(error)) from error

    def _free_name(self, name: str, renaming: bool) -> str:
        taken = {ALIAS, *(entity.name for entity in self._known.all())}
        if name not in taken:
            return name
        if not renaming:
            problem = f"the name '{name}' is taken; give another, or allow renaming"
            raise RequestError(srv.SpawnEntity.Response.NAME_NOT_UNIQUE, problem)
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
    return dataclasses.replace(entity, name=name, start=entity.lifted(pose), trajectory=path)
