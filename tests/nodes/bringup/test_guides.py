"""The guides' parameter files load, and the parameters that their tables name exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from bringup.parameters.composition import node_class
from bringup.parameters.files import for_node, shipped_parameters
from bringup.parameters.inputs import all_nodes, problems_in
from bringup.parameters.listing import values_of
from scripts.guides_page import ORDER, ROOT, read, table_of

pytestmark = pytest.mark.ros
SHIPPED = shipped_parameters()
KNOWN = {
    spec.name: set(values_of(node_class(spec).Config, for_node(SHIPPED, spec.name)))
    for spec in all_nodes()
}
_NAMED = re.compile(r"`([a-z_/]+)\.([\w.]+)`")


@pytest.mark.parametrize("guide", ORDER)
def test_a_guides_parameters_load(guide: str) -> None:
    assert problems_in(ROOT / "guides" / guide / "params.yaml") == []


@pytest.mark.parametrize("guide", ORDER)
def test_every_parameter_that_a_guides_table_names_exists(guide: str) -> None:
    for rows in read(table_of(guide))[1].values():
        for row in rows:
            for node, key in _NAMED.findall(row.here):
                assert node not in KNOWN or _exists(node, key), f"{node}.{key}"


def _exists(node: str, key: str) -> bool:
    """Tell whether a node has a parameter; plug-ins bring theirs with them, by a name."""
    return key in KNOWN[node] or key.split(".")[0] in {"FollowPath", "general_goal_checker"}


def test_every_folder_is_a_guide() -> None:
    folders = {path.name for path in Path(ROOT / "guides").iterdir() if path.is_dir()}
    assert folders == set(ORDER)
