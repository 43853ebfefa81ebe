"""simulation_interfaces: state, time, steps and features of the simulation, and its worlds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from simulation_interfaces import srv
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import (
    Resource,
    Result,
    SimulationState,
    SimulatorFeatures,
    WorldResource,
)

from arjuna_core.errors import ArjunaError, WorldError
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.files.library import Fault, ResourceError, sent_text
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.spawned import FORMATS, check_assets
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import World
from arjuna_sim.nodes.services.host import (
    OK,
    Host,
    RequestError,
    need_world,
    resource_error,
    serve_all,
)

_SUFFIXES = (".world", ".sdf", ".yaml")
_NO_WORLD = b"<sdf version='1.7'><world name='none'/></sdf>"


_FEATURES = (
    *("SPAWNING", "DELETING", "ENTITY_TAGS", "ENTITY_BOUNDS", "ENTITY_BOUNDS_BOX"),
    *("ENTITY_CATEGORIES", "SPAWNING_RESOURCE_STRING", "ENTITY_STATE_GETTING"),
    *("ENTITY_STATE_SETTING", "ENTITY_INFO_GETTING", "ENTITY_INFO_SETTING", "SPAWNABLES"),
    *("SIMULATION_RESET", "SIMULATION_RESET_TIME", "SIMULATION_RESET_STATE"),
    *("SIMULATION_RESET_SPAWNED", "SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING"),
    *("SIMULATION_STATE_PAUSE", "STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE"),
    *("STEP_SIMULATION_ACTION", "WORLD_LOADING", "WORLD_RESOURCE_STRING", "WORLD_UNLOADING"),
    *("WORLD_INFO_GETTING", "AVAILABLE_WORLDS", "SPAWNING_ENTITIES"),
)
_STATES = {
    SimulationState.STATE_STOPPED: "stopped",
    SimulationState.STATE_PLAYING: "playing",
    SimulationState.STATE_PAUSED: "paused",
    SimulationState.STATE_QUITTING: "quitting",
}


def check_steps(state: int, steps: int, most: int) -> None:
    """Refuse a number of steps that cannot be simulated in a SimulationState.

    Raises:
        RequestError: The simulation is not paused, or there are none or too many.
    """
    if state != SimulationState.STATE_PAUSED:
        problem = "steps are for a paused simulation; pause it first"
        raise RequestError(Result.RESULT_INCORRECT_STATE, problem)
    if not 1 <= steps <= most:
        problem = f"steps is {steps}; valid: 1 to {most}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem)


class StepAction(GoalServer):
    """The action simulate_steps: a tick at a time, with progress."""

    def __init__(self, node: ManagedNode, state: Callable[[], int]) -> None:
        name, on_cancel = "simulate_steps", self._on_cancel_steps
        super().__init__(node, SimulateSteps, name, self._begin, on_cancel=on_cancel)
        self._state = state
        self._done = 0
        node.keep(self)

    def explained(self, reason: str, code: int | None = None, **fields: Any) -> Any:
        """Return a result that says why a goal failed."""
        error = RequestError(Result.RESULT_OPERATION_FAILED, reason)
        return SimulateSteps.Result(result=error.result)

    def _begin(self) -> None:
        if self.preempt_requested:
            self.abort_pending(self.explained("other steps are being simulated"))
            return
        self._done = 0
        goal: Any = self.goal
        try:
            # Five hours of simulated time; more is a slip of the client's.
            check_steps(self._state(), goal.steps, 1_000_000)
        except RequestError as error:
            self.abort(SimulateSteps.Result(result=error.result))

    def count(self) -> None:
        """Take note of a tick."""
        goal = self.goal
        if goal is None:
            return
        self._done += 1
        remaining = goal.steps - self._done
        self.feedback(SimulateSteps.Feedback(completed_steps=self._done, remaining_steps=remaining))
        if remaining == 0:
            self.succeed(SimulateSteps.Result(result=OK))

    def _on_cancel_steps(self) -> None:
        if self.cancel_requested:
            self.cancel(self.explained(f"cancelled after {self._done} steps"))


class SimulationServices:
    """Serves what concerns the whole simulation and its world.

    Args:
        forget: Called where the entities are the start's again.

    Attributes:
        answers: What answers each service, by its name.
    """

    def __init__(self, host: Host, steps: StepAction, forget: Callable[[], None]) -> None:
        self._host = host
        self._steps = steps
        self._forget = forget
        self._inline = ""
        services = (
            (srv.ResetSimulation, "reset_simulation", self._reset),
            (srv.GetSimulationState, "get_simulation_state", self._get_state),
            (srv.SetSimulationState, "set_simulation_state", self._set_state),
            (srv.StepSimulation, "step_simulation", self._step),
            (srv.LoadWorld, "load_world", self._load),
            (srv.UnloadWorld, "unload_world", self._unload),
            (srv.GetCurrentWorld, "get_current_world", self._get_current),
            (srv.GetAvailableWorlds, "get_available_worlds", self._get_available),
        )
        features = "get_simulator_features"
        self.answers = serve_all(host, services) | {features: self._get_features}
        host.serve(srv.GetSimulatorFeatures, features, self._get_features)

    def _get_features(self, request: Any, response: Any) -> Any:
        response.features.features = [getattr(SimulatorFeatures, name) for name in _FEATURES]
        response.features.spawn_formats = list(FORMATS)
        response.features.custom_info = "Arjuna on MuJoCo"
        return response

    def _reset(self, request: Any, response: Any) -> None:
        need_world(self._host)
        scope, kind = request.scope, srv.ResetSimulation.Request
        simulator = self._host.simulator
        if scope in (kind.SCOPE_DEFAULT, kind.SCOPE_ALL):
            self._reset_all()
            return
        if scope & ~(kind.SCOPE_TIME | kind.SCOPE_STATE | kind.SCOPE_SPAWNED):
            problem = f"scope {scope} is unknown; valid: 0, 255, or a sum of 1, 2 and 4"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        if scope & kind.SCOPE_SPAWNED:
            simulator.clear_spawned()
            self._host.fleet.match()
        if scope & kind.SCOPE_STATE:
            simulator.reset_state()
        if scope & kind.SCOPE_TIME:
            simulator.reset_time()
            self._host.publish_time()

    def _reset_all(self) -> None:
        self._host.simulator.reset()
        self._forget()
        self._host.after_reset()

    def _get_state(self, request: Any, response: Any) -> None:
        response.state.state = self._host.state

    def _set_state(self, request: Any, response: Any) -> None:
        state, codes = request.state.state, srv.SetSimulationState.Response
        if state != SimulationState.STATE_QUITTING:
            need_world(self._host)
        if state not in _STATES:
            valid = ", ".join(f"{number} ({name})" for number, name in _STATES.items())
            problem = f"state {state} cannot be entered; valid: {valid}"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        if state == self._host.state:
            raise RequestError(codes.ALREADY_IN_TARGET_STATE, f"it is {_STATES[state]} already")
        if self._steps.goal is not None:
            problem = "steps are being simulated; cancel them first"
            raise RequestError(codes.STATE_TRANSITION_ERROR, problem)
        if state == SimulationState.STATE_STOPPED:
            self._reset_all()
        self._host.quitting = state == SimulationState.STATE_QUITTING
        self._host.state = state

    def _step(self, request: Any, response: Any) -> None:
        # The service answers after the last step; the action takes more.
        check_steps(self._host.state, request.steps, 1000)
        for _ in range(request.steps):
            self._host.advance()

    def _load(self, request: Any, response: Any) -> None:
        try:
            self._enter(self._read(request), SimulationState.STATE_STOPPED)
        except ResourceError as error:
            raise resource_error(srv.LoadWorld.Response, error) from error
        except ArjunaError as error:
            raise RequestError(srv.LoadWorld.Response.RESOURCE_PARSE_ERROR, str(error)) from error
        resource = request.world_resource
        self._inline = "" if resource.uri.strip() else resource.resource_string
        response.world = self._resource()

    def _enter(self, world: World, state: int) -> None:
        self._host.simulator.load_world(world)
        self._forget()
        self._host.state = state
        self._host.after_reset()

    def _read(self, request: Any) -> World:
        """Read the world that a client names or sends.

        Raises:
            ResourceError: It may not or cannot be used as the request wants it.
            WorldError: It is broken.
        """
        resource = request.world_resource
        if resource.uri.strip():
            world = load_world(self._host.library.find(resource.uri.strip(), _SUFFIXES))
        else:
            world = self._read_text(resource.resource_string)
        if not request.ignore_missing_or_unsupported_assets:
            check_assets(world.notes)
        for note in world.notes:
            if request.fail_on_unsupported_element and note.kind is NoteKind.IGNORED:
                raise ResourceError(Fault.UNSUPPORTED_ELEMENTS, note.text)
        return world

    def _read_text(self, text: str) -> World:
        if "<sdf" not in sent_text(text):
            raise ResourceError(Fault.UNSUPPORTED_FORMAT, "holds no <sdf>; valid: an SDF world")
        library = self._host.library
        path = library.folder / "resource_string"
        return read_world(XmlFile(path, "sdf", WorldError, text.encode(), library.search))

    def _unload(self, request: Any, response: Any) -> None:
        need_world(self._host, srv.UnloadWorld.Response.NO_WORLD_LOADED)
        empty = read_world(XmlFile(Path("none"), "sdf", WorldError, _NO_WORLD))
        self._enter(empty, SimulationState.STATE_NO_WORLD)

    def _get_current(self, request: Any, response: Any) -> None:
        need_world(self._host, srv.GetCurrentWorld.Response.NO_WORLD_LOADED)
        response.world = self._resource()

    def _resource(self) -> WorldResource:
        world = self._host.simulator.world
        uri = "" if self._inline else str(world.path)
        resource = Resource(uri=uri, resource_string=self._inline)
        return WorldResource(name=world.name, world_resource=resource)

    def _get_available(self, request: Any, response: Any) -> None:
        if request.additional_sources and not request.continue_on_error:
            problem = "only the simulator's own sources are searched; leave additional_sources out"
            raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
        if not request.filter.tags:  # no world has tags
            response.worlds = [
                WorldResource(name=path.stem, world_resource=Resource(uri=str(path)))
                for path in self._host.library.worlds()
            ]
