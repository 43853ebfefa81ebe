"""What a robot's file leaves out is made up for, and said."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.check import check
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts


def test_robot_without_any_collision_is_as_solid_as_it_is_drawn(tmp_path: Path) -> None:
    path = cases.Robot(cases.four()).write(tmp_path)
    path.write_text(path.read_text("utf-8").replace("collision>", "visual>"), "utf-8")
    sim = simulator(robot=path)
    assert sum("as solid as it is drawn" in note for note in sim.notes) == 5
    assert (
        sim.robot.model.urdf.links["base"].collisions == sim.robot.model.urdf.links["base"].visuals
    )
    assert run(sim, 2.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.05)


def test_robot_with_a_collision_keeps_what_is_only_drawn(tmp_path: Path) -> None:
    path = cases.Robot(
        cases.four(),
        "<link name='flag'><visual><geometry><sphere radius='0.1'/>"
        "</geometry></visual></link><joint name='f' type='fixed'><parent link='base'/>"
        "<child link='flag'/></joint>",
    ).write(tmp_path)
    assert not load_robot(path, SearchPath()).urdf.links["flag"].collisions


def test_motors_of_a_heavy_robot_can_move_it(tmp_path: Path) -> None:
    joints = "".join(
        f"<{side}_joint>{end}_{side}_wheel_joint</{side}_joint>"
        for side in ("left", "right")
        for end in ("front", "rear")
    )
    robot = cases.Robot(cases.four(), cases.plugin("gz-sim-diff-drive-system", joints), mass=300.0)
    path = robot.write(tmp_path)
    assert load_robot(path, SearchPath()).drive.torque == pytest.approx(
        2.0 * 9.81 * 301.6 * 0.06 / 4
    )
    limited = re.sub("</plugin>", "<torque>3</torque></plugin>", path.read_text("utf-8"))
    path.write_text(limited, "utf-8")
    assert load_robot(path, SearchPath()).drive.torque == 3.0


def test_body_of_no_mass_weighs_what_its_shapes_do(tmp_path: Path) -> None:
    path = cases.Robot(cases.four()).write(tmp_path)
    path.write_text(path.read_text("utf-8").replace("mass value='12.0'", "mass value='0'"), "utf-8")
    base = load_robot(path, SearchPath()).urdf.links["base"].inertial
    assert base is not None
    assert base.mass > 0.1


@pytest.mark.parametrize(("x", "leans"), [(0.0, False), (0.4, True)])
def test_robot_that_tips_over_is_named(tmp_path: Path, x: float, leans: bool) -> None:
    path = cases.Robot(cases.four()).write(tmp_path)
    mass = "<inertial><mass value='12.0'/>"
    moved = mass.replace("<inertial>", f"<inertial><origin xyz='{x} 0 0'/>")
    path.write_text(path.read_text("utf-8").replace(mass, moved), "utf-8")
    notes = texts(check(path, SearchPath(), {}).notes)
    assert any("it tips over, or would have to balance" in note for note in notes) == leans
