"""The files that a world can come from: SDF, or the map of a place."""

from __future__ import annotations

from pathlib import Path

from arjuna_core.errors import WorldError
from arjuna_sim.files.map_world import MAP_SUFFIXES, load_map_world
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.world import World


def load_world(path: str | Path, search: SearchPath | None = None) -> World:
    """Read a world from an SDF file, or from a map's YAML.

    Args:
        path: The file.
        search: Where to look for what it refers to; the environment's folders if None.

    Raises:
        WorldError: The file cannot be read, or holds values or models that cannot be simulated.
    """
    path = Path(path)
    if path.suffix in MAP_SUFFIXES:
        return load_map_world(path)
    return read_world(XmlFile(path, "sdf", WorldError, search=search))
