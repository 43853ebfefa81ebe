"""Conditions by the value of a substitution."""

from __future__ import annotations

from launch.action import Condition
from launch.launch_context import LaunchContext
from launch.substitution import (
    SomeSubstitutionsType,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from launch.substitutions import is_true


class InvalidConditionExpressionError(ValueError):
    """A condition is neither true nor false."""


def evaluate_condition_expression(
    context: LaunchContext, expression: SomeSubstitutionsType
) -> bool:
    """Return whether an expression is true or 1, rather than false or 0."""
    text = perform_substitutions(context, expression)
    try:
        return is_true(text)
    except ValueError as error:
        raise InvalidConditionExpressionError(f"of a condition: {error}") from error


class IfCondition(Condition):
    """Holds where an expression is true."""

    def __init__(self, predicate_expression: SomeSubstitutionsType) -> None:
        expression = normalize_to_list_of_substitutions(predicate_expression)
        super().__init__(predicate=lambda c: evaluate_condition_expression(c, expression))
        self.__predicate_expression = expression


class UnlessCondition(IfCondition):
    """Holds where an expression is false."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)


class LaunchConfigurationEquals(Condition):
    """Holds where a configuration has a value; None for that it is not set."""

    def __init__(
        self, launch_configuration_name: str, expected_value: SomeSubstitutionsType | None
    ) -> None:
        def equals(context: LaunchContext) -> bool:
            found = context.launch_configurations.get(launch_configuration_name)
            if expected_value is None or found is None:
                return expected_value is None and found is None
            return bool(found == perform_substitutions(context, expected_value))

        super().__init__(predicate=equals)


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """Holds where a configuration has another value."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)
