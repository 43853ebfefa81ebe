"""A generator of SDF worlds whose truth is known: nested, included, scaled and broken pieces."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3

MISSING, FLAT, BROKEN = "missing", "flat", "broken"
DEPTH_MAX = 4


@dataclass
class WorldCase:
    """A world that was written, and what a reader must find in it.

    Attributes:
        path: The world's file.
        positions: Where the centre of each solid box is, by its edge length [m].
        left_out: Names that notes must have.
    """

    path: Path
    positions: dict[float, NDArray[np.float64]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)


class WorldMaker:
    """Writes a world of random models; each solid box is known by a size that no other has.

    Args:
        folder: Where the world and its models go.
        seed: Of all that is random.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self._folder = folder
        self._rng = np.random.default_rng(seed)
        self._count = 0
        self.case = WorldCase(folder / "worlds" / "made.world")

    def make(self, models: int) -> WorldCase:
        """Write a world of some models, each nested up to four deep."""
        inside = "".join(self._model(f"top_{i}", ORIGIN, 0) for i in range(models))
        text = f"<sdf version='1.9'><world name='made'>{inside}</world></sdf>"
        self.case.path.parent.mkdir(parents=True, exist_ok=True)
        self.case.path.write_text(text, encoding="utf-8")
        return self.case

    def _pose(self) -> Pose3:
        xyz, rpy = self._rng.uniform(-3, 3, 3), self._rng.uniform(-3, 3, 3)
        return Pose3.from_rpy(tuple(xyz.tolist()), tuple(rpy.tolist()))

    def _model(self, name: str, T_parent: Pose3, depth: int, merged: bool = False) -> str:
        """Return a model, wrapped, nested or included."""
        pose, frame = self._pose(), self._pose()
        by_frame = self._rng.random() < 0.3
        T_world = T_parent @ frame @ pose if by_frame else T_parent @ pose
        tag = _text(pose, relative_to=f"{name}_frame" if by_frame else "")
        around = f"<frame name='{name}_frame'>{_text(frame)}</frame>" if by_frame else ""
        kind = str(self._rng.choice(["plain", "included", "wrapped", "merged"]))
        if kind == "plain" or depth >= DEPTH_MAX:
            inside = self._inside(T_world, depth)
            return f"{around}<model name='{name}'><static>1</static>{tag}{inside}</model>"
        uri = self._file(T_world, depth)
        if kind == "included":
            return f"{around}<include><uri>{uri}</uri><name>{name}</name>{tag}</include>"
        attribute = " merge='true'" if kind == "merged" else ""
        wrapped = f"<include{attribute}><uri>{uri}</uri><pose>0 0 0 0 0 0</pose></include>"
        return f"{around}<model name='{name}'>{tag}{wrapped}</model>"

    def _file(self, T_world: Pose3, depth: int) -> str:
        """Write a model of its own, static by itself; return one of the URIs that lead to it."""
        self._count += 1
        name = f"made_{self._count}"
        folder = self._folder / "models" / name
        folder.mkdir(parents=True)
        inside = self._inside(T_world, depth)
        text = f"<model name='{name}'><static>true</static>{inside}</model>"
        (folder / "model.sdf").write_text(f"<sdf version='1.7'>{text}</sdf>", encoding="utf-8")
        forms = (f"model://{name}", f"file://models/{name}", f"model://{name}/model.sdf", name)
        return str(self._rng.choice(forms))

    def _inside(self, T_world: Pose3, depth: int) -> str:
        """Return a link with a box, perhaps a broken piece, and perhaps a model within."""
        pose, own = self._pose(), self._pose()
        edge = round(0.1 + 1e-3 * len(self.case.positions), 6)
        self.case.positions[edge] = np.array((T_world @ pose @ own).position)
        box = f"<geometry><box><size>{edge} {edge} {edge}</size></box></geometry>"
        parts = f"<collision name='c'>{_text(own)}{box}</collision>"
        if self._rng.random() < 0.3:
            parts += self._broken()
        inner = ""
        if depth < DEPTH_MAX and self._rng.random() < 0.7:
            inner = self._model(f"m{depth + 1}", T_world, depth + 1)
        return f"<link name='l'>{_text(pose)}{parts}</link>{inner}"

    def _broken(self) -> str:
        """Return a collision that must be left out, with a note that names it."""
        self._count += 1
        kind = str(self._rng.choice([MISSING, FLAT, BROKEN]))
        name = f"{kind}_{self._count}.stl"
        folder = self._folder / "models" / "meshes"
        folder.mkdir(parents=True, exist_ok=True)
        if kind == BROKEN:
            (folder / name).write_text("solid nothing", encoding="utf-8")
        elif kind == FLAT:
            write_stl(folder / name, np.ones((1, 3, 3)))
        self.case.left_out.append(name)
        uri = f"<mesh><uri>model://meshes/{name}</uri></mesh>"
        return f"<collision name='b'><geometry>{uri}</geometry></collision>"


def _text(pose: Pose3, relative_to: str = "") -> str:
    numbers = " ".join(repr(value) for value in (*pose.position, *pose.rpy()))
    attribute = f" relative_to='{relative_to}'" if relative_to else ""
    return f"<pose{attribute}>{numbers}</pose>"


def stl(triangles: NDArray[np.float64]) -> bytes:
    """Return triangles `(N, 3, 3)` [m] as binary STL."""
    face = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    faces = np.zeros(len(triangles), face)
    faces["corners"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + bytes(faces.tobytes())


def write_stl(path: Path, triangles: NDArray[np.float64]) -> None:
    """Write triangles `(N, 3, 3)` [m] as binary STL."""
    path.write_bytes(stl(triangles))
