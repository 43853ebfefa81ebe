"""Bumpers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from arjuna_sim.devices.device import StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings, reads


@dataclass(frozen=True, kw_only=True)
class BumperSettings(SensorSettings):
    """A bumper: contacts of the link's collision shapes."""

    TITLE: ClassVar[str] = "bumper"


@reads("contact")
def read(tag: SensorTag) -> list[BumperSettings]:
    """Read a bumper."""
    mount = tag.mount(50.0, f"{tag.element.get('name', 'bumper')}/contacts")
    own = tag.text("bumpertopicname") or tag.element.findtext("contact/topic") or ""
    return [BumperSettings(**{**mount, "topic": own.strip() or mount["topic"]})]


@simulates(BumperSettings)
class Bumper(StaticDevice):
    """A switch that is closed while its link touches anything."""

    def rebind(self, model: Any) -> None:
        """Find the link's collision shapes, which carry its name."""
        link = self._settings.link
        body = int(model.site_bodyid[model.site(link).id])
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        self._own = np.zeros(model.ngeom, np.bool_)
        for geom in range(first, first + count):
            self._own[geom] = model.geom(geom).name.startswith(f"{link}//")

    def read(self, data: Any, now: float) -> bool:
        """Return whether one of the shapes touches anything."""
        return bool(self._own[data.contact.geom].any()) if data.ncon else False
