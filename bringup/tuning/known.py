"""The parameters that nodes have, with their values as some files set them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from arjuna_core.config import flatten, infos, load
from bringup.parameters.checking import over_shipped
from bringup.parameters.files import for_node
from bringup.stack import all_nodes
from bringup.tuning.space import Known


def known_parameters(paths: Sequence[Path]) -> Known:
    """Return every parameter's value under some files, and what is known of it, by node.

    Args:
        paths: Parameter files, a later one over an earlier, all over the shipped ones.

    Raises:
        ArjunaError: A file cannot be used.
    """
    values = over_shipped(paths)
    known: dict[str, dict[str, tuple[object, object]]] = {}
    for spec in all_nodes():
        config = load(spec.config, for_node(values, spec.name), spec.name)
        about = infos(type(config))
        known[spec.name] = {key: (value, about[key]) for key, value in flatten(config).items()}
    return known  # type: ignore[return-value]
