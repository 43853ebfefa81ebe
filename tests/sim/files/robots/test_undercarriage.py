"""The wheels on which a track runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.model.wheels import center
from tests.sim import drive_cases as cases

ROW = (-0.14, -0.14 / 3, 0.14 / 3, 0.14)


@pytest.mark.parametrize(
    ("size", "radius", "along", "up"),
    [
        ("0.4 0.06 0.12", 0.06, ROW, 0.0),
        ("0.4 0.02 0.12", 0.06, ROW, 0.0),
        ("0.08 0.06 0.1", 0.04, (0.0,), -0.01),
    ],
)
def test_a_box_runs_on_wheels_from_end_to_end(
    tmp_path: Path, size: str, radius: float, along: tuple[float, ...], up: float
) -> None:
    robot = cases.tracked()
    extra = robot.extra.replace("0.4 0.06 0.1", size)
    found = load_robot(replace(robot, extra=extra).write(tmp_path), SearchPath())
    assert found.drive.radius == pytest.approx(radius)
    for side, y in ((found.drive.left, 0.15), (found.drive.right, -0.15)):
        wheels = [center(found.urdf, name) for name in side]
        assert wheels == [pytest.approx((x, y, up)) for x in along]
        (rim,) = found.urdf.links[found.urdf.joints[side[0]].child].collisions
        assert rim.shape.size == pytest.approx((radius, float(size.split()[1])))


@pytest.mark.parametrize("x", [-0.15, 0.15])
def test_a_box_with_a_round_end_runs_on_both_ends(tmp_path: Path, x: float) -> None:
    robot = cases.tracked()
    box = "<collision><geometry><box size='0.4 0.06 0.1'/></geometry></collision>"
    assert box in robot.extra
    turned = f"<origin xyz='{x} 0 0' rpy='1.5708 0 0'/>"
    ball = f"<collision>{turned}<geometry><cylinder radius='0.05' length='0.06'/></geometry>"
    extra = robot.extra.replace(box, f"{box}{ball}</collision>")
    found = load_robot(replace(robot, extra=extra).write(tmp_path), SearchPath())
    along = [center(found.urdf, name)[0] for name in found.drive.left]
    assert (min(along), max(along)) == pytest.approx((-0.15, 0.15))
