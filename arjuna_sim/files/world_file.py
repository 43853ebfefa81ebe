"""The files that a world can come from: SDF, or the map of a place."""

from __future__ import annotations

from pathlib import Path

from arjuna_sim.files.map_world import MAP_SUFFIXES, load_map_world
from arjuna_sim.files.sdf.sdf import World
from arjuna_sim.files.sdf.sdf import load_world as load_sdf
from arjuna_sim.files.search_path import SearchPath


def load_world(path: str | Path, search: SearchPath | None = None) -> World:
    """Read a world from an SDF file, or from a map's YAML.

    Args:
        path: The file.
        search: Where to look for what it refers to; the environment's folders if None.

    Raises:
        WorldError: The file cannot be read or simulated.
    """
    return load_map_world(path) if Path(path).suffix in MAP_SUFFIXES else load_sdf(path, search)
