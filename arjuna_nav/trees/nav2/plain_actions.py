"""Nav2's actions that ask nobody: goals, paths and choices on the blackboard.

Source: nav2_behavior_tree, plugins/action.
"""

from __future__ import annotations

from typing import ClassVar

from arjuna_nav.trees.exchange import Heard, Topic
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import ANY, NUMBER, POSES, REQUIRED, TEXT, Port, TreeError, entry


class SetBlackboard(TreeNode):
    """Writes an entry."""

    PORTS: ClassVar[dict[str, Port]] = {
        "value": Port(ANY),
        "output_key": Port(TEXT, REQUIRED),
    }

    def tick(self) -> Status:
        """Write it; the key may stand in braces or not."""
        text = self._texts.get("output_key")
        if text is None:
            raise TreeError(f"{self.name}: port 'output_key' is not given")
        self._board.set(entry(text) or text, self.get("value"))
        return Status.SUCCESS


class UnsetBlackboard(TreeNode):
    """Removes an entry."""

    PORTS: ClassVar[dict[str, Port]] = {"key": Port(TEXT)}

    def tick(self) -> Status:
        """Remove it."""
        text = self._texts.get("key", "")
        self._board.set(entry(text) or text, None)
        return Status.SUCCESS


class RemovePassedGoals(TreeNode):
    """Removes goals from the first on while the robot is near them; the last one stays."""

    PORTS: ClassVar[dict[str, Port]] = {
        "input_goals": Port(POSES),
        "output_goals": Port(POSES, None, output=True),
        "radius": Port(NUMBER, 0.5),
        "global_frame": Port(TEXT, ""),
        "robot_base_frame": Port(TEXT, ""),
    }

    def tick(self) -> Status:
        """Remove what was passed."""
        goals, pose = self.get("input_goals"), self.running.state.pose
        if pose is None:
            return Status.FAILURE
        while len(goals) > 1 and pose.distance(goals[0]) <= self.get("radius"):
            goals = goals[1:]
        self.put("output_goals", goals)
        return Status.SUCCESS


class _Selector(TreeNode):
    """Writes what was chosen on a topic, or a default."""

    WHAT: ClassVar[str]

    def tick(self) -> Status:
        """Write it."""
        chosen = self.running.state.selected.get(self.topic("topic_name"), "")
        chosen = chosen or self.get(f"default_{self.WHAT}")
        if not chosen:
            return Status.FAILURE
        self.put(f"selected_{self.WHAT}", chosen)
        return Status.SUCCESS

    def topics(self) -> set[Topic]:
        """Return the topic on which it is chosen."""
        return {Topic(Heard.CHOICE, self.topic("topic_name"))}


def _ports(what: str) -> dict[str, Port]:
    return {
        "topic_name": Port(TEXT, f"{what}_selector"),
        f"default_{what}": Port(TEXT, ""),
        f"selected_{what}": Port(TEXT, "", output=True),
    }


class PlannerSelector(_Selector):
    """Which planner plans."""

    WHAT, PORTS = "planner", _ports("planner")


class ControllerSelector(_Selector):
    """Which controller follows."""

    WHAT, PORTS = "controller", _ports("controller")


class SmootherSelector(_Selector):
    """Which smoother smooths."""

    WHAT, PORTS = "smoother", _ports("smoother")


class GoalCheckerSelector(_Selector):
    """Which goal checker judges arrival."""

    WHAT, PORTS = "goal_checker", _ports("goal_checker")


class ProgressCheckerSelector(_Selector):
    """Which progress checker judges progress."""

    WHAT, PORTS = "progress_checker", _ports("progress_checker")
