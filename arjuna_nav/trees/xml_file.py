"""Trees in BehaviorTree.CPP's XML, format 4, and 3 where it is the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from defusedxml import DefusedXmlException
from defusedxml.ElementTree import ParseError, fromstring

from arjuna_core.errors import InputFileError, nearest
from arjuna_core.files.whole_file import read_bytes
from arjuna_nav.trees import controls, decorators
from arjuna_nav.trees.nav2.catalog import NAV2
from arjuna_nav.trees.node import Decorator, Maker, Running, Status, Tree, TreeNode
from arjuna_nav.trees.ports import Blackboard, TreeError, checked, entry

_PLAIN: tuple[type[TreeNode], ...] = (
    *(controls.Sequence, controls.SequenceWithMemory, controls.Fallback),
    *(controls.ReactiveSequence, controls.ReactiveFallback, controls.Parallel),
    *(controls.IfThenElse, controls.WhileDoElse),
    *(decorators.Inverter, decorators.ForceSuccess, decorators.ForceFailure),
    *(decorators.KeepRunningUntilFailure, decorators.Repeat, decorators.RetryUntilSuccessful),
    *(decorators.RunOnce, decorators.Timeout, decorators.Delay),
)
NODES: dict[str, type[TreeNode]] = {
    **{cls.__name__: cls for cls in (*_PLAIN, *NAV2)},
    "AsyncSequence": controls.Sequence,
    "AsyncFallback": controls.Fallback,
    "SequenceStar": controls.SequenceWithMemory,
}
"""The nodes that a tree may have, by the names of BehaviorTree.CPP and Nav2."""
_MAX_SIZE, _MAX_NODES, _MAX_DEPTH = 1_000_000, 2000, 100
_BY_ID = ("Action", "Condition", "Control", "Decorator")
_SUBTREES = ("SubTree", "SubTreePlus")
_IGNORED = ("_description", "_fullpath", "_uid")


class SubTree(Decorator):
    """A tree in a tree, with entries of its own."""

    def tick(self) -> Status:
        """Tick it."""
        self.set_status(Status.RUNNING)
        return self.child.execute()


def read_tree(path: Path) -> Tree:
    """Read a file.

    Raises:
        TreeError: It cannot be read, or is no tree that can be run.
    """
    try:
        text = read_bytes(path, _MAX_SIZE)
    except InputFileError as error:
        raise TreeError(str(error)) from error
    return build_tree(text, str(path))


def build_tree(text: str | bytes, where: str) -> Tree:
    """Build a tree of its XML.

    Args:
        text: The XML.
        where: What to name in errors.

    Raises:
        TreeError: It is no tree that can be run; the message names the node and what is valid.
    """
    try:
        document = fromstring(text, forbid_dtd=True)
    except (ParseError, DefusedXmlException, ValueError, RecursionError) as error:
        raise TreeError(f"{where}: no XML, or one with a DTD: {error}") from error
    return _Builder(document, where).build()


class _Builder:
    """Builds the nodes of one document."""

    def __init__(self, document: Any, where: str) -> None:
        self._where = where
        self._running = Running()
        self._count = 0
        if document.tag != "root":
            raise self._error(f"the outermost element is <{document.tag}>; valid: <root>")
        self._trees = dict(self._named(document))
        self._main = self._main_tree(document)

    def _error(self, problem: str) -> TreeError:
        return TreeError(f"{self._where}: {problem}")

    def _named(self, document: Any) -> Iterator[tuple[str, Any]]:
        """Return the document's trees by name."""
        for element in document:
            if element.tag == "include":
                raise self._error("<include> is not offered; put the trees into one file")
            if element.tag != "BehaviorTree":
                continue
            name = element.get("ID", "")
            if len(element) != 1:
                raise self._error(
                    f"<BehaviorTree ID='{name}'> has {len(element)} children; valid: 1"
                )
            yield name, element

    def _main_tree(self, document: Any) -> str:
        name = document.get("main_tree_to_execute")
        if name is None and len(self._trees) == 1:
            return next(iter(self._trees))
        if name not in self._trees:
            hint = nearest(str(name), self._trees)
            raise self._error(f"main_tree_to_execute is '{name}', no tree of the file; {hint}")
        return str(name)

    def build(self) -> Tree:
        root = self._node(self._trees[self._main][0], self._running.root, (self._main,), 0)
        return Tree(root, self._running)

    def _node(
        self, element: Any, board: Blackboard, inside: tuple[str, ...], depth: int
    ) -> TreeNode:
        """Build an element's node and all below it."""
        self._count += 1
        if self._count > _MAX_NODES or depth > _MAX_DEPTH:
            raise self._error(f"over {_MAX_NODES} nodes, or deeper than {_MAX_DEPTH}")
        uid, attributes = self._count, dict(element.attrib)
        if element.tag in _SUBTREES:
            return self._subtree(attributes, board, inside, depth, uid)
        kind = attributes.pop("ID", "") if element.tag in _BY_ID else element.tag
        cls = NODES.get(kind)
        if cls is None:
            valid = [*NODES, "SubTree"]
            raise self._error(f"there is no node '{kind}'; {nearest(kind, valid)}")
        attributes.pop("ID", None)
        name = attributes.pop("name", "") or kind
        self._check_ports(f"<{kind} name='{name}'>", cls, attributes)
        self._check_children(f"<{kind} name='{name}'>", cls, len(element))
        children = tuple(self._node(child, board, inside, depth + 1) for child in element)
        return cls(Maker(name, uid, attributes, children, board, self._running))

    def _check_ports(self, node: str, cls: type[TreeNode], texts: Mapping[str, str]) -> None:
        for name, text in texts.items():
            if name in _IGNORED:
                continue
            if name.startswith("_"):
                raise self._error(f"{node}: '{name}' (scripts and conditions) is not offered")
            if name not in cls.PORTS:
                raise self._error(f"{node} has no port '{name}'; {nearest(name, cls.PORTS)}")
            checked(text, cls.PORTS[name], f"{self._where}: {node}: port '{name}'")

    def _check_children(self, node: str, cls: type[TreeNode], count: int) -> None:
        least, most = cls.CHILDREN
        if not least <= count <= most:
            valid = str(least) if least == most else f"{least} or more"
            raise self._error(f"{node} has {count} children; valid: {valid}")

    def _subtree(
        self,
        attributes: dict[str, str],
        board: Blackboard,
        inside: tuple[str, ...],
        depth: int,
        uid: int,
    ) -> TreeNode:
        """Build a tree in a tree; its entries are its own but for those that are passed."""
        called = attributes.pop("ID", "")
        if called not in self._trees:
            raise self._error(f"there is no tree '{called}'; {nearest(called, self._trees)}")
        if called in inside:
            raise self._error(f"tree '{called}' holds itself: {' > '.join((*inside, called))}")
        name = attributes.pop("name", "") or called
        flags = (attributes.pop("_autoremap", ""), attributes.pop("__autoremap", ""))
        shared = any(flag.lower() in ("true", "1") for flag in flags)
        passed = {key: text for key, text in attributes.items() if not key.startswith("_")}
        renamed = {key: entry(text) or "" for key, text in passed.items() if entry(text)}
        own = Blackboard(board, renamed, shared)
        for key in passed.keys() - renamed.keys():
            own.set(key, passed[key])
        root = self._trees[called][0]
        child = self._node(root, own, (*inside, called), depth + 1)
        return SubTree(Maker(name, uid, {}, (child,), own, self._running))
