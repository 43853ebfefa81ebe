"""Rays of a sensor, through the world and other robots, many from one position at once."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numba import njit
from numpy.typing import NDArray

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_sim.model.geometry.shapes import Group

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_SPHERE = int(mujoco.mjtGeom.mjGEOM_SPHERE)
_ELLIPSOID = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)  # as robots' tyres are
_CYLINDER = int(mujoco.mjtGeom.mjGEOM_CYLINDER)
_BOX = int(mujoco.mjtGeom.mjGEOM_BOX)
SOLIDS = (_PLANE, _SPHERE, _ELLIPSOID, _CYLINDER, _BOX)
"""MuJoCo's kinds of geoms that `cast` knows."""

_LEAST = 1e-15  # of a ray along an axis, for it not to be parallel
_MISS = np.inf

Triple = tuple[float, float, float]
_inlined = njit(cache=True, error_model="numpy", forceinline=True)  # a call costs half a test


@njit(cache=True, error_model="numpy")
def cast(
    origin: Floats,
    rays: Floats,
    least: float,
    reach: float,
    seen: Ints,
    kinds: NDArray[np.int32],
    sizes: Floats,
    bounds: Floats,
    positions: Floats,
    rotations: Floats,
    ranges: Floats,
) -> None:
    """Find how far rays go, to the last bit as MuJoCo's `mj_multiRay` does.

    Args:
        origin: Where all begin, `(3,) float64` [m].
        rays: Unit vectors, `(N, 3) float64`.
        least: What a ray meets nearer than this it passes through [m].
        reach: What is further away as a whole is not seen [m].
        seen: Which geoms count, each of one of the `SOLIDS`, `(S,) int64`.
        kinds: MuJoCo's `geom_type`, `(G,) int32`.
        sizes: `geom_size`, `(G, 3) float64` [m].
        bounds: `geom_rbound`, `(G,) float64` [m]; that of a plane is not read.
        positions: `geom_xpos`, `(G, 3) float64` [m].
        rotations: `geom_xmat`, `(G, 9) float64`.
        ranges: Filled in, inf where nothing is hit, `(N,) float64` [m].
    """
    ranges[:] = np.inf
    for g in seen:
        kind, turned = kinds[g], rotations[g]
        x, y, z = (
            positions[g, 0] - origin[0],
            positions[g, 1] - origin[1],
            positions[g, 2] - origin[2],
        )
        bound = np.inf if kind == _PLANE else bounds[g]
        apart = x * x + y * y + z * z
        if math.sqrt(apart) > reach + bound:
            continue
        outside = apart - bound * bound
        # By rounding a ray may pass a sphere and yet touch what is in it.
        cone = (1.0 - 1e-9) * math.sqrt(outside) if outside > 0.0 else -np.inf
        size = sizes[g, 0], sizes[g, 1], sizes[g, 2]
        start = _turned(turned, -x, -y, -z)
        for k in range(len(rays)):
            a, b, c = rays[k, 0], rays[k, 1], rays[k, 2]
            along = x * a + y * b + z * c
            if along < cone or along - bound > ranges[k]:
                continue
            direction = _turned(turned, a, b, c)
            distance = _distance(kind, size, start, direction)
            if least <= distance < ranges[k]:
                ranges[k] = distance


@_inlined
def _turned(rotation: Floats, x: float, y: float, z: float) -> Triple:
    """Return a vector in the frame of a rotation, row by row `(9,) float64`."""
    return (
        rotation[0] * x + rotation[3] * y + rotation[6] * z,
        rotation[1] * x + rotation[4] * y + rotation[7] * z,
        rotation[2] * x + rotation[5] * y + rotation[8] * z,
    )


@_inlined
def _distance(kind: int, size: Triple, start: Triple, direction: Triple) -> float:
    """Return how far it is to a solid from a point along a direction, both in its frame."""
    if kind == _BOX:
        return _to_faces(size, start, direction)
    if kind == _CYLINDER:
        ends = min(
            _to_end(size, start, direction, -size[1]), _to_end(size, start, direction, size[1])
        )
        mantle = _to_round(start[:2], direction[:2], size[0])
        is_between = abs(start[2] + mantle * direction[2]) <= size[1]
        return min(ends, mantle) if mantle < _MISS and is_between else ends
    if kind == _SPHERE:
        return _to_round(start, direction, size[0])
    if kind == _ELLIPSOID:
        return _to_ellipsoid(size, start, direction)
    return _to_plane(size, start, direction)


@_inlined
def _to_faces(size: Triple, start: Triple, direction: Triple) -> float:
    """Return the distance to the nearest of a box's faces: those turned to the ray, if outside."""
    nearest, x, y, z = _MISS, abs(start[0]), abs(start[1]), abs(start[2])
    side = 1.0 if x <= size[0] and y <= size[1] and z <= size[2] else -1.0
    for i, j, k in ((0, 1, 2), (1, 0, 2), (2, 0, 1)):
        gap = math.copysign(size[i], side * direction[i]) - start[i]
        if gap * direction[i] >= 0.0 and abs(direction[i]) > _LEAST:
            distance = gap / direction[i]
            if (
                distance < nearest
                and abs(start[j] + distance * direction[j]) <= size[j]
                and abs(start[k] + distance * direction[k]) <= size[k]
            ):
                nearest = distance
    return nearest


@_inlined
def _to_end(size: Triple, start: Triple, direction: Triple, height: float) -> float:
    if abs(direction[2]) <= _LEAST:
        return _MISS
    distance = (height - start[2]) / direction[2]
    x, y = start[0] + distance * direction[0], start[1] + distance * direction[1]
    return distance if distance >= 0.0 and x * x + y * y <= size[0] * size[0] else _MISS


@_inlined
def _to_round(start: tuple[float, ...], direction: tuple[float, ...], radius: float) -> float:
    a, b, c = 0.0, 0.0, 0.0
    for i in range(len(direction)):
        a += direction[i] * direction[i]
        b += direction[i] * start[i]
        c += start[i] * start[i]
    return _root(a, b, c - radius * radius)


@_inlined
def _to_ellipsoid(size: Triple, start: Triple, direction: Triple) -> float:
    a, b, c = 0.0, 0.0, 0.0
    for i in range(3):
        weight = 1.0 / (size[i] * size[i])
        a += weight * direction[i] * direction[i]
        b += weight * direction[i] * start[i]
        c += weight * start[i] * start[i]
    return _root(a, b, c - 1.0)


@_inlined
def _root(a: float, b: float, c: float) -> float:
    """Return the least x of `a x^2 + 2 b x + c = 0` that is not below 0."""
    within = b * b - a * c
    if within < _LEAST:
        return _MISS
    root = math.sqrt(within)
    near, far = (-b - root) / a, (-b + root) / a
    if near >= 0.0:
        return near
    return far if far >= 0.0 else _MISS


@_inlined
def _to_plane(size: Triple, start: Triple, direction: Triple) -> float:
    """Return the distance to a plane's upper side, within its sides where it has any."""
    if direction[2] > -_LEAST:
        return _MISS
    distance = -start[2] / direction[2]
    x, y = start[0] + distance * direction[0], start[1] + distance * direction[1]
    is_inside = (size[0] <= 0.0 or abs(x) <= size[0]) and (size[1] <= 0.0 or abs(y) <= size[1])
    return distance if distance >= 0.0 and is_inside else _MISS


class Rays:
    """Casts rays of a sensor, which sees the world and other robots but not its own.

    Those of a sensor of the world begin at its least range, as in Gazebo: it may sit in a housing.

    Args:
        rendered: Whether it sees what is drawn, as Gazebo's `gpu_` sensors; else what is solid.
    """

    def __init__(self, model: Any, site: str, rendered: bool = False) -> None:
        self._name = site
        self._world, self._robot = (
            (Group.WORLD_VISUAL, Group.ROBOT_VISUAL)
            if rendered
            else (Group.WORLD_COLLISION, Group.ROBOT_COLLISION)
        )
        self._mask = np.array([i == self._world.value for i in range(6)], np.uint8)
        self._hits = np.zeros((0, 1), np.int32)
        self.rebind(model)

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._model = model
        self.site = int(model.site(self._name).id)
        own = model.body_rootid[model.site_bodyid[self.site]]
        is_world = model.geom_group == self._world.value
        is_robot = model.geom_group == self._robot.value
        is_own = model.body_rootid[model.geom_bodyid] == own
        self._is_of_world = not (is_robot & is_own).any()
        others = is_robot & ~is_own
        self._others = np.flatnonzero(others)
        self._seen = np.flatnonzero((others | is_world) & _is_opaque(model))
        self._are_solids = bool(np.isin(model.geom_type[self._seen], SOLIDS).all())

    def cast(self, data: Any, origin: Floats, rays: Floats, least: float, reach: float) -> Floats:
        """Return exact distances from one point along unit vectors, inf where nothing is hit [m].

        Args:
            data: The `mujoco.MjData`, with positions up to date.
            origin: The point, `(3,) float64` [m].
            rays: The unit vectors, `(N, 3) float64`.
            least: The sensor's least range [m].
            reach: How far they go [m].
        """
        least = least if self._is_of_world else 0.0
        if not self._are_solids:
            ranges = self._cast_at_meshes(data, origin, rays, reach)
            for k in np.flatnonzero(ranges < least):
                begin, ray = origin + least * rays[k], rays[k : k + 1]
                ranges[k] = least + self._cast_at_meshes(data, begin, ray, reach)[0]
            return ranges
        model, ranges = self._model, np.empty(len(rays))
        kinds, sizes, bounds = model.geom_type, model.geom_size, model.geom_rbound
        positions, rotations = data.geom_xpos, data.geom_xmat
        shapes = self._seen, kinds, sizes, bounds, positions, rotations
        cast(origin, rays, least, reach, *shapes, ranges)
        return ranges

    def _cast_at_meshes(self, data: Any, origin: Floats, rays: Floats, reach: float) -> Floats:
        """Let MuJoCo cast, which knows meshes and terrain."""
        if len(self._hits) != len(rays):
            self._hits = np.zeros((len(rays), 1), np.int32)
        groups, others = self._model.geom_group, self._others
        groups[others] = self._world.value  # which rays see
        ranges = np.empty(len(rays))
        mujoco.mj_multiRay(
            self._model,
            data,
            np.ascontiguousarray(origin).reshape(3, 1),
            np.ascontiguousarray(rays).reshape(-1, 1),
            self._mask,
            True,
            -1,
            self._hits,
            ranges.reshape(-1, 1),
            None,
            len(rays),
            reach,
        )
        groups[others] = self._robot.value
        ranges[ranges < 0.0] = np.inf
        return ranges


def _is_opaque(model: Any) -> Bools:
    """Return which geoms are not wholly transparent: those that are MuJoCo's rays pass through."""
    material, alpha = model.geom_matid, model.geom_rgba[:, 3].copy()
    has_material = material >= 0
    alpha[has_material] = model.mat_rgba[material[has_material], 3]
    return np.asarray(alpha != 0.0)
