"""Sources over the shipped parameters: what is merged, what is refused, and where it stands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from arjuna_core.config import flatten, infos, load
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes
from bringup.parameters.checking import (
    check_file,
    checked,
    merged_sources,
    over_shipped,
    problems_of,
)
from bringup.parameters.files import sim_time_of
from bringup.parameters.sources import COSTMAPS, of_words
from bringup.stack import VELOCITY_CHAIN, all_nodes
from tests.helpers.files import written

pytestmark = pytest.mark.ros
PATH = re.compile(r"(folder|file|filename|filepath|_dir|xml|database)$|^(robots?|world)$")


def test_words_come_over_files_and_reach_the_nodes_that_have_them() -> None:
    below = {"slam_toolbox": {"mode": "mapping", "resolution": 0.1}}
    words = ["slam_toolbox:mode:=localization", "maps_folder:=/tmp", "use_sim_time:=false"]
    found = checked(of_words(words), below).parameters
    assert found["slam_toolbox"]["mode"] == "localization"
    assert found["slam_toolbox"]["resolution"] == 0.1
    assert found["map_server"]["maps_folder"] == "/tmp"
    assert not sim_time_of(found, ["slam_toolbox"])
    assert checked(of_words([]), below).parameters is below


def test_a_file_and_a_word_with_a_class_keep_what_an_earlier_file_says(tmp_path: Path) -> None:
    node, filters = COSTMAPS[1], "filters: [a], a.plugin: 'nav2_costmap_2d::SpeedFilter'"
    said = "resolution: 0.1, inflation_layer.plugin: 'nav2_costmap_2d::InflationLayer'"
    first, second = (
        written(tmp_path, f"{node}: {{ros__parameters: {{{values}}}}}", f"{number}.yaml")
        for number, values in enumerate((said, filters))
    )
    word = f"{node}:inflation_layer.plugin:=nav2_costmap_2d::InflationLayer"
    found = merged_sources([first, second], [word]).parameters[node]
    assert (found["resolution"], found["filters"]) == (0.1, ["a"])


def test_the_smoothed_velocity_goes_where_the_monitor_takes_it_from(tmp_path: Path) -> None:
    file = written(
        tmp_path, "collision_monitor:\n  ros__parameters:\n    cmd_vel_in_topic: cmd_vel_raw\n"
    )
    assert merged_sources([file]).parameters["velocity_smoother"]["cmd_vel_out_topic"] == (
        "cmd_vel_raw"
    )
    for passed, taken, smoothed in (
        ("limited", "limited", "cmd_vel"),
        ("cmd_vel", "cmd_vel", None),
    ):
        topics = f"{{cmd_vel_in_topic: cmd_vel_nav, cmd_vel_out_topic: {passed}}}"
        file.write_text(f"collision_monitor: {{ros__parameters: {topics}}}")
        smoother = merged_sources([file]).parameters["velocity_smoother"]
        assert smoother["cmd_vel_in_topic"] == taken, "it would answer itself"
        assert smoother.get("cmd_vel_out_topic") == smoothed
    own = ["velocity_smoother:cmd_vel_out_topic:=smooth"]
    found = merged_sources([file], own).parameters["velocity_smoother"]
    assert found["cmd_vel_out_topic"] == "smooth"


MPPI = """
controller_server:
  ros__parameters:
    controller_plugins: [Own]
    Own:
      plugin: nav2_mppi_controller::MPPIController
    arrival:
      enabled: true
"""


def test_as_nav2_every_parameter_has_nav2s_behaviour_but_for_those_of_files(tmp_path: Path) -> None:
    file = written(tmp_path, MPPI)
    found = merged_sources([file], ["amcl:relocalize:=true"], originals=["nav2"]).parameters
    controller, monitor = found["controller_server"], found["collision_monitor"]
    assert controller["Own.noise_time"] == 0.0, "of a plug-in that the file names"
    assert controller["arrival.enabled"], "the file says so"
    assert not controller["escape.enabled"]
    assert monitor["FootprintApproach.moving_time"] == 0.0, "shipped is another value"
    assert found["amcl"]["relocalize"]
    assert found["amcl"]["global_localization_at_start"] == "never"
    plain = merged_sources([file]).parameters
    assert "Own.noise_time" not in plain["controller_server"]
    assert not problems_of(found, all_nodes())


@pytest.fixture(scope="module")
def configs() -> list[type[Any]]:
    """Return the configs of all nodes and of all plug-ins, with those of their defaults."""
    found = [spec.config for spec in all_nodes()]
    shim = {"primary_controller": "dwb_core::DWBLocalPlanner"}
    kinds = {id(info.plugins): info.plugins for one in found for info in infos(one).values()}
    for kind in kinds.values():
        for name in kind.types if isinstance(kind, PluginTypes) else ():
            found.append(kind.config_of(name, shim))
    return found


def test_each_value_with_their_behaviour_is_valid(configs: list[type[Any]]) -> None:
    others = [
        flatten(load(config, {key: info.theirs}))[key] == info.theirs
        for config in configs
        for key, info in infos(config).items()
        if info.theirs is not None
    ]
    assert len(others) > 20
    assert all(others)


def test_no_client_changes_a_path(configs: list[type[Any]]) -> None:
    paths = {}
    for config in configs:
        defaults = flatten(config())
        for key, info in infos(config).items():
            if isinstance(defaults[key], str | tuple) and PATH.search(key):
                paths[key] = info.path
            assert info.read_only or not info.path, key
    assert len(paths) > 15
    assert [key for key, known in paths.items() if not known] == []


@pytest.mark.parametrize(
    ("word", "problem"),
    [
        ("slam_toolbox:mod:=mapping", "slam_toolbox: mod: .*the nearest is 'mode'"),
        ("slam_tolbox:mode:=mapping", "slam_tolbox: no node has this name"),
        ("slam_toolbox:mode:=other", "slam_toolbox: mode: no value of it.*; valid: mapping"),
        ("nothing_has_this:=1", "nothing_has_this: no node has it"),
    ],
)
def test_what_no_node_takes_is_refused(word: str, problem: str) -> None:
    with pytest.raises(ConfigError, match=f"--param: .*{problem}"):
        merged_sources([], [word])


@pytest.mark.parametrize("said", ["controller_server", "velocity_smoother", "/**"])
def test_a_chain_of_velocities_is_of_one_type(said: str, tmp_path: Path) -> None:
    file = written(tmp_path, f'"{said}": {{ros__parameters: {{enable_stamped_cmd_vel: true}}}}')
    parameters = over_shipped([file])
    for name in VELOCITY_CHAIN:
        assert parameters[name]["enable_stamped_cmd_vel"] is True
    for name in COSTMAPS:
        assert parameters[name]["contact_layer.enable_stamped_cmd_vel"] is True
    renamed = written(
        tmp_path,
        "local_costmap: {local_costmap: {ros__parameters: {plugins: [touch],"
        " touch: {plugin: 'arjuna_nav::ContactLayer'}}}}",
        "renamed.yaml",
    )
    of_another_name = over_shipped([renamed, file])[COSTMAPS[0]]
    assert of_another_name["touch.enable_stamped_cmd_vel"] is True
    plain = over_shipped([])
    assert not any("enable_stamped_cmd_vel" in plain.get(name, {}) for name in VELOCITY_CHAIN)


def test_a_file_s_mistakes_are_all_named(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "amcl: {ros__parameters: {alpha1: -3.0, alpah2: 0.2}}\n"
        "amlc: {ros__parameters: {x: 1}}\n"
        f"map_server: {{ros__parameters: {{yaml_filename: {tmp_path / 'bad.yaml'}}}}}\n",
        "bad.yaml",
    )
    bound, of_map = check_file(path).problems
    assert bound == f"{path}:1: amcl: 'alpha1' is -3.0; the least valid is 0.0"
    assert of_map.startswith(f"{path}: map_server: {path}")
    assert check_file(path).refused_by(strict=True)[2:] == [
        f"{path}:2: unknown: amlc: no node has this name; the nearest is 'amcl'",
        f"{path}:1: unknown: amcl: alpah2: no such parameter; the nearest is 'alpha2'",
    ]
