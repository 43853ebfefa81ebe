"""joint_trajectory_controller: its topic, its action and what it says of its joints."""

from __future__ import annotations

from typing import Any

import numpy as np
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
from control_msgs.srv import QueryTrajectoryState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from arjuna_core.arrays import Floats
from arjuna_core.errors import ArjunaError
from arjuna_core.ros import qos
from arjuna_core.ros.convert import duration_msg, header, seconds
from arjuna_core.ros.goal_server import GoalServer
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.devices.driving.trajectory import Trajectory
from arjuna_sim.driven_robot import DrivenRobot
from arjuna_sim.model.joints import ControllerSettings
from arjuna_sim.physics.robot_motion import JointStates

_RESULT = FollowJointTrajectory.Result


class PastError(ArjunaError):
    """A trajectory would have ended already."""


def trajectory_of(message: JointTrajectory) -> Trajectory:
    """Return a message's trajectory.

    Raises:
        ArjunaError: It cannot be followed.
    """
    names, points = message.joint_names, message.points
    if len(set(names)) < len(names):
        raise ArjunaError("names a joint twice")

    def rows(field: str) -> Floats:
        found = [getattr(point, field) for point in points]
        rows = [each if len(each) == len(names) else [np.nan] * len(names) for each in found]
        return np.array(rows, np.float64).reshape(len(points), len(names))

    times = np.array([seconds(point.time_from_start) for point in points], np.float64)
    return Trajectory(times, *map(rows, ("positions", "velocities", "accelerations")))


class TrajectoryTopics(GoalServer):
    """Takes trajectories by topic and by action, and reports what becomes of each goal."""

    def __init__(self, node: ManagedNode, robot: DrivenRobot, settings: ControllerSettings) -> None:
        self._robot, self._settings, self._owner = robot, settings, node
        self._path: Trajectory | None = None
        self._begin = 0.0
        name = settings.name if settings.is_managed else settings.topic
        topic = f"{name}/joint_trajectory" if settings.is_managed else name
        node.subscribe(JointTrajectory, topic, self._on_message, qos.LATEST)
        super().__init__(
            *(node, FollowJointTrajectory, f"{name}/follow_joint_trajectory", self._on_goal),
            admit=self._admit,
            on_cancel=self._on_cancel_goal,
            unknown=_RESULT.INVALID_GOAL,
        )
        node.keep(self)
        self._state_out = node.publisher(
            JointTrajectoryControllerState, f"{name}/controller_state", qos.DEFAULT
        )
        node.serve(QueryTrajectoryState, f"{name}/query_state", self._query)

    def explained(self, reason: str, code: int | None = None, **fields: Any) -> Any:
        """Return a result that says why a goal failed."""
        code = _RESULT.INVALID_GOAL if code is None else code
        return _RESULT(error_code=code, error_string=reason)

    def _on_message(self, message: JointTrajectory) -> None:
        try:
            self._follow(message)
        except ArjunaError as error:
            self._owner.get_logger().warning(f"{self._settings.name}: trajectory ignored: {error}")

    def _follow(self, message: JointTrajectory) -> None:
        """Follow a message's trajectory, from its stamp on or, where that is 0, from now on."""
        stamp = seconds(message.header.stamp)
        begin = self._robot.elapsed + (stamp - self._owner.now if stamp > 0.0 else 0.0)
        names, path = message.joint_names, trajectory_of(message)
        if begin + path.duration < self._robot.elapsed:
            raise PastError(f"it ended at {stamp + path.duration:.2f} s, which is over")
        controllers = self._robot.controllers
        self._path = controllers.follow(self._settings.name, names, path, begin)
        self._begin = begin

    def _admit(self, goal: Any) -> str | None:
        try:
            controllers = self._robot.controllers
            controllers.check_joints(self._settings.name, goal.trajectory.joint_names)
            trajectory_of(goal.trajectory)
        except ArjunaError as error:
            return str(error)
        return None

    def _on_goal(self) -> None:
        goal = self.take_newest()
        assert goal is not None
        try:
            self._follow(goal.trajectory)
        except ArjunaError as error:
            is_past = isinstance(error, PastError)
            code = _RESULT.OLD_HEADER_TIMESTAMP if is_past else _RESULT.INVALID_GOAL
            self.abort(self.explained(str(error), code))

    def _on_cancel_goal(self) -> None:
        if self.cancel_requested:
            self._robot.controllers.hold(self._settings.name)
            self.cancel(self.explained("it was cancelled: the joints stay where they are", 0))

    def publish(self, joints: JointStates, now: float) -> None:
        """Report the joints after a tick that ends at a time [s], and end a goal."""
        is_wanted = self._state_out.get_subscription_count() > 0
        if not is_wanted and self.goal is None:
            return
        at, rate = joints.of(self._settings.joints)
        followed = self._robot.controllers.path(self._settings.name)
        is_own = followed is not None and followed is self._path
        time = self._robot.elapsed - self._begin
        wanted = self._path.at(time) if self._path is not None and is_own else at
        points = [
            JointTrajectoryPoint(positions=each, velocities=speed, time_from_start=duration_msg(0))
            for each, speed in ((wanted, []), (at, rate), (wanted - at, []))
        ]
        names = list(self._settings.joints)
        if is_wanted:
            kinds = dict(zip(("reference", "feedback", "error"), points, strict=True))
            self._state_out.publish(
                JointTrajectoryControllerState(
                    header=header("", now), joint_names=names, speed_scaling_factor=1.0, **kinds
                )
            )
        if self.goal is None:
            return
        if not is_own:
            self.abort(self.explained("its controller was stopped, or got another trajectory"))
            return
        kinds = dict(zip(("desired", "actual", "error"), points, strict=True))
        feedback = FollowJointTrajectory.Feedback
        self.feedback(feedback(header=header("", now), joint_names=names, **kinds))
        self._judge(np.abs(wanted - at), np.abs(rate), time)

    def _judge(self, error: Any, speed: Any, time: float) -> None:
        """End the goal where a tolerance is violated, or where it is reached."""
        goal, settings = self.goal, self._settings
        assert goal is not None
        assert self._path is not None
        late = time - self._path.duration
        if late < -1e-9:
            allowed = self._allowed(settings.path_tolerance, goal.path_tolerance)
            if problem := self._beyond(error, allowed):
                self._robot.controllers.hold(settings.name)
                code = _RESULT.PATH_TOLERANCE_VIOLATED
                self.abort(self.explained(f"left its path: {problem}", code))
            return
        allowed = self._allowed(settings.goal_tolerance, goal.goal_tolerance)
        problem = self._beyond(error, allowed)
        stopped = settings.stopped_velocity
        if not problem and (not stopped or (speed <= stopped).all()):
            self.succeed(_RESULT(error_code=_RESULT.SUCCESSFUL, error_string="goal reached"))
            return
        patience = seconds(goal.goal_time_tolerance) or settings.goal_time
        if patience and late > patience:
            code = _RESULT.GOAL_TOLERANCE_VIOLATED
            self.abort(self.explained(f"is not at its goal: {problem or 'it still moves'}", code))

    def _allowed(self, own: tuple[float, ...], given: Any) -> Floats:
        """Return the greatest errors: a goal's own, where it has one; infinite for any."""
        allowed = dict(zip(self._settings.joints, own, strict=False))
        for tolerance in given:
            if tolerance.position:
                allowed[tolerance.name] = max(tolerance.position, 0.0)
        return np.array([allowed.get(name) or np.inf for name in self._settings.joints])

    def _beyond(self, error: Any, allowed: Floats) -> str:
        """Return the joint that is farthest beyond what is allowed, "" for none."""
        if (error <= allowed).all():
            return ""
        worst = int(np.argmax(error - allowed))
        name = self._settings.joints[worst]
        return f"joint '{name}' is off by {error[worst]:.4f}; allowed are {allowed[worst]:g}"

    def _query(self, request: Any, response: Any) -> Any:
        """Answer where the joints are to be at a time."""
        if self._path is None:
            response.message = "no trajectory is followed"
            return response
        time = seconds(request.time) - self._owner.now + self._robot.elapsed - self._begin
        response.success, response.name = True, list(self._settings.joints)
        response.position = self._path.at(time)
        return response
