"""What hangs on each other: chests with drawers, carts with wheels, doors with handles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.files.library import Library
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.spawned import read_entity
from arjuna_sim.model.entities import EntityError
from arjuna_sim.nodes.services.entities import placed
from arjuna_sim.simulation import Simulation
from tests.sim.builders import run, saved_world, simulator

FIXED = "<joint name='w' type='fixed'><parent>world</parent><child>body</child></joint>"
GROUND = """<model name='g'><static>true</static><link name='l'><collision name='c'><geometry>
<plane/></geometry></collision></link></model>"""


def box(name: str, place: str, size: str, mass: float) -> str:
    shape = f"<geometry><box><size>{size}</size></box></geometry>"
    inertial = f"<inertial><mass>{mass}</mass></inertial>"
    solid = f"<collision name='c'>{shape}</collision>"
    return f"<link name='{name}'><pose>{place} 0 0 0</pose>{inertial}{solid}</link>"


def joint(kind: str, parent: str, child: str, axis: str) -> str:
    along = f"<axis><xyz>{axis}</xyz><limit><lower>0</lower><upper>0.4</upper></limit></axis>"
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f"<joint name='{child}' type='{kind}'>{ends}{along}</joint>"


def chest(folder: Path, more: str = "", drawers: int = 3, spawned: bool = False) -> Simulation:
    """Return a chest of 0.8 m ahead whose drawers and knobs lie within it, as Gazebo allows."""
    inside = box("body", "0 0 0.4", "0.5 0.6 0.8", 30.0) + more
    for i in range(drawers):
        z = 0.15 + 0.25 * i
        inside += box(f"d{i}", f"0.03 0 {z}", "0.5 0.5 0.2", 2.0)
        inside += joint("prismatic", "body", f"d{i}", "1 0 0")
        inside += box(f"k{i}", f"0.27 0 {z}", "0.1 0.03 0.03", 0.1)
        inside += joint("revolute", f"d{i}", f"k{i}", "1 0 0")
    model = f"<model name='chest'><pose>3 0 0 0 0 0</pose>{inside}</model>"
    if not spawned:
        return simulator(saved_world(folder, GROUND + model))
    sim = simulator(saved_world(folder, GROUND))
    entity = read_entity("", f"<sdf>{model}</sdf>", Library(folder, SearchPath()))
    place = Pose3((3.0, 0.0, 0.0 if more else 0.4))
    sim.stage.spawn(placed(entity, "chest", place))
    return sim


@pytest.mark.parametrize("spawned", [False, True])
@pytest.mark.parametrize("more", ["", FIXED])
@pytest.mark.parametrize("count", [1, 3])
def test_parts_of_a_model_pass_through_each_other(
    more: str, count: int, spawned: bool, tmp_path: Path
) -> None:
    """A drawer within its chest jumped out of it by 0.46 m, past its limit of 0.4 m."""
    sim = chest(tmp_path, more, count, spawned)
    names = [one.name for one in sim.stage.entities if one.mass > 0.0]
    before = {name: sim.stage.motion(name).pose.position for name in names}
    assert len(before) == 2 * count + (not more)
    run(sim, 2.0)
    for name, position in before.items():
        assert sim.stage.motion(name).pose.position == pytest.approx(position, abs=2e-3)


@pytest.mark.parametrize("of", ["model", "link"])
def test_parts_that_collide_with_their_model_do(of: str, tmp_path: Path) -> None:
    """`<self_collide>` was not read: a cube fell through another's cube of its model."""
    tag = "<self_collide>1</self_collide>"
    lift, upper = box("lift", "0 0 1.2", "0.2 0.2 0.2", 1.0), box("m", "0 0 0.9", "0.1 0.1 0.1", 1)
    lower = box("stop", "0 0 0.3", "0.2 0.2 0.2", 1.0)
    axis = "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>0.2</upper></limit></axis>"
    slide = (
        f"<joint name='s' type='prismatic'><parent>body</parent><child>lift</child>{axis}</joint>"
    )
    tied = "<joint name='t' type='fixed'><parent>lift</parent><child>m</child></joint>"
    hold = joint("revolute", "body", "stop", "0 0 1")
    inside = box("body", "1 0 0.5", "0.1 0.1 1", 1.0) + FIXED + lift + upper + lower
    inside = inside.replace("<pose>0 0 0.3", f"{tag * (of == 'link')}<pose>0 0 0.3")
    parts = f"{tag * (of == 'model')}{inside}{slide}{tied}{hold}"
    sim = simulator(saved_world(tmp_path, f"{GROUND}<model name='press'>{parts}</model>"))
    run(sim, 2.0)
    found = sim.stage.motion("press::lift").pose.position[2]
    assert found == pytest.approx(0.75, abs=0.02)


@pytest.mark.parametrize("more", ["", FIXED])
@pytest.mark.parametrize("spawned", [False, True])
def test_what_hangs_on_a_thing_goes_with_it(more: str, spawned: bool, tmp_path: Path) -> None:
    sim = chest(tmp_path, more, spawned=spawned)
    sim.stage.move("chest", Pose3((3.0, 2.0, 0.0 if more else 0.4)))
    run(sim, 0.5)
    for name, x, z in (("chest::d1", 3.03, 0.4), ("chest::k1", 3.27, 0.4)):
        found = sim.stage.motion(name).pose.position
        assert found == pytest.approx((x, 2.0, z), abs=5e-3)
    with pytest.raises(EntityError, match="'chest::k0' hangs on 'chest::d0': that can be moved"):
        sim.stage.move("chest::k0", Pose3())
    sim.stage.delete("chest::d0")
    assert {"chest::d0", "chest::k0"}.isdisjoint(one.name for one in sim.stage.entities)
    sim.stage.delete("chest")
    assert not [one.name for one in sim.stage.entities if one.name.startswith("chest")]


@pytest.mark.parametrize(("wheels", "rolls"), [("", False), ("revolute", True)])
def test_a_cart_rolls_on_its_wheels(wheels: str, rolls: bool, tmp_path: Path) -> None:
    inside = box("body", "0 0 0.25", "0.6 0.4 0.1", 20.0)
    disc = "<geometry><cylinder><radius>0.1</radius><length>0.04</length></cylinder></geometry>"
    for i, (x, y) in enumerate([(0.2, 0.25), (0.2, -0.25), (-0.2, 0.25), (-0.2, -0.25)]):
        kind = wheels or "fixed"
        inside += f"<link name='w{i}'><pose>{x} {y} 0.1 1.5708 0 0</pose><collision name='c'>{disc}"
        inside += f"</collision></link><joint name='j{i}' type='{kind}'><parent>body</parent>"
        inside += f"<child>w{i}</child><axis><xyz>0 0 1</xyz></axis></joint>"
    model = f"<model name='cart'><pose>2 0 0 0 0 0</pose>{inside}</model>"
    sim = simulator(saved_world(tmp_path, GROUND + model))
    run(sim, 0.5)
    assert sim.stage.motion("cart").pose.position == pytest.approx((2.0, 0.0, 0.25), abs=0.01)
    sim.stage.push("cart", np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    run(sim, 2.0, Velocity())
    assert (sim.stage.motion("cart").pose.position[0] - 2.0 > 0.3) is rolls


@pytest.mark.parametrize("static", [0, 1])
def test_a_lidar_of_several_rows_on_a_model_of_the_world_scans(static: int, tmp_path: Path) -> None:
    """Its two sensors had one site each, of one name: the simulator did not start."""
    scan = "<horizontal><samples>9</samples></horizontal><vertical><samples>4</samples></vertical>"
    span = "<range><min>0.1</min><max>9</max></range>"
    lidar = f"<sensor name='eye' type='gpu_lidar'><lidar><scan>{scan}</scan>{span}</lidar></sensor>"
    mast = box("body", "0 0 0.4", "0.2 0.2 0.8", 3.0).replace("</link>", f"{lidar}</link>")
    model = f"<model name='mast'><static>{static}</static><pose>3 0 0 0 0 0</pose>{mast}</model>"
    sim = simulator(saved_world(tmp_path, GROUND + model))
    run(sim, 0.5)
    topics = sorted(each.settings.topic for each in sim.stage.world.sensors)
    assert topics == ["mast/scan", "mast/scan/points"]
