"""Claims: errors have one root, say where, and suggest what was meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import (
    ArjunaError,
    ConfigError,
    InputFileError,
    MapError,
    RobotError,
    WorldError,
    nearest,
)


@pytest.mark.parametrize("cls", [ConfigError, InputFileError, MapError, RobotError, WorldError])
def test_every_error_has_the_root(cls: type[Exception]) -> None:
    assert issubclass(cls, ArjunaError)


def test_a_config_error_is_a_value_error() -> None:
    assert issubclass(ConfigError, ValueError)


def test_a_file_error_names_the_file_the_place_and_the_problem() -> None:
    error = MapError("maps/a.yaml", "must be positive", "resolution")
    assert str(error) == "maps/a.yaml: resolution: must be positive"
    assert (error.path, error.place) == (Path("maps/a.yaml"), "resolution")
    assert str(WorldError("w.sdf", "is empty")) == "w.sdf: is empty"


def test_a_close_name_is_suggested_and_else_all_are_listed() -> None:
    valid = ["max_beams", "min_particles", "alpha1"]
    assert nearest("max_beam", valid) == "did you mean 'max_beams'?"
    assert nearest("zzz", valid) == "valid: alpha1, max_beams, min_particles"
    assert nearest("zzz", []) == "valid: none"
