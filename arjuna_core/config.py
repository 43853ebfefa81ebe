"""Configuration: each parameter's default, bounds, unit and text live in one dataclass field."""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar, Union, get_args, get_origin

from arjuna_core.errors import ConfigError, closest, nearest
from arjuna_core.param import (
    SEED_MAX,
    ParamInfo,
    angle_param,
    duration_param,
    fixed,
    info_of,
    key_of,
    length_param,
    param,
    plugin_names,
    share_param,
    speed_param,
    yaw_rate_param,
)
from arjuna_core.plugins import config_class_for, type_hints

T = TypeVar("T")
_BOOLS = {"y": True, "Y": True, "n": False, "N": False}  # of rcl, beside those that YAML reads


@dataclasses.dataclass(frozen=True)
class NoParameters:
    """A configuration without parameters."""


def flatten(config: Any, prefix: str = "") -> dict[str, Any]:
    """Return a config dataclass as `{dotted name: value}`, nested dataclasses as prefixes."""
    result: dict[str, Any] = {}
    for item in dataclasses.fields(config):
        value = getattr(config, item.name)
        if dataclasses.is_dataclass(value):
            result.update(flatten(value, f"{prefix}{key_of(item)}."))
        else:
            result[prefix + key_of(item)] = value
    return result


def infos(cls: type[Any], prefix: str = "") -> dict[str, ParamInfo]:
    """Return what is known of each parameter of a config dataclass, by dotted name."""
    hints = type_hints(cls)
    result: dict[str, ParamInfo] = {}
    for item in dataclasses.fields(cls):
        hint = hints[item.name]
        if dataclasses.is_dataclass(hint):
            result.update(infos(hint, f"{prefix}{key_of(item)}."))  # type: ignore[arg-type]
        else:
            result[prefix + key_of(item)] = info_of(item)
    return result


def load(
    cls: type[T],
    values: Mapping[str, Any],
    where: str = "",
    warn: Callable[[str], None] | None = None,
) -> T:
    """Build a config from a mapping, nested or with dotted names.

    Args:
        cls: A frozen dataclass whose fields come from `param` or are such dataclasses themselves;
            where it lists plug-ins, the config is of a subclass with a field for each.
        values: The values that differ from the defaults.
        where: What to name in errors, a file or a node.
        warn: Takes a sentence for each key that is unknown, which then is passed over.

    Raises:
        ConfigError: Keys are unknown and nobody is to be warned, or values of the wrong type or
            outside their bounds; it names all of them.
    """
    problems: list[str] = []
    prefix = f"{where}: " if where else ""
    flat = dotted(values)
    if warn is not None:
        known = infos(config_class_for(cls, dict(flat), prefix, []))
        for name in [name for name in flat if name not in known]:
            warn(f"{prefix}unknown parameter '{name}'{closest(name, known)}")
            del flat[name]
    config = _build(config_class_for(cls, flat, prefix, problems), flat, "", prefix, problems)
    if problems:
        raise ConfigError(*problems)
    return config


def dotted(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a mapping of mappings as `{dotted name: value}`."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, Mapping):
            flat.update(dotted(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _build(
    cls: type[T],
    flat: dict[str, Any],
    prefix: str,
    where: str,
    problems: list[str],
    default: T | None = None,
) -> T:
    """Build a config; a wrong value is added to the problems and replaced by its default.

    A config within another has the defaults that the other gives it, which need not be its class's.
    """
    default = cls() if default is None else default
    hints = type_hints(cls)
    arguments: dict[str, Any] = {}
    known: list[str] = []
    before = len(problems)
    for item in dataclasses.fields(cls):  # type: ignore[arg-type]
        name, hint = prefix + key_of(item), hints[item.name]
        if dataclasses.is_dataclass(hint):
            nested = {k: v for k, v in flat.items() if k.startswith(f"{name}.")}
            own = getattr(default, item.name)
            arguments[item.name] = _build(hint, nested, f"{name}.", where, problems, own)  # type: ignore[arg-type]
            known.extend(nested)
            continue
        known.append(name)
        arguments[item.name] = getattr(default, item.name)
        if name in flat:
            try:
                arguments[item.name] = check(name, flat[name], hint, info_of(item), where)
            except ConfigError as error:
                problems.extend(error.problems)
    unknown = [name for name in flat if name not in known]
    valid = flatten(default, prefix) if unknown else {}
    problems += [f"{where}unknown parameter '{name}'; {nearest(name, valid)}" for name in unknown]
    if len(problems) > before:
        return default
    try:
        return cls(**arguments)
    except ConfigError as error:  # its values are at odds with each other
        problems += [f"{where}{problem}" for problem in error.problems]
        return default


def check(name: str, value: Any, hint: Any, info: ParamInfo, where: str = "") -> Any:
    """Return a value converted to its parameter's type.

    An endless one is the greatest there is, unless the parameter has a bound of its own.

    Args:
        hint: The field's type: bool, int, float, str, `tuple[T, ...]` or one of them or None.
        where: Prefix of the message.

    Raises:
        ConfigError: The value is of the wrong type, no number, out of bounds or no valid choice.
    """
    result = _convert(name, value, hint, where)
    if isinstance(result, float) and math.isinf(result):
        own = info.minimum if result < 0.0 else info.maximum
        result = result if own is not None else info.bounds[result > 0.0]
    for scalar in result if isinstance(result, tuple) else (result,):
        _check_bounds(name, scalar, info, where)
    return result


def _convert(name: str, value: Any, hint: Any, where: str) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        if value is None or (type(value) is float and math.isnan(value)):  # YAML's .nan is none
            return None
        hint = next(arm for arm in get_args(hint) if arm is not type(None))
    if get_origin(hint) is tuple:
        if isinstance(value, str) or not isinstance(value, Sequence):
            raise ConfigError(f"{where}'{name}' must be a list, got {value!r}")
        return tuple(_convert(name, entry, get_args(hint)[0], where) for entry in value)
    if hint is bool and isinstance(value, str) and value in _BOOLS:
        return _BOOLS[value]
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type(value) is not hint:
        raise ConfigError(
            f"{where}'{name}' must be {hint.__name__}, got {value!r} ({type(value).__name__})"
        )
    return value


def _check_bounds(name: str, value: Any, info: ParamInfo, where: str) -> None:
    if type(value) in (int, float):
        unit = f" {info.unit}" if info.unit else ""
        low, high = info.bounds
        if math.isnan(value):
            raise ConfigError(f"{where}'{name}' is not a number")
        if value < low:
            raise ConfigError(f"{where}'{name}' is {value}; the least valid is {low}{unit}")
        if value > high:
            problem = f"'{name}' is {value}; the greatest valid is {high}{unit}"
            raise ConfigError(f"{where}{problem}")
    if info.choices and value not in info.choices:
        valid = ", ".join(str(choice) for choice in info.choices)
        raise ConfigError(f"{where}'{name}' is {value!r}; valid: {valid}")
