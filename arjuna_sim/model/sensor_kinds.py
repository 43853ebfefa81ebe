"""The kinds of sensors: each file of `devices/sensors` registers its own."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple, TypeVar

from arjuna_sim.model.settings import SensorSettings

Reader = Callable[[Any], Sequence[SensorSettings]]
"""Returns the settings of the sensors that a `SensorTag` describes."""
Choice = Callable[[Sequence[SensorSettings]], SensorSettings | None]
"""Returns which of all sensors, or what of one, serves the rest of the robot; None for none."""
R = TypeVar("R", bound=Reader)
C = TypeVar("C", bound=Choice)
_PACKAGE = ".".join((*__name__.split(".")[:-2], "devices", "sensors"))
_readers: dict[str, Reader] = {}
_choices: dict[int, Choice] = {}


class SensorKinds(NamedTuple):
    """All kinds: readers by the tags' types, and the choices of the primary sensors."""

    readers: dict[str, Reader]
    choices: tuple[Choice, ...]


def reads(*types: str) -> Callable[[R], R]:
    """Register the reader of `<sensor>` tags of some types."""

    def registered(reader: R) -> R:
        _readers.update(dict.fromkeys(types, reader))
        return reader

    return registered


def chooses(rank: int) -> Callable[[C], C]:
    """Register the choice of a kind's primary sensor; those of lower rank come first."""

    def registered(choice: C) -> C:
        _choices[rank] = choice
        return choice

    return registered


@cache
def sensor_kinds() -> SensorKinds:
    """Return all kinds; their files are imported by name, as plug-ins."""
    package = importlib.import_module(_PACKAGE)
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{_PACKAGE}.{module.name}")
    return SensorKinds(
        dict(sorted(_readers.items())), tuple(_choices[rank] for rank in sorted(_choices))
    )
