"""Bodies of robots and entities."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Inertial, Kind, Part, Shape
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveSettings, GazeboSettings
from arjuna_sim.model.urdf import Hinge, Joint, Link, Mimic, Urdf
from arjuna_sim.physics.robot_body import ROBOTS_MAX, add_robot, let_meet
from arjuna_sim.physics.wheels.servo import ServoConfig
from tests.sim.builders import simulator

BALL = Part(Shape(Kind.SPHERE, (0.1,)))
NO_DRIVE = DriveSettings((), (), 1.0, 0.1, 1.0, 1.0, 0.1)


def random_inertial(rng: np.random.Generator) -> Inertial:
    root = rng.normal(size=(3, 3)) * 0.1
    x, y, z = rng.uniform(-0.3, 0.3, 3).tolist()
    spread = root @ root.T + 0.05 * np.eye(3)  # of grains, whose inertia any body can have
    return Inertial(float(rng.uniform(0.5, 3.0)), (x, y, z), np.trace(spread) * np.eye(3) - spread)


def random_pose(rng: np.random.Generator) -> Pose3:
    return Pose3.from_rpy(tuple(rng.uniform(-1, 1, 3)), tuple(rng.uniform(-3, 3, 3)))


def robot(
    *joints: Joint, inertials: tuple[Inertial | None, ...] = (), root: str = "root"
) -> RobotModel:
    """Return a robot of a root and a link for each joint."""
    names = (root, *(joint.child for joint in joints))
    own = inertials or (Inertial(1.0, (0.0, 0.0, 0.0), np.eye(3)),) * len(names)
    links = {n: Link(n, i, (BALL,), (BALL,)) for n, i in zip(names, own, strict=True)}
    urdf = Urdf(Path("r.urdf"), "r", "", root, links, {joint.name: joint for joint in joints})
    return RobotModel(urdf, GazeboSettings(friction={}), NO_DRIVE, ())


def compiled(one: RobotModel) -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    add_robot(spec, one, ServoConfig(), 1e-3)
    return spec.compile()


@pytest.mark.parametrize("seed", range(3))
def test_links_that_are_fixed_weigh_and_turn_as_one_body(seed: int) -> None:
    """By the moments of each link about the root's origin, which simply add up."""
    rng = np.random.default_rng(seed)
    parts = [random_inertial(rng) for _ in range(3)]
    first, second = random_pose(rng), random_pose(rng)
    one = robot(
        Joint("a", "fixed", "root", "arm", first),
        Joint("b", "fixed", "arm", "hand", second),
        inertials=tuple(parts),
    )
    model = compiled(one)
    mass, moment, about = 0.0, np.zeros(3), np.zeros((3, 3))
    for part, T in zip(parts, (Pose3(), first, first @ second), strict=True):
        position, R = T.apply(np.array([part.center]))[0], T.rotation()
        mass, moment = mass + part.mass, moment + part.mass * position
        shifted = position @ position * np.eye(3) - np.outer(position, position)
        about += R @ part.inertia @ R.T + part.mass * shifted
    center = moment / mass
    expected = about - mass * (center @ center * np.eye(3) - np.outer(center, center))
    body = model.body("body:root")
    assert float(body.mass[0]) == pytest.approx(mass)
    assert body.ipos == pytest.approx(center)
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, body.iquat)
    axes = turned.reshape(3, 3)
    np.testing.assert_allclose(axes @ np.diag(body.inertia) @ axes.T, expected, atol=1e-9)


def moving(kind: str, **given: Any) -> Joint:
    return Joint("j", kind, "root", "tool", Pose3((0.0, 0.0, 0.5)), (0.0, 0.6, 0.8), **given)


def test_joints_move_as_their_kind_says() -> None:
    hinge = compiled(robot(moving("revolute", limits=(-1.0, 2.0), friction=0.3))).joint("j")
    assert (int(hinge.type[0]), bool(hinge.limited[0])) == (mujoco.mjtJoint.mjJNT_HINGE, True)
    assert hinge.range.tolist() == [-1.0, 2.0]
    assert hinge.axis == pytest.approx((0.0, 0.6, 0.8))
    assert float(hinge.frictionloss[0]) == 0.3
    slide = compiled(robot(moving("prismatic", limits=(0.5, 0.5)))).joint("j")
    assert (int(slide.type[0]), bool(slide.limited[0])) == (mujoco.mjtJoint.mjJNT_SLIDE, False)
    free = compiled(robot(moving("continuous"))).joint("j")
    assert not bool(free.limited[0])
    with pytest.raises(KeyError):
        compiled(robot(moving("fixed"))).joint("j")


def test_what_nothing_drives_is_damped_as_its_file_says_or_a_little() -> None:
    """By load and radius: 0.2 / s of 2 kg at 0.1 m, which is more than the 1e-3 at most."""
    assert compiled(robot(moving("revolute"))).joint("j").damping[0] == 1e-3
    assert compiled(robot(moving("revolute", damping=0.5))).joint("j").damping[0] == 0.5
    small = replace(robot(moving("revolute")), drive=replace(NO_DRIVE, radius=0.01))
    assert compiled(small).joint("j").damping[0] == pytest.approx(0.2 * 2.0 * 0.01**2)


@pytest.mark.parametrize(("kind", "directions"), [("planar", 2), ("floating", 3)])
def test_a_loose_part_slides_along_its_plane_or_space(kind: str, directions: int) -> None:
    model = compiled(robot(moving(kind)))
    slides = [model.joint(f"j/{i}") for i in range(directions)]
    axes = np.array([slide.axis for slide in slides])
    np.testing.assert_allclose(axes @ axes.T, np.eye(directions), atol=1e-12)
    np.testing.assert_allclose(axes[:2] @ (0.0, 0.6, 0.8), 0.0, atol=1e-12)
    turn = model.joint("j/turn")
    kinds = {"planar": mujoco.mjtJoint.mjJNT_HINGE, "floating": mujoco.mjtJoint.mjJNT_BALL}
    assert int(turn.type[0]) == kinds[kind]
    assert all(joint.damping[0] == 1e-3 for joint in (*slides, turn))
    assert model.njnt == 1 + directions + 1


def test_a_joint_that_mimics_another_follows_it() -> None:
    lead = moving("revolute")
    follower = Joint("k", "revolute", "root", "claw", Pose3(), mimic=Mimic("j", -2.0, 0.3))
    model = compiled(robot(lead, follower))
    assert model.neq == 1
    assert (model.joint("k").id, model.joint("j").id) == (
        *(int(model.eq_obj1id[0]), int(model.eq_obj2id[0])),
    )
    assert model.eq_data[0, :2].tolist() == [0.3, -2.0]
    assert compiled(robot(lead)).neq == 0


def test_a_part_that_moves_must_weigh_something() -> None:
    own = (Inertial(1.0, (0.0, 0.0, 0.0), np.eye(3)), None)
    with pytest.raises(RobotError, match=r"link 'tool'.*moves, but neither it nor what is fixed"):
        compiled(robot(moving("revolute"), inertials=own))
    assert compiled(robot(moving("fixed"), inertials=own)).body("body:root").mass[0] == 1.0


@pytest.mark.parametrize("count", [1, 2, 4])
def test_robots_touch_each_other_and_none_itself(count: int) -> None:
    spec = mujoco.MjSpec()
    robots = [robot(root=f"r{i}") for i in range(count)]
    for one in robots:
        add_robot(spec, one, ServoConfig(), 1e-3)
    let_meet(spec, robots)
    model = spec.compile()
    for i in range(count):
        a = model.geom(f"r{i}//0")
        for k in range(count):
            b = model.geom(f"r{k}//0")
            touches = bool(a.contype[0] & b.conaffinity[0] or b.contype[0] & a.conaffinity[0])
            assert touches is (i != k)
        assert a.conaffinity[0] & 1  # and the world, whose type is the lowest bit
    with pytest.raises(RobotError, match="is robot 31; at most 30 can be in one world"):
        let_meet(spec, [robots[0]] * (ROBOTS_MAX + 1))


AT = Pose3((0.5, 0.0, 1.0))
CRATE = Entity(
    "crate", (Part(Shape(Kind.BOX, (1.0, 2.0, 3.0)), AT),), start=Pose3((9.0, 0.0, 1.0)), mass=6.0
)


def spawned(entity: Entity) -> Any:
    """Return the model of an empty world and an entity."""
    sim = simulator()
    sim.stage.spawn(entity)
    return sim.stage.scene.model


def test_it_has_the_inertia_of_the_box_around_it() -> None:
    body = spawned(CRATE).body(CRATE.body)
    assert body.mass[0] == 6.0
    assert body.ipos == pytest.approx(AT.position)
    assert body.inertia == pytest.approx((6.5, 5.0, 2.5))


@pytest.mark.parametrize("limits", [None, (-0.5, 1.0)])
def test_it_swings_or_slides_as_its_hinge_says(limits: tuple[float, float] | None) -> None:
    hinge = Hinge(False, (0.0, 0.6, 0.8), (0.1, 0.2, 0.3), limits, 5.0, 2.0, 3.0, 0.4)
    model = spawned(replace(CRATE, hinge=hinge))
    body = model.body(CRATE.body)
    joint = int(body.jntadr[0])
    assert body.jntnum[0] == 1
    assert model.jnt_axis[joint] == pytest.approx(hinge.axis)
    assert model.jnt_pos[joint] == pytest.approx(hinge.anchor)
    assert bool(model.jnt_limited[joint]) is (limits is not None)
    assert limits is None or model.jnt_range[joint] == pytest.approx(limits)
    rate = int(model.jnt_dofadr[joint])
    assert model.jnt_stiffness[joint] == 3.0
    assert model.qpos_spring[model.jnt_qposadr[joint]] == 0.4
    assert (model.dof_damping[rate], model.dof_frictionloss[rate]) == (5.0, 2.0)
    loose = spawned(replace(CRATE, hinge=replace(hinge, slides=True, damping=0.0, friction=0.0)))
    assert loose.jnt_type[joint] != model.jnt_type[joint]
    assert 0.0 < loose.dof_damping[rate] < 5.0


def test_it_swings_about_two_axes_or_about_all() -> None:
    second = Hinge(False, (0.0, 1.0, 0.0), limits=(-0.5, 1.0))
    model = spawned(replace(CRATE, hinge=Hinge(False, (1.0, 0.0, 0.0), further=second)))
    assert model.jnt_axis[model.body(CRATE.body).jntadr[0] :] == pytest.approx(np.eye(3)[:2])
    ball = spawned(replace(CRATE, hinge=Hinge(False, None, (0.1, 0.2, 0.3)))).body(CRATE.body)
    assert (ball.jntnum[0], ball.dofnum[0]) == (1, 3)


def test_what_is_light_swings_as_freely_as_a_door() -> None:
    """A pendulum of 10 g hung still in air as thick as honey."""
    hinge = Hinge(False, (1.0, 0.0, 0.0))
    heavy, light = (
        spawned(replace(CRATE, mass=mass, hinge=hinge)).dof_damping[-1] for mass in (6.0, 0.01)
    )
    assert (heavy, light) == (0.1, pytest.approx(0.1 * 0.01 * (1.25 + 6.5 / 6.0)))


def test_what_is_held_has_no_joint() -> None:
    assert spawned(replace(CRATE, mass=0.0)).body(CRATE.body).jntnum[0] == 0
    assert spawned(CRATE).body(CRATE.body).dofnum[0] == 6
    thin = replace(CRATE, solid=(Part(Shape(Kind.BOX, (1.0, 2.0, 1e-6)), AT),))
    assert np.min(spawned(thin).body(CRATE.body).inertia) > 0.0
