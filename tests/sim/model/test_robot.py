"""A robot's outline from above."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_sim.inputs import footprint_of, named_robot
from arjuna_sim.model.robot import footprint

_ROBOT = """<robot name="r">
  <link name="base"><collision><origin xyz="0.1 0 0.2" rpy="0 0 {turn}"/>
    <geometry><box size="0.6 0.2 0.1"/></geometry></collision>
    <visual><geometry><box size="9 9 9"/></geometry></visual></link>
  <link name="mast"><collision><geometry><cylinder radius="0.05" length="1"/></geometry>
    </collision></link>
  <joint name="j" type="fixed"><parent link="base"/><child link="mast"/>
    <origin xyz="0 {mast} 0"/></joint>
  {wheels}
</robot>"""
_WHEEL = """<link name="{side}_wheel"><visual><geometry><cylinder radius="0.05" length="0.04"/>
    </geometry></visual></link>
  <joint name="{side}_wheel_joint" type="continuous"><parent link="base"/>
    <child link="{side}_wheel"/><axis xyz="0 0 1"/><origin xyz="0 {y} 0" rpy="-1.5707963 0 0"/>
  </joint>"""


def _outline(folder: Path, turn: float = 0.0, mast: float = 0.0, wheels: bool = False) -> set[str]:
    path = folder / "r.urdf"
    pair = (_WHEEL.format(side="left", y=0.2) + _WHEEL.format(side="right", y=-0.2)) * wheels
    path.write_text(_ROBOT.format(turn=turn, mast=mast, wheels=pair), encoding="utf-8")
    return {f"{x:.2f} {y:.2f}" for x, y in footprint(named_robot(str(path), ""), "base")}


def test_it_is_the_hull_of_what_is_solid(tmp_path: Path) -> None:
    assert _outline(tmp_path) == {"0.40 0.10", "0.40 -0.10", "-0.20 0.10", "-0.20 -0.10"}
    turned = {one.split()[1] for one in _outline(tmp_path, turn=np.pi / 2)}
    assert {"0.30", "-0.30"} <= turned


def test_what_stands_out_widens_it(tmp_path: Path) -> None:
    ys = [float(one.split()[1]) for one in _outline(tmp_path, mast=0.4)]
    assert max(ys) == pytest.approx(0.45, abs=0.003)


def test_wheels_without_a_solid_shape_count_by_their_looks(tmp_path: Path) -> None:
    ys = [float(one.split()[1]) for one in _outline(tmp_path, wheels=True)]
    assert max(ys) == pytest.approx(0.22, abs=0.003)


def test_it_is_in_the_frame_that_is_asked_for(tmp_path: Path) -> None:
    _outline(tmp_path, mast=0.4)
    robot = named_robot(str(tmp_path / "r.urdf"), "")
    low = footprint(robot, "mast").min(axis=0) - footprint(robot, "base").min(axis=0)
    np.testing.assert_allclose(low, (0.0, -0.4), atol=1e-3)
    assert footprint_of(robot, "nowhere") == footprint_of(robot, "base")


def test_a_robot_without_a_solid_shape_has_none(tmp_path: Path) -> None:
    path = tmp_path / "none.urdf"
    path.write_text('<robot name="r"><link name="base"/></robot>', encoding="utf-8")
    assert footprint_of(named_robot(str(path), ""), "base") == ""
