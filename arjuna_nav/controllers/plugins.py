"""The controllers, goal checkers and progress checkers that there are, by Nav2's class names."""

from __future__ import annotations

from arjuna_core.plugins import PluginTypes

_HERE = "arjuna_nav.controllers"
_PURE_PURSUIT = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"

CONTROLLERS = PluginTypes(
    "controller",
    {
        _PURE_PURSUIT: f"{_HERE}.pursuit.controller:RegulatedPurePursuit",
        "nav2_mppi_controller::MPPIController": f"{_HERE}.mppi.controller:Mppi",
        "dwb_core::DWBLocalPlanner": f"{_HERE}.dwb.controller:Dwb",
        "nav2_graceful_controller::GracefulController": f"{_HERE}.graceful.controller:Graceful",
        "nav2_rotation_shim_controller::RotationShimController": (
            f"{_HERE}.rotation_shim:RotationShim"
        ),
    },
    _PURE_PURSUIT,
    stands_in=True,
)
GOAL_CHECKERS = PluginTypes(
    "goal checker",
    {
        "nav2_controller::SimpleGoalChecker": f"{_HERE}.checkers:SimpleGoalChecker",
        "nav2_controller::StoppedGoalChecker": f"{_HERE}.checkers:StoppedGoalChecker",
        "nav2_controller::PositionGoalChecker": f"{_HERE}.checkers:PositionGoalChecker",
    },
    "nav2_controller::SimpleGoalChecker",
    stands_in=True,
)
PROGRESS_CHECKERS = PluginTypes(
    "progress checker",
    {
        "nav2_controller::SimpleProgressChecker": f"{_HERE}.checkers:SimpleProgressChecker",
        "nav2_controller::PoseProgressChecker": f"{_HERE}.checkers:PoseProgressChecker",
    },
    "nav2_controller::SimpleProgressChecker",
    stands_in=True,
)
