"""Draws the meshes of urdf/fusion_description: `python -m scripts.fusion_meshes [FOLDER]`.

Binary STL in millimetres and in the coordinates of the whole robot, as Fusion 360 exports them.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from trimesh import Trimesh
from trimesh.creation import box, cylinder, revolve
from trimesh.transformations import rotation_matrix

FOLDER = Path(__file__).resolve().parents[1] / "urdf" / "fusion_description" / "meshes"


def wheel(y: float) -> Trimesh:
    """Return a wheel of 241 mm with a crowned tread, whose middle is at y [mm]."""
    tread = ((119.0, -25.0), (120.2, -12.0), (120.5, 0.0), (120.2, 12.0), (119.0, 25.0))
    mesh: Trimesh = revolve([(0.0, -25.0), *tread, (0.0, 25.0)], sections=64)
    mesh.apply_transform(rotation_matrix(math.pi / 2.0, (1.0, 0.0, 0.0)))
    mesh.apply_translation((0.0, y, 120.5))
    return mesh


def ball(x: float) -> Trimesh:
    """Return a ball of 80 mm that stands 2 mm above the ground, its middle at x [mm]."""
    ups = (math.pi * (k / 8 - 0.5) for k in range(9))
    mesh: Trimesh = revolve([(40.0 * math.cos(u), 40.0 * math.sin(u)) for u in ups], sections=16)
    mesh.apply_translation((x, 0.0, 42.0))
    return mesh


def bodies() -> dict[str, Trimesh]:
    """Return every mesh by its name."""
    return {
        "base_link": box((600.0, 470.0, 120.0)).apply_translation((0.0, 0.0, 140.0)),
        "left_wheel_1": wheel(269.0),
        "right_wheel_1": wheel(-269.0),
        "front_caster_1": ball(240.0),
        "rear_caster_1": ball(-240.0),
        "lidar_1": cylinder(35.0, 60.0, sections=24).apply_translation((250.0, 0.0, 230.0)),
    }


def write(folder: Path) -> None:
    """Write every mesh into a folder."""
    for name, mesh in bodies().items():
        mesh.export(folder / f"{name}.stl")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
