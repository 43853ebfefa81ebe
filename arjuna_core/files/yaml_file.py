"""YAML files read safely, with one error for all that can be wrong with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from arjuna_core.errors import InputFileError


def read_yaml(path: Path, error: type[InputFileError] = InputFileError) -> Any:
    """Return a YAML file's content.

    Args:
        path: The file.
        error: The kind of error to raise.

    Raises:
        InputFileError: The file cannot be read or is no YAML; of the kind asked for.
    """
    try:
        return yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as reason:
        raise error(path, f"cannot be read: {reason.strerror}") from reason
    except UnicodeDecodeError as reason:
        raise error(path, "is no UTF-8 text") from reason
    except yaml.YAMLError as reason:
        raise error(path, *_described(reason)) from reason


def _described(reason: yaml.YAMLError) -> tuple[str, str]:
    """Return what is wrong with a YAML text, and where."""
    if isinstance(reason, yaml.MarkedYAMLError) and reason.problem_mark is not None:
        mark = reason.problem_mark
        return f"is no YAML: {reason.problem}", f"line {mark.line + 1}, column {mark.column + 1}"
    return f"is no YAML: {' '.join(str(reason).split())}", "text"
