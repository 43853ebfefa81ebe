"""Rays and beams against what they must meet."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN
from arjuna_sim.devices.device import Mount
from arjuna_sim.devices.lidar import CloudLidar, RangeSensor
from arjuna_sim.devices.rays import Rays
from arjuna_sim.devices.sensors.lidar import CloudSettings, LidarSettings
from arjuna_sim.model.world import Earth
from arjuna_sim.simulation import Simulation
from tests.sim.builders import first, saved_world, simulator, static

_SHAPES = {
    "box": "<box><size>1.0 0.4 0.8</size></box>",
    "cylinder": "<cylinder><radius>0.4</radius><length>0.9</length></cylinder>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "ellipsoid": "<ellipsoid><radii>0.6 0.3 0.4</radii></ellipsoid>",
    "plane": "<plane><normal>0 0 1</normal><size>1 1</size></plane>",
    "capsule": "<capsule><radius>0.3</radius><length>0.9</length></capsule>",
}
_WORLD = np.array([1, 0, 0, 0, 0, 0], np.uint8)  # MuJoCo's group of what rays hit


def mount(model: Any, seed: int = 0) -> Mount:
    """Return what a lidar needs of a model."""
    return Mount(model, ORIGIN, Earth(), None, np.random.default_rng(seed))


def _one_in_the_air(folder: Path, shape: str) -> Simulation:
    return simulator(saved_world(folder, static("m", _SHAPES[shape], "4 0.5 2 0.4 -0.7 0.9")))


@pytest.mark.parametrize("shape", _SHAPES)
def test_rays_hit_solids_where_mujoco_says(tmp_path: Path, shape: str) -> None:
    sim, rng = _one_in_the_air(tmp_path, shape), np.random.default_rng(1)
    rays = Rays(sim.stage.scene.model, first(sim.robot.model, LidarSettings).site)
    hits = 0
    for spread in (0.1, 0.6, 3.0):  # inside, near its surface, outside
        origin = np.array([4.0, 0.5, 2.0]) + rng.uniform(-spread, spread, 3)
        directions = rng.normal(size=(100, 3))
        directions[:60] += 3.0 * (np.array([4.0, 0.5, 2.0]) - origin) / spread  # most towards it
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        expected = _by_mujoco(sim, origin, directions)
        hits += int(np.isfinite(expected).sum())
        found = rays.cast(sim.stage.data, origin, directions, 0.0, 12.0)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
    assert 30 < hits < 300


def test_what_is_out_of_reach_is_not_hit(tmp_path: Path) -> None:
    sim = _one_in_the_air(tmp_path, "sphere")
    rays = Rays(sim.stage.scene.model, first(sim.robot.model, LidarSettings).site)
    origin, direction = np.array([0.0, 0.5, 2.0]), np.array([[1.0, 0.0, 0.0]])
    assert rays.cast(sim.stage.data, origin, direction, 0.0, 4.0) == pytest.approx(3.5)
    assert rays.cast(sim.stage.data, origin, direction, 0.0, 3.4) == np.inf


def _by_mujoco(
    sim: Simulation, origin: NDArray[np.float64], directions: NDArray[np.float64]
) -> NDArray[np.float64]:
    found = np.empty(len(directions))
    for i, direction in enumerate(directions):
        geom = np.zeros((1, 1), np.int32)
        found[i] = mujoco.mj_ray(
            sim.stage.scene.model, sim.stage.data, origin, direction, _WORLD, True, -1, geom, None
        )
    return np.where(found < 0.0, np.inf, found)


# A wall 3 m ahead and one 2 m to the left of an eye that sits 0.5 m above the ground; the eye's own
# robot (group 3) is right before it, another one 1 m to the right.
ROOM = """<mujoco>
<asset><material name="glass" rgba="1 1 1 0"/><material name="brick" rgba="1 0 0 1"/>
<mesh name="tent" vertex="-1 -1 0 1 -1 0 0 1 0 0 0 1"/></asset>
<worldbody>
<geom name="ahead" type="box" size="0.5 9 9" pos="3.5 0 0" group="0" {wall}/>
<geom name="left" type="box" size="9 0.5 9" pos="0 2.5 0" group="0"/>
<geom name="drawn" type="sphere" size="0.2" pos="1.5 0 0.5" group="1"/>
{extra}
<body name="own"><freejoint/><geom type="sphere" size="0.1" pos="0.3 0 0.5" group="3"/>
<site name="eye" pos="0 0 0.5"/></body>
<body name="other" pos="0 -1.5 0.5"><freejoint/><geom type="sphere" size="0.5" group="3"/></body>
</worldbody></mujoco>"""
TENT = '<geom name="tent" type="mesh" mesh="tent" pos="-6 0 0" group="0"/>'
FORWARD, LEFT, RIGHT, BACK, UP = np.vstack((np.eye(3)[:2], -np.eye(3)[[1, 0]], np.eye(3)[2:]))
DIRECTIONS = np.array([FORWARD, LEFT, RIGHT, BACK])


def room(wall: str = "", extra: str = "") -> tuple[Any, Any]:
    """Return a model and its data."""
    model = mujoco.MjModel.from_xml_string(ROOM.format(wall=wall, extra=extra))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def cast(model: Any, data: Any, rendered: bool = False) -> NDArray[np.float64]:
    """Return how far it is to what stands ahead, left, right and behind."""
    return Rays(model, "eye", rendered).cast(data, np.array([0.0, 0.0, 0.5]), DIRECTIONS, 0.0, 20.0)


def settings(**changed: Any) -> CloudSettings:
    given = dict.fromkeys(("angle_min", "angle_max", "tilt_min", "tilt_max", "noise"), 0.0)
    given |= {"range_min": 0.1, "range_max": 30.0, "rate": 10.0}
    return CloudSettings(link="eye", frame="eye", **({"samples": 1, "rows": 1} | given | changed))


def points(**changed: Any) -> NDArray[np.float32]:
    model, data = room()
    return CloudLidar(settings(**changed), mount(model)).read(data, 0.0).points


@pytest.mark.parametrize("extra", ["", TENT], ids=["solids", "meshes"])
def test_a_robot_sees_walls_and_others_but_neither_itself_nor_what_is_only_drawn(
    extra: str,
) -> None:
    model, data = room(extra=extra)
    behind = np.inf if not extra else cast(model, data)[3]
    assert cast(model, data) == pytest.approx((3.0, 2.0, 1.0, behind))
    assert behind > 5.0  # the tent's side, half a metre up
    groups = [int(group) for group in model.geom_group]
    assert groups.count(3) == 2  # the other robot is what it was


CURTAIN = '<geom type="box" size="0.5 9 9" pos="-4.5 0 0" group="1"/>'


@pytest.mark.parametrize("extra", [CURTAIN, CURTAIN + TENT.replace("-6", "-9")])
def test_a_rendered_lidar_sees_what_is_drawn_and_not_what_is_solid(extra: str) -> None:
    model, data = room(extra=extra)
    assert cast(model, data, rendered=True) == pytest.approx((1.3, np.inf, np.inf, 4.0))


@pytest.mark.parametrize(
    ("wall", "seen"),
    [
        ('material="brick"', True),
        ('material="glass"', False),
        ('rgba="1 1 1 0"', False),
        ('rgba="1 1 1 0.1"', True),
    ],
)
@pytest.mark.parametrize("extra", ["", TENT], ids=["solids", "meshes"])
def test_beams_pass_what_is_wholly_transparent(wall: str, seen: bool, extra: str) -> None:
    assert np.isfinite(cast(*room(wall, extra))[0]) == seen


def test_fewer_or_more_rays_may_be_cast_of_the_same_eye() -> None:
    model, data = room(extra=TENT)
    rays, origin = Rays(model, "eye"), np.array([0.0, 0.0, 0.5])
    for directions in (DIRECTIONS[:1], DIRECTIONS, DIRECTIONS[:2]):
        found = rays.cast(data, origin, directions, 0.0, 20.0)
        assert found[:2] == pytest.approx([3.0, 2.0][: len(directions)])


def test_one_beam_points_to_the_middle_of_its_angles() -> None:
    # Across at a quarter of pi from ahead, upward by a tenth: it meets the left wall at y = 2.
    middle = points(angle_min=math.pi / 8, angle_max=3 * math.pi / 8, tilt_min=0.05, tilt_max=0.15)
    np.testing.assert_allclose(middle, [[2.0, 2.0, math.sqrt(8.0) * math.tan(0.1)]], rtol=1e-5)


def test_rows_rise_and_beams_go_from_the_least_angle_to_the_greatest() -> None:
    model, data = room()
    given = settings(samples=3, rows=2, angle_min=-0.2, angle_max=0.4, tilt_min=-0.1, tilt_max=0.2)
    cloud = CloudLidar(given, mount(model)).read(data, 0.0)
    x, y, z = cloud.points.T.astype(float)
    np.testing.assert_allclose(x, 3.0, rtol=1e-5)
    np.testing.assert_allclose(np.arctan2(y, x), [-0.2, 0.1, 0.4] * 2, atol=1e-6)
    np.testing.assert_allclose(np.arctan2(z, np.hypot(x, y)), [-0.1] * 3 + [0.2] * 3, atol=1e-6)
    assert cloud.rows.tolist() == [0, 0, 0, 1, 1, 1]


def test_a_cloud_leaves_out_what_is_nearer_or_farther_than_its_ranges() -> None:
    directions = {"samples": 3, "angle_min": -math.pi / 2, "angle_max": math.pi / 2}  # 1, 3 and 2 m
    assert len(points(**directions)) == 3
    assert len(points(**directions, range_min=1.5)) == 2
    assert len(points(**directions, range_max=2.5)) == 2
    assert len(points(**directions, range_min=2.0 - 1e-12, range_max=3.0 + 1e-12)) == 2


@pytest.mark.parametrize(
    ("ranges", "nearest"),
    [((0.1, 9.0), 2.0), ((2.5, 9.0), -np.inf), ((0.1, 1.5), np.inf), ((0.1, 2.5), 2.0)],
)
def test_a_sonar_reads_the_nearest_range_of_its_cone(
    ranges: tuple[float, float], nearest: float
) -> None:
    model, data = room()
    given = settings(
        samples=9, angle_max=math.pi / 2, range_min=ranges[0], range_max=ranges[1]
    )  # the left wall at 2 m, the one ahead at 3 m
    assert RangeSensor(given, mount(model)).read(data, 0.0) == pytest.approx(nearest)


def test_noise_is_that_of_the_settings_and_of_the_seed() -> None:
    model, data = room()
    given = settings(samples=4000, angle_min=0.0, angle_max=1e-9, noise=0.05)
    first, again, other = (
        np.linalg.norm(CloudLidar(given, mount(model, seed)).read(data, 0.0).points, axis=1)
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    assert first.mean() == pytest.approx(3.0, abs=0.004)  # five standard errors
    assert first.std() == pytest.approx(0.05, rel=0.06)


def test_beams_turn_with_their_eye() -> None:
    model, data = room()
    half = math.sqrt(0.5)
    data.qpos[3:7] = (half, 0.0, 0.0, half)  # a quarter to the left
    mujoco.mj_kinematics(model, data)
    ahead = CloudLidar(settings(), mount(model)).read(data, 0.0).points
    np.testing.assert_allclose(ahead, [[2.0, 0.0, 0.0]], atol=1e-6)
