"""The checks of a goal before it is driven to, and the trees and navigators that serve it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Protocol

from nav2_msgs import action
from nav2_msgs.action import ComputePathThroughPoses

from arjuna_core.config import NoParameters
from arjuna_core.plugins import PluginTypes
from arjuna_core.ros.goal_server import GoalError
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import SE2
from arjuna_nav.nodes.frames import pose_in, robot_pose
from arjuna_nav.nodes.trees.clients import TreeClients
from arjuna_nav.nodes.trees.loading import TreeChoice
from arjuna_nav.planners import PlanStatus
from arjuna_nav.trees.exchange import Answer


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
        return str(server.default_nav_to_pose_bt_xml)

    def poses(self, goal: Any) -> Sequence[Any]:
        return [goal.pose]


class NavigateThroughPosesNavigator(_Nav2Navigator):
    """Drives through poses to the last."""

    name, action, through = "navigate_through_poses", action.NavigateThroughPoses, True

    def default_tree(self, server: Any) -> str:
        return str(server.default_nav_through_poses_bt_xml)

    def poses(self, goal: Any) -> Sequence[Any]:
        return list(goal.poses)


_HERE = "arjuna_nav.nodes.goals.admission"
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


_MAY_CHANGE = {PlanStatus[name] for name in ("UNKNOWN", "NO_VALID_PATH", "TF_ERROR", "TIMEOUT")}
"""Errors of a plan that recoveries or time may mend."""


class Admission:
    """Lets a goal wait until it may be driven to.

    The robot's pose is waited for, up to `start_patience` (localization may just have been
    started again), and then the goal's frame, up to `transform_tolerance`. A goal that is to
    replace another is planned for first: where there is no path to it and no recovery could mend
    that, it alone is refused and the robot drives on, where Nav2 ends both.

    Args:
        node: bt_navigator; made in its `configure`.
        on_change: Called where it is time to ask again.
    """

    def __init__(
        self,
        node: ManagedNode,
        clients: TreeClients,
        trees: TreeChoice,
        on_change: Callable[[], None],
    ) -> None:
        self._node = node
        self._clients = clients
        self._trees = trees
        self._on_change = on_change
        self._came = self._lost_at = self._patience = 0.0
        self._trial: object = None
        self._plan: Answer | None = None
        self.problem = ""
        """Why the robot's pose is not known, empty if the goal does not wait for it."""

    def begin(self, patience: float) -> None:
        """Begin with a new goal, for which the robot's pose is waited for up to a patience [s]."""
        self._came = self._lost_at = self._node.now
        self._patience = patience
        self.problem = ""
        self._trial = self._plan = None

    def goals(self, navigator: GoalNavigator, goal: Any, preempts: bool) -> tuple[SE2, ...] | None:
        """Return the poses of the newest goal in the global frame, None while it must wait.

        Args:
            preempts: Whether it is to replace the one that runs.

        Raises:
            GoalError: It cannot be driven to.
        """
        poses = navigator.poses(goal)
        if not poses:
            code = ComputePathThroughPoses.Result.NO_VIAPOINTS_GIVEN
            raise GoalError(code, "0 poses were given, at least 1 is needed")
        goals = self._placed(navigator, poses)
        if goals is None:
            return None
        asked = getattr(goal, "behavior_tree", "")
        problem = self._trees.choose(navigator.name, asked, preempts)
        if problem:
            raise GoalError(0, problem)
        return goals if not preempts or self._is_reachable(navigator, goals) else None

    def _placed(self, navigator: GoalNavigator, poses: Sequence[Any]) -> tuple[SE2, ...] | None:
        """Return poses in the global frame, None while that or the robot's pose may still come."""
        config = self._node.config
        frame, tolerance = config.global_frame, config.transform_tolerance
        try:
            robot_pose(self._node, frame, config.robot_base_frame, tolerance)
        except TransformError as error:
            self._wait(navigator, error, self._came, self._patience)
            self._lost_at, self.problem = self._node.now, str(error)
            return None
        self.problem = ""
        try:
            return tuple(pose_in(self._node, frame, pose) for pose in poses)
        except TransformError as error:
            self._wait(navigator, error, self._lost_at, tolerance)
            return None

    def _wait(
        self, navigator: GoalNavigator, error: TransformError, since: float, patience: float
    ) -> None:
        """Return while there is patience [s] with a transform, refuse the goal after that."""
        waited = self._node.now - since
        if waited >= patience:
            problem = f"{error} (waited for {waited:.2f} s)"
            raise GoalError(error_code(navigator, PlanStatus.TF_ERROR), problem) from error

    def _is_reachable(self, navigator: GoalNavigator, goals: tuple[SE2, ...]) -> bool:
        """Return whether the goals may be driven to; false while the plan has not come."""
        if self._trial is None:
            self._trial = trial = object()

            def take(plan: Answer) -> None:
                if self._trial is trial:
                    self._plan = plan
                    self._on_change()

            self._clients.trial_plan(goals, take)
        if self._plan is None:
            return False
        status = PlanStatus.of_code(self._plan.code)
        if self._plan.succeeded or status is None or status in _MAY_CHANGE:
            return True
        raise GoalError(error_code(navigator, status), self._plan.message)


def error_code(navigator: GoalNavigator, code: int) -> int:
    """Return an error code; planning's count from 300 where it is through poses."""
    return PlanStatus(code).code(navigator.through) if code in list(PlanStatus) else code
