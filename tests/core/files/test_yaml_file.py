"""YAML as ROS reads it, and what is refused of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from arjuna_core.errors import InputFileError
from arjuna_core.files.yaml_file import _DEEPEST, _MOST, check_keys, plain, read_nodes, read_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-9", 1e-9),
        ("-2.5E3", -2500.0),
        ("[+1e2, 1.e1, e1, 1e, 1e+x]", [100.0, 10.0, "e1", "1e", "1e+x"]),
        ("0x1f", 31),
        (f"[{-(2**63)}, {2**64 - 1}]", [-(2**63), 2**64 - 1]),
        ("2026-01-02", "2026-01-02"),
        ("yes", True),
        ("a: &a {b: 1}\nc: *a", {"a": {"b": 1}, "c": {"b": 1}}),
        ("", None),
    ],
)
def test_values_are_those_of_ros(text: str, value: Any) -> None:
    assert plain(text) == value


def nested(depth: int) -> str:
    return "[" * depth + "]" * depth


def test_lists_are_nested_so_deep_and_no_deeper() -> None:
    assert plain(f"[{nested(_DEEPEST - 1)}, {nested(_DEEPEST - 1)}]") is not None
    with pytest.raises(yaml.YAMLError, match=f"is nested deeper than {_DEEPEST} levels"):
        plain(f"[{nested(_DEEPEST - 1)}, {nested(_DEEPEST)}]")


def doubled(times: int) -> str:
    """Return a list of two, of which each further one holds the last one twice."""
    lines = (f"a{k}: &a{k} [*a{k - 1}, *a{k - 1}]" for k in range(1, times + 1))
    return "\n".join(("a0: &a0 [1, 1]", *lines))


def test_what_grows_by_its_aliases_is_refused_before_it_grows() -> None:
    found = plain(doubled(10))["a10"]
    for _ in range(11):
        found = found[1]
    assert found == 1
    with pytest.raises(yaml.YAMLError, match=f"holds more than {_MOST} values"):
        plain(doubled(60))
    with pytest.raises(yaml.YAMLError, match=r"\*a stands in itself"):
        plain("a: &a [1, *a]")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("a: 1\nb: [1", "line 3, column 1: is no YAML: .*expected ',' or ']'"),
        ("a:\n  b: 1\n\tc: 2", "line 3, column 1: is no YAML: a tab indents; valid: spaces"),
        (f"a: {2**64}", "18446744073709551616, a whole number of more than 64 bits"),
        (f"a: {-(2**63) - 1}", "-9223372036854775809, a whole number of more than 64 bits"),
        ("a: !!int x", "text: is no YAML: holds a value that cannot be"),
        ("a: !!binary aGk=", "could not determine a constructor for the tag"),
        ("a: !!python/object/apply:os.getcwd []", "could not determine a constructor"),
    ],
)
def test_what_is_no_yaml_is_refused_where_it_stands(
    tmp_path: Path, text: str, problem: str
) -> None:
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(InputFileError, match=problem):
        read_yaml(tmp_path / "a.yaml")


def test_nodes_know_their_lines(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("a: 1\nb:\n- 1e3\n")
    node = read_nodes(tmp_path / "a.yaml")
    assert isinstance(node, yaml.MappingNode)
    assert [value.start_mark.line for _, value in node.value] == [0, 2]
    assert node.value[1][1].value[0].tag == "tag:yaml.org,2002:float"


@pytest.mark.parametrize(
    ("content", "empty", "problem"),
    [
        ([1], False, "is no mapping; valid keys: image, origin, free"),
        ({"image": "a", "orign": 1, 7: 2}, False, "'orign': .*'origin'.*; '7': .*'origin' is miss"),
        ({"image": "", "origin": 1}, False, "'image' is missing"),
        ({"image": ""}, True, "'origin' is missing"),
        ({"image": "", "origin": None}, True, ""),
        ({"image": "a", "origin": 1, "free": 0}, False, ""),
    ],
)
def test_keys_are_known_and_those_that_are_needed_are_there(
    content: Any, empty: bool, problem: str
) -> None:
    valid, needed = ("image", "origin", "free"), ("image", "origin")
    if problem:
        with pytest.raises(InputFileError, match=problem):
            check_keys(Path("m.yaml"), content, valid, needed, empty=empty)
    else:
        check_keys(Path("m.yaml"), content, valid, needed, empty=empty)
