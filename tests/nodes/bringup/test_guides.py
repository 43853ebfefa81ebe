"""The guides' parameter files load, and the parameters that their tables name exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from bringup.parameters.checking import check_file, over_shipped
from bringup.parameters.files import Parameters, for_node, shipped_parameters
from bringup.parameters.listing import values_of
from bringup.stack import all_nodes
from scripts.guides_page import ORDER, ROOT, read, table_of

SHIPPED = shipped_parameters()
KNOWN = {
    spec.name: set(values_of(spec.config, for_node(SHIPPED, spec.name))) for spec in all_nodes()
}
_NAMED = re.compile(r"`([a-z_/]+)\.([\w.]+)`")
_NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?!\w)")


@pytest.mark.parametrize("guide", ORDER)
def test_a_guides_parameters_load(guide: str) -> None:
    assert check_file(ROOT / "guides" / guide / "params.yaml").refused_by(strict=True) == []


@pytest.mark.parametrize("guide", ORDER)
def test_every_parameter_that_a_guides_table_names_exists(guide: str) -> None:
    for rows in read(table_of(guide))[1].values():
        for row in rows:
            for node, key in _NAMED.findall(row.here):
                of_plugin = key.split(".")[0] in {"FollowPath", "general_goal_checker"}
                assert node not in KNOWN or key in KNOWN[node] or of_plugin, f"{node}.{key}"


@pytest.mark.parametrize("guide", ORDER)
def test_a_guides_value_is_its_files_or_the_table_says_which_is(guide: str) -> None:
    given = over_shipped([ROOT / "guides" / guide / "params.yaml"])
    for rows in read(table_of(guide))[1].values():
        for row in rows:
            numbers = [float(number) for number in _NUMBER.findall(row.theirs)]
            for node, key in _NAMED.findall(row.here) if numbers else ():
                value = _value(node, key, given)
                named = isinstance(value, int | float) and f"{value:g}" in row.here
                assert value is None or value in numbers or named, f"{row.theirs}: {value}"


def _value(node: str, key: str, given: Parameters) -> object:
    """Return a node's number, None for what is not one or not there."""
    spec = next((spec for spec in all_nodes() if spec.name == node), None)
    if spec is None:
        return None
    value = values_of(spec.config, for_node(given, node)).get(key)
    return value if isinstance(value, int | float) and not isinstance(value, bool) else None


def test_every_folder_is_a_guide() -> None:
    folders = {path.name for path in Path(ROOT / "guides").iterdir() if path.is_dir()}
    assert folders == set(ORDER)
