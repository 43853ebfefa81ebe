"""Writing a robot file with the package around it."""

from __future__ import annotations

from pathlib import Path

import trimesh

from tests.sim.robot_files.drives import controllers, drive_tag
from tests.sim.robot_files.options import RobotFile
from tests.sim.robot_files.parts import base, caster, steered, wheel
from tests.sim.world_cases import stl

_MANIFEST = "<package format='3'><name>made_description</name></package>"
_MACROS = """<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>
<xacro:property name='unused' value='${2 * pi}'/>
<xacro:macro name='wheel' params='name parent axis *origin **inside side:=^|left'>
  <link name='$(arg prefix)${name}_wheel_link'><xacro:insert_block name='inside'/></link>
  <joint name='$(arg prefix)${name}_wheel_joint' type='continuous'>
    <xacro:insert_block name='origin'/>
    <parent link='${parent}'/><child link='$(arg prefix)${name}_wheel_link'/><axis xyz='${axis}'/>
    <xacro:if value='$(arg heavy)'><dynamics damping='1'/></xacro:if>
  </joint>
</xacro:macro></robot>"""


def write(robot: RobotFile, folder: Path) -> Path:
    """Write the package of a robot; return its file."""
    package = folder / "made_description"
    ending = "urdf.xacro" if robot.macros else "urdf"
    files = {
        "package.xml": _MANIFEST,
        f"urdf/made.{ending}": _text(robot),
        "urdf/inc/wheel.xacro": _MACROS,
        "config/controllers.yaml": controllers(robot),
    }
    for name, text in files.items():
        path = package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (package / "meshes").mkdir(exist_ok=True)
    unit = trimesh.creation.cylinder(0.5, 1.0, sections=48)  # about z
    (package / "meshes" / "unit.stl").write_bytes(stl(unit.triangles))
    return package / "urdf" / f"made.{ending}"


def _text(robot: RobotFile) -> str:
    parts = [base(robot), *(wheel(robot, *each) for each in robot.wheels())]
    if robot.layout == "two":
        parts.append(caster(robot, -2.5 * robot.radius))
    if robot.layout == "tricycle":
        parts.append(steered(robot, "front", 3.0 * robot.radius, 0.0, ""))
    parts.append(drive_tag(robot))
    head = "<?xml version='1.0'?>\n<robot name='made'"
    if not robot.macros:
        return f"{head}>{''.join(parts)}</robot>".replace("$(find made_description)", "..")
    return (
        f"{head} xmlns:xacro='http://www.ros.org/wiki/xacro'>"
        "<xacro:arg name='prefix' default=''/><xacro:arg name='heavy' default='false'/>"
        f"<xacro:property name='r' value='{robot.radius!r}'/>"
        "<xacro:include filename='$(find made_description)/urdf/inc/wheel.xacro'/>"
        f"{''.join(parts)}</robot>"
    )
