"""The files of behavior trees, by the names that goals and parameters have for them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from arjuna_core.files.maps_folder import MapsFolderError, path_in_folder
from arjuna_core.files.shipped import shipped_file
from arjuna_nav.trees.blackboard import TreeError


def default_tree(name: str, folders: Sequence[str]) -> Path:
    """Return the tree of a parameter: any file, or as `tree_file` in all but the first folder.

    Raises:
        TreeError: There is none.
    """
    path = Path(name)
    return path if path.is_file() else tree_file(name, (".", *folders[1:]))


def tree_file(name: str, folders: Sequence[str]) -> Path:
    """Return the tree of a name: a file in a folder, or a shipped one by its name.

    Raises:
        TreeError: There is none.
    """
    for each in folders:
        try:
            path = path_in_folder(each, name)
        except MapsFolderError:
            continue  # a path on another machine may end in the name of a shipped tree
        if path.is_file():
            return path
    shipped = shipped_file("behavior_trees")
    own = shipped / Path(name).name
    if own.suffix == ".xml" and own.is_file():
        return own
    valid = ", ".join(sorted(each.name for each in shipped.glob("*.xml")))
    raise TreeError(
        f"there is no behavior tree '{name}' in the folder '{folders[0]}' (parameter "
        f"'bt_folder'); valid: a file there, or {valid}"
    )
