"""What the `<state>` of a saved world says of its models."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.geometry.shapes import corners
from tests.sim.builders import texts

MODEL = """<model name='m'><static>1</static><link name='l'><collision name='c'>
<pose>0 0 1 0 0 0</pose><geometry>{0}</geometry></collision>
<visual name='v'><geometry>{0}</geometry></visual></link></model>"""
STATE = """<state world_name='w'><model name='m'><pose>7 8 0 0 0 0</pose><scale>{}</scale></model>
</state>"""
BOX = "<box><size>1 0.5 2</size></box>"
MESH = "<mesh><uri>tetra.obj</uri>{}</mesh>"
TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize(
    ("shape", "scale", "extent"),
    [
        (BOX, "7 0.2 1", (7.0, 0.1, 2.0)),
        (BOX, "1 1 1", (1.0, 0.5, 2.0)),
        (BOX, "7 much 1", (1.0, 0.5, 2.0)),
        ("<sphere><radius>0.5</radius></sphere>", "2 1 1", (2.0, 2.0, 2.0)),
        ("<cylinder><radius>0.5</radius><length>1</length></cylinder>", "2 1 3", (2.0, 2.0, 3.0)),
        (MESH.format(""), "2 3 4", (2.0, 3.0, 4.0)),
        (MESH.format("<scale>0.5 0.5 0.5</scale>"), "2 3 4", (1.0, 1.5, 2.0)),
    ],
)
def test_models_that_were_stretched_are_so_where_they_were(
    tmp_path: Path, shape: str, scale: str, extent: tuple[float, ...]
) -> None:
    (tmp_path / "tetra.obj").write_text(TETRA, encoding="utf-8")
    path = tmp_path / "saved.world"
    text = MODEL.format(shape) + STATE.format(scale)
    path.write_text(f"<sdf version='1.6'><world name='w'>{text}</world></sdf>", encoding="utf-8")
    world = load_world(path)
    parts = [body.part for body in world.bodies if body.model == "m"]
    assert len(parts) == 2
    for part in parts:
        points = corners(part.shape)
        assert (points.max(axis=0) - points.min(axis=0)).tolist() == pytest.approx(extent)
    assert parts[0].pose.position == pytest.approx((7.0, 8.0, 1.0))
    assert any("<scale>" in text for text in texts(world.notes)) is ("much" in scale)


@pytest.mark.parametrize(
    ("plugin", "x", "long"),
    [
        ("", 7.0, 7.0),
        ("<plugin filename='f' name='p'/>", 7.0, 7.0),
        ("<plugin filename='gz-sim-physics-system' name='gz::sim::systems::Physics'/>", 0.0, 1.0),
        ("<plugin filename='f' name='ignition::gazebo::systems::Physics'/>", 0.0, 1.0),
    ],
)
def test_worlds_of_gazebo_sim_have_no_state(
    tmp_path: Path, plugin: str, x: float, long: float
) -> None:
    path = tmp_path / "saved.sdf"
    text = plugin + MODEL.format(BOX) + STATE.format("7 1 1")
    path.write_text(f"<sdf version='1.6'><world name='w'>{text}</world></sdf>", encoding="utf-8")
    part = next(body.part for body in load_world(path).bodies if body.model == "m")
    assert (part.pose.position[0], part.shape.size[0]) == pytest.approx((x, long))
