"""Bodies that can be pushed weigh and turn as the box around them, and swing by their hinge."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.model.urdf import Hinge
from tests.sim.builders import simulator

AT = Pose3((0.5, 0.0, 1.0))
CRATE = Entity(
    "crate", (Part(Shape(Kind.BOX, (1.0, 2.0, 3.0)), AT),), start=Pose3((9.0, 0.0, 1.0)), mass=6.0
)


def spawned(entity: Entity) -> Any:
    """Return the model of an empty world and an entity."""
    sim = simulator()
    sim.stage.spawn(entity)
    return sim.stage.scene.model


def test_it_has_the_inertia_of_the_box_around_it() -> None:
    body = spawned(CRATE).body(CRATE.body)
    assert body.mass[0] == 6.0
    assert body.ipos == pytest.approx(AT.position)
    assert body.inertia == pytest.approx((6.5, 5.0, 2.5))


@pytest.mark.parametrize("limits", [None, (-0.5, 1.0)])
def test_it_swings_or_slides_as_its_hinge_says(limits: tuple[float, float] | None) -> None:
    hinge = Hinge(False, (0.0, 0.6, 0.8), (0.1, 0.2, 0.3), limits, 5.0, 2.0)
    model = spawned(replace(CRATE, hinge=hinge))
    body = model.body(CRATE.body)
    joint = int(body.jntadr[0])
    assert body.jntnum[0] == 1
    assert model.jnt_axis[joint] == pytest.approx(hinge.axis)
    assert model.jnt_pos[joint] == pytest.approx(hinge.anchor)
    assert bool(model.jnt_limited[joint]) is (limits is not None)
    assert limits is None or model.jnt_range[joint] == pytest.approx(limits)
    rate = int(model.jnt_dofadr[joint])
    assert (model.dof_damping[rate], model.dof_frictionloss[rate]) == (5.0, 2.0)
    loose = spawned(replace(CRATE, hinge=replace(hinge, slides=True, damping=0.0, friction=0.0)))
    assert loose.jnt_type[joint] != model.jnt_type[joint]
    assert 0.0 < loose.dof_damping[rate] < 5.0


def test_what_is_held_has_no_joint() -> None:
    assert spawned(replace(CRATE, mass=0.0)).body(CRATE.body).jntnum[0] == 0
    assert spawned(CRATE).body(CRATE.body).dofnum[0] == 6
    thin = replace(CRATE, solid=(Part(Shape(Kind.BOX, (1.0, 2.0, 1e-6)), AT),))
    assert np.min(spawned(thin).body(CRATE.body).inertia) > 0.0
