"""Robot files in all the forms that people and programs write."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import DriveKind
from arjuna_sim.simulation import Simulation, solo
from tests.sim.builders import run, texts
from tests.sim.generated import level
from tests.sim.robot_files.options import RobotFile, robot_files
from tests.sim.robot_files.package import write

_PLAIN = [dataclasses.replace(file, macros=False) for file in robot_files(40, seed=3)]


def _read(file: RobotFile, folder: Path) -> RobotModel:
    return load_robot(write(file, folder))


@pytest.mark.parametrize("file", _PLAIN, ids=lambda file: file.name)
def test_wheels_are_found_however_they_are_written(file: RobotFile, tmp_path: Path) -> None:
    robot = _read(file, tmp_path)
    count = {"two": 2, "six": 6, "skid": 4, "ackermann": 2, "tricycle": 2}[file.layout]
    assert len(robot.drive.wheels) == count
    assert robot.drive.effective_radius == pytest.approx(file.radius, rel=0.01)
    assert (robot.drive.kind is DriveKind.STEERED) is file.steers
    if not file.steers:
        assert robot.drive.separation == pytest.approx(file.track, rel=0.01)


def test_macros_and_what_they_expand_to_are_one_robot(tmp_path: Path) -> None:
    file = RobotFile(hubs=1, macros=True, friction=0.9)
    of_macros = _read(file, tmp_path / "macros")
    plain = _read(dataclasses.replace(file, macros=False), tmp_path / "plain")
    assert of_macros.drive == plain.drive
    assert of_macros.urdf.mass == plain.urdf.mass
    assert of_macros.settings.friction == plain.settings.friction


@pytest.mark.parametrize("solid", ["cylinder", "drawn mesh", "none"])
def test_an_inertia_that_no_wheel_can_have_is_replaced(tmp_path: Path, solid: str) -> None:
    robot = _read(RobotFile(inertia="one", solid=solid), tmp_path)
    note = next(n for n in texts(robot.notes) if "cannot have an inertia of 1 kg m^2" in n)
    assert note.startswith("link 'left_wheel_link'")
    sim = Simulation(solo(robot), level(), SimulatorConfig(), np.random.default_rng(0))
    assert run(sim, 2.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.02)


def test_a_great_inertia_that_its_size_allows_is_kept(tmp_path: Path) -> None:
    robot = _read(RobotFile(inertia="solid"), tmp_path)
    inertial = robot.urdf.links["left_wheel_link"].inertial
    assert inertial is not None
    mass, radius = 0.02 * 5.0, 0.05
    assert np.linalg.eigvalsh(inertial.inertia)[2] == pytest.approx(mass * radius**2 / 2.0)


def test_wheels_that_are_only_drawn_leave_a_caster_to_slide(tmp_path: Path) -> None:
    robot = _read(RobotFile(solid="drawn mesh", caster="mesh"), tmp_path)
    assert robot.settings.friction["caster_link"] == pytest.approx(0.01)


def test_free_wheels_hardly_brake_the_lightest_robot(tmp_path: Path) -> None:
    file = RobotFile("ackermann", radius=0.025, mass=0.2, friction=0.7)
    sim = Simulation(
        solo(_read(file, tmp_path)), level(), SimulatorConfig(), np.random.default_rng(0)
    )
    assert run(sim, 2.0, Velocity(0.3)).truth.v == pytest.approx(0.3, rel=0.01)


def test_a_robot_without_a_radius_is_refused_by_name(tmp_path: Path) -> None:
    file = RobotFile("skid", solid="none", drive="gz")
    path = write(file, tmp_path)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(f"<wheel_radius>{file.radius}</wheel_radius>", ""), "utf-8")
    with pytest.raises(RobotError, match="the wheels' radius is unknown; <wheel_diameter> gives"):
        load_robot(path)
