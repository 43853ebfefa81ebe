"""Which entities a client means: by name, category, tags or place."""

from __future__ import annotations

from typing import Any

import numpy as np
import re2
from numpy.typing import NDArray
from simulation_interfaces.msg import Bounds, EntityInfo, Result, TagsFilter

from arjuna_sim.model.entities import Entity
from arjuna_sim.nodes.messages import pose3_from_msg
from arjuna_sim.nodes.services.results import RequestError

_SHOWN = 80  # characters of a refused expression


def matching(found: list[tuple[Entity, EntityInfo, Any]], filters: Any) -> list[Entity]:
    """Return the entities that pass all of an EntityFilters message, in their order.

    Args:
        found: Each entity with its description and its pose in the world.
        filters: The message; what is empty does not restrict.

    Raises:
        RequestError: The pattern is no regular expression, or the bounds cannot be used.
    """
    name = _pattern(filters.filter)
    categories = {item.category for item in filters.categories}
    inside = _space(filters.bounds)
    return [
        entity
        for entity, info, pose in found
        if name.search(entity.name)
        and (not categories or info.category.category in categories)
        and _tagged(info.tags, filters.tags)
        and (inside is None or _overlaps(inside, entity.corners(pose3_from_msg(pose))))
    ]


def _pattern(text: str) -> Any:
    """Return an expression, which RE2 searches in time linear in the text, whatever it is."""
    options = re2.Options()
    options.log_errors = False
    try:
        return re2.compile(text, options)
    except re2.error as error:
        reason = error.args[0].decode("utf-8", "replace")[:_SHOWN]
        problem = f"the filter '{text[:_SHOWN]}' is no regular expression of RE2: {reason}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem) from error


def _tagged(tags: list[str], wanted: TagsFilter) -> bool:
    if not wanted.tags:
        return True
    held = [tag in tags for tag in wanted.tags]
    return all(held) if wanted.filter_mode == TagsFilter.FILTER_MODE_ALL else any(held)


def _space(bounds: Bounds) -> tuple[int, NDArray[np.float64]] | None:
    """Return a filter's box or sphere; None where it does not restrict."""
    if bounds.type == Bounds.TYPE_EMPTY:
        return None
    if bounds.type not in (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE):
        problem = f"bounds of type {bounds.type} are not supported; valid: 1 (box), 3 (sphere)"
        raise RequestError(Result.RESULT_FEATURE_UNSUPPORTED, problem)
    points = np.array([[p.x, p.y, p.z] for p in bounds.points]).reshape(-1, 3)
    if len(points) != 2 or not np.isfinite(points).all():
        problem = f"bounds of a box or sphere need 2 finite points, got {len(points)}"
        raise RequestError(Result.RESULT_OPERATION_FAILED, problem)
    return bounds.type, points


def _overlaps(space: tuple[int, NDArray[np.float64]], corners: NDArray[np.float64]) -> bool:
    """Tell whether a box or sphere meets the upright box around corners."""
    kind, (first, second) = space
    low, high = corners.min(axis=0), corners.max(axis=0)
    if kind == Bounds.TYPE_SPHERE:
        nearest = np.clip(first, low, high)
        return bool(np.linalg.norm(nearest - first) <= second[0])
    least, greatest = np.minimum(first, second), np.maximum(first, second)
    return bool((low <= greatest).all() and (high >= least).all())
