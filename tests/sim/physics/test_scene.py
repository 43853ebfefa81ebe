"""The scene's memory and pace."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Mesh, Part, Shape
from arjuna_sim.model.world import Body
from arjuna_sim.physics import scene as scenes
from arjuna_sim.physics.pacing import PaceMeter, Pacer
from arjuna_sim.physics.running import saved
from arjuna_sim.physics.scene import Scene, build_scene
from arjuna_sim.physics.wheels.servo import ServoConfig
from tests.sim.generated import Chassis, level
from tests.sim.physics.test_geoms import L

STEP = 0.002
ROBOT = Chassis().robot()
BALL = Part(Shape(Kind.SPHERE, (0.1,)))


def crate(shapes: int, name: str = "crate", mass: float = 1.0) -> Entity:
    return Entity(name, (BALL,) * shapes, start=Pose3((5.0, 0.0, 1.0)), mass=mass)


def scene(*entities: Entity, robots: tuple[str, ...] = ("a", "b")) -> Scene:
    return build_scene(
        {name: ROBOT.below(name) for name in robots}, level(), ServoConfig(), STEP, entities
    )


@pytest.fixture(scope="module")
def two() -> Scene:
    return scene(crate(2), crate(1, "post", 0.0))


def test_each_robot_has_its_own_addresses_in_the_state(two: Scene) -> None:
    model = two.model
    for name, robot in two.robots.items():
        assert robot.title == name
        root = model.body(f"body:{name}//base").id
        own = [i for i in range(model.nv) if model.body_rootid[model.dof_bodyid[i]] == root]
        assert list(range(model.nv))[robot.rates] == own
        assert robot.base[1] == own[0]
        joint = int(model.body_jntadr[root])
        assert robot.base[0] == model.jnt_qposadr[joint]
        wheels = [f"{name}//{wheel}" for wheel in ROBOT.moving_joints]
        assert len(wheels) == 4
        assert robot.joint_position.tolist() == [model.joint(n).qposadr[0] for n in wheels]
        assert robot.joint_velocity.tolist() == [model.joint(n).dofadr[0] for n in wheels]
        solid = [model.body_rootid[model.geom_bodyid[g]] == root for g in range(model.ngeom)]
        assert robot.is_solid.tolist() == [
            mine and group == 3 for mine, group in zip(solid, model.geom_group, strict=True)
        ]
        assert robot.is_solid.sum() == 9  # a box, four tyres and four rims
    assert two.rollers.shape == (0,)


def test_geoms_are_called_by_what_they_are_of(two: Scene) -> None:
    names = np.array(two.names)
    assert {str(name): int((names == name).sum()) for name in set(two.names)} == {
        "": 2,  # the ground as it is touched, and as it is drawn, as all shapes are
        "a": 9,
        "b": 9,
        "crate": 4,
        "post": 2,
    }
    np.testing.assert_array_equal(names == "a", two.robots["a"].is_solid)
    np.testing.assert_array_equal(two.is_obstacle, names != "")
    alone = scene(robots=("only",))
    assert set(alone.names) == {""}  # of its own shapes a robot alone need not tell


@pytest.mark.parametrize(
    ("shapes", "held", "memory"),
    [
        (0, 3, 64_000_000),
        (3, 2, 64_000_000 + 32 * 72**2),  # 6 geoms of 4 points of 3 forces, squared, of 32 bytes
        (225, 0, 64_000_000 + 32 * 5400**2),
        (230, 0, 1_000_000_000),
    ],
)
def test_contact_memory_is_that_of_pushed_bodies(shapes: int, held: int, memory: int) -> None:
    entities = [crate(count, n, mass) for count, n, mass in ((shapes, "m", 1.0), (held, "h", 0.0))]
    given = scene(*(each for each in entities if each.solid), robots=())
    assert given.model.narena == memory


def test_the_solver_is_set_for_dry_friction(two: Scene) -> None:
    option = two.model.opt
    assert option.timestep == STEP
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert option.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
    assert (option.impratio, option.tolerance) == (1e6, 1e-6)
    assert option.gravity == pytest.approx(level().gravity)
    assert option.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP


def test_a_model_from_the_cache_is_the_one_that_was_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(scenes, "_SLOW", 12)
    folder, made, make = tmp_path / "arjuna" / "models", list[object](), scenes._made

    def counted(*of: Any) -> Any:
        made.append(of)
        return make(*of)

    monkeypatch.setattr(scenes, "_made", counted)
    half = Part(Shape(Kind.MESH, (0.5, 1.0, 1.0), Mesh(Path("l.stl"), L)), Pose3((4.0, 0.0, 0.0)))

    def compiled(part: Part, keep: bool = True, mass: float = 1.0) -> Scene:
        ground = level()
        world = dataclasses.replace(ground, bodies=(*ground.bodies, Body("bent", part, True)))
        things = (crate(2, mass=mass),)
        return build_scene({"a": ROBOT}, world, ServoConfig(), STEP, things, keep)

    first, kept, plain = compiled(half), compiled(half), compiled(half, keep=False)
    assert (len(made), len(list(folder.iterdir()))) == (2, 1)
    assert "bent" in first.names
    for other in (kept, plain):
        assert saved(other.model).tobytes() == saved(first.model).tobytes()
        assert other.names == first.names
        assert other.robots["a"].support.ride_height == first.robots["a"].support.ride_height
    compiled(dataclasses.replace(half, friction=0.1))
    compiled(half, mass=2.0)
    assert len(made) == 4, "they are others"
    compiled(dataclasses.replace(half, shape=Shape(Kind.BOX, (1.0, 1.0, 1.0))))
    assert len(list(folder.iterdir())) == 3, "what is compiled at once is not kept"


class Clock:
    """A wall clock that is set by hand."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_it_waits_until_real_time_has_come_as_far() -> None:
    clock = Clock()
    pacer = Pacer(2.0, clock)
    assert pacer.wait(30.0) == 0.0
    assert pacer.wait(31.0) == 0.5
    clock.now = 100.4
    assert pacer.wait(31.0) == pytest.approx(0.1)
    clock.now = 100.9  # late, by less than is caught up with
    assert pacer.wait(31.0) == 0.0
    assert pacer.wait(32.0) == pytest.approx(0.1)


def test_what_is_too_late_is_not_caught_up_with() -> None:
    clock = Clock()
    pacer = Pacer(1.0, clock)
    pacer.wait(0.0)
    clock.now = 101.6
    assert pacer.wait(1.0) == 0.0
    assert pacer.wait(1.5) == pytest.approx(0.5)
    pacer.restart()
    assert pacer.wait(9.0) == 0.0
    assert pacer.wait(9.25) == 0.25


def test_a_factor_of_0_waits_for_nothing_and_less_is_refused() -> None:
    pacer = Pacer(0.0, Clock())
    assert [pacer.wait(now) for now in (0.0, 50.0)] == [0.0, 0.0]
    with pytest.raises(ValueError, match="at least 0, got -1"):
        Pacer(-1.0, Clock())


def test_factor_is_read_once_a_period_of_real_time() -> None:
    meter = PaceMeter(1.0)
    readings = [meter.update(10.0 + i * 0.25, i * 0.5) for i in range(9)]
    assert readings == [None, None, None, None, 2.0, None, None, None, 2.0]
    assert meter.summary == "real-time factor 2.00: 4.0 s in 2.0 s"


def test_pauses_do_not_count() -> None:
    meter = PaceMeter(1.0)
    meter.update(0.0, 0.0)
    assert meter.update(1.0, 1.0) == 1.0
    meter.pause()
    assert meter.update(100.0, 1.0) is None
    assert meter.update(101.0, 1.5) == pytest.approx(0.5)
    assert meter.summary == "real-time factor 0.75: 1.5 s in 2.0 s"


def test_nothing_is_said_of_nothing() -> None:
    assert PaceMeter().summary is None
