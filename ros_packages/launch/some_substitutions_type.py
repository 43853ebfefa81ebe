"""The type of what may be a text or a substitution."""

from launch.substitution import SomeSubstitutionsType

__all__ = ["SomeSubstitutionsType"]
