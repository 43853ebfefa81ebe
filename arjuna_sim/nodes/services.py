"""simulation_interfaces: what a client may ask of the simulator, and do to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    GetEntities,
    GetEntityState,
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    StepSimulation,
)

from arjuna_core.ros.convert import se2_from_pose
from arjuna_sim.nodes.messages import WORLD, entity_state

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

ALIAS = "robot"
_STEPS_MAX = 1000
_FEATURES = (
    SimulatorFeatures.ENTITY_STATE_GETTING,
    SimulatorFeatures.ENTITY_STATE_SETTING,
    SimulatorFeatures.SIMULATION_RESET,
    SimulatorFeatures.SIMULATION_RESET_STATE,
    SimulatorFeatures.SIMULATION_STATE_GETTING,
    SimulatorFeatures.SIMULATION_STATE_SETTING,
    SimulatorFeatures.SIMULATION_STATE_PAUSE,
    SimulatorFeatures.STEP_SIMULATION_SINGLE,
    SimulatorFeatures.STEP_SIMULATION_MULTIPLE,
)


class SimulationServices:
    """Serves simulation_interfaces for a simulator's node.

    Args:
        node: The node, being configured.
    """

    def __init__(self, node: SimNode) -> None:
        self._node = node
        node.serve(GetSimulatorFeatures, "get_simulator_features", self._get_features)
        node.serve(GetEntities, "get_entities", self._get_entities)
        node.serve(GetEntityState, "get_entity_state", self._get_entity_state)
        node.serve(SetEntityState, "set_entity_state", self._set_entity_state)
        node.serve(ResetSimulation, "reset_simulation", self._reset)
        node.serve(GetSimulationState, "get_simulation_state", self._get_state)
        node.serve(SetSimulationState, "set_simulation_state", self._set_state)
        node.serve(StepSimulation, "step_simulation", self._step)

    @property
    def _name(self) -> str:
        name: str = self._node.simulator.robot.urdf.name
        return name

    def _unknown(self, entity: str) -> Result | None:
        if entity.strip("/") in (self._name, ALIAS):
            return None
        problem = f"entity '{entity}' does not exist; valid: {self._name}, {ALIAS}"
        return Result(result=Result.RESULT_NOT_FOUND, error_message=problem)

    def _get_features(self, request: Any, response: Any) -> Any:
        response.features.features = list(_FEATURES)
        response.features.custom_info = "Arjuna on MuJoCo"
        return response

    def _get_entities(self, request: Any, response: Any) -> Any:
        response.entities = [self._name]
        response.result.result = Result.RESULT_OK
        return response

    def _get_entity_state(self, request: Any, response: Any) -> Any:
        response.result = self._unknown(request.entity) or Result(result=Result.RESULT_OK)
        if response.result.result == Result.RESULT_OK:
            simulator = self._node.simulator
            response.state = entity_state(simulator.truth(), simulator.time)
        return response

    def _set_entity_state(self, request: Any, response: Any) -> Any:
        response.result = self._unknown(request.entity) or self._move(request)
        return response

    def _move(self, request: Any) -> Result:
        frame = request.state.header.frame_id.lstrip("/")
        if request.set_twist or request.set_acceleration or not request.set_pose:
            problem = "only the pose can be set: set_pose true, set_twist, set_acceleration false"
            return Result(result=Result.RESULT_FEATURE_UNSUPPORTED, error_message=problem)
        if frame not in ("", WORLD):
            problem = f"frame '{frame}' is unknown; valid: {WORLD}"
            return Result(result=SetEntityState.Response.INVALID_POSE, error_message=problem)
        try:
            pose = se2_from_pose(request.state.pose)
        except ValueError as error:
            return Result(result=SetEntityState.Response.INVALID_POSE, error_message=str(error))
        touched = self._node.simulator.obstacles_at(pose)
        if touched:
            problem = f"the place is taken by {', '.join(touched)}"
            return Result(result=SetEntityState.Response.INVALID_POSE, error_message=problem)
        self._node.simulator.set_pose(pose)
        return Result(result=Result.RESULT_OK)

    def _reset(self, request: Any, response: Any) -> Any:
        kind = ResetSimulation.Request
        both = kind.SCOPE_TIME | kind.SCOPE_STATE
        response.result.result = Result.RESULT_OK
        if request.scope == kind.SCOPE_DEFAULT or request.scope & both == both:
            self._node.simulator.reset()
        elif request.scope & kind.SCOPE_STATE:
            self._node.simulator.set_pose(self._node.simulator.spawn)
        elif request.scope & kind.SCOPE_TIME:
            response.result.result = Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = "time is reset only together with the state"
        return response

    def _get_state(self, request: Any, response: Any) -> Any:
        paused = self._node.paused
        response.state.state = (
            SimulationState.STATE_PAUSED if paused else SimulationState.STATE_PLAYING
        )
        response.result.result = Result.RESULT_OK
        return response

    def _set_state(self, request: Any, response: Any) -> Any:
        wanted = {SimulationState.STATE_PAUSED: True, SimulationState.STATE_PLAYING: False}
        paused = wanted.get(request.state.state)
        if paused is None:
            response.result.result = Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = "valid states: playing, paused"
        elif paused == self._node.paused:
            response.result.result = SetSimulationState.Response.ALREADY_IN_TARGET_STATE
            response.result.error_message = "it is in this state already"
        else:
            self._node.paused = paused
            response.result.result = Result.RESULT_OK
        return response

    def _step(self, request: Any, response: Any) -> Any:
        if not self._node.paused:
            response.result.result = Result.RESULT_INCORRECT_STATE
            response.result.error_message = "steps are for a paused simulation; pause it first"
        elif not 1 <= request.steps <= _STEPS_MAX:
            response.result.result = Result.RESULT_OPERATION_FAILED
            response.result.error_message = f"steps is {request.steps}; valid: 1 to {_STEPS_MAX}"
        else:
            for _ in range(request.steps):
                self._node.advance()
            response.result.result = Result.RESULT_OK
        return response
