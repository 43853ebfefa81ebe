"""Parameter files: forms, merging, errors that say what is valid."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from bringup.parameters.files import for_node, load_parameters, unknown_nodes


def write(folder: Path, text: str, name: str = "params.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_nested_nodes_and_names_are_flattened(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "amcl: {ros__parameters: {alpha1: 0.1, initial_pose: {x: 1.0}}}\n"
        "global_costmap: {global_costmap: {ros__parameters: {resolution: 0.1}}}\n",
    )
    assert load_parameters([path]) == {
        "amcl": {"alpha1": 0.1, "initial_pose.x": 1.0},
        "global_costmap/global_costmap": {"resolution": 0.1},
    }


def test_a_later_file_wins_value_by_value(tmp_path: Path) -> None:
    first = write(tmp_path, "a: {ros__parameters: {x: 1, y: 2}}", "1.yaml")
    second = write(tmp_path, "a: {ros__parameters: {y: 3}}", "2.yaml")
    assert load_parameters([first, second]) == {"a": {"x": 1, "y": 3}}


def test_every_node_gets_the_wildcard_under_its_own() -> None:
    parameters = {"/**": {"use_sim_time": True, "x": 1, "y": 1}, "a": {"x": 2}}
    assert for_node(parameters, "a") == {"x": 2, "y": 1}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1", r"params\.yaml: line \d+, column \d+: is no YAML"),
        ("a: 3", "a: expected 'node: "),
        ("a: {ros__parameters: 3}", r"a\.ros__parameters: must map names to values"),
    ],
)
def test_a_broken_file_names_file_and_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputFileError, match=message):
        load_parameters([write(tmp_path, text)])


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputFileError, match=r"none\.yaml: cannot be read: No such file"):
        load_parameters([tmp_path / "none.yaml"])


def test_an_unknown_node_names_the_nearest() -> None:
    (problem,) = unknown_nodes({"amlc": {}, "sim": {}, "/**": {}}, ["amcl", "sim"])
    assert problem == "parameters for unknown node 'amlc'; did you mean 'amcl'?"
