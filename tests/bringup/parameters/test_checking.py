"""Claims: parameters of the command line are read as ROS reads them, and checked."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from arjuna_core.errors import ConfigError
from bringup.parameters.checking import checked, merged_sources
from bringup.parameters.files import sim_time_of
from bringup.parameters.sources import of_words

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("a:=1", {"/**": {"a": 1}}),
        ("a.b:=0.5", {"/**": {"a.b": 0.5}}),
        ("a:=[1.0, 2.0]", {"/**": {"a": [1.0, 2.0]}}),
        ("a:=x y", {"/**": {"a": "x y"}}),
        ("a:=", {"/**": {"a": ""}}),
        ("/slam_toolbox:a:=true", {"slam_toolbox": {"a": True}}),
        ("/**:a:=b:c", {"/**": {"a": "b:c"}}),
        ("local_costmap/local_costmap:a:=1", {"local_costmap/local_costmap": {"a": 1}}),
    ],
)
def test_words_are_parameters(word: str, expected: object) -> None:
    assert of_words([word]).values == expected


@pytest.mark.parametrize("word", ["a", "a=1", ":=1", "a:=[1", "node::=1"])
def test_words_that_are_none_are_refused(word: str) -> None:
    with pytest.raises(ConfigError, match=r"is none; valid: NAME:=VALUE|is no YAML value"):
        of_words([word])


def test_they_come_over_files_and_reach_the_nodes_that_have_them() -> None:
    below = {"slam_toolbox": {"mode": "mapping", "resolution": 0.1}}
    words = ["slam_toolbox:mode:=localization", "maps_folder:=/tmp", "use_sim_time:=false"]
    found = checked(of_words(words), below).parameters
    assert found["slam_toolbox"]["mode"] == "localization"
    assert found["slam_toolbox"]["resolution"] == 0.1
    assert found["map_server"]["maps_folder"] == "/tmp"
    assert not sim_time_of(found, ["slam_toolbox"])
    assert checked(of_words([]), below).parameters is below


@pytest.mark.parametrize(
    ("word", "problem"),
    [
        ("slam_toolbox:mod:=mapping", "slam_toolbox: mod: .*the nearest is 'mode'"),
        ("slam_tolbox:mode:=mapping", "slam_tolbox: no node has this name"),
        ("slam_toolbox:mode:=other", "slam_toolbox: 'mode' is 'other'; valid: mapping"),
        ("nothing_has_this:=1", "nothing_has_this: no node has it"),
    ],
)
def test_what_no_node_takes_is_refused(word: str, problem: str) -> None:
    with pytest.raises(ConfigError, match=f"--param: .*{problem}"):
        merged_sources([], [word])
