"""simulation_interfaces: what is in the world, where it is, and how it goes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geometry_msgs.msg import Pose
from simulation_interfaces import srv
from simulation_interfaces.msg import Result

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import BlockedPoseError, Entity, EntityError
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.messages import box_msg
from arjuna_sim.nodes.services.host import Host, RequestError, answering, need_world
from arjuna_sim.nodes.services.known_entities import KnownEntities, matching


def in_world(host: Host, answer: Callable[[Any, Any], None]) -> Callable[[Any, Any], Any]:
    """Return a service's callback that refuses while no world is loaded."""

    def checked(request: Any, response: Any) -> None:
        need_world(host)
        answer(request, response)

    return answering(checked)


class EntityServices:
    """Serves what concerns entities that are there.

    Attributes:
        answers: What answers each service, by its name.
    """

    def __init__(self, host: Host, known: KnownEntities) -> None:
        self._host = host
        self._known = known
        self.answers: dict[str, Callable[[Any, Any], Any]] = {}
        for service, name, answer in (
            (srv.GetEntities, "get_entities", self._get_entities),
            (srv.GetEntitiesStates, "get_entities_states", self._get_entities_states),
            (srv.GetEntityState, "get_entity_state", self._get_entity_state),
            (srv.SetEntityState, "set_entity_state", self._set_entity_state),
            (srv.GetEntityInfo, "get_entity_info", self._get_entity_info),
            (srv.SetEntityInfo, "set_entity_info", self._set_entity_info),
            (srv.GetEntityBounds, "get_entity_bounds", self._get_entity_bounds),
            (srv.DeleteEntity, "delete_entity", self._delete),
        ):
            self.answers[name] = in_world(host, answer)
            host.serve(service, name, self.answers[name])

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
