"""Reading the sensors of a world's models."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sdf.model_tags import SdfLink
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.settings import SensorSettings, sensor_kinds
from arjuna_sim.model.world import Fixture

_NAMED = ("topic", "topicname", "imagetopicname", "cameraname", "remapping", "argument")


def read_fixtures(model: str, links: list[SdfLink], T_world: Pose3) -> Iterator[Fixture]:
    """Yield the sensors of a model that stands somewhere; what is not simulated is noted.

    A sensor whose file names no topic publishes below its model's name.
    """
    for link in links:
        for element, T_sensor in link.sensors:
            name = f"{link.name}::{element.get('name', 'sensor')}"
            tag = SensorTag(link.file, element, f"{model}::{name}", ORIGIN)
            kind, readers = element.get("type", "?"), sensor_kinds().readers
            with leaving_out(link.file, tag.label):
                if kind not in readers:
                    problem = f"{tag.label}: type '{kind}' is not simulated"
                    link.file.note(problem, NoteKind.IGNORED)
                    continue
                for settings in readers[kind](tag):
                    own = settings if tag.text(*_NAMED) else _below(settings, model)
                    named = dataclasses.replace(own, name=tag.link, pose=ORIGIN)
                    T = T_sensor @ settings.pose
                    yield Fixture(named, model, T, T_world.inverse() @ T)


def _below(settings: SensorSettings, model: str) -> SensorSettings:
    """Return a sensor whose topics are below a model's name."""
    names = [each.name for each in dataclasses.fields(settings) if each.name.endswith("topic")]
    topics: dict[str, Any] = {
        name: f"{model}/{topic}" for name in names if (topic := getattr(settings, name))
    }
    return dataclasses.replace(settings, **topics)
