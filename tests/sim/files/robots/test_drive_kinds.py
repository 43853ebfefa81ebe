"""Drives that their wheels cannot do are simulated as others, say so, and drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.settings import DriveKind
from tests.sim import drive_cases as cases
from tests.sim.builders import run, simulator, texts
from tests.sim.files.test_robots import FOUR, LEFT, TWO, _robot

SIDES = "".join(
    f"<{side}_joint>{end}_{side}_wheel_joint</{side}_joint>"
    for end in ("front", "rear")
    for side in ("left", "right")
)


@pytest.mark.parametrize(
    ("wheels", "file", "inside", "said"),
    [
        (TWO, "libgazebo_ros_planar_move.so", "", "wheels are no mecanum or omni ones"),
        (TWO, "gz-sim-velocity-control-system", "", "wheels are no mecanum or omni ones"),
        (FOUR, "libgazebo_ros_omni_drive.so", "", "wheels' axes are parallel"),
        (FOUR, "gz-sim-ackermann-steering-system", SIDES, "no joint steers a wheel"),
        (FOUR, "gz-sim-diff-drive-system", SIDES, ""),
    ],
)
def test_drive_that_is_simulated_as_another_says_so(
    tmp_path: Path, wheels: str, file: str, inside: str, said: str
) -> None:
    path = _robot(tmp_path, wheels + cases.plugin(file, inside))
    robot = load_robot(path, SearchPath())
    assert robot.drive.kind is DriveKind.SIDES
    told = [note for note in texts(robot.notes) if "of its two sides" in note]
    assert len(told) == (1 if said else 0)
    assert not said or said in told[0]
    last = run(simulator(robot=path), 1.5, Velocity(0.3, y=0.3))
    assert last.truth.v == pytest.approx(0.3, rel=0.1)
    assert abs(last.truth.side) < 0.01


def test_robot_moved_in_the_plane_says_by_what(tmp_path: Path) -> None:
    path = cases.planar().write(tmp_path)
    slips = "<gazebo reference='front_left_mecanum_wheel'><mu1>0.01</mu1></gazebo></robot>"
    path.write_text(path.read_text().replace("</robot>", slips))
    robot = load_robot(path, SearchPath())
    assert any("moved in the plane: it moves by mecanum wheels" in n for n in texts(robot.notes))
    assert any("its friction 0.01 would slip; it gets 0.8" in n for n in texts(robot.notes))
    assert robot.settings.friction["front_left_mecanum_wheel"] == 0.8


def test_file_says_which_way_rollers_grip(tmp_path: Path) -> None:
    """What they say must let the robot drive any way."""
    path = cases.mecanum().write(tmp_path)
    rubbing = "".join(
        f"<gazebo reference='{end}_{side}_wheel'><mu1>1</mu1><mu2>0</mu2>"
        f"<fdir1>1 {sign} 0</fdir1></gazebo>"
        for end, side, sign in (
            ("front", "left", -1),
            ("front", "right", 1),
            ("rear", "left", 1),
            ("rear", "right", -1),
        )
    )
    standard = load_robot(path, SearchPath())
    path.write_text(path.read_text().replace("</robot>", f"{rubbing}</robot>"))
    told = load_robot(path, SearchPath())
    assert np.allclose(told.drive.grips, standard.drive.grips)
    assert not any("mu2" in note or "fdir1" in note for note in texts(told.notes))
    path.write_text(path.read_text().replace("<fdir1>1 -1 0", "<fdir1>1 1 0"))
    odd = load_robot(path, SearchPath())
    assert odd.drive.grips == standard.drive.grips
    assert any("do not let mecanum wheels drive" in note for note in texts(odd.notes))


def test_friction_of_two_directions_is_noted_without_rollers(tmp_path: Path) -> None:
    rubbing = "<gazebo reference='front_left_wheel'><mu1>1</mu1><mu2>0</mu2></gazebo>"
    robot = load_robot(_robot(tmp_path, FOUR + rubbing), SearchPath())
    assert set(robot.drive.left) == set(LEFT)
    assert any("<mu2> is taken to be <mu1>" in note for note in texts(robot.notes))


def test_casters_do_not_steer(tmp_path: Path) -> None:
    """A wheel that swivels with limits is a caster where its name says so."""
    robot = cases.Robot((*cases.four()[:2], cases.Wheel("caster", -0.15, 0.0, steered=True)))
    drive = load_robot(robot.write(tmp_path), SearchPath()).drive
    assert (drive.kind, drive.steering, drive.free) == (DriveKind.SIDES, (), ())
