"""The navigators of bt_navigator: an action each, whose goals a behavior tree drives to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Protocol

from nav2_msgs import action

from arjuna_core.config import NoParameters
from arjuna_core.plugins import PluginTypes


class GoalNavigator(Protocol):
    """One action; made of `(config)`, the parameters below its name.

    A class has `Config`, the frozen dataclass of its parameters. The feedback and the result get
    those of bt_navigator's fields that the action has, by Nav2's names.

    Attributes:
        through: Whether errors of planning count from 300, as those of paths through poses.
    """

    name: str
    action: Any
    through: bool

    def default_tree(self, server: Any) -> str:
        """Return the file of the tree of goals that name none, given bt_navigator's parameters."""
        ...

    def poses(self, goal: Any) -> Sequence[Any]:
        """Return the poses of a goal, each a PoseStamped; the last is where it ends."""
        ...

    def entries(self, goal: Any) -> dict[str, Any]:
        """Return what else of a goal the tree's blackboard has, by name."""
        ...


class _Nav2Navigator:
    Config: ClassVar[type[Any]] = NoParameters

    def __init__(self, config: Any) -> None:
        pass

    def entries(self, goal: Any) -> dict[str, Any]:
        """Return nothing: the poses are all."""
        return {}


class NavigateToPoseNavigator(_Nav2Navigator):
    """Drives to one pose."""

    name, action, through = "navigate_to_pose", action.NavigateToPose, False

    def default_tree(self, server: Any) -> str:
        """Return `default_nav_to_pose_bt_xml`."""
        return str(server.default_nav_to_pose_bt_xml)

    def poses(self, goal: Any) -> Sequence[Any]:
        """Return its pose."""
        return [goal.pose]


class NavigateThroughPosesNavigator(_Nav2Navigator):
    """Drives through poses to the last."""

    name, action, through = "navigate_through_poses", action.NavigateThroughPoses, True

    def default_tree(self, server: Any) -> str:
        """Return `default_nav_through_poses_bt_xml`."""
        return str(server.default_nav_through_poses_bt_xml)

    def poses(self, goal: Any) -> Sequence[Any]:
        """Return its poses."""
        return list(goal.poses)


_HERE = "arjuna_nav.nodes.goals.navigators"
NAVIGATORS = PluginTypes(
    "navigator",
    {
        f"nav2_bt_navigator::{cls.__name__}": f"{_HERE}:{cls.__name__}"
        for cls in (NavigateToPoseNavigator, NavigateThroughPosesNavigator)
    },
    "",
    {
        cls.name: f"nav2_bt_navigator::{cls.__name__}"
        for cls in (NavigateToPoseNavigator, NavigateThroughPosesNavigator)
    },
)


def filled(kind: Any, **fields: Any) -> Any:
    """Return a message of a type with those of the fields that it has."""
    known = kind.get_fields_and_field_types()
    return kind(**{name: value for name, value in fields.items() if name in known})
