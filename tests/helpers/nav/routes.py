"""A route graph that tests write: the corners of a square, and a path round on either side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

SQUARE = {0: (0.0, 0.0), 1: (4.0, 0.0), 2: (4.0, 4.0), 3: (0.0, 4.0)}


def square() -> dict[str, Any]:
    """Return the graph as GeoJSON: 0-1-2, where 0-1 is slow and 1-2 cheap, and 0-3-2."""
    nodes = [
        {
            "type": "Feature",
            "properties": {"id": k, "frame": "map"},
            "geometry": {"type": "Point", "coordinates": list(point)},
        }
        for k, point in SQUARE.items()
    ]
    ends = [(0, 1), (1, 2), (2, 1), (0, 3), (3, 2)]
    more: list[dict[str, Any]] = [{} for _ in ends]
    more[0] = {"metadata": {"speed_limit": 0.5, "penalty": 1.0}}
    more[1] = {"cost": 0.25, "overridable": False}
    edges = [
        {
            "type": "Feature",
            "properties": {"id": k, "startid": a, "endid": b, **more[k]},
            "geometry": {"type": "MultiLineString", "coordinates": [[SQUARE[a], SQUARE[b]]]},
        }
        for k, (a, b) in enumerate(ends)
    ]
    return {"type": "FeatureCollection", "features": [*nodes, *edges]}


def written(folder: Path, content: dict[str, Any] | None = None) -> Path:
    """Write a graph, the square where none is given, and return the file."""
    path = folder / "graph.geojson"
    path.write_text(json.dumps(square() if content is None else content), encoding="utf-8")
    return path
