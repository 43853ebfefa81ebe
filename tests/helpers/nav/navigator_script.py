"""The navigator with Arjuna's default tree, ticked by a script: answers instead of servers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import IDENTITY, SE2
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.base import ControlStatus
from arjuna_nav.navigator import Finish, Navigator, NavigatorConfig
from arjuna_nav.planners.base import PlanStatus
from arjuna_nav.trees.exchange import Answer, Ask, TreeState
from arjuna_nav.trees.xml_file import read_tree
from tests.nav.worlds import polyline

GOAL = SE2(4.0, 0.0, 0.0)
STRAIGHT = polyline([(0.0, 0.0), (4.0, 0.0)], 0.0)
DETOUR = polyline([(0.0, 0.0), (2.0, 1.5), (4.0, 0.0)], 0.0)
SHORT = {
    "ComputePathToPose": "plan",
    "ComputePathThroughPoses": "plan",
    "IsPathValid": "check",
    "FollowPath": "follow",
    "local_costmap/clear_entirely_local_costmap": "clear_local",
    "global_costmap/clear_entirely_global_costmap": "clear_global",
}


def planned(path: NDArray[np.float64] = STRAIGHT) -> Answer:
    return Answer(True, values={"path": path})


def failed(status: PlanStatus | ControlStatus = PlanStatus.NO_VALID_PATH) -> Answer:
    return Answer(False, int(status), status.name)


class Script:
    """Ticks a navigator, and answers its requests by their short names.

    Attributes:
        asked: The fields of the newest request by its short name.
        entry: Returns an entry of the tree's blackboard.
    """

    def __init__(
        self,
        goals: tuple[SE2, ...] = (GOAL,),
        tree: str = "navigate_to_pose.xml",
        config: NavigatorConfig | None = None,
    ) -> None:
        codes = ("compute_path_error_code", "follow_path_error_code")
        made = read_tree(shipped_file("behavior_trees") / tree)
        self.entry = made.blackboard.get
        self.navigator = Navigator(made, config or NavigatorConfig(), codes, goals, start=0.0)
        self.now = 0.0
        self.asked: dict[str, Mapping[str, Any]] = {}
        self.end: Finish | None = None
        self._open: dict[str, int] = {}

    def tick(
        self,
        dt: float = 0.1,
        pose: SE2 | None = IDENTITY,
        goals: tuple[SE2, ...] | None = None,
        cancel: bool = False,
        **answers: Answer | bool,
    ) -> list[str]:
        """Tick once; return what is asked, and with a '-' before it what is withdrawn."""
        self.now += dt
        given = {
            self._open.pop(name): Answer(value) if isinstance(value, bool) else value
            for name, value in answers.items()
        }
        state = TreeState(self.now, pose, answers=given)
        commands, self.end = self.navigator.tick(state, goals, cancel)
        done = []
        for command in commands:
            if isinstance(command, Ask):
                name = SHORT.get(command.server) or SHORT.get(command.kind) or command.kind
                self._open[name], self.asked[name] = command.key, command.fields
                done.append(name)
            else:
                names = [name for name, key in self._open.items() if key == command.key]
                done += [f"-{name}" for name in names]
                self._open = {k: v for k, v in self._open.items() if v != command.key}
        return done

    @property
    def followed(self) -> NDArray[np.float64]:
        """The path that was given to the controller last."""
        path: NDArray[np.float64] = self.asked["follow"]["path"]
        return path

    @property
    def recoveries(self) -> int:
        return int(self.feedback()["number_of_recoveries"])

    def feedback(self, pose: SE2 = IDENTITY, speed: float = 0.0) -> dict[str, Any]:
        state = TreeState(self.now, pose, mean_velocity=lambda: Velocity(speed))
        return self.navigator.feedback(state)

    def follow(self, path: NDArray[np.float64] = STRAIGHT) -> Script:
        """Come to the point where a path is followed."""
        assert self.tick() == ["plan"]
        assert self.tick(plan=planned(path)) == ["follow"]
        assert self.followed is path
        return self

    def replan(self, path: NDArray[np.float64], free: bool = True, pose: SE2 = IDENTITY) -> bool:
        """Let a second pass and a new path come; return whether it is followed."""
        assert self.tick(1.0, pose) == ["check", "plan"]
        return self.tick(0.1, pose, plan=planned(path), check=free) == ["follow"]

    def fail_to_plan(self) -> list[str]:
        """Let planning and its second try fail; return what is asked then."""
        assert self.tick(plan=failed()) == ["clear_global"]
        assert self.tick(clear_global=True) == ["plan"]
        return self.tick(plan=failed())
