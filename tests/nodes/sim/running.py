"""Starting the simulator's nodes and letting time pass, and a client's usual requests."""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import TransitionCallbackReturn
from simulation_interfaces.msg import EntityFilters, Resource, Result
from simulation_interfaces.srv import GetEntities, GetEntityState, SpawnEntity

from arjuna_core.files.shipped import shipped_file
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench

SUCCESS = TransitionCallbackReturn.SUCCESS
OK = Result.RESULT_OK


def start(bench: RosBench, node: Any) -> Any:
    """Configure and activate a node."""
    assert node.trigger_configure() == SUCCESS
    assert node.trigger_activate() == SUCCESS
    bench.process.drain()
    return node


def start_sim(bench: RosBench, **values: Any) -> SimNode:
    """Start the simulator with parameters."""
    node: SimNode = start(bench, SimNode(bench.process, values))
    return node


def start_in(bench: RosBench, world: str = "empty.world") -> SimNode:
    """Start the simulator in a shipped world."""
    return start_sim(bench, world=str(shipped_file(f"worlds/{world}")))


def run(bench: RosBench, sim: SimNode, ticks: int) -> None:
    """Run ticks, each with all that it causes."""
    for _ in range(ticks):
        sim.tick()
        bench.process.drain()


def spawn(
    bench: RosBench,
    name: str,
    uri: str = "box:0.4,0.4,1",
    x: float = 2.0,
    text: str = "",
    frame: str = "",
    **fields: Any,
) -> Any:
    """Ask for an entity; return the response."""
    request = SpawnEntity.Request(name=name, **fields)
    request.entity_resource = Resource(uri=uri, resource_string=text)
    request.initial_pose.header.frame_id = frame
    request.initial_pose.pose.position.x = x
    return bench.call(SpawnEntity, "/spawn_entity", request)


def names(bench: RosBench, filters: EntityFilters | None = None) -> list[str]:
    """Return the names of the entities that pass."""
    request = GetEntities.Request(filters=filters or EntityFilters())
    response = bench.call(GetEntities, "/get_entities", request)
    assert response.result.result == OK, response.result.error_message
    return list(response.entities)


def state(bench: RosBench, name: str) -> Any:
    """Ask where an entity is; return the response."""
    return bench.call(GetEntityState, "/get_entity_state", GetEntityState.Request(entity=name))
