"""The client of a running simulator's services."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Pose, PoseStamped
from numpy.typing import NDArray
from simulation_interfaces import srv
from simulation_interfaces.msg import (
    EntityCategory,
    EntityFilters,
    EntityState,
    Resource,
    Result,
    SimulationState,
)

from arjuna_core.errors import InputFileError
from arjuna_core.files.input_file import read_text
from arjuna_core.ros.convert import quaternion, yaw
from arjuna_core.se2 import SE2
from bringup.client.session import ClientError, Connection

_MESHES = re.compile(
    r"""(?:<mesh\b[^>]*\bfilename=["']|<mesh>(?:\s*<scale>[^<]*</scale>)?\s*<uri>)([^"'<]+)"""
)


class SimulatorError(ClientError):
    """No simulator answers, or it refuses a request; the message is its reason."""


class SimulatorClient(Connection):
    """A client of a simulator.

    Args:
        timeout: For its services to appear [s].
        answer: For what they do, which takes its time in a large world or on a busy machine [s].
    """

    error = SimulatorError

    def __init__(self, timeout: float = 5.0, namespace: str = "", answer: float = 60.0) -> None:
        super().__init__("simulator_client", namespace)
        self._timeout, self._answer = timeout, max(timeout, answer)

    def not_served(self, name: str, timeout: float) -> Exception:
        """Return the error of a service that nobody serves within a time [s]."""
        hint = "start a simulator with 'python -m bringup sim'"
        return SimulatorError(f"nobody serves '{name}' within {timeout:g} s; {hint}")

    def ask(self, service_type: Any, name: str, request: Any) -> Any:
        """Return a service's response.

        Raises:
            SimulatorError: Nobody answers in time, or the result is not RESULT_OK.
        """
        response = self.call(service_type, name, request, self._answer, self._timeout)
        if response.result.result != Result.RESULT_OK:
            raise SimulatorError(f"{response.result.error_message} ({response.result.result})")
        return response

    def spawn(self, name: str, resource: Resource, pose: Pose) -> str:
        """Put an entity into the world; return its name."""
        request = srv.SpawnEntity.Request(
            name=name, entity_resource=resource, initial_pose=PoseStamped(pose=pose)
        )
        return str(self.ask(srv.SpawnEntity, "spawn_entity", request).entity_name)

    def delete(self, name: str) -> None:
        """Take an entity out of the world."""
        self.ask(srv.DeleteEntity, "delete_entity", srv.DeleteEntity.Request(entity=name))

    def move(self, name: str, pose: Pose) -> None:
        """Put an entity somewhere else."""
        state = EntityState(pose=pose)
        request = srv.SetEntityState.Request(entity=name, state=state, set_pose=True)
        self.ask(srv.SetEntityState, "set_entity_state", request)

    def entities(self, pattern: str) -> list[str]:
        """Return a line for each entity whose name matches: its name, position and heading."""
        request = srv.GetEntitiesStates.Request(filters=EntityFilters(filter=pattern))
        found = self.ask(srv.GetEntitiesStates, "get_entities_states", request)
        lines = []
        for name, state in zip(found.entities, found.states, strict=True):
            p = state.pose.position
            heading = yaw(state.pose.orientation)
            lines.append(f"{name:<24} x {p.x:8.3f}  y {p.y:8.3f}  z {p.z:7.3f}  yaw {heading:6.3f}")
        return lines

    def obstacles(
        self, house: float = 3.0, reach: tuple[float, float] = (0.1, 1.7)
    ) -> list[NDArray[np.float64]]:
        """Return the corners from above of the boxes round what stands in the world, `(4, 2)` [m].

        Args:
            house: What is larger in both directions is none: its box holds rooms [m].
            reach: Heights between which something stands in a person's way [m].
        """
        kinds = EntityCategory.CATEGORY_OBJECT, EntityCategory.CATEGORY_STATIC_OBJECT
        filters = EntityFilters(categories=[EntityCategory(category=kind) for kind in kinds])
        request = srv.GetEntitiesStates.Request(filters=filters)
        found = self.ask(srv.GetEntitiesStates, "get_entities_states", request)
        name = "get_entity_bounds"
        client = self.client.create_client(srv.GetEntityBounds, name)  # one, for many questions
        self.run_until(client.service_is_ready, self._timeout, name)
        requests = [srv.GetEntityBounds.Request(entity=entity) for entity in found.entities]
        answers = [client.call_async(request) for request in requests]
        boxes = []
        for state, answer in zip(found.states, answers, strict=True):
            bounds = self.result(answer, self._answer, name).bounds.points
            if len(bounds) != 2:  # it is gone by now
                continue
            (x1, y1, z1), (x0, y0, z0) = ((point.x, point.y, point.z) for point in bounds)
            at = state.pose.position
            stands = at.z + z1 > reach[0] and at.z + z0 < reach[1]
            if stands and min(x1 - x0, y1 - y0) <= house:
                pose = SE2(at.x, at.y, yaw(state.pose.orientation))
                boxes.append(pose.apply(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])))
        return boxes

    def enter(self, state: int) -> None:
        """Pause or play."""
        request = srv.SetSimulationState.Request(state=SimulationState(state=state))
        self.ask(srv.SetSimulationState, "set_simulation_state", request)

    def step(self, steps: int, chunk: int = 500) -> None:
        """Run a paused simulation for some ticks, a chunk a call to be answered in time."""
        while steps > 0:
            count = min(steps, chunk)
            request = srv.StepSimulation.Request(steps=count)
            self.ask(srv.StepSimulation, "step_simulation", request)
            steps -= count

    def reset(self, scope: int) -> None:
        """Return to the start."""
        self.ask(srv.ResetSimulation, "reset_simulation", srv.ResetSimulation.Request(scope=scope))

    def load(self, world: Path) -> str:
        """Replace the world; return the new one's name."""
        resource = Resource(uri=str(world.resolve()))
        request = srv.LoadWorld.Request(world_resource=resource)
        return str(self.ask(srv.LoadWorld, "load_world", request).world.name)

    def worlds(self) -> list[str]:
        """Return the worlds that can be loaded, by their files."""
        request = srv.GetAvailableWorlds.Request()
        found = self.ask(srv.GetAvailableWorlds, "get_available_worlds", request).worlds
        return [world.world_resource.uri for world in found]

    def status(self) -> str:
        """Return which world is loaded, and whether time runs."""
        request = srv.GetSimulationState.Request()
        state = self.ask(srv.GetSimulationState, "get_simulation_state", request)
        number = state.state.state
        words = {SimulationState.STATE_NO_WORLD: "no world is loaded"}
        if number in words:
            return words[number]
        loaded = self.ask(srv.GetCurrentWorld, "get_current_world", srv.GetCurrentWorld.Request())
        world = loaded.world
        names = {
            SimulationState.STATE_STOPPED: "stopped",
            SimulationState.STATE_PLAYING: "playing",
            SimulationState.STATE_PAUSED: "paused",
        }
        return f"{world.name} ({world.world_resource.uri}): {names.get(number, number)}"


def pose_at(x: float, y: float, z: float, heading: float) -> Pose:
    """Return an upright pose."""
    pose = Pose(orientation=quaternion(heading))
    pose.position.x, pose.position.y, pose.position.z = float(x), float(y), float(z)
    return pose


def resource_of(what: str) -> Resource:
    """Return what to spawn: a file of this machine as its text, else the words as a URI.

    A file that refers to meshes beside it is named instead: by plain paths, or in a package that
    the file lies in. A simulator reads no file outside of its folder, as of a launch file's /tmp.

    Raises:
        SimulatorError: The file cannot be read.
    """
    path = Path(what)
    if "://" in what or not path.is_file():
        return Resource(uri=what)
    try:
        text = read_text(path, 20_000_000)
    except InputFileError as error:
        raise SimulatorError(str(error)) from error
    found = path.resolve()
    if any(_lies_beside(found, name.strip()) for name in _MESHES.findall(text)):
        return Resource(uri=str(found))
    return Resource(resource_string=text)


def _lies_beside(path: Path, mesh: str) -> bool:
    scheme, is_uri, rest = mesh.partition("://")
    if not is_uri:
        return not mesh.startswith("/")
    above = {folder.name for folder in path.parents}
    return scheme in ("package", "model") and rest.partition("/")[0] in above


def walker(name: str, path: Sequence[tuple[float, float]], speed: float, loop: bool) -> Resource:
    """Return an SDF actor that walks by two or more points at a speed [m/s]."""
    lines, now = [], 0.0
    for (x0, y0), (x1, y1) in itertools.pairwise(path):
        heading = math.atan2(y1 - y0, x1 - x0)
        end = now + math.hypot(x1 - x0, y1 - y0) / speed
        for time, x, y in ((now, x0, y0), (end, x1, y1)):
            pose = f"<pose>{x!r} {y!r} 0 0 0 {heading!r}</pose>"
            lines.append(f"<waypoint><time>{time!r}</time>{pose}</waypoint>")
        now = end
    return Resource(
        resource_string=f"<sdf version='1.7'><actor name='{escape(name)}'><script>"
        f"<loop>{str(loop).lower()}</loop><trajectory id='0' type='walk'>{''.join(lines)}"
        "</trajectory></script></actor></sdf>"
    )
