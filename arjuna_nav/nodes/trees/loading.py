"""The file that a goal's `behavior_tree` names, and a tree's log as a message."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from nav2_msgs.msg import BehaviorTreeLog, BehaviorTreeStatusChange

from arjuna_core.files.shipped import shipped_file
from arjuna_core.ros.convert import time_msg
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.exchange import StatusChange
from arjuna_nav.trees.files import default_tree, tree_file
from arjuna_nav.trees.node import Tree, TreeNode
from arjuna_nav.trees.xml_file import read_tree


class TreeChoice:
    """The tree that drives, by the goal or by a parameter.

    Args:
        defaults: By kind of goals, the tree of those that name none; empty: Arjuna's.
        folders: Of the trees that goals may name; parameters may name those of all but the first.
        nodes: Those that a tree may have.
        reload: Whether files are read again for each goal, or where another tree drove before.

    Raises:
        TreeError: A default tree cannot be run.
    """

    def __init__(
        self,
        defaults: Mapping[str, str],
        folders: Sequence[str],
        nodes: Mapping[str, type[TreeNode]],
        reload: bool,
    ) -> None:
        self._name, self._nodes, self._reload = "", nodes, reload
        self._contents: dict[Path, bytes] = {}
        self._defaults = {kind: name or f"{kind}.xml" for kind, name in defaults.items()}
        self._folders = folders
        trees = [self._default(kind) for kind in self._defaults]
        self.tree = trees[0]
        self.topics = set().union(*(tree.topics for tree in trees))

    def choose(self, kind: str, asked: str, preempts: bool) -> str:
        """Load the tree of a goal; return why that cannot be, or nothing.

        As Nav2's, a goal does not replace (`preempts`) one that another tree drives.
        """
        name = asked or self._defaults[kind]
        if preempts:
            same = name == self._name
            return "" if same else f"'{self._name}' drives the goal that runs, not '{name}'"
        if self._reload or name != self._name:
            self._contents.clear()
        try:
            self.tree = (
                self._read(tree_file(asked, self._folders)) if asked else self._default(kind)
            )
        except TreeError as error:
            return str(error)
        self._name = name
        return ""

    def _default(self, kind: str) -> Tree:
        """Return the tree of a parameter: Arjuna's, any file, or a shipped one by its name.

        Raises:
            TreeError: There is no such file, or it holds no tree that can be run.
        """
        name = self._defaults[kind]
        own = name == f"{kind}.xml"  # whatever lies in the working folder by that name
        path = shipped_file("behavior_trees") / name if own else default_tree(name, self._folders)
        return self._read(path)

    def _read(self, path: Path) -> Tree:
        return read_tree(path, self._nodes, self._contents)


def log_msg(changes: Sequence[StatusChange], now: float) -> Any:
    """Return the changes of a tree as the message of behavior_tree_log."""
    return BehaviorTreeLog(
        timestamp=time_msg(now),
        event_log=[
            BehaviorTreeStatusChange(
                timestamp=time_msg(change.now),
                node_name=change.node,
                uid=change.uid,
                previous_status=change.before,
                current_status=change.after,
            )
            for change in changes
        ],
    )
