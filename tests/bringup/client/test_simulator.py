"""What a client of the simulator sends of a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.client.simulator import resource_of

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(
    ("text", "is_named"),
    [
        ("<robot/>", False),
        ('<mesh filename="base.stl"/>', True),
        ('<mesh scale="1 1 1" filename="meshes/base.stl"/>', True),
        ("<mesh><scale>1 1 1</scale><uri>meshes/base.dae</uri></mesh>", True),
        ('<mesh filename="package://my_robot/meshes/base.stl"/>', True),
        ("<mesh><uri>model://my_robot/base.dae</uri></mesh>", True),
        ('<mesh filename="package://elsewhere/meshes/base.stl"/>', False),
        ('<mesh filename="file:///opt/base.stl"/>', False),
        ('<mesh filename="/opt/base.stl"/>', False),
        ("<include><uri>ground</uri></include>", False),
    ],
)
def test_a_file_is_sent_as_text_unless_meshes_lie_beside_it(
    text: str, is_named: bool, tmp_path: Path
) -> None:
    file = tmp_path / "my_robot/urdf/robot.urdf"
    file.parent.mkdir(parents=True)
    file.write_text(text)
    sent = resource_of(str(file))
    assert (sent.uri, sent.resource_string) == ((str(file), "") if is_named else ("", text))
