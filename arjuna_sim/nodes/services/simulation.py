"""simulation_interfaces: state, time and steps of the simulation, and what it can do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
)

from arjuna_sim.files.spawned import FORMATS
from arjuna_sim.nodes.services.entities import EntityServices
from arjuna_sim.nodes.services.results import OK, refusal
from arjuna_sim.nodes.services.spawning import SpawnServices
from arjuna_sim.nodes.services.stepping import StepAction, refuse_steps
from arjuna_sim.nodes.services.worlds import WorldServices

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

_STEPS_MAX = 1000
_FEATURES = (
    SimulatorFeatures.SPAWNING,
    SimulatorFeatures.DELETING,
    SimulatorFeatures.ENTITY_TAGS,
    SimulatorFeatures.ENTITY_BOUNDS,
    SimulatorFeatures.ENTITY_BOUNDS_BOX,
    SimulatorFeatures.ENTITY_CATEGORIES,
    SimulatorFeatures.SPAWNING_RESOURCE_STRING,
    SimulatorFeatures.ENTITY_STATE_GETTING,
    SimulatorFeatures.ENTITY_STATE_SETTING,
    SimulatorFeatures.ENTITY_INFO_GETTING,
    SimulatorFeatures.ENTITY_INFO_SETTING,
    SimulatorFeatures.SPAWNABLES,
    SimulatorFeatures.SIMULATION_RESET,
    SimulatorFeatures.SIMULATION_RESET_TIME,
    SimulatorFeatures.SIMULATION_RESET_STATE,
    SimulatorFeatures.SIMULATION_RESET_SPAWNED,
    SimulatorFeatures.SIMULATION_STATE_GETTING,
    SimulatorFeatures.SIMULATION_STATE_SETTING,
    SimulatorFeatures.SIMULATION_STATE_PAUSE,
    SimulatorFeatures.STEP_SIMULATION_SINGLE,
    SimulatorFeatures.STEP_SIMULATION_MULTIPLE,
    SimulatorFeatures.STEP_SIMULATION_ACTION,
    SimulatorFeatures.WORLD_LOADING,
    SimulatorFeatures.WORLD_RESOURCE_STRING,
    SimulatorFeatures.WORLD_UNLOADING,
    SimulatorFeatures.WORLD_INFO_GETTING,
    SimulatorFeatures.AVAILABLE_WORLDS,
    SimulatorFeatures.SPAWNING_ENTITIES,
)
_STATES = {
    SimulationState.STATE_STOPPED: "stopped",
    SimulationState.STATE_PLAYING: "playing",
    SimulationState.STATE_PAUSED: "paused",
    SimulationState.STATE_QUITTING: "quitting",
}


class SimulationServices:
    """Serves simulation_interfaces for a simulator's node.

    Args:
        node: The node, being configured.
    """

    def __init__(self, node: SimNode) -> None:
        self._node = node
        node.serve(GetSimulatorFeatures, "get_simulator_features", self._get_features)
        node.serve(ResetSimulation, "reset_simulation", self._reset)
        node.serve(GetSimulationState, "get_simulation_state", self._get_state)
        node.serve(SetSimulationState, "set_simulation_state", self._set_state)
        node.serve(StepSimulation, "step_simulation", self._step)
        self._entities = EntityServices(node)
        SpawnServices(node, self._entities)
        WorldServices(node, self._entities.reset)
        self._steps = StepAction(node)

    @property
    def stepping(self) -> bool:
        """Whether the action simulate_steps wants the next tick."""
        return self._steps.goal is not None

    def after_tick(self) -> None:
        """Tell a client of simulate_steps that a tick is done."""
        self._steps.count()

    def abort(self) -> None:
        """End what runs, since the node stops."""
        self._steps.abort_all()

    def _get_features(self, request: Any, response: Any) -> Any:
        response.features.features = list(_FEATURES)
        response.features.spawn_formats = list(FORMATS)
        response.features.custom_info = "Arjuna on MuJoCo"
        return response

    def _reset(self, request: Any, response: Any) -> Any:
        response.result = self._no_world() or self._reset_scope(request.scope)
        return response

    def _reset_scope(self, scope: int) -> Result:
        kind = ResetSimulation.Request
        simulator = self._node.simulator
        known = kind.SCOPE_TIME | kind.SCOPE_STATE | kind.SCOPE_SPAWNED
        if scope in (kind.SCOPE_DEFAULT, kind.SCOPE_ALL):
            self._reset_all()
            return OK
        if scope & ~known:
            problem = f"scope {scope} is unknown; valid: 0, 255, or a sum of 1, 2 and 4"
            return refusal(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        if scope & kind.SCOPE_SPAWNED:
            simulator.stage.clear_spawned()
        if scope & kind.SCOPE_STATE:
            simulator.reset_state()
        if scope & kind.SCOPE_TIME:
            simulator.reset_time()
            self._node.tell_time()
        return OK

    def _reset_all(self) -> None:
        self._node.simulator.reset()
        self._node.contacts.log.reset()
        self._entities.reset()
        self._node.tell_time()

    def _no_world(self) -> Result | None:
        if self._node.state != SimulationState.STATE_NO_WORLD:
            return None
        return refusal(Result.RESULT_INCORRECT_STATE, "no world is loaded; load one first")

    def _get_state(self, request: Any, response: Any) -> Any:
        response.state.state = self._node.state
        response.result = OK
        return response

    def _set_state(self, request: Any, response: Any) -> Any:
        quits = request.state.state == SimulationState.STATE_QUITTING
        response.result = (None if quits else self._no_world()) or self._enter(request.state.state)
        return response

    def _enter(self, state: int) -> Result:
        if state not in _STATES:
            problem = f"state {state} cannot be entered; valid: {_listed(_STATES)}"
            return refusal(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        if state == self._node.state:
            problem = f"it is {_STATES[state]} already"
            return refusal(SetSimulationState.Response.ALREADY_IN_TARGET_STATE, problem)
        if self.stepping:
            problem = "steps are being simulated; cancel them first"
            return refusal(SetSimulationState.Response.STATE_TRANSITION_ERROR, problem)
        if state == SimulationState.STATE_STOPPED:
            self._reset_all()
        self._node.quitting = state == SimulationState.STATE_QUITTING
        self._node.state = state
        return OK

    def _step(self, request: Any, response: Any) -> Any:
        response.result = refuse_steps(self._node, request.steps, _STEPS_MAX) or OK
        if response.result is OK:
            for _ in range(request.steps):
                self._node.advance()
        return response


def _listed(names: dict[int, str]) -> str:
    return ", ".join(f"{number} ({name})" for number, name in names.items())
