"""Joints of a world beside its models."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.twist import Velocity
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.world import World
from tests.sim.builders import run, simulator, texts

_INERTIAL = "<inertial><mass>4</mass></inertial>"
_LEAF = "<geometry><box><size>0.05 1 1</size></box></geometry>"


def _model(name: str, pose: str, static: bool = False) -> str:
    inside = f"<link name='l'>{_INERTIAL}<collision name='c'>{_LEAF}</collision></link>"
    given = f"<static>{str(static).lower()}</static>"
    return f"<model name='{name}'>{given}<pose>{pose}</pose>{inside}</model>"


def _joint(kind: str, parent: str, child: str, inside: str = "") -> str:
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    axis = "<axis><xyz>0 0 1</xyz></axis>" if kind == "revolute" else ""
    return f"<joint name='j' type='{kind}'>{ends}{axis}{inside}</joint>"


def _world(folder: Path, inside: str) -> Path:
    ground = "<include><uri>model://ground_plane</uri></include>"
    path = folder / "made.world"
    path.write_text(
        f"<sdf version='1.10'><world name='w'>{ground}{inside}</world></sdf>", encoding="utf-8"
    )
    return path


def _read(folder: Path, inside: str) -> World:
    return load_world(_world(folder, inside))


@pytest.mark.parametrize(
    ("parent", "child"), [("world", "door::l"), ("post::l", "door"), ("post", "door::l")]
)
def test_a_door_of_the_world_turns_on_its_hinge(tmp_path: Path, parent: str, child: str) -> None:
    post = _model("post", "2 -2 0.5 0 0 0", static=True)
    hinge = _joint("revolute", parent, child, "<pose>0 -0.5 0 0 0 0</pose>")
    world = _read(tmp_path, post + _model("door", "2 0 0.6 0 0 1.2") + hinge)
    assert texts(world.notes) == ()
    found = world.movable["door::l"].hinge
    assert found is not None
    assert found.axis == pytest.approx((0.0, 0.0, 1.0))
    assert found.anchor == pytest.approx((0.0, -0.5, 0.0))


def test_what_is_fixed_to_the_world_stays_in_the_air(tmp_path: Path) -> None:
    joint = _joint("fixed", "world", "sign")
    sim = simulator(_world(tmp_path, _model("sign", "2 0 2 0 0 0") + joint))
    run(sim, 1.0)
    assert sim.stage.motion("sign").pose == Pose3((2.0, 0.0, 2.0))


def test_a_joint_of_two_that_move_is_left_out_by_name(tmp_path: Path) -> None:
    models = _model("a", "2 0 0.5 0 0 0") + _model("b", "4 0 0.5 0 0 0")
    world = _read(tmp_path, models + _joint("fixed", "a::l", "b::l"))
    assert "joint 'j': connects no model to what stands fast: not simulated" in texts(world.notes)
    assert set(world.movable) == {"a", "b"}


def test_a_cart_and_its_wheels_are_one_body_that_rests_and_is_pushed(tmp_path: Path) -> None:
    box = "<collision name='c'><geometry><box><size>0.4 0.3 0.2</size></box></geometry></collision>"
    disc = "<geometry><cylinder><radius>0.1</radius><length>0.04</length></cylinder></geometry>"
    light = _INERTIAL.replace("4", "0.2")
    wheels = "".join(
        f"<link name='w{i}'><pose>{x} {y} 0.1 1.5708 0 0</pose>{light}<collision name='c'>{disc}"
        f"</collision></link><joint name='j{i}' type='revolute'><parent>l</parent>"
        f"<child>w{i}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        for i, (x, y) in enumerate([(0.15, 0.2), (0.15, -0.2), (-0.15, 0.2), (-0.15, -0.2)])
    )
    body = f"<link name='l'><pose>0 0 0.25 0 0 0</pose>{light}{box}</link>"
    model = f"<model name='cart'><pose>1 0 0 0 0 0</pose>{body}{wheels}</model>"
    sim = simulator(_world(tmp_path, model))
    assert "model 'cart': its links hold together as one body" in texts(sim.world.notes)
    run(sim, 1.0)
    start = sim.stage.motion("cart").pose.position
    assert start == pytest.approx((1.0, 0.0, 0.25), abs=0.01)
    run(sim, 4.0, Velocity(0.4))
    assert sim.stage.motion("cart").pose.position[0] > start[0] + 0.1


def test_a_joint_whose_link_does_not_exist_costs_no_model(tmp_path: Path) -> None:
    world = _read(tmp_path, _model("a", "2 0 0.5 0 0 0") + _joint("fixed", "world", "c::l"))
    assert set(world.movable) == {"a"}
    assert any(note.startswith("joint 'j' is left out") for note in texts(world.notes))
