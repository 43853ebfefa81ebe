"""A campaign's runs: one command with every combination of the factors' levels."""

from __future__ import annotations

import dataclasses
import itertools
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from arjuna_core.errors import ArjunaError, InputFileError, nearest
from arjuna_core.files.shipped import found_or_shipped
from arjuna_core.files.yaml_file import check_keys, read_yaml

CHANCE = "seed"
"""The factor that repeats runs: its levels are not shown one by one."""
FOLDER = "{folder}"
"""The placeholder in a command for the folder of a run."""
LARGEST = 1 << 30
"""The size of a file that a run reads or writes, at most [bytes]."""
_RUNS_MAX = 100_000  # more are taken for a mistake in the factors
_KEYS = (
    *("command", "result", "factors", "success", "measures", "timeout", "compare"),
    *("cpus", "memory"),
)
_RANGE = {"first", "count"}
UNFIT = re.compile(r"[^\w.+-]+")
Scalar = str | int | float | bool


class CampaignError(InputFileError):
    """A campaign's file or folder cannot be used."""


@dataclass(frozen=True)
class Level:
    """One value of a factor: its label in tables, and what it adds to the command."""

    label: str
    options: Mapping[str, Scalar]


@dataclass(frozen=True)
class Campaign:
    """A command, what it is varied in, and how its result is judged.

    Attributes:
        command: The words after `python -m bringup`; `{folder}` stands for the run's folder.
        result: The JSON file that a run writes, in its folder.
        success: What a run's result must say: a value, or `at_least` and `at_most`, by key.
        measures: Keys of the numbers to draw; all numbers if empty.
        timeout: How long a run may take [s].
        compare: The factor whose levels are compared, each with the first; "" for none.
        cpus: How many a run keeps busy, for a cluster to plan with; 0 to measure it.
        memory: How much a run takes at most [MB], for the same; 0 to measure it.
    """

    name: str
    command: tuple[str, ...]
    result: str
    factors: Mapping[str, tuple[Level, ...]]
    success: Mapping[str, Any]
    measures: tuple[str, ...] = ()
    timeout: float = 3600.0
    compare: str = ""
    cpus: float = 0.0
    memory: float = 0.0

    @property
    def conditions(self) -> list[str]:
        """The factors by which figures are shown: with levels to choose from, and not chance."""
        shown = (name for name, levels in self.factors.items() if len(levels) > 1)
        return [name for name in shown if name not in (CHANCE, self.compare)]

    def with_level(self, factor: str, label: str, options: Sequence[str]) -> Campaign:
        """Return the campaign with one more labelled level of a factor, options as NAME=VALUE.

        Raises:
            ArjunaError: There is no such factor, it has the level, or an option is not valid.
        """
        if factor not in self.factors:
            raise ArjunaError(f"no factor '{factor}'; {nearest(factor, self.factors)}")
        if any(level.label == label for level in self.factors[factor]):
            raise ArjunaError(f"factor '{factor}' has a level '{label}'; valid: a new name")
        split = [option.partition("=") for option in options]
        if wrong := [name for name, sign, _ in split if not name or not sign]:
            raise ArjunaError(f"'{wrong[0]}' is no option of a level; valid: NAME=VALUE")
        level = Level(label, {name: value for name, _, value in split})
        factors = {**self.factors, factor: (*self.factors[factor], level)}
        return dataclasses.replace(self, factors=factors)


@dataclass(frozen=True)
class Run:
    """One run of a campaign."""

    name: str
    levels: Mapping[str, str]
    options: Mapping[str, Scalar] = field(default_factory=dict)

    def words(self, campaign: Campaign, folder: Path) -> list[str]:
        """Return the words after `python -m bringup`, results going to a folder.

        A path that leads nowhere from here is the shipped file's of that name.
        """
        options = itertools.chain.from_iterable(
            (f"--{name}", str(value)) for name, value in self.options.items()
        )
        words = [found_or_shipped(word) for word in (*campaign.command, *options)]
        return [word.replace(FOLDER, str(folder)) for word in words]


def load_campaign(path: Path) -> Campaign:
    """Return the campaign that a YAML file describes.

    Raises:
        CampaignError: The file cannot be read, or a key or value is not valid; all are named.
    """
    path = Path(found_or_shipped(str(path)))
    return campaign_of(path, read_yaml(path, CampaignError))


def campaign_of(path: Path, content: Any, others: Sequence[str] = ()) -> Campaign:
    """Return the campaign that a file's content describes.

    Raises:
        CampaignError: A key or value is not valid; all are named.
    """
    needed = ("command", "result", "success")
    check_keys(path, content, (*_KEYS, *others), needed, CampaignError, empty=True)
    try:
        return _campaign(path, content)
    except ValueError as error:
        raise CampaignError(path, str(error)) from error


def _campaign(path: Path, content: dict[str, Any]) -> Campaign:
    if not isinstance(content["success"], dict):
        raise ValueError("'success' is a mapping of a result's keys")
    timeout, cpus, memory = (
        _positive(content, key, unit)
        for key, unit in (("timeout", "seconds"), ("cpus", "processors"), ("memory", "megabytes"))
    )
    measures = content.get("measures", [])
    if not isinstance(measures, list):
        raise ValueError("'measures' is a list of a result's keys")
    command = tuple(shlex.split(str(content["command"])))
    if not any(FOLDER in word for word in command):
        raise ValueError(f"'command' says nowhere where its results go; write {FOLDER} for it")
    factors, compare = factors_of(content.get("factors", {})), str(content.get("compare", ""))
    if compare and compare not in factors:
        raise ValueError(f"'compare' names no factor: '{compare}'; {nearest(compare, factors)}")
    return Campaign(
        path.stem,
        command,
        str(content["result"]),
        factors,
        content["success"],
        tuple(map(str, measures)),
        timeout,
        compare,
        cpus,
        memory,
    )


def _positive(content: dict[str, Any], key: str, unit: str) -> float:
    value = content.get(key)
    if value is not None and (not isinstance(value, int | float) or not value > 0):
        raise ValueError(f"'{key}' is a number of {unit} above 0")
    return float(getattr(Campaign, key) if value is None else value)


def factors_of(given: Any) -> dict[str, tuple[Level, ...]]:
    """Return factors by name from what a file holds.

    Raises:
        ValueError: It is no mapping, or a factor's levels are not valid.
    """
    if not isinstance(given, dict):
        raise ValueError("'factors' is a mapping of names to levels")
    return {str(name): _levels(str(name), values) for name, values in given.items()}


def _levels(name: str, values: Any) -> tuple[Level, ...]:
    if isinstance(values, dict) and set(values) == _RANGE:
        first, count = values["first"], values["count"]
        if not isinstance(first, int) or not isinstance(count, int) or count < 1:
            raise ValueError(f"factor '{name}': 'first' and 'count' are whole numbers")
        values = list(range(first, first + min(count, _RUNS_MAX + 1)))
    if isinstance(values, list) and values and all(isinstance(v, Scalar) for v in values):
        return tuple(Level(str(value), {name: value}) for value in values)
    if isinstance(values, dict) and values and all(isinstance(v, dict) for v in values.values()):
        return tuple(Level(str(label), options) for label, options in values.items())
    valid = "a list of values, {first, count}, or a set of options by name"
    raise ValueError(f"factor '{name}' is none of: {valid}")


def runs_of(campaign: Campaign) -> list[Run]:
    """Return every combination of levels, in the order of the file.

    Raises:
        ArjunaError: They are too many.
    """
    levels = campaign.factors.values()
    combinations = list(itertools.islice(itertools.product(*levels), _RUNS_MAX + 1))
    if len(combinations) > _RUNS_MAX:
        raise ArjunaError(f"campaign '{campaign.name}' has more than {_RUNS_MAX} runs")
    width = len(str(len(combinations) - 1))
    return [
        Run(
            "_".join([f"{number:0{width}}", *(UNFIT.sub("-", level.label) for level in chosen)]),
            {name: level.label for name, level in zip(campaign.factors, chosen, strict=True)},
            {key: value for level in chosen for key, value in level.options.items()},
        )
        for number, chosen in enumerate(combinations)
    ]
