"""One picture of a tuning: its progress, which parameters mattered, and each one's trials."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arjuna_core.files.whole_file import write_atomically
from bringup.tuning.plan import Dimension, Tuning
from bringup.tuning.study import Study, Tried

mpl.use("Agg")
PICTURE = "tuning.png"
_GOOD, _BAD, _NOW, _BEST = "tab:blue", "tab:red", "black", "tab:orange"


def write_picture(folder: Path, tuning: Tuning, study: Study, columns: int = 3) -> None:
    """Draw a study of one trial or more.

    Raises:
        OSError: It cannot be written.
    """
    tried, best, shares = study.tried(), study.ranked()[0], study.importance()
    order = list(shares) or [one.name for one in tuning.dimensions]
    dimensions = sorted(tuning.dimensions, key=lambda one: order.index(one.name))
    rows = math.ceil(len(dimensions) / columns)
    figure = Figure(figsize=(11.0, 3.2 + 2.4 * rows), layout="constrained")
    figure.suptitle(f"{tuning.campaign.name}: {len(tried)} trials, the best is {best.number + 1}")
    top, below = figure.subfigures(2, 1, height_ratios=(3.0, 2.4 * rows), squeeze=False).flat
    history, importance = top.subplots(1, 2)
    _draw_history(history, tuning, tried)
    _draw_importance(importance, shares)
    for axes, dimension in zip(
        below.subplots(rows, columns, squeeze=False).flat, dimensions, strict=False
    ):
        _draw_slice(axes, dimension, tuning.measure, tried, best)
    for axes in below.axes[len(dimensions) :]:
        axes.set_visible(False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=90)
    write_atomically(folder / PICTURE, buffer.getvalue())


def _draw_history(axes: Axes, tuning: Tuning, tried: Sequence[Tried]) -> None:
    better = np.maximum if tuning.maximize else np.minimum
    worst = -np.inf if tuning.maximize else np.inf
    held = [worst if one.failed else one.figure for one in tried]
    _scatter(axes, [one.number + 1 for one in tried], tried)
    axes.step(
        range(1, len(tried) + 1), better.accumulate(held), where="post", color=_BEST, label="best"
    )
    axes.axhline(tried[0].figure, color=_NOW, lw=0.8, ls=":", label="now")
    axes.set(xlabel="trial", ylabel=tuning.measure, title="how it went (red: a run failed)")
    axes.legend(fontsize="small")


def _draw_importance(axes: Axes, shares: Mapping[str, float]) -> None:
    axes.set(title="what mattered", xlabel="share in telling the best quarter from the rest")
    if not shares:
        axes.text(0.5, 0.5, "too few trials to tell", ha="center", transform=axes.transAxes)
        return
    names = [name.rpartition(" ")[2] for name in shares]
    axes.barh(range(len(shares)), list(shares.values()), color=_GOOD)
    axes.set_yticks(range(len(shares)), names, fontsize="small")
    axes.invert_yaxis()


def _draw_slice(
    axes: Axes, dimension: Dimension, measure: str, tried: Sequence[Tried], best: Tried
) -> None:
    values = [one.values[dimension.name] for one in tried]
    positions = [float(dimension.choices.index(v) if dimension.choices else v) for v in values]
    _scatter(axes, positions, tried)
    axes.plot(positions[best.number], best.figure, "*", color=_BEST, ms=14, zorder=3)
    axes.plot(positions[0], tried[0].figure, "s", mfc="none", color=_NOW, ms=8, zorder=3)
    if dimension.choices:
        axes.set_xticks(range(len(dimension.choices)), map(str, dimension.choices))
    if dimension.log:
        axes.set_xscale("log")
    unit = f" [{dimension.unit}]" if dimension.unit else ""
    axes.set_xlabel(f"{dimension.key}{unit}", fontsize="small")
    axes.set_title(dimension.node, fontsize="small")
    axes.set_ylabel(measure, fontsize="small")


def _scatter(axes: Axes, positions: Sequence[float], tried: Sequence[Tried]) -> None:
    shown = [(x, one) for x, one in zip(positions, tried, strict=True) if math.isfinite(one.figure)]
    axes.scatter(
        [x for x, _ in shown],
        [one.figure for _, one in shown],
        c=[_BAD if one.failed else _GOOD for _, one in shown],
        s=18,
        alpha=0.7,
    )
