"""What the commands `entity` and `world` do."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from simulation_interfaces.msg import SimulationState

from bringup.simulator.client import (
    SimulatorClient,
    SimulatorError,
    pose_at,
    resource_of,
    walker,
)
from bringup.simulator.parser import SCOPES


def run(arguments: argparse.Namespace, write: Callable[[str], None]) -> None:
    """Run a command against the simulator that runs on this machine.

    Args:
        arguments: What `cli_parser.parse` returned.
        write: Takes each line of what the simulator says.

    Raises:
        SimulatorError: Nobody answers in time, or the request is refused.
    """
    client = SimulatorClient()
    try:
        answer = _entity if arguments.command == "entity" else _world
        for line in answer(client, arguments):
            write(line)
    finally:
        client.close()


def _entity(client: SimulatorClient, arguments: argparse.Namespace) -> list[str]:
    if arguments.action == "list":
        return client.entities(arguments.filter)
    if arguments.action == "delete":
        client.delete(arguments.name)
        return [f"{arguments.name} is gone"]
    pose = pose_at(arguments.at[0], arguments.at[1], arguments.z, arguments.yaw)
    if arguments.action == "move":
        client.move(arguments.name, pose)
        return [f"{arguments.name} is at {arguments.at[0]:g}, {arguments.at[1]:g}"]
    if arguments.path is None:
        name = client.spawn(arguments.name, resource_of(arguments.what), pose)
    elif arguments.what == "person":
        path = walker(arguments.name, arguments.path, arguments.speed, arguments.once)
        name = client.spawn(arguments.name, path, pose)
    else:
        raise SimulatorError(f"only a person walks a path, not '{arguments.what}'")
    return [f"{name} is there"]


def _world(client: SimulatorClient, arguments: argparse.Namespace) -> list[str]:
    if arguments.action == "pause":
        client.enter(SimulationState.STATE_PAUSED)
    elif arguments.action == "play":
        client.enter(SimulationState.STATE_PLAYING)
    elif arguments.action == "quit":
        client.enter(SimulationState.STATE_QUITTING)
        return []
    elif arguments.action == "step":
        client.step(arguments.steps)
    elif arguments.action == "reset":
        client.reset(SCOPES[arguments.scope])
    elif arguments.action == "load":
        client.load(arguments.world)
    elif arguments.action == "list":
        return client.worlds()
    return [client.status()]
