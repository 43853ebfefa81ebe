"""Claims: configuration takes what is valid and says what is wrong, where, and what is meant."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from typing import Any

import pytest

from arjuna_core.config import flatten, info_of, infos, load, param
from arjuna_core.errors import ConfigError


@dataclass(frozen=True)
class Lidar:
    """Nested parameters."""

    beams: int = param(360, "Number of beams.", minimum=1, maximum=4096)
    kind: str = param("planar", "Kind.", choices=("planar", "spinning"))


@dataclass(frozen=True)
class Robot:
    """Parameters of every type."""

    speed: float = param(0.5, "Top speed.", unit="m/s", minimum=0.0, maximum=2.0)
    stamped: bool = param(False, "Stamped commands.")
    limits: tuple[float, ...] = param((0.5, 0.0), "Limits.", minimum=-1.0)
    radius: float | None = param(None, "Radius, if round.", minimum=0.0)
    lidar: Lidar = Lidar()


def test_nothing_given_is_all_defaults() -> None:
    assert load(Robot, {}) == Robot()


def test_a_config_within_another_keeps_the_defaults_that_it_is_given_there() -> None:
    @dataclass(frozen=True)
    class Cart:
        rear: Lidar = Lidar(beams=90, kind="spinning")

    assert load(Cart, {}) == Cart()
    assert load(Cart, {"rear.kind": "planar"}) == Cart(Lidar(beams=90, kind="planar"))
    with pytest.raises(ConfigError, match=r"'rear.beams' is 0; the least valid is 1"):
        load(Cart, {"rear.beams": 0})


@pytest.mark.parametrize(
    "values", [{"lidar": {"beams": 10}, "speed": 1.0}, {"lidar.beams": 10, "speed": 1.0}]
)
def test_names_may_be_nested_or_dotted(values: dict[str, Any]) -> None:
    assert load(Robot, values) == Robot(speed=1.0, lidar=Lidar(beams=10))


def test_flattening_and_loading_are_inverse() -> None:
    config = Robot(speed=1.5, stamped=True, limits=(0.1,), radius=0.2, lidar=Lidar(7, "spinning"))
    flat = flatten(config)
    assert list(flat) == ["speed", "stamped", "limits", "radius", "lidar.beams", "lidar.kind"]
    assert load(Robot, flat) == config


def test_an_integer_serves_as_a_float_and_a_list_as_a_tuple() -> None:
    config = load(Robot, {"speed": 1, "limits": [1, 2.5]})
    assert config.speed == 1.0
    assert isinstance(config.speed, float)
    assert config.limits == (1.0, 2.5)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"sped": 1.0}, "unknown parameter 'sped'; did you mean 'speed'?"),
        ({"lidar.beam": 3}, "unknown parameter 'lidar.beam'; did you mean 'lidar.beams'?"),
        ({"lidar": {"knd": "planar"}}, "unknown parameter 'lidar.knd'; did you mean 'lidar.kind'?"),
        ({"lidar": 3}, "unknown parameter 'lidar'; did you mean"),
        ({"speed": "fast"}, "'speed' must be float, got 'fast' (str)"),
        ({"speed": True}, "'speed' must be float, got True (bool)"),
        ({"stamped": 1}, "'stamped' must be bool, got 1 (int)"),
        ({"lidar.beams": 1.5}, "'lidar.beams' must be int, got 1.5 (float)"),
        ({"limits": "0.5"}, "'limits' must be a list, got '0.5'"),
        ({"limits": [0.5, None]}, "'limits' must be float, got None (NoneType)"),
        ({"speed": -0.1}, "'speed' is -0.1; the least valid is 0.0 m/s"),
        ({"speed": 3.0}, "'speed' is 3.0; the greatest valid is 2.0 m/s"),
        ({"limits": [0.5, -2.0]}, "'limits' is -2.0; the least valid is -1.0"),
        ({"speed": float("nan")}, "'speed' is not a number"),
        ({"lidar.kind": "round"}, "'lidar.kind' is 'round'; valid: planar, spinning"),
    ],
)
def test_what_is_wrong_is_named_with_what_is_valid(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(f"robot.yaml: {message}")):
        load(Robot, values, "robot.yaml")


def test_all_that_is_wrong_is_named_at_once() -> None:
    with pytest.raises(ConfigError, match="speed") as caught:
        load(Robot, {"speed": 3.0, "lidar": {"beam": 3, "kind": "round"}}, "r")
    assert [problem.split(";")[0] for problem in caught.value.problems] == [
        "r: 'speed' is 3.0",
        "r: 'lidar.kind' is 'round'",
        "r: unknown parameter 'lidar.beam'",
    ]


def test_the_information_of_all_parameters_is_found_by_dotted_name() -> None:
    assert infos(Robot)["lidar.beams"].maximum == 4096
    assert set(infos(Robot)) == set(flatten(Robot()))


def test_none_is_valid_where_the_type_says_so() -> None:
    assert load(Robot, {"radius": None}).radius is None
    assert load(Robot, {"radius": 0.3}).radius == 0.3


def test_the_information_of_a_field_is_what_was_declared() -> None:
    info = info_of(dataclasses.fields(Robot)[0])
    assert (info.description, info.unit, info.minimum, info.maximum) == (
        "Top speed.",
        "m/s",
        0.0,
        2.0,
    )
