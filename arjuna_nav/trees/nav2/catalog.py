"""Which of Nav2's nodes there are."""

from __future__ import annotations

from arjuna_nav.trees.nav2 import (
    actions,
    conditions,
    controls,
    decorators,
    paths,
    plain_actions,
    robot,
    routes,
    services,
)
from arjuna_nav.trees.node import TreeNode

NAV2: tuple[type[TreeNode], ...] = (
    *(controls.PipelineSequence, controls.RecoveryNode, controls.RoundRobin),
    *(decorators.RateController, decorators.DistanceController, decorators.SpeedController),
    *(decorators.SingleTrigger, decorators.GoalUpdatedController, decorators.GoalUpdater),
    decorators.PathLongerOnApproach,
    *(conditions.AlwaysSuccess, conditions.AlwaysFailure, conditions.GoalUpdated),
    *(conditions.GlobalUpdatedGoal, conditions.GoalReached, conditions.InitialPoseReceived),
    *(conditions.TimeExpired, conditions.PathExpiringTimer, conditions.DistanceTraveled),
    *(conditions.AreErrorCodesPresent, conditions.WouldAControllerRecoveryHelp),
    *(conditions.WouldAPlannerRecoveryHelp, conditions.WouldASmootherRecoveryHelp),
    conditions.ArePosesNear,
    *(actions.ComputePathToPose, actions.ComputePathThroughPoses, actions.FollowPath),
    *(actions.SmoothPath, actions.Spin, actions.Wait, actions.BackUp, actions.DriveOnHeading),
    *(actions.AssistedTeleop, actions.DockRobot, actions.UndockRobot),
    *(services.IsPathValid, services.ReinitializeGlobalLocalization),
    *(services.ClearEntireCostmap, services.ClearCostmapExceptRegion),
    *(services.ClearCostmapAroundRobot, services.ClearCostmapAroundPose),
    *(services.CancelControl, services.CancelSpin, services.CancelBackUp, services.CancelWait),
    *(services.CancelDriveOnHeading, services.CancelAssistedTeleop),
    *(plain_actions.SetBlackboard, plain_actions.UnsetBlackboard),
    *(plain_actions.RemovePassedGoals, paths.TruncatePath),
    *(paths.TruncatePathLocal, paths.ConcatenatePaths, paths.GetPoseFromPath, paths.GetCurrentPose),
    *(robot.IsStuck, robot.IsStopped, robot.TransformAvailable),
    *(robot.IsBatteryLow, robot.IsBatteryCharging),
    *(routes.ComputeRoute, routes.ComputeAndTrackRoute, services.CancelComputeAndTrackRoute),
    *(conditions.WouldARouteRecoveryHelp, routes.NavigateToPose, routes.NavigateThroughPoses),
    *(plain_actions.PlannerSelector, plain_actions.ControllerSelector),
    *(plain_actions.SmootherSelector, plain_actions.GoalCheckerSelector),
    plain_actions.ProgressCheckerSelector,
)
