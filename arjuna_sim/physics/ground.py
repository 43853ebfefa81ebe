"""The ground of a world: at which heights something stands, and which of them people walk on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np

from arjuna_core.arrays import Floats, Ints
from arjuna_sim.model.geometry.shapes import Group
from arjuna_sim.model.geometry.thickness import numbered

RISE_MAX = 0.7
"""Steepest slope of a ground, as a robot is put on: 35 degrees."""
_WIDE, _LEVEL = 1.0, 0.05  # a floor is as high in most directions this far away [m]
_HEADROOM = 0.5  # over what is walked on; less is below a floor, or a shelf [m]
_REACH, _CELL = 3.2, 0.2  # how far around and how densely the ground is surveyed [m]
_KEPT = 4096  # columns that are remembered: a survey has 1089
_SOLID = (Group.WORLD_COLLISION.value, Group.WORLD_CONTACT.value)


class Column(NamedTuple):
    """Surfaces above one another at a point.

    Attributes:
        floors: Heights of what something can stand on, rising [m].
        headroom: Above each of them [m].
        base: Height of a plane or terrain, below which all is solid; None where there is none [m].
        tops: Where anything begins, covered or not [m].
    """

    floors: tuple[float, ...]
    headroom: tuple[float, ...]
    base: float | None
    tops: tuple[float, ...]

    @property
    def walked(self) -> float:
        """Height of the floor with head-room that is nearest to 0; NaN where there is none [m]."""
        high = zip(self.floors, self.headroom, strict=True)
        walked = [floor for floor, room in high if room >= _HEADROOM]
        return min(walked, key=abs, default=np.nan)

    def nearest(self, height: float) -> float:
        """Return the floor nearest to a height; NaN where there is none [m]."""
        return min(self.floors, key=lambda floor: abs(floor - height), default=np.nan)


@dataclass(frozen=True)
class Survey:
    """The ground around a point: the largest area that is walked on without a step.

    Attributes:
        points: Where it was found, `(N, 3) float64` [m].
    """

    points: Floats

    def height(self, x: float, y: float) -> float:
        """Return the ground's height where it is nearest to a point; NaN where there is none."""
        if not len(self.points):
            return float("nan")
        away = np.hypot(self.points[:, 0] - x, self.points[:, 1] - y)
        return float(self.points[int(away.argmin()), 2])


class Ground:
    """Finds by rays the ground that robots touch, as all stands now.

    Args:
        model: A `mujoco.MjModel`.
        data: Its `mujoco.MjData`.
        fixed: Whether only the world counts, not the entities in it.
        before: What was found then holds as long as nothing else stands elsewhere.
    """

    def __init__(
        self, model: Any, data: Any, fixed: bool = False, before: Ground | None = None
    ) -> None:
        self._model, self._data = model, data
        self._surveys: dict[tuple[int, int], Survey] = {}
        mujoco.mj_kinematics(model, data)
        solid = np.isin(model.geom_group, _SOLID) & (model.geom_contype > 0)
        solid &= (model.geom_bodyid == 0) | (not fixed)
        is_plane = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        self._planes = np.flatnonzero(solid & is_plane)
        self._geoms = np.flatnonzero(solid & ~is_plane)
        turned = data.geom_xmat[self._geoms].reshape(-1, 3, 3)
        box = model.geom_aabb[self._geoms]
        middle = data.geom_xpos[self._geoms] + (turned @ box[:, :3, None])[:, :, 0]
        half = (np.abs(turned) @ box[:, 3:, None])[:, :, 0]
        self._low, self._high = middle - half, middle + half
        self._spans = np.column_stack((self._low[:, 2], self._high[:, 2])).tolist()
        every = np.append(self._planes, self._geoms)
        self._placed = np.column_stack((every, data.geom_xpos[every], data.geom_xmat[every]))
        self._columns: dict[tuple[float, float], Column] = {}
        is_same = before is not None and before._model is model
        if before is not None and is_same and np.array_equal(before._placed, self._placed):
            self._columns = before._columns

    @property
    def is_level(self) -> bool:
        """True where no terrain is there."""
        return bool(self._model.nhfield == 0)

    def stood_on(self, x: float, y: float) -> float:
        """Return the height at which people stand at a point: of the ground, or a floor on it."""
        return max(self.levels(x, y))

    def column(self, x: float, y: float) -> Column:
        """Return what is above one another at a point."""
        found = self._columns.get((x, y))
        if found is None:
            if len(self._columns) == _KEPT:
                self._columns.clear()
            found = self._columns[x, y] = self._column(x, y)
        return found

    def _column(self, x: float, y: float) -> Column:
        point = np.array([x, y])
        is_here = ((self._low[:, :2] <= point) & (point <= self._high[:, :2])).all(axis=1)
        solids = [
            self._solid(int(self._geoms[i]), x, y, *self._spans[i]) for i in np.flatnonzero(is_here)
        ]
        plane = self._plane(x, y)
        solids = [(top, low) for top, low in (*solids, (plane, -np.inf)) if np.isfinite(top)]
        floors, above = [], np.inf
        for top, low in sorted(solids, reverse=True):
            # Pieces of one solid meet with a gap of up to 5 mm.
            if above - top > 5e-3:
                floors.append((round(top, 6), above - top))
            above = min(above, low)
        base = max((top for top, low in solids if low == -np.inf), default=None)
        return Column(
            tuple(floor for floor, _ in floors[::-1]),
            tuple(room for _, room in floors[::-1]),
            None if base is None else round(base, 6),
            tuple(top for top, _ in solids),
        )

    def _solid(self, geom: int, x: float, y: float, low: float, high: float) -> tuple[float, float]:
        """Return the top and the bottom of a convex geom or a terrain; NaN where it is beside."""
        model, data = self._model, self._data
        ends = []
        for start, direction in ((high + 1.0, -1.0), (low - 1.0, 1.0)):
            ray = np.array([x, y, start]), np.array([0.0, 0.0, direction])
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_HFIELD:
                distance = mujoco.mj_rayHfield(model, data, geom, *ray)
                return (start - distance if distance >= 0.0 else np.nan), -np.inf
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
                distance = mujoco.mj_rayMesh(model, data, geom, *ray)
            else:
                pose = data.geom_xpos[geom], data.geom_xmat[geom], model.geom_size[geom]
                distance = mujoco.mju_rayGeom(*pose, *ray, model.geom_type[geom])
            ends.append(start + direction * distance if distance >= 0.0 else np.nan)
        return ends[0], ends[1]

    def _plane(self, x: float, y: float) -> float:
        """Return the height of the highest plane at a point; -inf where there is none [m]."""
        data = self._data
        normals = data.geom_xmat[self._planes][:, [2, 5, 8]]
        away = data.geom_xpos[self._planes] - (x, y, 0.0)
        up = normals[:, 2] > 0.1
        with np.errstate(invalid="ignore"):  # a robot that is lost may be anywhere
            slant = (normals[up, :2] * away[up, :2]).sum(axis=1) / normals[up, 2]
        heights = away[up, 2] + slant
        return float(heights.max(initial=-np.inf))

    def height(self, x: float, y: float, survey: Survey | None = None) -> float:
        """Return the height of the ground at a point, or of that nearest to it if it is covered.

        Args:
            survey: Of the ground around; made or used again where it is needed if None.
        """
        if not np.isfinite((x, y)).all():  # of a robot that is lost
            return 0.0
        column = self.column(x, y)
        if column.base is not None and column.headroom[0] >= _HEADROOM:
            return column.base
        near = (survey or self._survey_near(x, y)).height(x, y)
        if np.isnan(near):
            return 0.0
        here = column.nearest(near)
        return here if abs(here - near) <= _LEVEL + RISE_MAX * _CELL else near

    def _survey_near(self, x: float, y: float) -> Survey:
        center = round(x / (_REACH / 2)), round(y / (_REACH / 2))
        if center not in self._surveys:
            self._surveys[center] = self.survey(x, y)
        return self._surveys[center]

    def survey(self, x: float, y: float) -> Survey:
        """Find the ground around a point."""
        steps = np.arange(-_REACH, _REACH + _CELL / 2, _CELL)
        heights = np.array([[self.column(x + i, y + j).walked for j in steps] for i in steps])
        index = np.arange(heights.size).reshape(heights.shape)
        pairs = np.concatenate([_joined(heights, index), _joined(heights.T, index.T)])
        area = numbered(pairs, heights.size)
        is_there = np.isfinite(heights.ravel())
        sizes = np.bincount(area, weights=is_there)
        chosen = is_there & (area == sizes.argmax())
        xs, ys = np.meshgrid(x + steps, y + steps, indexing="ij")
        return Survey(np.column_stack((xs.ravel(), ys.ravel(), heights.ravel()))[chosen])

    def levels(self, x: float, y: float, survey: Survey | None = None) -> Iterator[float]:
        """Yield the ground's height at a point, and those of floors that are laid on it [m]."""
        ground = self.height(x, y, survey)
        yield ground
        for level in self.column(x, y).floors:
            # What is higher is a storey or a roof.
            if ground < level < ground + 0.25 and self._is_floor(x, y, level):
                yield level

    def _is_floor(self, x: float, y: float, level: float) -> bool:
        """Return whether a surface extends around a point, rather than tops a box."""
        angles = np.arange(8) * np.pi / 4
        around = [self.column(x + _WIDE * np.cos(a), y + _WIDE * np.sin(a)) for a in angles]
        is_level = [any(abs(top - level) < _LEVEL for top in column.tops) for column in around]
        return sum(is_level) >= len(around) // 2


def _joined(heights: Floats, index: Ints) -> Ints:
    """Return pairs of cells along the first axis that lie level, or on one straight slope."""
    rise = np.diff(heights, axis=0)
    bend = np.full((len(rise) + 1, rise.shape[1]), np.inf)
    bend[1:-1] = np.abs(np.diff(rise, axis=0))
    straight = np.fmin(bend[:-1], bend[1:]) <= _LEVEL
    is_joined = (np.abs(rise) <= _LEVEL) | (straight & (np.abs(rise) <= RISE_MAX * _CELL))
    return np.column_stack((index[:-1][is_joined], index[1:][is_joined]))
