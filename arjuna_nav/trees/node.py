"""Trees and their nodes: a status, ports, children, conditions; ticked and halted.

The engine is our own: py_trees ticks half as fast, and has neither BehaviorTree.CPP's XML, ports
and scripts nor Nav2's nodes, which are four fifths of this wing.

Source: BehaviorTree.CPP 4, TreeNode, ControlNode and DecoratorNode.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from arjuna_nav.trees.blackboard import Blackboard, Entry, TreeError
from arjuna_nav.trees.exchange import Ask, StatusChange, Topic, TreeState, Withdraw
from arjuna_nav.trees.ports import NOT_OF_KIND, REQUIRED, TEXT, Port, entry, literal, mismatch
from arjuna_nav.trees.script import Script


class Status(enum.Enum):
    """The state of a node; SKIPPED where a condition in its attributes left it out."""

    IDLE = enum.auto()
    RUNNING = enum.auto()
    SUCCESS = enum.auto()
    FAILURE = enum.auto()
    SKIPPED = enum.auto()


ENDED = (Status.SUCCESS, Status.FAILURE)
_DECIDING = {"_failureIf": Status.FAILURE, "_successIf": Status.SUCCESS, "_skipIf": Status.SKIPPED}
_AFTER = {"_onSuccess": (Status.SUCCESS,), "_onFailure": (Status.FAILURE,), "_post": ENDED}
SCRIPTED = (*_DECIDING, "_while", *_AFTER, "_onHalted")
"""Attributes of any node that hold scripts, in the order in which they are run."""


@dataclass
class Maker:
    """The parts of a node: `texts` are its ports as the XML has them, `scripts` by `SCRIPTED`."""

    name: str
    uid: int
    texts: Mapping[str, str]
    children: tuple[TreeNode, ...]
    board: Blackboard
    tree: Tree
    scripts: Mapping[str, Script] = field(default_factory=dict)


class TreeNode:
    """One node of its parts; a port's text that can be no value of it raises TreeError."""

    PORTS: ClassVar[dict[str, Port]] = {}
    """The ports by their names: each attribute of the class that is a Port."""
    CHILDREN: ClassVar[tuple[int, float]] = (0, 0)
    """Least and greatest number of children."""
    _run_since = 0.0
    _before = Status.IDLE
    """The status of a node with children before this tick."""

    def __init_subclass__(cls) -> None:
        own = {port.name: port for port in vars(cls).values() if isinstance(port, Port)}
        cls.PORTS = {**cls.PORTS, **own}

    def __init__(self, maker: Maker) -> None:
        self.name = maker.name
        self.uid = maker.uid
        self.children = maker.children
        self.tree = maker.tree
        self.status = Status.IDLE
        self._texts = maker.texts
        self.board = maker.board
        scripts = maker.scripts
        self._deciding = [(scripts[key], _DECIDING[key]) for key in _DECIDING if key in scripts]
        self._while = scripts.get("_while")
        self._guarded = bool(self._deciding) or self._while is not None
        self._after = [(scripts[key], _AFTER[key]) for key in _AFTER if key in scripts]
        self._halted = scripts.get("_onHalted")
        self._entries: dict[str, Entry] = {}
        self._values: dict[str, Any] = {}
        for name, port in self.PORTS.items():
            self._bind(name, port)

    def _bind(self, name: str, port: Port) -> None:
        text = self._texts.get(name)
        key = entry(text) if text is not None else None
        if key is not None:
            self._entries[name] = self.board.entry(key)
        elif text is not None and not self._is_left_empty(text, port):
            self._values[name] = literal(text, port, f"<{self.name}>: port '{name}'")
        elif port.default is not REQUIRED:
            self._values[name] = port.default

    def _is_left_empty(self, text: str, port: Port) -> bool:
        """Return whether a text is what Groot writes of a port that nobody has filled in."""
        if text.strip():
            return False
        try:
            literal(text, port, "")
        except TreeError:
            return True
        return False

    def execute(self) -> Status:
        """Tick the node, unless its conditions decide, and keep its status."""
        status = self._decided() if self._guarded else None
        if status is None:
            if self.status is not Status.RUNNING:
                self._run_since = self.tree.state.now
            if self.children:
                self._before = self.status
                if self._before is not Status.RUNNING:
                    self.set_status(Status.RUNNING)
            status = self._tick()
        if status is not self.status:
            self.set_status(status)
        for script, statuses in self._after:
            if status in statuses:
                script.run(self.board)
        return status

    @property
    def elapsed(self) -> float:
        """Time since the first tick of this run [ms]."""
        return (self.tree.state.now - self._run_since) * 1000.0

    def _decided(self) -> Status | None:
        """Return the status that the conditions give the node, None where it is ticked."""
        begins = self.status in (Status.IDLE, Status.SKIPPED)
        for script, status in self._deciding if begins else ():
            if script.holds(self.board):
                return status
        if self._while is None or not (begins or self.status is Status.RUNNING):
            return None
        if self._while.holds(self.board):
            return None
        self.reset()
        return Status.SKIPPED

    def _tick(self) -> Status:
        """Do the node's work; never IDLE."""
        raise NotImplementedError

    def _on_halt(self) -> None:
        """Stop the running node and forget its state."""

    def halt(self) -> None:
        """Stop the node and all below it; it is idle then."""
        self.reset_children()
        self._on_halt()
        if self._halted is not None and self.status is Status.RUNNING:
            self._halted.run(self.board)
        self.set_status(Status.IDLE)

    def reset(self) -> None:
        """Make the node idle; stop it where it runs."""
        if self.status is Status.RUNNING:
            self.halt()
        else:
            self.set_status(Status.IDLE)

    def topics(self) -> set[Topic]:
        """Return the topics that the node and those below it listen to."""
        return set().union(*(child.topics() for child in self.children))

    def topic(self, port: str) -> str:
        """Return the topic that a port names; it is listened to from when the tree is built on.

        Raises:
            TreeError: It is an entry of the blackboard, which may change.
        """
        bound = self._entries.pop(port, None)
        if bound is not None:
            if bound.value is None:
                where = self._texts[port]
                raise TreeError(f"{self.name}: port '{port}' is {where}; valid: a topic's name")
            self._values[port] = str(bound.value)
        return str(self._values[port])

    def named_entry(self, port: str) -> Entry:
        """Return the entry that a port names, in braces or not.

        Raises:
            TreeError: The port is not given.
        """
        if port not in self._texts:
            raise TreeError(f"{self.name}: port '{port}' is not given")
        text = self._texts[port]
        return self.board.entry(entry(text) or text)

    def reset_children(self) -> None:
        """Make all children idle."""
        for child in self.children:
            child.reset()

    def set_status(self, status: Status) -> None:
        """Change the status; the change is logged."""
        if status is not self.status:
            self.tree.log(self, self.status, status)
            self.status = status

    def get(self, name: str) -> Any:
        """Return a port's value.

        Raises:
            TreeError: It must be given and is not, or is not of its kind.
        """
        if name in self._values:
            return self._values[name]
        port, bound = self.PORTS[name], self._entries.get(name)
        if bound is not None and bound.value is not None:
            try:
                return port.kind.convert(bound.value)
            except NOT_OF_KIND as error:
                where = f"{self.name}: port '{name}'"
                raise mismatch(bound.value, port.kind, where, error) from error
        if bound is not None and port.default is not REQUIRED:
            return port.default
        text = self._texts.get(name)
        missing = "it is not given" if text is None else f"{text} is not on the blackboard"
        raise TreeError(f"{self.name}: port '{name}': {missing}; valid: {port.kind.name}")

    def fixed(self, name: str) -> Any:
        """Return a port's value that no entry of the blackboard gives, None where one does."""
        return self._values.get(name)

    def put(self, name: str, value: Any) -> None:
        """Write a port's value where the XML names an entry for it."""
        if name in self._entries:
            self._entries[name].set(value)


class Control(TreeNode):
    """A node with any number of children."""

    CHILDREN = (1, float("inf"))

    def _end(self, status: Status) -> Status:
        self.reset_children()
        self._on_halt()
        return status


class Decorator(TreeNode):
    """A node with one child; a child that has ended is idle again at once."""

    CHILDREN = (1, 1)

    def __init__(self, maker: Maker) -> None:
        super().__init__(maker)
        self.child = maker.children[0]

    def execute(self) -> Status:
        """Tick the node, keep its status, and make its child ready for the next time."""
        status = super().execute()
        if self.child.status is not Status.RUNNING:
            self.child.set_status(Status.IDLE)
        return status


class Condition(TreeNode):
    """A node that answers at once."""

    def _tick(self) -> Status:
        return Status.SUCCESS if self._holds() else Status.FAILURE

    def _holds(self) -> bool:
        raise NotImplementedError


class Framed(TreeNode):
    """A node that names the frames of the robot's pose; empty ones are the navigator's."""

    global_frame = Port(TEXT, "")
    robot_base_frame = Port(TEXT, "")


class Tree:
    """One tree; its nodes share its state, requests and log.

    Attributes:
        root: Its uppermost node.
        state: The state of the robot and the requests in this tick.
        calls: The services that its nodes offer; each returns why it refuses, or nothing.
        failures: What actions last said of each error code with which they failed, in that order.
    """

    root: TreeNode
    topics: set[Topic]

    def __init__(self) -> None:
        self.blackboard = Blackboard()
        self.state = TreeState(0.0)
        self.asking: list[TreeNode] = []
        self.calls: dict[str, Callable[[], str]] = {}
        self.failures: dict[int, str] = {}
        self._commands: list[Ask | Withdraw] = []
        self._changes: list[StatusChange] = []
        self._last_key = 0

    def nodes(self) -> Iterator[TreeNode]:
        """Yield all its nodes, the uppermost first."""
        left = [self.root]
        while left:
            node = left.pop()
            yield node
            left += reversed(node.children)

    def ask(
        self,
        kind: str,
        server: str,
        fields: Mapping[str, Any],
        feedback: bool = False,
        timeout: float = 0.0,
    ) -> int:
        """Ask a server; return the key of its answer, and of its feedback where that is wanted."""
        self._last_key += 1
        self._commands.append(Ask(self._last_key, kind, server, fields, feedback, timeout))
        return self._last_key

    def withdraw(self, key: int) -> None:
        """Withdraw a request."""
        self._commands.append(Withdraw(key))

    def note_failure(self, code: int, message: str) -> None:
        """Keep what an action said as it failed, also where no port of the tree takes it."""
        self.failures.pop(code, None)
        self.failures[code] = message

    def log(self, node: TreeNode, before: Status, after: Status) -> None:
        """Note a node's change of status."""
        change = StatusChange(self.state.now, node.name, node.uid, before.name, after.name)
        self._changes.append(change)

    def tick(self, state: TreeState) -> tuple[Status, list[Ask | Withdraw]]:
        """Tick the tree once; return its status and its requests.

        Raises:
            TreeError: A node lacks what it must be given.
        """
        self.state, self._commands = state, []
        status = self.root.execute()
        if status is not Status.RUNNING:
            self.root.reset()
        return status, self._commands

    def halt(self, state: TreeState) -> list[Ask | Withdraw]:
        """Stop the tree; return what is withdrawn."""
        self.state, self._commands = state, []
        self.root.halt()
        return self._commands

    def take_changes(self) -> tuple[StatusChange, ...]:
        """Return the changes of status since the last call."""
        changes, self._changes = tuple(self._changes), []
        return changes
