"""Plug-ins by name: Nav2's class names, and `module:Class` for a user's own."""

from __future__ import annotations

import dataclasses
import functools
import importlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar, get_type_hints

from arjuna_core.errors import ConfigError, nearest
from arjuna_core.param import field_of, fixed, info_of, key_of, param

T = TypeVar("T")
_NAME = re.compile(r"[^\s.,\[\]'\"]+")  # a dot stands between a plug-in's name and a parameter's
type_hints: Callable[[Any], dict[str, Any]] = functools.lru_cache(maxsize=512)(get_type_hints)
"""A class's types by field; a node loads its config for each parameter that is set."""


@dataclass(frozen=True, eq=False)
class PluginTypes:
    """The classes that plug-ins of one kind may be of.

    A class has `Config`, the frozen dataclass of its parameters; where they depend on their values,
    as those of a controller that wraps another, `config_for(values)` returns the dataclass.

    Attributes:
        what: What they are, in a word.
        types: `module:Class` of each of Nav2's class names.
        default: Nav2's name of the class where none is given; empty where one must be.
        by_name: The same for plug-ins of certain names.
        key: Which of a plug-in's parameters names its class.
        stands_in: Whether the default can do the work of a class that cannot be loaded.
    """

    what: str
    types: Mapping[str, str]
    default: str
    by_name: Mapping[str, str] = field(default_factory=dict)
    key: str = "plugin"
    stands_in: bool = False

    def resolve(self, name: str) -> Any:
        """Import the class of a name, `package::Class`, `package/Class` or `module:Class`.

        Raises:
            ConfigError: There is none.
        """
        path = self.types.get(canonical(name))
        if path is not None:
            return _imported(path)
        if ":" not in name.replace("::", ""):
            hint = nearest(canonical(name), self.types)
            raise ConfigError(f"no {self.what} '{name}'; {hint} Or module:Class of your own")
        return _imported(name)

    def make(self, config: Any, *arguments: Any) -> Any:
        """Make a plug-in of its parameters, as `load` made them, and what its kind takes."""
        return self.resolve(getattr(config, field_of(self.key)))(config, *arguments)

    def config_of(self, name: str, values: Mapping[str, Any]) -> type[Any]:
        """Return the dataclass of a class's parameters, given their dotted values.

        Raises:
            ConfigError: There is no such class, or it has none.
        """
        cls = self.resolve(name)
        shape = getattr(cls, "config_for", None)
        config: type[Any] | None = getattr(cls, "Config", None) if shape is None else shape(values)
        if not dataclasses.is_dataclass(config):
            raise ConfigError(f"{self.what} '{name}' has no dataclass Config of its parameters")
        return config


@dataclass(frozen=True, eq=False)
class NamedConfigs:
    """Things that a parameter names, each with the parameters of one dataclass below its name.

    Attributes:
        key: Which of its parameters has the name itself as its default, such as a topic; empty for
            none.
    """

    config: Any
    key: str = ""


def canonical(name: str) -> str:
    """Return a class's name as Nav2 writes it since Iron: `package::Class`."""
    return name if ":" in name else name.replace("/", "::")


def _imported(path: str) -> Any:
    module, _, name = path.partition(":")
    try:
        return getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        missing = isinstance(error, ModuleNotFoundError) and error.name == module
        hint = "; --plugin-path says where it is" if missing else ""
        raise ConfigError(f"plug-in '{path}' cannot be imported: {error}{hint}") from error


def config_class_for(
    cls: type[T], flat: dict[str, Any], where: str, problems: list[str], prefix: str = ""
) -> type[T]:
    """Return a config class with a field for each plug-in that the values name, at any depth.

    Args:
        cls: The class; one whose fields depend on the values has `config_for(values)`.
        flat: Values by dotted name; plug-ins' class names become canonical in it, and what stands
            below a plug-in whose class does not exist is taken out.
        where: Prefix of problems.
        problems: Receives the classes that do not exist; the default replaces them.
        prefix: What stands before the class's parameters in the values' names.
    """
    shape = getattr(cls, "config_for", None)
    cls = cls if shape is None else shape(flat)
    fields: dict[str, type[Any]] = {}
    hints = type_hints(cls)
    for item in dataclasses.fields(cls):  # type: ignore[arg-type]
        kind = info_of(item).plugins if item.metadata else None
        name = prefix + key_of(item)
        if kind is None:
            hint = hints[item.name]
            inner = dataclasses.is_dataclass(hint)
            made = config_class_for(hint, flat, where, problems, f"{name}.") if inner else hint
            fields |= {} if made is hint else {item.name: made}
            continue
        for plugin in names_in(flat.get(name, item.default), item.default):
            if plugin in hints:  # the class itself has its parameters
                continue
            if not _NAME.fullmatch(plugin):
                hint = "; spaces stand between names" if "," in plugin else ""
                problems.append(f"{where}'{name}': '{plugin}' is no name of a plug-in{hint}")
                continue
            config = _plugin_class(kind, plugin, flat, where, problems, prefix)
            fields[plugin] = config_class_for(config, flat, where, problems, f"{prefix}{plugin}.")
    return with_configs(cls, tuple(fields.items())) if fields else cls


def names_in(given: Any, default: Any = ()) -> tuple[str, ...]:
    """Return the names in a list, or in a text with spaces between them.

    Args:
        default: Which of both it has to be; what it is not has these names.
    """
    if isinstance(default, str):
        return tuple((given if isinstance(given, str) else default).split())
    return tuple(map(str, given if isinstance(given, (list, tuple)) else default))


def _plugin_class(
    kind: PluginTypes | NamedConfigs,
    name: str,
    flat: dict[str, Any],
    where: str,
    problems: list[str],
    outer: str,
) -> type[Any]:
    if isinstance(kind, NamedConfigs):
        return _with_default(kind.config, kind.key, name) if kind.key else kind.config
    prefix = f"{outer}{name}."
    key = prefix + kind.key
    default = kind.by_name.get(name, kind.default) or name
    given = canonical(str(flat.get(key, default)))
    below = {k.removeprefix(prefix): v for k, v in flat.items() if k.startswith(prefix)}
    config: Any
    try:
        config = kind.config_of(given, below)
    except ConfigError as error:
        if key not in flat and given == name:
            hint = nearest(name, kind.by_name)
            problems.append(f"{where}'{key}' must name the class of the {kind.what}; {hint}")
        else:
            problems += [f"{where}'{key}': {problem}" for problem in error.problems]
        for k in below:
            del flat[prefix + k]
        if default == name:
            return _NoConfig
        given, config = default, kind.config_of(default, {})
    if key in flat:
        flat[key] = given
    made: type[Any] = _with_class_name(config, kind.what, kind.key, given)
    return made


@dataclass(frozen=True)
class _NoConfig:
    """The parameters of a plug-in whose class does not exist."""


@functools.cache
def _with_default(config: Any, key: str, default: str) -> type[Any]:
    (item,) = (item for item in dataclasses.fields(config) if item.name == key)
    changed = dataclasses.field(default=default, metadata=item.metadata)
    return _subclass(config, [(key, str, changed)])


@functools.cache
def _with_class_name(config: Any, what: str, key: str, given: str) -> type[Any]:
    item = fixed(given, f"Class of the {what}, or module:Class.", choices=(given,))
    return _subclass(config, [(field_of(key), str, item)])


def names_below(values: Mapping[str, Any], prefix: str) -> list[str]:
    """Return the names that stand below a prefix in dotted names, in their order."""
    below = (key.removeprefix(f"{prefix}.") for key in values if key.startswith(f"{prefix}."))
    names = (key.partition(".")[0] for key in below if "." in key)
    return list(dict.fromkeys(names))


def with_configs(cls: type[T], fields: tuple[tuple[str, Any], ...]) -> type[T]:
    """Return a config class with fields for the parameters of others, by name and class."""
    base: Any = cls
    made: type[T] = _with_configs(base, fields)
    return made


@functools.cache
def _with_configs(cls: Any, fields: tuple[tuple[str, Any], ...]) -> type[Any]:
    made = ((name, kind, dataclasses.field(default_factory=kind)) for name, kind in fields)
    return _subclass(cls, [(field_of(name), kind, item) for name, kind, item in made])


@functools.cache
def with_values(
    cls: Any, names: tuple[str, ...], default: Any, description: str, read_only: bool = False
) -> type[Any]:
    """Return a config class with a parameter of one default for each of some names."""
    kinds = {field_of(name): param(default, description, read_only=read_only) for name in names}
    return _subclass(cls, [(name, type(default), item) for name, item in kinds.items()])


def _subclass(cls: type[Any], fields: list[tuple[str, Any, Any]]) -> type[Any]:
    made: type[Any] = dataclasses.make_dataclass(
        cls.__name__, fields, bases=(cls,), namespace={"__getattr__": _by_key}, frozen=True
    )
    made.__module__ = cls.__module__
    return made


def _by_key(config: Any, key: str) -> Any:
    """Return what a config has of a parameter or plug-in whose name is none in Python."""
    name = field_of(key)
    if name == key:
        raise AttributeError(f"{type(config).__name__} has no '{key}'")
    return getattr(config, name)
