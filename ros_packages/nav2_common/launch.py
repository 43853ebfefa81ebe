"""Parameter files with other values, as substitutions: `RewrittenYaml` and its like."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from launch.condition import Condition
from launch.launch_context import LaunchContext
from launch.substitution import SomeSubstitutionsType, Substitution, perform_substitutions

from arjuna_core.files.input_file import read_text
from arjuna_core.files.yaml_file import read_yaml

__all__ = ["HasNodeParams", "ReplaceString", "RewrittenYaml"]
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
        """Write the file and return its path."""
        params, keys, values = (
            {name: perform_substitutions(context, value) for name, value in (given or {}).items()}
            for given in (self._params, self._keys, self._values)
        )

        def rewritten(item: Any, path: str, name: str = "") -> Any:
            if isinstance(item, dict):
                return {
                    keys.get(key, key): rewritten(below, f"{path}.{key}".strip("."), key)
                    for key, below in item.items()
                }
            found = params.get(name, params.get(path))
            if found is None:
                return values.get(item, item) if isinstance(item, str) else item
            return yaml.safe_load(found) if self._convert or found in _TRUTHS else found

        document = rewritten(read_yaml(Path(perform_substitutions(context, self.source_file))), "")
        root = perform_substitutions(context, self.root_key or "").strip("/")
        return _written(yaml.safe_dump({root: document} if root else document))


_TRUTHS = ("true", "True", "false", "False")


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
        """Write the file and return its path; the source's where the condition does not hold."""
        source = perform_substitutions(context, self.source_file)
        if self._condition is not None and not self._condition.evaluate(context):
            return source
        text = read_text(Path(source))
        for old, new in self._replacements.items():
            text = text.replace(old, perform_substitutions(context, new))
        return _written(text)


class HasNodeParams(Substitution):
    """`True` where a parameter file has a section of a node."""

    def __init__(self, source_file: SomeSubstitutionsType, node_name: str) -> None:
        self.source_file, self.node_name = source_file, node_name

    def perform(self, context: LaunchContext) -> str:
        """Return `True` or `False`."""
        found = read_yaml(Path(perform_substitutions(context, self.source_file)))
        return str(self.node_name in found)


def _written(text: str) -> str:
    handle, name = tempfile.mkstemp(suffix=".yaml")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    return name
