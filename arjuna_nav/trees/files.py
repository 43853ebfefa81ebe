"""The files of behavior trees, by the names that goals and parameters have for them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.files.shipped import shipped_file
from arjuna_nav.trees.blackboard import TreeError

_NAV2 = "nav2_bt_navigator"


def default_tree(name: str, folders: Sequence[str]) -> Path:
    """Return the tree of a parameter: any file, or as `tree_file` in all but the first folder.

    Raises:
        TreeError: There is none.
    """
    path = Path(name)
    return path if path.is_file() else tree_file(name, (".", *folders[1:]))


def tree_file(name: str, folders: Sequence[str]) -> Path:
    """Return the tree of a name: a file in a folder or the user's home, or a shipped one.

    A shipped one stands for Nav2's of its name, and for paths of another machine; never for a file
    of one's own that is here, but not where a goal may name it.

    Raises:
        TreeError: There is none.
    """
    for each in folders:
        try:
            path = map_path(each, name)
        except MapsFolderError:
            continue  # a path on another machine may end in the name of a shipped tree
        if path.is_file():
            return path
    shipped = shipped_file("behavior_trees")
    own = shipped / Path(name).name
    is_here = name.startswith("/") and os.path.isfile(name)  # noqa: PTH113 - names of any kind
    if own.is_file() and own.suffix == ".xml" and not (is_here and _NAV2 not in Path(name).parts):
        return own
    valid = ", ".join(sorted(each.name for each in shipped.glob("*.xml")))
    raise TreeError(
        f"there is no behavior tree '{name}' in the folder '{folders[0]}' (parameter "
        f"'bt_folder') or the user's home; valid: a file there, or {valid}"
    )
