"""Parameters in the forms of Nav2 before Foxy, as its files of Dashing and Eloquent have them."""

from __future__ import annotations

from typing import Any

import pytest

from bringup.parameters.files import Parameters
from tests.bringup.parameters.foreign.test_later import of, understood

pytestmark = pytest.mark.ros
LOCAL = "local_costmap/local_costmap"
DWB = {
    "max_vel_x": 0.26,
    "max_vel_theta": 1.0,
    "critics": ["PathDist", "GoalDist"],
    "PathDist.scale": 7.0,
    "xy_goal_tolerance": 0.11,
}


@pytest.mark.parametrize("section", ["dwb_controller", "DwbController", "/robot/dwb_controller"])
def test_the_controller_s_own_node_is_a_plug_in_of_a_server(section: str) -> None:
    own = {"min_x_velocity_threshold": 0.002, "required_movement_radius": 0.3}
    found = understood({section: {**DWB, **own}})
    assert found.remarks == []
    values = of(found)
    assert values["controller_plugins"] == ("FollowPath",)
    assert values["FollowPath.plugin"] == "dwb_core::DWBLocalPlanner"
    assert (values["FollowPath.max_vel_x"], values["FollowPath.PathDist.scale"]) == (0.26, 7.0)
    assert values["FollowPath.critics"] == ("PathDist", "GoalDist")
    assert values["FollowPath.xy_goal_tolerance"] == 0.11
    assert values["goal_checker.xy_goal_tolerance"] == 0.11
    assert values["min_x_velocity_threshold"] == 0.002
    assert values["progress_checker.required_movement_radius"] == 0.3


def test_the_planner_s_own_node_is_a_plug_in_of_a_server() -> None:
    found = understood({"navfn_planner": {"tolerance": 0.07, "use_astar": True}})
    assert found.remarks == []
    values = of(found, "planner_server")
    assert (values["GridBased.tolerance"], values["GridBased.use_astar"]) == (0.07, True)


def test_names_and_classes_in_two_lists_are_plug_ins_with_their_classes() -> None:
    given: Parameters = {
        "controller_server": {
            "controller_plugin_ids": ["Way"],
            "controller_plugin_types": ["dwb_core::DWBLocalPlanner"],
            **{f"Way.{key}": value for key, value in DWB.items()},
        },
        "planner_server": {
            "planner_plugin_ids": ["Grid"],
            "planner_plugin_types": ["nav2_navfn_planner/NavfnPlanner"],
            "Grid.tolerance": 0.3,
        },
        "recoveries_server": {
            "plugin_names": ["spin", "back_up"],
            "plugin_types": ["nav2_recoveries/Spin", "nav2_recoveries/BackUp"],
        },
    }
    found = understood(given)
    assert found.remarks == []
    way = of(found)
    assert (way["controller_plugins"], way["Way.max_vel_x"]) == (("Way",), 0.26)
    assert way["goal_checker.xy_goal_tolerance"] == 0.11
    assert of(found, "planner_server")["Grid.tolerance"] == 0.3
    assert of(found, "behavior_server")["behavior_plugins"] == ("spin", "backup")


def test_a_controller_s_goal_does_not_change_a_checker_that_the_file_lists() -> None:
    listed = {"goal_checker_plugin": "exact", "exact.plugin": "nav2_controller::SimpleGoalChecker"}
    ids = {"controller_plugin_ids": ["A"], "controller_plugin_types": ["dwb_core::DWBLocalPlanner"]}
    values = of(understood({"controller_server": {**ids, **listed, "A.xy_goal_tolerance": 0.1}}))
    assert values["goal_checker_plugins"] == ("exact",)
    assert values["exact.xy_goal_tolerance"] == 0.25


LAYERS = {
    "plugin_names": ["seen", "inflation_layer"],
    "plugin_types": ["nav2_costmap_2d::ObstacleLayer", "nav2_costmap_2d::InflationLayer"],
}


@pytest.mark.parametrize(("layers", "name"), [(LAYERS, "seen"), ({}, "obstacle_layer")])
def test_a_costmap_s_own_sources_are_those_of_its_layers(layers: dict[str, Any], name: str) -> None:
    given = {**layers, "observation_sources": "front", "front.topic": "front_scan"}
    given |= {f"{name}.enabled": True, "front.marking": True}
    found = understood({LOCAL: given})
    assert found.remarks == []
    values = of(found, LOCAL)
    assert values[f"{name}.observation_sources"] == "front"
    assert values[f"{name}.front.topic"] == "front_scan"
