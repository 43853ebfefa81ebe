"""Forces that clients ask for push joints and links, each for its time."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity, EntityError, UnknownEntityError
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.simulation import Simulation
from tests.sim.builders import run, simulator

LIFT = """<robot name="lift"><link name="base"><inertial><mass value="20"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="1 1 0.2"/></geometry></collision></link>
<joint name="mast" type="prismatic"><parent link="base"/><child link="fork"/>
<origin xyz="0 0 0.3"/><axis xyz="0 0 1"/><limit lower="0" upper="0.3" effort="500" velocity="1"/>
<dynamics damping="200"/></joint>
<link name="fork"><inertial><mass value="3"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="tip_joint" type="fixed"><parent link="fork"/><child link="tip"/>
<origin xyz="0.5 0 0"/></joint><link name="tip"/></robot>"""
STILL = np.zeros(3)


@pytest.fixture
def sim() -> Simulation:
    """Return a world with a block of 2 kg that floats, 5 m off."""
    found = simulator()
    part = Part(Shape(Kind.BOX, (1.0, 1.0, 1.0)), Pose3())
    block = Entity("block", (part,), start=Pose3((5.0, 0.0, 2.0)), mass=2.0, floats=True)
    found.stage.spawn(block)
    found.stage.spawn(replace(block, name="beside", start=Pose3((5.0, 5.0, 2.0))))
    return found


def pushed(sim: Simulation, wrench: list[float], frame: str = "", point: object = STILL) -> None:
    now = sim.stage.elapsed
    whole = np.array([*wrench, *[0.0] * (6 - len(wrench))])
    sim.stage.forces.push_link("block::link", whole, frame, np.array(point), now, now + 1.0)


def test_a_force_accelerates_for_its_time_and_is_forgotten(sim: Simulation) -> None:
    pushed(sim, [4.0])
    run(sim, 2.0)
    motion = sim.stage.motion("block")
    assert motion.linear == pytest.approx((2.0, 0.0, 0.0), abs=1e-2)
    assert motion.pose.position[0] == pytest.approx(5.0 + 1.0 + 2.0, abs=0.02)
    assert sim.stage.motion("beside").linear == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert not sim.stage.forces


def test_forces_on_one_link_add_up_and_all_end_at_once(sim: Simulation) -> None:
    pushed(sim, [4.0])
    pushed(sim, [0.0, 2.0, 1.0])
    run(sim, 0.5)
    speed = sim.stage.motion("block").linear
    assert speed == pytest.approx((1.0, 0.5, 0.25), abs=1e-2)
    sim.stage.forces.clear_link("block::link")
    run(sim, 0.5)
    assert sim.stage.motion("block").linear == pytest.approx(speed, abs=1e-2)


def test_a_force_in_a_links_frame_turns_with_it_and_acts_at_its_point(sim: Simulation) -> None:
    sim.stage.move("block", Pose3.from_rpy((5.0, 0.0, 2.0), (0.0, 0.0, math.pi / 2)))
    pushed(sim, [1.0], frame="block::link", point=(0.0, 0.5, 0.0))
    run(sim, 0.2)
    found = sim.stage.motion("block")
    assert found.linear == pytest.approx((0.0, 0.1, 0.0), abs=1e-2)
    # A torque of -0.5 N m on a cube of 2 kg: m / 6 is a third of 1 kg m^2.
    assert found.angular == pytest.approx((0.0, 0.0, -0.3), abs=1e-2)


def test_an_effort_lifts_a_fork_that_falls_again(tmp_path: Path) -> None:
    file = tmp_path / "lift.urdf"
    file.write_text(LIFT)
    sim = simulator(robot=file)

    def height() -> float:
        model, data = sim.stage.scene.model, sim.stage.data
        return float(data.qpos[model.joint("mast").qposadr[0]])

    now = sim.stage.elapsed
    sim.stage.forces.push_joint("mast", 3.0 * 9.81 + 40.0, now, math.inf)
    run(sim, 1.0)
    assert height() == pytest.approx(0.2, abs=0.02)  # 40 N against 200 N s/m
    sim.stage.forces.clear_joint("mast")
    run(sim, 2.0)
    assert height() == pytest.approx(0.0, abs=0.01)
    before = sim.stage.elapsed
    sim.stage.forces.push_link("lift::tip", np.array([0, 0, 69.4, 0, 0, 0]), "", STILL, before, 9e9)
    run(sim, 0.5)
    assert height() == pytest.approx(0.1, abs=0.02)


def test_a_restart_and_another_world_end_them(sim: Simulation) -> None:
    pushed(sim, [4.0])
    sim.stage.restore()
    assert not sim.stage.forces


def test_what_is_not_there_is_named(sim: Simulation) -> None:
    with pytest.raises(
        UnknownEntityError, match=r"joint 'masst' does not exist; valid: .*front_left_joint"
    ):
        sim.stage.forces.push_joint("masst", 1.0, 0.0, 1.0)
    with pytest.raises(UnknownEntityError, match="link 'a::base_lin' does not exist; did you mean"):
        sim.stage.forces.clear_link("a::base_lin")


def test_no_push_is_too_hard_for_the_physics(sim: Simulation) -> None:
    for value in (math.nan, math.inf):
        with pytest.raises(EntityError, match="is not finite"):
            sim.stage.forces.push_joint("front_left_joint", value, 0.0, 1.0)
        with pytest.raises(EntityError, match="is not finite"):
            pushed(sim, [1.0], "block::link", (value, 0.0, 0.0))
    pushed(sim, [0.0, 0.0, 1e300, 1e300])
    sim.stage.forces.push_joint("front_left_joint", -1e300, 0.0, math.inf)
    run(sim, 0.2)
    assert np.isfinite(sim.stage.data.qpos).all()
    assert sim.stage.motion("block").pose.position[2] == pytest.approx(2.0 + 0.5e4 * 0.04, rel=0.1)
