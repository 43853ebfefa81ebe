"""Parameters as texts: all of some nodes as a file that loads again, and where two sets differ."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from arjuna_core.config import ParamInfo, flatten, infos, load
from bringup.parameters.files import Parameters


@dataclass(frozen=True)
class Described:
    """One parameter of a node."""

    key: str
    value: Any
    default: Any
    info: ParamInfo


def values_of(cls: type[Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return all values that a node with this config has, given those that differ.

    Raises:
        ConfigError: A value is not valid.
    """
    return flatten(load(cls, values))


def dump(nodes: Iterable[tuple[str, type[Any], Mapping[str, Any]]]) -> str:
    """Return a ROS parameter file with every parameter, its text, unit, bounds and default."""
    lines = []
    for name, cls, values in nodes:
        lines += [f"/{name}:", "  ros__parameters:", *_rows(cls, values), ""]
    return "\n".join(lines)


def described(cls: type[Any], values: Mapping[str, Any]) -> Iterator[Described]:
    """Return every parameter of a node with this config, given the values that differ.

    Raises:
        ConfigError: A value is not valid.
    """
    config = load(cls, values)
    known, defaults = infos(type(config)), flatten(type(config)())
    for key, value in flatten(config).items():
        yield Described(key, value, defaults[key], known[key])


def _rows(cls: type[Any], values: Mapping[str, Any], width: int = 44) -> Iterator[str]:
    for one in described(cls, values):
        value = "" if one.value is None else f" {scalar(one.value)}"
        item = f"    {'# ' if one.value is None else ''}{one.key}:{value}"
        yield f"{item:<{width}}  # {_comment(one)}"


def scalar(value: Any) -> str:
    """Return a value as YAML on one line."""
    plain = list(value) if isinstance(value, tuple) else value
    text = yaml.safe_dump(plain, default_flow_style=True, width=math.inf, allow_unicode=True)
    return text.removesuffix("\n").removesuffix("\n...")


def _comment(one: Described) -> str:
    info = one.info
    parts = [info.description]
    parts += [f"[{info.unit}]"] if info.unit else []
    parts += [bounds(info)] if bounds(info) else []
    parts += [] if one.value == one.default else [f"(default {scalar(one.default)})"]
    return " ".join(parts)


def bounds(info: ParamInfo) -> str:
    """Return what is valid of a parameter, in brackets; empty where all of its type is."""
    if info.choices:
        return f"({' | '.join(str(choice) for choice in info.choices)})"
    if info.minimum is None:
        return "" if info.maximum is None else f"(at most {info.maximum:g})"
    upper = "or more" if info.maximum is None else f"to {info.maximum:g}"
    return f"({info.minimum:g} {upper})"


def differences(before: Parameters, after: Parameters) -> list[str]:
    """Return a line for each value that differs: `node: name: before -> after`."""
    return [
        f"{node}: {name}: {scalar(value)} -> {scalar(after[node][name])}"
        for node, values in before.items()
        for name, value in values.items()
        if after[node][name] != value
    ]
