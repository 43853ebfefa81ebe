"""Claims: cameras see by a world's lights, in its fog, before its sky."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.look import SUN, Fog, Light, LightKind, Look
from arjuna_sim.model.world import Body, World
from tests.sim.builders import EMPTY
from tests.sim.files.test_pictures import seen_from

LOW, HIGH = 1.0 / 255.0, 60
DARK = Look((), (LOW, LOW, LOW), (0.0, 0.0, 0.0))
GROUND, WALL = (420, 320), (225, 320)  # pixels before the robot, and on the wall behind them


def world_with(look: Look, distance: float = 2.0, roof: bool = False) -> World:
    """Return a grey wall before the robot, which a roof may hide from above."""
    grey = (0.6, 0.6, 0.6, 1.0)
    wall = Part(Shape(Kind.BOX, (0.1, 6.0, 0.6)), Pose3((distance, 0.0, 0.3)), grey)
    above = Part(Shape(Kind.BOX, (6.0, 6.0, 0.1)), Pose3((0.0, 0.0, 3.0)), grey)
    parts = [wall, above] if roof else [wall]
    empty = load_world(EMPTY)
    bodies = (*empty.bodies, *(Body("w", part, False) for part in parts))
    return dataclasses.replace(empty, bodies=bodies, look=look)


def seen(world: World) -> dict[str, np.ndarray]:
    picture = seen_from(world, SE2()).astype(int)
    return {"ground": picture[GROUND], "wall": picture[WALL], "sky": picture[0, 320]}


def shining(kind: LightKind, **fields: object) -> Look:
    light = Light(kind, **{"diffuse": (1.0, 0.0, 0.0), "specular": (0.0,) * 3, **fields})  # type: ignore[arg-type]
    return dataclasses.replace(DARK, lights=(light,))


@pytest.mark.parametrize(
    ("look", "ground", "wall"),
    [
        (DARK, False, False),
        (shining(LightKind.DIRECTIONAL), True, False),
        (shining(LightKind.DIRECTIONAL, direction=(1.0, 0.0, 0.0)), False, True),
        (shining(LightKind.POINT, position=(1.0, 0.0, 1.0)), True, True),
        (shining(LightKind.POINT, position=(1.0, 0.0, 9.0), attenuation=(0, 0, 1)), False, False),
        (shining(LightKind.SPOT, position=(0.8, 0.0, 5.0), cutoff=0.15), True, False),
        (
            shining(LightKind.SPOT, direction=(1.0, 0.0, 0.0), position=(0, 0, 0.4), cutoff=0.3),
            False,
            True,
        ),
    ],
    ids=["none", "from above", "from behind", "lamp", "far lamp", "cone down", "cone ahead"],
)
def test_what_a_light_shines_on_is_seen_in_its_colour(look: Look, ground: bool, wall: bool) -> None:
    found = seen(world_with(look))
    for name, lit in (("ground", ground), ("wall", wall)):
        assert (found[name][0] > HIGH) == lit, (name, found)
        assert (found[name][1:] < HIGH / 2).all()


@pytest.mark.parametrize("casts", [False, True])
@pytest.mark.parametrize(
    ("kind", "height"), [(LightKind.DIRECTIONAL, 0.0), (LightKind.SPOT, 6.0)], ids=["sun", "spot"]
)
def test_shadow_lies_below_a_roof(kind: LightKind, height: float, casts: bool) -> None:
    look = shining(kind, position=(0.8, 0.0, height), casts_shadow=casts)
    assert (seen(world_with(look, roof=True))["ground"][0] > HIGH) != casts


def test_sky_and_fog_have_their_colours() -> None:
    sun, sky, grey = shining(LightKind.DIRECTIONAL, direction=(1.0, 0, 0)), (0.0, 1.0, 0.0), 200
    plain = seen(world_with(dataclasses.replace(sun, background=sky)))
    assert plain["sky"].tolist() == [0, 255, 0]
    fog = Fog((grey / 255,) * 3, 1.0, 5.0)
    near, middle, far = (
        seen(world_with(dataclasses.replace(sun, fog=fog), x)) for x in (1.2, 3.2, 5.5)
    )
    assert far["sky"].tolist() == far["wall"].tolist() == [grey] * 3
    assert near["wall"][0] == pytest.approx(plain["wall"][0], abs=8)
    assert middle["wall"][1] == pytest.approx(grey / 2, abs=8)  # half of the fog


def test_the_ground_of_an_empty_world_is_not_stippled_by_the_edge_of_shadows() -> None:
    look = Look((dataclasses.replace(SUN, casts_shadow=True),))
    picture = seen_from(dataclasses.replace(load_world(EMPTY), look=look), SE2()).astype(int)
    assert np.abs(np.diff(picture[260:], axis=1)).max() < 20  # from the horizon down
