"""A file of lattice primitives that tests write."""

from __future__ import annotations

import json
import math
from pathlib import Path


def written(folder: Path, **about: object) -> Path:
    """Write a file of a robot that drives straight and turns by quarters, and return it."""
    quarter = math.pi / 2
    straight = [
        [[0.1 * k * math.cos(i * quarter), 0.1 * k * math.sin(i * quarter), i * quarter]
         for k in range(3)]
        for i in range(4)
    ]  # fmt: skip
    ahead = [{"start_angle_index": i, "end_angle_index": i, "poses": straight[i]} for i in range(4)]
    turns = [
        {
            "start_angle_index": i,
            "end_angle_index": (i + 1) % 4,
            "poses": [[0, 0, (i + 1) * quarter]],
        }
        for i in range(4)
    ]
    content = {
        "lattice_metadata": {
            "motion_model": "diff",
            "turning_radius": 0.4,
            "heading_angles": [i * quarter for i in range(4)],
            **about,
        },
        "primitives": [
            {**one, "trajectory_radius": 0.0, "left_turn": True} for one in (*ahead, *turns)
        ],
    }
    path = folder / "lattice.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path
