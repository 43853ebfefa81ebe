"""Parameter files with other values, as substitutions: `RewrittenYaml` and its like."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml
from launch.action import Condition
from launch.by_file import import_by_file
from launch.launch_context import LaunchContext
from launch.substitution import (
    SomeSubstitutionsType,
    Substitution,
    perform_substitutions,
    performed,
)
from launch.substitutions import LaunchConfiguration

from arjuna_core.files.input_file import read_text
from arjuna_core.files.yaml_file import plain, read_yaml

_Texts = Mapping[Any, SomeSubstitutionsType]


class RewrittenYaml(Substitution):
    """The path of a new parameter file: a file's, with other values and keys, below a root."""

    def __init__(
        self,
        source_file: SomeSubstitutionsType,
        param_rewrites: _Texts,
        root_key: SomeSubstitutionsType | None = None,
        key_rewrites: _Texts | None = None,
        value_rewrites: _Texts | None = None,
        convert_types: bool = False,
    ) -> None:
        self.source_file, self.root_key, self._convert = source_file, root_key, convert_types
        self._params, self._keys, self._values = param_rewrites, key_rewrites, value_rewrites

    def perform(self, context: LaunchContext) -> str:
        params, keys, values = (
            performed(context, given or {}) for given in (self._params, self._keys, self._values)
        )

        found: set[str] = set()

        def rewritten(item: Any, path: str, name: str = "") -> Any:
            for known in (path, name):
                if known in params:
                    found.add(known)
                    return converted(params[known])
            if isinstance(item, list):
                return [rewritten(one, f"{path}.{k}") for k, one in enumerate(item)]
            if isinstance(item, dict):
                return {
                    keys.get(key, key): rewritten(below, f"{path}.{key}".strip("."), key)
                    for key, below in item.items()
                }
            return values.get(item, item) if isinstance(item, str) else item

        def converted(text: str) -> Any:
            with suppress(ValueError):
                if self._convert:
                    return float(text) if "." in text else int(text)
            return {"true": True, "false": False}.get(text.lower(), text)

        content = read_yaml(Path(perform_substitutions(context, self.source_file)))
        document = rewritten(content or {}, "")
        for path in params.keys() - found:
            *above, last = path.split(".")
            if "ros__parameters" in above:  # a whole path is there afterwards, in any case
                node = document
                for key in above:
                    node[key] = node = node.get(key) or {}
                node[last] = converted(params[path])
        root = perform_substitutions(context, self.root_key or "").strip("/")
        return str(context.new_file(yaml.safe_dump({root: document} if root else document)))


class ReplaceString(Substitution):
    """The path of a new file: a file's text with others in place of some texts."""

    def __init__(
        self,
        source_file: SomeSubstitutionsType,
        replacements: _Texts,
        condition: Condition | None = None,
    ) -> None:
        self.source_file, self._replacements, self._condition = source_file, replacements, condition

    def perform(self, context: LaunchContext) -> str:
        source = perform_substitutions(context, self.source_file)
        if self._condition is not None and not self._condition.evaluate(context):
            return source
        text = read_text(Path(source))
        for old, new in self._replacements.items():
            text = text.replace(old, perform_substitutions(context, new))
        return str(context.new_file(text))


class HasNodeParams(Substitution):
    """`True` where a parameter file has a section of a node."""

    def __init__(self, source_file: SomeSubstitutionsType, node_name: str) -> None:
        self.source_file, self.node_name = source_file, node_name

    def perform(self, context: LaunchContext) -> str:
        found = read_yaml(Path(perform_substitutions(context, self.source_file)))
        return str(self.node_name in (found or ()))


class LaunchConfigAsBool(LaunchConfiguration):
    """`True` where a configuration is true, 1, yes or on, else `False`."""

    def perform(self, context: LaunchContext) -> str:
        return str(super().perform(context).strip().lower() in ("true", "1", "yes", "on"))


class ParseMultiRobotPose(Substitution):
    """Robots' poses, by name, of an argument such as `robots:=a={x: 1.0}; b={y: 2.0}`.

    Args:
        robots_argument: The argument's name, for `value`, or what holds its text.
    """

    def __init__(self, robots_argument: Any) -> None:
        self.argument = robots_argument

    def value(self) -> dict[str, dict[str, float]]:
        """Return each robot's `x`, `y`, `z` [m], `roll`, `pitch` and `yaw` [rad]."""
        given = (word.partition(":=") for word in sys.argv)
        text = next((text for name, _, text in given if name == self.argument), "")
        pairs = (one.partition("=") for one in text.split(";") if "=" in one)
        zero = dict.fromkeys(("x", "y", "z", "roll", "pitch", "yaw"), 0.0)
        return {name.strip(): {**zero, **plain(pose)} for name, _, pose in pairs}


import_by_file({sys.modules[__name__]: ()})
