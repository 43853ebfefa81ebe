"""A tuning's file: a campaign, the ranges of parameters searched, and the figure it betters."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.config import check
from arjuna_core.errors import ConfigError, nearest
from arjuna_core.files.shipped import found_or_shipped
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.files.yaml_file import read_yaml
from arjuna_core.param import ParamInfo
from bringup.campaign.plan import FOLDER, Campaign, CampaignError, Level, campaign_of, factors_of
from bringup.parameters.checking import over_shipped
from bringup.parameters.files import for_node
from bringup.parameters.listing import described
from bringup.stack import all_nodes

Known = Mapping[str, Mapping[str, tuple[Any, ParamInfo]]]
"""The value that every parameter has now and what is known of it, by node and name."""
Value = float | int | bool | str
_RANGE = {"low", "high", "log"}
_FORMS = "valid: {low, high}, {low, high, log: true} or a list of values"


@dataclass(frozen=True)
class Dimension:
    """A parameter that is searched, in a range or among some values.

    Attributes:
        low: Least value to try; NaN for choices.
        high: Greatest value to try; NaN for choices.
        log: Whether factors count, not differences.
    """

    node: str
    key: str
    now: Value
    unit: str
    low: float = float("nan")
    high: float = float("nan")
    log: bool = False
    choices: tuple[Value, ...] = ()

    @property
    def name(self) -> str:
        """The name in the study and in tables."""
        return f"{self.node}: {self.key}"

    @property
    def whole(self) -> bool:
        """True where only whole numbers are valid."""
        return type(self.now) is int


def known_parameters(paths: Sequence[Path]) -> Known:
    """Return every parameter's value under some files, and what is known of it, by node.

    Raises:
        ArjunaError: A file cannot be used.
    """
    values = over_shipped(paths)
    return {
        spec.name: {
            one.key: (one.value, one.info)
            for one in described(spec.config, for_node(values, spec.name))
        }
        for spec in all_nodes()
    }


def dimensions_of(space: Any, known: Known) -> tuple[tuple[Dimension, ...], list[str]]:
    """Return a search space's dimensions, and everything that is wrong with it."""
    if not isinstance(space, dict) or not all(isinstance(v, dict) for v in space.values()):
        return (), ["'parameters' maps nodes to parameters, and these to ranges"]
    found: list[Dimension] = []
    problems: list[str] = []
    for node, ranges in space.items():
        if node not in known:
            problems.append(f"no node '{node}'; {nearest(str(node), known)}")
            continue
        for key, given in ranges.items():
            try:
                found.append(_dimension(str(node), str(key), given, known[node]))
            except ConfigError as error:
                problems += [f"{node}: {problem}" for problem in error.problems]
    if not found and not problems:
        problems.append("'parameters' names none")
    return tuple(found), problems


def _dimension(
    node: str, key: str, given: Any, known: Mapping[str, tuple[Any, ParamInfo]]
) -> Dimension:
    """Return a dimension."""
    if key not in known:
        raise ConfigError(f"unknown parameter '{key}'; {nearest(key, known)}")
    now, info = known[key]
    if not isinstance(now, Value):
        raise ConfigError(f"'{key}' is {now!r} now: no number, truth or word to begin from")
    if isinstance(given, list):
        for value in given:
            check(key, value, type(now), info)
        if now not in given:
            raise ConfigError(f"'{key}' is {now!r} now, which its values leave out: list it too")
        return Dimension(node, key, now, info.unit, choices=tuple(given))
    if not isinstance(given, dict) or not {"low", "high"} <= set(given) <= _RANGE:
        raise ConfigError(f"'{key}' is no range; {_FORMS}")
    if isinstance(now, bool | str):
        raise ConfigError(f"'{key}' is {now!r}: list its values in place of a range")
    low, high = (check(key, given[end], type(now), info) for end in ("low", "high"))
    log = bool(given.get("log", False))
    if not low < high or (log and low <= 0):
        raise ConfigError(f"'{key}': low lies below high{', and above 0 for log' if log else ''}")
    if not low <= now <= high:
        raise ConfigError(f"'{key}' is {now} now, outside {low} to {high}: widen the range")
    return Dimension(node, key, now, info.unit, float(low), float(high), log)


_KEYS = ("parameters", "params", "minimize", "maximize", "trials", "confirm")
PARAMETERS = "parameters.yaml"
"""A trial's parameter file, in its folder."""


@dataclass(frozen=True)
class Tuning:
    """A search for better parameters.

    Attributes:
        measure: The figure that is bettered: a key of a run's result.
        params: Parameter files that every trial begins from.
        confirm: Factors of the runs by which the winner is compared at last; none if empty.
    """

    campaign: Campaign
    dimensions: tuple[Dimension, ...]
    measure: str
    maximize: bool
    params: tuple[str, ...] = ()
    confirm: Mapping[str, tuple[Level, ...]] = dataclasses.field(default_factory=dict)
    trials: int = 40

    @property
    def identity(self) -> str:
        """All that must be the same for trials to be of one study, as JSON."""
        content = dataclasses.asdict(self)
        del content["trials"], content["confirm"]
        return json.dumps(content, sort_keys=True)

    @property
    def now(self) -> dict[str, Value]:
        """The values that the parameters have now, by dimension."""
        return {one.name: one.now for one in self.dimensions}

    def parameter_text(self, values: Mapping[str, Value]) -> str:
        """Return the parameter file of some values, by dimension."""
        nodes: dict[str, Any] = {}
        for one in self.dimensions:
            node = nodes.setdefault(one.node, {"ros__parameters": {}})
            node["ros__parameters"][one.key] = values[one.name]
        return yaml.safe_dump(nodes, sort_keys=False)

    def trial(self, values: Mapping[str, Value], folder: Path) -> Campaign:
        """Return the campaign that tries some values; write its parameter file into a folder.

        Raises:
            OSError: It cannot be written.
        """
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / PARAMETERS, self.parameter_text(values).encode())
        every = (*self.params, f"{FOLDER}/../{PARAMETERS}")  # a run's folder lies below the trial's
        files = [word for file in every for word in ("--params", file)]
        return dataclasses.replace(self.campaign, command=(*self.campaign.command, *files))


def load_tuning(path: Path, known: Callable[[Sequence[Path]], Known]) -> Tuning:
    """Return the tuning that a YAML file describes: a campaign's keys, and these.

    Raises:
        CampaignError: The file cannot be read, or a key or value is not valid; all are named.
    """
    path = Path(found_or_shipped(str(path)))
    content = read_yaml(path, CampaignError)
    campaign = campaign_of(path, content, _KEYS)
    problems = []
    aims = [key for key in ("minimize", "maximize") if key in content]
    if len(aims) != 1 or not isinstance(content[aims[0]], str):
        problems.append("name one figure of the result, under 'minimize' or under 'maximize'")
    trials = content.get("trials", Tuning.trials)
    if type(trials) is not int or trials < 1:
        problems.append("'trials' is a whole number above 0")
    files = content.get("params", [])
    if not isinstance(files, list) or not all(isinstance(file, str) for file in files):
        raise CampaignError(path, "'params' is a list of parameter files")
    dimensions, wrong = dimensions_of(
        content.get("parameters"), known([Path(found_or_shipped(f)) for f in files])
    )
    confirm = _confirm(path, content.get("confirm", {}), campaign)
    if problems + wrong:
        raise CampaignError(path, "\n".join(problems + wrong))
    maximize = aims[0] == "maximize"
    return Tuning(campaign, dimensions, content[aims[0]], maximize, tuple(files), confirm, trials)


def _confirm(path: Path, given: Any, campaign: Campaign) -> dict[str, tuple[Level, ...]]:
    """Return the factors of the last comparison: the campaign's, some with other levels."""
    try:
        levels = factors_of(given)
    except ValueError as error:
        raise CampaignError(path, f"'confirm': {error}") from error
    return {**campaign.factors, **levels} if levels else {}
