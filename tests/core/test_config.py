"""Configurations and the registry of plug-ins."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field, make_dataclass
from typing import Any, ClassVar

import pytest

from arjuna_core.config import flatten, info_of, infos, load, param, plugin_names
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import NamedConfigs, PluginTypes


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


def test_a_config_within_another_keeps_the_defaults_that_it_is_given_there() -> None:
    @dataclass(frozen=True)
    class Cart:
        rear: Lidar = Lidar(beams=90, kind="spinning")

    assert load(Cart, {}) == Cart()
    assert load(Cart, {"rear.kind": "planar"}) == Cart(Lidar(beams=90, kind="planar"))
    with pytest.raises(ConfigError, match=r"'rear.beams' is 0; the least valid is 1"):
        load(Cart, {"rear.beams": 0})


@pytest.mark.parametrize(
    ("values", "config"),
    [
        ({}, Robot()),
        ({"lidar": {"beams": 10}, "speed": 1.0}, Robot(speed=1.0, lidar=Lidar(beams=10))),
        ({"lidar.beams": 10, "speed": 1.0}, Robot(speed=1.0, lidar=Lidar(beams=10))),
        ({"speed": 1, "limits": [1, 2.5]}, Robot(speed=1.0, limits=(1.0, 2.5))),
        ({"radius": float("inf")}, Robot(radius=1e6)),  # the greatest where no bound is named
        ({"radius": None}, Robot()),
        ({"radius": 0.3}, Robot(radius=0.3)),
        ({"stamped": "y"}, Robot(stamped=True)),
    ],
)
def test_what_is_valid_is_read_in_the_types_of_the_fields(
    values: dict[str, Any], config: Robot
) -> None:
    assert repr(load(Robot, values)) == repr(config)


def test_flattening_and_loading_are_inverse() -> None:
    config = Robot(speed=1.5, stamped=True, limits=(0.1,), radius=0.2, lidar=Lidar(7, "spinning"))
    flat = flatten(config)
    assert list(flat) == ["speed", "stamped", "limits", "radius", "lidar.beams", "lidar.kind"]
    assert load(Robot, flat) == config


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
        ({"speed": float("inf")}, "'speed' is inf; the greatest valid is 2.0 m/s"),
        ({"lidar.kind": "round"}, "'lidar.kind' is 'round'; valid: planar, spinning"),
    ],
)
def test_what_is_wrong_is_named_with_what_is_valid(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(f"robot.yaml: {message}")):
        load(Robot, values, "robot.yaml")


def test_what_is_not_a_number_is_none_where_none_is_valid() -> None:
    assert load(Robot, {"radius": float("nan")}, "r").radius is None


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
    info = infos(Robot)["speed"]
    assert info == info_of(dataclasses.fields(Robot)[0])
    assert (info.description, info.unit, info.minimum, info.maximum) == (
        *("Top speed.", "m/s", 0.0, 2.0),
    )


@dataclass(frozen=True)
class SlowConfig:
    speed: float = param(0.1, "Speed.", minimum=0.0)


class Slow:
    Config: ClassVar[type[Any]] = SlowConfig

    def __init__(self, config: SlowConfig, scale: float) -> None:
        self.speed = config.speed * scale


@dataclass(frozen=True)
class FastConfig:
    gear: int = param(3, "Gear.")


class Fast:
    Config: ClassVar[type[Any]] = FastConfig


class Wrapped:
    """Its parameters hold those of what it wraps."""

    @staticmethod
    def config_for(values: dict[str, Any]) -> type[Any]:
        return TYPES.config_of(values.get("inner", "ours::Slow"), values)


class NoConfig:
    pass


TYPES = PluginTypes(
    "drive", {"ours::Slow": f"{__name__}:Slow", "ours::Fast": f"{__name__}:Fast"}, "ours::Slow"
)


@dataclass(frozen=True)
class ServerConfig:
    drives: tuple[str, ...] = plugin_names(("Main",), "The drives.", TYPES)
    rate: float = param(2.0, "Rate.")


def test_without_values_there_is_the_default() -> None:
    config = load(ServerConfig, {})
    assert flatten(config) == {
        "drives": ("Main",),
        "rate": 2.0,
        "Main.speed": 0.1,
        "Main.plugin": "ours::Slow",
    }
    assert set(infos(type(config))) == set(flatten(config))
    assert isinstance(config, ServerConfig)


@pytest.mark.parametrize("name", ["ours::Fast", "ours/Fast", f"{__name__}:Fast"])
def test_several_at_once_each_with_its_own_parameters(name: str) -> None:
    values = {"drives": ["A", "B"], "A": {"plugin": name, "gear": 4}, "B": {"speed": 0.5}}
    config: Any = load(ServerConfig, values)
    assert (config.A.gear, config.B.speed) == (4, 0.5)
    assert config.A.plugin == name.replace("ours/", "ours::")


def test_loading_what_was_flattened_gives_the_same() -> None:
    config = load(ServerConfig, {"drives": ["A"], "A.plugin": "ours/Fast", "A.gear": 5})
    assert load(ServerConfig, flatten(config)) == config


def test_a_plugin_is_made_of_its_parameters() -> None:
    config: Any = load(ServerConfig, {"Main.speed": 2.0})
    assert TYPES.make(config.Main, 3.0).speed == 6.0


@pytest.mark.parametrize("name", ["front-left", "3d", "ours::Main", "a/b", "\u524d", "lambda"])
def test_a_plugin_may_have_any_name(name: str) -> None:
    given = {"drives": [name], f"{name}.speed": 2.0}
    config: Any = load(ServerConfig, given)
    assert TYPES.make(getattr(config, name), 3.0).speed == 6.0
    assert flatten(config)[f"{name}.speed"] == 2.0
    with pytest.raises(ConfigError, match=re.escape(f"'{name}.speed' must be float")):
        load(ServerConfig, {**given, f"{name}.speed": "fast"})


def test_parameters_may_depend_on_values() -> None:
    types = PluginTypes("drive", {"ours::Wrapped": f"{__name__}:Wrapped"}, "ours::Wrapped")
    assert types.config_of("ours::Wrapped", {"inner": "ours::Fast"}) is FastConfig


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"Main.plugin": "ours::Fats", "Main.gear": 2}, r"no drive 'ours::Fats'; did you mean"),
        ({"Main.plugin": "nowhere.at_all:Fast"}, "cannot be imported: No module named 'nowhere'"),
        ({"Main.plugin": f"{__name__}:Missing"}, "cannot be imported: module .* has no attribute"),
        ({"Main.plugin": f"{__name__}:NoConfig"}, "has no dataclass Config"),
        ({"drives": ["a b"]}, "'drives': 'a b' is no name of a plug-in"),
        ({"drives": ["a,"]}, "'a,' is no name of a plug-in; spaces stand between names"),
        ({"Main.sped": 2.0}, "unknown parameter 'Main.sped'; did you mean 'Main.speed'"),
        ({"Main.plugin": "ours::Fast", "Main.speed": 2.0}, "unknown parameter 'Main.speed'"),
        ({"drives": "Main"}, "'drives' must be a list"),
    ],
)
def test_mistakes_are_named(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        load(ServerConfig, values, "server")
    assert len(caught.value.problems) == 1
    assert caught.value.problems[0].startswith("server: ")


@dataclass(frozen=True)
class WheelConfig:
    topic: str = param("", "Topic.")
    radius: float = param(0.1, "Radius.")


@dataclass(frozen=True)
class AxleConfig:
    wheels: str = plugin_names("left", "The wheels.", NamedConfigs(WheelConfig, "topic"))
    inner: ServerConfig = field(default_factory=ServerConfig)


class Axle:
    Config: ClassVar[type[Any]] = AxleConfig


def test_names_in_a_text_have_parameters_each_at_any_depth() -> None:
    types = PluginTypes("axle", {"ours::Axle": f"{__name__}:Axle"}, "ours::Axle")
    item = plugin_names(("A", "B"), "The axles.", types)
    cart: Any = make_dataclass("Cart", [("axles", tuple[str, ...], item)], frozen=True)
    values = {
        "A.wheels": "left right",
        "A.right.radius": 0.3,
        "B.left.topic": "mine",
        "B.inner.drives": ["X"],
        "B.inner.X.plugin": "ours/Fast",
    }
    config: Any = load(cart, values)
    assert (config.A.left.topic, config.A.right.topic) == ("left", "right")
    assert (config.A.left.radius, config.A.right.radius) == (0.1, 0.3)
    assert (config.B.left.topic, config.B.inner.X.gear) == ("mine", 3)
    assert config.A.inner.Main.speed == 0.1
    assert load(cart, flatten(config)) == config
    assert set(infos(type(config))) == set(flatten(config))
    with pytest.raises(ConfigError, match=r"unknown parameter 'A\.right\.topic'"):
        load(cart, {"A.right.topic": "x"})
