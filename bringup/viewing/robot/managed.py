"""The managed nodes' states, and the commands to their managers, to costmaps and the mapper."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from lifecycle_msgs.srv import GetState
from nav2_msgs.srv import ClearEntireCostmap, ManageLifecycleNodes
from slam_toolbox.srv import SaveMap, SerializePoseGraph
from std_msgs.msg import String

from bringup.viewing.robot.services import Services

COMMANDS = {
    name.lower(): getattr(ManageLifecycleNodes.Request, name)
    for name in ("STARTUP", "PAUSE", "RESUME", "RESET")
}
"""The commands that lifecycle managers take here."""
_MARKS = {"active": "●", "inactive": "○", "unconfigured": "·"}


class ManagedNodes:
    """Asks one node after the other for its state."""

    def __init__(self, services: Services) -> None:
        self._services = services
        self._round: list[str] = []
        self.states: dict[str, str] = {}
        self.report = ""

    def ask_next(self) -> None:
        """Ask the next node for its state; after the last, look who is there."""
        if not self._round:
            self._round = self._services.of_type("lifecycle_msgs/srv/GetState")
            here = {_node(name) for name in self._round}
            self.states = {name: state for name, state in self.states.items() if name in here}
        if not self._round:
            return
        name = self._round.pop(0)
        self._services.ask(GetState, name, GetState.Request(), partial(self._on_state, _node(name)))

    def _on_state(self, node: str, response: Any) -> None:
        self.states[node] = response.current_state.label

    def command(self, command: str) -> None:
        """Send a command to every lifecycle manager that takes commands."""
        request = ManageLifecycleNodes.Request(command=COMMANDS[command])
        managers = self._services.of_type("nav2_msgs/srv/ManageLifecycleNodes")
        self.report = f"{command} …" if managers else "no lifecycle manager takes commands"
        failed: list[str] = []
        pending = list(managers)

        def done(manager: str, response: Any) -> None:
            pending.remove(manager)
            if not response.success:
                failed.append(_node(manager))
            how = f"failed: {', '.join(failed)}" if failed else "done"
            self.report = f"{command} {how}" if not pending else self.report

        for manager in managers:
            self._services.ask(
                ManageLifecycleNodes, manager, request, partial(done, manager), 120.0
            )

    def save_map(self, kind: str, name: str) -> None:
        """Save the map of slam_toolbox as picture and YAML (`map`), or as its graph (`graph`)."""
        service, request = (
            (SaveMap, SaveMap.Request(name=String(data=name)))
            if kind == "map"
            else (SerializePoseGraph, SerializePoseGraph.Request(filename=name))
        )
        names = self._services.of_type(f"slam_toolbox/srv/{service.__name__}")
        self.report = f"saving the {kind} …" if names else "no slam_toolbox is running"

        def done(response: Any) -> None:
            how = "is saved" if response.result == 0 else f"is not saved: result {response.result}"
            self.report = f"the {kind} '{name}' {how}"

        for one in names:
            self._services.ask(service, one, request, done, 30.0)

    def clear_costmaps(self) -> None:
        """Empty every costmap."""
        names = self._services.of_type("nav2_msgs/srv/ClearEntireCostmap")
        self.report = "costmaps cleared" if names else "no costmap is running"
        for name in names:
            request = ClearEntireCostmap.Request()
            self._services.ask(ClearEntireCostmap, name, request, lambda response: None)


def nodes_text(states: Mapping[str, str], cpu: Mapping[str, float] = MappingProxyType({})) -> str:
    """Return nodes' lifecycle states and shares of a core as a Markdown table."""
    if not states and not cpu:
        return "no managed nodes found"
    rows = [
        f"| {_MARKS.get(states.get(name, ''), '✖') if name in states else ''} | {name} "
        f"| {states.get(name, '')} | {f'{cpu[name]:.0%}' if name in cpu else ''} |"
        for name in sorted({*states, *cpu})
    ]
    return "\n".join(["| | node | state | CPU |", "|-|-|-|-|", *rows])


def _node(service: str) -> str:
    return service.rpartition("/")[0].lstrip("/")
