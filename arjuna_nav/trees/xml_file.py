"""Trees in BehaviorTree.CPP's XML, format 4, and 3 where it is the same."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from arjuna_core.errors import InputFileError, nearest
from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.maps_folder import MapsFolderError, path_in_folder
from arjuna_core.files.shipped import package_file, shipped_file
from arjuna_core.files.xml_text import parse_xml
from arjuna_nav.trees import actions, conditions, controls, decorators, replanning, servers
from arjuna_nav.trees.blackboard import Blackboard, TreeError
from arjuna_nav.trees.node import SCRIPTED, Decorator, Maker, Status, Tree, TreeNode
from arjuna_nav.trees.ports import entry
from arjuna_nav.trees.script import Script


def nodes_in(*modules: ModuleType) -> dict[str, type[TreeNode]]:
    """Return the nodes that modules define, by name: their public classes."""
    return {
        name: cls
        for module in modules
        for name, cls in vars(module).items()
        if isinstance(cls, type) and issubclass(cls, TreeNode) and cls.__module__ == module.__name__
        if not name.startswith("_")
    }


NODES: Mapping[str, type[TreeNode]] = {
    **nodes_in(controls, decorators, conditions, actions, servers, replanning),
    **controls.SWITCHES,
    **decorators.MAPPED,
    **decorators.COUNTED,
    **decorators.LOOPS,
    **conditions.CONDITIONS,
    **actions.SELECTORS,
    **servers.SERVERS,
    "AsyncSequence": controls.Sequence,
    "AsyncFallback": controls.Fallback,
    "SequenceStar": controls.SequenceWithMemory,
    "RetryUntilSuccesful": decorators.COUNTED["RetryUntilSuccessful"],
}
"""The nodes that a tree may have, by the names of BehaviorTree.CPP and Nav2."""
_OF_FORMAT_3 = {
    ("Parallel", "success_threshold"): "success_count",
    ("Parallel", "failure_threshold"): "failure_count",
}
"""Ports that format 3 calls otherwise: node and port, and the name today."""
_MAX_SIZE, _MAX_NODES, _MAX_DEPTH, _MAX_FILES = 1_000_000, 2000, 100, 20
_BY_ID = ("Action", "Condition", "Control", "Decorator")
_SUBTREES = ("SubTree", "SubTreePlus")
_SHARING = ("_autoremap", "__autoremap", "__shared_blackboard")
_OWN_NAME = ("{=}", "=")
"""Texts of a port whose entry has the port's own name."""
_IGNORED = ("_description", "_fullpath", "_uid")
_BUILT_IN = ("nav2_", "opennav_dock_", "opennav_undock_")
"""What names of libraries begin with whose nodes are here."""


class UnknownNodeError(TreeError):
    """A tree has a node that is not here."""


class SubTree(Decorator):
    """A tree in a tree, with entries of its own."""

    def _tick(self) -> Status:
        return self.child.execute()


def with_own_nodes(modules: Iterable[str]) -> tuple[Mapping[str, type[TreeNode]], list[str]]:
    """Return the nodes that a tree may have with those of a user's modules, by name.

    Args:
        modules: Names of Python modules. Libraries of Nav2 and its docking are built in.

    Returns:
        The nodes, and why modules are left out.
    """
    nodes, problems = dict(NODES), []
    for name in modules:
        if name.startswith(_BUILT_IN):
            continue
        try:
            nodes |= nodes_in(importlib.import_module(name))
        except (ImportError, ValueError) as error:
            problems.append(f"'{name}' is no Python module with nodes of trees: {error}")
    return nodes, problems


def read_tree(
    path: Path,
    nodes: Mapping[str, type[TreeNode]] = NODES,
    contents: dict[Path, bytes] | None = None,
) -> Tree:
    """Read a file.

    Args:
        contents: Of files that are not read again; those that are read are added.

    Raises:
        TreeError: It cannot be read, or is no tree that can be run.
    """
    contents = {} if contents is None else contents
    return build_tree(_read(path, contents), str(path), path.parent, nodes, contents)


def _read(path: Path, contents: dict[Path, bytes]) -> bytes:
    if path not in contents:
        try:
            contents[path] = read_bytes(path, _MAX_SIZE)
        except InputFileError as error:
            raise TreeError(str(error)) from error
    return contents[path]


def build_tree(
    text: str | bytes,
    where: str,
    folder: Path = Path(),
    nodes: Mapping[str, type[TreeNode]] = NODES,
    contents: dict[Path, bytes] | None = None,
) -> Tree:
    """Build a tree from its XML.

    Args:
        folder: What it includes lies there, or below.
        nodes: Those that it may have.
        contents: Of files that are not read again.

    Raises:
        TreeError: It is no tree that can be run; the message names the node and what is valid.
    """
    document = _document(text, where)
    trees = _Trees(where, {} if contents is None else contents)
    trees.add(document, where, folder)
    return _Builder(where, trees, nodes).build(trees.main(document))


def _document(text: str | bytes, where: str) -> Any:
    try:
        document = parse_xml(where, text.encode() if isinstance(text, str) else text)
    except InputFileError as error:
        raise TreeError(str(error)) from error
    if document.tag != "root":
        raise TreeError(f"{where}: the outermost element is <{document.tag}>; valid: <root>")
    return document


@dataclass
class _Trees:
    """The trees of a file and of those that it includes, by name."""

    where: str
    contents: dict[Path, bytes]
    named: dict[str, Any] = field(default_factory=dict)
    models: dict[str, dict[str, str]] = field(default_factory=dict)
    files_of: dict[str, str] = field(default_factory=dict)
    own: list[str] = field(default_factory=list)
    files: set[Path] = field(default_factory=set)

    def add(self, document: Any, where: str, folder: Path) -> None:
        """Take the trees of a document and of its includes."""
        for element in document:
            if element.tag == "include":
                self._include(element, where, folder)
            elif element.tag == "TreeNodesModel":
                for model in element.iterfind("SubTree"):
                    ports = self.models.setdefault(model.get("ID", ""), {})
                    ports |= {port.get("name", ""): port.get("default", "") for port in model}
            elif element.tag == "BehaviorTree":
                name = element.get("ID", "")
                if len(element) != 1:
                    count = f"has {len(element)} children; valid: 1"
                    raise TreeError(f"{where}: <BehaviorTree ID='{name}'> {count}")
                if name in self.files_of:
                    both = f"stands in {self.files_of[name]}, too; valid: one tree of a name"
                    raise TreeError(f"{where}: <BehaviorTree ID='{name}'> {both}")
                self.named[name], self.files_of[name] = element, where
                if where == self.where:
                    self.own.append(name)

    def _include(self, element: Any, where: str, folder: Path) -> None:
        """Take an included file's trees; of a package of Nav2's that is not here, a shipped one."""
        named, package = element.get("path", ""), element.get("ros_pkg", "")
        installed = package_file(package, named)
        try:
            path = installed or path_in_folder(folder, named)
        except MapsFolderError as error:
            raise TreeError(f"{where}: <include path='{named}'>: {error}") from error
        shipped = shipped_file("behavior_trees") / path.name
        if package.startswith("nav2_") and installed is None and shipped.is_file():
            path = shipped
        path = path.resolve()
        if path in self.files or path == Path(self.where).resolve():
            return
        self.files.add(path)
        if len(self.files) > _MAX_FILES:
            raise TreeError(f"{where}: over {_MAX_FILES} files are included")
        self.add(_document(_read(path, self.contents), str(path)), str(path), path.parent)

    def main(self, document: Any) -> str:
        """Return the name of the tree to run."""
        name = document.get("main_tree_to_execute")
        if name is None and len(self.own) == 1:
            return self.own[0]
        if name not in self.named:
            hint = nearest(str(name), self.named)
            problem = f"main_tree_to_execute is '{name}', no tree of the file; {hint}"
            raise TreeError(f"{self.where}: {problem}")
        return str(name)


class _Builder:
    def __init__(self, where: str, trees: _Trees, nodes: Mapping[str, type[TreeNode]]) -> None:
        self._where = where
        self._trees, self._models = trees.named, trees.models
        self._nodes = nodes
        self._tree = Tree()
        self._count = 0

    def _error(self, problem: str) -> TreeError:
        return TreeError(f"{self._where}: {problem}")

    def build(self, main: str) -> Tree:
        tree = self._tree
        tree.root = self._node(self._trees[main][0], tree.blackboard, (main,), 0)
        tree.topics = tree.root.topics()
        return tree

    def _node(
        self, element: Any, board: Blackboard, inside: tuple[str, ...], depth: int
    ) -> TreeNode:
        self._count += 1
        if self._count > _MAX_NODES or depth > _MAX_DEPTH:
            raise self._error(f"over {_MAX_NODES} nodes, or deeper than {_MAX_DEPTH}")
        uid, texts = self._count, dict(element.attrib)
        is_subtree = element.tag in _SUBTREES
        kind = element.tag
        if is_subtree or kind in _BY_ID:
            kind = texts.get("ID", "")
            if not kind:
                raise self._error(f"<{element.tag}> has no ID; valid: <{element.tag} ID='...'>")
        texts.pop("ID", None)
        texts = {_OF_FORMAT_3.get((kind, key), key): text for key, text in texts.items()}
        texts = {key: f"{{{key}}}" if text in _OWN_NAME else text for key, text in texts.items()}
        name = texts.pop("name", "") or kind
        shown = f"<{kind} name='{name}'>"
        scripts = {
            key: self._script(shown, key, texts.pop(key)) for key in SCRIPTED if key in texts
        }
        if is_subtree:
            child = self._subtree(kind, texts, board, inside, depth)
            return SubTree(Maker(name, uid, {}, (child,), board, self._tree, scripts))
        cls = self._nodes.get(kind)
        if cls is None:
            hint = nearest(kind, [*self._nodes, "SubTree"])
            if hint.startswith("valid"):
                hint = f"C++ does not load, your own node in Python does: docs/plugins.md; {hint}"
            raise UnknownNodeError(f"{self._where}: there is no node '{kind}'; {hint}")
        self._check(shown, cls, texts, len(element))
        children = tuple(self._node(child, board, inside, depth + 1) for child in element)
        try:
            return cls(Maker(name, uid, texts, children, board, self._tree, scripts))
        except TreeError as error:
            raise self._error(str(error)) from error

    def _script(self, node: str, name: str, text: str) -> Script:
        try:
            return Script(text)
        except TreeError as error:
            raise self._error(f"{node}: '{name}': {error}") from error

    def _check(self, node: str, cls: type[TreeNode], texts: Mapping[str, str], count: int) -> None:
        """Refuse a node with attributes or children that it cannot have."""
        for name in texts:
            valid = cls.PORTS if not name.startswith("_") else (*SCRIPTED, *_IGNORED)
            if name not in valid:
                raise self._error(f"{node} has no port '{name}'; {nearest(name, valid)}")
        least, most = cls.CHILDREN
        if not least <= count <= most:
            known = str(least) if least == most else f"{least} or more"
            raise self._error(f"{node} has {count} children; valid: {known}")

    def _subtree(
        self,
        called: str,
        texts: dict[str, str],
        board: Blackboard,
        inside: tuple[str, ...],
        depth: int,
    ) -> TreeNode:
        """Build a tree in a tree; its entries are its own but for those that are passed."""
        if called not in self._trees:
            raise self._error(f"there is no tree '{called}'; {nearest(called, self._trees)}")
        if called in inside:
            raise self._error(f"tree '{called}' holds itself: {' > '.join((*inside, called))}")
        shared = any(texts.get(key, "").lower() in ("true", "1") for key in _SHARING)
        passed = {key: text for key, text in texts.items() if not key.startswith("_")}
        if not shared:
            passed = {**self._models.get(called, {}), **passed}
        if lacking := [key for key, text in passed.items() if not text and key not in texts]:
            raise self._error(f"<SubTree ID='{called}'> lacks {lacking}; its model has no default")
        renamed = {key: entry(text) or "" for key, text in passed.items() if entry(text)}
        literals = {key: text for key, text in passed.items() if key not in renamed}
        own = Blackboard(board, renamed, shared, literals)
        return self._node(self._trees[called][0], own, (*inside, called), depth + 1)
