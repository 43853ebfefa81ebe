"""simulation_interfaces: which world is loaded, and which others can be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simulation_interfaces.msg import Resource, Result, SimulationState, WorldResource
from simulation_interfaces.srv import (
    GetAvailableWorlds,
    GetCurrentWorld,
    LoadWorld,
    UnloadWorld,
)

from arjuna_core.errors import ArjunaError, WorldError
from arjuna_sim.files.library import Fault, ResourceError
from arjuna_sim.files.sdf.sdf import World, read_world
from arjuna_sim.files.spawned import check_assets
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.nodes.services.results import OK, refusal, resource_refusal

if TYPE_CHECKING:
    from arjuna_sim.nodes.sim import SimNode

_SUFFIXES = (".world", ".sdf", ".yaml")
_NO_WORLD = b"<sdf version='1.7'><world name='none'/></sdf>"
_TEXT_MAX = 20_000_000
_UNSUPPORTED = "not simulated"


class WorldServices:
    """Serves what concerns worlds.

    Args:
        node: The simulator's node, being configured.
        forget: Called when the entities of the last world are gone.
    """

    def __init__(self, node: SimNode, forget: Callable[[], None]) -> None:
        self._node = node
        self._forget = forget
        self._inline = ""
        node.serve(LoadWorld, "load_world", self._load)
        node.serve(UnloadWorld, "unload_world", self._unload)
        node.serve(GetCurrentWorld, "get_current_world", self._get_current)
        node.serve(GetAvailableWorlds, "get_available_worlds", self._get_available)

    def _load(self, request: Any, response: Any) -> Any:
        try:
            world = self._read(request)
            self._node.simulator.load_world(world)
        except ResourceError as error:
            response.result = resource_refusal(LoadWorld.Response, error)
        except ArjunaError as error:
            code = LoadWorld.Response.RESOURCE_PARSE_ERROR
            response.result = refusal(code, str(error))
        else:
            uri = request.world_resource.uri.strip()
            self._inline = "" if uri else request.world_resource.resource_string
            self._begin(SimulationState.STATE_STOPPED)
            response.result, response.world = OK, self._resource()
        return response

    def _begin(self, state: int) -> None:
        self._forget()
        self._node.contacts.log.reset()
        self._node.state = state
        self._node.tell_time()

    def _read(self, request: Any) -> World:
        """Read the world that a client names or sends.

        Raises:
            ResourceError: It may not or cannot be used as the request wants it.
            WorldError: It is broken.
        """
        resource = request.world_resource
        if resource.uri.strip():
            world = load_world(self._node.library.find(resource.uri.strip(), _SUFFIXES))
        else:
            world = self._read_text(resource.resource_string)
        if not request.ignore_missing_or_unsupported_assets:
            check_assets(world.notes)
        for note in world.notes:
            if request.fail_on_unsupported_element and _UNSUPPORTED in note:
                raise ResourceError(Fault.UNSUPPORTED_ELEMENTS, note)
        return world

    def _read_text(self, text: str) -> World:
        if not text.strip():
            raise ResourceError(Fault.NO_RESOURCE, "neither a uri nor a resource_string was given")
        if len(text) > _TEXT_MAX:
            problem = f"has {len(text)} characters; at most {_TEXT_MAX} are read"
            raise ResourceError(Fault.RESOURCE_PARSE_ERROR, problem)
        if "<sdf" not in text:
            raise ResourceError(Fault.UNSUPPORTED_FORMAT, "holds no <sdf>; valid: an SDF world")
        library = self._node.library
        path = library.folder / "resource_string"
        return read_world(XmlFile(path, "sdf", WorldError, text.encode(), library.search))

    def _unload(self, request: Any, response: Any) -> Any:
        if self._node.state == SimulationState.STATE_NO_WORLD:
            code = UnloadWorld.Response.NO_WORLD_LOADED
            response.result = refusal(code, "no world is loaded")
            return response
        empty = read_world(XmlFile(Path("none"), "sdf", WorldError, _NO_WORLD))
        self._node.simulator.load_world(empty)
        self._begin(SimulationState.STATE_NO_WORLD)
        response.result = OK
        return response

    def _get_current(self, request: Any, response: Any) -> Any:
        if self._node.state == SimulationState.STATE_NO_WORLD:
            code = GetCurrentWorld.Response.NO_WORLD_LOADED
            response.result = refusal(code, "no world is loaded")
        else:
            response.result, response.world = OK, self._resource()
        return response

    def _resource(self) -> WorldResource:
        world = self._node.simulator.world
        uri = "" if self._inline else str(world.path)
        resource = Resource(uri=uri, resource_string=self._inline)
        return WorldResource(name=world.name, world_resource=resource)

    def _get_available(self, request: Any, response: Any) -> Any:
        if request.additional_sources and not request.continue_on_error:
            problem = "only the simulator's own sources are searched; leave additional_sources out"
            response.result = refusal(Result.RESULT_FEATURE_UNSUPPORTED, problem)
            return response
        if not request.filter.tags:  # no world has tags
            response.worlds = [
                WorldResource(name=path.stem, world_resource=Resource(uri=str(path)))
                for path in self._node.library.worlds()
            ]
        response.result = OK
        return response
