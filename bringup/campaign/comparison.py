"""Two campaigns side by side, and whether they differ by more than chance."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bringup.campaign.outcome import Outcome, read_outcome
from bringup.campaign.plan import CampaignError
from bringup.campaign.statistics import measure_difference, success_difference

_SURE = 0.05


def outcomes_in(folder: Path) -> list[Outcome]:
    """Return the outcomes of a campaign's folder, in the order of its runs.

    Raises:
        CampaignError: It holds none.
    """
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    outcomes = [one for one in map(read_outcome, paths) if one is not None]
    if not outcomes:
        raise CampaignError(folder, "holds no runs; valid: the folder that a campaign wrote")
    return outcomes


def compared(first: Sequence[Outcome], second: Sequence[Outcome]) -> list[str]:
    """Return lines with what two campaigns found and how probable the difference is by chance."""
    counts = [(sum(one.success for one in each), len(each)) for each in (first, second)]
    chance = success_difference(*((good, total - good) for good, total in counts))
    lines = [_line("", ("first", "second"), "p")]
    lines.append(_line("success", [f"{a} of {b}" for a, b in counts], _verdict(chance)))
    keys = dict.fromkeys(key for one in (*first, *second) for key in one.figures)
    for key in keys:
        one, other = ([run.figures.get(key, np.nan) for run in each] for each in (first, second))
        medians = [f"{_median(each):.4g}" for each in (one, other)]
        lines.append(_line(key, medians, _verdict(measure_difference(one, other))))
    return lines


def _median(values: Sequence[float]) -> float:
    finite = np.array(values)[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else np.nan


def _verdict(chance: float) -> str:
    return f"{chance:.3f}{' differs' if chance < _SURE else ''}"


def _line(name: str, both: Sequence[str], chance: str) -> str:
    return f"{name:28}{both[0]:>14}{both[1]:>14}  {chance}"
