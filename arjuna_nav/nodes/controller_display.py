"""The display of controllers as messages: made only of what somebody listens to."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from dwb_msgs.msg import CriticScore, LocalPlanEvaluation, Trajectory2D, TrajectoryScore
from geometry_msgs.msg import Point, PointStamped, Pose2D, PoseStamped, Vector3
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool, ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from arjuna_core.ros import qos
from arjuna_core.ros.convert import cloud_msg, duration_msg, header, path_msg, pose_stamped
from arjuna_core.ros.messages import maker
from arjuna_core.ros.node import ManagedNode
from arjuna_nav.controllers import display
from arjuna_nav.controllers.display import Evaluation, Judged

_critic, _pose = maker(CriticScore, "name", "raw_score", "scale"), maker(Pose2D, "x", "y", "theta")
_trajectory = maker(
    *(Trajectory2D, "velocity.x", "velocity.y", "velocity.theta", "time_offsets", "poses")
)
_score = maker(TrajectoryScore, "traj", "scores", "total")
_colour, _point = maker(ColorRGBA, "r", "g", "b", "a"), maker(Point, "x", "y")


def evaluation_msg(evaluation: Evaluation, frame: str, now: float) -> LocalPlanEvaluation:
    """Return an evaluation of a frame at a time [s]."""
    return LocalPlanEvaluation(
        header=header(frame, now),
        twists=[_judged(one) for one in evaluation.trajectories],
        best_index=evaluation.best,
        worst_index=evaluation.worst,
    )


def _judged(one: Judged) -> TrajectoryScore:
    times = [duration_msg(time) for time in one.times.tolist()]
    poses = [_pose(*row) for row in one.poses.tolist()]
    scores = [_critic(each.name, each.raw_score, each.scale) for each in one.scores]
    return _score(_trajectory(*one.velocity, times, poses), scores, one.total)


class ControllerDisplay:
    """Publishes what a node's controllers show; `local_plan` there is with any of them."""

    def __init__(self, node: ManagedNode, configs: Iterable[Any]) -> None:
        kinds: dict[str, type[Any]] = {"local_plan": display.Plan}
        for config in configs:
            kinds |= display.topics_of(config.plugin, config)
        self._outputs: dict[str, tuple[Any, Callable[[Any, str, float], Any]]] = {}
        for topic, kind in kinds.items():
            message, made = _MESSAGES[kind]
            self._outputs[topic] = node.publisher(message, topic, qos.LATEST), made

    def wanted(self) -> frozenset[str]:
        """Return the topics that somebody listens to."""
        return frozenset(
            topic
            for topic, (publisher, _) in self._outputs.items()
            if publisher.get_subscription_count()
        )

    def publish(self, shown: Mapping[str, Any], frame: str, now: float) -> None:
        """Publish values of a frame at a time [s], by topic."""
        for topic, value in shown.items():
            publisher, made = self._outputs[topic]
            publisher.publish(made(value, frame, now))


def _path(plan: display.Plan, frame: str, now: float) -> Path:
    return path_msg(plan.poses, frame, now)


def _target(target: display.Target, frame: str, now: float) -> PoseStamped:
    return pose_stamped(target.pose, frame, now)


def _spot(spot: display.Spot, frame: str, now: float) -> PointStamped:
    above = 0.01  # [m], as Nav2, to stand out from the map
    return PointStamped(header=header(frame, now), point=Point(x=spot.x, y=spot.y, z=above))


def _flag(flag: display.Flag, frame: str, now: float) -> Bool:
    return Bool(data=flag.on)


def _cloud(cloud: display.Cloud, frame: str, now: float) -> PointCloud2:
    flat = np.column_stack((cloud.points, np.zeros(len(cloud.points))))
    return cloud_msg(flat, frame, now, cloud.channels)


def _markers(shapes: display.Shapes, frame: str, now: float) -> MarkerArray:
    stamped = header(frame, now)
    numbers: dict[str, int] = {}
    markers = []
    for shape in shapes.shapes:
        numbers[shape.name] = number = numbers.get(shape.name, -1) + 1
        marker = Marker(header=stamped, ns=shape.name, id=number)
        marker.type = Marker.LINE_STRIP if shape.line else Marker.SPHERE_LIST
        marker.pose.orientation.w = 1.0
        marker.scale = Vector3(x=shape.size, y=shape.size, z=shape.size)
        marker.lifetime = duration_msg(shape.lifetime)
        marker.points = [_point(x, y) for x, y in shape.points.tolist()]
        rows = [_colour(*row, 1.0) for row in np.atleast_2d(shape.colours).tolist()]
        marker.color, marker.colors = rows[0], rows if shape.colours.ndim > 1 else []
        markers.append(marker)
    return MarkerArray(markers=markers)


_MESSAGES: dict[type[Any], tuple[Any, Callable[[Any, str, float], Any]]] = {
    display.Plan: (Path, _path),
    display.Target: (PoseStamped, _target),
    display.Spot: (PointStamped, _spot),
    display.Flag: (Bool, _flag),
    display.Cloud: (PointCloud2, _cloud),
    display.Shapes: (MarkerArray, _markers),
    Evaluation: (LocalPlanEvaluation, evaluation_msg),
}
"""For each kind of value the type of its messages and what makes them, in a frame at a time [s]."""
