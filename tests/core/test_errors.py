"""Claims: errors have one root, say where, and suggest what was meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
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
    assert issubclass(cls, ValueError) or cls is not ConfigError


def test_a_file_error_names_the_file_the_line_and_the_problem() -> None:
    error = MapError("maps/a.yaml", "must be positive", "resolution")
    assert str(error) == "maps/a.yaml: resolution: must be positive"
    assert (error.path, error.location) == (Path("maps/a.yaml"), "resolution")
    assert str(WorldError("w.sdf", "is empty")) == "w.sdf: is empty"


NAMES = [
    *(f"odom_alpha{i}" for i in range(1, 6)),
    *("laser_z_hit", "laser_z_max", "laser_z_rand", "laser_z_short", "kld_err", "kld_z"),
    *("max_vel_x", "max_vel_y", "min_vel_x", "max_vel_theta", "min_vel_theta", "sim_time"),
    *("update_min_a", "update_min_d", "robot_base_frame", "base_frame_id", "odom_frame_id"),
    *("inflation_radius", "robot_radius", "transform_tolerance", "xy_goal_tolerance"),
]


PATHS = ["ComputePathThroughPoses", "ComputePathToPose", "ComputeRoute"]


@pytest.mark.parametrize(
    ("typed", "valid", "said"),
    [
        ("max_beam", ["max_beams", "min_particles"], "did you mean 'max_beams'?"),
        ("zzz", ["max_beams", "alpha1"], "valid: alpha1, max_beams"),
        ("zzz", [], "valid: none"),
        ("ComputePath", PATHS, "did you mean 'ComputePathToPose'?"),
    ],
)
def test_a_close_name_or_the_shortest_that_begins_so_is_suggested_and_else_all_are_listed(
    typed: str, valid: list[str], said: str
) -> None:
    assert nearest(typed, valid) == said


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("odom_alphal", "odom_alpha1"),
        ("0dom_alpha3", "odom_alpha3"),
        ("kid_err", "kld_err"),
        ("odom frame id", "odom_frame_id"),
        ("Max-Vel-X", "max_vel_x"),
        ("XY_GOAL_TOLERANCE", "xy_goal_tolerance"),
        ("laser_z_hti", "laser_z_hit"),
    ],
)
def test_letters_that_look_alike_are_hardly_a_mistake(typed: str, meant: str) -> None:
    assert nearest(typed, NAMES) == f"did you mean '{meant}'?"


def _misspelt(name: str, rng: np.random.Generator) -> str:
    """Return a name with one letter doubled, left out, swapped with the next, or mistaken."""
    index = int(rng.integers(len(name) - 1))
    left, letter, right = name[:index], name[index], name[index + 1 :]
    return [
        f"{left}{letter}{letter}{right}",
        f"{left}{right}",
        f"{left}{right[0]}{letter}{right[1:]}",
        f"{left}{'qx'[letter == 'q']}{right}",
    ][int(rng.integers(4))]


def test_one_mistake_anywhere_is_understood() -> None:
    rng = np.random.default_rng(0)
    for name in NAMES * 40:
        typed = _misspelt(name, rng)
        assert nearest(typed, NAMES) == f"did you mean '{name}'?", typed
