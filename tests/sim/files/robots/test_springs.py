"""Springs of joints, as of wheels that drop: read from URDF and SDF, and held by the physics."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sim.builders import run, simulator

_INERTIA = "<inertia ixx='0.01' ixy='0' ixz='0' iyy='0.01' iyz='0' izz='0.01'/>"
URDF = f"""<robot name="r"><link name="world"/><link name="leg"><inertial><mass value="2"/>
{_INERTIA}
</inertial></link><joint name="drop" type="prismatic"><parent link="world"/><child link="leg"/>
<origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="-0.5" upper="0.5"/><dynamics damping="20"/>
</joint><gazebo reference="drop"><implicitSpringDamper>true</implicitSpringDamper>
<springStiffness>400</springStiffness><springReference>0.03</springReference></gazebo></robot>"""
SDF = """<sdf version="1.9"><model name="r"><link name="leg"><pose>0 0 1 0 0 0</pose><inertial>
<mass>2</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>
<joint name="drop" type="prismatic"><parent>world</parent><child>leg</child><axis><xyz>0 0 1</xyz>
<limit><lower>-0.5</lower><upper>0.5</upper></limit><dynamics><damping>20</damping>
<spring_stiffness>400</spring_stiffness><spring_reference>0.03</spring_reference></dynamics></axis>
</joint></model></sdf>"""


@pytest.mark.parametrize(("suffix", "text"), [(".urdf", URDF), (".sdf", SDF)])
def test_a_spring_carries_what_hangs_on_it(tmp_path: Path, suffix: str, text: str) -> None:
    path = tmp_path / f"r{suffix}"
    path.write_text(text, encoding="utf-8")
    sim = simulator(robot=path)
    assert not [note for note in sim.notes if "pring" in note]
    seen = run(sim, 3.0)
    assert seen.joints.positions[0] == pytest.approx(0.03 - 2.0 * 9.81 / 400.0, abs=1e-3)
