"""A tree that runs: told what is known, it says what to ask and how it ended."""

from __future__ import annotations

from arjuna_nav.trees.exchange import Ask, StatusChange, TreeState, Withdraw
from arjuna_nav.trees.node import Running, Status, TreeNode
from arjuna_nav.trees.plain_actions import topics
from arjuna_nav.trees.ports import Blackboard


class Tree:
    """One tree.

    Args:
        root: Its uppermost node.
        running: What its nodes share.

    Attributes:
        topics: On which something is chosen.
    """

    def __init__(self, root: TreeNode, running: Running) -> None:
        self._root = root
        self._running = running
        self.topics = topics(root)

    @property
    def blackboard(self) -> Blackboard:
        """The entries of the whole tree."""
        return self._running.root

    def tick(self, state: TreeState) -> tuple[Status, list[Ask | Withdraw]]:
        """Tick the tree once; return its status and what it asks.

        Raises:
            TreeError: A node lacks what it must be given.
        """
        self._running.state = state
        self._running.commands.clear()
        status = self._root.execute()
        if status is not Status.RUNNING:
            self._root.reset()
        return status, list(self._running.commands)

    def halt(self, state: TreeState) -> list[Ask | Withdraw]:
        """Stop the tree; return what is withdrawn."""
        self._running.state = state
        self._running.commands.clear()
        self._root.halt()
        return list(self._running.commands)

    def take_changes(self) -> tuple[StatusChange, ...]:
        """Return which nodes changed their status since this was asked last."""
        changes = tuple(self._running.changes)
        self._running.changes.clear()
        return changes
