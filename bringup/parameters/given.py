"""Parameters of the command line: `--param NAME:=VALUE`."""

from __future__ import annotations

from collections.abc import Iterable

import yaml

from arjuna_core.errors import ConfigError
from arjuna_core.files.yaml_file import plain
from bringup.parameters.composition import problems_of_change
from bringup.parameters.files import EVERY_NODE, Parameters
from bringup.parameters.foreign.understanding import understand
from bringup.parameters.reading import write_remarks
from bringup.parameters.remarks import Kind
from bringup.stack import all_nodes


def of_words(words: Iterable[str]) -> Parameters:
    """Return the parameters of words as `rcl` reads them: `NAME:=VALUE` or `NODE:NAME:=VALUE`.

    Raises:
        ConfigError: A word is none, or its value is no YAML.
    """
    found: Parameters = {}
    for word in words:
        name, sign, text = word.partition(":=")
        node, _, key = name.rpartition(":")
        if not (sign and key):
            raise ConfigError(f"--param '{word}' is none; valid: NAME:=VALUE, NODE:NAME:=VALUE")
        try:
            value = plain(text)
        except yaml.YAMLError as error:
            raise ConfigError(f"--param {name}: {text!r} is no YAML value") from error
        section = node if node == EVERY_NODE else node.strip("/") or EVERY_NODE
        found.setdefault(section, {})[key] = "" if value is None else value
    return found


def with_words(below: Parameters, words: Iterable[str], namespace: str = "") -> Parameters:
    """Return parameters with those of the command line over them; no name may be unknown.

    Args:
        below: The files' over the shipped ones.
        words: As `of_words` takes them.
        namespace: The robot's.

    Raises:
        ConfigError: A word is none, or its name or value is not valid.
    """
    given = of_words(words)
    if not given:
        return below
    understood = understand(given, below, all_nodes(), namespace)
    after = understood.parameters
    unknown = [str(one) for one in understood.remarks if one.kind is Kind.UNKNOWN]
    problems = [*understood.problems, *unknown, *problems_of_change(below, after, all_nodes())]
    if problems:
        raise ConfigError(*(f"--param: {problem}" for problem in problems))
    write_remarks(understood.remarks)
    return after
