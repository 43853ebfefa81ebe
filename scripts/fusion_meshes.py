"""Draws the meshes of urdf/fusion_description: `python -m scripts.fusion_meshes [FOLDER]`.

Binary STL in millimetres and in the coordinates of the whole robot, as Fusion 360 exports them.
"""

from __future__ import annotations

import math
import struct
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "urdf" / "fusion_description" / "meshes"

Point = tuple[float, float, float]
Triangle = tuple[Point, Point, Point]


def ring(radius: float, at: float, sides: int = 64) -> list[Point]:
    """Return a circle around z at a height [mm]."""
    turns = [2.0 * math.pi * k / sides for k in range(sides)]
    return [(radius * math.cos(t), radius * math.sin(t), at) for t in turns]


def closed(rings: list[list[Point]]) -> Iterator[Triangle]:
    """Yield the faces of a body between rings of as many points each, lowest first, with lids."""
    for low, high in pairwise(rings):
        for k in range(len(low)):
            a, b, c, d = low[k - 1], low[k], high[k], high[k - 1]
            yield (a, b, c)
            yield (a, c, d)
    for ends, turned in ((rings[0], True), (rings[-1], False)):
        for a, b in pairwise(ends[1:]):
            yield (ends[0], b, a) if turned else (ends[0], a, b)


def plate(x: float, y: float, low: float, high: float) -> Iterator[Triangle]:
    """Yield a box of half-lengths x and y [mm]."""
    corners = ((x, y), (-x, y), (-x, -y), (x, -y))
    return closed([[(a, b, z) for a, b in corners] for z in (low, high)])


def ball(radius: float, sides: int = 16) -> Iterator[Triangle]:
    """Yield a sphere [mm]."""
    ups = [math.pi * (k / 8 - 0.5) for k in range(9)]
    rings = [(max(math.cos(u), 1e-3), math.sin(u)) for u in ups]  # its poles are tiny lids
    return closed([ring(radius * wide, radius * up, sides) for wide, up in rings])


def moved(faces: Iterator[Triangle], x: float, y: float, z: float) -> list[Triangle]:
    """Shift faces [mm]."""

    def shifted(p: Point) -> Point:
        return (p[0] + x, p[1] + y, p[2] + z)

    return [(shifted(a), shifted(b), shifted(c)) for a, b, c in faces]


def upright(faces: Iterator[Triangle]) -> Iterator[Triangle]:
    """Turn faces a quarter about x, so that what lay along z lies along y."""

    def turned(p: Point) -> Point:
        return (p[0], -p[2], p[1])

    return ((turned(a), turned(b), turned(c)) for a, b, c in faces)


def wheel(y: float) -> list[Triangle]:
    """Return a wheel of 241 mm with a crowned tread, whose middle is at y [mm]."""
    tread = ((119.0, -25.0), (120.2, -12.0), (120.5, 0.0), (120.2, 12.0), (119.0, 25.0))
    return moved(upright(closed([ring(r, at) for r, at in tread])), 0.0, y, 120.5)


def bodies() -> dict[str, list[Triangle]]:
    """Return every mesh by its name."""
    return {
        "base_link": moved(plate(300.0, 235.0, 0.0, 120.0), 0.0, 0.0, 80.0),
        "left_wheel_1": wheel(269.0),
        "right_wheel_1": wheel(-269.0),
        "front_caster_1": moved(ball(40.0), 240.0, 0.0, 42.0),
        "rear_caster_1": moved(ball(40.0), -240.0, 0.0, 42.0),
        "lidar_1": moved(closed([ring(35.0, 0.0, 24), ring(35.0, 60.0, 24)]), 250.0, 0.0, 200.0),
    }


def stl(name: str, faces: list[Triangle]) -> bytes:
    """Return faces as a binary STL file."""
    parts = [name.encode().ljust(80, b"\0"), struct.pack("<I", len(faces))]
    for a, b, c in faces:
        u, v = ([q - p for p, q in zip(a, end, strict=True)] for end in (b, c))
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        length = math.hypot(*normal) or 1.0
        parts.append(struct.pack("<12fH", *(n / length for n in normal), *a, *b, *c, 0))
    return b"".join(parts)


def write(folder: Path) -> None:
    """Write every mesh into a folder."""
    for name, faces in bodies().items():
        (folder / f"{name}.stl").write_bytes(stl(name, faces))


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
