"""Sources beside files: the words of the command line as ROS reads them, a robot's names."""

from __future__ import annotations

from typing import Any

import pytest

from arjuna_core.errors import ConfigError
from arjuna_core.files.shipped import shipped_file
from bringup.cli import parse
from bringup.parameters.checking import problems_of
from bringup.parameters.files import merged, shipped_parameters
from bringup.parameters.inputs import groups_of
from bringup.parameters.sources import ROBOT_NAMES, of_names, of_options, of_words
from bringup.stack import LOCAL_COSTMAP, NAVIGATION_GROUP

pytestmark = pytest.mark.ros
OPTIONS = {name: f"--{name.replace('_', '-')}" for name in ROBOT_NAMES}


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("a:=1", {"/**": {"a": 1}}),
        ("a.b:=0.5", {"/**": {"a.b": 0.5}}),
        ("a:=[1.0, 2.0]", {"/**": {"a": [1.0, 2.0]}}),
        ("a:=x y", {"/**": {"a": "x y"}}),
        ("a:=[[0.1, 0], [1, 2]]", {"/**": {"a": "[[0.1, 0], [1, 2]]"}}),
        ("a:=", {"/**": {"a": ""}}),
        ("/slam_toolbox:a:=true", {"slam_toolbox": {"a": True}}),
        ("/**:a:=b:c", {"/**": {"a": "b:c"}}),
        ("local_costmap/local_costmap:a:=1", {"local_costmap/local_costmap": {"a": 1}}),
    ],
)
def test_words_are_parameters(word: str, expected: object) -> None:
    assert of_words([word]).values == expected


@pytest.mark.parametrize("word", ["a", "a=1", ":=1", "a:=[1", "node::=1"])
def test_invalid_words_are_refused(word: str) -> None:
    with pytest.raises(ConfigError, match=r"is none; valid: NAME:=VALUE|is no YAML value"):
        of_words([word])


@pytest.mark.parametrize("where", [["--slam"], ["--map", "maps/office.yaml"]])
def test_every_option_is_a_parameter_of_the_nodes_that_run(where: list[str]) -> None:
    given = [word for option in OPTIONS.values() for word in (option, "other")]
    arguments = parse(["robot", *where, *given, "--robot", "urdf/arjuna.urdf"])
    groups = groups_of(arguments)
    shipped = shipped_parameters()
    found = of_names(vars(arguments), groups, shipped)
    specs = [spec for group in groups for spec in group.nodes]
    assert problems_of(merged(shipped, found), specs) == []
    assert set(found) <= {spec.name for group in groups for spec in group.nodes}
    assert found["collision_monitor"]["base_frame_id"] == "other"
    assert found["collision_monitor"]["cmd_vel_out_topic"] == "other"
    assert "cmd_vel_topic" not in found.get("controller_server", {})


def test_plug_ins_say_which_of_their_topics_are_the_robot_s() -> None:
    layers = {
        "plugins": ["cloudy", "all"],
        "cloudy.plugin": "nav2_costmap_2d::VoxelLayer",
        "cloudy.observation_sources": "camera front rear",
        "cloudy.camera.data_type": "PointCloud2",
        "all.plugin": "nav2_costmap_2d::PluginContainerLayer",
        "all.plugins": ["touch"],
        "all.touch.plugin": "arjuna_nav::ContactLayer",
    }
    names = {"scan_topic": "/s", "cmd_vel_topic": "/c", "odom_topic": None}
    found = of_names(names, [NAVIGATION_GROUP], {LOCAL_COSTMAP.name: layers})
    expected = {"cloudy.front.topic": "/s", "all.touch.topic": "/c"}
    assert found[LOCAL_COSTMAP.name] == expected
    assert found["docking_server"] == {"cmd_vel_topic": "/c"}


def test_shipped_parameters_are_the_caller_s_own() -> None:
    first, again = shipped_parameters(), shipped_parameters()
    assert first == again
    lists = [value for node in first.values() for value in node.values() if type(value) is list]
    changed: list[Any] = [*lists, first["sim"]]
    for value in changed:
        value.clear()
    assert shipped_parameters() == again


def of_line(line: str) -> dict[str, object]:
    """Return the parameters of `sim` that a command line stands for."""
    arguments = parse(["sim", *line.split()])
    return of_options(vars(arguments), groups_of(arguments), {}).get("sim", {})


def test_options_are_parameters_of_the_simulator() -> None:
    assert of_line("") == {}
    one = of_line("--at 1 -2 --yaw 0.5 --rtf 0 --seed 3 a:=1 --viewer")
    assert one == {
        "initial_pose.x": 1.0,
        "initial_pose.y": -2.0,
        "initial_pose.yaw": 0.5,
        "real_time_factor": 0.0,
        "seed": 3,
        "robot_arguments": "a:=1",
        "viewer": True,
    }
    file = str(shipped_file("urdf/burger.urdf").resolve())
    several = of_line(f"--namespace a --namespace b --robot {file} --at 1 2 --at 3 4")
    assert several["namespaces"] == ["a", "b"]
    assert several["robots"] == [file, file]
    assert several["starts"] == [1.0, 2.0, 0.0, 3.0, 4.0, 0.0]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("--at 0 0 --at 1 1", "is given again, but there is one robot"),
        ("--namespace a --namespace b --at 0 0 --at 1 1 --yaw 1", r"2 .* and 1 headings .* given"),
    ],
)
def test_starts_at_odds_are_refused(line: str, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        of_line(line)
