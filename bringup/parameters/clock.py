"""Which clock the nodes of a command take their time from."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from contextlib import closing

from bringup.parameters.files import EVERY_NODE, SIM_TIME, Parameters, sim_time_of
from bringup.stack import Group

_PATIENCE = 1.0  # [s] for a publisher of /clock to be discovered


def with_clock(
    parameters: Parameters, groups: Iterable[Group], insisted: bool | None
) -> Parameters:
    """Return parameters in which every node has one clock.

    A file that says `use_sim_time: false` is one that a launch file's argument overrides: where a
    simulator publishes /clock, its time is taken all the same, and that is written.

    Args:
        parameters: Of all nodes, as the files say.
        groups: What runs.
        insisted: The command line's word; None where it says nothing.
    """
    names = [spec.name for group in groups for spec in group.nodes]
    simulated = insisted
    if simulated is None:
        simulated = sim_time_of(parameters, names)
        if not simulated and _clock_is_published():
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

    end = time.monotonic() + _PATIENCE
    with closing(Process("clock_probe", use_sim_time=False)) as probe:
        while time.monotonic() < end:
            if probe.node.count_publishers("/clock"):
                return True
            probe.spin_once(0.05)
    return False
