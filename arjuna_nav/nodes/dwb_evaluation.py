"""DWB's evaluation as a message, imported where a DWB is configured alone."""

from __future__ import annotations

from dwb_msgs.msg import CriticScore, LocalPlanEvaluation, Trajectory2D, TrajectoryScore
from geometry_msgs.msg import Pose2D

from arjuna_core.ros.convert import duration_msg, header
from arjuna_core.ros.messages import maker
from arjuna_nav.controllers.display import Evaluation, Judged

MESSAGE = LocalPlanEvaluation
_critic, _pose = maker(CriticScore, "name", "raw_score", "scale"), maker(Pose2D, "x", "y", "theta")
_trajectory = maker(
    *(Trajectory2D, "velocity.x", "velocity.y", "velocity.theta", "time_offsets", "poses")
)
_score = maker(TrajectoryScore, "traj", "scores", "total")


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
