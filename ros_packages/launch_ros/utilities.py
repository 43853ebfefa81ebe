"""Functions for those who look into launch files: what parameters and names come to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launch.launch_context import LaunchContext

from launch_ros.parameter_descriptions import evaluated, normalize_parameters

__all__ = ["evaluate_parameters", "normalize_parameters"]


def evaluate_parameters(context: LaunchContext, parameters: Iterable[Any]) -> tuple[Any, ...]:
    """Return parameters that were normalized: paths of files, and values by name."""
    found = [evaluated(context, one) for one in parameters]
    return tuple(
        {name: tuple(v) if isinstance(v, list) else v for name, v in one.items()}
        if isinstance(one, dict)
        else one
        for one in found
    )
