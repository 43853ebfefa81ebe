"""Trees and what every node of one is: a status, ports, children; ticked and halted.

Source: BehaviorTree.CPP 4, TreeNode, ControlNode and DecoratorNode.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from arjuna_nav.trees.exchange import Ask, StatusChange, Topic, TreeState, Withdraw
from arjuna_nav.trees.ports import REQUIRED, Blackboard, Port, TreeError, converted, entry

_FIRST_KEY = 1


class Status(enum.Enum):
    """How a node is."""

    IDLE = enum.auto()
    RUNNING = enum.auto()
    SUCCESS = enum.auto()
    FAILURE = enum.auto()


@dataclass
class Running:
    """What the nodes of a tree share while it runs.

    Attributes:
        root: The blackboard of the whole tree.
        state: What is known in this tick.
        commands: What was asked in this tick.
        changes: Which nodes changed their status since they were last taken.
        asking: The nodes that ask servers.
    """

    root: Blackboard = field(default_factory=Blackboard)
    state: TreeState = field(default_factory=lambda: TreeState(0.0))
    commands: list[Ask | Withdraw] = field(default_factory=list)
    changes: list[StatusChange] = field(default_factory=list)
    asking: list[TreeNode] = field(default_factory=list)
    _next: int = _FIRST_KEY

    def ask(self, kind: str, server: str, fields: Mapping[str, Any], feedback: bool = False) -> int:
        """Ask a server; return the key of its answer, and of its feedback where that is wanted."""
        key, self._next = self._next, self._next + 1
        self.commands.append(Ask(key, kind, server, fields, feedback))
        return key


@dataclass
class Maker:
    """What a node is made of.

    Attributes:
        name: Its name.
        uid: Its number.
        texts: Its ports as the XML has them.
        children: Its children.
        board: The blackboard of its tree.
        running: What all nodes share.
    """

    name: str
    uid: int
    texts: Mapping[str, str]
    children: tuple[TreeNode, ...]
    board: Blackboard
    running: Running


class TreeNode:
    """One node.

    Args:
        maker: What it is made of.
    """

    PORTS: ClassVar[dict[str, Port]] = {}
    CHILDREN: ClassVar[tuple[int, float]] = (0, 0)
    """Least and greatest number of children."""

    def __init__(self, maker: Maker) -> None:
        self.name = maker.name
        self.uid = maker.uid
        self.children = maker.children
        self.running = maker.running
        self.status = Status.IDLE
        self._texts = maker.texts
        self._named: dict[str, str] = {}
        self._board = maker.board

    def execute(self) -> Status:
        """Tick the node and keep its status."""
        self.set_status(self.tick())
        return self.status

    def tick(self) -> Status:
        """Do what the node does; never IDLE."""
        raise NotImplementedError

    def on_halt(self) -> None:
        """Stop what is under way and forget it."""

    def halt(self) -> None:
        """Stop the node and all below it; it is idle then."""
        self.reset_children()
        self.on_halt()
        self.set_status(Status.IDLE)

    def reset(self) -> None:
        """Make the node idle; stop it where it runs."""
        if self.status is Status.RUNNING:
            self.halt()
        else:
            self.set_status(Status.IDLE)

    def topics(self) -> set[Topic]:
        """Return the topics that the node and those below it must be told of."""
        return set().union(*(child.topics() for child in self.children))

    def topic(self, port: str) -> str:
        """Return the topic that a port names; it is listened to from when the tree is built on.

        Raises:
            TreeError: It is an entry of the blackboard that was not there then.
        """
        if port not in self._named:
            text = self._texts.get(port, "")
            key = entry(text)
            if key is not None and self._board.get(key) is None:
                raise TreeError(f"{self.name}: port '{port}' is {text}; valid: a topic's name")
            self._named[port] = str(self.get(port))
        return self._named[port]

    def reset_children(self) -> None:
        """Make all children idle."""
        for child in self.children:
            child.reset()

    def set_status(self, status: Status) -> None:
        """Change the status; the change is told."""
        if status is not self.status:
            now = self.running.state.now
            change = StatusChange(now, self.name, self.uid, self.status.name, status.name)
            self.running.changes.append(change)
            self.status = status

    def get(self, name: str) -> Any:
        """Return a port's value.

        Raises:
            TreeError: It must be given and is not, or is none of its kind.
        """
        port = self.PORTS[name]
        text = self._texts.get(name)
        key = entry(text) if text is not None else None
        value = text if key is None else self._board.get(key)
        where = f"{self.name}: port '{name}'"
        if value is None:
            if port.default is REQUIRED:
                missing = f"{{{key}}} is not on the blackboard" if key else "it is not given"
                raise TreeError(f"{where}: {missing}; valid: {port.kind.name}")
            return port.default
        return converted(value, port.kind, where)

    def put(self, name: str, value: Any) -> None:
        """Write a port's value where the XML names an entry for it."""
        text = self._texts.get(name)
        key = entry(text) if text is not None else None
        if key is not None:
            self._board.set(key, value)


class Control(TreeNode):
    """A node with any number of children."""

    CHILDREN = (1, float("inf"))


class Decorator(TreeNode):
    """A node with one child; a child that has ended is idle again at once."""

    CHILDREN = (1, 1)

    @property
    def child(self) -> TreeNode:
        """The child."""
        return self.children[0]

    def execute(self) -> Status:
        """Tick the node, keep its status, and make its child ready for the next time."""
        status = super().execute()
        if self.child.status in (Status.SUCCESS, Status.FAILURE):
            self.child.reset()
        return status


class Tree:
    """One tree.

    Args:
        root: Its uppermost node.
        running: What its nodes share.

    Attributes:
        topics: That the nodes must be told of.
    """

    def __init__(self, root: TreeNode, running: Running) -> None:
        self._root = root
        self._running = running
        self.topics = root.topics()

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
