"""A tuning's file: a campaign, the parameters that it searches, and the figure that it betters."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from arjuna_core.files.shipped import found_or_shipped
from arjuna_core.files.whole_file import write_atomically
from arjuna_core.files.yaml_file import read_yaml
from bringup.campaign.plan import FOLDER, Campaign, CampaignError, Level, campaign_of, factors_of
from bringup.tuning.space import Dimension, Known, Value, dimensions_of

_KEYS = ("parameters", "params", "minimize", "maximize", "trials", "confirm")
PARAMETERS = "parameters.yaml"
"""A trial's parameter file, in its folder."""


@dataclass(frozen=True)
class Tuning:
    """A search for better parameters.

    Attributes:
        campaign: What a trial runs, with its parameters.
        measure: The figure that is bettered: a key of a run's result.
        maximize: Whether more of it is better.
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
