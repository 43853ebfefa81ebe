"""The robot's model in rerun: each link's looks in the link's frame, so that TF moves it."""

from __future__ import annotations

import rerun as rr

from bringup.viewing.drawing.looks import FindMesh, LooksError, read
from bringup.viewing.rerun.stream import Stream


def log_robot(stream: Stream, description: str, find_mesh: FindMesh) -> tuple[str, ...]:
    """Show a robot.

    Args:
        stream: Where to.
        description: The URDF's text.
        find_mesh: Finds its meshes.

    Returns:
        Notes on what is not drawn.
    """
    try:
        looks = read(description, find_mesh)
    except LooksError as error:
        return (str(error),)
    for link, glb in looks.glbs.items():
        stream.place(f"robot/{link}", link)
        stream.always(f"robot/{link}", rr.Asset3D(contents=glb, media_type=rr.MediaType.GLB))
    return looks.notes
