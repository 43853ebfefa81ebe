"""Where the meshes of a robot's description are."""

from __future__ import annotations

from pathlib import Path

from bringup.viewing.drawing.looks import FindMesh


def mesh_finder() -> FindMesh:
    """Return what finds meshes in the packages of the environment and below this folder."""
    from arjuna_sim.files.search_path import EscapeError, SearchPath

    def find(uri: str) -> Path | None:
        try:
            return SearchPath.of().find(Path.cwd() / "robot.urdf", uri)
        except EscapeError:
            return None

    return find
