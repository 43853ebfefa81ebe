"""Every node of every stack: each in turn makes all its transitions."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.lifecycle import TransitionCallbackReturn

from bringup import stack as stacks
from bringup.parameters.files import for_node, merged, shipped_parameters
from bringup.stack import PROGRAMS, Group
from tests.helpers.ros import RosBench

GROUPS = {group.name: group for group in vars(stacks).values() if isinstance(group, Group)}
GROUPS["programs"] = Group("programs", tuple(dict.fromkeys(PROGRAMS.values())))
pytestmark = [
    pytest.mark.ros,
    pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS),
]
CYCLE = ("configure", "activate", "deactivate", "cleanup")
TO_STATE = {"unconfigured": (), "inactive": CYCLE[:1], "active": CYCLE[:2]}
NEEDED = {"map_server": {"yaml_filename": "maps/arjuna_room.yaml"}}
PARAMETERS = merged(shipped_parameters(), NEEDED)


BENCH = {"transport": "dds"}  # its entities are made and destroyed; a shutdown is the same in both


def made(bench: RosBench, group: Group) -> list[Any]:
    """Make the nodes of a group, which find each other in the process."""
    nodes = [each.make(bench.process, for_node(PARAMETERS, each.name)) for each in group.nodes]
    bench.process.drain()
    return nodes


def step(bench: RosBench, node: Any, transition: str) -> None:
    """Make a transition and let some time pass after it, until each timer was due once."""
    result = getattr(node, f"trigger_{transition}")()
    assert result == TransitionCallbackReturn.SUCCESS, f"{node.get_name()}: {transition} failed"
    bench.advance(1.2, 10)


def entities(node: Any) -> list[str]:
    """Return the names of everything a node has in the graph."""
    topics = [item.topic_name for item in (*node.publishers, *node.subscriptions)]
    services = [item.srv_name for item in (*node.services, *node.clients)]
    return sorted(topics + services) + [type(item).__name__ for item in node.waitables]


def test_each_node_goes_round_twice_and_leaves_nothing(bench: RosBench, group: Group) -> None:
    """The second time, in every state, parameters are set and the clock is set back."""
    diagnostics = bench.collect(DiagnosticArray, "/diagnostics")
    for node in made(bench, group):
        before, configured = entities(node), []
        for transitions in (CYCLE, ("", *CYCLE)):
            for transition in transitions:
                if transition:
                    step(bench, node, transition)
                assert node.active == (transition == "activate")
                if transition == "configure":
                    configured.append(entities(node))
                if transitions is not CYCLE:
                    if node.configured:
                        node.on_config(node.config)
                    bench.advance(1.0, 10)
                    bench.set_back()
                    bench.advance(1.0, 10)
            assert entities(node) == before
        assert configured[0] == configured[1] != before
        # from the start on: before it was configured, too
        name = f"{node.get_fully_qualified_name()}: messages"
        assert name in {status.name for array in diagnostics for status in array.status}


@pytest.mark.parametrize("state", TO_STATE)
def test_each_node_shuts_down_from_every_state(group: Group, state: str) -> None:
    with closing(RosBench()) as bench:
        for node in made(bench, group):
            before = entities(node)
            for transition in TO_STATE[state]:
                step(bench, node, transition)
            step(bench, node, "shutdown")
            assert not node.active
            assert entities(node) == before
