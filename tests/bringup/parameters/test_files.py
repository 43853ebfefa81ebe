"""Parameter files: read, merged and listed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from arjuna_core.config import param
from arjuna_core.errors import InputFileError
from arjuna_core.files.shipped import shipped_file
from bringup.parameters.files import for_node, lines_of, load_parameters, node_of, sim_time_of
from bringup.parameters.listing import differences, dump, values_of
from tests.helpers.files import written


def test_nested_nodes_and_names_are_flattened(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "amcl: {ros__parameters: {alpha1: 0.1, initial_pose: {x: 1.0}}}\n"
        "global_costmap: {global_costmap: {ros__parameters: {resolution: 0.1}}}\n",
    )
    assert load_parameters([path]) == {
        "amcl": {"alpha1": 0.1, "initial_pose.x": 1.0},
        "global_costmap/global_costmap": {"resolution": 0.1},
    }


def test_the_shipped_file_drives_on_from_a_waypoint_as_nav2s() -> None:
    shipped = load_parameters([shipped_file("params/arjuna_nav.yaml")])
    assert shipped["waypoint_follower"] == {"stop_on_failure": False}


def test_a_later_file_wins_value_by_value(tmp_path: Path) -> None:
    first = written(tmp_path, "a: {ros__parameters: {x: 1, y: 2}}", "1.yaml")
    second = written(tmp_path, "a: {ros__parameters: {y: 3}}", "2.yaml")
    assert load_parameters([first, second]) == {"a": {"x": 1, "y": 3}}


def test_every_node_gets_the_wildcard_under_its_own() -> None:
    parameters = {"/**": {"use_sim_time": True, "x": 1, "y": 1}, "a": {"x": 2}}
    assert for_node(parameters, "a") == {"x": 2, "y": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1", r"params\.yaml: line \d+, column \d+: is no YAML"),
        ("a: 3", "a: expected 'node: "),
        ("{image: a.pgm, resolution: 0.05}", "parameters; it is a map: 'nav --map FILE'"),
        ("[{ros_topic_name: scan}]", "parameters; it is of ros_gz_bridge: its config_file"),
        ("waypoints: [{x: 1.0}]", "it is a list of waypoints: 'tour FILE' drives to poses"),
        ("a: {ros_parameters: {x: 1}}", "a: no node's .* 'ros_parameters'; .*'ros__parameters'"),
        ("a: {ros__parameters: 3}", r"a\.ros__parameters: must map names to values"),
        ("a: {ros__parameters: {b: {c: [{d: 1}]}}}", r"a\.b\.c: a list of mappings, as of ROS 1"),
    ],
)
def test_a_broken_file_names_file_and_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputFileError, match=message):
        load_parameters([written(tmp_path, text)])


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match=r"none\.yaml: cannot be read: No such file"):
        load_parameters([tmp_path / "none.yaml"])


NODES = ("amcl", "local_costmap/local_costmap")


@pytest.mark.parametrize(
    ("name", "namespace", "node"),
    [
        ("amcl", "", "amcl"),
        ("/amcl", "", "amcl"),
        ("**/amcl", "", "amcl"),
        ("/*/amcl", "robot1", "amcl"),
        ("/**/local_costmap/local_costmap", "", "local_costmap/local_costmap"),
        ("<robot_namespace>/amcl", "robot1", "amcl"),
        ("robot1/amcl", "robot1", "amcl"),
        ("/robot1/amcl", "", "amcl"),
        ("robot2/amcl", "robot1", None),
        ("amlc", "", None),
        ("local_costmap", "", None),
    ],
)
def test_a_section_matches_nodes_as_in_ros(name: str, namespace: str, node: str | None) -> None:
    assert node_of(name, NODES, namespace) == node


def test_every_name_has_its_line(tmp_path: Path) -> None:
    text = "a:\n  ros__parameters:\n    x: 1\n    y:\n      z: 2\n/**: {ros__parameters: {k: 1}}\n"
    lines, repeated = lines_of(written(tmp_path, text))
    assert (lines["a", ""], lines["a", "x"], lines["a", "y.z"], lines["/**", "k"]) == (1, 3, 5, 6)
    assert not repeated


@pytest.mark.parametrize(
    ("text", "repeated"),
    [
        ("a: {ros__parameters: {x: 1}}\na: {ros__parameters: {y: 1}}\n", {"a"}),
        ("n: {a: {ros__parameters: {x: 1}, ros__parameters: {y: 1}}}\n", {"n/a"}),
        ("a: {ros__parameters: {x: {y: 1, y: 2}}}\n", {"a: x.y"}),
        ("a: {ros__parameters: {x: 1, x: 1}}\n", set()),
    ],
)
def test_what_stands_twice_is_known(tmp_path: Path, text: str, repeated: set[str]) -> None:
    assert lines_of(written(tmp_path, text))[1] == repeated


def test_a_process_has_the_clock_that_its_nodes_name() -> None:
    parameters = {"/**": {"use_sim_time": True}, "b": {"use_sim_time": False}}
    assert sim_time_of({}, ["a"])
    assert sim_time_of(parameters, ["a"])
    assert not sim_time_of(parameters, ["a", "b"])
    assert not sim_time_of({"a": {"use_sim_time": "False"}}, ["a"])  # a launch file's text


def test_a_section_without_values_says_nothing(tmp_path: Path) -> None:
    assert load_parameters([written(tmp_path, "amcl:\n  ros__parameters:\n")]) == {"amcl": {}}


@dataclass(frozen=True)
class Drive:
    """Nested."""

    limits: tuple[float, ...] = param((0.5, float("inf")), "Limits.", unit="m/s", maximum=9.0)


@dataclass(frozen=True)
class Config:
    """One of each kind."""

    drive: Drive = Drive()
    name: str = param("off", "Name that YAML would take for a word of its own.")
    tiny: float = param(1e-7, "Tiny.", minimum=0.0)
    radius: float | None = param(None, "Radius.")
    mode: str = param("a", "Mode.", choices=("a", "b"))


def test_what_is_dumped_loads_with_the_same_values(tmp_path: Path) -> None:
    path = tmp_path / "all.yaml"
    given = {"mode": "b", "drive.limits": [0.1]}
    path.write_text(dump([("robot/base", Config, given)]), encoding="utf-8")
    loaded = load_parameters([path])["robot/base"]
    assert values_of(Config, loaded) == values_of(Config, given)


def test_a_line_says_text_unit_bounds_and_default() -> None:
    lines = dump([("n", Config, {"mode": "b"})]).splitlines()
    comments = [line.split("  # ")[-1] for line in lines[2:] if line]
    assert comments[0] == "Limits. [m/s] (at most 9)"
    assert comments[2] == "Tiny. (0 or more)"
    assert comments[4] == "Mode. (a | b) (default a)"
    assert lines[5].startswith("    # radius:")


def test_differences_name_node_name_and_both_values() -> None:
    before, after = {"n": {"x": 1, "y": (1.0,)}}, {"n": {"x": 2, "y": (1.0,)}}
    assert differences(before, after) == ["n: x: 1 -> 2"]
