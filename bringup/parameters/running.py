"""What already runs beside a command: the clock that is there, and the simulator's robot."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from contextlib import closing
from typing import Any

from bringup.parameters.files import EVERY_NODE, SIM_TIME, Parameters, sim_time_of
from bringup.stack import Group

_PATIENCE = 1.0  # [s] for what runs to be discovered
_POLL = 0.01  # [s]


def with_clock(
    parameters: Parameters, groups: Iterable[Group], insisted: bool | None, ask: bool
) -> Parameters:
    """Return parameters in which every node has one clock.

    A file that says `use_sim_time: false` is one that a launch file's argument overrides: where a
    simulator publishes /clock, its time is taken all the same, and that is written.

    Args:
        parameters: Of all nodes, as the files say.
        groups: What runs.
        insisted: The command line's word; None where it says nothing.
        ask: Whether to look for a publisher of /clock.
    """
    names = [spec.name for group in groups for spec in group.nodes]
    simulated = insisted
    if simulated is None:
        simulated = sim_time_of(parameters, names)
        if not simulated and ask and _clock_is_published():
            simulated = True
            sys.stderr.write(
                "use_sim_time: false in a file, but a simulator publishes /clock: its time is"
                " taken ('--use-sim-time false' insists)\n"
            )
    plain = {
        node: {key: value for key, value in values.items() if key != SIM_TIME}
        for node, values in parameters.items()
    }
    plain.setdefault(EVERY_NODE, {})[SIM_TIME] = simulated
    return plain


def _clock_is_published() -> bool:
    """Return whether somebody publishes /clock; it imports rclpy."""
    from arjuna_core.ros.process import Process

    with closing(Process("clock_probe", use_sim_time=False)) as probe:
        return _came(probe, lambda: bool(probe.node.count_publishers("/clock")))


def robot_of_simulator(namespace: str) -> dict[str, Any]:
    """Return `robot`, `robot_arguments` and `standard_topics` of the simulator that runs.

    Args:
        namespace: The robot's, which may be one of several.

    Returns:
        The simulator's parameters; nothing where none runs. It imports rclpy.
    """
    from rcl_interfaces.srv import GetParameters
    from rclpy.parameter import parameter_value_to_python

    from arjuna_core.ros.process import Process

    asked = ["robot", "robot_arguments", "standard_topics", "namespaces", "robots"]
    with closing(Process("robot_probe", use_sim_time=False)) as probe:
        names = dict.fromkeys((f"/{namespace}/sim" if namespace else "/sim", "/sim"))
        clients = [
            probe.node.create_client(GetParameters, f"{name}/get_parameters") for name in names
        ]
        if not _came(probe, lambda: any(client.service_is_ready() for client in clients)):
            return {}
        client = next(client for client in clients if client.service_is_ready())
        future = client.call_async(GetParameters.Request(names=asked))
        if not _came(probe, future.done):
            return {}
        values = [parameter_value_to_python(value) for value in future.result().values]
    *found, namespaces, robots = values
    said = dict(zip(asked, found, strict=False))
    if robots and namespace in namespaces:
        said["robot"] = robots[list(namespaces).index(namespace)]
    return said


def _came(probe: Any, done: Callable[[], bool]) -> bool:
    """Return whether something comes true while a process listens."""
    end = time.monotonic() + _PATIENCE
    while not done():
        if time.monotonic() >= end:
            return False
        probe.spin_once(_POLL)
    return True
