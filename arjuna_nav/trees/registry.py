"""The nodes that a tree may have, by the names of BehaviorTree.CPP and Nav2."""

from __future__ import annotations

from arjuna_nav.trees import (
    actions,
    conditions,
    controls,
    decorators,
    nav2_controls,
    plain_actions,
)
from arjuna_nav.trees.node import TreeNode

_CLASSES: tuple[type[TreeNode], ...] = (
    *(controls.Sequence, controls.SequenceWithMemory, controls.Fallback),
    *(controls.ReactiveSequence, controls.ReactiveFallback, controls.Parallel),
    *(controls.IfThenElse, controls.WhileDoElse),
    *(nav2_controls.PipelineSequence, nav2_controls.RecoveryNode, nav2_controls.RoundRobin),
    *(decorators.Inverter, decorators.ForceSuccess, decorators.ForceFailure),
    *(decorators.KeepRunningUntilFailure, decorators.Repeat, decorators.RetryUntilSuccessful),
    *(decorators.RunOnce, decorators.Timeout, decorators.Delay, decorators.RateController),
    *(decorators.DistanceController, decorators.SpeedController, decorators.SingleTrigger),
    *(conditions.AlwaysSuccess, conditions.AlwaysFailure, conditions.GoalUpdated),
    *(conditions.GlobalUpdatedGoal, conditions.GoalReached, conditions.InitialPoseReceived),
    *(conditions.TimeExpired, conditions.PathExpiringTimer, conditions.DistanceTraveled),
    *(conditions.AreErrorCodesPresent, conditions.WouldAControllerRecoveryHelp),
    *(conditions.WouldAPlannerRecoveryHelp, conditions.WouldASmootherRecoveryHelp),
    *(actions.ComputePathToPose, actions.ComputePathThroughPoses, actions.FollowPath),
    *(actions.SmoothPath, actions.Spin, actions.Wait, actions.BackUp, actions.DriveOnHeading),
    *(actions.AssistedTeleop, actions.DockRobot, actions.UndockRobot, actions.IsPathValid),
    *(actions.ClearEntireCostmap, actions.ClearCostmapExceptRegion),
    *(actions.ClearCostmapAroundRobot, actions.ClearCostmapAroundPose),
    *(plain_actions.SetBlackboard, plain_actions.UnsetBlackboard),
    *(plain_actions.RemovePassedGoals, plain_actions.TruncatePath),
    *(plain_actions.PlannerSelector, plain_actions.ControllerSelector),
    *(plain_actions.SmootherSelector, plain_actions.GoalCheckerSelector),
    plain_actions.ProgressCheckerSelector,
)
NODES: dict[str, type[TreeNode]] = {
    **{cls.__name__: cls for cls in _CLASSES},
    "AsyncSequence": controls.Sequence,
    "AsyncFallback": controls.Fallback,
    "SequenceStar": controls.SequenceWithMemory,
}
