"""Parameters as `--as-nav2` sets them."""

from __future__ import annotations

from typing import Any

from arjuna_core.config import load
from bringup.parameters.sources import as_nav2
from bringup.stack import all_nodes


def nav2_config(node: str, **values: Any) -> Any:
    """Return a node's parameters as `--as-nav2` sets them, given those of a file."""
    (spec,) = (one for one in all_nodes() if one.name == node)
    parameters = as_nav2({node: values}, [spec], replaces=False)
    return load(spec.config, parameters.get(node, {}))
