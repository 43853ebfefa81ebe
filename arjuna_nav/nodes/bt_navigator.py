"""Node bt_navigator: navigate_to_pose, navigate_through_poses, and actions of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.msg import BehaviorTreeLog

from arjuna_core.config import duration_param, fixed, param, plugin_names
from arjuna_core.ros import qos
from arjuna_core.ros.goal_client import GoalClient
from arjuna_core.ros.goal_server import GoalError, GoalServer, result_timeout
from arjuna_core.se2 import SE2
from arjuna_core.timing import Periodic
from arjuna_nav.navigator import Ending, EntryNames, Finish, Navigator, NavigatorConfig
from arjuna_nav.nodes.goals.admission import NAVIGATORS, Admission, GoalNavigator, error_code
from arjuna_nav.nodes.goals.memory import GoalMemory, ResumingNode
from arjuna_nav.nodes.safety.posture import PostureWatch
from arjuna_nav.nodes.trees.clients import TreeClients
from arjuna_nav.nodes.trees.loading import TreeChoice, log_msg
from arjuna_nav.nodes.trees.messages import filled
from arjuna_nav.safety.posture import PostureConfig
from arjuna_nav.trees.exchange import TreeState
from arjuna_nav.trees.xml_file import with_own_nodes

_INVALID = ComputePathToPose.Result.TF_ERROR
"""The planner's code of a goal that cannot be used; navigation's actions name none."""


@dataclass(frozen=True)
class BtNavigatorConfig(NavigatorConfig, PostureConfig):
    """Parameters of bt_navigator."""

    global_frame: str = fixed("map", "Frame to navigate in.")
    robot_base_frame: str = fixed("base_link", "Frame of the robot.")
    odom_topic: str = fixed("odom", "Topic of the odometry.")
    transform_tolerance: float = duration_param(0.1, "Age of the transform that is tolerated.")
    action_server_result_timeout: float = result_timeout(900.0)
    start_patience: float = duration_param(
        10.0, "How long a new goal waits for the robot's pose.", theirs=0.0
    )
    bt_loop_duration: int = param(10, "Time between two ticks.", unit="ms", minimum=1)
    feedback_rate: float = fixed(10.0, "Most feedbacks a second.", unit="Hz", minimum=0.1)
    wait_for_service_timeout: int = param(
        1000, "How long to wait for a server to be there.", unit="ms", minimum=0
    )
    default_server_timeout: int = param(
        1000,
        "How long an action may take to accept a goal, and a service to answer, where a tree's "
        "server_timeout says nothing; looked at every 0.2 s.",
        unit="ms",
        minimum=0,
        theirs=20,
    )
    default_cancel_timeout: int = param(
        1000, "After which a cancel without an answer is logged.", unit="ms", minimum=0, theirs=20
    )
    filter_duration: float = duration_param(
        0.3,
        "Time over which SpeedController and the time left take the mean velocity.",
        read_only=True,
    )
    navigators: tuple[str, ...] = plugin_names(
        tuple(NAVIGATORS.by_name), "The navigators, an action each.", NAVIGATORS
    )
    default_nav_to_pose_bt_xml: str = param(
        "navigate_to_pose.xml",
        "Behavior tree of goals that name none; empty: that one.",
        theirs="navigate_to_pose_w_replanning_and_recovery.xml",
        path=True,
    )
    default_nav_through_poses_bt_xml: str = param(
        "navigate_through_poses.xml",
        "The same for goals through poses.",
        theirs="navigate_through_poses_w_replanning_and_recovery.xml",
        path=True,
    )
    plugin_lib_names: tuple[str, ...] = fixed(
        (), "Python modules with nodes of trees of one's own; Nav2's libraries are built in."
    )
    bt_folder: str = param(".", "Folder of the behavior trees that goals may name.", path=True)
    bt_search_directories: tuple[str, ...] = param(
        (), "Further folders of trees that goals or parameters may name.", path=True
    )
    always_reload_bt_xml: bool = fixed(
        True,
        "Whether a tree is read again for each goal; else where another drove before.",
        theirs=False,
    )
    error_code_names: tuple[str, ...] = param(
        ("compute_path_error_code", "follow_path_error_code"),
        "Entries of a tree's blackboard that hold error codes; the lowest is a failed goal's.",
    )
    error_code_name_prefixes: tuple[str, ...] = param(
        (), "Further such entries, without their ending '_error_code', as Nav2 after Jazzy."
    )
    goal_blackboard_id: str = fixed("goal", "Entry of the goal.")
    goals_blackboard_id: str = fixed("goals", "Entry of the goals up to it.")
    path_blackboard_id: str = fixed("path", "Entry of the path to it.")
    resume_file: str = param(
        "", "Keeps the goal under way, to resume it after a crash; empty: no.", path=True
    )


class BtNavigatorNode(ResumingNode):
    """Ticks the navigator, and carries out its requests."""

    Config = BtNavigatorConfig
    DEFAULT_NAME = "bt_navigator"

    def configure(self) -> None:
        config = self.config
        self._navigator: Navigator | None = None
        self._started_at = 0.0
        self._new_goals: tuple[SE2, ...] | None = None
        self._feedback_due = Periodic(1.0 / config.feedback_rate)
        self._requests = TreeClients(self, config)
        self._log_out = self.publisher(BehaviorTreeLog, "behavior_tree_log", qos.DEFAULT)
        made = [NAVIGATORS.make(getattr(config, name)) for name in config.navigators]
        self._kinds: dict[str, GoalNavigator] = {kind.name: kind for kind in made}
        self._kind = made[0]
        nodes, problems = with_own_nodes(config.plugin_lib_names)
        for problem in problems:
            self.get_logger().warning(f"plugin_lib_names: {problem}")
        defaults = {name: kind.default_tree(config) for name, kind in self._kinds.items()}
        folders = config.bt_folder, *config.bt_search_directories
        self._trees = TreeChoice(defaults, folders, nodes, config.always_reload_bt_xml)
        self._requests.listen(self._trees.topics, {})
        self._servers: dict[str, GoalServer] = {
            name: self.offer(
                kind.action,
                name,
                self._on_goal,
                admit=partial(self._admit, name),
                on_cancel=self._work,
                invalid=_INVALID,
            )
            for name, kind in self._kinds.items()
        }
        self._admission = Admission(self, self._requests, self._trees, self._consider)
        self.memory = GoalMemory(
            self, config.resume_file, {name: kind.action for name, kind in self._kinds.items()}
        )
        self._posture = PostureWatch(self)
        self._own = self.keep(GoalClient(self, NavigateToPose, "navigate_to_pose"))
        for topic in ("goal_pose", "/move_base_simple/goal"):
            self.subscribe(PoseStamped, topic, self._on_goal_pose, qos.DEFAULT)
        self.every(config.bt_loop_duration / 1000.0, self._work)

    def resume_goal(self) -> None:
        self.halt()
        self._admission.begin(self.config.outage_patience)

    def halt(self) -> None:
        self._requests.stop()
        self._navigator = None

    def trouble(self) -> str:
        if overturned := self._posture.problem():
            return overturned
        problem = ""
        if self._navigator is not None:
            problem = self._navigator.trouble()
        elif self._busy_with() is not None:
            problem = self._admission.problem
        return f"the robot stands and waits: {problem}" if problem else ""

    def _on_goal_pose(self, message: Any) -> None:
        self._own.send(NavigateToPose.Goal(pose=message), lambda outcome: None)

    def _admit(self, kind: str, goal: Any) -> str | None:
        other = self._busy_with()
        return None if other in (None, kind) else f"{other} is running"

    def _busy_with(self) -> str | None:
        return next((k for k, server in self._servers.items() if server.newest is not None), None)

    def _on_goal(self) -> None:
        self._admission.begin(self.config.start_patience)
        self._consider()

    def _consider(self) -> None:
        """Begin with the goal that waits, refuse it alone, or let it wait."""
        name = self._busy_with()
        if name is None:
            return
        kind, server = self._kinds[name], self._servers[name]
        if self._navigator is not None and not server.preempt_requested:
            return
        if self._navigator is None and server.preempt_requested:
            server.accept_pending()
        preempts = server.preempt_requested
        if not preempts and server.cancel_requested:
            server.cancel(kind.action.Result())
            return
        try:
            goals = self._admission.goals(kind, server.newest, preempts)
        except GoalError as refused:
            server.fail(refused)
            return
        if goals is None:
            return
        self.get_logger().info(f"{name}: {_described(goals)} received")
        self._started_at, self._kind = self.now, kind
        self.memory.keep(name, server.newest)
        for entry, value in kind.entries(server.newest).items():
            self._trees.tree.blackboard.set(entry, value)
        if preempts:
            server.accept_pending()
            self._new_goals = goals
        else:
            self._navigator = self._made_navigator(goals)
        self._tick()

    def _made_navigator(self, goals: tuple[SE2, ...]) -> Navigator:
        tree, config = self._trees.tree, self.config
        self._requests.listen(tree.topics, tree.calls)
        names = config.goal_blackboard_id, config.goals_blackboard_id, config.path_blackboard_id
        further = map("{}_error_code".format, config.error_code_name_prefixes)
        codes = *config.error_code_names, *further
        return Navigator(tree, config, codes, goals, self.now, EntryNames(*names))

    def _work(self) -> None:
        self.memory.resume()
        if overturned := self._posture.problem():
            self._give_up(overturned)
        self._consider()
        self._tick()

    def _give_up(self, reason: str) -> None:
        """End the goal that runs, or that waits, for a reason."""
        name = self._busy_with()
        if self._navigator is not None:
            self._finish(Finish(Ending.ABORTED, 0, reason))
        elif name is not None:
            self._servers[name].fail(GoalError(0, reason))

    def _tick(self) -> None:
        navigator = self._navigator
        if navigator is None:
            return
        state = self._requests.state()
        goals, self._new_goals = self._new_goals, None
        requests, end = navigator.tick(
            state, goals, self._servers[self._kind.name].cancel_requested
        )
        for request in requests:
            self._requests.carry_out(request)
        if end is not None:
            self._finish(end)
        changes = navigator.take_changes()
        if changes and self._log_out.get_subscription_count():
            self._log_out.publish(log_msg(changes, self.now))
        self._give_feedback(state)

    def _give_feedback(self, state: TreeState) -> None:
        if self._navigator is None or not self._feedback_due.due(self.now):
            return
        progress, frame = self._navigator.feedback(state), self.config.global_frame
        message = filled(self._kind.action.Feedback, progress, frame, self.now)
        self._servers[self._kind.name].feedback(message)

    def _finish(self, finish: Finish) -> None:
        self._navigator = None
        self.memory.forget()
        self._requests.stop()
        name, took = self._kind.name, f"after {self.now - self._started_at:.1f} s"
        code, server = error_code(self._kind, finish.error_code), self._servers[name]
        values = {"error_code": code, "error_msg": finish.error_msg}
        result = filled(self._kind.action.Result, values)
        if finish.ending is Ending.CANCELED:
            self.get_logger().info(f"{name}: goal canceled {took}")
            server.cancel(result)
        elif finish.ending is Ending.SUCCEEDED:
            self.get_logger().info(f"{name}: goal succeeded {took}")
            server.succeed(result)
        else:
            self.get_logger().error(f"{name}: goal aborted {took}: {finish.error_msg}")
            server.abort(result)


def _described(goals: Sequence[SE2]) -> str:
    """Return a goal as words: its poses' number, if several, and the last one."""
    x, y, yaw = goals[-1].x, goals[-1].y, goals[-1].theta
    several = f"{len(goals)} poses up to " if len(goals) > 1 else ""
    return f"goal {several}({x:.2f}, {y:.2f}, {yaw:.2f})"
