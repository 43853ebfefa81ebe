"""Bumpers: contact sensors of links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_sim.devices.device import StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import topic
from arjuna_sim.model.entities import body_name
from arjuna_sim.model.optical import ABOVE
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class BumperSettings(SensorSettings):
    """A bumper: contacts of the link's collision shapes.

    Attributes:
        in_world: Whether its points are in the world's frame rather than the sensor's.
        robot: Its robot's name, which others see where it has the world for its own.
    """

    TITLE: ClassVar[str] = "bumper"
    robot: str = ""
    in_world: bool = True


@dataclass(frozen=True, kw_only=True)
class ContactSettings(BumperSettings):
    """A contact sensor without a ROS plugin, whose messages are those of Gazebo's bridge."""

    TITLE: ClassVar[str] = "contact sensor"


@reads("contact")
def read(tag: SensorTag) -> list[BumperSettings]:
    """Read a bumper, whose messages are `ContactsState` where a ROS plugin makes them."""
    if tag.element.find("plugin") is None:
        mount = tag.mount(50.0, tag.own_topic("contacts"))
        return [ContactSettings(**mount, robot=tag.robot)]
    states = "bumper_states"
    mount = tag.mount(50.0, states)
    mount["topic"] = topic(tag.element, mount["topic"], states, "bumpertopicname")
    in_world = tag.text("framename", default="world") in ABOVE
    return [BumperSettings(**mount, in_world=in_world, robot=tag.robot)]


class Touch(NamedTuple):
    """The contact of one collision shape of a link with another.

    Attributes:
        own: Name of the link's shape, as Gazebo calls it.
        other: Name of what it touches.
        positions: `(N, 3) float64` [m].
        normals: Out of the other, `(N, 3) float64`.
        depths: `(N,) float64` [m].
        forces: Upon the link, `(N, 3) float64` [N].
    """

    own: str
    other: str
    positions: Floats
    normals: Floats
    depths: Floats
    forces: Floats


@simulates(ContactSettings)
@simulates(BumperSettings)
class Bumper(StaticDevice):
    """Feels what a link's collision shapes touch; of a world's sensor those of its whole model."""

    def rebind(self, model: Any) -> None:
        """Find the collision shapes: a link's carry its name, a world's that of their model."""
        super().rebind(model)
        link, self._robot = self._settings.link, self._settings.robot
        if "::" in link:
            self._robot = "robot"  # as entities call the simulator's own
            names = [self._owner(geom) for geom in range(model.ngeom)]
            self._own = np.array([name == link.partition("::")[0] for name in names])
            return
        body = int(model.site_bodyid[model.site(link).id])
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        self._own = np.zeros(model.ngeom, np.bool_)
        for geom in range(first, first + count):
            self._own[geom] = model.geom(geom).name.startswith(f"{link}//")

    def read(self, data: Any, now: float) -> tuple[Touch, ...]:
        """Return what its shapes touch, in the order of MuJoCo's contacts."""
        pairs = data.contact.geom
        found: dict[tuple[int, int], list[Floats]] = {}
        for row in np.flatnonzero(self._own[pairs].any(axis=1)).tolist() if data.ncon else ():
            own, other = pairs[row] if self._own[pairs[row][0]] else pairs[row][::-1]
            found.setdefault((int(own), int(other)), []).append(self._felt(data, row))
        return tuple(self._touch(data, *pair, np.array(each)) for pair, each in found.items())

    def _felt(self, data: Any, row: int) -> Floats:
        """Return position, normal, depth and force of a contact in the world, `(10,)`."""
        contact, force = data.contact[row], np.zeros(6)
        mujoco.mj_contactForce(self._model, data, row, force)
        axes = contact.frame.reshape(3, 3)
        # The normal points from the first geom to the second, upon which the force acts.
        sign = -1.0 if self._own[contact.geom[0]] else 1.0
        return np.concatenate(
            (contact.pos, sign * axes[0], [-contact.dist], sign * force[:3] @ axes)
        )

    def _touch(self, data: Any, own: int, other: int, felt: Floats) -> Touch:
        R, origin = np.eye(3), np.zeros(3)
        if not self._settings.in_world:
            R, origin = data.site_xmat[self._site].reshape(3, 3), data.site_xpos[self._site]
        names = self._called(own), self._called(other)
        positions, normals = (felt[:, :3] - origin) @ R, felt[:, 3:6] @ R
        return Touch(*names, positions, normals, felt[:, 6], felt[:, 7:] @ R)

    def _called(self, geom: int) -> str:
        """Return a geom's name as Gazebo has it, `model::link::collision`."""
        name = self._model.geom(geom).name
        if "//" not in name:
            return f"{self._owner(geom)}::link::collision"
        owner, link, number = f"{self._robot}//{name}".split("//")[-3:]
        suffix = "" if number == "0" or not number.isdigit() else f"_{number}"
        return f"{owner}::{link}::{link}_collision{suffix}"

    def _owner(self, geom: int) -> str:
        """Return the model of the world, or the entity, that a geom is of."""
        model = self._model
        name = model.geom(geom).name or model.body(int(model.geom_bodyid[geom])).name
        return str(name.removeprefix(body_name("")).partition("::")[0])
