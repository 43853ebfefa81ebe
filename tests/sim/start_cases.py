"""Worlds in which a start is asked for at random, often inside something; their true ground."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.sdf.solids import prism
from arjuna_sim.model.geometry.shapes import Kind, Mesh, Part, Shape, Terrain
from arjuna_sim.model.world import Body, World, ground_bodies

SIDE = 16.0
"""Of the ground [m]; starts are asked for on its inner 10 m."""
WORLDS = 20
GROUNDS = ("plane", "slab", "plate", "sheet", "terrain", "hill", "raised", "storeys", "platform")

Ground = Callable[[float, float], float]


@dataclass
class StartCase:
    """A world, the height of its ground at a point, and what stands in the way there.

    Attributes:
        things: Centre, and radius of the circle around it, of each thing that stands there.
    """

    ground: Ground
    bodies: list[Body] = field(default_factory=list)
    things: list[tuple[float, float, float]] = field(default_factory=list)

    @property
    def world(self) -> World:
        """What a reader would have returned."""
        return World(Path("starts.world"), "starts", tuple(self.bodies), ())

    def clearance(self, x: float, y: float) -> float:
        """Return the distance to the nearest thing's circle; negative inside it [m]."""
        return min(math.hypot(x - a, y - b) - r for a, b, r in self.things)

    def add(self, name: str, shape: Shape, pose: Pose3 = ORIGIN) -> None:
        """Put something solid there."""
        self.bodies.append(Body(name, Part(shape, pose), True))

    def add_box(self, name: str, edges: tuple[float, float, float], pose: Pose3) -> None:
        """Put a box there that stands on its pose's height."""
        self.add(name, Shape(Kind.BOX, edges), pose @ Pose3((0.0, 0.0, edges[2] / 2)))

    def asked(self, rng: np.random.Generator) -> list[SE2]:
        """Return ten poses, of which four are within things, at any heading."""
        chosen = rng.choice(len(self.things), 4)
        points = [(self.things[i][0], self.things[i][1]) for i in chosen]
        points += [tuple(point) for point in rng.uniform(-5.0, 5.0, (6, 2)).tolist()]
        return [SE2(x, y, rng.uniform(-math.pi, math.pi)) for x, y in points]


def start_case(number: int) -> StartCase:
    """Return one of `WORLDS` worlds."""
    rng = np.random.default_rng((27, number))
    case = _ground(GROUNDS[number % len(GROUNDS)], rng)
    for i in range(int(rng.integers(6, 14))):
        x, y = rng.uniform(-5.0, 5.0, 2).tolist()
        pose = Pose3.from_rpy((x, y, case.ground(x, y)), (0.0, 0.0, rng.uniform(0.0, 6.0)))
        _thing(case, f"thing{i}", pose, rng)
    return case


def _ground(kind: str, rng: np.random.Generator) -> StartCase:
    half = SIDE / 2
    notched = half * np.array([(-1, -1), (1, -1), (1, 1), (0.9, 1), (0.9, 0.9), (-1, 0.9)])
    level = float(rng.choice([0.0, 0.07, -0.4, 1.3]))
    case = StartCase(lambda x, y: level)
    at = Pose3((0.0, 0.0, level))
    if kind == "plane":
        case = StartCase(lambda x, y: 0.0, list(ground_bodies()))
    elif kind == "slab":
        case.add_box("floor", (SIDE, SIDE, 0.2), at @ Pose3((0.0, 0.0, -0.2)))
    elif kind in ("plate", "sheet"):
        faces = prism(notched, 2e-3) - (0.0, 0.0, 2e-3)
        top = faces[:, :, 2].min(axis=1) == 0.0
        case.add("floor", _mesh("floor", faces[top] if kind == "sheet" else faces), at)
    elif kind == "terrain":
        case = _terrain(rng)
    elif kind == "hill":
        tilt = math.radians(rng.uniform(4.0, 15.0))
        case = StartCase(lambda x, y: x * math.tan(tilt))
        case.add_box(
            "hill",
            (2.0 * SIDE, SIDE, 0.5),
            Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, -tilt, 0.0)) @ Pose3((0.0, 0.0, -0.5)),
        )
    elif kind == "raised":  # a floor on posts above the ground plane
        case = StartCase(lambda x, y: 0.2, list(ground_bodies()))
        case.add_box("floor", (SIDE, SIDE, 0.05), Pose3((0.0, 0.0, 0.15)))
    elif kind == "storeys":
        case.add_box("floor", (SIDE, SIDE, 0.1), at @ Pose3((0.0, 0.0, -0.1)))
        case.add_box("upstairs", (SIDE, SIDE, 0.2), at @ Pose3((0.0, 0.0, 2.6)))
    else:  # a platform that a ramp leads to
        case = StartCase(lambda x, y: float(np.clip((x - 1.0) * 0.2, 0.0, 0.4)))
        corners = np.array([(-half, -1.0), (half, -1.0), (half, 0.4), (3.0, 0.4), (1.0, 0.0)])
        corners = np.vstack((corners, [(-half, 0.0)]))
        turned = Pose3.from_rpy((0.0, half, 0.0), (math.pi / 2, 0.0, 0.0))
        case.add("floor", _mesh("ramp", prism(corners, SIDE)), turned)
    return case


def _terrain(rng: np.random.Generator) -> StartCase:
    """Return rolling ground, rough by up to 1 cm, up to 3 m above or below 0."""
    cells, high = 65, 2.0
    x, y = np.meshgrid(*2 * [np.linspace(0.0, 2.0 * math.pi, cells)])
    heights = 0.5 + 0.4 * np.sin(x + rng.uniform(0.0, 6.0)) * np.cos(y + rng.uniform(0.0, 6.0))
    terrain = Terrain(Path("hills"), heights + 0.005 * rng.random(heights.shape))
    z, size = float(rng.uniform(-3.0, 3.0)), (SIDE, SIDE, high)

    def ground(x: float, y: float) -> float:
        scale = (cells - 1) / SIDE
        column, row = ((value + SIDE / 2) * scale for value in (x, y))
        i, j = int(row), int(column)
        v, u = row - i, column - j
        near = terrain.heights[i : i + 2, j : j + 2]
        return z + high * float(np.array([1 - v, v]) @ near @ np.array([1 - u, u]))

    case = StartCase(ground)
    case.add("hills", Shape(Kind.TERRAIN, size, terrain=terrain), Pose3((0.0, 0.0, z)))
    return case


def _thing(case: StartCase, name: str, pose: Pose3, rng: np.random.Generator) -> None:
    a, b = rng.uniform(0.4, 2.5, 2).tolist()
    high = float(rng.uniform(0.5, 3.5))
    kind = str(rng.choice(["block", "wall", "cabinet", "drum", "crate", "table", "sunken"]))
    if kind == "drum":
        a = b = 2.0 * float(rng.uniform(0.2, 1.0))
        case.add(name, Shape(Kind.CYLINDER, (a / 2, high)), pose @ Pose3((0.0, 0.0, high / 2)))
    elif kind == "cabinet":  # a mesh
        case.add(name, _mesh(f"{name}.dae", _box(a, b, high)), pose)
    elif kind == "crate":  # without a bottom, wound inside out
        faces = _box(a, b, high)
        case.add(name, _mesh(name, faces[faces[:, :, 2].max(axis=1) > 0.0][:, ::-1]), pose)
    elif kind == "table":
        offsets = [(0.45 * i * a, 0.45 * j * b, 0.0) for i in (-1, 1) for j in (-1, 1)]
        legs = [np.add(_box(0.06, 0.06, 0.72), offset) for offset in offsets]
        top = np.add(_box(a, b, 0.03), (0.0, 0.0, 0.72))
        case.add(name, _mesh(name, np.concatenate((*legs, top))), pose)
    else:
        b = 0.15 if kind == "wall" else b
        deep = 0.4 if kind == "sunken" else 0.0
        case.add_box(name, (a, b, high + deep), pose @ Pose3((0.0, 0.0, -deep)))
    case.things.append((*pose.position[:2], math.hypot(a, b) / 2))


def _box(a: float, b: float, c: float) -> NDArray[np.float64]:
    outline = np.array([(-a, -b), (a, -b), (a, b), (-a, b)]) / 2
    return prism(outline, c)


def _mesh(name: str, faces: NDArray[np.float64]) -> Shape:
    return Shape(Kind.MESH, (1.0, 1.0, 1.0), Mesh(Path(name), np.ascontiguousarray(faces)))
