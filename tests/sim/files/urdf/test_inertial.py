"""A link's <inertial> as it stands, turned by its origin, or computed where no body can have it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.model.geometry.shapes import Inertial
from tests.sim.builders import texts

LINK = """<robot name="r"><link name="base_link"><inertial>{inside}</inertial><collision>
<geometry><box size="1.0 2.0 3.0"/></geometry></collision></link></robot>"""
MASS = "<mass value='{}'/>"
TENSOR = "<inertia ixx='{}' iyy='{}' izz='{}' ixy='{}' ixz='0' iyz='0'/>"
BOX = np.array([13.0, 10.0, 5.0]) / 12.0 * 6.0  # of 6 kg


def read(folder: Path, inside: str) -> tuple[Inertial, str]:
    """Return the link's mass properties and what is noted of them."""
    path = folder / "r.urdf"
    path.write_text(LINK.format(inside=inside), encoding="utf-8")
    robot = load_robot(path)
    found = robot.urdf.links["base_link"].inertial
    assert found is not None
    return found, " ".join(text for text in texts(robot.notes) if "inerti" in text)


@pytest.mark.parametrize("tensor", [(1.0, 2.0, 2.5, 0.0), (1.0, 2.0, 2.5, 0.3), (1, 1, 3.9, 0)])
def test_an_inertia_that_a_body_can_have_is_taken(
    tmp_path: Path, tensor: tuple[float, ...]
) -> None:
    found, noted = read(tmp_path, MASS.format(6.0) + TENSOR.format(*tensor))
    xx, yy, zz, xy = tensor
    assert (found.mass, noted) == (6.0, "")
    np.testing.assert_allclose(found.inertia, [[xx, xy, 0], [xy, yy, 0], [0, 0, zz]])


def test_it_is_turned_and_placed_by_its_origin(tmp_path: Path) -> None:
    origin = "<origin xyz='0.1 0.2 0.3' rpy='0 0 1.5707963267948966'/>"
    found, _ = read(tmp_path, origin + MASS.format(6.0) + TENSOR.format(1.0, 2.0, 2.5, 0.0))
    assert found.center == pytest.approx((0.1, 0.2, 0.3))
    np.testing.assert_allclose(found.inertia, np.diag([2.0, 1.0, 2.5]), atol=1e-12)


@pytest.mark.parametrize(
    ("tensor", "problem"),
    [
        ("", "lacks <inertia>"),
        (TENSOR.format(1, 1, 4.1, 0), "the inertia's largest axis is more than the sum of the"),
        (TENSOR.format(1, 1, 1, 1.5), "the inertia is not positive definite"),
        (TENSOR.format(0, 0, 0, 0), "the inertia is not positive definite"),
        (TENSOR.format(1e13, 1e13, 1e13, 0), "the inertia is beyond all bounds"),
    ],
)
def test_one_that_no_body_can_have_is_computed_with_a_note(
    tmp_path: Path, tensor: str, problem: str
) -> None:
    found, noted = read(tmp_path, MASS.format(6.0) + tensor)
    assert f"{problem}" in noted
    assert "so it is computed from its shapes of 6 kg" in noted
    np.testing.assert_allclose(found.inertia, np.diag(BOX), rtol=1e-6)


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        ("", "mass"),
        (MASS.format(" "), "<mass> lacks the attribute 'value'"),
        (MASS.format(-1), "weighs -1 kg; valid: 0 to 1e\\+07 kg"),
        (MASS.format(2e7), "weighs 2e\\+07 kg"),
        (MASS.format("heavy"), "heavy"),
    ],
)
def test_a_mass_that_is_none_is_refused(tmp_path: Path, inside: str, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        read(tmp_path, inside + TENSOR.format(1, 1, 1, 0))
