"""Rays against solids: what MuJoCo says of each ray by itself, from outside, inside and beside."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_sim.devices.rays.rays import Rays
from arjuna_sim.devices.sensors.lidar import LidarSettings
from arjuna_sim.simulation import Simulation
from tests.sim.builders import first, simulator

_SHAPES = {
    "box": "<box><size>1.0 0.4 0.8</size></box>",
    "cylinder": "<cylinder><radius>0.4</radius><length>0.9</length></cylinder>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "ellipsoid": "<ellipsoid><radii>0.6 0.3 0.4</radii></ellipsoid>",
    "plane": "<plane><normal>0 0 1</normal><size>1 1</size></plane>",
    "capsule": "<capsule><radius>0.3</radius><length>0.9</length></capsule>",
}
_WORLD = np.array([1, 0, 0, 0, 0, 0], np.uint8)  # MuJoCo's group of what rays hit


def _one_in_the_air(folder: Path, shape: str) -> Simulation:
    path = folder / "one.world"
    path.write_text(
        "<sdf version='1.6'><world name='w'><model name='m'><static>1</static>"
        "<pose>4 0.5 2 0.4 -0.7 0.9</pose><link name='l'><collision name='c'>"
        f"<geometry>{_SHAPES[shape]}</geometry></collision></link></model></world></sdf>"
    )
    return simulator(path)


@pytest.mark.parametrize("shape", _SHAPES)
def test_rays_hit_solids_where_mujoco_says(tmp_path: Path, shape: str) -> None:
    sim, rng = _one_in_the_air(tmp_path, shape), np.random.default_rng(1)
    rays = Rays(sim.stage.scene.model, first(sim.robot.model, LidarSettings).site)
    hits = 0
    for spread in (0.1, 0.6, 3.0):  # inside, near its surface, outside
        origin = np.array([4.0, 0.5, 2.0]) + rng.uniform(-spread, spread, 3)
        ways = rng.normal(size=(100, 3))
        ways[:60] += 3.0 * (np.array([4.0, 0.5, 2.0]) - origin) / spread  # most towards it
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        expected = _by_mujoco(sim, origin, ways)
        hits += int(np.isfinite(expected).sum())
        found = rays.cast(sim.stage.data, origin, ways, 12.0)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
    assert 30 < hits < 300


def test_what_is_out_of_reach_or_wholly_transparent_is_not_hit(tmp_path: Path) -> None:
    sim = _one_in_the_air(tmp_path, "sphere")
    model, data, site = (
        sim.stage.scene.model,
        sim.stage.data,
        first(sim.robot.model, LidarSettings).site,
    )
    origin, way = np.array([0.0, 0.5, 2.0]), np.array([[1.0, 0.0, 0.0]])
    rays = Rays(model, site)
    assert rays.cast(data, origin, way, 4.0) == pytest.approx(3.5)
    assert rays.cast(data, origin, way, 3.4) == np.inf
    model.geom_rgba[model.geom_group == 0, 3] = 0.0
    assert Rays(model, site).cast(data, origin, way, 4.0) == np.inf


def _by_mujoco(
    sim: Simulation, origin: NDArray[np.float64], ways: NDArray[np.float64]
) -> NDArray[np.float64]:
    found = np.empty(len(ways))
    for i, way in enumerate(ways):
        geom = np.zeros((1, 1), np.int32)
        found[i] = mujoco.mj_ray(
            sim.stage.scene.model, sim.stage.data, origin, way, _WORLD, True, -1, geom, None
        )
    return np.where(found < 0.0, np.inf, found)
