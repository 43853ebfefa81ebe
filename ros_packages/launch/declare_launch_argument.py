"""The action that declares an argument of a launch file."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from launch.action import Action
from launch.launch_context import LaunchContext
from launch.substitution import (
    SomeSubstitutionsType,
    TextSubstitution,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)


class DeclareLaunchArgument(Action):
    """Declares an argument of the launch file.

    Attributes:
        name: Its name.
        default_value: None where it has to be given.
    """

    def __init__(
        self,
        name: str,
        *,
        default_value: SomeSubstitutionsType | None = None,
        description: str = "",
        choices: Iterable[str] | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.name = self.__name = name
        self.description = self.__description = description or "no description given"
        self.choices = list(choices) if choices is not None else None
        self.default_value = self.__default_value = (
            None if default_value is None else normalize_to_list_of_substitutions(default_value)
        )
        texts = all(isinstance(one, TextSubstitution) for one in self.default_value or ())
        default = "".join(getattr(one, "text", "") for one in self.default_value or ())
        if self.choices and self.default_value and texts and default not in self.choices:
            raise ValueError(f"default '{default}' of '{name}' is not one of {self.choices}")

    def execute(self, context: LaunchContext) -> None:
        known = context.launch_configurations
        if self.name not in known:
            if self.default_value is None:
                raise RuntimeError(
                    f"Required launch argument '{self.name}' was not provided: {self.name}:=VALUE;"
                    f" {self.description}"
                )
            known[self.name] = perform_substitutions(context, self.default_value)
        if self.choices is not None and known[self.name] not in self.choices:
            valid = ", ".join(self.choices)
            raise RuntimeError(f"Argument '{self.name}': '{known[self.name]}'; valid: {valid}")
