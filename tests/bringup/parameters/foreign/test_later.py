"""Parameters in the forms of Nav2 after Jazzy, as its configuration guide has them."""

from __future__ import annotations

from typing import Any

import pytest

from arjuna_core.config import flatten, load
from bringup.parameters.files import Parameters, for_node, shipped_parameters
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.remarks import Checked, Kind
from bringup.stack import all_nodes

pytestmark = pytest.mark.ros
NODES = {spec.name: spec for spec in all_nodes()}
MPPI = "nav2_mppi_controller::MPPIController"
RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"
SHIM = "nav2_rotation_shim_controller::RotationShimController"
GLOBAL = "global_costmap/global_costmap"


def understood(given: Parameters) -> Checked:
    found = understand(given, shipped_parameters(), NODES.values())
    assert found.problems == []
    return found


def of(found: Checked, node: str = "controller_server") -> dict[str, Any]:
    """Return a node's parameters, as it is made of them."""
    return flatten(load(NODES[node].config, for_node(found.parameters, node)))


def controllers(**below: Any) -> Checked:
    return understood({"controller_server": {k.replace("__", "."): v for k, v in below.items()}})


@pytest.mark.parametrize("model", ["DiffDrive", "Omni", "Ackermann"])
@pytest.mark.parametrize("name", ["mine", None])
def test_a_motion_model_is_a_group_of_a_name(model: str, name: str | None) -> None:
    group = name or "diff_drive"
    given: dict[str, Any] = {"FollowPath.plugin": MPPI}
    given[f"FollowPath.{group}.plugin"] = f"mppi::{model}MotionModel"
    given |= {"FollowPath.motion_model": name} if name else {}
    given[f"FollowPath.{group}.min_turning_r"] = 0.7
    found = understood({"controller_server": given})
    assert found.remarks == []
    assert of(found)["FollowPath.motion_model"] == model
    assert of(found)["FollowPath.AckermannConstraints.min_turning_r"] == 0.7


def test_the_group_of_a_model_that_jazzy_names_says_its_bend_too() -> None:
    given = {"FollowPath.plugin": MPPI, "FollowPath.motion_model": "Ackermann"}
    given["FollowPath.ackermann.plugin"] = "mppi::AckermannMotionModel"
    found = understood({"controller_server": {**given, "FollowPath.ackermann.min_turning_r": 1.65}})
    assert of(found)["FollowPath.AckermannConstraints.min_turning_r"] == 1.65
    other = {"FollowPath.plugin": MPPI, "FollowPath.motion_model": "DiffDrive"}
    other["FollowPath.car.plugin"] = "mppi::AckermannMotionModel"
    assert of(understood({"controller_server": other}))["FollowPath.motion_model"] == "DiffDrive"


def test_a_wrapped_controller_s_parameters_stand_below_it() -> None:
    found = controllers(
        FollowPath__plugin=SHIM,
        FollowPath__max_angular_accel=1.0,
        FollowPath__primary_controller__plugin=RPP.replace("::", "/"),
        FollowPath__primary_controller__desired_linear_vel=0.2,
        FollowPath__primary_controller__max_angular_accel=2.0,
    )
    assert of(found)["FollowPath.primary_controller"] == RPP
    assert of(found)["FollowPath.desired_linear_vel"] == 0.2
    assert of(found)["FollowPath.max_angular_accel"] == 1.0
    (remark,) = found.remarks
    assert remark.kind is Kind.NO_EFFECT
    assert "primary_controller.max_angular_accel" in str(remark)


def test_the_first_path_handler_is_mppi_s() -> None:
    handler = "nav2_controller::FeasiblePathHandler"
    found = controllers(
        controller_plugins=["FollowPath", "Slow"],
        path_handler_plugins=["second", "first"],
        first__plugin=handler,
        first__prune_distance=3.0,
        second__plugin=handler,
        second__prune_distance=2.0,
        second__enforce_path_inversion=True,
        second__enforce_path_rotation=True,
        FollowPath__plugin=MPPI,
        Slow__plugin=MPPI,
        Slow__prune_distance=1.0,
    )
    assert of(found)["FollowPath.enforce_path_inversion"]
    assert of(found)["FollowPath.prune_distance"] == 2.0
    assert of(found)["Slow.prune_distance"] == 1.0
    lost = [str(one) for one in found.remarks if one.kind is Kind.NO_EFFECT]
    assert len(lost) == 1
    assert "enforce_path_rotation" in lost[0]


def test_the_greatest_speed_of_pure_pursuit_holds_by_its_newer_name() -> None:
    given = {"FollowPath__plugin": RPP, "FollowPath__max_linear_vel": 0.2}
    assert of(controllers(**given))["FollowPath.desired_linear_vel"] == 0.2
    both = controllers(**given, FollowPath__desired_linear_vel=0.3)
    assert of(both)["FollowPath.desired_linear_vel"] == 0.3
    assert "SAFETY" in str(both.remarks[0])
    assert "desired_linear_vel" in str(both.remarks[0])


@pytest.mark.parametrize(
    ("cls", "warned"), [("AsymmetricInflationLayer", True), ("LegacyInflationLayer", False)]
)
def test_an_inflation_layer_after_jazzy_inflates(cls: str, warned: bool) -> None:
    own = {"plugin": f"nav2_costmap_2d::{cls}", "inflation_radius": 0.7}
    section = {f"wide.{key}": value for key, value in own.items()}
    found = understood({GLOBAL: {"plugins": ["static_layer", "wide"], **section}})
    assert of(found, GLOBAL)["plugins"] == ("static_layer", "wide")
    assert of(found, GLOBAL)["wide.inflation_radius"] == 0.7
    remarks = [str(one) for one in found.remarks]
    assert any("stands in" in one and "SAFETY" in one for one in remarks) == warned


def test_a_goal_checker_after_jazzy_has_its_finer_tolerance() -> None:
    found = controllers(
        general_goal_checker__plugin="nav2_controller::AdaptiveToleranceGoalChecker",
        general_goal_checker__fine_xy_goal_tolerance=0.07,
    )
    assert of(found)["general_goal_checker.xy_goal_tolerance"] == 0.07
    assert found.remarks[0].kind is Kind.NO_EFFECT


def test_a_navigator_s_blackboard_has_its_entries() -> None:
    found = understood({"bt_navigator": {"navigate_to_pose.goal_blackboard_id": "target"}})
    assert of(found, "bt_navigator")["goal_blackboard_id"] == "target"
