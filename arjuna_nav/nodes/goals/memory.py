"""The current goal, stored in a file, and nodes that resume it after their process has ended."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.ros.goal_client import GoalClient
from arjuna_core.ros.goal_server import GoalNode
from arjuna_core.ros.node import ManagedNode
from arjuna_nav.nodes.costmap.reader import CostmapReader


class GoalMemory:
    """The goal that runs, sent again once the node may take it.

    Args:
        node: The node whose goals they are; made in its `configure`.
        file: Keeps the goal; empty: none is kept.
        actions: The node's actions by name.
        max_age: Greatest age of a costmap that can be planned on [s].
    """

    def __init__(
        self, node: ManagedNode, file: str, actions: Mapping[str, Any], max_age: float = 1.0
    ) -> None:
        self._max_age = max_age
        self._node = node
        self._file = Path(file) if file else None
        self._actions = dict(actions)
        self._unfinished: tuple[str, Any] | None = None
        self._clients: dict[str, GoalClient] = {}
        if self._file is not None:
            self._clients = {k: node.keep(GoalClient(node, a, k)) for k, a in actions.items()}
            self._costmap = CostmapReader(node, "global_costmap/costmap_raw", "", "", math.inf)

    def keep(self, name: str, goal: Any) -> None:
        """Keep a goal of an action in place of the last."""
        self._unfinished = None
        if self._file is not None:
            write_atomically(self._file, name.encode() + b"\n" + serialize_message(goal))

    def forget(self) -> None:
        """Keep nothing: the goal has ended."""
        self._unfinished = None
        if self._file is not None:
            self._file.unlink(missing_ok=True)

    def recall(self) -> None:
        """Look for a goal that did not end; `resume`, called again and again, sends it."""
        if self._file is None or not self._file.is_file():
            return
        first, _, data = read_bytes(self._file, 1 << 24).partition(b"\n")
        name = first.decode(errors="replace")
        if name in self._actions:
            self._unfinished = name, deserialize_message(data, self._actions[name].Goal)

    def resume(self) -> None:
        """Send the goal again that did not end, once the robot's pose on a map is known.

        A goal of a client that comes meanwhile goes before.
        """
        if self._unfinished is None:
            return
        if self._costmap.current(self._max_age) is None:
            return
        (name, goal), self._unfinished = self._unfinished, None
        self._node.get_logger().info(f"{name}: resumes the goal that was under way")
        self._clients[name].send(goal, lambda outcome: None, yields=True)


class ResumingNode(GoalNode):
    """Resumes the current goal after a crash or a jump of time, if `resume_file` is set.

    Attributes:
        memory: The current goal; made in `configure`.
    """

    memory: GoalMemory

    def activate(self) -> None:
        self.memory.recall()

    def deactivate(self) -> None:
        """Stop and abort what is asked for; it is not resumed."""
        super().deactivate()
        self.memory.forget()

    def on_time_jump(self) -> None:
        """Stop and abort, or resume the current goal if `resume_file` is set."""
        if not self.config.resume_file:
            super().on_time_jump()
        elif self.active:
            self.resume_goal()

    def resume_goal(self) -> None:
        """Resume the current goal after the clock has jumped."""
