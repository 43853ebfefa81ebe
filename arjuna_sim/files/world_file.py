"""The files that a world can come from: SDF, or the map of a place."""

from __future__ import annotations

from pathlib import Path

from arjuna_core.errors import RobotError, WorldError
from arjuna_core.files.whole_file import read_bytes
from arjuna_sim.files.map_world import MAP_SUFFIXES, load_map_world
from arjuna_sim.files.sdf.world import read_world
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.urdf.xacro_file import expand, has_macros
from arjuna_sim.files.xml_file import BYTES_MAX, XmlFile
from arjuna_sim.model.world import World


def load_world(path: str | Path, search: SearchPath | None = None) -> World:
    """Read a world from an SDF file, which may have xacro macros, or from a map's YAML.

    Args:
        path: The file.
        search: Where to look for what it refers to; the environment's folders if None.

    Raises:
        WorldError: The file cannot be read, or holds values or models that cannot be simulated.
    """
    path = Path(path)
    if path.suffix in MAP_SUFFIXES:
        return load_map_world(path)
    text = read_bytes(path, BYTES_MAX, WorldError)
    search = SearchPath.of() if search is None else search
    if not has_macros(path, text):
        return read_world(XmlFile(path, "sdf", WorldError, text, search))
    try:
        expanded = expand(path, search, {})
    except RobotError as error:
        raise WorldError(error.path, error.problem, error.place) from error
    xml = XmlFile(path, "sdf", WorldError, expanded.text, search)
    xml.keep(*expanded.notes)
    return read_world(xml)
