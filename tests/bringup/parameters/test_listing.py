"""Listed parameters load again as they were, and say what is known of each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arjuna_core.config import param
from bringup.parameters.files import load_parameters
from bringup.parameters.listing import differences, dump, values_of


@dataclass(frozen=True)
class Drive:
    """Nested."""

    limits: tuple[float, ...] = param((0.5, float("inf")), "Limits.", unit="m/s", maximum=9.0)


@dataclass(frozen=True)
class Config:
    """One of each kind."""

    drive: Drive = Drive()
    name: str = param("off", "Name that YAML would take for a word of its own.")
    tiny: float = param(1e-7, "Tiny.", minimum=0.0)
    radius: float | None = param(None, "Radius.")
    mode: str = param("a", "Mode.", choices=("a", "b"))


def test_what_is_dumped_loads_with_the_same_values(tmp_path: Path) -> None:
    path = tmp_path / "all.yaml"
    given = {"mode": "b", "drive.limits": [0.1]}
    path.write_text(dump([("robot/base", Config, given)]), encoding="utf-8")
    loaded = load_parameters([path])["robot/base"]
    assert values_of(Config, loaded) == values_of(Config, given)


def test_a_line_says_text_unit_bounds_and_default() -> None:
    lines = dump([("n", Config, {"mode": "b"})]).splitlines()
    comments = [line.split("  # ")[-1] for line in lines[2:] if line]
    assert comments[0] == "Limits. [m/s] (at most 9)"
    assert comments[2] == "Tiny. (0 or more)"
    assert comments[4] == "Mode. (a | b) (default a)"
    assert lines[5].startswith("    # radius:")


def test_differences_name_node_name_and_both_values() -> None:
    before, after = {"n": {"x": 1, "y": (1.0,)}}, {"n": {"x": 2, "y": (1.0,)}}
    assert differences(before, after) == ["n: x: 1 -> 2"]
