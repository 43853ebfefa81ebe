"""The type of what makes one text; the real package has it in a file of its own."""

from __future__ import annotations

import os
from collections.abc import Iterable

from launch.substitution import SomeSubstitutionsType, Substitution

__all__ = ["SomeSubstitutionsType", "SomeSubstitutionsType_types_tuple"]

SomeSubstitutionsType_types_tuple = (str, os.PathLike, Substitution, Iterable)
