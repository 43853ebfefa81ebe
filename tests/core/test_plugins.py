"""Plug-ins by name: their parameters, several at once, a user's own, and mistakes."""

from __future__ import annotations

from dataclasses import dataclass, field, make_dataclass
from typing import Any, ClassVar

import pytest

from arjuna_core.config import flatten, infos, load, param, plugin_names
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import NamedConfigs, PluginTypes


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
