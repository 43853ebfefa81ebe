"""simulation_interfaces: which world is loaded, and which others can be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from simulation_interfaces.msg import Resource, Result, SimulationState, WorldResource
from simulation_interfaces.srv import GetAvailableWorlds, GetCurrentWorld, LoadWorld, UnloadWorld

from arjuna_core.errors import ArjunaError, WorldError
from arjuna_sim.files.library import Fault, ResourceError, sent_text
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.spawned import check_assets
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import World
from arjuna_sim.nodes.services.host import (
    Host,
    RequestError,
    answering,
    need_world,
    resource_error,
)

_SUFFIXES = (".world", ".sdf", ".yaml")
_NO_WORLD = b"<sdf version='1.7'><world name='none'/></sdf>"


class WorldServices:
    """Serves what concerns worlds."""

    def __init__(self, host: Host, forget: Callable[[], None]) -> None:
        self._host = host
        self._forget = forget
        self._inline = ""
        host.serve(LoadWorld, "load_world", answering(self._load))
        host.serve(UnloadWorld, "unload_world", answering(self._unload))
        host.serve(GetCurrentWorld, "get_current_world", answering(self._get_current))
        host.serve(GetAvailableWorlds, "get_available_worlds", answering(self._get_available))

    def _load(self, request: Any, response: Any) -> None:
        try:
            self._enter(self._read(request), SimulationState.STATE_STOPPED)
        except ResourceError as error:
            raise resource_error(LoadWorld.Response, error) from error
        except ArjunaError as error:
            raise RequestError(LoadWorld.Response.RESOURCE_PARSE_ERROR, str(error)) from error
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
        need_world(self._host, UnloadWorld.Response.NO_WORLD_LOADED)
        empty = read_world(XmlFile(Path("none"), "sdf", WorldError, _NO_WORLD))
        self._enter(empty, SimulationState.STATE_NO_WORLD)

    def _get_current(self, request: Any, response: Any) -> None:
        need_world(self._host, GetCurrentWorld.Response.NO_WORLD_LOADED)
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
