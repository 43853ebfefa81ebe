"""Node docking_server: dock_robot and undock_robot."""

from __future__ import annotations

from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import DockRobot, NavigateToPose, UndockRobot
from nav2_msgs.srv import ReloadDockDatabase

from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, pose_stamped
from arjuna_core.ros.goal_client import GoalClient, GoalOutcome
from arjuna_core.ros.goal_server import GoalError, GoalNode, GoalServer
from arjuna_core.ros.tf import TransformError
from arjuna_core.ros.velocity import VelocityOutput
from arjuna_core.se2 import SE2
from arjuna_nav.costmap.costmap import Costmap
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.docking.docking import (
    Docking,
    DockingError,
    DockingPhase,
    DockingState,
    DockingStep,
    Undocking,
)
from arjuna_nav.nodes.costmap.reader import CostmapReader
from arjuna_nav.nodes.docking.book import DockBook, DockingServerConfig, Order
from arjuna_nav.nodes.docking.senses import DockSensors
from arjuna_nav.nodes.frames import robot_pose

_ACTIONS = {"dock_robot": DockRobot, "undock_robot": UndockRobot}
_BEFORE_APPROACH = (DockingPhase.NAV_TO_STAGING_POSE, DockingPhase.INITIAL_PERCEPTION)


class DockingServerNode(GoalNode):
    """Carries out one order at a time; a newer one ends the older."""

    Config = DockingServerConfig
    DEFAULT_NAME = "docking_server"

    def configure(self) -> None:
        config: DockingServerConfig = self.config
        self._book = DockBook(config, self.get_logger().warning)
        self._order: Order | None = None
        self._last: tuple[str, SE2] | None = None
        self._docked_at: SE2 | None = None
        controller = config.controller
        self._costmap = CostmapReader(
            self,
            controller.costmap_topic,
            controller.footprint_topic,
            config.base_frame,
            controller.transform_tolerance,
        )
        self._sensors = DockSensors(self, config.fixed_frame)
        self._output = VelocityOutput(
            self, config.enable_stamped_cmd_vel, config.base_frame, config.cmd_vel_topic
        )
        self._dock_out = self.publisher(PoseStamped, "dock_pose", qos.LATEST)
        self._staging_out = self.publisher(PoseStamped, "staging_pose", qos.LATEST)
        self._navigator = self.keep(GoalClient(self, NavigateToPose, "navigate_to_pose"))
        self._servers = {
            name: self.offer(
                action,
                name,
                partial(self._on_goal, name),
                on_cancel=self._check_cancelled,
                unknown=DockingError.UNKNOWN,
            )
            for name, action in _ACTIONS.items()
        }
        self.serve(ReloadDockDatabase, f"{self.get_name()}/reload_database", self._on_reload)
        self.every(1.0 / config.controller_frequency, self._tick)

    def on_config(self, config: DockingServerConfig) -> None:
        self._book.judge_by(config)

    def halt(self) -> None:
        if self._order is not None:
            self._stop(self._order)
        self._order = None

    def _stop(self, order: Order) -> None:
        phase = getattr(order.core, "phase", None)
        if phase is DockingPhase.NAV_TO_STAGING_POSE:
            self._navigator.cancel()
        else:
            self._output.stop()

    def _on_reload(self, request: Any, response: Any) -> Any:
        try:
            self._book.reload(self.config.dock_folder, request.filepath)
        except ArjunaError as error:
            self.get_logger().error(f"the docks are as they were: {error}")
            response.success = False
        else:
            response.success = True
        return response

    def _on_goal(self, name: str) -> None:
        """Begin an order; whichever ran before is ended."""
        server = self._servers[name]
        before, self._order = self._order, None
        if before is not None:
            self._stop(before)
            if before.server is not server:
                reason = f"replaced by {name} at {self.now:.2f} s"
                before.server.abort(before.server.explained(reason))
        goal = server.take_newest()
        self._order = (self._dock if name == "dock_robot" else self._undock)(server, goal)

    def _dock(self, server: GoalServer, goal: Any) -> Order:
        dock = self._book.dock(goal, self.config.fixed_frame)
        name, kind = self._book.kind(dock.type)
        self._sensors.forget()
        footprint = self._footprint()
        navigate, limit = goal.navigate_to_staging_pose, goal.max_staging_time
        core = Docking(self.config, kind, footprint, navigate, limit)
        return Order(server, DockRobot, kind, name, core, self.now, dock)

    def _undock(self, server: GoalServer, goal: Any) -> Order:
        last = self._last[0] if self._last is not None else ""
        name, kind = self._book.kind(goal.dock_type or last)
        limit, docked = goal.max_undocking_time, self._is_still_docked()
        core = Undocking(self.config, kind, self._footprint(), limit, docked)
        return Order(server, UndockRobot, kind, name, core, self.now)

    def _footprint(self) -> Footprint | None:
        """Return the robot's outline where obstacles count.

        Raises:
            GoalError: It is not known.
        """
        if not self.config.controller.use_collision_detection:
            return None
        try:
            return self._costmap.footprint()
        except TransformError as error:
            raise GoalError(DockingError.FAILED_TO_CONTROL, str(error)) from error

    def _is_still_docked(self) -> bool:
        """Return whether the robot has not moved since it docked."""
        pose = self.transforms.try_lookup(self.config.fixed_frame, self.config.base_frame)
        docked = self._docked_at
        # A robot that moved 0.1 m since it docked has left the dock.
        return pose is not None and docked is not None and pose.distance(docked) < 0.1

    def _check_cancelled(self) -> None:
        order = self._order
        if order is not None and order.server.cancel_requested:
            self._stop(order)
            self._order = None
            order.server.cancel(order.action.Result(success=False))

    def _tick(self) -> None:
        self._check_cancelled()
        order = self._order
        if order is None:
            return
        try:
            step = self._step(order)
        except TransformError as error:
            order.lost_since = self.now if order.lost_since is None else order.lost_since
            # The robot waits two seconds, standing still, for its pose to be known again.
            late = self.now - order.lost_since > 2.0
            message = f"the robot's pose is not known: {error}"
            step = DockingStep(ended=DockingError.UNKNOWN if late else None, message=message)
        else:
            order.lost_since = None
        self._carry_out(order, step)

    def _step(self, order: Order) -> DockingStep:
        """Ask the order what to do, in the fixed frame."""
        config: DockingServerConfig = self.config
        pose = robot_pose(self, config.fixed_frame, config.base_frame, config.transform_tolerance)
        costmap = None
        if config.controller.use_collision_detection:
            costmap = self._costmap.current(config.costmap_update_timeout, config.fixed_frame)
            if costmap is None:
                message = self._costmap.why_not_current()
                return DockingStep(ended=DockingError.FAILED_TO_CONTROL, message=message)
        if order.dock is None:
            last = None if self._last is None else self._last[1]
            return self._asked(order, pose, last, costmap)
        if order.nominal is None or order.core.phase in _BEFORE_APPROACH:  # type: ignore[union-attr]
            T_fixed_dock = self.transforms.lookup(config.fixed_frame, order.dock.frame)
            order.nominal = T_fixed_dock @ order.dock.docked
        seen = order.kind.config.use_external_detection_pose
        dock = self._sensors.detected(order.kind.config) if seen else order.nominal
        if dock is not None:
            self._dock_out.publish(pose_stamped(dock, config.fixed_frame, self.now))
            self._last = order.type, dock
        return self._asked(order, pose, dock, costmap)

    def _asked(
        self, order: Order, pose: SE2, dock: SE2 | None, costmap: Costmap | None
    ) -> DockingStep:
        kind = order.kind.config
        distance = None if dock is None else pose.distance(dock)
        senses = self._sensors.senses(distance, kind.stall_joint_names)
        state = DockingState(self.now, pose, dock, senses, costmap, order.staged)
        if isinstance(order.core, Undocking):
            return order.core.tick(state)
        assert order.nominal is not None
        return order.core.tick(state, order.nominal)

    def _carry_out(self, order: Order, step: DockingStep) -> None:
        if step.ended is not None:
            self._end(order, step.ended, step.message)
            return
        if step.stage:
            self._drive_to_staging_pose(order)
        if step.velocity is not None:
            self._output.publish(step.velocity)
        if isinstance(order.core, Docking):
            order.server.feedback(
                DockRobot.Feedback(
                    state=int(order.core.phase),
                    docking_time=duration_msg(self.now - order.since),
                    num_retries=order.core.retries,
                )
            )

    def _drive_to_staging_pose(self, order: Order) -> None:
        assert order.dock is not None
        staging = order.kind.staging_pose(order.dock.docked)
        goal = pose_stamped(staging, order.dock.frame, self.now)
        self._staging_out.publish(goal)

        def arrived(outcome: GoalOutcome) -> None:
            order.staged = outcome.succeeded

        if self._navigator.ready:
            tree = self.config.navigator_bt_xml
            self._navigator.send(NavigateToPose.Goal(pose=goal, behavior_tree=tree), arrived)
        else:
            order.staged = False

    def _end(self, order: Order, error: DockingError, message: str) -> None:
        self._stop(order)
        self._order = None
        docking = isinstance(order.core, Docking)
        fields = {"num_retries": order.core.retries} if isinstance(order.core, Docking) else {}
        if error is DockingError.NONE:
            pose = self.transforms.try_lookup(self.config.fixed_frame, self.config.base_frame)
            self._docked_at = pose if docking else None
            order.server.succeed(order.action.Result(success=True, **fields))
        else:
            order.server.fail(GoalError(error, message), **fields)
