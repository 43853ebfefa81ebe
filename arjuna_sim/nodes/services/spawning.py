"""simulation_interfaces: what can be spawned, and spawning it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import Any

from simulation_interfaces.msg import Resource, Result, Spawnable, SpawnResult
from simulation_interfaces.srv import GetSpawnables, SpawnEntities, SpawnEntity

from arjuna_core.errors import ArjunaError
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.library import ResourceError
from arjuna_sim.files.spawned import read_driven, read_entity
from arjuna_sim.model.entities import BlockedPoseError, Entity
from arjuna_sim.model.world import Trajectory
from arjuna_sim.nodes.fleet import NamespaceError
from arjuna_sim.nodes.services.entities import in_world
from arjuna_sim.nodes.services.host import OK, Host, RequestError, resource_error
from arjuna_sim.nodes.services.known_entities import ALIAS, KnownEntities
from arjuna_sim.nodes.sim_config import NAMESPACE

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./:-]{0,127}")
_EXAMPLES = ("box:0.5,0.5,1.0", "cylinder:0.2,1.0", "sphere:0.25", "person")


class SpawnServices:
    """Serves what brings entities into the world.

    Attributes:
        answers: What answers each service, by its name.
    """

    def __init__(self, host: Host, known: KnownEntities) -> None:
        self._host = host
        self._known = known
        self.answers: dict[str, Callable[[Any, Any], Any]] = {}
        for service, name, answer in (
            (GetSpawnables, "get_spawnables", self._get_spawnables),
            (SpawnEntity, "spawn_entity", self._spawn),
            (SpawnEntities, "spawn_entities", self._spawn_all),
        ):
            self.answers[name] = in_world(host, answer)
            host.serve(service, name, self.answers[name])

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
            raise RequestError(SpawnEntities.Response.ENTITIES_SPAWN_FAILED, problem)

    def _spawn_one(self, request: Any) -> str:
        codes = SpawnEntity.Response
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
            entity = read_entity(*what, self._host.library)
            robot = None if _is_static(entity) else read_driven(*what, self._host.library)
        except ResourceError as error:
            raise resource_error(codes, error) from error
        name = self._free_name(request.name or entity.name, request.allow_renaming)
        start = request.initial_pose
        pose = self._known.pose(start.header.frame_id, start.pose, codes.INVALID_POSE)
        if robot is None:
            self._put(lambda: self._host.simulator.stage.spawn(placed(entity, name, pose)))
            return name
        namespace = (request.entity_namespace or name).strip("/")
        if not NAMESPACE.fullmatch(namespace):
            problem = f"a robot that drives needs an entity_namespace, for '{name}' cannot be one"
            raise RequestError(codes.NAMESPACE_INVALID, f"{problem}; valid: as /a/b")
        self._put(lambda: self._host.fleet.add(name, namespace, robot, pose.planar()))
        return name

    def _put(self, put: Callable[[], None]) -> None:
        try:
            put()
        except NamespaceError as error:
            code = SpawnEntity.Response.NAMESPACE_INVALID
            raise RequestError(code, str(error)) from error
        except BlockedPoseError as error:
            raise RequestError(SpawnEntity.Response.INVALID_POSE, str(error)) from error
        except ArjunaError as error:  # MuJoCo refuses it
            code = SpawnEntity.Response.RESOURCE_PARSE_ERROR
            raise RequestError(code, str(error)) from error

    def _free_name(self, name: str, renaming: bool) -> str:
        taken = {ALIAS, *(entity.name for entity in self._known.all())}
        if name not in taken:
            return name
        if not renaming:
            problem = f"the name '{name}' is taken; give another, or allow renaming"
            raise RequestError(SpawnEntity.Response.NAME_NOT_UNIQUE, problem)
        number = 1
        while f"{name}_{number}" in taken:
            number += 1
        return f"{name}_{number}"


def _is_static(entity: Entity) -> bool:
    return entity.mass == 0.0 or entity.trajectory is not None


def placed(entity: Entity, name: str, pose: Pose3) -> Entity:
    """Return an entity under a name at a pose, with its path; a free one stands on the ground."""
    path: Trajectory | None = entity.trajectory
    if path is not None:
        T = pose.planar()
        path = dataclasses.replace(path, poses=tuple(T @ point for point in path.poses))
    return dataclasses.replace(entity, name=name, start=entity.lifted(pose), trajectory=path)
